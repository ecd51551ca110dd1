// SPDX-License-Identifier: MIT OR Apache-2.0
//! Indices against brute force, the two inside tests against one another, and exactness where
//! plain f64 fails.

use super::{TestRing, locator, star, try_locator};
use crate::point::LocatorError;
use terrafill_core::EdgeRule;
use terrafill_fixtures::Random;

const RULES: [EdgeRule; 2] = [EdgeRule::Planar, EdgeRule::GreatEllipse];

/// Stars of all sizes in all places: over the antimeridian, and for great ellipses over poles.
fn stars(random: &mut Random, rule: EdgeRule) -> Vec<TestRing> {
    let mut rings: Vec<TestRing> = Vec::new();
    for (region, radius) in [(0, 0.001), (1, 0.1), (2, 3.0), (3, 20.0), (4, 60.0)] {
        for _ in 0..4 {
            let place = random.place();
            let latitude = if rule == EdgeRule::Planar {
                place[1].clamp(radius - 90.0, 90.0 - radius)
            } else {
                place[1].clamp(-75.0, 75.0)
            };
            let mut star = star(random, [place[0], latitude], radius, 200);
            for vertex in &mut star {
                vertex[1] = vertex[1].clamp(-90.0, 90.0);
            }
            rings.push((region, star, 0.0));
        }
    }
    if rule == EdgeRule::Planar {
        let mut coast: Vec<[f64; 2]> = (0..500)
            .map(|i| [f64::from(i) * 0.72 - 180.0, -60.0 - 20.0 * random.share()])
            .collect();
        rings.push((5, coast.clone(), 360.0));
        coast.reverse();
        for vertex in &mut coast {
            vertex[1] = -vertex[1] - 1.0;
        }
        rings.push((6, coast, -360.0));
    }
    rings
}

/// Random places, and places around the rings' own vertices.
fn places(random: &mut Random, rings: &[TestRing]) -> Vec<[f64; 2]> {
    let mut places: Vec<[f64; 2]> = (0..4000).map(|_| random.place()).collect();
    for (_, vertices, _) in rings {
        let center: [f64; 2] = [0, 1].map(|axis| {
            vertices.iter().map(|vertex| vertex[axis]).sum::<f64>() / vertices.len() as f64
        });
        for vertex in vertices {
            let share = 1.3 * random.share();
            places.push([0, 1].map(|axis| center[axis] + share * (vertex[axis] - center[axis])));
        }
        places.push(vertices[0]);
        places.push(center);
    }
    places.extend([
        [0.0, 90.0],
        [0.0, -90.0],
        [180.0, 0.0],
        [-180.0, 0.0],
        [540.0, 10.0],
    ]);
    places.retain(|place| place[1].abs() <= 90.0);
    places
}

#[test]
fn the_index_gives_what_brute_force_gives() {
    for rule in RULES {
        for seed in 0..3 {
            let mut random = Random(seed);
            let rings = stars(&mut random, rule);
            let located = locator(&rings, rule);
            let mut held = 0;
            for place in places(&mut random, &rings) {
                let found = located.locate(place[0], place[1]);
                let brute = located.locate_brute(place[0], place[1]);
                assert_eq!(found, brute, "{rule:?} {seed} {place:?}");
                held += found.regions.len();
            }
            // The check is worth something only where points lie on both sides.
            assert!((1000..20_000).contains(&held), "{held}");
        }
    }
}

#[test]
fn the_two_tests_differ_nowhere_but_on_edges() {
    for rule in RULES {
        let mut random = Random(7);
        let rings = stars(&mut random, rule);
        let located = locator(&rings, rule);
        for _ in 0..50_000 {
            let place = random.place();
            assert!(
                located.locate(place[0], place[1]).disagree.is_empty(),
                "{rule:?} {place:?}"
            );
        }
    }
}

#[test]
fn vertex_order_and_whole_turns_change_nothing() {
    for rule in RULES {
        let mut random = Random(11);
        let rings = stars(&mut random, rule);
        let mut changed = rings.clone();
        for (_, vertices, winding_deg) in &mut changed {
            if *winding_deg == 0.0 {
                vertices.reverse();
                for vertex in vertices.iter_mut() {
                    vertex[0] += 360.0;
                }
            }
        }
        let (before, after) = (locator(&rings, rule), locator(&changed, rule));
        for place in places(&mut random, &rings[..20]) {
            let at = |located: &crate::Locator| located.locate(place[0], place[1]).regions;
            // Places on a vertex itself are within rounding of the moved ring's edges.
            if before.locate(place[0], place[1]).disagree.is_empty()
                && !rings.iter().any(|ring| ring.1.contains(&place))
            {
                assert_eq!(at(&before), at(&after), "{rule:?} {place:?}");
            }
        }
    }
}

