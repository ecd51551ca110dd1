// SPDX-License-Identifier: MIT OR Apache-2.0
//! Routes of two arctangents, whole: names, shader text, residual against emulation, special places.

use crate::naga_says::is_valid;
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use terrafill_core::{Ellipsoid, Geodetic, nearest_f32};
use terrafill_texture::{
    AngleCore, AngleForm, Arithmetic, CoordinateRoute, LatitudeForm, MapExtent, MapRegion,
    MapRegionError, Residual, ResidualSum, Sample,
};

fn route(name: &str) -> CoordinateRoute {
    CoordinateRoute::parse(name).unwrap_or_else(|| panic!("{name}: no such route"))
}

/// A square of `size` degrees round a latitude, cut off at the poles, with terrain on it.
fn region(latitude: f64, size: f64) -> MapRegion {
    let south = (latitude - size / 2.0).max(-90.0);
    let north = (latitude + size / 2.0).min(90.0);
    let extent = MapExtent::from_degrees(10.0 - size / 2.0, south, 10.0 + size / 2.0, north);
    MapRegion::new(Ellipsoid::WGS84, extent, (-11e3, 9e3)).expect("a region")
}

fn angle_routes() -> Vec<CoordinateRoute> {
    CoordinateRoute::all()
        .into_iter()
        .filter(|route| matches!(route, CoordinateRoute::Angles { .. }))
        .collect()
}

#[test]
fn names_are_different_and_return() {
    let all = CoordinateRoute::all();
    let names: BTreeSet<String> = all.iter().map(CoordinateRoute::name).collect();
    assert_eq!(names.len(), all.len());
    for one in all.iter().step_by(17) {
        assert_eq!(CoordinateRoute::parse(&one.name()), Some(*one));
    }
    // Without a latitude it is one step of Bowring's.
    assert_eq!(route("recentred-odd-7").name(), "recentred-odd-7+bowring-1");
    for wrong in [
        "",
        "odd-6",
        "odd-7+bowring-3",
        "odd-pin-3",
        "lut-100-r8-nearest",
        "Odd-7",
    ] {
        assert_eq!(CoordinateRoute::parse(wrong), None, "{wrong}");
    }
}

/// A route's text with its declarations and an entry point that calls it.
fn module_of(route: &CoordinateRoute) -> String {
    let program = route.program();
    let declarations = program
        .table()
        .map_or(String::new(), |table| table.declarations(0, 1));
    format!(
        "{declarations}@group(0) @binding(0) var<uniform> constants: RouteConstants;\n{}\
         @fragment fn main(@location(0) d: vec3f) -> @location(0) vec4f {{\n    \
         return vec4f(route_angles(d, constants), 0.0, 1.0);\n}}\n",
        route.wgsl()
    )
}

#[test]
fn every_text_is_wgsl_and_a_broken_one_is_not() {
    let routes = angle_routes();
    assert!(routes.len() > 1000, "{}", routes.len());
    for route in routes {
        if let Err(message) = is_valid(&module_of(&route)) {
            panic!("{}: {message}", route.name());
        }
    }
    let good = module_of(&route("lut-256-r16-linear"));
    for (word, mutant) in [
        ("return vec2f", "return vec3f"),
        ("var route_sampler: sampler;", ""),
        ("c1: vec4f,", ""),
        ("textureSampleLevel", "textureSampleLvl"),
    ] {
        assert!(good.contains(word), "{word}");
        assert!(is_valid(&good.replace(word, mutant)).is_err(), "{word}");
    }
}

/// Numbers with the suffix f in a shader's text.
fn literals(text: &str) -> BTreeSet<u32> {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || ".-+".contains(c)))
        .filter_map(|word| word.strip_suffix('f')?.parse::<f32>().ok())
        .map(f32::to_bits)
        .collect()
}

#[test]
fn the_text_has_the_tables_coefficients_and_no_others() {
    for core in AngleCore::all() {
        let Some((numerator, denominator)) = core.coefficients() else {
            continue;
        };
        let of = |latitude| CoordinateRoute::Angles {
            form: AngleForm::Near,
            core,
            latitude,
        };
        let text = of(LatitudeForm::Geocentric).wgsl();
        let found = literals(&text);
        let coefficients: BTreeSet<u32> = numerator
            .iter()
            .chain(denominator)
            .map(|c| nearest_f32(*c).to_bits())
            .collect();
        // Dense ones take the sign off and put it back by comparing with 0.
        let mut expected = coefficients.clone();
        if core.name().starts_with("dense") || core == AngleCore::CesiumCubic {
            expected.insert(0.0_f32.to_bits());
        }
        assert_eq!(found, expected, "{}", core.name());
        // Negative control: the last bit of one coefficient.
        let one = f32::from_bits(*coefficients.iter().next().expect("has some"));
        let mutant = text.replace(&format!("{one:?}f"), &format!("{:?}f", one.next_up()));
        assert_ne!(literals(&mutant), expected, "{}", core.name());
    }
}

