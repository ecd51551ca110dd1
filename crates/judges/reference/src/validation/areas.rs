// SPDX-License-Identifier: MIT OR Apache-2.0
//! Areas by counting points of an equal-area lattice, against closed forms.
//!
//! The lattice: latitudes that cut the ellipsoid into zones of equal area, longitudes turned by
//! the golden angle from one to the next. Were the points random, a share `f` of `n` of them would
//! scatter by σ = √(f (1 − f) / n). The lattice is far more even, and [`SIGMAS`] says how much of
//! that is relied on.

use super::{TestRing, locator, parallel, rectangle};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Mutex;
use terrafill_core::{EdgeRule, Ellipsoid};
use terrafill_fixtures::Random;

const POINTS: u32 = 200_000;

/// Largest error allowed, in σ of random points. The largest one found is 0.027.
const SIGMAS: f64 = 0.05;

/// `POINTS` places, each standing for the same area of `body`.
fn lattice(body: &Ellipsoid) -> &'static [[f64; 2]] {
    static LATTICES: Mutex<BTreeMap<&str, &[[f64; 2]]>> = Mutex::new(BTreeMap::new());
    let mut lattices = LATTICES.lock().expect("no test panics while it holds this");
    lattices
        .entry(body.name())
        .or_insert_with(|| new_lattice(body).leak())
}

fn new_lattice(body: &Ellipsoid) -> Vec<[f64; 2]> {
    let golden_turn = (5_f64.sqrt() - 1.0) / 2.0;
    let whole = body.zone_area_per_radian(FRAC_PI_2);
    (0..POINTS)
        .map(|i| {
            let target = whole * ((f64::from(i) + 0.5) / f64::from(POINTS) * 2.0 - 1.0);
            let (mut south, mut north) = (-FRAC_PI_2, FRAC_PI_2);
            for _ in 0..60 {
                let middle = f64::midpoint(south, north);
                if body.zone_area_per_radian(middle) < target {
                    south = middle;
                } else {
                    north = middle;
                }
            }
            let turn = (f64::from(i) * golden_turn).fract();
            [turn * 360.0 - 180.0, south.to_degrees()]
        })
        .collect()
}

/// Whether the share of the lattice that is `inside` differs from the exact one by more than the
/// sampling allows.
fn area_error_in_sigmas(body: &Ellipsoid, area_m2: f64, inside: &dyn Fn(f64, f64) -> bool) -> f64 {
    let exact = area_m2 / body.quadrangle_area_m2(TAU, -FRAC_PI_2, FRAC_PI_2);
    let found = lattice(body)
        .iter()
        .filter(|place| inside(place[0], place[1]))
        .count();
    let sigma = (exact * (1.0 - exact) / f64::from(POINTS)).sqrt();
    (found as f64 / f64::from(POINTS) - exact).abs() / sigma
}

struct Shape {
    name: &'static str,
    body: Ellipsoid,
    rule: EdgeRule,
    rings: Vec<TestRing>,
    area_m2: f64,
}

/// Area of the planar triangle under the edge from (0, `top`) to (`top`, 0), degrees: the zones
/// below the edge, summed over longitude by Simpson's rule.
fn triangle_area(body: &Ellipsoid, top: f64) -> f64 {
    let steps = 1000;
    let width = top.to_radians() / f64::from(steps);
    let zone = |i: i32| body.zone_area_per_radian(top.to_radians() - f64::from(i) * width);
    let sum: f64 = (0..steps)
        .step_by(2)
        .map(|i| zone(i) + 4.0 * zone(i + 1) + zone(i + 2))
        .sum();
    sum * width / 3.0
}