/// Two triangles on both sides of a slanted edge, and points within a few units in the last place
/// of that edge.
fn shared_edge() -> (Vec<TestRing>, Vec<[f64; 2]>) {
    let (a, b) = ([12.0, 12.0], [24.0, 24.0]);
    let rings = vec![
        (0, vec![a, b, [10.0, 30.0]], 0.0),
        (1, vec![b, a, [30.0, 10.0]], 0.0),
    ];
    let mut points = Vec::new();
    for i in 0..64 {
        for j in 0..64 {
            let step = f64::from(2_f32.powi(-43));
            points.push([17.5 + f64::from(i) * step, 17.5 + f64::from(j) * step]);
        }
    }
    (rings, points)
}

#[test]
fn points_along_a_shared_edge_belong_to_exactly_one_side_by_the_exact_test() {
    for rule in RULES {
        let (rings, points) = shared_edge();
        let located = locator(&rings, rule);
        let mut sides = [0; 2];
        for point in &points {
            let regions = located.locate(point[0], point[1]).regions;
            assert_eq!(regions.len(), 1, "{rule:?} {point:?} {regions:?}");
            sides[regions[0]] += 1;
        }
        if rule == EdgeRule::Planar {
            // The diagonal of the grid lies on the edge: half of the rest on either side. On the
            // diagonal the edge is not to the north, so it belongs to the side north of it.
            assert_eq!(sides, [64 * 65 / 2, 64 * 63 / 2]);
        }
    }
}

#[test]
fn a_point_within_rounding_of_an_edge_is_reported() {
    // Positive control of the disagreement count: an edge with no exact slope, and points on it
    // as near as doubles get.
    for rule in RULES {
        let rings = vec![(0, vec![[0.1, 0.1], [33.3, 7.7], [20.0, 40.0]], 0.0)];
        let located = locator(&rings, rule);
        let mut reported = 0;
        for i in 1..2000 {
            let share = f64::from(i) / 2000.0;
            let (from, to) = (
                crate::point::normal(0.1, 0.1),
                crate::point::normal(33.3, 7.7),
            );
            let place = if rule == EdgeRule::Planar {
                [0.1 + share * 33.2, 0.1 + share * 7.6]
            } else {
                let on_arc = from.lerp(to, share);
                let latitude = on_arc.z.atan2(on_arc.x.hypot(on_arc.y));
                [on_arc.y.atan2(on_arc.x).to_degrees(), latitude.to_degrees()]
            };
            reported += located.locate(place[0], place[1]).disagree.len();
        }
        assert!((10..1990).contains(&reported), "{rule:?}: {reported}");
    }
}

#[test]
fn rings_that_leave_their_inside_open_are_refused() {
    let refused = |vertices: Vec<[f64; 2]>, winding: f64, rule: EdgeRule| {
        try_locator(&[(0, vertices, winding)], rule).err()
    };
    let triangle = vec![[0.0, 0.0], [10.0, 0.0], [0.0, 10.0]];
    for rule in RULES {
        assert_eq!(refused(triangle.clone(), 0.0, rule), None);
    }
    assert!(matches!(
        refused(triangle, 720.0, EdgeRule::Planar),
        Some(LocatorError::Winding { .. })
    ));
    assert!(matches!(
        refused(
            vec![[0.0, 0.0], [361.0, 0.0], [0.0, 10.0]],
            0.0,
            EdgeRule::Planar
        ),
        Some(LocatorError::WiderThanATurn { .. })
    ));
    assert!(matches!(
        refused(
            vec![[800.0, 0.0], [810.0, 0.0], [800.0, 10.0]],
            0.0,
            EdgeRule::Planar
        ),
        Some(LocatorError::LongitudeOutOfRange { .. })
    ));
    // From pole to pole, and over the equator's middle, on no plane in particular.
    for vertices in [
        vec![[0.0, -90.0], [0.0, 90.0], [30.0, 0.0]],
        vec![[10.0, 5.0], [190.0, -5.0], [100.0, 60.0]],
    ] {
        let error = refused(vertices, 0.0, EdgeRule::GreatEllipse);
        assert!(
            matches!(error, Some(LocatorError::OppositeEnds { vertex: 0, .. })),
            "{error:?}"
        );
    }
    // Negative control: a hair off, the plane is known.
    let near = vec![[10.0, 5.0], [190.0, -5.1], [100.0, 60.0]];
    assert_eq!(refused(near, 0.0, EdgeRule::GreatEllipse), None);
    // Almost a hemisphere is taken.
    let cap: Vec<[f64; 2]> = (0..90).map(|i| [f64::from(i) * 4.0, 0.1]).collect();
    let located = locator(&[(0, cap, 0.0)], EdgeRule::GreatEllipse);
    assert_eq!(located.locate(33.0, 0.2).regions, [0]);
    assert!(located.locate(33.0, 0.0).regions.is_empty());
}

