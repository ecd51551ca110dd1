// SPDX-License-Identifier: MIT OR Apache-2.0
//! Edges that cross on the antimeridian itself, where both are cut: their pieces only touch there.

use crate::outlines::RULES;
use terrafill_core::{EdgeRule, Ellipsoid, MeshError, MeshOptions, Region, RegionMesh};

type Degrees = [f64; 2];

/// One part per ring.
fn region(rings: &[&[Degrees]]) -> Region {
    let parts: Vec<_> = rings.iter().map(|ring| [ring]).collect();
    terrafill_fixtures::region(&format!("{parts:?}"))
}

fn build(region: &Region, rule: EdgeRule) -> Result<RegionMesh, MeshError> {
    let body = Ellipsoid::WGS84;
    let mesh = RegionMesh::build(region, &body, rule, &MeshOptions::default())?;
    assert_eq!(mesh.check_invariants(&body), Ok(()));
    Ok(mesh)
}

/// Latitude of the crossing that the region is refused for.
fn refused_at(region: &Region, rule: EdgeRule) -> f64 {
    match build(region, rule) {
        Err(MeshError::SelfCrossing {
            longitude_deg,
            latitude_deg,
            ..
        }) => {
            assert!((longitude_deg.abs() - 180.0).abs() < 1e-8);
            latitude_deg
        }
        other => panic!("{}: not refused: {other:?}", rule.name()),
    }
}

fn area_m2(rings: &[&[Degrees]], rule: EdgeRule) -> f64 {
    build(&region(rings), rule).expect("simple").area_m2
}

/// Every spelling of a ring's longitudes, a turn apart.
fn spellings(ring: &[Degrees]) -> [Vec<Degrees>; 3] {
    [0.0, -360.0, -180.0].map(|by| {
        let turned = |[x, y]: Degrees| [x + by, y];
        let ring: Vec<Degrees> = ring.iter().copied().map(turned).collect();
        ring
    })
}

#[test]
fn a_bow_tie_whose_knot_lies_on_the_antimeridian_is_refused_and_repaired() {
    let tie = [[170.0, -5.0], [190.0, 5.0], [190.0, -5.0], [170.0, 5.0]];
    for rule in RULES {
        let wings: [&[Degrees]; 2] = [
            &[[170.0, -5.0], [180.0, 0.0], [170.0, 5.0]],
            &[[190.0, 5.0], [180.0, 0.0], [190.0, -5.0]],
        ];
        let expected = area_m2(&wings, rule);
        let spelled = spellings(&tie);
        // The last one is the same tie at longitude 0, which has always been refused.
        for tie in &spelled[..2] {
            assert!(refused_at(&region(&[tie]), rule).abs() < 1e-12);
            let mut repaired = region(&[tie]);
            assert_eq!(repaired.split_at_crossings(rule), 1, "{}", rule.name());
            assert_eq!(
                repaired.warnings.last().map(|last| last.text.as_str()),
                Some("1 crossing of edges: filled by the even-odd rule")
            );
            // A second time there is nothing left to do.
            assert_eq!(repaired.clone().split_at_crossings(rule), 0);
            let found = build(&repaired, rule).expect("repaired").area_m2;
            assert!((found / expected - 1.0).abs() < 1e-9, "{}", rule.name());
        }
        let mut at_zero = region(&[&spelled[2]]);
        assert!(build(&at_zero, rule).is_err());
        assert_eq!(at_zero.split_at_crossings(rule), 1);
    }
}

#[test]
fn the_tie_of_the_report_is_refused() {
    // Planar edges of the same latitudes at both ends, their crossing at 5° on the antimeridian.
    let tie = [[170.0, 0.0], [190.0, 10.0], [170.0, 10.0], [190.0, 0.0]];
    let latitude = refused_at(&region(&[&tie]), EdgeRule::Planar);
    assert!((latitude - 5.0).abs() < 1e-12);
    let mut repaired = region(&[&tie]);
    assert_eq!(repaired.split_at_crossings(EdgeRule::Planar), 1);
    assert!(build(&repaired, EdgeRule::Planar).is_ok());
}

