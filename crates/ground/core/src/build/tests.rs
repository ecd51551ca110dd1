// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes of regions: what speaks for or against building them.

use super::*;
use crate::{Ring, ShapeFamily};

fn groups(region: &Region) -> Vec<TriangulatedGroup> {
    let (body, rule, options) = (Ellipsoid::WGS84, EdgeRule::Planar, MeshOptions::default());
    let mut splitter = EdgeSplitter::new(&body, rule, &options);
    let Ok(outline) = Outline::new(region, rule, &mut splitter) else {
        panic!("planar edges have no opposite ends");
    };
    let groups = outline
        .groups
        .into_iter()
        .map(|edges| (edges, Arcs::AsDrawn));
    let groups = triangulate_groups(region, &body, rule, &options, groups.collect(), Vec::new());
    groups.expect("crosses nowhere")
}

/// Groups of which overlaps and shared edges are looked for.
fn searched(groups: &[TriangulatedGroup]) -> usize {
    let searched = groups
        .iter()
        .filter(|group| group.in_doubt || group.is_joined);
    searched.count()
}

/// `−∮ (φ − φ₀) dλ` and the sum of its terms' sizes, added up as they come.
fn plain_area(edges: impl Iterator<Item = [Degrees; 2]>, reference: f64) -> [f64; 2] {
    let term = |[start, end]: [Degrees; 2]| {
        0.5 * ((start[1] - reference) + (end[1] - reference)) * (start[0] - end[0])
    };
    edges.fold([0.0, 0.0], |[sum, scale], edge| {
        [sum + term(edge), scale + term(edge).abs()]
    })
}

#[test]
fn very_many_holes_are_not_searched_for_overlaps() {
    let text = ShapeFamily::Holes.geojson(300_000);
    let mut regions = crate::parse_regions(text.as_bytes(), "holes").expect("valid");
    let mut region = regions.remove(0);
    assert!(region.vertex_count() > 290_000 && region.rings().count() > 37_000);
    let found = groups(&region);
    assert_eq!((searched(&found), found.len()), (0, 1));
    // Negative control: by plain sums it would have been.
    let mesh = &found[0].mesh;
    let boundary = mesh
        .boundary
        .iter()
        .map(|ends| ends.map(|i| mesh.vertices[i as usize]));
    let [together, terms] = plain_area(boundary, mesh.vertices[0][1]);
    let (mut one_by_one, mut scale) = (0.0, 0.0);
    for (index, ring) in region.rings().enumerate() {
        let edges = ring.edges_deg().map(|(start, end)| [start, end]);
        let [area, terms] = plain_area(edges, ring.vertices_deg()[0][1]);
        one_by_one += if index == 0 { area.abs() } else { -area.abs() };
        scale += terms;
    }
    let difference = (one_by_one - together.abs()).abs();
    assert!(difference > 1e-14 * (scale + terms), "{difference}");
    // Negative control: one hole, a 37,000th of them, outside of the shell.
    let outside = |[x, y]: Degrees| [x + 40.0, y];
    let hole = region.polygons[0].holes.pop().expect("holes");
    let moved = hole.vertices_deg().iter().copied().map(outside).collect();
    let moved = Ring::from_checked(moved, 0.0);
    region.polygons[0].holes.push(moved);
    assert_eq!(searched(&groups(&region)), 1);
}

#[test]
fn a_vertex_outside_moves_the_nearer_end_of_an_extent() {
    let extent = |west_deg, east_deg| Extent {
        west_deg,
        south_deg: -10.0,
        east_deg,
        north_deg: 10.0,
    };
    let widened = |mut extent: Extent, position| {
        widen(&mut extent, position);
        [
            extent.west_deg,
            extent.south_deg,
            extent.east_deg,
            extent.north_deg,
        ]
    };
    for (west, east) in [(20.0, 30.0), (170.0, -170.0)] {
        let as_it_was = [west, -10.0, east, 10.0];
        let at = |position| widened(extent(west, east), position);
        assert_eq!(at([east + 1e-9, 11.0]), [west, -10.0, east + 1e-9, 11.0]);
        assert_eq!(at([west - 1e-9, -11.0]), [west - 1e-9, -11.0, east, 10.0]);
        // Negative controls: within it, and where longitudes say nothing.
        assert_eq!(at([west + 1.0, 0.0]), as_it_was);
        assert_eq!(at([-180.0, 0.0]), as_it_was);
        assert_eq!(at([0.0, 90.0]), [west, -10.0, east, 90.0]);
    }
}
