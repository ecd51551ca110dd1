// SPDX-License-Identifier: MIT OR Apache-2.0
//! Large regions drawn in parts: what is seen of them, as ranges of their indices.

use crate::{IndexOrder, Layout, VertexVariant, cache_ordered};
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use terrafill_core::RegionMesh;
use terrafill_fill::FillInput;
use terrafill_scene::{PartOrder, SeenParts};

/// What is drawn of each mesh of which not all is, by its number.
pub(crate) type DrawnOfMeshes = BTreeMap<usize, DrawnParts>;

/// What is drawn of a mesh.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct DrawnParts {
    /// Of the indices of a cap.
    pub(crate) caps: Vec<Range<u32>>,
    /// Of the indices of the walls; with layout `pulled` of the vertices of their draw.
    pub(crate) walls: Vec<Range<u32>>,
}

impl DrawnParts {
    /// Of the meshes of which a view leaves parts out.
    pub(crate) fn of_view(variant: &VertexVariant, input: &FillInput) -> DrawnOfMeshes {
        let seen = input.plan.seen_parts.iter();
        let some = seen.filter(|(_, seen)| variant.parts && seen.facets_left_out > 0);
        some.map(|(&mesh, seen)| (mesh, Self::new(variant, &input.scene.meshes[mesh], seen)))
            .collect()
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "meshes have fewer than 2^32 vertices"
    )]
    fn new(variant: &VertexVariant, mesh: &RegionMesh, seen: &SeenParts) -> Self {
        let caps = seen.caps.iter();
        let mut firsts = Vec::with_capacity(mesh.boundary_loops.len());
        let mut edges = 0;
        for ring in &mesh.boundary_loops {
            firsts.push(edges);
            edges += ring.len() as u32;
        }
        let wall = |(ring, range): (usize, Range<u32>)| {
            let [before, loops] = [firsts[ring], ring as u32];
            let Range { start, end } = range;
            match variant.layout {
                // Each loop is followed by its first vertex and a separator.
                Layout::Pulled => 6 * (before + 2 * loops + start)..6 * (before + 2 * loops + end),
                // Two indices a vertex, the first one's again, and a restart.
                _ if variant.has_strips() => {
                    let first = 2 * (before + loops) + loops;
                    first + 2 * start..first + 2 * end + 2
                }
                _ => 6 * (before + start)..6 * (before + end),
            }
        };
        Self {
            caps: caps.map(|range| 3 * range.start..3 * range.end).collect(),
            walls: seen.walls_by_loop(mesh).into_iter().map(wall).collect(),
        }
    }

    /// Ranges of both caps, or of the top alone.
    ///
    /// - `cap`: indices of one cap
    pub(crate) fn both_caps(&self, cap: u32, with_bottom: bool) -> Vec<Range<u32>> {
        let bottom = self.caps.iter().filter(|_| with_bottom);
        let bottom = bottom.map(|range| cap + range.start..cap + range.end);
        self.caps.iter().cloned().chain(bottom).collect()
    }
}

/// Triangles part by part, and in the order of the variant within each; `None` where the mesh is drawn whole.
pub(crate) fn ordered_by_part(variant: &VertexVariant, mesh: &RegionMesh) -> Option<Vec<[u32; 3]>> {
    let order = PartOrder::of(mesh).filter(|_| variant.parts)?;
    let mut triangles = order.ordered(mesh);
    if variant.index_order == IndexOrder::Cache {
        for range in &order.caps {
            order_for_cache(&mut triangles[range.start as usize..range.end as usize]);
        }
    }
    Some(triangles)
}

/// As [`cache_ordered`], at the cost of these triangles' vertices only.
#[allow(
    clippy::cast_possible_truncation,
    reason = "meshes have fewer than 2^32 vertices"
)]
fn order_for_cache(triangles: &mut [[u32; 3]]) {
    let mut known: HashMap<u32, u32> = HashMap::new();
    let mut vertices = Vec::new();
    let mut local = |vertex: u32| {
        *known.entry(vertex).or_insert_with(|| {
            vertices.push(vertex);
            vertices.len() as u32 - 1
        })
    };
    let own: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(&mut local)).collect();
    let ordered = cache_ordered(&own, vertices.len());
    for (place, corners) in triangles.iter_mut().zip(ordered.iter()) {
        *place = corners.map(|vertex| vertices[vertex as usize]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Walls;
    use crate::layout::SceneGeometry;
    use std::collections::BTreeSet;
    use terrafill_fill::boundary_edges;
    use terrafill_fixtures::by_hand::{circle_deg, mesh};
    use terrafill_scene::PART_FACETS;

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
        let edges: Vec<[u32; 2]> = boundary_edges(&mesh).collect();
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
                let parts = DrawnParts::new(&variant, &mesh, &seen);
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
        // Twin: in the mesh's own order the same ranges hold other facets.
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

    #[test]
    fn both_caps_are_drawn_where_the_bottom_is() {
        let parts = DrawnParts {
            caps: vec![0..6, 12..15],
            walls: Vec::new(),
        };
        assert_eq!(parts.both_caps(30, false), [0..6, 12..15]);
        assert_eq!(parts.both_caps(30, true), [0..6, 12..15, 30..36, 42..45]);
    }
}
