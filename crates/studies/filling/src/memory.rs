// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bytes of a scene in a layout, by formula, beside what the backend allocated.
//!
//! Beyond the scene's own regions the same ones are repeated in turn, so that the formula says what
//! a layout takes for thousands of them.

use crate::Subject;
use terrafill_core::RegionMesh;
use terrafill_fill::{GeometryBytes, MemoryUse};
use terrafill_results::legacy::MemoryRow;

/// Numbers of regions for which the formula is worked out.
const REGION_COUNTS: [usize; 12] = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1_000, 2_000, 5_000];

/// What a row is about.
pub(crate) struct LayoutOfScene<'a> {
    pub(crate) scene: &'a str,
    pub(crate) layout: String,
    pub(crate) subject: &'a Subject,
    /// All of the scene.
    pub(crate) meshes: &'a [RegionMesh],
    /// Whether the view draws each of them.
    pub(crate) is_drawn: &'a [bool],
    /// As reported by the backend.
    pub(crate) allocated: Option<MemoryUse>,
}

impl LayoutOfScene<'_> {
    /// The scene as it is, then [`REGION_COUNTS`]; none for a technique without geometry.
    pub(crate) fn rows(&self) -> Vec<MemoryRow> {
        let count = self.meshes.len();
        // Each mesh once, however often it is repeated: some formulas ask for strips to be found.
        let formulas = |all_drawn: bool| -> Option<Vec<GeometryBytes>> {
            let meshes = self.meshes.iter().zip(self.is_drawn);
            let of =
                |(mesh, is_drawn): (_, &bool)| self.subject.formula(mesh, all_drawn || *is_drawn);
            meshes.map(of).collect()
        };
        let (Some(own), Some(drawn)) = (formulas(false), formulas(true)) else {
            return Vec::new();
        };
        let scene = self.row(count, &own);
        let others = REGION_COUNTS
            .into_iter()
            .filter(|&regions| regions != count);
        let others = others.filter_map(|regions| self.row(regions, &drawn));
        scene.into_iter().chain(others).collect()
    }

    /// - `formulas`: bytes of each mesh
    fn row(&self, regions: usize, formulas: &[GeometryBytes]) -> Option<MemoryRow> {
        let distinct = &self.meshes[..regions.min(self.meshes.len())];
        let mut total = self.subject.shared_formula(distinct);
        let mut each = Vec::with_capacity(regions);
        let [mut vertices, mut triangles, mut edges, mut loops] = [0_u64; 4];
        let is_scene = regions == self.meshes.len();
        let meshes = self.meshes.iter().zip(formulas).cycle();
        for (mesh, &bytes) in meshes.take(regions) {
            total = total + bytes;
            each.push(bytes.total());
            vertices += mesh.vertex_count() as u64;
            triangles += mesh.triangle_count() as u64;
            edges += mesh.boundary_edge_count() as u64;
            loops += mesh.boundary_loops.len() as u64;
        }
        let allocated = self.allocated.filter(|_| is_scene);
        each.sort_unstable();
        Some(MemoryRow {
            scene: self.scene.to_owned(),
            backend: self.subject.backend().to_owned(),
            layout: self.layout.clone(),
            regions: regions as u64,
            mesh_vertices: vertices,
            mesh_triangles: triangles,
            boundary_edges: edges,
            boundary_loops: loops,
            formula_vertex_bytes: total.vertex_bytes,
            formula_index_bytes: total.index_bytes,
            allocated_vertex_bytes: allocated.map(|memory| memory.vertex_bytes),
            allocated_index_bytes: allocated.map(|memory| memory.index_bytes),
            region_bytes_smallest: *each.first()?,
            region_bytes_median: each[each.len() / 2],
            region_bytes_largest: *each.last()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_compute::ComputeTechnique;
    use terrafill_core::{MeshOptions, RegionMesh};
    use terrafill_fill::Technique;
    use terrafill_gpu::BaselineKind;
    use terrafill_scene::{Overlap, Scene};
    use terrafill_vertex::VertexTechnique;

    fn subject(technique: &'static dyn Technique, layout: (&str, &str)) -> Subject {
        let main = technique.main(Overlap::Disjoint);
        Subject::Fill(technique, main.with(layout.0, layout.1))
    }

    fn california() -> Vec<RegionMesh> {
        let scene = Scene::shipped("california", None).expect("it ships");
        let options = MeshOptions::default();
        RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &options)
            .expect("it meshes")
    }

    #[test]
    fn repeated_regions_take_as_many_times_the_bytes() {
        let meshes = california();
        for layout in ["doubled", "pulled", "per-triangle"] {
            let rows = LayoutOfScene {
                scene: "california",
                layout: layout.to_owned(),
                subject: &subject(&VertexTechnique, ("layout", layout)),
                meshes: &meshes,
                is_drawn: &[true],
                allocated: Some(MemoryUse {
                    vertex_bytes: 7,
                    index_bytes: 5,
                    ..MemoryUse::default()
                }),
            }
            .rows();
            assert_eq!(rows.len(), REGION_COUNTS.len());
            assert_eq!(rows[0].regions, 1);
            assert_eq!(rows[0].allocated_bytes(), Some(12), "the scene itself");
            let last = &rows[rows.len() - 1];
            assert_eq!((last.regions, last.allocated_bytes()), (5_000, None));
            assert_eq!(last.formula_bytes(), 5_000 * rows[0].formula_bytes());
            assert_eq!(last.mesh_vertices, 5_000 * meshes[0].vertex_count() as u64);
            assert_eq!(last.region_bytes_median, rows[0].formula_bytes());
        }
    }

    #[test]
    fn what_is_made_per_frame_is_held_for_drawn_regions_only() {
        let meshes = california();
        let bytes = |expansion, is_drawn| {
            let rows = LayoutOfScene {
                scene: "california",
                layout: String::new(),
                subject: &subject(&ComputeTechnique, ("expansion", expansion)),
                meshes: &meshes,
                is_drawn: &[is_drawn],
                allocated: None,
            }
            .rows();
            rows[0].formula_bytes()
        };
        let drawn = bytes("per-frame", true);
        assert!(bytes("per-frame", false) < drawn);
        assert_eq!(bytes("cached", false), drawn);
    }

    #[test]
    fn what_regions_share_is_counted_once() {
        let meshes = california();
        let separate = subject(&VertexTechnique, ("layout", "separate"));
        let rows = LayoutOfScene {
            scene: "california",
            layout: "separate".to_owned(),
            subject: &separate,
            meshes: &meshes,
            is_drawn: &[true],
            allocated: None,
        }
        .rows();
        let shared = rows[0].formula_bytes() - rows[0].region_bytes_median;
        assert_eq!(shared, 2 * 4 * meshes[0].vertex_count() as u64);
        let last = &rows[rows.len() - 1];
        let own = 5_000 * rows[0].region_bytes_median;
        assert_eq!(last.formula_bytes(), own + shared);
        // Twin: were the flags stored with each region, there would be more of them.
        assert!(last.formula_bytes() < 5_000 * rows[0].formula_bytes());
    }

    #[test]
    fn a_full_screen_pass_has_no_geometry() {
        let rows = LayoutOfScene {
            scene: "california",
            layout: String::new(),
            subject: &Subject::Baseline(BaselineKind::Bound),
            meshes: &california(),
            is_drawn: &[true],
            allocated: None,
        }
        .rows();
        assert_eq!(rows, []);
    }
}
