// SPDX-License-Identifier: MIT OR Apache-2.0
//! Position routes and charts on the device: their printed text as a compute shader, against the
//! exact offsets and angles, the bounds and the emulation.

use crate::common::evaluated;
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_gpu::{GpuOptions, Kernel, open_for_test};
use terrafill_texture::{
    Arithmetic, Chart, CoordinateRoute, DepthFormat, DepthMapping, DepthStorage, MapExtent,
    MapRegion, PerspectiveView, PositionRoute, Program, Sample,
};

/// Evaluates positions by a text of a route.
fn position_kernel(wgsl: &str) -> Kernel<'_> {
    Kernel {
        name: "position",
        wgsl,
        constants: Some("PositionConstants"),
        call: "vec4f(fragment_offset(x.xy, x.z, constants), 0.0)",
        table: None,
    }
}

/// Evaluates angles by a text of a chart.
fn chart_kernel(wgsl: &str) -> Kernel<'_> {
    Kernel {
        name: "chart",
        wgsl,
        constants: Some("RouteConstants"),
        call: "vec4f(route_angles(x.xyz, constants), 0.0, 0.0)",
        table: None,
    }
}

/// How many results equal the emulation with `fma` rounded once or twice bit by bit.
fn equal_to_emulation(
    program: &Program,
    constants: &[[f32; 4]],
    inputs: &[[f32; 3]],
    results: &[[f32; 4]],
) -> usize {
    inputs
        .iter()
        .zip(results)
        .filter(|(input, result)| {
            [Arithmetic::Fused, Arithmetic::Separate]
                .into_iter()
                .map(|arithmetic| program.emulate_all(constants, **input, arithmetic))
                .any(|all| {
                    all.iter()
                        .zip(result.iter())
                        .all(|(a, b)| (a - b).abs() <= 0.0)
                })
        })
        .count()
}

/// A kilometre at 20° E, 45° N, seen aslant from `distance_m`; 60° over 1920 × 1080 pixels.
fn region_and_view(distance_m: f64, depth: DepthFormat) -> (MapRegion, PerspectiveView) {
    let extent = MapExtent::from_degrees(19.995, 44.995, 20.005, 45.005);
    let body = Ellipsoid::WGS84;
    let region = MapRegion::new(body, extent, (0.0, 0.0)).expect("a region");
    let target = body.geodetic_to_ecef(Geodetic::from_degrees(20.001, 45.002, 0.0));
    let up = body.geodetic_surface_normal(20_f64.to_radians(), 45_f64.to_radians());
    let east = glam::DVec3::Z.cross(up).normalize();
    let north = up.cross(east);
    let backward = (up * 0.8 - north * 0.5 + east * 0.33).normalize();
    let right = north.cross(backward).normalize();
    let focal_y = 1.0 / 30_f64.to_radians().tan();
    let view = PerspectiveView {
        eye_ecef: target + backward * distance_m,
        right,
        up: backward.cross(right),
        backward,
        focal_x: focal_y * 1080.0 / 1920.0,
        focal_y,
        size: [1920, 1080],
        depth,
    };
    (region, view)
}

/// Pixel centres all over the screen.
fn pixels() -> impl Iterator<Item = [f32; 2]> {
    (0..40_u16)
        .flat_map(|i| (0..40_u16).map(move |j| [f32::from(i * 49) + 0.5, f32::from(j * 27) + 0.5]))
}

#[test]
fn positions_on_the_device_are_within_their_bound() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let endless = f64::INFINITY;
    let formats = [
        (DepthMapping::Reversed, DepthStorage::Float32, endless),
        (DepthMapping::Reversed, DepthStorage::Float32, 1e8),
        (DepthMapping::Standard, DepthStorage::Float32, endless),
        (DepthMapping::Standard, DepthStorage::Unorm24, 1e8),
        (DepthMapping::Logarithmic, DepthStorage::Float32, 1e8),
    ];
    for (mapping, storage, far_m) in formats {
        for (near_m, distance_m) in [(0.1, 20.0), (1.0, 1e3), (1.0, 1e6)] {
            let format = DepthFormat::new(mapping, storage, near_m, far_m).expect("a format");
            let (region, view) = region_and_view(distance_m, format);
            let depth = format.stored(distance_m);
            let inputs: Vec<[f32; 3]> = pixels().map(|[x, y]| [x, y, depth]).collect();
            for route in PositionRoute::ALL {
                let constants = route.constants(&view, &region);
                let text = route.wgsl(&format);
                let results = evaluated(&gpu, &position_kernel(&text), &constants, &inputs);
                let error = |result: &[f32; 4], input: &[f32; 3]| {
                    let pixel = [f64::from(input[0]), f64::from(input[1])];
                    let exact = view.exact_offset_m(&region, pixel, distance_m);
                    let [x, y, z, _] = result.map(f64::from);
                    (glam::DVec3::new(x, y, z) - exact).length()
                };
                let worst = results
                    .iter()
                    .zip(&inputs)
                    .map(|(result, input)| error(result, input))
                    .fold(0.0, f64::max);
                let residual = route.residual(&view, &region, distance_m);
                let program = route.program(&format);
                let equal = equal_to_emulation(&program, &constants, &inputs, &results);
                let case = format!("{} {} {distance_m} m", route.name(), format.name());
                eprintln!(
                    "{case}: device {worst:.3e} m, bound {:.3e}, emulation {:.3e}; {equal} of {} equal",
                    residual.max_m,
                    residual.measured_max_m,
                    inputs.len()
                );
                assert!(
                    worst.is_finite() && worst <= 1.02 * residual.max_m,
                    "{case}: {worst}"
                );
            }
        }
    }
}

