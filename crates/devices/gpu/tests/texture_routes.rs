// SPDX-License-Identifier: MIT OR Apache-2.0
//! Coordinate routes on the device: the text that is printed from a route's steps, run as a compute
//! shader over a region's places, against the exact map, the residual and the emulation.
//!
//! Here a driver's own `atan2` shows, which no emulation on the CPU can know.

use crate::common::evaluated;
use std::sync::Arc;
use terrafill_core::Ellipsoid;
use terrafill_gpu::{Gpu, GpuOptions, Kernel, RouteTexels, open_for_test};
use terrafill_texture::{Arithmetic, CoordinateRoute, MapExtent, MapRegion, Sample};

fn route(name: &str) -> CoordinateRoute {
    CoordinateRoute::parse(name).unwrap_or_else(|| panic!("{name}: no such route"))
}

fn region(latitude: f64, size: f64) -> MapRegion {
    let (south, north) = (latitude - size / 2.0, latitude + size / 2.0);
    let extent = MapExtent::from_degrees(170.0, south.max(-90.0), 170.0 + size, north.min(90.0));
    MapRegion::new(Ellipsoid::WGS84, extent, (-11e3, 9e3)).expect("a region")
}

/// The text of a route, its table declared.
fn shader_text(route: &CoordinateRoute) -> String {
    let program = route.program();
    RouteTexels::declarations(&program, 1) + &program.wgsl()
}

/// What the device makes of `text` for these offsets.
fn run(
    gpu: &Arc<Gpu>,
    route: &CoordinateRoute,
    text: &str,
    constants: &[[f32; 4]],
    offsets: &[[f32; 3]],
) -> Vec<[f32; 2]> {
    let table = RouteTexels::of(&route.program());
    let kernel = Kernel {
        name: "route",
        wgsl: text,
        constants: Some("RouteConstants"),
        call: "vec4f(route_angles(x.xyz, constants), 0.0, 0.0)",
        table: table.as_ref(),
    };
    let answers = evaluated(gpu, &kernel, constants, offsets).into_iter();
    answers.map(|[x, y, ..]| [x, y]).collect()
}

/// Largest differences of angles, longitude the short way round: from the exact ones, and from the
/// nearer of the two emulations; and how many places equal an emulation bit by bit.
struct RouteErrors {
    from_exact_rad: f64,
    from_emulation_rad: f64,
    equal: usize,
    places: usize,
    non_finite: usize,
}

fn compare(
    route: &CoordinateRoute,
    constants: &[[f32; 4]],
    samples: &[Sample],
    angles: &[[f32; 2]],
) -> RouteErrors {
    let program = route.program();
    let mut found = RouteErrors {
        from_exact_rad: 0.0,
        from_emulation_rad: 0.0,
        equal: 0,
        places: samples.len(),
        non_finite: 0,
    };
    let turn = std::f64::consts::TAU;
    let short = |difference: f64| difference.abs().min((turn - difference.abs()).abs());
    for (sample, angle) in samples.iter().zip(angles) {
        if !angle.iter().all(|a| a.is_finite()) {
            found.non_finite += 1;
            continue;
        }
        let emulated = [Arithmetic::Fused, Arithmetic::Separate]
            .map(|arithmetic| program.emulate(constants, sample.offset_m, arithmetic));
        found.equal += usize::from(emulated.contains(angle));
        for axis in usize::from(sample.on_axis)..2 {
            let value = f64::from(angle[axis]);
            let off = short(value - sample.angles_rad[axis]);
            found.from_exact_rad = found.from_exact_rad.max(off);
            let near = emulated
                .map(|e| short(value - f64::from(e[axis])))
                .into_iter()
                .fold(f64::INFINITY, f64::min);
            found.from_emulation_rad = found.from_emulation_rad.max(near);
        }
    }
    found
}

/// Kinds whose steps leave a device nothing but how `fma`, divisions and roots are rounded.
const CALCULATED: [&str; 14] = [
    "odd-3",
    "odd-7",
    "odd-11+parametric",
    "odd-15+bowring-2",
    "odd-pin-9",
    "rat-1-1",
    "rat-2-2",
    "dense-5",
    "recentred-odd-15",
    "recentred-odd-7+parametric",
    "recentred-rat-3-3+bowring-2",
    "near-odd-15",
    "near-rat-3-3",
    "near-dense-8",
];

/// Kinds that read a texture or call the device's own functions.
const DEVICES_OWN: [&str; 8] = [
    "atan2-native+geocentric",
    "atan2-native",
    "recentred-atan2-native",
    "lut-64-r8-nearest",
    "lut-256-r16f-linear",
    "lut-256-r8-linear",
    "lut-1024-r32f-linear-exact",
    "near-lut-4096-r32f-nearest",
];

/// Charts, where the region is small enough for them.
const CHARTS: [&str; 4] = ["planes", "gnomonic-1", "gnomonic-3", "gnomonic-5"];

