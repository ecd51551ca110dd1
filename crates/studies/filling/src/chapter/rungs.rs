// SPDX-License-Identifier: MIT OR Apache-2.0
//! The rungs of a ladder as they were measured, each with its gain.
//!
//! A rung is compared with the last one before it on the way whose picture is right; what stands aside is
//! on no way.

use super::data::{Data, grouped};
use crate::keys::*;
use terrafill_plot::number::{digits, measured_bytes};
use terrafill_results::{Case, ConditionKey, Estimate};

/// One rung as measured.
pub(super) struct Rung<'a> {
    pub(super) number: u32,
    pub(super) step: &'a str,
    /// What changes, in a sentence.
    pub(super) change: &'a str,
    pub(super) case: &'a Case,
    /// Beside the way: nothing is compared with it.
    pub(super) is_aside: bool,
    /// The last kept rung before it.
    pub(super) before: Option<&'a Case>,
    /// The step between both that is not right: what differs is its work as well as this one's.
    pub(super) skipped: Option<&'a str>,
    /// Time of that rung over this one's.
    pub(super) gain: Option<Estimate>,
}

impl<'a> Rung<'a> {
    pub(super) fn view(&self) -> &'a str {
        self.case.condition(VIEW)
    }

    /// Whether the next rung starts from it: it is right, and not aside.
    pub(super) fn is_kept(&self) -> bool {
        self.case.counts() && !self.is_aside
    }
}

/// A ladder on one view.
pub(super) struct Ladder<'a> {
    pub(super) title: String,
    pub(super) scene: &'a str,
    pub(super) view: &'a str,
    pub(super) technique: &'a str,
    pub(super) rungs: Vec<Rung<'a>>,
}

impl<'a> Ladder<'a> {
    /// The rung of a step.
    pub(super) fn step(&self, step: &str) -> Option<&Rung<'a>> {
        self.rungs.iter().find(|rung| rung.step == step)
    }
}

/// Conditions that number and name rungs, and the note that says what changes.
type Names = (ConditionKey, ConditionKey, &'static str);

/// Rungs of the way from the method of 2007 to the full plan.
pub(super) const FULL_PLAN: Names = (RUNG, STEP, "change");
/// Rungs of the way from everything that a fill can hold to what its view needs.
pub(super) const NEEDS: Names = (NEEDS_RUNG, NEEDS_STEP, "needs_change");

/// Every ladder of the run.
pub(super) fn ladders<'a>(data: &Data<'a>, names: Names) -> Vec<Ladder<'a>> {
    let cases = data.cases.iter().copied();
    let numbered = cases.filter_map(|case| Some((case.condition(names.0).parse().ok()?, case)));
    let key = |(_, case): &(u32, &'a Case)| [SCENE, VIEW, TECHNIQUE].map(|key| case.condition(key));
    let ladder = |([scene, view, technique], rungs): ([&'a str; 3], Vec<(u32, &'a Case)>)| Ladder {
        title: format!("{scene}, {view}: {technique}"),
        scene,
        view,
        technique,
        rungs: climb(data, names, rungs),
    };
    grouped(numbered, key).into_iter().map(ladder).collect()
}

/// Rungs by number, each with its gain.
fn climb<'a>(data: &Data<'a>, names: Names, mut cases: Vec<(u32, &'a Case)>) -> Vec<Rung<'a>> {
    cases.sort_by_key(|(number, _)| *number);
    let mut before: Option<&Case> = None;
    let mut skipped = None;
    let mut rungs = Vec::new();
    for (number, case) in cases {
        let rung = Rung {
            number,
            step: case.condition(names.1),
            change: case.note(names.2),
            case,
            is_aside: names == FULL_PLAN && case.condition(ASIDE) == "yes",
            before,
            skipped,
            gain: before.and_then(|before| data.timings.over(before, case)),
        };
        if rung.is_kept() {
            (before, skipped) = (Some(case), None);
        } else if !rung.is_aside {
            skipped = Some(rung.step);
        }
        rungs.push(rung);
    }
    rungs
}

/// What a step changes of the work that is done, in a sentence: why its gain may be what it is.
pub(super) fn counters(before: &Case, after: &Case) -> String {
    let metrics = [
        ("vertices", VERTICES),
        ("stencil fragments", STENCIL_FRAGMENTS),
        ("fragments shaded", FRAGMENT_SHADER_INVOCATIONS),
        ("draws", DRAWS),
        ("geometry bytes", GEOMETRY_BYTES),
        ("bytes handed over a frame", UPLOAD_BYTES),
    ];
    let changed = metrics.iter().filter_map(|(name, metric)| {
        let values = [before.value(*metric)?, after.value(*metric)?];
        let print = if metric.name.ends_with("bytes") {
            measured_bytes
        } else {
            digits
        };
        (values[0] != values[1])
            .then(|| format!("{name} {} → {}", print(values[0]), print(values[1])))
    });
    let changed: Vec<String> = changed.collect();
    if changed.is_empty() {
        "the same vertices, fragments, draws and bytes".to_owned()
    } else {
        changed.join(", ")
    }
}
