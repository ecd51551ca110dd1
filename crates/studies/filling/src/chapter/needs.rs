// SPDX-License-Identifier: MIT OR Apache-2.0
//! What each scene needs: the features built into a view's fill and those left out, each with its reason,
//! and what leaving out is worth, from everything that a fill can hold to only what is needed.
//!
//! Every figure is what the backend held and the device made; that sums agree is a requirement.

use super::ablations::{Ablation, NEEDS, counters, measured};
use super::data::{DEPTH_PASS, Data, distinct, grouped, name, title};
use super::table::{STATUS, head};
use crate::keys::*;
use crate::purpose::Purpose;
use terrafill_contract::{Feature, Need};
use terrafill_lab::{Column, StepsSection, none_differs};
use terrafill_plot::number::{count, digits};
use terrafill_results::{Block, Case, Cell, ChapterError, Finding, Row, Table};

const STEPS: [Column; 3] = [
    STATUS,
    Column::metric("bytes held", HELD_BYTES).written(digits),
    Column::metric("pipelines", HELD_PIPELINES),
];

/// Title of the section.
pub(super) const TITLE: &str = "What each scene needs";

/// What one case says of all features.
struct CaseNeeds<'a> {
    case: &'a Case,
    needs: Vec<Need>,
}

impl<'a> CaseNeeds<'a> {
    /// `None` of a case that says nothing.
    fn of(case: &'a Case) -> Option<Self> {
        let needs = Feature::ALL.iter();
        let needs = needs.filter_map(|&(feature, note)| Need::read(feature, case.note(note)));
        let needs: Vec<Need> = needs.collect();
        (!needs.is_empty()).then_some(Self { case, needs })
    }

    /// Names of features that are built in here and not there.
    fn without(&self, other: &Self) -> Vec<String> {
        let held = |told: &Self, feature| {
            let mut needs = told.needs.iter();
            needs.any(|need| need.feature == feature && need.is_held)
        };
        let own = self.needs.iter().filter(|need| need.is_held);
        let gone = own.filter(|need| !held(other, need.feature));
        gone.map(|need| shown(need.feature)).collect()
    }
}

/// A feature's name as it is read.
fn shown(feature: Feature) -> String {
    let name = feature.note();
    name.trim_start_matches("need_").replace('_', " ")
}

/// Every case that says what it holds.
fn all<'a>(data: &Data<'a>) -> Vec<CaseNeeds<'a>> {
    data.cases
        .iter()
        .copied()
        .filter_map(CaseNeeds::of)
        .collect()
}

/// Whether a case holds only what its view needs: the last of the steps, or the only one.
fn is_needed(data: &Data<'_>, case: &Case) -> bool {
    let number = |case: &Case| case.condition(NEEDS_RUNG).parse::<u32>().ok();
    let technique = case.condition(TECHNIQUE);
    let mut others = data.beside(case).iter();
    Purpose::Needs.is_of(case)
        && others.all(|other| {
            other.condition(TECHNIQUE) != technique
                || !Purpose::Needs.is_of(other)
                || number(other) <= number(case)
        })
}

/// The section.
pub(super) fn blocks(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    let all = all(data);
    if all.is_empty() {
        return Ok(Vec::new());
    }
    let mut blocks = head(
        TITLE,
        "What a fill holds for a view, and what it leaves out, each with the value that decided it. \
             Bytes are those of buffers and textures that the device was asked to make, pipelines likewise. \
             “Only what is needed” is the variant that decides by itself what each view needs: `terrafill \
             bench SCENE --ablation SCENE` measures the way there from everything that a fill can hold.",
    );
    let ablations = measured(data, NEEDS);
    for (scene, own) in grouped(&all, |told| told.case.condition(SCENE)) {
        blocks.push(Block::part(format!("Needs of {scene}")));
        let needed = own.iter().copied();
        let needed = needed.filter(|told| is_needed(data, told.case));
        for (technique, own) in grouped(needed, |told| told.case.condition(TECHNIQUE)) {
            blocks.push(Block::Table(features(technique, &own)));
        }
        for ablation in ablations.iter().filter(|ablation| ablation.scene == scene) {
            blocks.extend(ablation_blocks(data, ablation)?);
        }
    }
    Ok(blocks)
}

/// Everything that is made is declared; `None` for a run that tells nothing.
pub(super) fn requirement(data: &Data<'_>) -> Option<Finding> {
    let all = all(data);
    let differing: Vec<String> = all.iter().filter_map(disagreement).collect();
    let claim = "Every byte and pipeline that a fill holds belongs to a feature that says why.";
    let what = "fills declare what the device made for them";
    (!all.is_empty()).then(|| none_differs(claim, all.len(), &differing, what))
}

