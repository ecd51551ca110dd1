// SPDX-License-Identifier: MIT OR Apache-2.0
//! Charts: how far their polynomials are from the body.

use super::*;
use crate::residual::{Residual, residual_of};
use crate::{CoordinateRoute, MapExtent, MapRegionError};
use terrafill_core::{Ellipsoid, nearest_f32};

fn chart(name: &str) -> Chart {
    let found = Chart::all().find(|chart| chart.name() == name);
    found.expect("a chart")
}

/// A square of `size_deg` round a latitude, from the ocean's floor to the highest mountain.
fn square(latitude_deg: f64, size_deg: f64) -> Result<MapRegion, MapRegionError> {
    let half = 0.5 * size_deg;
    let extent = MapExtent::from_degrees(
        20.0 - half,
        latitude_deg - half,
        20.0 + half,
        latitude_deg + half,
    );
    MapRegion::new(Ellipsoid::WGS84, extent, (-11e3, 9e3))
}

fn residual(chart: Chart, region: &MapRegion) -> Residual {
    residual_of(&chart.program(), &chart.constants(region), region, 1000)
}

/// Errors by another implementation: metres as the larger angle's error times the equatorial
/// radius, fitted at height 0 by least squares, heights −11 … 9 km.
const PUBLISHED_M: [(f64, f64, [f64; 5]); 7] = [
    (45.0, 0.01, [1.4, 0.05, 0.003, 0.003, 0.003]),
    (45.0, 0.1, [17.0, 5.1, 0.033, 0.032, 0.032]),
    (45.0, 1.0, [580.0, 510.0, 3.8, 0.33, 0.33]),
    (45.0, 5.0, [1.3e4, 1.3e4, 460.0, 15.0, 1.7]),
    (70.0, 1.0, [1500.0, 1400.0, 21.0, 0.33, 0.08]),
    (85.0, 1.0, [5800.0, 5700.0, 370.0, 23.0, 0.18]),
    (0.0, 10.0, [2800.0, 1900.0, 1900.0, 13.0, 6.4]),
];

#[test]
fn errors_of_charts_are_those_of_another_implementation() {
    let names = [
        "planes",
        "gnomonic-1",
        "gnomonic-2",
        "gnomonic-3",
        "gnomonic-5",
    ];
    for (latitude, size, published) in PUBLISHED_M {
        let region = square(latitude, size).expect("a region");
        for (name, want) in names.iter().zip(published) {
            let found = residual(chart(name), &region);
            let ratio = found.approximation_max_rad * 6_378_137.0 / want;
            // Close to the pole the fit for the smallest maximum is five times as good as least
            // squares where five powers are available.
            let better = latitude > 80.0 && *name == "gnomonic-5";
            let allowed = if better { 0.15..0.5 } else { 0.5..2.0 };
            assert!(
                allowed.contains(&ratio),
                "{name} at {latitude}, {size} degrees: {ratio} of {want} m"
            );
        }
    }
}

#[test]
fn the_bodys_centre_would_leave_the_foot_of_the_normal() {
    // A gnomonic chart that projects from the centre: e² taken away from its frame.
    let region = square(45.0, 0.01).expect("a region");
    let chart = chart("gnomonic-3");
    let program = chart.program();
    let right = chart.constants(&region);
    let mut mutant = right.clone();
    // Up becomes the direction from the centre to the anchor.
    let anchor = region.anchor_meridian();
    let centre = anchor.normalize();
    mutant[0][0] = nearest_f32(centre.x / anchor.length());
    mutant[0][1] = nearest_f32(centre.z / anchor.length());
    let north = DVec3::new(-centre.z, 0.0, centre.x);
    let scale = f64::from(right[0][3]).hypot(f64::from(right[1][0]));
    mutant[0][3] = nearest_f32(north.x * scale);
    mutant[1][0] = nearest_f32(north.z * scale);
    let error = |constants: &[[f32; 4]]| {
        residual_of(&program, constants, &region, 500).approximation_max_rad * 6_378_137.0
    };
    assert!(error(&right) < 0.01);
    let off = error(&mutant);
    assert!((30.0..45.0).contains(&off), "{off}");
}

