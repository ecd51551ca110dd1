// SPDX-License-Identifier: MIT OR Apache-2.0
//! Large regions drawn in parts: in which order their triangles lie.

use crate::{IndexOrder, Layout, VertexVariant, cache_ordered};
use terrafill_core::{RegionMesh, index_u32};
use terrafill_plan::PartOrder;
use terrafill_stencil::WallIndices;

impl VertexVariant {
    /// How many indices walls take.
    pub(crate) fn wall_indices(&self) -> WallIndices {
        match self.layout {
            Layout::Pulled => WallIndices::PULLED,
            _ if self.has_strips() => WallIndices::STRIP,
            _ => WallIndices::LIST,
        }
    }
}

/// Triangles part by part, and in the order of the variant within each; `None` where the mesh is drawn whole.
pub(crate) fn ordered_by_part(variant: &VertexVariant, mesh: &RegionMesh) -> Option<Vec<[u32; 3]>> {
    let order = variant.parts.then(|| PartOrder::of(mesh)).flatten()?;
    let mut triangles = order.ordered(mesh);
    if variant.index_order == IndexOrder::Cache {
        let mut locals = vec![NO_VERTEX; mesh.vertices_ecef.len()];
        for range in &order.caps {
            let own = &mut triangles[range.start as usize..range.end as usize];
            order_for_cache(own, &mut locals);
        }
    }
    Some(triangles)
}

/// Of a vertex that has no number in its part.
const NO_VERTEX: u32 = u32::MAX;