#[test]
fn parts_written_a_turn_apart_cross_on_the_antimeridian_too() {
    let a = [[170.0, -1.0], [190.0, -1.0], [190.0, 1.0], [170.0, 3.0]];
    let b = [[-190.0, 1.0], [-170.0, 3.0], [-170.0, 9.0], [-190.0, 9.0]];
    for turns in [0.0, 360.0] {
        let b = b.map(|[x, y]| [x + turns, y]);
        let mut crossing = region(&[&a, &b]);
        let latitude = refused_at(&crossing, EdgeRule::Planar);
        assert!((latitude - 2.0).abs() < 1e-12);
        assert_eq!(crossing.split_at_crossings(EdgeRule::Planar), 1);
        assert!(build(&crossing, EdgeRule::Planar).is_ok());
    }
}

#[test]
fn an_edge_along_the_antimeridian_is_crossed_by_one_that_is_cut_there() {
    // From the south-west over the middle of the edge from (180, 5) to (180, -5).
    let ring = [
        [170.0, -2.0],
        [190.0, 2.0],
        [190.0, 5.0],
        [180.0, 5.0],
        [180.0, -5.0],
    ];
    for rule in RULES {
        for ring in &spellings(&ring)[..2] {
            assert!(refused_at(&region(&[ring]), rule).abs() < 1e-12);
            let mut repaired = region(&[ring]);
            assert_eq!(repaired.split_at_crossings(rule), 1, "{}", rule.name());
            let loops: [&[Degrees]; 2] = [
                &[[170.0, -2.0], [180.0, 0.0], [180.0, -5.0]],
                &[[180.0, 0.0], [190.0, 2.0], [190.0, 5.0], [180.0, 5.0]],
            ];
            let found = build(&repaired, rule).expect("repaired").area_m2;
            let expected = area_m2(&loops, rule);
            assert!((found / expected - 1.0).abs() < 1e-9, "{}", rule.name());
        }
        // Negative control: up to the antimeridian and back, the edges only touch.
        let touching = [
            [170.0, -2.0],
            [180.0, 0.0],
            [170.0, 2.0],
            [170.0, 5.0],
            [180.0, 5.0],
            [180.0, -5.0],
        ];
        let mut touching = region(&[&touching]);
        assert!(build(&touching, rule).is_ok());
        assert_eq!(touching.split_at_crossings(rule), 0);
    }
}

#[test]
fn a_seam_along_the_antimeridian_is_crossed_freely() {
    // The whole globe as a rectangle, and parts cut as RFC 7946 wants it: both sides cancel.
    let whole = [
        [-180.0, -90.0],
        [180.0, -90.0],
        [180.0, 90.0],
        [-180.0, 90.0],
    ];
    let [west, east] = [
        [[160.0, -9.0], [180.0, -9.0], [180.0, 9.0], [160.0, 9.0]],
        [[-160.0, -9.0], [-160.0, 9.0], [-180.0, 9.0], [-180.0, -9.0]],
    ];
    let hole = [[170.0, -2.0], [190.0, -2.0], [190.0, 2.0], [170.0, 2.0]];
    let repaired = |rings: &[&[Degrees]]| {
        let mut region = region(rings);
        let crossings = region.split_at_crossings(EdgeRule::Planar);
        (crossings, build(&region, EdgeRule::Planar).is_ok())
    };
    assert_eq!(repaired(&[&whole, &hole]), (0, true));
    assert_eq!(repaired(&[&west, &east, &hole]), (0, true));
    // A vertex on one side at the very latitude of a cut.
    let mut notched = east.to_vec();
    notched.insert(3, [-180.0, 2.0]);
    assert_eq!(repaired(&[&west, &notched, &hole]), (0, true));
    // Negative control: with one side only it is a border, and both its crossings are found.
    assert_eq!(repaired(&[&west, &hole]), (2, true));
}