#[test]
fn every_coefficient_counts() {
    let region = square(52.0, 3.0).expect("a region");
    let cap = MapExtent::from_degrees(-180.0, 70.0, 180.0, 90.0);
    let cap = MapRegion::with_anchor(Ellipsoid::WGS84, 0.0, FRAC_PI_2, cap, (0.0, 0.0));
    let cap = cap.expect("a region");
    for chart in Chart::all() {
        let region = match chart {
            Chart::Azimuthal(_) => &cap,
            _ => &region,
        };
        let program = chart.program();
        let constants = chart.constants(region);
        let before = residual_of(&program, &constants, region, 300);
        let used = program
            .steps()
            .iter()
            .filter(|step| matches!(step, crate::Step::Constant(_)))
            .count();
        let mut noticed = 0;
        for lane in 0..4 * constants.len() {
            let mut mutant = constants.clone();
            let value = &mut mutant[lane / 4][lane % 4];
            // A tenth of it, or something where it is nothing: more than any fit leaves open.
            *value += if value.abs() < 1e-12 {
                0.1
            } else {
                0.1 * *value
            };
            let after = residual_of(&program, &mutant, region, 300);
            noticed += usize::from(after != before);
        }
        assert_eq!(noticed, used, "{}", chart.name());
    }
}

#[test]
fn a_chart_too_wide_says_so() {
    let wide = MapExtent::from_degrees(-100.0, -10.0, 100.0, 10.0);
    let region = MapRegion::new(Ellipsoid::WGS84, wide, (0.0, 0.0)).expect("a region");
    for degree in ChartDegree::ALL {
        let chart = Chart::Gnomonic(degree);
        let constants = chart.constants(&region);
        assert!(constants.iter().flatten().all(|x| x.is_finite()));
        assert!(residual(chart, &region).max_rad > 0.5);
    }
}

#[test]
fn over_a_pole_the_azimuthal_chart_is_smooth_and_the_gnomonic_one_is_not() {
    for (south, north, pole) in [(80.0, 90.0, FRAC_PI_2), (-90.0, -70.0, -FRAC_PI_2)] {
        let extent = MapExtent::from_degrees(-180.0, south, 180.0, north);
        let region = MapRegion::with_anchor(Ellipsoid::WGS84, 0.0, pole, extent, (-11e3, 9e3))
            .expect("a region");
        let azimuthal = residual(chart("azimuthal-4"), &region);
        assert_eq!(azimuthal.non_finite, 0);
        // Longitude has the floor of an f32 angle of π, latitude that of the cap.
        assert!(azimuthal.max_axis_rad[0] < 2e-6, "{azimuthal:?}");
        assert!(azimuthal.max_axis_rad[1] < 1e-6, "{azimuthal:?}");
        assert!(azimuthal.max_m < 5.0, "{azimuthal:?}");
        let gnomonic = residual(chart("gnomonic-5"), &region);
        assert!(gnomonic.max_rad > 1.0);
    }
}

