// SPDX-License-Identifier: MIT OR Apache-2.0
//! Position routes and vertex formats: errors against other computations, against their own
//! formula, and mutants that must be noticed.

use crate::naga_says::is_valid;
use glam::DVec3;
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_texture::{
    Arithmetic, DepthFormat, DepthMapping, DepthStorage, MapExtent, MapRegion, PerspectiveView,
    PositionRoute, VertexFormat,
};

/// A region of about 1 km at a place, and a point on the ground some 600 m from its anchor.
fn region_and_target(place: u32) -> (MapRegion, DVec3) {
    let (lon, lat) = (
        -170.0 + 13.7 * f64::from(place),
        -80.0 + 6.6 * f64::from(place),
    );
    let half = 0.005;
    let extent = MapExtent::from_degrees(lon - half, lat - half, lon + half, lat + half);
    let region = MapRegion::new(Ellipsoid::WGS84, extent, (0.0, 0.0)).expect("a region");
    let target = Geodetic::from_degrees(lon, lat + 0.0054, 0.0);
    (region, Ellipsoid::WGS84.geodetic_to_ecef(target))
}

/// Places on the body over which errors are taken: what an f32 radius loses depends on the place.
const PLACES: u32 = 25;

/// An eye `distance_m` from the target, looking at it aslant; 60° over 1920 × 1080 pixels.
fn view(target: DVec3, distance_m: f64, depth: DepthFormat) -> PerspectiveView {
    let up = target.normalize();
    let east = DVec3::Z.cross(up).normalize();
    let north = up.cross(east);
    let backward = (up * 0.8 - north * 0.5 + east * 0.33).normalize();
    let right = north.cross(backward).normalize();
    let focal_y = 1.0 / 30_f64.to_radians().tan();
    PerspectiveView {
        eye_ecef: target + backward * distance_m,
        right,
        up: backward.cross(right),
        backward,
        focal_x: focal_y * 1080.0 / 1920.0,
        focal_y,
        size: [1920, 1080],
        depth,
    }
}

fn format(mapping: DepthMapping, storage: DepthStorage, near_m: f64, far_m: f64) -> DepthFormat {
    DepthFormat::new(mapping, storage, near_m, far_m).expect("a depth format")
}

fn endless(mapping: DepthMapping, near_m: f64) -> DepthFormat {
    format(mapping, DepthStorage::Float32, near_m, f64::INFINITY)
}

/// Every mapping, storage and kind of far plane there is.
fn all_formats(near_m: f64) -> Vec<DepthFormat> {
    let mut all = Vec::new();
    for storage in [DepthStorage::Unorm24, DepthStorage::Float32] {
        for far_m in [1e8, f64::INFINITY] {
            all.push(format(DepthMapping::Standard, storage, near_m, far_m));
            all.push(format(DepthMapping::Reversed, storage, near_m, far_m));
        }
        all.push(format(DepthMapping::Logarithmic, storage, near_m, 1e8));
    }
    all
}

/// Median and maximum over places and pixels of what the emulation is off, metres.
///
/// - `absolute`: of the position about the body's centre, before the anchor is subtracted
fn emulated_errors(
    route: PositionRoute,
    depth: DepthFormat,
    distance_m: f64,
    arithmetic: Arithmetic,
    absolute: bool,
) -> (f64, f64) {
    let program = route.program(&depth);
    let stored = depth.stored(distance_m);
    let mut errors = Vec::new();
    for place in 0..PLACES {
        let (region, target) = region_and_target(place);
        let view = view(target, distance_m, depth);
        let constants = route.constants(&view, &region);
        // What rounding the anchor moves; the routes that subtract it have it last.
        let anchor = constants[constants.len() - 1].map(f64::from);
        let moved = if absolute && route != PositionRoute::EyeRegion {
            DVec3::new(anchor[0], anchor[1], anchor[2]) - region.anchor_meridian()
        } else {
            DVec3::ZERO
        };
        for (column, row) in (0..9_u16).flat_map(|i| (0..9_u16).map(move |j| (i * 239, j * 134))) {
            let pixel = [f32::from(column) + 0.5, f32::from(row) + 0.5];
            let inputs = [pixel[0], pixel[1], stored];
            let got = program.emulate_all(&constants, inputs, arithmetic);
            let got = DVec3::from_array([0, 1, 2].map(|i| f64::from(got[i])));
            let exact = view.exact_offset_m(&region, pixel.map(f64::from), distance_m);
            errors.push((got + moved - exact).length());
        }
    }
    errors.sort_by(f64::total_cmp);
    (errors[errors.len() / 2], errors[errors.len() - 1])
}