#[test]
fn positions_that_are_none_are_in_no_region() {
    let rings = vec![(0, super::rectangle(-180.0, -90.0, 180.0, 90.0), 0.0)];
    let located = locator(&rings, EdgeRule::Planar);
    assert_eq!(located.locate(0.0, 0.0).regions, [0]);
    assert_eq!(located.locate(180.0, 90.0).regions, [0]);
    for place in [
        [f64::NAN, 0.0],
        [0.0, f64::NAN],
        [f64::INFINITY, 0.0],
        [0.0, 90.1],
    ] {
        assert_eq!(
            located.locate(place[0], place[1]),
            crate::Location::default()
        );
    }
}

#[test]
fn parts_cut_at_the_antimeridian_meet_without_a_gap() {
    for rule in RULES {
        // The parts' vertices on the cut are at different latitudes.
        let rings = vec![
            (
                0,
                vec![
                    [170.0, 50.0],
                    [180.0, 48.0],
                    [180.0, 61.0],
                    [180.0, 70.0],
                    [170.0, 70.0],
                ],
                0.0,
            ),
            (
                0,
                vec![
                    [-180.0, 48.0],
                    [-170.0, 50.0],
                    [-170.0, 70.0],
                    [-180.0, 70.0],
                ],
                0.0,
            ),
        ];
        let located = locator(&rings, rule);
        for i in 0..400 {
            let latitude = 50.0 + f64::from(i) * 0.049;
            for longitude in [
                180.0,
                -180.0,
                540.0,
                180.0_f64.next_down(),
                (-180.0_f64).next_up(),
            ] {
                let found = located.locate(longitude, latitude).regions;
                assert_eq!(found, [0], "{rule:?} {longitude} {latitude}");
            }
        }
        // Negative control: a gap of a metre is not closed.
        let mut apart = rings;
        for vertex in &mut apart[1].1 {
            vertex[0] += 1e-5;
        }
        assert!(
            locator(&apart, rule)
                .locate(-180.0 + 5e-6, 60.0)
                .regions
                .is_empty()
        );
    }
}

#[test]
fn a_fan_of_triangles_leaves_no_place_without_an_owner_and_gives_none_two() {
    for rule in RULES {
        for middle in [[20.3, 31.7], [180.0, 10.0], [0.0, 0.0]] {
            // Spokes to the north and south lie on the meridian itself.
            let rim: Vec<[f64; 2]> = (0..12)
                .map(|i| {
                    let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 12.0).sin_cos();
                    let cos = if i % 6 == 3 { 0.0 } else { cos };
                    [middle[0] + 9.0 * cos, middle[1] + 9.0 * sin]
                })
                .collect();
            let rings: Vec<TestRing> = (0..12)
                .map(|i| (i, vec![middle, rim[i], rim[(i + 1) % 12]], 0.0))
                .collect();
            let located = locator(&rings, rule);
            let owners = |place: [f64; 2]| located.locate(place[0], place[1]).regions.len();
            assert_eq!(owners(middle), 1, "{rule:?} {middle:?}");
            for spoke in &rim {
                for i in 1..200 {
                    let share = f64::from(i) / 200.0;
                    let place = [0, 1].map(|k| middle[k] + share * (spoke[k] - middle[k]));
                    assert_eq!(owners(place), 1, "{rule:?} {place:?}");
                }
            }
            // Negative control: with one triangle missing, its places have no owner.
            let missing = locator(&rings[1..], rule);
            let inside = [0, 1].map(|k| (middle[k] + rim[0][k] + rim[1][k]) / 3.0);
            assert!(missing.locate(inside[0], inside[1]).regions.is_empty());
            assert_eq!(owners(inside), 1);
        }
    }
}
