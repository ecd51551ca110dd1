// SPDX-License-Identifier: MIT OR Apache-2.0
//! Charts on every body, across the antimeridian and over poles: emulation against bound, special
//! inputs, shader text.

use crate::naga_says::is_valid;
use terrafill_core::Ellipsoid;
use terrafill_texture::{
    Arithmetic, Chart, CoordinateRoute, CubeTexture, MapExtent, MapRegion, Program,
};

fn chart(name: &str) -> CoordinateRoute {
    CoordinateRoute::parse(name).expect("a chart")
}

/// A square at a place; heights in proportion to the body, as −11 … 9 km are to the Earth.
fn square(body: Ellipsoid, centre_deg: [f64; 2], size_deg: f64) -> MapRegion {
    let half = 0.5 * size_deg;
    let [lon, lat] = centre_deg;
    let extent = MapExtent::from_degrees(lon - half, lat - half, lon + half, lat + half);
    let scale = body.equatorial_radius_m() / 6_378_137.0;
    MapRegion::new(body, extent, (-11e3 * scale, 9e3 * scale)).expect("a region")
}

/// A cap round the north or the south pole with the pole for anchor.
fn cap(body: Ellipsoid, north: bool, size_deg: f64) -> MapRegion {
    let (south_deg, north_deg) = if north {
        (90.0 - size_deg, 90.0)
    } else {
        (-90.0, size_deg - 90.0)
    };
    let extent = MapExtent::from_degrees(-180.0, south_deg, 180.0, north_deg);
    let scale = body.equatorial_radius_m() / 6_378_137.0;
    MapRegion::anchored(body, extent, (-11e3 * scale, 9e3 * scale)).expect("a region")
}

#[test]
fn a_region_that_touches_one_pole_is_anchored_there() {
    let latitude = |south, north| {
        let extent = MapExtent::from_degrees(10.0, south, 30.0, north);
        let region = MapRegion::anchored(Ellipsoid::WGS84, extent, (0.0, 0.0)).expect("a region");
        region.anchor_latitude_rad().to_degrees()
    };
    for (south, north, want) in [
        (80.0, 90.0, 90.0),
        (-90.0, -60.0, -90.0),
        (-90.0, 90.0, 0.0),
        (80.0, 89.9, 84.95),
    ] {
        assert!(
            (latitude(south, north) - want).abs() < 1e-9,
            "{south} {north}"
        );
    }
}

/// Largest emulated error over its bound, sample by sample, and over all of them.
fn error_over_bound(program: &Program, constants: &[[f32; 4]], region: &MapRegion) -> (f64, f64) {
    let mut closest = 0.0_f64;
    let mut worst = 0.0_f64;
    for sample in region.samples(700) {
        let bounds = program.bounded(constants, sample.offset_m);
        for arithmetic in [Arithmetic::Fused, Arithmetic::Separate] {
            let got = program.emulate(constants, sample.offset_m, arithmetic);
            for axis in usize::from(sample.on_axis)..2 {
                let rounding = (f64::from(got[axis]) - bounds[axis].value).abs();
                closest = closest.max(rounding / bounds[axis].bound);
                let error = (f64::from(got[axis]) - sample.angles_rad[axis]).abs();
                worst = worst.max(error.min((std::f64::consts::TAU - error).abs()));
            }
        }
    }
    (closest, worst)
}

#[test]
fn emulation_stays_within_its_bound_on_every_body() {
    for body in Ellipsoid::ALL {
        for route in Chart::all().map(CoordinateRoute::Chart) {
            let polar = route.name().starts_with("azimuthal");
            let regions = if polar {
                [cap(body, true, 3.0), cap(body, false, 20.0)]
            } else {
                [
                    square(body, [179.5, -33.0], 2.0),
                    square(body, [20.0, 60.0], 0.05),
                ]
            };
            for region in regions {
                let (program, constants) = (route.program(), route.constants(&region));
                let (closest, worst) = error_over_bound(&program, &constants, &region);
                let case = format!("{} on {}", route.name(), body.name());
                assert!(closest <= 1.0, "{case}: {closest}");
                assert!(closest > 0.04, "{case}: the bound is idle, {closest}");
                let residual = route.residual(&region);
                assert_eq!(residual.non_finite, 0, "{case}");
                assert!(
                    worst <= 1.02 * residual.max_rad,
                    "{case}: {worst} {residual:?}"
                );
                assert!(
                    worst > 0.1 * residual.max_rad,
                    "{case}: {worst} {residual:?}"
                );
            }
        }
    }
}