#[test]
fn errors_of_routes_are_those_of_another_implementation() {
    use DepthMapping::{Reversed, Standard};
    // Median and maximum, metres, for inverse-ecef, eye-ecef and eye-region.
    let published = [
        (
            Reversed,
            0.1,
            20.0,
            [(0.31, 1.0), (0.18, 0.52), (4.4e-5, 1.6e-4)],
        ),
        (
            Reversed,
            1.0,
            1e6,
            [(0.30, 0.80), (0.22, 0.55), (0.049, 0.14)],
        ),
        (Reversed, 1.0, 3e7, [(1.6, 5.8), (1.5, 4.5), (1.5, 5.3)]),
        (
            Standard,
            0.1,
            20.0,
            [(49.0, 144.0), (0.18, 0.50), (7e-5, 2e-4)],
        ),
        (
            Standard,
            1.0,
            1e3,
            [(251.0, 795.0), (0.21, 0.51), (0.014, 0.038)],
        ),
        (
            Standard,
            1.0,
            1e6,
            [(2.9e5, 7e5), (9500.0, 3.8e4), (9500.0, 3.8e4)],
        ),
    ];
    for (mapping, near_m, distance_m, rows) in published {
        for (route, (median, max)) in PositionRoute::ALL.into_iter().zip(rows) {
            let depth = endless(mapping, near_m);
            // Without contraction, as array arithmetic on a CPU rounds.
            let separate = Arithmetic::Separate;
            let got = emulated_errors(route, depth, distance_m, separate, true);
            let name = route.name();
            for (got, want) in [(got.0, median), (got.1, max)] {
                let ratio = got / want;
                // The lowest is 0.47: standard depth at 20 m, where what is left is the rounding of
                // the offset, and the distance of the target from the anchor decides.
                assert!(
                    (0.45..2.0).contains(&ratio),
                    "{mapping:?} {near_m} {distance_m} {name}: {got} for {want}"
                );
            }
        }
    }
}

#[test]
fn the_default_is_within_a_tenth_of_a_millimetre_at_20_m_and_a_quarter_of_a_pixel_everywhere() {
    for (near_m, distance_m, allowed_m) in [(0.1, 20.0, 1e-4), (0.1, 1e3, 1e-3)] {
        let depth = endless(DepthMapping::Reversed, near_m);
        for place in 0..PLACES {
            let (region, _) = region_and_target(place);
            // The anchor itself in view; the far target of the table above is half a kilometre off.
            let view = view(region.anchor_ecef(), distance_m, depth);
            let residual = PositionRoute::EyeRegion.residual(&view, &region, distance_m);
            assert!(residual.max_m <= allowed_m, "{place}: {residual:?}");
        }
    }
    for distance_m in [20.0, 1e3, 1e6, 3e7] {
        let depth = endless(DepthMapping::Reversed, 0.1);
        let (region, target) = region_and_target(7);
        let view = view(target, distance_m, depth);
        let quarter = 0.25 * view.pixel_size_m(distance_m);
        let bound = PositionRoute::EyeRegion.residual(&view, &region, distance_m);
        assert!(bound.max_m <= quarter, "{distance_m}: {bound:?}");
        // Negative control: the 2007 way is not, close by.
        let published = PositionRoute::InverseEcef.residual(&view, &region, distance_m);
        assert_eq!(published.measured_max_m > quarter, distance_m < 1e4);
    }
}

#[test]
fn no_emulation_leaves_its_bound_and_no_bound_is_idle() {
    for format in all_formats(0.5) {
        for route in PositionRoute::ALL {
            let mut closest = 0.0_f64;
            for distance_m in [2.0, 20.0, 1e3, 1e5, 1e6] {
                for place in 0..PLACES / 5 {
                    let (region, target) = region_and_target(place * 5);
                    let view = view(target, distance_m, format);
                    let residual = route.residual(&view, &region, distance_m);
                    assert!(
                        residual.measured_max_m <= residual.max_m,
                        "{} {} {distance_m}: {residual:?}",
                        route.name(),
                        format.name()
                    );
                    if residual.max_m.is_finite() {
                        closest = closest.max(residual.measured_max_m / residual.max_m);
                    }
                }
            }
            // WGSL lets a division be off by 2.5 ULP and exp2 by up to 60; the emulation's are off by
            // half of one.
            let expected = match format.mapping() {
                DepthMapping::Logarithmic => 0.02,
                DepthMapping::Standard | DepthMapping::Reversed => 0.1,
            };
            let name = format.name();
            assert!(closest > expected, "{} {name}: {closest}", route.name());
        }
    }
}