/// What running a route in `f32` gives over a region.
struct Measured {
    max_rad: f64,
    rms_rad: f64,
    max_m: f64,
    /// Largest error over the bound at the same place.
    over_bound: f64,
    non_finite: u32,
}

/// - `turn`: added to what the route gives, to see that a wrong answer is noticed
fn measure(route: CoordinateRoute, region: &MapRegion, count: u32, turn: [f64; 2]) -> Measured {
    let program = route.program();
    let constants = route.constants(region);
    let jump = match route {
        CoordinateRoute::Angles { core, .. } => core.theory_error().unwrap_or(0.0),
        _ => 0.0,
    };
    let mut result = Measured {
        max_rad: 0.0,
        rms_rad: 0.0,
        max_m: 0.0,
        over_bound: 0.0,
        non_finite: 0,
    };
    let (mut squares, mut places) = ([0.0; 2], 0.0);
    for sample in region.samples(count) {
        let bounded = program.bounded(&constants, sample.offset_m);
        for arithmetic in [Arithmetic::Fused, Arithmetic::Separate] {
            let found = program.emulate(&constants, sample.offset_m, arithmetic);
            if !found.iter().all(|angle| angle.is_finite()) {
                result.non_finite += 1;
                continue;
            }
            places += 1.0;
            let mut square_m = 0.0;
            for axis in usize::from(sample.on_axis)..2 {
                let short = |difference: f64| difference.abs().min((TAU - difference.abs()).abs());
                let found = f64::from(found[axis]) + turn[axis];
                let error = short(found - sample.angles_rad[axis]);
                let rounding = short(found - bounded[axis].value);
                // The bound is to first order. Where f32 falls on the other side of an octant or of a
                // texel's edge, it differs by the jump there, which is twice the core's error.
                let allowed = 1.001 * bounded[axis].bound + 2.0 * jump + 1e-30;
                result.over_bound = result.over_bound.max(rounding / allowed);
                result.max_rad = result.max_rad.max(error);
                squares[axis] += error * error;
                square_m += (error * sample.metres_per_radian[axis]).powi(2);
            }
            result.max_m = result.max_m.max(square_m.sqrt());
        }
    }
    result.rms_rad = (squares[0].max(squares[1]) / places).sqrt();
    result
}

/// What a residual does not say as it should, or nothing.
fn complaint(residual: &Residual, measured: &Measured) -> Option<String> {
    // A few metres wide, a region's sums all round the same way, and half of what is expected of
    // independent roundings does not come: down to 0.42 at the equator.
    let within = |found: f64, said: f64| found > 0.4 * said && found < 2.0 * said;
    if measured.over_bound > 1.0 {
        return Some(format!("rounding {} of its bound", measured.over_bound));
    }
    if residual.non_finite + measured.non_finite > 0 {
        return Some("not finite".to_owned());
    }
    if measured.max_rad > residual.max_rad || measured.max_m > residual.max_m {
        return Some(format!("max {} over {}", measured.max_m, residual.max_m));
    }
    if !within(measured.rms_rad, residual.rms_rad) {
        let (found, said) = (measured.rms_rad, residual.rms_rad);
        return Some(format!("rms {found:e}, said {said:e}"));
    }
    if !within(measured.max_rad, residual.expected_max_rad) {
        let (found, said) = (measured.max_rad, residual.expected_max_rad);
        return Some(format!("max {found:e}, expected {said:e}"));
    }
    None
}

/// Routes of every kind that behave differently.
const KINDS: [&str; 16] = [
    "odd-3+geocentric",
    "odd-7",
    "odd-15+parametric",
    "odd-15+bowring-2",
    "rat-2-2",
    "dense-8",
    "lut-64-r16-nearest",
    "lut-1024-r32f-linear",
    "lut-4096-r32f-linear-exact",
    "recentred-odd-7+parametric",
    "recentred-odd-15",
    "recentred-odd-pin-11+bowring-2",
    "recentred-lut-256-r16-linear",
    "recentred-rat-3-3",
    "near-odd-9",
    "near-rat-2-3",
];

