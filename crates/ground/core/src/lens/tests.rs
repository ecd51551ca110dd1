// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lenses between arcs and their chords: which vertices lie in them.

use super::*;
use crate::triangulate::{Arcs, triangulate};
use crate::{EdgePlace, MeshOptions};
use std::collections::BTreeMap;

fn edges(places: &[Degrees]) -> Vec<OutlineEdge> {
    let next = places.iter().cycle().skip(1);
    let edge = |(start, end): (&Degrees, &Degrees)| OutlineEdge {
        start: *start,
        end: *end,
        place: EdgePlace::default(),
    };
    places.iter().zip(next).map(edge).collect()
}

fn places(edges: &[OutlineEdge]) -> Vec<Degrees> {
    edges.iter().map(|edge| edge.start).collect()
}

const WEST: Degrees = [0.0, 50.0];
const EAST: Degrees = [20.0, 50.0];

#[test]
fn an_arc_is_split_at_the_foot_of_a_vertex_in_its_lens() {
    // Of the arc's 0.43° above its chord.
    let middle = point_on_edge(EdgeRule::GreatEllipse, WEST, EAST, 0.5);
    for below_deg in [0.4, 1e-3, 1e-9] {
        let vertex = [middle[0] + 0.7, middle[1] - below_deg - 0.003];
        let split = follow_arcs(edges(&[WEST, EAST, vertex]), WithinRounding::Kept);
        let made = places(&split);
        let lens = Lens::of(WEST, EAST).expect("bows");
        let on_arc = |place: &Degrees| {
            let share = lens.share_of(*place)?;
            Some(arc_rad(lens.place(share), *place) < 1e-15)
        };
        let foot = made[1];
        assert_eq!(made[0], WEST);
        assert_eq!(on_arc(&foot), Some(true));
        // At right angles to the arc, which is level there.
        assert!((foot[0] - vertex[0]).abs() < 0.02, "{foot:?}");
        // Negative control: the vertex is not.
        assert_eq!(on_arc(&vertex), Some(false));
    }
    // Negative controls: beyond the arc, and on the other side of the chord.
    for latitude in [middle[1] + 1e-3, 49.999] {
        let same = edges(&[WEST, EAST, [middle[0], latitude]]);
        let split = follow_arcs(same.clone(), WithinRounding::Kept);
        assert_eq!(places(&split), places(&same));
    }
}

#[test]
fn an_arc_and_its_reverse_are_split_at_the_same_places() {
    let inside = [[3.0, 50.1], [7.0, 50.2], [16.0, 50.05], [8.0, 50.01]];
    let there = [&[WEST, EAST], inside.as_slice()].concat();
    let mut back = there.clone();
    back.reverse();
    for near in [WithinRounding::Kept, WithinRounding::Merged] {
        let [mut there, mut back] =
            [&there, &back].map(|ring| places(&follow_arcs(edges(ring), near)));
        assert!(there.len() > 6, "{}", there.len());
        there.sort_by(|a, b| a[0].total_cmp(&b[0]));
        back.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert_eq!(there, back);
    }
}

#[test]
fn an_arc_past_a_pole_has_feet_at_the_longitude_of_its_end() {
    let lens = Lens::of([10.9999, 90_f64.next_down()], [11.0, 89.0]).expect("bows");
    let foot_of = |vertex| lens.foot_of(vertex, WithinRounding::Kept);
    let feet = (10..90).map(|percent| {
        let latitude = 89.0 + 0.01 * f64::from(percent);
        let (_, foot) = foot_of([10.999_999, latitude]).expect("in the lens");
        foot[0]
    });
    // Where rounding does not carry it to the west.
    let at_the_end = feet.filter(|longitude| *longitude == 11.0).count();
    assert!(at_the_end > 10, "{at_the_end}");
    // Negative control: beyond the chord.
    assert_eq!(foot_of([10.999_93, 89.5]), None);
    // Merged, nothing of an edge to the pole leaves its meridian.
    let polar = edges(&[[10.1, 90.0], [10.1, 89.999_92]])[0];
    assert_eq!(merged(vec![polar])[0].start, polar.start);
    assert_eq!(merged(vec![polar])[0].end, polar.end);
    // Negative control: of another edge it does.
    let free = edges(&[[10.1, 89.999_92], [10.2, 89.9]])[0];
    assert_ne!(merged(vec![free])[0].start, free.start);
}

