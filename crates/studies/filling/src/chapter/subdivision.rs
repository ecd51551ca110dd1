// SPDX-License-Identifier: MIT OR Apache-2.0
//! Subdivision against wall height: coarse caps need tall walls to contain the terrain, fine ones need
//! triangles.
//!
//! Cozzi (2007, 2.1.7.2) expected coarse meshes with tall walls to win and left it unmeasured. How tall they
//! must be at most follows from the step: `terrafill_core::MeshOptions::sagitta_bound_m`.

use super::data::{
    DEPTH_PASS, Data, Timed, counter, grouped, has_role, layout_name, one_change, title,
};
use super::rungs::SOURCE;
use super::table::Show::{Count, Figure, Median, Over, Own};
use super::table::{Column, head, part, table};
use crate::keys::*;
use terrafill_plot::number::significant;
use terrafill_results::{Block, Case, Cell, Claim, ConditionKey, Finding, Standing};

/// The switch whose values are swept.
const KNOB: ConditionKey = CAP_STEP;

const COLUMNS: [Column; 10] = [
    ("cap step", Own("")),
    ("triangles of caps", Count(CAP_TRIANGLES)),
    ("tallest wall, m", Figure(WALL_HEIGHT_M)),
    ("at most by formula, m", Figure(WALL_BOUND_M)),
    ("fill, {unit}", Median),
    ("÷\u{a0}depth-pass", Over(DEPTH_PASS)),
    ("stencil fragments", Count(STENCIL_FRAGMENTS)),
    ("px that differ", Count(MISMATCHED_PX)),
    ("outside band", Count(MISMATCHED_PX_OUTSIDE_BAND)),
    ("Hausdorff, px", Figure(HAUSDORFF_PX)),
];

/// Meshes of one view by their cap steps, degrees, finest first.
struct Sweep<'a> {
    title: String,
    cases: Vec<(f64, &'a Case)>,
}

/// Every view with at least two cap steps.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let sweeps = sweeps(data);
    if sweeps.is_empty() {
        return Vec::new();
    }
    let mut blocks = head(
        "Subdivision against wall height",
        "A coarse cap bends away from the ground, so its volume must reach higher to hold the \
             terrain; a fine one needs more triangles. Cozzi (2007, 2.1.7.2) anticipated of it: \
             “the extra subdivision is not going to payoff”, and left it unmeasured. The volume's \
             heights follow from the mesh, so every picture must be right. By formula: with a step s, \
             in radians between the normals of an edge's ends, a body of radii a and b, ρ = a²/b and \
             R = b²/a, no facet hangs deeper than R − √(R² − r²) with r = √3/2 ρ s, and no wall is \
             taller than the terrain and that.",
    );
    for sweep in &sweeps {
        blocks.push(part(format!("Cap steps of {}", sweep.title)));
        let cases = sweep.cases.iter();
        let rows = cases.map(|(step, case)| (*case, vec![Cell::name(format!("{step}°"))]));
        blocks.push(Block::Table(table(data, &COLUMNS, rows)));
        blocks.extend(finding(data, sweep).map(Block::Finding));
        blocks.extend(walls_by_formula(sweep).map(Block::Finding));
    }
    blocks
}

fn sweeps<'a>(data: &Data<'a>) -> Vec<Sweep<'a>> {
    let own = data.cases.iter().copied();
    let own = own.filter(|case| has_role(case, "subdivision"));
    let swept = own.filter_map(|case| Some((case.condition(KNOB).parse::<f64>().ok()?, case)));
    // Meshes of one technique: another draws the same mesh in another time.
    let name = |(_, case): &(f64, &'a Case)| format!("{}: {}", title(case), layout_name(case));
    let sweeps = grouped(swept, name).into_iter().map(|(title, mut cases)| {
        cases.sort_by(|a, b| a.0.total_cmp(&b.0));
        // A step that cuts nothing gives the mesh of a finer one, and says nothing of steps.
        cases.dedup_by_key(|(_, case)| counter(case, CAP_TRIANGLES).ok_or_else(|| case.id().key()));
        Sweep { title, cases }
    });
    sweeps.filter(|sweep| sweep.cases.len() >= 2).collect()
}

/// Time of the coarsest mesh over that of the finest, for each view.
pub(super) fn coarsest_over_finest<'a>(data: &Data<'a>) -> Vec<Timed<'a>> {
    let of = |sweep: Sweep<'a>| {
        let (fine, coarse) = (sweep.cases.first()?.1, sweep.cases.last()?.1);
        Some(Timed {
            title: sweep.title,
            pairing: one_change(KNOB),
            cases: [coarse, fine],
        })
    };
    sweeps(data).into_iter().filter_map(of).collect()
}

/// Whether the coarsest mesh is faster than the finest.
fn finding(data: &Data<'_>, sweep: &Sweep<'_>) -> Option<Finding> {
    let (fine, coarse) = (sweep.cases.first()?, sweep.cases.last()?);
    let timed = Timed {
        title: sweep.title.clone(),
        pairing: one_change(KNOB),
        cases: [fine.1, coarse.1],
    };
    let answer = timed.answer(data, Claim::Faster);
    answer.figure.as_ref().map(|gain| Finding {
        claim: format!(
            "{SOURCE}, 2.1.7.2, anticipated: “the extra subdivision is not going to payoff”. Coarse and \
             tall is faster."
        ),
        standing: answer.standing,
        because: format!(
            "{}° fills {} as fast as {}° {}",
            coarse.0,
            data.ratio_text(gain),
            fine.0,
            answer.because
        )
        .trim_end()
        .to_owned(),
    })
}

/// Whether walls are as low as the formula says; nothing where no case has both figures.
fn walls_by_formula(sweep: &Sweep<'_>) -> Option<Finding> {
    let walls = sweep.cases.iter().filter_map(|(step, case)| {
        let (found, bound) = (case.value(WALL_HEIGHT_M)?, case.value(WALL_BOUND_M)?);
        let [of, most] = [found, bound].map(significant);
        Some((format!("{step}°: {of} of {most} m"), found <= bound))
    });
    let (texts, are_within): (Vec<String>, Vec<bool>) = walls.unzip();
    (!texts.is_empty()).then(|| Finding {
        claim: "No wall is taller than the sagitta of its cap step asks for.".to_owned(),
        standing: Standing::holds_if(are_within.iter().all(|is_within| *is_within)),
        because: texts.join(", "),
    })
}