#[test]
fn a_wrong_constant_or_depth_leaves_the_bound() {
    let depth = endless(DepthMapping::Reversed, 0.1);
    let (region, target) = region_and_target(3);
    let view = view(target, 500.0, depth);
    for route in PositionRoute::ALL {
        let program = route.program(&depth);
        let constants = route.constants(&view, &region);
        let bound_m = route.residual(&view, &region, 500.0).max_m;
        let pixel = [300.5_f32, 900.5];
        let exact = view.exact_offset_m(&region, pixel.map(f64::from), 500.0);
        let off = |constants: &[[f32; 4]], depth: f32| {
            let inputs = [pixel[0], pixel[1], depth];
            let got = program.emulate_all(constants, inputs, Arithmetic::Fused);
            (DVec3::from_array([0, 1, 2].map(|i| f64::from(got[i]))) - exact).length()
        };
        let stored = depth.stored(500.0);
        assert!(off(&constants, stored) <= bound_m, "{}", route.name());
        assert!(off(&constants, stored * 1.1) > bound_m, "{}", route.name());
        let mut mutants = 0;
        for slot in 0..constants.len() {
            for lane in 0..4 {
                let mut mutant = constants.clone();
                mutant[slot][lane] = mutant[slot][lane] * 1.05 + if slot > 1 { 100.0 } else { 0.0 };
                // Near over far and padding are not read by this format.
                let read = off(&mutant, stored) > bound_m;
                mutants += u32::from(read);
            }
        }
        // Screen 4, near 1, rows 12 and what follows; the inverse reads its near from the rows.
        let expected = match route {
            PositionRoute::InverseEcef => 2 + 12 + 2 + 3,
            PositionRoute::EyeEcef => 4 + 1 + 12 + 3,
            PositionRoute::EyeRegion => 4 + 1 + 12,
        };
        assert_eq!(mutants, expected, "{}", route.name());
    }
}

#[test]
fn errors_of_depth_are_those_of_another_implementation() {
    use DepthMapping::{Logarithmic, Reversed, Standard};
    use DepthStorage::{Float32, Unorm24};
    let far = f64::INFINITY;
    // Mapping, storage, near, far; then maxima in metres at 10 m, 1 km, 1,000 km and 30,000 km.
    let published = [
        (
            Standard,
            Float32,
            0.1,
            far,
            [3.0e-5, 0.30, 1.7e5, f64::INFINITY],
        ),
        (Standard, Float32, 1.0, far, [3.0e-6, 0.030, 1.8e4, 1.3e7]),
        (Standard, Float32, 10.0, far, [2e-9, 0.0030, 3000.0, 2.2e6]),
        (Standard, Unorm24, 10.0, far, [3e-7, 0.0030, 3000.0, 2.2e6]),
        (Reversed, Float32, 0.1, far, [4.7e-7, 5.9e-5, 0.058, 1.7]),
        (Logarithmic, Float32, 0.1, 1e8, [3.3e-6, 8e-4, 1.5, 49.0]),
    ];
    for (mapping, storage, near_m, far_m, row) in published {
        let format = format(mapping, storage, near_m, far_m);
        for (distance_m, want) in [10.0, 1e3, 1e6, 3e7].into_iter().zip(row) {
            let (mut got, mut bound) = (0.0_f64, 0.0_f64);
            for i in 0..2000_u16 {
                let distance_m = distance_m * (1.0 + 1e-5 * f64::from(i));
                let back = format.distance_m(f64::from(format.stored(distance_m)));
                got = got.max((back - distance_m).abs());
                bound = bound.max(format.residual_m(distance_m));
            }
            let name = format.name();
            assert!(got <= bound, "{name} {distance_m}: {got} > {bound}");
            // At 10 m in front of a near plane at 10 m depth is 0 and the error what one likes.
            let at_the_plane = storage == Float32 && near_m >= distance_m && mapping == Standard;
            let ratio = got / want;
            assert!(
                (0.5..2.0).contains(&ratio)
                    || at_the_plane
                    || got.is_infinite() == want.is_infinite() && got.is_infinite(),
                "{name} near {near_m} at {distance_m}: {got} for {want}"
            );
        }
    }
}

