// SPDX-License-Identifier: MIT OR Apache-2.0
//! Strips over meshes of every kind, and strips that are broken.

use super::*;
use crate::layout::tests::{annulus, planar, real_meshes};
use std::collections::BTreeSet;

/// In the order of [`Upward::place`].
const WAYS: [Upward; 4] = [
    Upward::Ends,
    Upward::Turns(1),
    Upward::Turns(2),
    Upward::Closed,
];

/// Triangles of strips as Vulkan makes them ("Triangle Strips"), those with equal corners left
/// out; `odd` are the places of the last two corners in every second one.
fn triangles_of(strips: &Strips, odd: [usize; 2]) -> Vec<[u32; 3]> {
    let of_strip = |strip: &[StripCorner]| -> Vec<[u32; 3]> {
        let windows = strip.windows(3).enumerate();
        let corners = windows.map(|(i, window)| {
            let [second, third] = if i % 2 == 0 { [1, 2] } else { odd };
            [0, second, third].map(|place| window[place].vertex)
        });
        corners.collect()
    };
    let all = strips.iter().flat_map(of_strip);
    all.filter(|[a, b, c]| a != b && b != c && c != a).collect()
}

/// The same triangles, whichever corner they begin with.
fn turned(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let smallest_first =
        |&[a, b, c]: &[u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min();
    let mut turned: Vec<_> = triangles.iter().filter_map(smallest_first).collect();
    turned.sort_unstable();
    turned
}

#[test]
fn every_triangle_is_in_one_strip_with_its_winding() {
    let mut meshes = real_meshes();
    meshes.extend([3, 4, 10, 101].map(annulus));
    meshes.push(planar(&[], &[]));
    let mut would_differ = 0;
    for mesh in &meshes {
        let strips = Strips::over(&Neighbours::of(mesh));
        let found = turned(&triangles_of(&strips, [2, 1]));
        assert_eq!(found, turned(&mesh.triangles), "{}", mesh.name);
        // Negative control: every second triangle wound like the others.
        let wrong = turned(&triangles_of(&strips, [1, 2]));
        would_differ += usize::from(wrong != found);
    }
    // A region of one triangle after the other has none that is second.
    assert!(would_differ + 2 >= meshes.len(), "{would_differ}");
}

#[test]
fn counting_finds_what_writing_does() {
    let mut meshes = real_meshes();
    meshes.extend([3, 4, 5, 10, 11, 101].map(annulus));
    meshes.push(planar(&[], &[]));
    let mut not_free = 0;
    for mesh in &meshes {
        let neighbours = Neighbours::of(mesh);
        let strips = Strips::over(&neighbours);
        let counts = strip_counts(mesh);
        assert_eq!(counts.strips, strips.ends.len(), "{}", mesh.name);
        assert_eq!(counts.corners(), strips.corners.len(), "{}", mesh.name);
        let forest = Forest::over(&neighbours);
        for triangle in 0..mesh.triangle_count() {
            let best = WAYS.map(|upward| forest.links(triangle).best(upward).0);
            assert_eq!(forest.costs[triangle], best, "{}", mesh.name);
        }
        // Negative control: by the paths' cost alone a first turn that is free from neither end is missing.
        let cost = Paths::over(&neighbours).cost as usize;
        not_free += counts.repeated + STRIP_COST as usize * counts.strips - cost;
    }
    assert!(not_free > 10, "{not_free}");
}

#[test]
fn strips_stop_at_walls_and_at_what_is_behind() {
    // Two triangles with a wall on the side between them, as where a loop runs along both.
    let triangles = [[0, 1, 2], [2, 1, 3]];
    let open = planar(&triangles, &[&[0, 1, 3, 2]]);
    let walled = planar(&triangles, &[&[0, 1, 2], &[2, 1, 3]]);
    // One triangle and the same from behind.
    let folded = planar(&[[0, 1, 2], [2, 1, 0]], &[]);
    for (mesh, strips) in [(open, 1), (walled, 2), (folded, 2)] {
        assert_eq!(strip_counts(&mesh).strips, strips, "{:?}", mesh.triangles);
    }
}

#[test]
fn zigzags_repeat_no_corner_and_fans_nearly_every_one() {
    for count in 1..12 {
        let zigzag: Vec<[u32; 3]> = (0..count)
            .map(|i| {
                if i % 2 == 0 {
                    [i, i + 1, i + 2]
                } else {
                    [i, i + 2, i + 1]
                }
            })
            .collect();
        let fan: Vec<[u32; 3]> = (0..count).map(|i| [0, i + 1, i + 2]).collect();
        let repeated = |triangles| {
            let counts = strip_counts(&planar(triangles, &[]));
            assert_eq!((counts.triangles, counts.strips), (count as usize, 1));
            counts.repeated
        };
        assert_eq!(repeated(&zigzag), 0, "{count}");
        // The first and the last triangle turn nowhere, and the first turn may be free.
        assert_eq!(
            repeated(&fan),
            (count as usize).saturating_sub(3),
            "{count}"
        );
    }
}

/// Triangles of a convex polygon of `count` corners, split at the whim of `random`.
fn polygon(count: u32, random: &mut impl FnMut(u32) -> u32) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    let mut parts = vec![(0, count - 1)];
    while let Some((from, to)) = parts.pop() {
        if to - from >= 2 {
            let between = from + 1 + random(to - from - 1);
            triangles.push([from, between, to]);
            parts.extend([(from, between), (between, to)]);
        }
    }
    triangles
}