fn shapes() -> Vec<Shape> {
    let body = Ellipsoid::WGS84;
    let quadrangle = |body: &Ellipsoid, [west, south, east, north]: [f64; 4]| {
        let width = (east - west).to_radians();
        body.quadrangle_area_m2(width, south.to_radians(), north.to_radians())
    };
    let planar = |name, rings: Vec<TestRing>, area_m2| Shape {
        name,
        body,
        rule: EdgeRule::Planar,
        rings,
        area_m2,
    };
    let cap = quadrangle(&body, [-180.0, 60.0, 180.0, 90.0]);
    let mut round_the_north = parallel(60.0);
    let mut shapes = vec![
        planar(
            "north cap, ring round the pole",
            vec![(0, round_the_north.clone(), 360.0)],
            cap,
        ),
        planar(
            "cap as RFC 7946 writes it",
            vec![(0, rectangle(-180.0, 60.0, 180.0, 90.0), 0.0)],
            cap,
        ),
        planar(
            "lune",
            vec![(0, rectangle(20.0, -90.0, 50.0, 90.0), 0.0)],
            quadrangle(&body, [20.0, -90.0, 50.0, 90.0]),
        ),
        planar(
            "strip over the antimeridian",
            vec![(0, rectangle(160.0, -20.0, 200.0, 30.0), 0.0)],
            quadrangle(&body, [160.0, -20.0, 200.0, 30.0]),
        ),
        planar(
            "the same strip cut in two",
            vec![
                (0, rectangle(160.0, -20.0, 180.0, 30.0), 0.0),
                (0, rectangle(-180.0, -20.0, -160.0, 30.0), 0.0),
            ],
            quadrangle(&body, [160.0, -20.0, 200.0, 30.0]),
        ),
        planar(
            "hole with an island",
            vec![
                (0, rectangle(-60.0, -10.0, 60.0, 70.0), 0.0),
                (0, rectangle(-40.0, 0.0, 40.0, 50.0), 0.0),
                (0, rectangle(-20.0, 10.0, 20.0, 40.0), 0.0),
            ],
            quadrangle(&body, [-60.0, -10.0, 60.0, 70.0])
                - quadrangle(&body, [-40.0, 0.0, 40.0, 50.0])
                + quadrangle(&body, [-20.0, 10.0, 20.0, 40.0]),
        ),
        planar(
            "triangle with a slanted edge",
            vec![(0, vec![[0.0, 0.0], [50.0, 0.0], [0.0, 50.0]], 0.0)],
            triangle_area(&body, 50.0),
        ),
        planar(
            "ring between two parallels",
            vec![(0, parallel(30.0), 360.0), (0, parallel(55.0), 360.0)],
            quadrangle(&body, [-180.0, 30.0, 180.0, 55.0]),
        ),
    ];
    round_the_north.reverse();
    let round_the_south: Vec<[f64; 2]> = round_the_north
        .iter()
        .map(|vertex| [vertex[0], -vertex[1]])
        .collect();
    shapes.push(planar(
        "south cap, written westwards",
        vec![(0, round_the_south, -360.0)],
        cap,
    ));
    let saturn = Ellipsoid::SATURN_LIKE;
    shapes.push(Shape {
        name: "cap of a flat body",
        body: saturn,
        rule: EdgeRule::Planar,
        rings: vec![(0, parallel(45.0), 360.0)],
        area_m2: quadrangle(&saturn, [-180.0, 45.0, 180.0, 90.0]),
    });
    let great = |name, body, vertices, area_m2| Shape {
        name,
        body,
        rule: EdgeRule::GreatEllipse,
        rings: vec![(0, vertices, 0.0)],
        area_m2,
    };
    // Equator and meridians are great ellipses on every body.
    shapes.push(great(
        "octant",
        body,
        vec![[10.0, 0.0], [100.0, 0.0], [77.0, 90.0]],
        quadrangle(&body, [10.0, 0.0, 100.0, 90.0]),
    ));
    shapes.push(great(
        "half of a hemisphere, clockwise",
        body,
        vec![[170.0, 0.0], [170.0, 90.0], [280.0, 0.0], [225.0, 0.0]],
        quadrangle(&body, [170.0, 0.0, 280.0, 90.0]),
    ));
    let unit = Ellipsoid::UNIT_SPHERE;
    let triangle = vec![[-170.0, 20.0], [150.0, 70.0], [130.0, -30.0]];
    let area_m2 = spherical_excess(&triangle);
    shapes.push(great("spherical triangle", unit, triangle, area_m2));
    shapes
}

/// Area of a triangle of great circles on the unit sphere by its sides (L'Huilier).
fn spherical_excess(vertices: &[[f64; 2]]) -> f64 {
    let side = |i: usize, j: usize| {
        let ([lon_a, lat_a], [lon_b, lat_b]) = (vertices[i], vertices[j]);
        let half_lat = ((lat_b - lat_a) / 2.0).to_radians().sin();
        let half_lon = ((lon_b - lon_a) / 2.0).to_radians().sin();
        let cosines = lat_a.to_radians().cos() * lat_b.to_radians().cos();
        2.0 * (half_lat * half_lat + cosines * half_lon * half_lon)
            .sqrt()
            .asin()
    };
    let (a, b, c) = (side(0, 1), side(1, 2), side(2, 0));
    let s = (a + b + c) / 2.0;
    let product: f64 = [s, s - a, s - b, s - c]
        .map(|x| (x / 2.0).tan())
        .iter()
        .product();
    4.0 * product.sqrt().atan()
}