/// How sums over features differ from what the device made.
fn disagreement(told: &CaseNeeds<'_>) -> Option<String> {
    let case = told.case;
    let sum = |figure: fn(&Need) -> u64| told.needs.iter().map(figure).sum::<u64>();
    let declared = [
        ("bytes", MADE_BYTES, sum(|need| need.bytes)),
        ("pipelines", MADE_PIPELINES, sum(|need| need.pipelines)),
    ];
    let differing =
        declared
            .iter()
            .filter_map(|(what, metric, declared)| match case.value(*metric) {
                Some(made) if made == *declared as f64 => None,
                Some(made) => Some(format!("{declared} {what} declared, {made} made")),
                None => Some(format!("{what} made were not recorded")),
            });
    let differing: Vec<String> = differing.collect();
    (!differing.is_empty())
        .then(|| format!("{}: {}: {}", title(case), name(case), differing.join("; ")))
}

/// One row for each feature, and for each group of views of which the same is said.
fn features(technique: &str, needed: &[&CaseNeeds<'_>]) -> Table {
    let of_feature = |(feature, _): (Feature, _)| {
        let told = needed.iter().filter_map(move |told| {
            let need = told.needs.iter().find(|need| need.feature == feature)?;
            Some((need, told.case.condition(VIEW)))
        });
        grouped(told, |(need, _)| need.line()).into_iter()
    };
    let rows = Feature::ALL.into_iter().flat_map(of_feature);
    let rows = rows.map(|(_, same)| {
        let views: Vec<&str> = same.iter().map(|(_, view)| *view).collect();
        let need = same[0].0;
        let some =
            |number: u64, why: &str| Cell::or_absent((number > 0).then(|| count(number)), why);
        let cells = [
            Cell::name(if views.len() == needed.len() {
                "all".to_owned()
            } else {
                views.join(", ")
            }),
            Cell::name(if need.is_held { "yes" } else { "left out" }),
            some(need.bytes, "it has no buffer and no texture of its own"),
            some(need.pipelines, "no pipeline was made for it"),
            some(need.spared_bytes, "it is built in, or would take no bytes"),
            Cell::name(&need.reason),
        ];
        Row::named(Cell::name(shown(need.feature)), cells)
    });
    let variants = distinct(needed.iter().map(|told| told.case.condition(VARIANT)));
    let headings = [
        ("feature", ""),
        ("views", ""),
        ("built in", ""),
        ("bytes", "of its buffers and textures, as made"),
        ("pipelines", "made for it"),
        (
            "would take",
            "bytes that it would take, where it is left out and would take any",
        ),
        ("because", ""),
    ];
    Table {
        caption: format!(
            "Only what is needed, by {technique}: {}.",
            variants.join("; ")
        ),
        ..Table::of(headings, rows.collect())
    }
}

/// The way from everything to what is needed.
fn ablation_blocks(data: &Data<'_>, ablation: &Ablation<'_>) -> Result<Vec<Block>, ChapterError> {
    let title = format!(
        "{}, {}: time over depth-pass, from everything to what is needed",
        ablation.scene, ablation.view
    );
    let changed =
        |before: &Case, after: &Case| match CaseNeeds::of(before).zip(CaseNeeds::of(after)) {
            None => Cell::absent("one of both says nothing of its features"),
            Some((told, now)) => Cell {
                detail: counters(before, after),
                ..Cell::name(change(&told, &now))
            },
        };
    let heading = Block::part(format!(
        "From everything to what {} needs, by {}",
        ablation.view, ablation.technique
    ));
    let section = StepsSection {
        title: &title,
        baseline: DEPTH_PASS,
        columns: &STEPS,
        is_main: true,
    };
    let blocks = ablation.blocks(data, section, changed)?;
    Ok([vec![heading], blocks].concat())
}

/// What a step left out and brought in.
fn change(before: &CaseNeeds<'_>, after: &CaseNeeds<'_>) -> String {
    let (gone, come) = (before.without(after), after.without(before));
    match (gone.is_empty(), come.is_empty()) {
        (true, true) => "the same features".to_owned(),
        (false, true) => format!("without {}", gone.join(", ")),
        (true, false) => format!("with {}", come.join(", ")),
        (false, false) => format!("with {} in place of {}", come.join(", "), gone.join(", ")),
    }
}

#[cfg(test)]
mod tests;