/// Fewest indices, but for what first turns cost, of all ways to join neighbours to paths.
fn fewest_indices(neighbours: &Neighbours<'_>) -> usize {
    let count = neighbours.triangles.len();
    let all = (0..count).flat_map(|triangle| [0, 1, 2].map(|number| Side { triangle, number }));
    let joints: Vec<(Side, Side)> = all
        .filter_map(|side| Some((side, neighbours.beyond(side)?)))
        .filter(|(side, back)| side.triangle < back.triangle)
        .collect();
    let cost_of = |chosen: u32| {
        let mut goes_on = vec![[false; 3]; count];
        for (bit, (side, back)) in joints.iter().enumerate() {
            if chosen & (1 << bit) != 0 {
                goes_on[side.triangle][side.number] = true;
                goes_on[back.triangle][back.number] = true;
            }
        }
        let paths = Paths {
            goes_on,
            top: Vec::new(),
            cost: 0,
        };
        let is_path = paths
            .goes_on
            .iter()
            .all(|on| on.iter().filter(|&&on| on).count() < 3);
        let mut path = Vec::new();
        let mut cost = 0;
        for triangle in (0..count).filter(|&triangle| is_path && paths.ends_at(triangle)) {
            paths.walk(neighbours, triangle, &mut path);
            let other_end = path.last().map_or(triangle, |step| step.triangle);
            if triangle <= other_end {
                let turns: Vec<_> = path.iter().filter_map(Step::turn).collect();
                let same = turns.windows(2).filter(|pair| pair[0] == pair[1]).count();
                cost += 3 + same;
            }
        }
        is_path.then_some(cost)
    };
    let least = (0..1_u32 << joints.len()).filter_map(cost_of).min();
    count + least.expect("apart they are paths")
}

#[test]
fn over_a_tree_no_other_strips_take_fewer_indices() {
    let mut state = 1_u64;
    let mut random = |below: u32| {
        // Knuth's MMIX constants.
        state = state.wrapping_mul(6_364_136_223_846_793_005);
        state = state.wrapping_add(1_442_695_040_888_963_407);
        u32::try_from((state >> 33) % u64::from(below)).expect("below it")
    };
    let mut branched = 0;
    for round in 0..300 {
        let triangles = polygon(3 + round % 9, &mut random);
        let mesh = planar(&triangles, &[]);
        let neighbours = Neighbours::of(&mesh);
        let paths = Paths::over(&neighbours);
        let counts = strip_counts(&mesh);
        let found = counts.triangles + 3 * counts.strips + counts.repeated;
        let least = fewest_indices(&neighbours);
        // A strip whose first turn is the other one at both ends repeats a corner for it.
        assert!(
            (least..=least + counts.strips).contains(&found),
            "{found}, {least}"
        );
        let mut path = Vec::new();
        let ends: Vec<usize> = (0..triangles.len()).filter(|&t| paths.ends_at(t)).collect();
        let longest = ends.iter().map(|&end| {
            paths.walk(&neighbours, end, &mut path);
            path.len()
        });
        branched += usize::from(longest.max() < Some(triangles.len()));
        // Negative control: each triangle for itself is too much, where there are two.
        let apart = 4 * triangles.len();
        let allowed = least..=least + triangles.len();
        assert!(triangles.len() < 2 || !allowed.contains(&apart), "{least}");
    }
    assert!(branched > 50, "hardly a choice to make: {branched}");
}

#[test]
fn real_regions_take_less_than_two_indices_a_triangle() {
    let counts: Vec<StripCounts> = real_meshes().iter().map(strip_counts).collect();
    let sum = |of: fn(&StripCounts) -> usize| counts.iter().map(of).sum::<usize>();
    let triangles = sum(|counts| counts.triangles);
    let indices = triangles + 3 * sum(|counts| counts.strips) + sum(|counts| counts.repeated);
    let each = indices as f64 / triangles as f64;
    eprintln!("{each:.3} indices a triangle");
    assert!(each < 1.8, "{each}");
    // What no strips can do without, one corner a triangle, is far from all.
    let names: BTreeSet<usize> = counts.iter().map(|counts| counts.strips).collect();
    assert!(each > 1.2 && names.len() > 10, "{each}");
}
