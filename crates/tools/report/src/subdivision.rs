// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on subdivision against wall height: coarse caps need tall walls to contain the
//! terrain, fine ones need triangles.
//!
//! Cozzi (2007, 2.1.7.2) expected coarse meshes with tall walls to win and left it unmeasured.

use crate::interval::{Claim, gain};
use crate::number::{count, significant};
use crate::plot::{Curve, Point, Reading, Standing};
use crate::run_data::{Case, Outcome, RunData};

/// The switch whose values are swept.
const KNOB: &str = "cap-step-deg=";

/// Meshes of one view by their cap steps.
pub(crate) struct SubdivisionTable {
    pub(crate) title: String,
    pub(crate) rows: Vec<SubdivisionRow>,
    /// What became of the expectation, with class and words of its standing.
    pub(crate) finding: Option<(String, &'static str, &'static str)>,
    /// Fill time, then wall height, over the cap step.
    pub(crate) times: Vec<Curve>,
    pub(crate) walls: Vec<Curve>,
}

/// One mesh.
pub(crate) struct SubdivisionRow {
    pub(crate) name: String,
    pub(crate) cells: Vec<String>,
    pub(crate) is_wrong: bool,
}

/// Value of the knob as the variant names it, degrees.
fn cap_step_deg(case: &Case) -> Option<f64> {
    let mut switches = case.key.variant.split(',');
    switches.find_map(|switch| switch.strip_prefix(KNOB)?.parse().ok())
}

/// A table for each view with at least two cap steps.
pub(crate) fn tables(data: &RunData) -> Vec<SubdivisionTable> {
    let mut views: Vec<(&str, &str)> = Vec::new();
    for case in data
        .cases
        .iter()
        .filter(|case| cap_step_deg(case).is_some())
    {
        let view = (case.key.scene.as_str(), case.key.view.as_str());
        if !views.contains(&view) {
            views.push(view);
        }
    }
    views
        .into_iter()
        .filter_map(|(scene, view)| table(data, scene, view))
        .collect()
}

fn table(data: &RunData, scene: &str, view: &str) -> Option<SubdivisionTable> {
    let mut cases: Vec<(f64, &Case)> = data
        .cases
        .iter()
        .filter(|case| case.key.scene == scene && case.key.view == view)
        .filter_map(|case| Some((cap_step_deg(case)?, case)))
        .collect();
    cases.sort_by(|a, b| a.0.total_cmp(&b.0));
    if cases.len() < 2 {
        return None;
    }
    let title = format!("{scene}, {view}");
    Some(SubdivisionTable {
        rows: cases.iter().map(|(step, case)| row(*step, case)).collect(),
        finding: finding(data, &cases),
        times: vec![curve(&title, &cases, |case| {
            let spread = case.fill_cpu.filter(|_| case.counts())?;
            Some(Reading::sampled(spread, &case.fill_cpu_ms))
        })],
        walls: vec![curve(&title, &cases, |case| {
            case.value(|row| row.wall_height_m).map(Reading::exact)
        })],
        title,
    })
}

fn row(step: f64, case: &Case) -> SubdivisionRow {
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
    let time = case.fill_cpu.filter(|_| case.counts());
    SubdivisionRow {
        name: format!("{step}°"),
        cells: vec![
            or_dash(case.value(|row| row.cap_triangles).map(count)),
            or_dash(case.value(|row| row.wall_height_m).map(significant)),
            or_dash(time.map(|ms| significant(ms.median))),
            or_dash(case.value(|row| row.fill_over_bound_cpu).map(significant)),
            or_dash(case.value(|row| row.stencil_fragments).map(count)),
            or_dash(case.value(|row| row.mismatched_px).map(count)),
            or_dash(case.value(|row| row.mismatched_px_outside_band).map(count)),
            or_dash(case.value(|row| row.hausdorff_px).map(significant)),
        ],
        is_wrong: case.outcome != Outcome::Ok,
    }
}

/// Whether the coarsest mesh is faster than the finest, in the same rounds.
fn finding(data: &RunData, cases: &[(f64, &Case)]) -> Option<(String, &'static str, &'static str)> {
    let (fine, coarse) = (cases.first()?, cases.last()?);
    let frames = |case: &Case| data.frames.get(&case.key).filter(|_| case.counts());
    let gain = gain(frames(fine.1)?, frames(coarse.1)?)?;
    let standing = Claim::Faster.standing(gain);
    let text = format!(
        "{}° fills {} times as fast as {}° ({} … {})",
        coarse.0,
        significant(gain.middle),
        fine.0,
        significant(gain.low),
        significant(gain.high),
    );
    Some((text, standing.class(), standing.name()))
}

fn curve(name: &str, cases: &[(f64, &Case)], height: impl Fn(&Case) -> Option<Reading>) -> Curve {
    let points = cases.iter().map(|(step, case)| {
        let y = height(case);
        Point {
            knob: *step,
            label: String::new(),
            x: Some(Reading::exact(*step)),
            standing: if y.is_some() {
                Standing::Right
            } else {
                Standing::Failed
            },
            y,
            y_rms: None,
        }
    });
    Curve {
        name: name.to_owned(),
        points: points.collect(),
    }
}