#[test]
fn reversed_depth_gains_nothing_in_24_bits_and_everything_in_a_float() {
    let error = |mapping, storage| {
        let format = format(mapping, storage, 0.1, f64::INFINITY);
        (0..1000_u16)
            .map(|i| 1e3 + f64::from(i))
            .map(|d| (format.distance_m(f64::from(format.stored(d))) - d).abs())
            .fold(0.0, f64::max)
    };
    let standard = error(DepthMapping::Standard, DepthStorage::Unorm24);
    let reversed = error(DepthMapping::Reversed, DepthStorage::Unorm24);
    assert!(
        (reversed / standard - 1.0).abs() < 0.1,
        "{reversed} {standard}"
    );
    assert!(error(DepthMapping::Reversed, DepthStorage::Float32) < 1e-3 * standard);
}

#[test]
fn depths_return_and_wrong_planes_are_refused() {
    for format in all_formats(0.5) {
        for distance_m in [0.5, 1.0, 77.0, 1e4, 1e6] {
            let back = format.distance_m(format.depth(distance_m));
            assert!((back / distance_m - 1.0).abs() < 1e-8, "{}", format.name());
        }
        if format.far_m().is_finite() {
            let end = if format.mapping() == DepthMapping::Reversed {
                0.0
            } else {
                1.0
            };
            assert!((format.depth(format.far_m()) - end).abs() < 1e-15);
        }
    }
    let new = |mapping, near, far| DepthFormat::new(mapping, DepthStorage::Float32, near, far);
    use DepthMapping::{Logarithmic, Reversed};
    for (mapping, near, far, message) in [
        (
            Reversed,
            0.0,
            1.0,
            "near plane at 0 m, must be finite and above 0",
        ),
        (
            Reversed,
            f64::NAN,
            1.0,
            "near plane at NaN m, must be finite and above 0",
        ),
        (
            Reversed,
            2.0,
            1.0,
            "far plane at 1 m, must be beyond the near plane at 2 m",
        ),
        (
            Logarithmic,
            1.0,
            f64::INFINITY,
            "logarithmic depth needs a finite far plane",
        ),
    ] {
        let error = new(mapping, near, far).expect_err("refused");
        assert_eq!(error.to_string(), message);
    }
}

#[test]
fn special_depths_are_listed() {
    let (region, target) = region_and_target(11);
    // Depths at which each format has no finite position: its infinity, and what is no depth. A device
    // that flushes subnormals has its infinity there too; no drawn depth is as small.
    let always = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    for format in all_formats(0.5) {
        let view = view(target, 100.0, format);
        let endless = format.far_m().is_infinite();
        let infinity = match format.mapping() {
            DepthMapping::Standard if endless => Some(1.0),
            DepthMapping::Reversed if endless => Some(0.0),
            _ => None,
        };
        for route in PositionRoute::ALL {
            let constants = route.constants(&view, &region);
            let finite = |depth: f32| {
                let got = route.emulate(&format, &constants, [960.5, 540.5], depth);
                got.iter().all(|x| x.is_finite())
            };
            for depth in [
                0.0,
                -0.0,
                f32::MIN_POSITIVE / 4.0,
                1e-30,
                0.5,
                1.0 - f32::EPSILON,
                1.0,
            ] {
                let cleared = infinity.is_some_and(|at: f32| (at - depth).abs() <= 0.0);
                // The 2007 way divides by near over distance, which a logarithmic 0 has no end for;
                // and so close to reversed infinity the distance leaves f32.
                let inverse_of_zero = route == PositionRoute::InverseEcef
                    && format.mapping() == DepthMapping::Logarithmic
                    && depth < 1e-8;
                // near / far is below an f32's step beside 1, so the inverse matrix has no far plane.
                let far_plane = route == PositionRoute::InverseEcef
                    && format.mapping() == DepthMapping::Standard
                    && depth > 1.0 - 0.5 * f32::EPSILON;
                let expected = !cleared && !inverse_of_zero && !far_plane;
                let name = format.name();
                assert_eq!(finite(depth), expected, "{} {name} {depth:e}", route.name());
            }
            // A logarithm's −∞ is distance −1, by arithmetic alone.
            for depth in always.into_iter().filter(|d| !d.is_infinite()) {
                assert!(!finite(depth), "{}", route.name());
            }
        }
    }
}

