// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a probe frame says about its case, and what of it is written.

use crate::cases::{AblationPlace, FillCase};
use crate::purpose::Purpose;
use std::collections::BTreeMap;
use terrafill_conformance::{ErrorFigures, TextureErrors};
use terrafill_contract::{Counters, DeviceError, FillInput, Frame, MemoryUse, Need, Needs};
use terrafill_core::{MeshOptions, VolumeHeights};
use terrafill_results::{CaseFeature, Status, Verdict};
use terrafill_study::Failure;
use terrafill_surface::HeightRange;

/// Notes of every case; empty for what it has not.
const NOTES: [&str; 12] = [
    "left_out",
    "texture_route",
    "mask_hash",
    "ids_hash",
    "image",
    "difference_image",
    "reference_image",
    // The view for people, with which nothing is compared.
    "map_image",
    // The surroundings of the worst pixel, and its column and row.
    "worst_image",
    "worst_px",
    "change",
    "needs_change",
];

/// What a probe frame says.
#[derive(Debug)]
pub(crate) struct Probe {
    pub(crate) status: Status,
    pub(crate) reason: String,
    figures: Vec<(&'static str, f64)>,
    notes: BTreeMap<&'static str, String>,
    features: Vec<CaseFeature>,
    pub(crate) texture_errors: Option<TextureErrors>,
}

impl Probe {
    pub(crate) fn new(case: &FillCase, memory: MemoryUse, frame: &Frame) -> Self {
        let mut probe = Self {
            status: Status::default(),
            reason: String::new(),
            figures: Vec::new(),
            notes: NOTES.map(|name| (name, String::new())).into(),
            features: Vec::new(),
            texture_errors: None,
        };
        let change =
            |place: Option<&AblationPlace>| place.map_or("", |place| place.step.change).to_owned();
        probe.note("change", change(case.place.as_ref()));
        probe.note("needs_change", change(case.needs_place.as_ref()));
        let texture_bytes = Some(memory.texture_bytes).filter(|_| case.is(Purpose::Texture));
        probe.add_counts([
            ("geometry_bytes", Some(memory.geometry_bytes())),
            ("vertex_bytes", Some(memory.vertex_bytes)),
            ("index_bytes", Some(memory.index_bytes)),
            ("constant_bytes", Some(memory.constant_bytes)),
            ("target_bytes", Some(memory.target_bytes)),
            ("texture_bytes", texture_bytes),
            ("buffers", Some(memory.buffers)),
        ]);
        if let Some(of) = &frame.counters {
            probe.add_counts([
                ("upload_bytes", Some(of.upload_bytes)),
                ("draws", Some(of.draws)),
                ("vertices", Some(of.vertices)),
                ("vertex_shader_invocations", of.vertex_shader_invocations),
                ("geometry_shader_primitives", of.geometry_shader_primitives),
                ("clipper_invocations", of.clipper_invocations),
                ("clipper_primitives_out", of.clipper_primitives_out),
                (
                    "fragment_shader_invocations",
                    of.fragment_shader_invocations,
                ),
                ("stencil_fragments", of.stencil_fragments),
                ("buffer_creations", Some(of.buffer_creations)),
                ("pipeline_creations", Some(of.pipeline_creations)),
            ]);
        }
        probe
    }

    pub(crate) fn add(&mut self, name: &'static str, figure: Option<f64>) {
        self.figures.extend(figure.map(|figure| (name, figure)));
    }