#[test]
fn the_residual_is_what_running_it_shows() {
    let mut checked = 0;
    for latitude in [0.0, 45.0, -70.0, 85.0, 90.0] {
        for size in [1e-3, 0.1, 5.0, 60.0, 360.0] {
            let region = region(latitude, size);
            for name in KINDS {
                let beyond_near = size > 60.0 || region.touches_pole() || latitude.abs() > 70.0;
                if name.starts_with("near") && beyond_near {
                    continue;
                }
                let route = route(name);
                let residual = route.residual(&region);
                let measured = measure(route, &region, 2048, [0.0; 2]);
                if let Some(what) = complaint(&residual, &measured) {
                    panic!("{name} at {latitude}, {size}°: {what}");
                }
                checked += 1;
            }
        }
    }
    assert!(checked > 300, "{checked}");
}

#[test]
fn a_residual_that_says_too_little_or_too_much_is_noticed() {
    let region = region(45.0, 5.0);
    for name in KINDS {
        let route = route(name);
        let right = route.residual(&region);
        let measured = measure(route, &region, 2048, [0.0; 2]);
        assert_eq!(complaint(&right, &measured), None, "{name}");
        for factor in [0.3, 4.0] {
            let wrong = Residual {
                rms_rad: right.rms_rad * factor,
                expected_max_rad: right.expected_max_rad * factor,
                ..right
            };
            assert!(complaint(&wrong, &measured).is_some(), "{name} {factor}");
        }
        // A latitude that is off by ten times the largest error.
        let turned = measure(route, &region, 2048, [0.0, 10.0 * right.max_rad]);
        assert!(complaint(&right, &turned).is_some(), "{name}");
    }
}

#[test]
fn wrong_constants_are_noticed() {
    // Another region's constants, the sphere's in place of the ellipsoid's, one lane zero.
    let home = region(45.0, 5.0);
    let sphere = Ellipsoid::new("sphere", 6_378_137.0, 6_378_137.0).expect("a sphere");
    let round = MapRegion::new(sphere, *home.extent(), home.height_range_m()).expect("a region");
    for name in ["odd-15", "recentred-odd-15", "near-odd-15"] {
        let route = route(name);
        let program = route.program();
        let right = route.constants(&home);
        let worst = |constants: &[[f32; 4]]| {
            home.samples(200)
                .map(|sample| {
                    let found = program.emulate(constants, sample.offset_m, Arithmetic::Fused);
                    let off = |axis: usize| f64::from(found[axis]) - sample.angles_rad[axis];
                    off(0).abs().max(off(1).abs())
                })
                .fold(0.0, f64::max)
        };
        let bound = route.residual(&home).max_rad;
        assert!(worst(&right) < bound, "{name}");
        assert!(
            worst(&route.constants(&region(46.0, 5.0))) > bound,
            "{name}"
        );
        assert!(worst(&route.constants(&round)) > bound, "{name}");
        for (vector, lane) in (0..right.len()).flat_map(|v| (0..4).map(move |l| (v, l))) {
            let mut mutant = right.clone();
            if mutant[vector][lane].abs() > 0.0 && reads(&program, vector * 4 + lane) {
                // Bowring's step hardly depends on where it starts.
                mutant[vector][lane] *= 1.5;
                let found = worst(&mutant);
                assert!(found > bound, "{name} {vector} {lane}: {found:e} {bound:e}");
            }
        }
    }
}

fn reads(program: &terrafill_texture::Program, index: usize) -> bool {
    let step = terrafill_texture::Step::Constant(index);
    program.steps().contains(&step)
}

#[test]
fn recentred_angles_shrink_with_the_region_and_absolute_ones_do_not() {
    // Largest errors in metres at latitude 45 as another implementation measured them. It took the
    // height as 0 and a nearly perfect arctangent.
    for (size, recentred_m) in [(1e-3, 0.8e-3), (1.0, 1.3e-2), (10.0, 0.14)] {
        let region = region(45.0, size);
        let recentred = measure(route("recentred-rat-3-3"), &region, 4096, [0.0; 2]).max_m;
        let ratio = recentred / recentred_m;
        assert!((0.5..2.0).contains(&ratio), "{size}: {recentred}");
        let absolute = measure(route("rat-3-3"), &region, 4096, [0.0; 2]).max_m;
        assert!((0.55..2.8).contains(&absolute), "{size}: {absolute}");
        // Negative control: the one is not the other.
        assert!(absolute > 5.0 * recentred, "{size}: {absolute} {recentred}");
    }
}

