// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a probe frame says about its case, and what of it is written.

use crate::cases::{FillCase, Place};
use terrafill_conformance::{ErrorFigures, TextureErrors};
use terrafill_core::{MeshOptions, VolumeHeights};
use terrafill_fill::{Counters, DeviceError, FillInput, Frame, MemoryUse, Needs};
use terrafill_results::{Status, Verdict};
use terrafill_scene::{HeightRange, LazyMesh};

/// Figures of a probe frame.
#[derive(Debug, Default)]
pub(crate) struct Probe {
    pub(crate) status: Status,
    pub(crate) reason: String,
    memory: MemoryUse,
    counters: Option<Counters>,
    /// Of the same frame drawn once more; `None` of a case that is not timed.
    pub(crate) steady: Option<Counters>,
    pub(crate) figures: Option<ErrorFigures>,
    regions: Option<[u64; 2]>,
    left_out: String,
    boundary_deviation_m: Option<f64>,
    wall_height_m: Option<f64>,
    /// How far walls are from those along geodetic normals, where they are no such walls.
    pub(crate) wall_shift_m: Option<f64>,
    /// The tallest wall that the cap step allows, by formula.
    pub(crate) wall_bound_m: Option<f64>,
    cap_triangles: Option<u64>,
    surface_bytes: Option<u64>,
    pub(crate) plan_cpu_ms: Option<f64>,
    pub(crate) prepare_cpu_ms: Option<f64>,
    pub(crate) image: String,
    pub(crate) difference_image: String,
    pub(crate) reference_image: String,
    /// The surroundings of the worst pixel, and its column and row.
    pub(crate) worst_image: String,
    pub(crate) worst_px: String,
    pub(crate) texture_errors: Option<TextureErrors>,
    /// Largest and mean difference of a colour channel from the reference's picture.
    pub(crate) colour: Option<(u64, f64)>,
    /// What the view holds and leaves out, where that is told.
    pub(crate) needs: Option<Needs>,
    /// Pixels on which the reference's own tests disagree, in all and outside the boundary band.
    pub(crate) disagreements: Option<(u64, u64)>,
    /// How far the boundary as drawn lies from the true one: largest and 99th percentile, pixels.
    pub(crate) moved_px_true: Option<[f64; 2]>,
}

impl Probe {
    pub(crate) fn new(memory: MemoryUse, input: &FillInput, frame: &Frame) -> Self {
        let meshes = &input.scene.meshes;
        Self {
            memory,
            counters: frame.counters,
            regions: Some([
                input.plan.regions.len() as u64,
                input.plan.left_out.len() as u64,
            ]),
            left_out: input.left_out_summary(),
            boundary_deviation_m: largest_deviation(meshes),
            wall_height_m: tallest_wall(input),
            cap_triangles: Some(cap_triangles(input)),
            surface_bytes: Some(surface_bytes(input)),
            ..Self::default()
        }
    }

    /// Of a rival, which makes no use of our plans and meshes.
    pub(crate) fn of_rival(memory: MemoryUse, frame: &Frame) -> Self {
        Self {
            memory,
            counters: frame.counters,
            ..Self::default()
        }
    }

    pub(crate) fn remark(&mut self, remark: &str) {
        if !self.reason.is_empty() {
            self.reason.push_str("; ");
        }
        self.reason.push_str(remark);
    }

    /// Right without a reason against it.
    pub(crate) fn set_status(&mut self, reasons: &[String]) {
        self.status = if reasons.is_empty() {
            Status::Ok
        } else {
            Status::Wrong
        };
        self.reason = reasons.join("; ");
    }

    /// An approximate fill is never right: that its picture matches here promises nothing elsewhere.
    pub(crate) fn set_approximate(&mut self, reasons: &[String]) {
        let found = match reasons {
            [] => "within the tolerances in this view, which it does not promise".to_owned(),
            some => some.join("; "),
        };
        self.status = Status::Wrong;
        self.reason = format!("approximate: {found}");
    }

    /// How a case ends of which the driver is known to lose pixels.
    pub(crate) fn settle(&mut self, (status, reason): (Status, String)) {
        (self.status, self.reason) = (status, reason);
    }

    /// Where every texel lies at a silhouette nothing speaks against them, and nothing for them: that
    /// is not a pass.
    pub(crate) fn let_off_if_all_silhouette(&mut self, is_mask_right: bool) {
        let Some(errors) = self.texture_errors.filter(is_all_silhouette) else {
            return;
        };
        if is_mask_right {
            self.status = Status::Skipped;
            self.reason = format!(
                "all {} filled pixels lie at a silhouette: no texel to compare at this size",
                errors.silhouette_px
            );
            self.texture_errors = None;
        }
    }