    pub(crate) fn add_counts(
        &mut self,
        counts: impl IntoIterator<Item = (&'static str, Option<u64>)>,
    ) {
        for (name, count) in counts {
            self.add(name, count.map(|count| count as f64));
        }
    }

    pub(crate) fn note(&mut self, name: &'static str, text: String) {
        self.notes.insert(name, text);
    }

    pub(crate) fn has_note(&self, name: &str) -> bool {
        self.notes.get(name).is_some_and(|text| !text.is_empty())
    }

    /// What our plans and meshes make of the view.
    pub(crate) fn add_input(&mut self, input: &FillInput) {
        let FillInput { plan, scene, .. } = input;
        self.note("left_out", input.left_out_summary());
        self.add_counts([
            ("regions_drawn", Some(plan.regions.len() as u64)),
            ("regions_left_out", Some(plan.left_out.len() as u64)),
            ("cap_triangles", Some(cap_triangles(input))),
            ("surface_bytes", Some(surface_bytes(input))),
        ]);
        let deviations = scene.meshes.iter().map(|mesh| mesh.boundary_deviation_m);
        self.add("boundary_deviation_m", deviations.reduce(f64::max));
        self.add("wall_height_m", tallest_wall(input));
    }

    /// What the view holds and leaves out.
    pub(crate) fn add_needs(&mut self, needs: &Needs) {
        let spared = needs.list.iter().map(|need| need.spared_bytes);
        self.add_counts([
            ("held_bytes", Some(needs.held_bytes())),
            ("made_bytes", Some(needs.made.made_bytes)),
            ("spared_bytes", Some(spared.sum())),
            ("held_pipelines", Some(needs.pipelines())),
            ("made_pipelines", Some(needs.made.pipeline_creations)),
        ]);
        let row = |need: &Need| CaseFeature {
            feature: need.feature.name().to_owned(),
            is_held: need.is_held,
            bytes: need.bytes,
            pipelines: need.pipelines,
            spared_bytes: need.spared_bytes,
            reason: need.reason.clone(),
        };
        self.features = needs.list.iter().map(row).collect();
    }

    /// Of the same frame drawn once more.
    pub(crate) fn add_steady(&mut self, of: &Counters) {
        self.add_counts([
            ("steady_buffer_creations", Some(of.buffer_creations)),
            ("steady_pipeline_creations", Some(of.pipeline_creations)),
            ("steady_uploads", Some(of.uploads)),
        ]);
    }

    /// How the picture differs from the reference's.
    pub(crate) fn add_errors(&mut self, of: &ErrorFigures) {
        let outside = of.mismatched_px_outside_band;
        self.add_counts([
            ("filled_px", Some(of.filled_px)),
            ("mismatched_px", Some(of.mismatched_px)),
            ("mismatched_px_outside_band", Some(outside)),
            ("foreign_px", of.foreign_px),
            ("tiny_regions", Some(of.tiny_regions)),
            ("non_finite", Some(of.non_finite)),
        ]);
        self.add("hausdorff_px", of.hausdorff_px);
        self.add("boundary_moved_px", of.boundary_moved_px);
        self.add("area_error", of.area_error);
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

    pub(crate) fn verdict(mut self) -> Verdict {
        if let Some(errors) = self.texture_errors {
            self.add_counts([
                ("texel_non_finite", Some(errors.non_finite)),
                ("texel_compared_px", Some(errors.compared_px)),
            ]);
            // Of no pixel there is no error, which is not 0.
            if errors.compared_px > 0 {
                self.add("texel_rms", Some(worse(errors.rms_texels)));
                self.add("texel_max", Some(worse(errors.max_texels)));
            }
        }
        Verdict {
            status: self.status,
            reason: self.reason,
            figures: self.figures,
            notes: self.notes.into_iter().collect(),
            features: self.features,
        }
    }
}

/// What the adapter lacks, and switches that do not go together, are skipped; everything else that
/// breaks has failed.
pub(crate) fn failed(error: DeviceError) -> Failure {
    match error {
        DeviceError::Unsupported { .. } | DeviceError::Switch(_) => {
            Failure::Unable(error.to_string())
        }
        _ => Failure::broken(error),
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
        // Negative controls: no pixel at all, one without coordinates, one that is not finite, one compared.
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
        let error = DeviceError::Switch(terrafill_variant::SwitchError {
            switch: "texture",
            found: "chosen for a scene without a picture".to_owned(),
            allowed: "plain".to_owned(),
        });
        let Failure::Unable(reason) = failed(error) else {
            panic!("skipped");
        };
        assert!(reason.contains("without a picture"));
        // Negative control: what breaks has failed.
        let lost = failed(DeviceError::DeviceLost("gone".to_owned()));
        assert!(matches!(lost, Failure::Broken(_)), "{lost:?}");
    }
}
