// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bytes of a scene in a layout, by formula, beside what the technique allocated.
//!
//! Beyond the scene's own regions the same ones are repeated in turn, so that the formula says what
//! a layout takes for thousands of them.

use crate::subject::Subject;
use terrafill_contract::{GeometryBytes, MemoryUse};
use terrafill_plan::LazyMesh;

/// Numbers of regions for which the formula is worked out.
pub(crate) const REGION_COUNTS: [usize; 12] =
    [1, 2, 5, 10, 20, 50, 100, 200, 500, 1_000, 2_000, 5_000];

/// What the figures are about.
pub(crate) struct LayoutOfScene<'a> {
    pub(crate) subject: &'a Subject,
    /// All of the scene.
    pub(crate) meshes: &'a [LazyMesh],
    /// Whether the view draws each of them.
    pub(crate) is_drawn: &'a [bool],
}

impl LayoutOfScene<'_> {
    /// Figures for so many regions by metric name; none for a technique without geometry.
    ///
    /// - `allocated`: as the technique reports it, of the scene's own regions
    pub(crate) fn figures(
        &self,
        regions: usize,
        allocated: Option<MemoryUse>,
    ) -> Vec<(&'static str, f64)> {
        let is_scene = regions == self.meshes.len();
        let drawn = self.is_drawn.iter().map(|is_drawn| *is_drawn || !is_scene);
        // Each mesh once, however often it is repeated: some formulas find strips first.
        let formulas: Option<Vec<GeometryBytes>> = self
            .meshes
            .iter()
            .zip(drawn)
            .take(regions)
            .map(|(mesh, is_drawn)| self.subject.formula(mesh, is_drawn))
            .collect();
        let Some(formulas) = formulas.filter(|formulas| !formulas.is_empty()) else {
            return Vec::new();
        };
        let distinct = &self.meshes[..regions.min(self.meshes.len())];
        let mut total = self.subject.shared_formula(distinct);
        let mut each = Vec::with_capacity(regions);
        let [mut vertices, mut triangles, mut edges, mut loops] = [0_u64; 4];
        for (mesh, &bytes) in self.meshes.iter().zip(&formulas).cycle().take(regions) {
            total = total + bytes;
            each.push(bytes.total());
            vertices += mesh.vertex_count() as u64;
            triangles += mesh.triangle_count() as u64;
            edges += mesh.boundary_edge_count() as u64;
            loops += mesh.boundary_loops.len() as u64;
        }
        each.sort_unstable();
        let (Some(smallest), Some(largest)) = (each.first(), each.last()) else {
            return Vec::new();
        };
        let mut figures = vec![
            ("mesh_vertices", vertices),
            ("mesh_triangles", triangles),
            ("boundary_edges", edges),
            ("boundary_loops", loops),
            ("formula_vertex_bytes", total.vertex_bytes),
            ("formula_index_bytes", total.index_bytes),
            ("region_bytes_smallest", *smallest),
            ("region_bytes_median", each[each.len() / 2]),
            ("region_bytes_largest", *largest),
        ];
        if let Some(memory) = allocated.filter(|_| is_scene) {
            figures.extend([
                ("allocated_vertex_bytes", memory.vertex_bytes),
                ("allocated_index_bytes", memory.index_bytes),
            ]);
        }
        let as_value = |(name, value)| (name, value as f64);
        figures.into_iter().map(as_value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;
    use terrafill_compute::ComputeTechnique;
    use terrafill_contract::Technique as _;
    use terrafill_core::{MeshOptions, RegionMesh};
    use terrafill_gpu::BaselineKind;
    use terrafill_plan::RegionSet;
    use terrafill_scene::{Overlap, Scene};
    use terrafill_vertex::VertexTechnique;

    fn california() -> RegionSet {
        let scene = Scene::shipped("california", None).expect("it ships");
        let options = MeshOptions::default();
        RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &options)
            .expect("it meshes")
            .into()
    }

    fn vertex(layout: &str) -> Subject {
        let main = VertexTechnique.main(Overlap::Disjoint);
        Subject::Fill(&VertexTechnique, main.with("layout", layout))
    }

    type Figures = BTreeMap<&'static str, f64>;

    fn figures(
        subject: &Subject,
        meshes: &[LazyMesh],
        is_drawn: bool,
        regions: usize,
        allocated: Option<MemoryUse>,
    ) -> Figures {
        let of_scene = LayoutOfScene {
            subject,
            meshes,
            is_drawn: &[is_drawn],
        };
        of_scene.figures(regions, allocated).into_iter().collect()
    }

    fn formula_bytes(figures: &Figures) -> f64 {
        figures["formula_vertex_bytes"] + figures["formula_index_bytes"]
    }

    #[track_caller]
    fn assert_same(left: f64, right: f64) {
        assert!((left - right).abs() < 0.5, "{left} bytes, {right} bytes");
    }

    #[test]
    fn repeated_regions_take_as_many_times_the_bytes() {
        let meshes = california();
        for layout in ["doubled", "pulled", "per-triangle"] {
            let allocated = Some(MemoryUse {
                vertex_bytes: 7,
                index_bytes: 5,
                ..MemoryUse::default()
            });
            let of = |regions| figures(&vertex(layout), &meshes, true, regions, allocated);
            let (one, many) = (of(1), of(5_000));
            assert_same(one["allocated_vertex_bytes"], 7.0);
            assert_same(one["allocated_index_bytes"], 5.0);
            // Negative control: nothing was allocated for more regions than the scene has.
            assert!(!many.contains_key("allocated_vertex_bytes"), "{layout}");
            assert_same(formula_bytes(&many), 5_000.0 * formula_bytes(&one));
            let vertices = 5_000.0 * meshes[0].vertex_count() as f64;
            assert_same(many["mesh_vertices"], vertices);
            for name in ["smallest", "median", "largest"] {
                let name = format!("region_bytes_{name}");
                assert_same(many[name.as_str()], formula_bytes(&one));
            }
        }
    }

    #[test]
    fn what_is_made_per_frame_is_held_for_drawn_regions_only() {
        let meshes = california();
        let bytes = |expansion, is_drawn| {
            let main = ComputeTechnique.main(Overlap::Disjoint);
            let subject = Subject::Fill(&ComputeTechnique, main.with("expansion", expansion));
            formula_bytes(&figures(&subject, &meshes, is_drawn, 1, None))
        };
        let drawn = bytes("per-frame", true);
        assert!(bytes("per-frame", false) < drawn);
        assert_same(bytes("cached", false), drawn);
    }

    #[test]
    fn what_regions_share_is_counted_once() {
        let meshes = california();
        let of = |regions| figures(&vertex("separate"), &meshes, true, regions, None);
        let (one, many) = (of(1), of(5_000));
        let own = one["region_bytes_median"];
        let shared = formula_bytes(&one) - own;
        assert_same(shared, 2.0 * 4.0 * meshes[0].vertex_count() as f64);
        assert_same(formula_bytes(&many), 5_000.0 * own + shared);
        // Negative control: were the flags stored with each region, there would be more of them.
        assert!(formula_bytes(&many) < 5_000.0 * formula_bytes(&one));
    }

    #[test]
    fn a_full_screen_pass_has_no_geometry() {
        for kind in BaselineKind::ALL {
            let pass = Subject::Baseline(kind);
            assert!(figures(&pass, &california(), true, 1, None).is_empty());
        }
    }
}
