// SPDX-License-Identifier: MIT OR Apache-2.0
//! Subdivision against wall height: coarse caps need tall walls to contain the terrain, fine ones need
//! triangles.
//!
//! How tall walls must be at most follows from the step: `terrafill_core::MeshOptions::sagitta_bound_m`.

use super::data::{Data, Timed, grouped, layout_name, one_change, title};
use crate::keys::*;
use crate::purpose::Purpose;
use terrafill_lab::{Cases, Column, Figure, Names, Section, Select, finding};
use terrafill_plot::number::significant;
use terrafill_results::{Block, Case, ChapterError, ConditionKey, Finding};

/// The switch whose values are swept.
const KNOB: ConditionKey = CAP_STEP;

/// The sweep's cases, finest first in each view, as they are planned.
const SECTION: Section<'static> = Section {
    title: "Subdivision against wall height",
    text: "A coarse cap bends away from the ground, so its volume must reach higher to hold the \
           terrain; a fine one needs more triangles. The volume's heights follow from the mesh, so every \
           picture must be right. By formula: with a step s, in radians between the normals of an edge's \
           ends, a body of radii a and b, ρ = a²/b and R = b²/a, no facet hangs deeper than R − √(R² − r²) \
           with r = √3/2 ρ s, and no wall is taller than the terrain and that.",
    cases: Select::Fitting(is_swept),
    named_by: Names::Of("scene, view: layout", name),
    columns: &[
        Column::of("cap step, °", Figure::Condition(KNOB)),
        Column::metric("triangles of caps", CAP_TRIANGLES),
        Column::metric("tallest wall, m", WALL_HEIGHT_M),
        Column::metric("at most by formula, m", WALL_BOUND_M),
        Column::clocked("fill, ms", FILL_GPU_MS, FILL_CPU_MS),
        Column::metric("stencil fragments", STENCIL_FRAGMENTS),
        Column::metric("px that differ", MISMATCHED_PX),
        Column::metric("outside band", MISMATCHED_PX_OUTSIDE_BAND),
        Column::metric("Hausdorff, px", HAUSDORFF_PX),
    ],
    findings: &[walls_by_formula],
    ..Section::EMPTY
};

/// Every mesh of the sweep; nothing for a run without it.
pub(super) fn blocks(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    SECTION.blocks(&data.study)
}

fn is_swept(case: &Case) -> bool {
    Purpose::Subdivision.is_of(case)
}

/// Meshes of one technique: another draws the same mesh in another time.
fn name(case: &Case) -> String {
    format!("{}: {}", title(case), layout_name(case))
}

/// Time of the coarsest mesh over that of the finest, for each view with at least two.
pub(super) fn coarsest_over_finest<'a>(data: &Data<'a>) -> Vec<Timed<'a>> {
    let own = data.cases.iter().copied().filter(|case| is_swept(case));
    let swept = own.filter_map(|case| Some((case.condition(KNOB).parse::<f64>().ok()?, case)));
    let sweeps = grouped(swept, |(_, case)| name(case)).into_iter();
    let timed = sweeps.filter_map(|(title, mut cases)| {
        cases.sort_by(|a, b| a.0.total_cmp(&b.0));
        // A step that cuts nothing gives the mesh of a finer one, and says nothing of steps.
        cases.dedup_by(|(_, a), (_, b)| {
            let [a, b] = [a, b].map(|case| case.value(CAP_TRIANGLES));
            a.is_some() && a == b
        });
        let [(_, fine), .., (_, coarse)] = cases[..] else {
            return None;
        };
        Some(Timed {
            title,
            pairing: one_change(KNOB),
            cases: [coarse, fine],
        })
    });
    timed.collect()
}

/// Whether walls are as low as the formula says.
fn walls_by_formula(swept: &Cases<'_>) -> Finding {
    let walls = swept.iter().filter_map(|case| {
        let (found, bound) = (case.value(WALL_HEIGHT_M)?, case.value(WALL_BOUND_M)?);
        let [of, most] = [found, bound].map(significant);
        let [scene, view, step] = [SCENE, VIEW, KNOB].map(|key| case.condition(key));
        let text = format!("{scene}, {view}, {step}°: {of} of {most} m");
        Some((text, found <= bound))
    });
    let (texts, are_within): (Vec<String>, Vec<bool>) = walls.unzip();
    let is_within = are_within.iter().all(|is_within| *is_within);
    finding(
        "No wall is taller than the sagitta of its cap step asks for.",
        (!texts.is_empty()).then_some(is_within),
        texts.join(", "),
    )
}