#[test]
fn what_is_left_out_of_the_latitude_shows() {
    let region = region(45.0, 1.0);
    let off = |name: &str| route(name).residual(&region).max_m;
    // 21.4 km for the geocentric latitude, 37 m for the parametric one at −11 km.
    assert!((off("rat-3-3+geocentric") / 21.4e3 - 1.0).abs() < 0.02);
    assert!((off("recentred-rat-3-3+parametric") / 37.0 - 1.0).abs() < 0.02);
    assert!(off("recentred-rat-3-3+bowring-1") < 0.1);
    // Recentred, the geocentric latitude is off by how its difference changes, not by 21 km.
    let recentred = off("recentred-rat-3-3+geocentric");
    assert!((30.0..300.0).contains(&recentred), "{recentred}");
    // On Saturn one step leaves 0.3 m, two nothing.
    let extent = MapExtent::from_degrees(0.0, 35.0, 1.0, 36.0);
    let saturn = MapRegion::new(Ellipsoid::SATURN_LIKE, extent, (-1e5, 8.4e4)).expect("a region");
    let off = |name: &str| route(name).residual(&saturn).approximation_max_rad * 6.0e7;
    let (one, two) = (
        off("recentred-rat-3-3+bowring-1"),
        off("recentred-rat-3-3+bowring-2"),
    );
    assert!(one > 0.1 && one < 0.4 && two < 0.5 * one, "{one} {two}");
}

#[test]
fn operations_add_up() {
    // Absolute, geocentric, native: two sums to the position, ρ (a product, an fma and a root), one
    // difference, two arctangents.
    let plain = route("atan2-native+geocentric").operations();
    assert_eq!(
        (plain.add_mul_fma, plain.sqrt, plain.transcendental),
        (5, 1, 2)
    );
    assert_eq!((plain.divisions, plain.compares_selects), (0, 0));
    let parametric = route("atan2-native+parametric").operations();
    assert_eq!(
        parametric.add_mul_fma,
        plain.add_mul_fma + 1,
        "one product more"
    );
    // Bowring's step: (1 − f) ρ, a squared length, two products for the direction, two cubes, two fma.
    let bowring = route("atan2-native+bowring-1").operations();
    assert_eq!(bowring.add_mul_fma, plain.add_mul_fma + 1 + 2 + 2 + 4 + 2);
    assert_eq!(bowring.sqrt, plain.sqrt + 1);
    // A degree more costs two fma, one for each angle; nothing else moves.
    for form in ["", "recentred-", "near-"] {
        let of = |degree: u32| route(&format!("{form}odd-{degree}")).operations();
        for degree in [3, 5, 7, 9, 11, 13] {
            let (low, high) = (of(degree), of(degree + 2));
            assert_eq!(high.add_mul_fma, low.add_mul_fma + 2);
            assert_eq!(high.compares_selects, low.compares_selects);
        }
    }
    // Leaving the octants out leaves every select out.
    assert_eq!(
        route("near-odd-7").operations().compares_selects,
        1,
        "a root's guard"
    );
    assert!(route("recentred-odd-7").operations().compares_selects > 15);
}

/// Offsets at which a route may go wrong, from a region's anchor.
fn special_offsets(region: &MapRegion) -> Vec<(&'static str, [f32; 3])> {
    let anchor = region.anchor_meridian().as_vec3();
    let body = region.body();
    let pole = region.offset_m(Geodetic {
        longitude_rad: 0.0,
        latitude_rad: FRAC_PI_2,
        height_m: 0.0,
    });
    let pole = pole.as_vec3();
    let radius = body.equatorial_radius_m();
    let far = region.offset_m(Geodetic {
        longitude_rad: 1.0,
        latitude_rad: 0.5,
        height_m: 5.0 * radius,
    });
    let antimeridian = region.offset_m(Geodetic {
        longitude_rad: PI + region.anchor_longitude_rad(),
        latitude_rad: 0.3,
        height_m: 0.0,
    });
    let antimeridian = antimeridian.as_vec3();
    vec![
        ("the anchor", [0.0; 3]),
        ("the anchor, negative zeros", [-0.0; 3]),
        ("subnormals", [1e-40, -1e-40, 1e-42]),
        ("the body's centre", [-anchor.x, 0.0, -anchor.z]),
        ("the north pole", [-anchor.x, 0.0, pole.z]),
        ("the south pole", [-anchor.x, 0.0, -2.0 * anchor.z - pole.z]),
        ("beside the axis", [-anchor.x, 1e-30, pole.z]),
        (
            "the opposite point",
            [-2.0 * anchor.x, 0.0, -2.0 * anchor.z],
        ),
        ("the opposite meridian", antimeridian.to_array()),
        ("just east of it", [antimeridian.x, 1.0, antimeridian.z]),
        ("just west of it", [antimeridian.x, -1.0, antimeridian.z]),
        ("a high orbit", far.as_vec3().to_array()),
    ]
}