#[test]
fn charts_on_the_device_are_within_their_residual() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let body = Ellipsoid::WGS84;
    let square = |latitude: f64, size: f64| {
        let half = 0.5 * size;
        let (south, north) = (latitude - half, latitude + half);
        let extent = MapExtent::from_degrees(180.0 - half, south, 180.0 + half, north);
        MapRegion::new(body, extent, (-11e3, 9e3)).expect("a region")
    };
    let cap = MapExtent::from_degrees(-180.0, 70.0, 180.0, 90.0);
    let cap = MapRegion::anchored(body, cap, (-11e3, 9e3)).expect("a region");
    for route in Chart::all().filter(|c| !matches!(c, Chart::Cube(_))) {
        let regions = match route {
            Chart::Azimuthal(_) => vec![cap],
            _ => vec![square(45.0, 0.01), square(-70.0, 2.0), square(0.0, 10.0)],
        };
        let route = CoordinateRoute::Chart(route);
        for region in regions {
            let samples: Vec<Sample> = region.samples(2000).collect();
            let inputs: Vec<[f32; 3]> = samples.iter().map(|s| s.offset_m).collect();
            let constants = route.constants(&region);
            let text = route.wgsl();
            let results = evaluated(&gpu, &chart_kernel(&text), &constants, &inputs);
            let worst = worst_angle(&samples, &results);
            let residual = route.residual(&region);
            let equal = equal_to_emulation(&route.program(), &constants, &inputs, &results);
            let name = route.name();
            eprintln!(
                "{name}: device {worst:.3e} rad, residual {:.3e}; {equal} of {} equal",
                residual.max_rad,
                inputs.len()
            );
            assert!(
                worst <= 1.02 * residual.max_rad,
                "{name}: {worst} {residual:?}"
            );
        }
    }
}

/// Largest error of an angle, longitude the short way round and not on the axis.
fn worst_angle(samples: &[Sample], results: &[[f32; 4]]) -> f64 {
    let turn = std::f64::consts::TAU;
    let mut worst = 0.0_f64;
    for (sample, result) in samples.iter().zip(results) {
        let pairs = result.iter().zip(sample.angles_rad);
        for (got, exact) in pairs.skip(usize::from(sample.on_axis)) {
            let off = (f64::from(*got) - exact).abs();
            // A maximum would drop NaN.
            let off = if off.is_nan() { f64::INFINITY } else { off };
            worst = worst.max(off.min((turn - off).abs()));
        }
    }
    worst
}

#[test]
fn a_wrong_text_is_noticed_on_the_device() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let extent = MapExtent::from_degrees(179.0, 44.0, 181.0, 46.0);
    let region = MapRegion::new(Ellipsoid::WGS84, extent, (0.0, 0.0)).expect("a region");
    let route = CoordinateRoute::parse("gnomonic-4").expect("a chart");
    let samples: Vec<Sample> = region.samples(200).collect();
    let inputs: Vec<[f32; 3]> = samples.iter().map(|s| s.offset_m).collect();
    let constants = route.constants(&region);
    let text = route.wgsl();
    let bound = route.residual(&region).max_rad;
    let worst =
        |kernel: &Kernel<'_>| worst_angle(&samples, &evaluated(&gpu, kernel, &constants, &inputs));
    assert!(worst(&chart_kernel(&text)) <= 1.02 * bound);
    for (from, to) in [
        ("constants.c1.x", "constants.c1.y"),
        ("constants.c2.x", "constants.c2.z"),
        ("d.y", "d.z"),
    ] {
        assert!(text.contains(from), "{from}");
        let wrong = text.replace(from, to);
        assert!(worst(&chart_kernel(&wrong)) > 1.02 * bound, "{from}");
    }
    let swapped = Kernel {
        call: "vec4f(route_angles(x.yxz, constants), 0.0, 0.0)",
        ..chart_kernel(&text)
    };
    assert!(worst(&swapped) > 1.02 * bound);
}
