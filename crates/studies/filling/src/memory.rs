// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bytes of a scene in a layout, by formula, beside what the technique allocated.
//!
//! Beyond the scene's own regions the same ones are repeated in turn, so that the formula says what
//! a layout takes for thousands of them.

use crate::subject::Subject;
use terrafill_core::RegionMesh;
use terrafill_fill::{GeometryBytes, MemoryUse};

/// Numbers of regions for which the formula is worked out.
pub(crate) const REGION_COUNTS: [usize; 12] =
    [1, 2, 5, 10, 20, 50, 100, 200, 500, 1_000, 2_000, 5_000];

/// What the figures are about.
pub(crate) struct LayoutOfScene<'a> {
    pub(crate) subject: &'a Subject,
    /// All of the scene.
    pub(crate) meshes: &'a [RegionMesh],
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
