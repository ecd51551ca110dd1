// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangulations of groups of rings.

use super::*;
use crate::EdgePlace;

fn closed(vertices: &[Degrees]) -> Vec<OutlineEdge> {
    let next = vertices.iter().cycle().skip(1);
    vertices
        .iter()
        .zip(next)
        .enumerate()
        .map(|(vertex, (start, end))| OutlineEdge {
            start: *start,
            end: *end,
            place: EdgePlace {
                vertex,
                ..EdgePlace::default()
            },
        })
        .collect()
}

fn area(mesh: &GroupMesh) -> f64 {
    let twice: f64 = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
            (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        })
        .sum();
    twice / 2.0
}

fn mesh(edges: &[OutlineEdge], cap_step_deg: f64) -> GroupMesh {
    let options = MeshOptions {
        cap_step_deg,
        ..MeshOptions::default()
    };
    match triangulate(edges.to_vec(), EdgeRule::Planar, &options, Arcs::AsDrawn) {
        Ok(mesh) => mesh,
        Err(TriangulateError::Crossings { found, .. }) => panic!("crossings at {found:?}"),
        Err(TriangulateError::TooFine { points }) => panic!("{points} points"),
        Err(TriangulateError::Refused(message)) => panic!("{message}"),
    }
}

#[test]
fn edges_that_overlap_are_counted_modulo_two() {
    // A square whose right side is also the left side of half a square: the shared half cancels.
    let mut edges = closed(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
    edges.extend(closed(&[[2.0, 0.0], [4.0, 0.0], [4.0, 1.0], [2.0, 1.0]]));
    let mesh = mesh(&edges, 180.0);
    assert_eq!(area(&mesh), 6.0);
    assert_eq!(mesh.boundary.len(), 7);
}

#[test]
fn a_spike_there_and_back_leaves_no_boundary() {
    let spike = [
        [0.0, 0.0],
        [2.0, 0.0],
        [5.0, 0.0],
        [2.0, 0.0],
        [2.0, 2.0],
        [0.0, 2.0],
    ];
    let mesh = mesh(&closed(&spike), 180.0);
    assert_eq!(area(&mesh), 4.0);
    assert_eq!(mesh.boundary.len(), 4);
}

#[test]
fn lattice_and_halving_keep_the_area_and_bound_the_edges() {
    let mut square = Vec::new();
    for (from, to) in [
        ([0, 0], [1, 0]),
        ([1, 0], [1, 1]),
        ([1, 1], [0, 1]),
        ([0, 1], [0, 0]),
    ] {
        for k in 0..10 {
            square.push([0, 1].map(|i| f64::from(2 * (from[i] * (10 - k) + to[i] * k))));
        }
    }
    let edges = closed(&square);
    let coarse = mesh(&edges, 180.0);
    let fine = mesh(&edges, 2.0);
    assert_eq!(area(&coarse), 400.0);
    assert!((area(&fine) - 400.0).abs() < 1e-10);
    assert_eq!((coarse.boundary.len(), fine.boundary.len()), (40, 40));
    let longest = |mesh: &GroupMesh| {
        let sides = mesh
            .triangles
            .iter()
            .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
        sides
            .map(|side| side.map(|i| mesh.vertices[i as usize]))
            .map(|[a, b]| arc_rad(a, b).to_degrees())
            .fold(0.0, f64::max)
    };
    assert!(longest(&fine) <= 3.0 && longest(&coarse) > 10.0);
}

#[test]
fn nothing_is_refined_outside() {
    // A find: the middle of an interior edge came to lie on the outline, and from there edges led
    // outside, round to the part on the other side of ±180. A band of a million points took 90 s.
    let text = r#"{"type":"Polygon","coordinates":[[[179.992,-0.008],
        [180.00099999999978,1.862645149230957e-12],[180.0,0.0070000000000000045],[180.0,0.007]]]}"#;
    let region = crate::parse_regions(text.as_bytes(), "find").expect("valid");
    let body = crate::Ellipsoid::MOON;
    let options = MeshOptions {
        boundary_tolerance_m: 1.7,
        cap_step_deg: 0.01,
    };
    let mut splitter = crate::edge::EdgeSplitter::new(&body, EdgeRule::Planar, &options);
    let outline = crate::outline::Outline::new(&region[0], EdgeRule::Planar, &mut splitter).ok();
    let groups = outline.expect("no opposite ends").groups;
    let edges = crate::snap::snap_rounded(EdgeRule::Planar, &groups).remove(0);
    let mut group = Group::load(&edges).ok().flatten().expect("crosses nowhere");
    group.mesh.find_inside();
    let before = group.mesh.vertex_count();
    group.refine(options.cap_step_deg).ok().expect("refined");
    let added = group.mesh.vertex_count() - before;
    assert!((1..9).contains(&added), "{added}");
}

#[test]
fn points_of_a_step_are_foreseen_and_refused_before_they_fill_the_memory() {
    let box_of =
        |east: f64, north: f64| closed(&[[0.0, 0.0], [east, 0.0], [east, north], [0.0, north]]);
    for (edges, step_deg) in [(box_of(20.0, 20.0), 0.25), (box_of(60.0, 70.0), 1.0)] {
        let group = load_without_false_crossings(edges.clone(), EdgeRule::Planar, Arcs::AsDrawn);
        let mut group = group.ok().expect("a box");
        group.mesh.find_inside();
        let foreseen = group.lattice_points(step_deg);
        let added = group.insert_lattice(step_deg).ok().expect("inserted").len() as f64;
        assert!(
            (0.7..1.5).contains(&(foreseen / added)),
            "{foreseen} {added}"
        );
    }
    let options = MeshOptions {
        cap_step_deg: 0.01,
        ..MeshOptions::default()
    };
    let meshed = |edges| triangulate(edges, EdgeRule::Planar, &options, Arcs::AsDrawn);
    let refused = meshed(box_of(60.0, 60.0));
    assert!(matches!(refused, Err(TriangulateError::TooFine { points }) if points > 2e7));
    // Negative control: a smaller box has room.
    assert!(meshed(box_of(1.0, 1.0)).is_ok());
}

#[test]
fn a_crossing_is_placed_and_a_touch_is_not_a_crossing() {
    let bow_tie = closed(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]);
    match triangulate(
        bow_tie,
        EdgeRule::Planar,
        &MeshOptions::default(),
        Arcs::AsDrawn,
    ) {
        Err(TriangulateError::Crossings { found, complete }) => {
            assert_eq!((found.len(), complete), (1, true));
            assert_eq!((found[0].first.vertex, found[0].second.vertex), (0, 2));
            assert_eq!(found[0].at, [1.0, 1.0]);
        }
        _ => panic!("a bow-tie crosses itself"),
    }
    // Through a common vertex instead: both lobes, by even-odd.
    let touching = [
        [0.0, 0.0],
        [1.0, 1.0],
        [2.0, 2.0],
        [2.0, 0.0],
        [1.0, 1.0],
        [0.0, 2.0],
    ];
    assert_eq!(area(&mesh(&closed(&touching), 180.0)), 2.0);
}