#[test]
fn areas_by_point_count_match_closed_forms() {
    for shape in shapes() {
        let locator = locator(&shape.rings, shape.rule);
        let error = area_error_in_sigmas(&shape.body, shape.area_m2, &|lon, lat| {
            let location = locator.locate(lon, lat);
            assert!(
                location.disagree.is_empty(),
                "{}: tests differ at {lon} {lat}",
                shape.name
            );
            !location.regions.is_empty()
        });
        assert!(error < SIGMAS, "{}: off by {error} σ", shape.name);
    }
}

/// Negative control of the check above: each mutant must be refused for some shape, and it must be refused by
/// the area alone.
#[test]
fn mutants_have_wrong_areas() {
    type Mutant = fn(&Ellipsoid, f64, f64) -> ([f64; 2], bool);
    let mutants: [(&str, Mutant); 4] = [
        ("none", |_, lon, lat| ([lon, lat], false)),
        ("swapped longitude and latitude", |_, lon, lat| {
            ([lat, lon.clamp(-90.0, 90.0)], false)
        }),
        ("e² dropped", |body, lon, lat| {
            // Latitude as seen from the centre, which is what a body without e² would give.
            let squeeze = 1.0 - body.eccentricity_squared();
            (
                [lon, (squeeze * lat.to_radians().tan()).atan().to_degrees()],
                false,
            )
        }),
        ("winding flipped", |_, lon, lat| ([lon, lat], true)),
    ];
    for (name, mutant) in mutants {
        let mut refused = 0;
        for shape in shapes() {
            let locator = locator(&shape.rings, shape.rule);
            let error = area_error_in_sigmas(&shape.body, shape.area_m2, &|lon, lat| {
                let (place, flipped) = mutant(&shape.body, lon, lat);
                locator.locate(place[0], place[1]).regions.is_empty() == flipped
            });
            refused += usize::from(error >= SIGMAS);
        }
        // Every shape but the symmetric ones notices each mutant; bodies without flattening,
        // lunes and triangles between equator and meridians cannot notice a missing e².
        let expected = if name == "none" { 0..=0 } else { 6..=13 };
        assert!(
            expected.contains(&refused),
            "{name}: refused {refused} times"
        );
    }
}

#[test]
fn a_ring_held_to_the_wrong_pole_has_the_wrong_area() {
    let body = Ellipsoid::WGS84;
    let cap = body.quadrangle_area_m2(TAU, 60_f64.to_radians(), FRAC_PI_2);
    for (latitude, refused) in [(60.0, false), (-60.0, false), (59.0, true)] {
        let locator = locator(&[(0, parallel(latitude), 360.0)], EdgeRule::Planar);
        let error = area_error_in_sigmas(&body, cap, &|lon, lat| {
            !locator.locate(lon, lat).regions.is_empty()
        });
        assert_eq!(error >= SIGMAS, refused, "{latitude}: {error} σ");
    }
    let north = locator(&[(0, parallel(60.0), 360.0)], EdgeRule::Planar);
    assert_eq!(north.locate(0.0, 90.0).regions, [0]);
    assert!(north.locate(0.0, -90.0).regions.is_empty());
    let south = locator(&[(0, parallel(-60.0), 360.0)], EdgeRule::Planar);
    assert_eq!(south.locate(0.0, -90.0).regions, [0]);
    assert!(south.locate(0.0, 90.0).regions.is_empty());
}

#[test]
fn the_lattice_is_even_and_the_yardstick_is_not_blind() {
    let body = Ellipsoid::WGS84;
    let zone = body.quadrangle_area_m2(TAU, 0.1, 0.5);
    let inside = |_: f64, lat: f64| (0.1..0.5).contains(&lat.to_radians());
    assert!(area_error_in_sigmas(&body, zone, &inside) < SIGMAS);
    // A thousandth more area than there is.
    assert!(area_error_in_sigmas(&body, zone * 1.001, &inside) > SIGMAS);
    // Random points scatter by a whole σ or so, as the name says.
    let mut random = Random(1);
    let share = zone / body.quadrangle_area_m2(TAU, -FRAC_PI_2, FRAC_PI_2);
    let hits = (0..POINTS).filter(|_| random.share() < share).count();
    let sigma = (share * (1.0 - share) * f64::from(POINTS)).sqrt();
    assert!((hits as f64 - share * f64::from(POINTS)).abs() < 4.0 * sigma);
    assert!((spherical_excess(&[[0.0, 0.0], [90.0, 0.0], [0.0, 90.0]]) - PI / 2.0).abs() < 1e-14);
}
