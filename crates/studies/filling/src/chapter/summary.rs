// SPDX-License-Identifier: MIT OR Apache-2.0
//! `summary.csv`: a row for each case, with medians over processes. Its first columns are stable;
//! `bound` and `floor` are the old names of the depth-pass and the stencil-pass and stay there.

use super::data::{DEPTH_PASS, Data, STENCIL_PASS};
use crate::keys::{FILL_CPU_MS, FILL_GPU_MS, TECHNIQUE};
use crate::metrics::METRICS;
use terrafill_results::{Case, ChapterError, DerivedTable, Metric, Outcome, sample_spread};

/// The columns, left to right; those up to `left_out` are stable.
const COLUMNS: &str = "\
    scene view backend variant status reason surface_gpu_ms fill_gpu_ms fill_cpu_ms bound_gpu_ms \
    bound_cpu_ms floor_cpu_ms fill_over_bound_cpu geometry_bytes upload_bytes draws vertices filled_px \
    mismatched_px mismatched_px_outside_band hausdorff_px left_out stencil_gpu_ms colour_gpu_ms \
    fill_wall_ms fill_cpu_ms_p5 fill_cpu_ms_p95 samples regions_drawn regions_left_out non_finite \
    reference_disagreements reference_disagreements_outside_band boundary_tolerance_m \
    boundary_deviation_m area_error tiny_regions buffers vertex_bytes index_bytes constant_bytes \
    vertex_shader_invocations clipper_invocations clipper_primitives_out fragment_shader_invocations \
    image difference_image reference_image plan_cpu_ms role mask_hash ids_hash stencil_fragments \
    buffer_creations pipeline_creations cap_step_deg wall_height_m cap_triangles texture_route texel_rms \
    texel_max texel_non_finite texel_compared_px texture_bytes colour_max colour_mean boundary_moved_px \
    foreign_px";

/// The table; a missing case has no row.
pub(super) fn table(data: &Data<'_>) -> Result<DerivedTable, ChapterError> {
    let header: Vec<&str> = COLUMNS.split_whitespace().collect();
    let cases = data
        .cases
        .iter()
        .filter(|case| case.outcome != Outcome::Missing);
    let row = |case: &&Case| {
        header
            .iter()
            .map(|column| cell(data, case, column))
            .collect()
    };
    DerivedTable::new("summary.csv", &header, cases.map(row))
}

/// What a column shows: unless it is among these, a note or the metric of that name.
fn cell(data: &Data<'_>, case: &Case, column: &str) -> String {
    let baseline = |technique: &str, metric: &Metric| data.baseline(case, technique)?.value(metric);
    let samples = sample_spread(case, FILL_CPU_MS);
    let value = match column {
        "scene" | "view" | "variant" | "role" => return case.condition_named(column).to_owned(),
        // Techniques are named as ever in this table.
        "backend" => {
            return match case.condition(TECHNIQUE) {
                DEPTH_PASS => "bound".to_owned(),
                STENCIL_PASS => "floor".to_owned(),
                technique => technique.to_owned(),
            };
        }
        "status" => return case.outcome.name().to_owned(),
        "reason" => return case.reason.clone(),
        "samples" => {
            let processes = case.samples(FILL_CPU_MS).into_iter().flatten();
            return processes
                .map(|(_, own)| own.len())
                .sum::<usize>()
                .to_string();
        }
        "left_out" | "image" | "difference_image" | "reference_image" | "mask_hash"
        | "ids_hash" | "texture_route" => return case.note(column).to_owned(),
        "bound_gpu_ms" => baseline(DEPTH_PASS, FILL_GPU_MS),
        "bound_cpu_ms" => baseline(DEPTH_PASS, FILL_CPU_MS),
        "floor_cpu_ms" => baseline(STENCIL_PASS, FILL_CPU_MS),
        // Of a right case alone.
        "fill_over_bound_cpu" => baseline(DEPTH_PASS, FILL_CPU_MS)
            .filter(|_| case.counts())
            .zip(case.value(FILL_CPU_MS))
            .map(|(bound_ms, ms)| ms / bound_ms),
        "fill_cpu_ms_p5" => samples.map(|samples| samples.p5),
        "fill_cpu_ms_p95" => samples.map(|samples| samples.p95),
        metric => case.value(Metric::of(&METRICS, metric)),
    };
    value.map_or_else(String::new, |value| value.to_string())
}