/// A region's places, as samples and as a device takes them.
fn places(home: &MapRegion, count: u32) -> (Vec<Sample>, Vec<[f32; 3]>) {
    let samples: Vec<Sample> = home.samples(count).collect();
    let offsets = samples.iter().map(|s| s.offset_m).collect();
    (samples, offsets)
}

#[test]
fn every_kind_of_route_is_within_its_residual_on_the_device() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let mut checked = 0;
    for (latitude, size) in [(45.0, 1e-3), (45.0, 1.0), (0.0, 40.0), (-80.0, 300.0)] {
        let home = region(latitude, size);
        let (samples, offsets) = places(&home, 2048);
        let charts: &[&str] = if size > 1.0 { &[] } else { &CHARTS };
        for name in CALCULATED.iter().chain(&DEVICES_OWN).chain(charts) {
            if name.starts_with("near") && size > 90.0 {
                continue;
            }
            let route = route(name);
            let constants = route.constants(&home);
            let angles = run(&gpu, &route, &shader_text(&route), &constants, &offsets);
            let found = compare(&route, &constants, &samples, &angles);
            let residual = route.residual(&home).max_rad;
            let at = format!("{name} at {latitude}°, {size}°");
            assert_eq!(found.non_finite, 0, "{at}");
            let device = found.from_exact_rad;
            // These are other places than the residual's, whose offsets round to f32 otherwise.
            let allowed = residual * (1.0 + 1e-6);
            assert!(device <= allowed, "{at}: {device:e}, residual {residual:e}");
            // A software driver calculates with the CPU's own f32: nearly every place is the same bit
            // by bit, the rest lie where one sum is fused and another is not.
            if gpu.facts.device_type == "cpu" && CALCULATED.contains(name) {
                let (equal, places) = (found.equal, found.places);
                assert!(equal * 10 > places * 9, "{at}: {equal} of {places} equal");
            }
            eprintln!(
                "{at}: device {device:.2e} rad, residual {residual:.2e}, from emulation {:.2e}",
                found.from_emulation_rad
            );
            checked += 1;
        }
    }
    assert!(checked > 80, "{checked}");
}

#[test]
fn a_wrong_shader_leaves_its_residual_on_the_device() {
    // Negative control: the same comparison of texts that are not the route's.
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    // Wide enough that the octants are all in use.
    let home = region(0.0, 120.0);
    let (samples, offsets) = places(&home, 1024);
    let route = route("recentred-odd-7");
    let constants = route.constants(&home);
    let residual = route.residual(&home).max_rad;
    let right = shader_text(&route);
    let off = |text: &str| {
        let angles = run(&gpu, &route, text, &constants, &offsets);
        compare(&route, &constants, &samples, &angles)
    };
    assert!(off(&right).from_exact_rad <= residual);
    for (part, mutant) in [
        ("0.9992138f", "0.9982138f"),
        ("-0.32117498f", "-0.3221498f"),
        ("1.5707964f", "1.5717964f"),
        ("return vec2f(", "return 1.001 * vec2f("),
        ("max(", "min("),
        ("constants.c0.y", "constants.c0.z"),
    ] {
        assert!(right.contains(part), "{part} in {right}");
        let found = off(&right.replace(part, mutant));
        let noticed = found.non_finite > 0 || found.from_exact_rad > residual;
        assert!(noticed, "{part} → {mutant}: {}", found.from_exact_rad);
    }
}

#[test]
fn special_places_are_finite_on_the_device() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let home = region(45.0, 1.0);
    let anchor = home.anchor_meridian().as_vec3();
    let pole = 6_356_752.5 - anchor.z;
    let offsets = [
        [0.0; 3],
        [-0.0; 3],
        [1e-40, -1e-40, 1e-42],
        [-anchor.x, 0.0, -anchor.z],
        [-anchor.x, -0.0, -anchor.z],
        [-anchor.x, 0.0, pole],
        [-anchor.x, 0.0, -2.0 * anchor.z - pole],
        [-2.0 * anchor.x, 0.0, 0.0],
        [-2.0 * anchor.x, -0.0, 0.0],
        [-2.0 * anchor.x, 0.0, -2.0 * anchor.z],
        [0.0, 3e7, 3e7],
    ];
    for name in CALCULATED.iter().chain(&DEVICES_OWN) {
        // The near form promises nothing 45° from the anchor and further.
        if name.starts_with("near") {
            continue;
        }
        let route = route(name);
        let constants = route.constants(&home);
        let angles = run(&gpu, &route, &shader_text(&route), &constants, &offsets);
        for (offset, angle) in offsets.iter().zip(&angles) {
            let sane = angle.iter().all(|a| a.abs() < 4.0);
            assert!(sane, "{name} at {offset:?}: {angle:?}");
        }
        // At the centre x and y are 0: a guarded route's longitude is 0, the device's own whatever.
        let centre = angles[3][0];
        if name.contains("native") {
            eprintln!("{name}: longitude {centre} at the body's centre");
        } else {
            assert!(centre.abs() < 1e-2, "{name}: {centre}");
        }
    }
}
