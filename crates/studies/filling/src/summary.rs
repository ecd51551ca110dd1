// SPDX-License-Identifier: MIT OR Apache-2.0
//! From samples and a probe frame to a case's row.

use crate::group::{GroupRun, Probe, RunningCase};
use crate::{BenchCase, Subject};
use terrafill_conformance::checks_nothing;
use terrafill_results::legacy::{Baselines, Sample, Status, Summary, median, quantile};

impl GroupRun<'_> {
    pub(crate) fn summary(
        &self,
        running: &RunningCase<'_>,
        samples: &[Sample],
        baselines: Baselines,
    ) -> Summary {
        let (case, probe) = (running.case, &running.probe);
        let own: Vec<&Sample> = samples.iter().filter(|s| s.key() == case.key).collect();
        let collect = |value: fn(&Sample) -> Option<f64>| -> Vec<f64> {
            own.iter().filter_map(|sample| value(sample)).collect()
        };
        let middle = |value: fn(&Sample) -> Option<f64>| median(&collect(value));
        let fill_cpu_ms = middle(|s| Some(s.fill_cpu_ms));
        let cpu = collect(|s| Some(s.fill_cpu_ms));
        let status = probe.status.unwrap_or(if own.is_empty() {
            Status::Failed
        } else {
            Status::Ok
        });
        // A wrong frame is never fast: its times stand in the row, but no ratio is formed.
        let fill_over_bound_cpu = (status == Status::Ok)
            .then(|| Some(fill_cpu_ms? / baselines.bound_cpu_ms?))
            .flatten();
        let figures = probe.figures;
        let errors = probe.texture_errors;
        // Of no pixel there is no error, which is not 0.
        let compared = errors.filter(|errors| errors.compared_px > 0);
        let counters = probe.frame.as_ref().and_then(|frame| frame.counters);
        let is_baseline = matches!(case.subject, Subject::Baseline(_));
        Summary {
            scene: case.key.scene.clone(),
            view: case.key.view.clone(),
            backend: case.key.backend.clone(),
            variant: case.key.variant.clone(),
            status,
            reason: self.reason(probe, is_baseline),
            surface_gpu_ms: middle(|s| s.surface_gpu_ms),
            fill_gpu_ms: middle(|s| s.fill_gpu_ms),
            fill_cpu_ms,
            bound_gpu_ms: baselines.bound_gpu_ms,
            bound_cpu_ms: baselines.bound_cpu_ms,
            floor_cpu_ms: baselines.floor_cpu_ms,
            fill_over_bound_cpu,
            geometry_bytes: probe.memory.map(|memory| memory.geometry_bytes()),
            upload_bytes: counters.map(|counters| counters.upload_bytes),
            draws: counters.map(|counters| counters.draws),
            vertices: counters.map(|counters| counters.vertices),
            filled_px: figures.map(|figures| figures.filled_px),
            mismatched_px: figures.map(|figures| figures.mismatched_px),
            mismatched_px_outside_band: figures.map(|f| f.mismatched_px_outside_band),
            hausdorff_px: figures.and_then(|figures| figures.hausdorff_px),
            left_out: probe.left_out.clone(),
            stencil_gpu_ms: middle(|s| s.stencil_gpu_ms),
            colour_gpu_ms: middle(|s| s.colour_gpu_ms),
            fill_wall_ms: middle(|s| Some(s.fill_wall_ms)),
            fill_cpu_ms_p5: quantile(&cpu, 0.05),
            fill_cpu_ms_p95: quantile(&cpu, 0.95),
            samples: u32::try_from(own.len()).unwrap_or(u32::MAX),
            regions_drawn: probe.regions_drawn,
            regions_left_out: probe.regions_left_out,
            non_finite: figures.map(|figures| figures.non_finite),
            reference_disagreements: (!is_baseline).then_some(self.disagreements.0),
            reference_disagreements_outside_band: (!is_baseline).then_some(self.disagreements.1),
            boundary_tolerance_m: case.boundary_tolerance_m,
            boundary_deviation_m: probe.boundary_deviation_m,
            area_error: figures.and_then(|figures| figures.area_error),
            tiny_regions: figures.map(|figures| figures.tiny_regions),
            buffers: probe.memory.map(|memory| memory.buffers),
            vertex_bytes: probe.memory.map(|memory| memory.vertex_bytes),
            index_bytes: probe.memory.map(|memory| memory.index_bytes),
            constant_bytes: probe.memory.map(|memory| memory.constant_bytes),
            vertex_shader_invocations: counters.and_then(|c| c.vertex_shader_invocations),
            clipper_invocations: counters.and_then(|c| c.clipper_invocations),
            clipper_primitives_out: counters.and_then(|c| c.clipper_primitives_out),
            fragment_shader_invocations: counters.and_then(|c| c.fragment_shader_invocations),
            image: probe.image.clone(),
            difference_image: probe.difference_image.clone(),
            reference_image: probe
                .reference_image
                .clone()
                .unwrap_or_else(|| self.reference_image.clone()),
            plan_cpu_ms: probe.plan_cpu_ms,
            role: case.roles.name(),
            mask_hash: probe.mask_hash.clone(),
            ids_hash: probe.ids_hash.clone(),
            stencil_fragments: counters.and_then(|counters| counters.stencil_fragments),
            buffer_creations: counters.map(|counters| counters.buffer_creations),
            pipeline_creations: counters.map(|counters| counters.pipeline_creations),
            cap_step_deg: case.cap_step_deg,
            wall_height_m: probe.wall_height_m,
            cap_triangles: probe.cap_triangles,
            texture_route: probe.texture_route.clone(),
            texel_rms: compared.map(|errors| worse(errors.rms_texels)),
            texel_max: compared.map(|errors| worse(errors.max_texels)),
            texel_non_finite: errors.map(|errors| errors.non_finite),
            texel_compared_px: errors.map(|errors| errors.compared_px),
            texture_bytes: probe
                .memory
                .map(|memory| memory.texture_bytes)
                .filter(|_| case.roles.texture),
            colour_max: probe.colour_max,
            colour_mean: probe.colour_mean,
            boundary_moved_px: figures.and_then(|figures| figures.boundary_moved_px),
            foreign_px: figures.and_then(|figures| figures.foreign_px),
        }
    }

    /// Why the status is what it is, why cells are empty, and what the view cannot show.
    fn reason(&self, probe: &Probe, is_baseline: bool) -> String {
        let mut reasons = Vec::new();
        if !probe.reason.is_empty() {
            reasons.push(probe.reason.clone());
        }
        if is_baseline {
            reasons.push("a full-screen pass: it fills no region, so it has no error".to_owned());
        } else {
            if checks_nothing(&self.reference) {
                reasons.push("no region boundary in sight: this view checks nothing".to_owned());
            }
            if let Some(note) = &self.group.view.note {
                reasons.push(note.clone());
            }
        }
        reasons.join("; ")
    }
}

/// Of two axes; a NaN is worse than any number.
fn worse([u, v]: [f64; 2]) -> f64 {
    if u.is_nan() || v.is_nan() {
        return f64::NAN;
    }
    u.max(v)
}

/// Medians of the two full-screen passes of this scene and view.
pub(crate) fn baselines(cases: &[BenchCase], samples: &[Sample]) -> Baselines {
    let of = |backend: &str, value: fn(&Sample) -> Option<f64>| {
        let case = cases.iter().find(|case| case.key.backend == backend)?;
        let own = samples.iter().filter(|sample| sample.key() == case.key);
        median(&own.filter_map(value).collect::<Vec<_>>())
    };
    Baselines {
        bound_gpu_ms: of("bound", |sample| sample.fill_gpu_ms),
        bound_cpu_ms: of("bound", |sample| Some(sample.fill_cpu_ms)),
        floor_cpu_ms: of("floor", |sample| Some(sample.fill_cpu_ms)),
    }
}