#[test]
fn the_antimeridian_is_no_place() {
    // The same square at 20° E and across ±180°, written past 180 and past −180.
    for name in [
        "planes",
        "gnomonic-3",
        "gnomonic-5",
        "azimuthal-3",
        "cube-512",
    ] {
        let route = chart(name);
        let errors: Vec<f64> = [20.0, 180.0, -180.0, 179.9]
            .map(|lon| {
                let region = square(Ellipsoid::WGS84, [lon, 45.0], 1.0);
                route.residual(&region).max_m
            })
            .into();
        for error in &errors {
            assert!((error / errors[0] - 1.0).abs() < 0.05, "{name}: {errors:?}");
        }
    }
}

#[test]
fn exaggerated_heights_cost_what_another_implementation_says() {
    // Ten times the terrain at 45°, 1°, cubic: 3.3 m instead of 0.33 m, as an angle times the radius.
    let extent = MapExtent::from_degrees(19.5, 44.5, 20.5, 45.5);
    let error = |heights| {
        let region = MapRegion::new(Ellipsoid::WGS84, extent, heights).expect("a region");
        chart("gnomonic-3").residual(&region).approximation_max_rad * 6_378_137.0
    };
    assert!((0.5..2.0).contains(&(error((-11e3, 9e3)) / 0.33)));
    assert!((0.5..2.0).contains(&(error((-11e4, 9e4)) / 3.3)));
}

#[test]
fn operations_are_counted_from_what_is_printed() {
    for route in Chart::all().map(CoordinateRoute::Chart) {
        let (text, count) = (route.wgsl(), route.operations());
        let found = |what: &str| u32::try_from(text.matches(what).count()).expect("few");
        let name = route.name();
        assert_eq!(found(" / "), count.divisions, "{name}");
        assert_eq!(found("sqrt("), count.sqrt, "{name}");
        assert_eq!(found("atan"), count.transcendental, "{name}");
        let sums = found("fma(") + found(" + ") + found(" * ");
        // A minus with a space on either side is a difference, the other one a sign.
        assert_eq!(sums + found(" - "), count.add_mul_fma, "{name}");
        let fetches = u32::from(name.starts_with("cube"));
        assert_eq!(count.texture_fetches, fetches, "{name}");
    }
    let adds = |name: &str| chart(name).operations().add_mul_fma;
    assert_eq!(adds("planes"), 6);
    assert!(adds("gnomonic-5") > adds("gnomonic-3") && adds("gnomonic-3") > adds("gnomonic-1"));
}

#[test]
fn every_text_is_wgsl() {
    for route in Chart::all().map(CoordinateRoute::Chart) {
        let cube = route.program().cube().copied();
        let declarations = cube.map_or(String::new(), |cube| cube.declarations(0, 0));
        let text = format!("{declarations}{}", route.wgsl());
        is_valid(&text).unwrap_or_else(|e| panic!("{}: {e}", route.name()));
        // Negative controls: an argument less, and a texture that is not declared.
        assert!(
            is_valid(&text.replacen("fma(", "fma(1.0f, ", 1)).is_err() || !text.contains("fma(")
        );
        if !declarations.is_empty() {
            assert!(is_valid(&route.wgsl()).is_err());
        }
        let region = square(Ellipsoid::WGS84, [0.0, 0.0], 1.0);
        let constants = route.constants(&region);
        assert_eq!(
            constants.len(),
            route.program().constant_vectors(),
            "{}",
            route.name()
        );
    }
}