#[test]
fn every_text_is_wgsl_and_a_broken_one_is_not() {
    let mut seen = std::collections::BTreeSet::new();
    for format in all_formats(0.5) {
        for route in PositionRoute::ALL {
            let text = route.wgsl(&format);
            is_valid(&text).unwrap_or_else(|e| panic!("{} {}: {e}", route.name(), format.name()));
            assert!(is_valid(&text.replacen("vec3f(", "vec2f(", 1)).is_err());
            let vectors = route.program(&format).constant_vectors();
            let (region, target) = region_and_target(0);
            let constants = route.constants(&view(target, 10.0, format), &region);
            assert_eq!(constants.len(), vectors, "{}", route.name());
            seen.insert(text);
        }
    }
    // Three routes; per route standard and reversed with and without end, and logarithmic, where
    // the inverse needs no distance for the first four.
    assert_eq!(seen.len(), 3 * 5 - 3);
}

/// Largest error of a vertex format's component over places, metres, and its bound.
fn vertex_error(format: VertexFormat, distance_m: f64, extent_m: f64) -> (f64, f64) {
    let (mut worst, mut bound) = (0.0_f64, 0.0_f64);
    for i in 0..4000_u32 {
        let turn = |k: f64| (f64::from(i) * k).fract() * 2.0 - 1.0;
        let origin = Ellipsoid::WGS84.geodetic_to_ecef(Geodetic {
            longitude_rad: 3.0 * turn(0.618_033_988_7),
            latitude_rad: 1.5 * turn(0.754_877_666_2),
            height_m: 0.0,
        });
        let vertex =
            origin + DVec3::new(turn(0.310_268_3), turn(0.770_159_2), turn(0.130_357_7)) * extent_m;
        let eye = vertex
            + DVec3::new(turn(0.170_820_4), turn(0.531_662_5), turn(0.912_870_9)) * distance_m;
        let got = DVec3::from(format.emulate(vertex, eye, origin, extent_m).map(f64::from));
        let error = (got - (vertex - eye)).abs().max_element();
        worst = worst.max(error);
        let radius = vertex.abs().max(eye.abs()).max_element();
        bound = bound.max(format.residual_m(radius, extent_m, distance_m));
        assert!(
            error <= format.residual_m(radius, extent_m, distance_m),
            "{}",
            format.name()
        );
    }
    (worst, bound)
}

#[test]
fn vertex_formats_lose_what_their_formula_says() {
    for format in VertexFormat::ALL {
        for (distance_m, extent_m) in [(10.0, 500.0), (1e3, 5e3), (1e6, 1e5)] {
            let (worst, bound) = vertex_error(format, distance_m, extent_m);
            assert!(
                worst > 0.2 * bound,
                "{} {distance_m}: {worst} of {bound}",
                format.name()
            );
        }
    }
    // Known figures at 10 m: 0.5 m a component, 6 mm, less than a micrometre; 0.66 m in length if
    // the sums of the two floats are reassociated.
    let at_10_m = |format| vertex_error(format, 10.0, 500.0).0;
    assert!((0.25..0.6).contains(&at_10_m(VertexFormat::EcefF32)));
    assert!((1e-3..6e-3).contains(&at_10_m(VertexFormat::SplitAt65536)));
    assert!(at_10_m(VertexFormat::TwoFloat) < 1e-6);
    assert!((0.25..0.66).contains(&at_10_m(VertexFormat::TwoFloatReassociated)));
    assert!(at_10_m(VertexFormat::RegionLocalF32) < 1e-4);
    assert!(at_10_m(VertexFormat::RegionFixedPoint) < 2e-6);
}

#[test]
fn names_return() {
    for route in PositionRoute::ALL {
        assert_eq!(PositionRoute::parse(route.name()), Some(route));
    }
    assert_eq!(PositionRoute::parse("eye-regio"), None);
    let names: std::collections::BTreeSet<_> =
        all_formats(1.0).iter().map(DepthFormat::name).collect();
    assert_eq!(names.len(), 10);
}