    /// - `texts`: hashes of mask and ids, and the routes of a textured fill
    pub(crate) fn verdict(
        self,
        case: &FillCase,
        [mask_hash, ids_hash, texture_route]: [String; 3],
    ) -> Verdict {
        let figures = self.values(case);
        let change = |place: Option<Place>| place.map_or("", |place| place.change).to_owned();
        let needs = self.needs.iter().flat_map(|needs| &needs.list);
        let needs: Vec<_> = needs
            .map(|need| (need.feature.note(), need.line()))
            .collect();
        let own = vec![
            ("left_out", self.left_out),
            ("texture_route", texture_route),
            ("mask_hash", mask_hash),
            ("ids_hash", ids_hash),
            ("image", self.image),
            ("difference_image", self.difference_image),
            ("reference_image", self.reference_image),
            ("worst_image", self.worst_image),
            ("worst_px", self.worst_px),
            ("change", change(case.place)),
            ("needs_change", change(case.needs_place)),
        ];
        Verdict {
            status: self.status,
            reason: self.reason,
            figures,
            notes: own.into_iter().chain(needs).collect(),
        }
    }

    fn values(&self, case: &FillCase) -> Vec<(&'static str, f64)> {
        let memory = &self.memory;
        let is_textured = case.is(crate::cases::Purpose::Texture);
        let mut counts: Vec<(&'static str, Option<u64>)> = vec![
            ("geometry_bytes", Some(memory.geometry_bytes())),
            ("vertex_bytes", Some(memory.vertex_bytes)),
            ("index_bytes", Some(memory.index_bytes)),
            ("constant_bytes", Some(memory.constant_bytes)),
            ("target_bytes", Some(memory.target_bytes)),
            (
                "texture_bytes",
                Some(memory.texture_bytes).filter(|_| is_textured),
            ),
            ("buffers", Some(memory.buffers)),
            ("regions_drawn", self.regions.map(|[drawn, _]| drawn)),
            (
                "regions_left_out",
                self.regions.map(|[_, left_out]| left_out),
            ),
            ("cap_triangles", self.cap_triangles),
            ("surface_bytes", self.surface_bytes),
        ];
        if let Some(counters) = &self.counters {
            counts.extend([
                ("upload_bytes", Some(counters.upload_bytes)),
                ("draws", Some(counters.draws)),
                ("vertices", Some(counters.vertices)),
                (
                    "vertex_shader_invocations",
                    counters.vertex_shader_invocations,
                ),
                (
                    "geometry_shader_primitives",
                    counters.geometry_shader_primitives,
                ),
                ("clipper_invocations", counters.clipper_invocations),
                ("clipper_primitives_out", counters.clipper_primitives_out),
                (
                    "fragment_shader_invocations",
                    counters.fragment_shader_invocations,
                ),
                ("stencil_fragments", counters.stencil_fragments),
                ("buffer_creations", Some(counters.buffer_creations)),
                ("pipeline_creations", Some(counters.pipeline_creations)),
            ]);
        }
        if let Some(needs) = &self.needs {
            let spared = needs.list.iter().map(|need| need.spared_bytes);
            counts.extend([
                ("held_bytes", Some(needs.held_bytes())),
                ("made_bytes", Some(needs.made.made_bytes)),
                ("spared_bytes", Some(spared.sum())),
                ("held_pipelines", Some(needs.pipelines())),
                ("made_pipelines", Some(needs.made.pipeline_creations)),
            ]);
        }
        if let Some(counters) = &self.steady {
            counts.extend([
                ("steady_buffer_creations", Some(counters.buffer_creations)),
                (
                    "steady_pipeline_creations",
                    Some(counters.pipeline_creations),
                ),
                ("steady_uploads", Some(counters.uploads)),
            ]);
        }
        if let Some(figures) = &self.figures {
            counts.extend([
                ("filled_px", Some(figures.filled_px)),
                ("mismatched_px", Some(figures.mismatched_px)),
                (
                    "mismatched_px_outside_band",
                    Some(figures.mismatched_px_outside_band),
                ),
                ("foreign_px", figures.foreign_px),
                ("tiny_regions", Some(figures.tiny_regions)),
                ("non_finite", Some(figures.non_finite)),
            ]);
        }
        if let Some((all, outside)) = self.disagreements {
            counts.extend([
                ("reference_disagreements", Some(all)),
                ("reference_disagreements_outside_band", Some(outside)),
            ]);
        }
        let errors = self.texture_errors;
        counts.extend([
            ("texel_non_finite", errors.map(|errors| errors.non_finite)),
            ("texel_compared_px", errors.map(|errors| errors.compared_px)),
            ("colour_max", self.colour.map(|(largest, _)| largest)),
        ]);
        // Of no pixel there is no error, which is not 0.
        let compared = errors.filter(|errors| errors.compared_px > 0);
        let figures = self.figures.as_ref();
        let measures = [
            ("plan_cpu_ms", self.plan_cpu_ms),
            ("prepare_cpu_ms", self.prepare_cpu_ms),
            ("boundary_deviation_m", self.boundary_deviation_m),
            ("wall_height_m", self.wall_height_m),
            ("wall_bound_m", self.wall_bound_m),
            ("wall_shift_m", self.wall_shift_m),
            (
                "hausdorff_px",
                figures.and_then(|figures| figures.hausdorff_px),
            ),
            (
                "boundary_moved_px",
                figures.and_then(|figures| figures.boundary_moved_px),
            ),
            (
                "moved_px_true",
                self.moved_px_true.map(|[largest, _]| largest),
            ),
            ("moved_px_true_p99", self.moved_px_true.map(|[_, p99]| p99)),
            ("area_error", figures.and_then(|figures| figures.area_error)),
            ("texel_rms", compared.map(|errors| worse(errors.rms_texels))),
            ("texel_max", compared.map(|errors| worse(errors.max_texels))),
            ("colour_mean", self.colour.map(|(_, mean)| mean)),
        ];
        let counts = counts.into_iter();
        let counts = counts.map(|(name, count)| (name, count.map(|count| count as f64)));
        counts
            .chain(measures)
            .filter_map(|(name, value)| Some((name, value?)))
            .collect()
    }
}