/// As [`cache_ordered`], at the cost of these triangles' vertices only.
///
/// - `locals`: of all the mesh's vertices none has a number, before and after
fn order_for_cache(triangles: &mut [[u32; 3]], locals: &mut [u32]) {
    let mut vertices = Vec::new();
    let mut local = |vertex: u32| {
        let local = &mut locals[vertex as usize];
        if *local == NO_VERTEX {
            *local = index_u32(vertices.len());
            vertices.push(vertex);
        }
        *local
    };
    let own: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(&mut local)).collect();
    let ordered = cache_ordered(&own, vertices.len());
    for (place, corners) in triangles.iter_mut().zip(ordered.iter()) {
        *place = corners.map(|vertex| vertices[vertex as usize]);
    }
    for vertex in vertices {
        locals[vertex as usize] = NO_VERTEX;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Walls;
    use crate::layout::SceneGeometry;
    use std::collections::BTreeSet;
    use terrafill_fixtures::by_hand::{circle_deg, mesh};
    use terrafill_plan::{PART_FACETS, SeenParts};
    use terrafill_stencil::DrawnParts;

    /// A fan of 1,000 and a triangle, whose loops come the other way round.
    fn large() -> RegionMesh {
        let mut vertices_deg = circle_deg(1_000, 1.0);
        vertices_deg.extend([[40.0, 0.0], [41.0, 0.0], [41.0, 1.0]]);
        let fan = (1..999).map(|i| [0, i, i + 1]);
        let loops = vec![vec![1_000, 1_001, 1_002], (0..1_000).collect()];
        let triangles = fan.chain([[1_000, 1_001, 1_002]]).collect();
        mesh(vertices_deg, triangles, loops)
    }

    fn variant(layout: Layout, walls: Walls, index_order: IndexOrder) -> VertexVariant {
        VertexVariant {
            layout,
            walls,
            index_order,
            parts: true,
            ..VertexVariant::default()
        }
    }

    /// Boundary edges that a draw of these ranges has walls of.
    fn walls_of(
        geometry: &SceneGeometry,
        variant: &VertexVariant,
        parts: &DrawnParts,
    ) -> BTreeSet<[u32; 2]> {
        let short: Vec<u32> = geometry
            .indices
            .short
            .iter()
            .map(|&i| u32::from(i))
            .collect();
        let first = geometry.regions[0].place.first_loop_index;
        let at = |index: u32| short[(first + index) as usize];
        let mut found = BTreeSet::new();
        for range in &parts.walls {
            match variant.layout {
                Layout::Pulled => {
                    let entries = range.start / 6..range.end / 6;
                    found.extend(entries.map(|entry| [at(entry), at(entry + 1)]));
                }
                _ if variant.has_strips() => {
                    let pairs = (range.start..range.end - 2).step_by(2);
                    found.extend(pairs.map(|index| [at(index) / 2, at(index + 2) / 2]));
                }
                _ => {
                    let walls = range.clone().step_by(6);
                    found.extend(walls.map(|index| [at(index) / 2, at(index + 2) / 2]));
                }
            }
        }
        found
    }

    #[test]
    fn ranges_hold_the_facets_and_walls_seen_and_no_others() {
        let mesh = large();
        let order = PartOrder::of(&mesh).expect("large");
        let edges: Vec<[u32; 2]> = mesh.boundary_edges().collect();
        // Neither the first part nor the last, and of the walls the small loop and what follows.
        let last = order.caps.len() - 1;
        let seen = SeenParts {
            caps: vec![order.caps[1].clone(), order.caps[last - 1].clone()],
            walls: vec![0..40, 300..310, 990..1_003],
            facets_left_out: 1,
            ..SeenParts::default()
        };
        let wanted: BTreeSet<[u32; 2]> = [0..40, 300..310, 990..1_003]
            .into_iter()
            .flat_map(|range| edges[range].iter().copied())
            .collect();
        for (layout, walls) in [
            (Layout::Doubled, Walls::Strip),
            (Layout::Doubled, Walls::List),
            (Layout::Separate, Walls::Strip),
            (Layout::Pulled, Walls::Strip),
        ] {
            for order_within in [IndexOrder::Mesh, IndexOrder::Cache] {
                let variant = variant(layout, walls, order_within);
                let geometry =
                    SceneGeometry::build(&variant, std::slice::from_ref(&mesh), |_| true);
                let parts = DrawnParts::new(&mesh, &seen, variant.wall_indices());
                assert_eq!(walls_of(&geometry, &variant, &parts), wanted, "{variant:?}");
                let copies = if layout == Layout::Pulled { 1 } else { 2 };
                let drawn: BTreeSet<BTreeSet<u32>> = parts
                    .caps
                    .iter()
                    .flat_map(|range| {
                        let own = &geometry.indices.short[range.start as usize..range.end as usize];
                        own.chunks(3).map(|corners| {
                            corners
                                .iter()
                                .map(|&corner| u32::from(corner) / copies)
                                .collect()
                        })
                    })
                    .collect();
                let own = seen.caps.iter().flat_map(|range| range.clone());
                let wanted = own.map(|place| {
                    let corners = mesh.triangles[order.triangles[place as usize] as usize];
                    corners.into_iter().collect::<BTreeSet<u32>>()
                });
                assert_eq!(drawn, wanted.collect(), "{variant:?}");
            }
        }
        // Negative control: in the mesh's own order the same ranges hold other facets.
        let plain = VertexVariant::default();
        let geometry = SceneGeometry::build(&plain, std::slice::from_ref(&mesh), |_| true);
        let range = order.caps[1].start as usize..order.caps[1].end as usize;
        let facet = |corners: [u32; 3]| BTreeSet::from(corners);
        let plain: BTreeSet<BTreeSet<u32>> = geometry.indices.short[3 * range.start..3 * range.end]
            .chunks(3)
            .map(|corners| facet([0, 1, 2].map(|i| u32::from(corners[i]) / 2)))
            .collect();
        let own = order.triangles[range].iter();
        let own: BTreeSet<BTreeSet<u32>> = own
            .map(|&place| facet(mesh.triangles[place as usize]))
            .collect();
        assert_eq!(plain.len(), own.len());
        assert_ne!(plain, own);
        assert!(mesh.triangles.len() > PART_FACETS);
    }
}