#[test]
fn what_ends_at_a_pole_keeps_its_longitude() {
    // Beside the pole a tenth of a degree of longitude is less than rounding.
    let beside = [10.0, 89.999_999_999_986_7];
    let meridian = |longitude: f64| edges(&[[longitude, 90.0], [longitude, 89.9]])[0];
    let other = edges(&[beside, [10.2, 89.9]])[0];
    let made = |edge: OutlineEdge| {
        let split = split_on_arcs(&[edge, other], &[([0, 1], beside)], WithinRounding::Kept);
        places(&split)
    };
    assert_eq!(made(meridian(10.1))[1], [10.1, beside[1]]);
    // Negative control: of what does not end there the common place is taken.
    let level = edges(&[[9.9, beside[1]], [10.1, beside[1]]])[0];
    assert_eq!(made(level)[1], beside);
}

#[test]
fn arcs_that_are_one_to_rounding_become_one() {
    // There and back between ends that are a few last bits apart, six times.
    let beside = |k: u32| 4e-14 * f64::from(k);
    let ring: Vec<Degrees> = (0..6)
        .flat_map(|k| {
            [
                [WEST[0], WEST[1] + beside(k)],
                [EAST[0] + beside(k), EAST[1] - beside(k % 3)],
            ]
        })
        .collect();
    let halved = edges(&ring).into_iter().flat_map(|edge| {
        let middle = point_on_edge(EdgeRule::GreatEllipse, edge.start, edge.end, 0.5);
        edges(&[edge.start, middle, edge.end]).into_iter().take(2)
    });
    let halved: Vec<OutlineEdge> = halved.collect();
    // Ends of edges that an odd number of edges joins.
    let left = |edges: Vec<OutlineEdge>| {
        let bits = |place: Degrees| place.map(f64::to_bits);
        let mut uses: BTreeMap<[[u64; 2]; 2], usize> = BTreeMap::new();
        for edge in edges {
            let (a, b) = in_order(edge.start, edge.end);
            *uses.entry([bits(a), bits(b)]).or_default() += 1;
        }
        uses.into_values().filter(|uses| uses % 2 == 1).count()
    };
    assert_eq!(left(follow_arcs(halved.clone(), WithinRounding::Merged)), 0);
    // Negative control: each stays another.
    let kept = follow_once(halved, WithinRounding::Kept).unwrap_or_else(|crossing| crossing);
    assert!(left(kept) > 10);
}

#[test]
fn very_many_arcs_in_one_lens_cost_no_more_than_they_are_allowed() {
    for near in [WithinRounding::Kept, WithinRounding::Merged] {
        for count in [10_u32, 3_000] {
            let tooth = |k: u32| {
                let share = f64::from(k) / f64::from(count);
                [
                    [7.0 * share, 50.0 + 0.1 * share],
                    [20.0 - 6.0 * share, 50.0 + 0.1 * share],
                ]
            };
            let comb: Vec<Degrees> = (0..count).flat_map(tooth).collect();
            let edges = edges(&comb);
            let most = MAX_PARTS * edges.len().max(SMALL_GROUP);
            let made = follow_arcs(edges, near).len();
            assert!((comb.len() + 10..=most).contains(&made), "{made} of {most}");
        }
    }
}

#[test]
fn what_lies_in_one_cell_vanishes() {
    let bits = |k: u32| 1e-14 * f64::from(k);
    let ring: Vec<Degrees> = (0..5).map(|k| [7.0, 50.0 + bits(k)]).collect();
    let left = follow_arcs(edges(&ring), WithinRounding::Merged);
    assert!(left.is_empty());
    let mesh = triangulate(
        left,
        EdgeRule::GreatEllipse,
        &MeshOptions::default(),
        Arcs::Settled,
    );
    assert!(mesh.is_ok_and(|mesh| mesh.triangles.is_empty()));
    // Negative control: unless it may not be moved, since it would come onto a pole.
    let at_pole = [[7.0, 90_f64.next_down()], [8.0, 90_f64.next_down()]];
    assert_eq!(merged(edges(&at_pole)).len(), 2);
}