/// What the adapter lacks, and switches that do not go together, are skipped; everything else that
/// breaks has failed.
pub(crate) fn failed(error: &DeviceError) -> Verdict {
    match error {
        DeviceError::Unsupported { .. } | DeviceError::Switch(_) => {
            Verdict::skipped(error.to_string())
        }
        _ => Verdict::failed(error.to_string()),
    }
}

/// Of two axes; a NaN is worse than any number.
fn worse([u, v]: [f64; 2]) -> f64 {
    if u.is_nan() || v.is_nan() {
        return f64::NAN;
    }
    u.max(v)
}

/// From the bottom cap to the top cap of the region drawn where they are farthest apart.
fn tallest_wall(input: &FillInput) -> Option<f64> {
    let regions = input.plan.regions.iter();
    let walls = regions.map(|region| region.heights.top_m - region.heights.bottom_m);
    walls.reduce(f64::max)
}

/// The same if the caps' facets hung as deep as `options` allow: what the mesher did better is added.
pub(crate) fn tallest_wall_allowed(input: &FillInput, options: &MeshOptions) -> Option<f64> {
    let scene = &input.scene;
    let sagitta_m = options.sagitta_bound_m(&scene.body);
    let span = |heights: VolumeHeights| heights.top_m - heights.bottom_m;
    let walls = input.plan.regions.iter().map(|region| {
        let mesh = &scene.meshes[region.mesh];
        let stated = scene.surface.heights(&mesh.extent);
        let HeightRange {
            lowest_m,
            highest_m,
        } = input.surface.heights_over(&mesh.extent, stated);
        let found_m = span(mesh.volume_heights(lowest_m, highest_m));
        let allowed = mesh.volume_heights_of_sagitta(sagitta_m, lowest_m, highest_m);
        span(region.heights) + span(allowed) - found_m
    });
    walls.reduce(f64::max)
}

/// Triangles of one cap of every region drawn.
fn cap_triangles(input: &FillInput) -> u64 {
    let meshes = input.plan.regions.iter().map(|region| region.mesh);
    meshes
        .map(|mesh| input.scene.meshes[mesh].triangle_count() as u64)
        .sum()
}

/// Of vertices, indices and picture, as both devices hold them.
fn surface_bytes(input: &FillInput) -> u64 {
    let surface = &input.surface;
    let mesh = size_of_val(&*surface.vertices_rte) + size_of_val(&*surface.triangles);
    let picture = input.scene.picture.as_ref();
    mesh as u64 + picture.map_or(0, |picture| picture.bytes())
}

fn largest_deviation(meshes: &[LazyMesh]) -> Option<f64> {
    let deviations = meshes.iter().map(|mesh| mesh.boundary_deviation_m);
    deviations.reduce(f64::max)
}

/// Whether every texel of a picture was left out of the comparison because a silhouette is near, as in
/// a very small image.
fn is_all_silhouette(errors: &TextureErrors) -> bool {
    let TextureErrors {
        compared_px,
        silhouette_px,
        missing_px,
        non_finite,
        ..
    } = *errors;
    (compared_px, missing_px, non_finite) == (0, 0, 0) && silhouette_px > 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_that_are_all_at_silhouettes_are_no_verdict() {
        let all = TextureErrors {
            silhouette_px: 12,
            ..TextureErrors::default()
        };
        assert!(is_all_silhouette(&all));
        // Twins: no pixel at all, one without coordinates, one that is not finite, one compared.
        for other in [
            TextureErrors::default(),
            TextureErrors {
                missing_px: 1,
                ..all
            },
            TextureErrors {
                non_finite: 1,
                ..all
            },
            TextureErrors {
                compared_px: 1,
                ..all
            },
        ] {
            assert!(!is_all_silhouette(&other), "{other:?}");
        }
    }

    #[test]
    fn what_has_no_picture_is_skipped_with_that_reason() {
        let error = DeviceError::Switch(terrafill_fill::SwitchError {
            switch: "texture",
            found: "chosen for a scene without a picture".to_owned(),
            allowed: "plain".to_owned(),
        });
        let verdict = failed(&error);
        assert_eq!(verdict.status, Status::Skipped);
        assert!(verdict.reason.contains("without a picture"));
        // Twin: what breaks has failed.
        let lost = failed(&DeviceError::DeviceLost("gone".to_owned()));
        assert_eq!(lost.status, Status::Failed);
    }
}
