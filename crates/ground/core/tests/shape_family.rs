// SPDX-License-Identifier: MIT OR Apache-2.0
//! The shapes that growth is measured on are what they are called, at any size.

use terrafill_core::{EdgeRule, Ellipsoid, MeshOptions, RegionMesh, ShapeFamily, parse_regions};

#[test]
fn every_family_has_about_the_vertices_asked_for_and_meshes() {
    let body = Ellipsoid::WGS84;
    for family in ShapeFamily::ALL {
        for asked in [1_000, 3_000] {
            let text = family.geojson(asked);
            let regions = parse_regions(text.as_bytes(), family.name()).expect("valid");
            let found = regions[0].vertex_count();
            assert!(
                found.abs_diff(asked as usize) <= 8,
                "{}: {found}",
                family.name()
            );
            let mesh = RegionMesh::build(
                &regions[0],
                &body,
                EdgeRule::Planar,
                &MeshOptions::default(),
            )
            .expect("meshes");
            assert_eq!(mesh.check_invariants(&body), Ok(()));
            // Growth is by the vertices of the file, so the mesh must not make many of its own; but
            // where edges are to be split, they are.
            let edges = mesh.boundary_edge_count();
            let is_split = matches!(
                family,
                ShapeFamily::LongComb | ShapeFamily::TurnedComb | ShapeFamily::Star
            );
            let parts = if is_split { 4 } else { 2 };
            assert!(!is_split || edges > found + found / 5);
            assert!(
                edges < parts * found + 2_000,
                "{}: {edges} edges",
                family.name()
            );
            assert_eq!(text, family.geojson(asked));
            // Negative control: another number is another shape.
            assert_ne!(text, family.geojson(asked + 16));
        }
    }
}