#[test]
fn close_to_a_pole_longitude_is_as_good_as_the_offset() {
    let cap = MapExtent::from_degrees(-180.0, 80.0, 180.0, 90.0);
    let region = MapRegion::with_anchor(Ellipsoid::WGS84, 0.0, FRAC_PI_2, cap, (0.0, 0.0));
    let region = region.expect("a region");
    let beside = MapRegion::new(Ellipsoid::WGS84, cap, (0.0, 0.0)).expect("a region");
    let chart = chart("azimuthal-4");
    let error = |region: &MapRegion, metres: f64| {
        let constants = chart.constants(region);
        let program = chart.program();
        let mut worst = 0.0_f64;
        for i in 0..60_u8 {
            let sample = region.sample(Geodetic {
                longitude_rad: f64::from(i) * 0.1 - 3.0,
                latitude_rad: FRAC_PI_2 - metres / 6.4e6,
                height_m: 0.0,
            });
            let got = program.emulate(&constants, sample.offset_m, crate::Arithmetic::Fused);
            worst = worst.max((f64::from(got[0]) - sample.angles_rad[0]).abs());
        }
        worst
    };
    for metres in [0.01, 1.0, 1e3, 1e5] {
        assert!(error(&region, metres) < 6e-7, "{metres}");
    }
    // With the anchor beside the pole its distance from the axis is added in f32.
    assert!(error(&beside, 1.0) > 1e-3);
    // At the pole itself longitude is 0 by definition, and latitude the pole's.
    let at_pole = chart.program().emulate(
        &chart.constants(&region),
        [0.0; 3],
        crate::Arithmetic::Fused,
    );
    assert!(
        at_pole[0].abs() < f32::MIN_POSITIVE && at_pole[1].abs() < 1e-15,
        "{at_pole:?}"
    );
}

/// Largest error of a cube texture with exact weights over an extent, metres on the ground.
fn cube_error_m(size: u32, [west, south, east, north]: [f64; 4]) -> f64 {
    let chart = chart(&format!("cube-{size}"));
    let extent = MapExtent::from_degrees(west, south, east, north);
    let latitude = (0.5 * (south + north)).to_radians();
    let region = MapRegion::with_anchor(Ellipsoid::WGS84, 0.0, latitude, extent, (0.0, 0.0))
        .expect("a region");
    let (program, constants) = (chart.program(), chart.constants(&region));
    region
        .samples(4000)
        .map(|sample| {
            let answer = program.bounded(&constants, sample.offset_m);
            let off = [0, 1].map(|axis: usize| {
                let error = answer[axis].value - sample.angles_rad[axis];
                error * sample.metres_per_radian[axis]
            });
            off[0].hypot(off[1])
        })
        .fold(0.0, f64::max)
}

#[test]
fn a_cube_has_the_published_error_within_a_face_and_more_at_its_edges() {
    let equator = |size| cube_error_m(size, [-40.0, -30.0, 40.0, 30.0]);
    // The pole's disc of three texels is left out: there longitude goes round within a texel.
    let disc = |size: u32| 3.0 * 90.0 / f64::from(size);
    let pole = |size| cube_error_m(size, [-150.0, 60.0, 150.0, 90.0 - disc(size)]);
    let edge = |size| cube_error_m(size, [44.0, 20.0, 46.0, 30.0]);
    assert!((0.5..2.0).contains(&(equator(1024) / 3.3)));
    assert!((0.5..2.0).contains(&(pole(1024) / 423.0)));
    // Within a face the error falls with the square of the size, close to the pole with its first
    // power, since the disc shrinks too.
    let fall = |error: &dyn Fn(u32) -> f64| error(512) / error(1024);
    assert!((3.7..4.3).contains(&fall(&equator)));
    assert!((1.8..2.2).contains(&fall(&pole)));
    // Two texels on either side of a cube's edge lie at the same latitude, the edge between them
    // at a lower one: half a texel's width times t / √2 is left, 1.3 km at 1024.
    assert!((1.8..2.2).contains(&fall(&edge)));
    assert!((1000.0..1600.0).contains(&edge(1024)), "{}", edge(1024));
}

#[test]
fn names_return_and_others_do_not() {
    for chart in Chart::all() {
        let route = CoordinateRoute::Chart(chart);
        assert_eq!(CoordinateRoute::parse(&chart.name()), Some(route));
    }
    for name in ["gnomonic-0", "gnomonic-6", "cube-1000", "plane", ""] {
        assert_eq!(CoordinateRoute::parse(name), None, "{name}");
    }
}
