// SPDX-License-Identifier: MIT OR Apache-2.0
//! `summary.csv`: a row for each case, with medians over processes. Its first columns are stable;
//! `bound` and `floor` are the old names of the depth-pass and the stencil-pass and stay there.

use super::data::{DEPTH_PASS, Data, STENCIL_PASS};
use crate::keys::{FILL_CPU_MS, FILL_GPU_MS, ROLE, SCENE, TECHNIQUE, VARIANT, VIEW};
use crate::metrics::METRICS;
use terrafill_results::{Case, ChapterError, DerivedTable, Outcome, quantile};

/// What a column shows.
enum Column {
    /// A text.
    Text(fn(&Case) -> String),
    /// A metric of the case.
    Metric,
    /// A metric of a full-screen pass of the same scene and view.
    Baseline(&'static str, &'static terrafill_results::Metric),
    /// `fill_cpu_ms / bound_cpu_ms` of a right case.
    FillOverBound,
    /// A quantile of the process CPU time.
    Quantile(f64),
    /// Timed samples behind the medians.
    Samples,
}

use Column::{Baseline, FillOverBound, Metric, Quantile, Samples, Text};

/// The columns, left to right; those up to `left_out` are stable.
const COLUMNS: [(&str, Column); 68] = [
    ("scene", Text(|case| case.condition(SCENE).to_owned())),
    ("view", Text(|case| case.condition(VIEW).to_owned())),
    ("backend", Text(backend)),
    ("variant", Text(|case| case.condition(VARIANT).to_owned())),
    ("status", Text(|case| case.outcome.name().to_owned())),
    ("reason", Text(|case| case.reason.clone())),
    ("surface_gpu_ms", Metric),
    ("fill_gpu_ms", Metric),
    ("fill_cpu_ms", Metric),
    ("bound_gpu_ms", Baseline(DEPTH_PASS, FILL_GPU_MS)),
    ("bound_cpu_ms", Baseline(DEPTH_PASS, FILL_CPU_MS)),
    ("floor_cpu_ms", Baseline(STENCIL_PASS, FILL_CPU_MS)),
    ("fill_over_bound_cpu", FillOverBound),
    ("geometry_bytes", Metric),
    ("upload_bytes", Metric),
    ("draws", Metric),
    ("vertices", Metric),
    ("filled_px", Metric),
    ("mismatched_px", Metric),
    ("mismatched_px_outside_band", Metric),
    ("hausdorff_px", Metric),
    ("left_out", Text(|case| case.note("left_out").to_owned())),
    ("stencil_gpu_ms", Metric),
    ("colour_gpu_ms", Metric),
    ("fill_wall_ms", Metric),
    ("fill_cpu_ms_p5", Quantile(0.05)),
    ("fill_cpu_ms_p95", Quantile(0.95)),
    ("samples", Samples),
    ("regions_drawn", Metric),
    ("regions_left_out", Metric),
    ("non_finite", Metric),
    ("reference_disagreements", Metric),
    ("reference_disagreements_outside_band", Metric),
    ("boundary_tolerance_m", Metric),
    ("boundary_deviation_m", Metric),
    ("area_error", Metric),
    ("tiny_regions", Metric),
    ("buffers", Metric),
    ("vertex_bytes", Metric),
    ("index_bytes", Metric),
    ("constant_bytes", Metric),
    ("vertex_shader_invocations", Metric),
    ("clipper_invocations", Metric),
    ("clipper_primitives_out", Metric),
    ("fragment_shader_invocations", Metric),
    ("image", Text(|case| case.note("image").to_owned())),
    (
        "difference_image",
        Text(|case| case.note("difference_image").to_owned()),
    ),
    (
        "reference_image",
        Text(|case| case.note("reference_image").to_owned()),
    ),
    ("plan_cpu_ms", Metric),
    ("role", Text(|case| case.condition(ROLE).to_owned())),
    ("mask_hash", Text(|case| case.note("mask_hash").to_owned())),
    ("ids_hash", Text(|case| case.note("ids_hash").to_owned())),
    ("stencil_fragments", Metric),
    ("buffer_creations", Metric),
    ("pipeline_creations", Metric),
    ("cap_step_deg", Metric),
    ("wall_height_m", Metric),
    ("cap_triangles", Metric),
    (
        "texture_route",
        Text(|case| case.note("texture_route").to_owned()),
    ),
    ("texel_rms", Metric),
    ("texel_max", Metric),
    ("texel_non_finite", Metric),
    ("texel_compared_px", Metric),
    ("texture_bytes", Metric),
    ("colour_max", Metric),
    ("colour_mean", Metric),
    ("boundary_moved_px", Metric),
    ("foreign_px", Metric),
];

// Columns of metrics have the names of declared ones.
const _: () = {
    let mut at = 0;
    while at < COLUMNS.len() {
        if let Metric = COLUMNS[at].1 {
            let _ = terrafill_results::Metric::of(&METRICS, COLUMNS[at].0);
        }
        at += 1;
    }
};

/// The table; a missing case has no row.
pub(super) fn table(data: &Data<'_>) -> Result<DerivedTable, ChapterError> {
    let header = COLUMNS.each_ref().map(|(name, _)| *name);
    let cases = data
        .cases
        .iter()
        .filter(|case| case.outcome != Outcome::Missing);
    let row = |case: &&Case| {
        let cells = COLUMNS
            .iter()
            .map(|(name, column)| cell(data, case, name, column));
        cells.collect()
    };
    DerivedTable::new("summary.csv", &header, cases.map(row))
}

/// Techniques are named as ever in this table.
fn backend(case: &Case) -> String {
    match case.condition(TECHNIQUE) {
        DEPTH_PASS => "bound".to_owned(),
        STENCIL_PASS => "floor".to_owned(),
        technique => technique.to_owned(),
    }
}

fn cell(data: &Data<'_>, case: &Case, name: &str, column: &Column) -> String {
    let baseline = |technique: &str, metric: &terrafill_results::Metric| {
        data.baseline(case, technique)?.value(metric)
    };
    let value = match column {
        Text(text) => return text(case),
        Samples => return samples(case).len().to_string(),
        Metric => case.value(name),
        Baseline(technique, metric) => baseline(technique, metric),
        FillOverBound => fill_over_bound(case, baseline(DEPTH_PASS, FILL_CPU_MS)),
        Quantile(q) => quantile(&samples(case), *q),
    };
    value.map_or_else(String::new, |value| value.to_string())
}

fn fill_over_bound(case: &Case, bound_ms: Option<f64>) -> Option<f64> {
    let bound_ms = bound_ms.filter(|_| case.counts())?;
    Some(case.value(FILL_CPU_MS)? / bound_ms)
}

fn samples(case: &Case) -> Vec<f64> {
    let processes = case.samples(FILL_CPU_MS).into_iter().flatten();
    processes
        .flat_map(|(_, samples)| samples.values().copied())
        .collect()
}
