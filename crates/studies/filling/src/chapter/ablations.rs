// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ablations as they were measured: ablations of one technique on one view.

use super::data::{Data, grouped, name};
use crate::keys::*;
use terrafill_lab::{AblationStep, ShownStep, StepKeys, StepsSection, ablation, changed_work};
use terrafill_results::{Block, Case, Cell, ChapterError};

/// An ablation on one view.
pub(super) struct Ablation<'a> {
    pub(super) title: String,
    pub(super) scene: &'a str,
    pub(super) view: &'a str,
    pub(super) technique: &'a str,
    pub(super) steps: Vec<AblationStep<'a>>,
}

impl<'a> Ablation<'a> {
    /// The step of that name.
    pub(super) fn step(&self, name: &str) -> Option<&AblationStep<'a>> {
        self.steps.iter().find(|step| step.name == name)
    }

    /// Its steps over the depth-pass, as a plot and a table.
    ///
    /// - `changed`: what a step changed of the work
    pub(super) fn blocks(
        &self,
        data: &Data<'_>,
        section: StepsSection<'_>,
        changed: impl Fn(&Case, &Case) -> Cell,
    ) -> Result<Vec<Block>, ChapterError> {
        let show = |case: &Case| ShownStep {
            name: name(case),
            over_baseline: data.spread_over_depth_pass(case),
            command: data.command(case),
        };
        section.blocks(&data.study, data.timings, &self.steps, show, changed)
    }
}

/// Steps of the way from the method of 2007 to the full plan.
pub(super) const FULL_PLAN: StepKeys = StepKeys {
    number: RUNG,
    name: STEP,
    aside: Some(ASIDE),
    change: "change",
};
/// Steps of the way from everything that a fill can hold to what its view needs.
pub(super) const NEEDS: StepKeys = StepKeys {
    number: NEEDS_RUNG,
    name: NEEDS_STEP,
    aside: None,
    change: "needs_change",
};

/// Every ablation of the run.
pub(super) fn measured<'a>(data: &Data<'a>, keys: StepKeys) -> Vec<Ablation<'a>> {
    let cases = data.cases.iter().copied();
    let of_ablations = cases.filter(|case| !case.condition(keys.number).is_empty());
    let key = |case: &&'a Case| [SCENE, VIEW, TECHNIQUE].map(|key| case.condition(key));
    let ablations = grouped(of_ablations, key).into_iter();
    let ablations = ablations.map(|([scene, view, technique], cases)| Ablation {
        title: format!("{scene}, {view}: {technique}"),
        scene,
        view,
        technique,
        steps: ablation(data.timings, keys, cases),
    });
    ablations.collect()
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
    changed_work(&metrics, before, after)
        .unwrap_or_else(|| "the same vertices, fragments, draws and bytes".to_owned())
}
