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
use terrafill_lab::{Column, StepsSection, none_differs};
use terrafill_plot::number::{count, digits};
use terrafill_results::{Block, Case, CaseFeature, Cell, ChapterError, Finding, Row, Table};

const STEPS: [Column; 3] = [
    STATUS,
    Column::metric("bytes held", HELD_BYTES).written(digits),
    Column::metric("pipelines", HELD_PIPELINES),
];

/// Title of the section.
pub(super) const TITLE: &str = "What each scene needs";

/// Names of features that `case` holds and `other` does not.
fn without(case: &Case, other: &Case) -> Vec<String> {
    let is_held = |of: &CaseFeature| {
        let mut others = other.features().iter();
        others.any(|found| found.feature == of.feature && found.is_held)
    };
    let own = case.features().iter().filter(|of| of.is_held);
    let gone = own.filter(|of| !is_held(of));
    gone.map(|of| of.feature.clone()).collect()
}

/// Every case that says what it holds.
fn all<'a>(data: &Data<'a>) -> Vec<&'a Case> {
    let cases = data.cases.iter().copied();
    cases.filter(|case| !case.features().is_empty()).collect()
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
    for (scene, own) in grouped(all, |case| case.condition(SCENE)) {
        blocks.push(Block::part(format!("Needs of {scene}")));
        let needed = own.iter().copied().filter(|case| is_needed(data, case));
        for (technique, own) in grouped(needed, |case| case.condition(TECHNIQUE)) {
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
    let differing: Vec<String> = all.iter().copied().filter_map(disagreement).collect();
    let claim = "Every byte and pipeline that a fill holds belongs to a feature that says why.";
    let what = "fills declare what the device made for them";
    (!all.is_empty()).then(|| none_differs(claim, all.len(), &differing, what))
}

/// How sums over features differ from what the device made.
fn disagreement(case: &Case) -> Option<String> {
    let sum = |figure: fn(&CaseFeature) -> u64| case.features().iter().map(figure).sum::<u64>();
    let declared = [
        ("bytes", MADE_BYTES, sum(|of| of.bytes)),
        ("pipelines", MADE_PIPELINES, sum(|of| of.pipelines)),
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
fn features(technique: &str, needed: &[&Case]) -> Table {
    let said = || {
        let needed = needed.iter();
        needed.map(|case| (case.condition(VIEW), case.features()))
    };
    let names =
        distinct(said().flat_map(|(_, features)| features.iter().map(|of| of.feature.as_str())));
    let of_name = |name: &str| {
        let own = said().filter_map(|(view, features)| {
            let found = features.iter().find(|of| of.feature == name)?;
            Some((found, view))
        });
        grouped(own, |(found, _)| (*found).clone())
    };
    let rows = names.into_iter().flat_map(of_name);
    let rows = rows.map(|(of, same)| {
        let views: Vec<&str> = same.iter().map(|(_, view)| *view).collect();
        let some =
            |number: u64, why: &str| Cell::or_absent((number > 0).then(|| count(number)), why);
        let cells = [
            Cell::name(if views.len() == needed.len() {
                "all".to_owned()
            } else {
                views.join(", ")
            }),
            Cell::name(if of.is_held { "yes" } else { "left out" }),
            some(of.bytes, "it has no buffer and no texture of its own"),
            some(of.pipelines, "no pipeline was made for it"),
            some(of.spared_bytes, "it is built in, or would take no bytes"),
            Cell::name(&of.reason),
        ];
        Row::named(Cell::name(&of.feature), cells)
    });
    let variants = distinct(needed.iter().map(|case| case.condition(VARIANT)));
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
    let changed = |before: &Case, after: &Case| {
        if before.features().is_empty() || after.features().is_empty() {
            return Cell::absent("one of both says nothing of its features");
        }
        Cell {
            detail: counters(before, after),
            ..Cell::name(change(before, after))
        }
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
fn change(before: &Case, after: &Case) -> String {
    let (gone, come) = (without(before, after), without(after, before));
    match (gone.is_empty(), come.is_empty()) {
        (true, true) => "the same features".to_owned(),
        (false, true) => format!("without {}", gone.join(", ")),
        (true, false) => format!("with {}", come.join(", ")),
        (false, false) => format!("with {} in place of {}", come.join(", "), gone.join(", ")),
    }
}

#[cfg(test)]
mod tests;