#[test]
fn what_touches_on_the_antimeridian_is_no_crossing() {
    for rule in RULES {
        // A vertex of both.
        let wings: [&[Degrees]; 2] = [
            &[[170.0, -5.0], [180.0, 0.0], [170.0, 5.0]],
            &[[190.0, 5.0], [180.0, 0.0], [190.0, -5.0]],
        ];
        // Both cut at the same latitude along a common edge.
        let neighbours: [&[Degrees]; 2] = [
            &[[170.0, -5.0], [190.0, 5.0], [170.0, 20.0]],
            &[[190.0, 5.0], [170.0, -5.0], [190.0, -20.0]],
        ];
        for rings in [&wings, &neighbours] {
            let mut region = region(rings);
            assert!(build(&region, rule).is_ok(), "{}", rule.name());
            assert_eq!(region.split_at_crossings(rule), 0);
        }
    }
}

#[test]
fn near_misses_are_told_from_crossings() {
    for rule in RULES {
        for by in [-1e-9, 1e-9] {
            // Two thin wings, apart or over one another by a nanodegree at ±180.
            let wings: [&[Degrees]; 2] = [
                &[[170.0, -5.0], [180.0 + by, 0.0], [170.0, 5.0]],
                &[[190.0, 5.0], [180.0, 0.0], [190.0, -5.0]],
            ];
            let mut wings = region(&wings);
            assert_eq!(build(&wings, rule).is_err(), by > 0.0, "{}", rule.name());
            assert_eq!(wings.split_at_crossings(rule) > 0, by > 0.0);
            // A tie whose knot lies beside the antimeridian crosses all the same.
            let tie = [
                [170.0 + by, -5.0],
                [190.0, 5.0],
                [190.0, -5.0],
                [170.0 + by, 5.0],
            ];
            let mut tie = region(&[&tie]);
            assert!(refused_at(&tie, rule).abs() < 1e-8);
            assert_eq!(tie.split_at_crossings(rule), 1);
            // Open by as much, it does not.
            let half = by.abs();
            let open = [
                [170.0, -5.0],
                [180.0, -half],
                [190.0, -5.0],
                [190.0, 5.0],
                [180.0, half],
                [170.0, 5.0],
            ];
            let mut open = region(&[&open]);
            assert!(build(&open, rule).is_ok(), "{}", rule.name());
            assert_eq!(open.split_at_crossings(rule), 0);
        }
    }
}

#[test]
fn every_crossing_of_a_bundle_through_one_place_is_listed() {
    // Five needles, each from side to side through (180, 0) or a whisker beside it.
    let needles: Vec<[Degrees; 3]> = (1..=5)
        .map(|i| {
            let rise = f64::from(i);
            [[170.0, -rise], [190.0, rise], [190.0, rise + 0.5]]
        })
        .collect();
    let rings: Vec<&[Degrees]> = needles.iter().map(<[Degrees; 3]>::as_slice).collect();
    let region = region(&rings);
    let errors = RegionMesh::build_all(
        std::slice::from_ref(&region),
        &Ellipsoid::WGS84,
        EdgeRule::Planar,
        &MeshOptions::default(),
    )
    .expect_err("needles cross");
    let at_the_middle = errors
        .iter()
        .filter(|error| {
            matches!(error, MeshError::SelfCrossing { longitude_deg, latitude_deg, .. }
                if longitude_deg.abs() == 180.0 && *latitude_deg == 0.0)
        })
        .count();
    // Five edges through one place are ten pairs.
    assert_eq!(at_the_middle, 10, "{errors:?}");
    let mut repaired = region;
    assert!(repaired.split_at_crossings(EdgeRule::Planar) >= 10);
    assert!(build(&repaired, EdgeRule::Planar).is_ok());
}
