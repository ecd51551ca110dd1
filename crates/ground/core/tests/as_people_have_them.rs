// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions as people have them: rings round a pole, uncut at the antimeridian, with collapsed holes,
//! with a vertex a last bit off an edge. Areas come from arithmetic that shares nothing with the mesher.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::time::Instant;
use terrafill_core::{
    EdgeRule, Ellipsoid, Inside, MeshError, MeshOptions, Reading, Region, RegionMesh,
    RegionWarning, Unwrap, read_regions_as,
};
use terrafill_fixtures::expectations::{
    BEHIND_CIRCLE_M2, BOTH_POLES, EASTERN_HALF, NOTCHED, SPIKED_CAP, circle_of_100_degrees,
};

type Degrees = [f64; 2];

const BODY: Ellipsoid = Ellipsoid::WGS84;
const PLANAR: EdgeRule = EdgeRule::Planar;
const ARCS: EdgeRule = EdgeRule::GreatEllipse;

fn read(rings: &[&[Degrees]], reading: Reading) -> Region {
    let text = format!(r#"{{"type":"Polygon","coordinates":{rings:?}}}"#);
    let read = read_regions_as(text.as_bytes(), "test", reading);
    read.expect("valid").regions.remove(0)
}

fn build_as(
    rings: &[&[Degrees]],
    rule: EdgeRule,
    reading: Reading,
) -> Result<RegionMesh, Vec<MeshError>> {
    let regions = [read(rings, reading)];
    RegionMesh::build_all(&regions, &BODY, rule, &MeshOptions::default()).map(|mut meshes| {
        assert_eq!(meshes[0].check_invariants(&BODY), Ok(()));
        meshes.remove(0)
    })
}

fn build(rings: &[&[Degrees]], rule: EdgeRule) -> RegionMesh {
    build_as(rings, rule, Reading::default()).expect("meshes")
}

fn inside(inside: Inside) -> Reading {
    Reading {
        inside,
        ..Reading::default()
    }
}

fn reversed(ring: &[Degrees]) -> Vec<Degrees> {
    ring.iter().rev().copied().collect()
}

fn whole_m2() -> f64 {
    BODY.quadrangle_area_m2(TAU, -FRAC_PI_2, FRAC_PI_2)
}

/// Area north of a curve once round the axis, straight between places in longitude and latitude.
fn north_of_m2(curve: &[Degrees]) -> f64 {
    let to_pole = |latitude: f64| {
        BODY.zone_area_per_radian(FRAC_PI_2) - BODY.zone_area_per_radian(latitude.to_radians())
    };
    let edges = curve.windows(2).map(|edge| {
        let [from, to] = [edge[0], edge[1]];
        let at = |k: u32| to_pole(from[1] + (to[1] - from[1]) * f64::from(k) / 512.0);
        let sum: f64 = (0..256)
            .map(|k| at(2 * k) + 4.0 * at(2 * k + 1) + at(2 * k + 2))
            .sum();
        (to[0] - from[0]).to_radians() * sum / (3.0 * 512.0)
    });
    edges.sum()
}

#[track_caller]
fn assert_area(mesh: &RegionMesh, expected_m2: f64, tolerance: f64) {
    let error = (mesh.area_m2 / expected_m2 - 1.0).abs();
    assert!(
        error < tolerance,
        "{} m², not {expected_m2}: {error:e}",
        mesh.area_m2
    );
}

/// A ring round a pole that is not cut at the antimeridian.
const UNCUT_CAP: [[f64; 2]; 5] = [
    [0.0, 60.0],
    [90.0, 60.0],
    [180.0, 60.0],
    [-90.0, 60.0],
    [0.0, 60.0],
];

#[test]
fn of_a_ring_round_a_pole_the_smaller_side_is_inside_or_the_left_one() {
    for (ring, percent) in [(&SPIKED_CAP[..], 7.2524), (&NOTCHED, 48.4005)] {
        let north_m2 = north_of_m2(&ring[..ring.len() - 1]);
        let found = 100.0 * north_m2 / whole_m2();
        assert!((found - percent).abs() < 1e-4, "{found} %");
        let smaller_m2 = north_m2.min(whole_m2() - north_m2);
        let backwards = reversed(ring);
        for (written, left_m2) in [(ring, north_m2), (&backwards, whole_m2() - north_m2)] {
            let differ = left_m2 > smaller_m2;
            for (choice, expected_m2) in [(Inside::Smaller, smaller_m2), (Inside::Left, left_m2)] {
                let mesh = build_as(&[written], PLANAR, inside(choice)).expect("meshes");
                assert_area(&mesh, expected_m2, 1e-9);
                assert_eq!(
                    mesh.warnings.len(),
                    usize::from(differ),
                    "{:?}",
                    mesh.warnings
                );
                let areas =
                    [expected_m2, whole_m2() - expected_m2].map(|m2| format!("{m2:.6e} m²"));
                for warning in &mesh.warnings {
                    let side = match choice {
                        Inside::Smaller => "inside is its smaller side",
                        Inside::Left => "inside is its left side",
                    };
                    for part in ["polygon 0, ring 0: the ring", side, &areas[0], &areas[1]] {
                        assert!(warning.text.contains(part), "{warning}: no {part}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_vertex_on_an_edge_changes_no_side() {
    let without = build(&[&NOTCHED], PLANAR);
    for on_the_edge in [&[-90.0][..], &[-170.0, -100.0, -90.0, -10.0]] {
        let mut split = NOTCHED.to_vec();
        for longitude in on_the_edge.iter().rev() {
            split.insert(1, [*longitude, 10.0]);
        }
        assert_area(&build(&[&split], PLANAR), without.area_m2, 1e-12);
    }
    // Negative control: one off the edge by enough to make the other side the smaller one.
    let mut moved = NOTCHED.to_vec();
    moved.insert(1, [-90.0, -10.0]);
    let north_m2 = north_of_m2(&moved[..moved.len() - 1]);
    assert!(north_m2 > 0.5 * whole_m2());
    assert_area(&build(&[&moved], PLANAR), whole_m2() - north_m2, 1e-9);
}

/// Latitudes along the great circle between two places.
fn followed(ring: &[Degrees]) -> Vec<Degrees> {
    let mut curve = vec![ring[0]];
    for edge in ring.windows(2) {
        let [[west, south], [east, north]] = [edge[0], edge[1]];
        let width = (east - west + 540.0).rem_euclid(360.0) - 180.0;
        for step in 1..=2_000 {
            let at = width * f64::from(step) / 2_000.0;
            let tangent = south.to_radians().tan() * (width - at).to_radians().sin()
                + north.to_radians().tan() * at.to_radians().sin();
            let latitude = (tangent / width.to_radians().sin()).atan().to_degrees();
            let previous = curve[curve.len() - 1][0];
            let latitude = if width == 0.0 { north } else { latitude };
            curve.push([previous + width / 2_000.0, latitude]);
        }
    }
    curve
}

#[test]
fn a_ring_of_great_ellipses_may_hold_both_poles() {
    // South of the southern arcs, north of the northern ones, and ten degrees between them.
    let south: Vec<Degrees> = BOTH_POLES[2..7].iter().map(|[x, y]| [*x, -*y]).collect();
    let south = followed(&reversed(&south));
    let north = followed(&BOTH_POLES[8..]);
    let strip = [[-5.0, 0.0], [5.0, 0.0]];
    let expected_m2 = north_of_m2(&south) + north_of_m2(&north) + 2.0 * north_of_m2(&strip);
    for ring in [BOTH_POLES.to_vec(), reversed(&BOTH_POLES)] {
        let mesh = build(&[&ring], ARCS);
        assert_area(&mesh, expected_m2, 1e-6);
        // Written the other way round, the left side is the rest.
        assert_eq!(mesh.warnings.len(), usize::from(ring[1] != BOTH_POLES[1]));
        let left = build_as(&[&ring], ARCS, inside(Inside::Left)).expect("meshes");
        let rest_m2 = whole_m2() - expected_m2;
        let left_m2 = if mesh.warnings.is_empty() {
            expected_m2
        } else {
            rest_m2
        };
        assert_area(&left, left_m2, 1e-6);
    }
    // Negative control: a ring with both poles on its larger side holds neither, whichever way it is written, unless its
    // left side is asked for.
    let country = box_of(0.0, 20.0, 0.0, 20.0);
    for choice in [Inside::Smaller, Inside::Left] {
        for (ring, is_clockwise) in [(country.to_vec(), false), (reversed(&country), true)] {
            let mesh = build_as(&[&ring], ARCS, inside(choice)).expect("meshes");
            let is_rest = is_clockwise && choice == Inside::Left;
            assert_eq!(mesh.area_m2 > 0.99 * whole_m2(), is_rest);
            assert_eq!(mesh.warnings.len(), usize::from(is_rest));
        }
    }
}

#[test]
fn the_left_of_any_shell_is_taken_where_it_is_asked_for() {
    let circle = circle_of_100_degrees();
    for (rule, behind_m2) in [PLANAR, ARCS].into_iter().zip(BEHIND_CIRCLE_M2) {
        let reading = |inside| Reading {
            unwrap: Unwrap::Shortest,
            inside,
        };
        let built =
            |ring: &[Degrees], side| build_as(&[ring], rule, reading(side)).expect("meshes");
        let left = built(&circle, Inside::Left);
        assert_area(&left, whole_m2() - behind_m2, 1e-9);
        let [note] = &left.warnings[..] else {
            panic!("{:?}", left.warnings);
        };
        assert!(
            note.text
                .contains("is written clockwise; inside is its left side"),
            "{note}"
        );
        // Negative controls: unasked, and written the other way round.
        for small in [
            built(&circle, Inside::Smaller),
            built(&reversed(&circle), Inside::Left),
        ] {
            assert_area(&small, behind_m2, 1e-9);
            assert!(small.warnings.is_empty(), "{:?}", small.warnings);
        }
        // A hole beside the circle's back is cut out of the left side, whichever way it is written.
        let hole = box_of(10.0, 20.0, -5.0, 5.0);
        for hole in [hole.to_vec(), reversed(&hole)] {
            let rings: [&[Degrees]; 2] = [&circle, &hole];
            let with_hole = build_as(&rings, rule, reading(Inside::Left)).expect("meshes");
            let hole_m2 = build(&[&hole], rule).area_m2;
            assert_area(&with_hole, left.area_m2 - hole_m2, 1e-9);
        }
    }
}

/// All the way round.
fn parallel(latitude: f64) -> [Degrees; 5] {
    [-180.0, -60.0, 60.0, 180.0, -180.0].map(|longitude| [longitude, latitude])
}

#[test]
fn of_halves_the_left_one_is_inside() {
    let equator = parallel(0.0);
    let middle_is_inside = |ring: &[Degrees], rule, at: Degrees| {
        let mesh = build(&[ring], rule);
        assert_area(&mesh, 0.5 * whole_m2(), 1e-12);
        assert!(mesh.warnings.is_empty());
        let near = |vertex: &Degrees| (vertex[0] - at[0]).hypot(vertex[1] - at[1]) < 10.0;
        mesh.vertices_deg.iter().any(near)
    };
    for (ring, rule, left, right) in [
        (&EASTERN_HALF[..], ARCS, [90.0, 0.0], [-90.0, 0.0]),
        (&equator, PLANAR, [0.0, 60.0], [0.0, -60.0]),
        (&equator, ARCS, [0.0, 60.0], [0.0, -60.0]),
    ] {
        let back = reversed(ring);
        assert!(middle_is_inside(ring, rule, left) && middle_is_inside(&back, rule, right));
        assert!(!middle_is_inside(ring, rule, right) && !middle_is_inside(&back, rule, left));
    }
}

#[test]
fn a_hole_round_the_pole_leaves_what_lies_between_it_and_its_shell() {
    let zone_m2 = |south: f64, north: f64| {
        BODY.quadrangle_area_m2(TAU, south.to_radians(), north.to_radians())
    };
    // The shell's smaller side is the other one than the hole's.
    for (shell, hole) in [(-10.0, 60.0), (60.0, -10.0), (10.0, 60.0), (-60.0, -80.0)] {
        let expected_m2 = zone_m2(f64::min(shell, hole), f64::max(shell, hole));
        for choice in [Inside::Smaller, Inside::Left] {
            let rings = [parallel(shell), parallel(hole)];
            let mesh = build_as(&[&rings[0], &rings[1]], PLANAR, inside(choice)).expect("meshes");
            assert_area(&mesh, expected_m2, 1e-12);
            assert!(mesh.warnings.is_empty(), "{:?}", mesh.warnings);
        }
    }
    // Negative control: a hole in the whole globe decides for itself; the right side of it, when asked for.
    let globe = box_of(-180.0, 180.0, -90.0, 90.0);
    let hole = parallel(60.0);
    let mesh = build(&[&globe, &hole], PLANAR);
    assert_area(&mesh, zone_m2(-90.0, 60.0), 1e-12);
    assert!(
        mesh.warnings[0]
            .text
            .contains("cut out is its smaller side"),
        "{:?}",
        mesh.warnings
    );
    let mesh = build_as(&[&globe, &hole], PLANAR, inside(Inside::Left)).expect("meshes");
    assert_area(&mesh, zone_m2(60.0, 90.0), 1e-12);
    let clockwise = reversed(&hole);
    let mesh = build_as(&[&globe, &clockwise], PLANAR, inside(Inside::Left)).expect("meshes");
    assert_area(&mesh, zone_m2(-90.0, 60.0), 1e-12);
    assert!(mesh.warnings.is_empty());
}

#[test]
fn edges_over_the_antimeridian_go_the_long_way_unless_the_shortest_is_asked_for() {
    let habit = box_of(170.0, -170.0, 10.0, 20.0);
    let literal = build(&[&habit], PLANAR);
    assert_area(&literal, box_m2(340.0, 10.0, 20.0), 1e-12);
    assert!(
        literal.warnings[0]
            .text
            .starts_with("2 edges span more than 180° of longitude")
    );
    let short = build_as(&[&habit], PLANAR, SHORTEST).expect("meshes");
    assert_area(&short, box_m2(20.0, 10.0, 20.0), 1e-12);
    assert!(short.warnings.is_empty());
    let extent = short.extent;
    assert_eq!([extent.west_deg, extent.east_deg], [170.0, -170.0]);
    // Great ellipses take the shorter way anyway, and nothing is said of planar edges.
    for reading in [Reading::default(), SHORTEST] {
        let arcs = build_as(&[&habit], ARCS, reading).expect("meshes");
        assert!(arcs.warnings.is_empty() && arcs.extent.west_deg > arcs.extent.east_deg);
    }
    // Both sides of the antimeridian written, a hole there, and a turn further east.
    let spelt = [
        [170.0, 10.0],
        [180.0, 10.0],
        [-180.0, 10.0],
        [-170.0, 10.0],
        [-170.0, 20.0],
        [-180.0, 20.0],
        [180.0, 20.0],
        [170.0, 20.0],
        [170.0, 10.0],
    ];
    let hole = box_of(178.0, -178.0, 12.0, 14.0);
    let expected_m2 = box_m2(20.0, 10.0, 20.0) - box_m2(4.0, 12.0, 14.0);
    for turn in [0.0, 360.0, -360.0] {
        let spelt = spelt.map(|[x, y]| [x + turn, y]);
        let mesh = build_as(&[&spelt, &hole], PLANAR, SHORTEST).expect("meshes");
        assert_area(&mesh, expected_m2, 1e-12);
    }
    // What is written along a pole or in short edges stays as it is.
    let antarctic = [
        [-180.0, -90.0],
        [180.0, -90.0],
        [180.0, -70.0],
        [60.0, -70.0],
        [-60.0, -70.0],
        [-180.0, -70.0],
        [-180.0, -90.0],
    ];
    let country = box_of(0.0, 20.0, 0.0, 20.0);
    for ring in [&antarctic[..], &country] {
        let region = |reading| read(&[ring], reading);
        assert_eq!(region(SHORTEST), region(Reading::default()));
    }
}

const AUTO: Reading = Reading {
    unwrap: Unwrap::Auto,
    inside: Inside::Smaller,
};
const SHORTEST: Reading = Reading {
    unwrap: Unwrap::Shortest,
    ..AUTO
};

fn box_of(west: f64, east: f64, south: f64, north: f64) -> [[f64; 2]; 5] {
    [
        [west, south],
        [east, south],
        [east, north],
        [west, north],
        [west, south],
    ]
}

fn box_m2(width: f64, south: f64, north: f64) -> f64 {
    let [width, south, north] = [width, south, north].map(f64::to_radians);
    BODY.quadrangle_area_m2(width, south, north)
}

#[test]
fn of_two_readings_the_one_is_taken_that_crosses_nothing_and_is_oriented() {
    let shorter = |rings: &[&[[f64; 2]]], expected_m2: f64| {
        let mesh = build_as(rings, PLANAR, AUTO).expect("meshes");
        assert_area(&mesh, expected_m2, 1e-12);
        let warned = |warning: &RegionWarning| {
            let text = &warning.text;
            text.contains("read the shorter way") && text.contains("--unwrap literal")
        };
        assert!(mesh.warnings.iter().any(warned), "{:?}", mesh.warnings);
    };
    let as_written = |rings: &[&[[f64; 2]]], expected_m2: f64| {
        let mesh = build_as(rings, PLANAR, AUTO).expect("meshes");
        assert_area(&mesh, expected_m2, 1e-12);
        let same = build(rings, PLANAR);
        assert_eq!(mesh.warnings, same.warnings);
    };
    let jump = box_of(171.0, -171.0, 14.0, 15.0);
    shorter(&[&jump], box_m2(18.0, 14.0, 15.0));
    // A hole goes with its shell, however it runs.
    for hole in [
        box_of(178.0, -178.0, 14.2, 14.8),
        reversed_box(178.0, -178.0, 14.2, 14.8),
    ] {
        shorter(
            &[&jump, &hole],
            box_m2(18.0, 14.0, 15.0) - box_m2(4.0, 14.2, 14.8),
        );
    }
    // Round a pole: nothing is enclosed as the numbers stand.
    shorter(&[&UNCUT_CAP], box_m2(360.0, 60.0, 90.0));
    // Clockwise, so only crossings tell: the northern jump would cut the spike at 160 … 165.
    let spiked = [
        [160.0, 10.0],
        [160.0, 30.0],
        [165.0, 30.0],
        [165.0, 12.0],
        [170.0, 20.0],
        [-170.0, 20.0],
        [-170.0, 10.0],
        [170.0, 10.0],
        [160.0, 10.0],
    ];
    let turned = spiked.map(|[x, y]| [if x < 0.0 { x + 360.0 } else { x }, y]);
    shorter(&[&spiked], build(&[&turned], PLANAR).area_m2);
    // Bands, boxes of the world, and what no edge jumps in stay.
    for (ring, expected_m2) in [
        (box_of(-171.0, 171.0, 14.0, 15.0), box_m2(342.0, 14.0, 15.0)),
        (
            box_of(-179.9, 179.9, -85.0, 85.0),
            box_m2(359.8, -85.0, 85.0),
        ),
        (box_of(-180.0, 180.0, 30.0, 38.0), box_m2(360.0, 30.0, 38.0)),
        (
            reversed_box(-180.0, 180.0, 30.0, 38.0),
            box_m2(360.0, 30.0, 38.0),
        ),
        (box_of(-180.0, 180.0, 80.0, 90.0), box_m2(360.0, 80.0, 90.0)),
        (box_of(170.0, 190.0, 14.0, 15.0), box_m2(20.0, 14.0, 15.0)),
    ] {
        as_written(&[&ring], expected_m2);
    }
    // Negative control: told to take the numbers, the jump is a band; told the opposite, the band a jump.
    assert_area(&build(&[&jump], PLANAR), box_m2(342.0, 14.0, 15.0), 1e-12);
    let band = build_as(&[&box_of(-171.0, 171.0, 14.0, 15.0)], PLANAR, SHORTEST).expect("meshes");
    assert_area(&band, box_m2(18.0, 14.0, 15.0), 1e-12);
}

fn reversed_box(west: f64, east: f64, south: f64, north: f64) -> [[f64; 2]; 5] {
    let mut ring = box_of(west, east, south, north);
    ring.reverse();
    ring
}

#[test]
fn one_part_may_be_a_band_and_another_a_jump() {
    let parts = [
        [box_of(-180.0, 180.0, 30.0, 38.0)],
        [box_of(171.0, -172.0, -20.0, -6.0)],
    ];
    let text = format!(r#"{{"type":"MultiPolygon","coordinates":{parts:?}}}"#);
    let read = read_regions_as(text.as_bytes(), "t", AUTO);
    let regions = read.expect("valid").regions;
    assert_eq!(regions[0].warnings.len(), 1);
    assert!(
        regions[0].warnings[0]
            .text
            .starts_with("polygon 1, ring 0: 2 edges over more than 180°")
    );
    let mesh =
        RegionMesh::build(&regions[0], &BODY, PLANAR, &MeshOptions::default()).expect("meshes");
    assert_area(
        &mesh,
        box_m2(360.0, 30.0, 38.0) + box_m2(17.0, -20.0, -6.0),
        1e-12,
    );
    // Great ellipses have nothing to find out.
    assert_eq!(AUTO.of_edges(ARCS).unwrap, Unwrap::Literal);
    assert_eq!(AUTO.of_edges(PLANAR), AUTO);
}

#[test]
fn a_pole_ring_without_its_cut_is_refused_with_what_would_read_it() {
    let refused = build_as(&[&UNCUT_CAP], PLANAR, Reading::default()).expect_err("no area");
    let [MeshError::NoArea { long_edges: 1, .. }] = refused[..] else {
        panic!("{refused:?}");
    };
    let mesh = build_as(&[&UNCUT_CAP], PLANAR, SHORTEST).expect("meshes");
    let cap_m2 = BODY.quadrangle_area_m2(TAU, 60_f64.to_radians(), FRAC_PI_2);
    assert_area(&mesh, cap_m2, 1e-12);
    assert!(build(&[&UNCUT_CAP], ARCS).area_m2 < cap_m2);
    // Negative control: nothing of long edges where there are none.
    let line = [[0.0, 60.0], [90.0, 60.0], [100.0, 60.0], [0.0, 60.0]];
    let refused = build_as(&[&line], PLANAR, Reading::default()).expect_err("no area");
    assert_eq!(
        refused[0].to_string(),
        "feature 0: the rings enclose no area"
    );
}

#[test]
fn every_crossing_of_arcs_is_listed() {
    let knot = [
        [-22.215_626_112_076_293, -1.137_427_231_703_769_2],
        [-19.901_693_061_023_817, -0.960_731_706_066_421_7],
        [-23.452_740_097_492_384, -5.298_265_426_214_496],
        [-19.601_909_156_563_874, 4.629_894_098_982_212],
        [-19.884_265_901_539_987, -3.866_919_377_967_096],
        [-22.215_626_112_076_293, -1.137_427_231_703_769_2],
    ];
    let places = |ring: &[Degrees]| -> Vec<[usize; 2]> {
        let errors = build_as(&[ring], ARCS, Reading::default()).expect_err("crosses");
        let place = |error: &MeshError| match error {
            MeshError::SelfCrossing { first, second, .. } => [first.vertex, second.vertex],
            other => panic!("{other}"),
        };
        errors.iter().map(place).collect()
    };
    assert_eq!(places(&knot), [[0, 2], [1, 4], [2, 4]]);
    // Chords of a star {n/k} about the equator's origin cross n (k − 1) times, and so do its arcs.
    let star = |count: u32, step: u32| -> Vec<Degrees> {
        (0..=count)
            .map(|i| {
                let angle = TAU * f64::from(i * step % count) / f64::from(count);
                [20.0 * angle.cos(), 20.0 * angle.sin()]
            })
            .collect()
    };
    assert_eq!(places(&star(5, 2)).len(), 5);
    assert_eq!(places(&star(19, 5)).len(), 76);
    // Negative control: a star that crosses nowhere.
    assert!(build(&[&star(5, 1)], ARCS).warnings.is_empty());
}

#[test]
fn a_collapsed_hole_is_left_out_with_a_warning() {
    let shell = box_of(0.0, 10.0, 0.0, 10.0);
    let hole = [[7.0, 7.0], [8.0, 7.0], [8.0, 8.0], [7.0, 7.0]];
    let back = [[2.0, 2.0], [4.0, 2.0], [2.0, 2.0], [2.0, 2.0]];
    let line = [[2.0, 2.0], [4.0, 2.0], [6.0, 2.0], [2.0, 2.0]];
    let said = "1 hole without area was left out";
    let expected_m2 = build(&[&shell, &hole], PLANAR).area_m2;
    for collapsed in [back, line] {
        for rule in [PLANAR, ARCS] {
            if rule == ARCS && collapsed == line {
                continue;
            }
            for repair in [false, true] {
                let mut region = read(&[&shell, &collapsed, &hole], Reading::default());
                if repair {
                    assert_eq!(region.split_at_crossings(rule), 0);
                }
                let mesh = RegionMesh::build(&region, &BODY, rule, &MeshOptions::default());
                let mesh = mesh.expect("meshes");
                assert!(
                    mesh.warnings.iter().any(|warning| *warning == said),
                    "{:?}",
                    mesh.warnings
                );
                assert_eq!((mesh.holes, mesh.boundary_loops.len()), (1, 2));
                if rule == PLANAR {
                    assert_area(&mesh, expected_m2, 1e-13);
                }
            }
        }
        // What is wrong with a later ring names its place in the file.
        let across = [[7.0, 7.0], [12.0, 7.0], [8.0, 8.0], [7.0, 7.0]];
        let errors = build_as(&[&shell, &collapsed, &across], PLANAR, Reading::default());
        let errors = errors.expect_err("crosses");
        assert!(errors[0].to_string().contains("ring 2"), "{}", errors[0]);
    }
    // Negative controls: by great ellipses the line is a sliver; and a shell is no hole.
    let sliver = build(&[&shell, &line], ARCS);
    assert_eq!((sliver.holes, sliver.warnings.len()), (1, 0));
    let refused = build_as(&[&line], PLANAR, Reading::default()).expect_err("no area");
    assert!(matches!(refused[0], MeshError::NoArea { .. }));
}

#[test]
fn slivers_keep_the_digits_of_their_areas() {
    let body = BODY;
    // M N cos φ, square metres per square radian.
    let scale = |latitude: f64| {
        let (sin, cos) = latitude.to_radians().sin_cos();
        let (a2, e2) = (
            body.equatorial_radius_m().powi(2),
            body.eccentricity_squared(),
        );
        a2 * (1.0 - e2) / (1.0 - e2 * sin * sin).powi(2) * cos
    };
    let top = 10.000_000_000_000_071;
    let east = 17.105_427_357_600_29;
    let needle = [[10.0, 10.0], [east, top], [east, 10.0], [10.0, 10.0]];
    // Subtracted in degrees, where both differences are exact.
    let sides = [east - 10.0, top - 10.0].map(f64::to_radians);
    let expected_m2 = 0.5 * sides[0] * sides[1] * scale(10.0);
    assert!((expected_m2 / 0.003_061_276_35 - 1.0).abs() < 1e-8);
    assert_area(&build(&[&needle], PLANAR), expected_m2, 1e-12);
    // Negative control: subtracted in radians.
    let wrong = top.to_radians() - 10_f64.to_radians();
    assert!((wrong / sides[1] - 1.0).abs() > 5e-3);
    // A square metre.
    let (west, south) = (10.0, 45.0);
    let (east, north): (f64, f64) = (west + 1.27e-5, south + 9e-6);
    let square = box_of(west, east, south, north);
    let (width, height) = ((east - west).to_radians(), (north - south).to_radians());
    let expected_m2 = width * height * scale(0.5 * (south + north));
    assert!((0.9..1.1).contains(&expected_m2));
    assert_area(&build(&[&square], PLANAR), expected_m2, 1e-13);
}

#[test]
fn a_vertex_a_last_bit_outside_is_refused_at_every_tolerance() {
    let shell = [
        [11.894_776_601_190_637, 10.140_789_316_286_638],
        [11.268_084_990_354_495, 11.414_906_518_904_214],
        [9.900_225_107_618_281, 11.897_378_446_923_6],
        [8.311_056_495_345_493, 9.129_672_568_463_253],
        [11.894_776_601_190_637, 10.140_789_316_286_638],
    ];
    let hole = |tip: Degrees| [tip, [10.19, 10.0], [10.0, 10.19], tip];
    let out = [8.749_201_838_849_682, 9.892_749_207_072_583];
    let inside = [out[0] + 1e-14, out[1]];
    for boundary_tolerance_m in [0.1, 1.0, 10.0, 100.0, 500.0, 1_000.0, 100_000.0] {
        let options = MeshOptions {
            boundary_tolerance_m,
            ..MeshOptions::default()
        };
        let build = |tip| {
            let region = read(&[&shell, &hole(tip)], Reading::default());
            RegionMesh::build(&region, &BODY, PLANAR, &options)
        };
        let refused = build(out).map(|mesh| mesh.area_m2);
        assert!(
            matches!(refused, Err(MeshError::SelfCrossing { .. })),
            "{boundary_tolerance_m} m: {refused:?}"
        );
        // Negative control: some last bits inside.
        let mesh = build(inside).expect("inside");
        assert_eq!((mesh.check_invariants(&BODY), mesh.holes), (Ok(()), 1));
    }
}

#[test]
fn a_tolerance_finer_than_what_is_drawn_is_bounded_and_said() {
    let square = box_of(10.0, 20.0, 40.0, 50.0);
    for rule in [PLANAR, ARCS] {
        let region = read(&[&square], Reading::default());
        let build = |boundary_tolerance_m| {
            let options = MeshOptions {
                boundary_tolerance_m,
                ..MeshOptions::default()
            };
            let start = Instant::now();
            let mesh = RegionMesh::build(&region, &BODY, rule, &options).expect("meshes");
            // It takes 0.3 s; unbounded it took 35 s.
            assert!(start.elapsed().as_secs() < 20);
            mesh
        };
        let mesh = build(1e-9);
        assert!(mesh.boundary_edge_count() < 200_000);
        // As fine as the finest tolerance that is followed.
        assert!((1e-9..3.2e-4).contains(&mesh.boundary_deviation_m));
        let said = format!("{:.3e} m was reached", mesh.boundary_deviation_m);
        assert!(
            mesh.warnings[0].text.ends_with(&said),
            "{:?}",
            mesh.warnings
        );
        // Negative control: what can be reached is.
        let mesh = build(1e-3);
        assert!(mesh.boundary_deviation_m <= 1e-3 && mesh.warnings.is_empty());
    }
}