#[test]
fn finite_offsets_have_finite_angles_everywhere() {
    let centred = [
        (0.0, 1.0),
        (45.0, 1.0),
        (-70.0, 360.0),
        (90.0, 10.0),
        (-90.0, 10.0),
    ];
    let mut homes: Vec<MapRegion> = centred.map(|(lat, size)| region(lat, size)).into();
    // Anchored at a pole, where the anchor has no distance from the axis and the opposite pole is
    // as far away as a place can be.
    for latitude in [90.0, -90.0] {
        let cap = region(latitude, 10.0);
        let (extent, heights) = (*cap.extent(), cap.height_range_m());
        let anchored = MapRegion::anchored(Ellipsoid::WGS84, extent, heights);
        homes.push(anchored.expect("a region"));
    }
    let mut checked = 0;
    for home in homes {
        for route in angle_routes() {
            let CoordinateRoute::Angles { form, core, .. } = route else {
                continue;
            };
            // Formats differ in values only, and the near form promises nothing this far away.
            let other_table = matches!(core, AngleCore::Lookup { texels, .. } if texels != 64);
            if other_table || form == AngleForm::Near {
                continue;
            }
            let program = route.program();
            let constants = route.constants(&home);
            for (what, offset) in special_offsets(&home) {
                for arithmetic in [Arithmetic::Fused, Arithmetic::Separate] {
                    let found = program.emulate(&constants, offset, arithmetic);
                    let finite = found.iter().all(|angle| angle.is_finite());
                    assert!(finite, "{} at {what}: {found:?}", route.name());
                    let sane = found[0].abs() < 3.15 && found[1].abs() < 3.15;
                    assert!(sane, "{} at {what}: {found:?}", route.name());
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 10_000, "{checked}");
}

#[test]
fn offsets_that_are_not_finite_give_what_is_listed() {
    // The chooser never sees these: a fragment without a surface has no offset. Listed, since a
    // comparison that drops NaN gives a plausible angle: "finite" below is not "right".
    let home = region(45.0, 1.0);
    let [inf, nan] = [f32::INFINITY, f32::NAN];
    let offsets = [
        [inf, 0.0, 0.0],
        [0.0, inf, 0.0],
        [0.0, 0.0, inf],
        [inf, inf, 0.0],
        [inf, inf, inf],
        [nan, 0.0, 0.0],
        [0.0, nan, 0.0],
        [0.0, 0.0, nan],
    ];
    // One letter per offset: f both finite, n at least one not.
    for (name, expected) in [
        ("atan2-native+geocentric", "fffffnnn"),
        ("odd-7+geocentric", "fffnnfff"),
        ("odd-7+bowring-1", "fffnnnnn"),
        ("recentred-odd-7+geocentric", "nnnnnnnn"),
        ("recentred-odd-7+bowring-1", "nnnnnnnn"),
        ("near-odd-7+bowring-1", "nnnnnnnn"),
    ] {
        let route = route(name);
        let constants = route.constants(&home);
        let found: String = offsets
            .iter()
            .map(|offset| {
                let angles = route.emulate(&constants, *offset);
                let finite = angles.iter().all(|angle| angle.is_finite());
                if finite { 'f' } else { 'n' }
            })
            .collect();
        assert_eq!(found, expected, "{name}");
    }
}

#[test]
fn the_antimeridian_is_no_seam_within_a_region() {
    // A region over ±180°: longitudes on both sides continue, and the jump is on the far side.
    let extent = MapExtent::from_degrees(170.0, -10.0, 190.0, 10.0);
    let home = MapRegion::new(Ellipsoid::WGS84, extent, (0.0, 0.0)).expect("a region");
    for name in ["odd-11", "recentred-odd-11", "near-odd-11", "atan2-native"] {
        let route = route(name);
        let constants = route.constants(&home);
        let at = |longitude_deg: f64| {
            let place = home.sample(Geodetic::from_degrees(longitude_deg, 3.0, 0.0));
            route.emulate(&constants, place.offset_m)[0]
        };
        // East of 180° written either way.
        assert!((at(181.0) - at(-179.0)).abs() < 1e-6, "{name}");
        let rise = (at(181.0) - at(179.0)).to_degrees();
        assert!((rise - 2.0).abs() < 1e-3, "{name}: {rise}");
        // Negative control: anchored at 0 the same two places are a turn apart.
        let extent = MapExtent::from_degrees(-180.0, -10.0, 180.0, 10.0);
        let globe = MapRegion::new(Ellipsoid::WGS84, extent, (0.0, 0.0)).expect("a region");
        let constants = route.constants(&globe);
        let at = |longitude_deg: f64| {
            let place = globe.sample(Geodetic::from_degrees(longitude_deg, 3.0, 0.0));
            route.emulate(&constants, place.offset_m)[0]
        };
        if !name.starts_with("near") {
            assert!(at(179.0) - at(181.0) > 6.0, "{name}");
        }
    }
}

#[test]
fn regions_that_are_none_are_refused() {
    let good = MapExtent::from_degrees(0.0, 0.0, 1.0, 1.0);
    let with = |extent, heights| MapRegion::new(Ellipsoid::WGS84, extent, heights);
    assert!(with(good, (0.0, 0.0)).is_ok());
    for (extent, heights) in [
        (MapExtent::from_degrees(1.0, 0.0, 0.0, 1.0), (0.0, 0.0)),
        (MapExtent::from_degrees(0.0, 0.0, 361.0, 1.0), (0.0, 0.0)),
        (MapExtent::from_degrees(0.0, 1.0, 1.0, 0.0), (0.0, 0.0)),
        (MapExtent::from_degrees(0.0, 0.0, 1.0, 91.0), (0.0, 0.0)),
        (good, (1.0, 0.0)),
        (good, (-4e6, 0.0)),
    ] {
        let refused = matches!(with(extent, heights), Err(MapRegionError::Bounds { .. }));
        assert!(refused, "{extent:?} {heights:?}");
    }
    let nan = MapExtent {
        west_rad: f64::NAN,
        ..good
    };
    for refused in [with(nan, (0.0, 0.0)), with(good, (0.0, f64::INFINITY))] {
        assert!(matches!(refused, Err(MapRegionError::NotFinite { .. })));
    }
}

#[test]
fn a_route_beyond_its_domain_says_so() {
    // The near form has no octants: past 45° its core is beyond 1, and at the axis it divides by 0.
    for (latitude, size) in [(90.0, 10.0), (0.0, 179.0)] {
        let home = region(latitude, size);
        for name in ["near-odd-15", "near-rat-2-2", "near-lut-256-r16-linear"] {
            let residual = route(name).residual(&home);
            assert!(residual.max_rad > 0.05, "{name}: {}", residual.max_rad);
        }
        // Negative control: with octants the same cores hold.
        for name in ["recentred-odd-15", "recentred-rat-2-2"] {
            let residual = route(name).residual(&home);
            assert!(residual.max_rad < 1e-3, "{name}: {}", residual.max_rad);
        }
    }
    // On the axis itself nothing finite comes out, and that is counted and makes the maximum infinite.
    let home = region(45.0, 1.0);
    let on_axis = Sample {
        offset_m: [-home.anchor_meridian().as_vec3().x, 0.0, 0.0],
        angles_rad: [0.0; 2],
        metres_per_radian: [1.0; 2],
        on_axis: true,
    };
    for (name, non_finite) in [("near-odd-15", 1), ("recentred-odd-15", 0)] {
        let route = route(name);
        let answer = route
            .program()
            .bounded(&route.constants(&home), on_axis.offset_m);
        let mut sum = ResidualSum::default();
        sum.add(&on_axis, [answer[0], answer[1]]);
        let residual = sum.finish();
        assert_eq!(residual.non_finite, non_finite, "{name}");
        assert_eq!(residual.max_rad.is_infinite(), non_finite > 0, "{name}");
    }
}