#[test]
fn inputs_without_a_finite_answer_are_listed() {
    let special = [
        0.0,
        -0.0,
        f32::MIN_POSITIVE / 8.0,
        1e-30,
        1.0,
        3e7,
        1e18,
        1e30,
        f32::MAX,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];
    let region = square(Ellipsoid::WGS84, [20.0, 45.0], 1.0);
    for route in Chart::all().map(CoordinateRoute::Chart) {
        let (program, constants) = (route.program(), route.constants(&region));
        for (axis, value) in (0..3).flat_map(|axis| special.map(|v| (axis, v))) {
            let mut offset = [0.0; 3];
            offset[axis] = value;
            let got = program.emulate(&constants, offset, Arithmetic::Fused);
            let finite = got.iter().all(|x| x.is_finite());
            let case = format!("{} {axis} {value:e}: {got:?}", route.name());
            // Whatever lies on or near a body has an answer. Powers of what is 10¹⁸ m away may
            // overflow. Infinities and NaN have none but one: infinitely far along the axis an
            // azimuthal chart sees the pole.
            let towards_pole = route.name().starts_with("azimuthal") && axis == 2;
            if value.abs() <= 3e7 {
                assert!(finite, "{case}");
            } else if value.is_nan() || value.is_infinite() {
                assert_eq!(finite, towards_pole && value.is_infinite(), "{case}");
            }
        }
    }
}

#[test]
fn points_opposite_the_projection_have_no_answer() {
    // On the plane through the projection's centre the divisor is 0.
    let region = square(Ellipsoid::UNIT_SPHERE, [0.0, 0.0], 1.0);
    let route = chart("gnomonic-1");
    let constants = route.constants(&region);
    assert!(!route.emulate(&constants, [-1.0, 0.5, 0.0])[0].is_finite());
    assert!(route.emulate(&constants, [-0.5, 0.5, 0.0])[0].is_finite());
}

#[test]
fn a_cube_uploads_what_it_samples() {
    let cube = CubeTexture::new(4);
    for face in 0..6 {
        let texels = cube.face(face);
        assert_eq!(texels.len(), 16);
        assert!(texels.iter().flatten().all(|x| x.is_finite()));
    }
    // Near the middle of +x both angles are small; of −x longitude is close to ±π.
    assert!(cube.face(0)[5].iter().all(|x| x.abs() < 0.3));
    assert!(cube.face(1)[5][0].abs() > 2.8);
    assert!(cube.face(4)[5][1] > 1.2 && cube.face(5)[5][1] < -1.2);
}

#[test]
fn barycentric_coordinates_err_by_the_chords_of_meridians_and_parallels() {
    let barycentric = CoordinateRoute::Chart(Chart::Barycentric);
    let on_equator = |size: f64| {
        let half = 0.5 * size;
        let extent = MapExtent::from_degrees(30.0 - half, -half, 30.0 + half, half);
        MapRegion::new(Ellipsoid::WGS84, extent, (0.0, 0.0)).expect("a region")
    };
    // The equator in the plane: x = tan(longitude). Its chord from 0 to h is off by 2 h³ / (9 √3) at most.
    for size in [1.0_f64, 4.0] {
        let half = (0.5 * size).to_radians();
        let expected = 2.0 * half.powi(3) / (9.0 * 3.0_f64.sqrt());
        let found = barycentric.residual(&on_equator(size)).max_rad;
        // The sides of the rectangle bend as well, and meridians converge: the same order.
        assert!(
            found > expected && found < 6.0 * expected,
            "{size}: {found:e} {expected:e}"
        );
    }
    // Ten metres are flat: what is left, a tenth of a millimetre at most, is rounding in f32.
    let small = barycentric.residual(&on_equator(1e-4)).max_rad;
    assert!(small < 1e-11, "{small:e}");
    // Negative control: a gnomonic chart of degree 1 is as flat, fitted, and errs less over the same 4 degrees.
    let fitted = CoordinateRoute::parse("gnomonic-1").expect("a chart");
    let region = on_equator(4.0);
    assert!(fitted.residual(&region).max_rad < barycentric.residual(&region).max_rad);
}
