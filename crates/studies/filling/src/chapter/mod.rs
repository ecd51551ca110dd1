// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on filling: scenes with their techniques, the ladder from 2007, the matrix of switches,
//! bytes of layouts, textured fills, and what the measurements say of published claims.
//!
//! It reads cases, metrics and notes of a run and nothing else. Ratios, rankings and plots use the
//! run's clock: [`Run::clock`].

mod answers;
mod approximate;
mod claims;
mod comparisons;
mod data;
mod error_time;
mod fill_rate;
mod fronts;
mod ladder;
mod matrix;
mod memory;
mod needs;
mod published;
mod rivals;
mod rungs;
mod scenes;
mod subdivision;
mod summary;
mod table;
mod techniques;
#[cfg(test)]
mod tests;
mod textured;

use crate::keys::{FILL_CPU_MS, FILL_GPU_MS, MISMATCHED_PX_OUTSIDE_BAND};
use crate::request::STUDY;
pub(crate) use data::grouped;
use data::{Data, is_baseline};
use rungs::FULL_PLAN;
pub(crate) use scenes::picture;
pub(crate) use table::{alarm, figures, row};
use terrafill_lab::{with_command, with_commands};
use terrafill_results::{
    Answers, Block, Case, Chapter, ChapterError, Clock, DerivedTable, Outcome, Run,
};

/// What filling regions costs and how right it is.
#[derive(Debug, Clone, Copy, Default)]
pub struct FillingChapter;

impl FillingChapter {
    fn data<'a>(&self, run: &'a Run) -> Data<'a> {
        Data::new(run, run.clock().pick(FILL_GPU_MS, FILL_CPU_MS))
    }
}

impl Chapter for FillingChapter {
    fn study(&self) -> &'static str {
        STUDY
    }

    fn title(&self) -> &'static str {
        "Region fill on terrain"
    }

    fn primary_metric(&self, clock: Clock) -> Option<&'static str> {
        Some(clock.pick(FILL_GPU_MS, FILL_CPU_MS).name)
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let data = self.data(run);
        let ladders = rungs::ladders(&data, FULL_PLAN);
        let sections = [
            pictures_sentence(&data).into_iter().collect(),
            fronts::section(&data)?,
            approximate::blocks(&data),
            claims::blocks(&data, &ladders),
            ladder::blocks(&data, &ladders)?,
            comparisons::walls(&data, &ladders),
            rivals::blocks(&data),
            comparisons::pairs(&data),
            matrix::blocks(&data),
            memory::blocks(&data)?,
            needs::blocks(&data)?,
            comparisons::scales(&data),
            subdivision::blocks(&data)?,
            textured::blocks(&data),
            scenes::blocks(&data)?,
            techniques::blocks(&data),
        ];
        let blocks = sections.into_iter().flatten().collect();
        Ok(with_commands(blocks, run, STUDY))
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let mut answers = answers::answers(&self.data(run))?;
        let requirements = answers.requirements.into_iter();
        let requirements = requirements.map(|finding| with_command(finding, run, STUDY));
        answers.requirements = requirements.collect();
        Ok(answers)
    }

    fn has_long_sections(&self) -> bool {
        true
    }

    fn contradictions(&self, run: &Run) -> Vec<String> {
        let data = self.data(run);
        data.cases
            .iter()
            .filter_map(|case| contradiction(&data, case))
            .collect()
    }

    fn tables(&self, run: &Run) -> Result<Vec<DerivedTable>, ChapterError> {
        let data = self.data(run);
        if data.cases.is_empty() {
            return Ok(Vec::new());
        }
        let ladders = rungs::ladders(&data, FULL_PLAN);
        Ok(vec![
            summary::table(&data)?,
            claims::table(&data, &ladders)?,
        ])
    }

    fn undecided(&self, run: &Run) -> Vec<String> {
        let data = self.data(run);
        claims::undecided(&data, &rungs::ladders(&data, FULL_PLAN))
    }
}

/// What in a case's figures contradicts its outcome.
fn contradiction(data: &Data<'_>, case: &Case) -> Option<String> {
    let samples = case.samples(data.metric).into_iter().flatten();
    let times = samples.flat_map(|(_, of_process)| of_process.values());
    let (all, usable) = times.fold((0_usize, 0_usize), |(all, usable), ms| {
        (all + 1, usable + usize::from(ms.is_finite() && *ms > 0.0))
    });
    if usable < all {
        let (name, lost) = (case.id(), all - usable);
        return Some(format!(
            "{name}: {lost} of {all} times are 0, negative or not finite; left out"
        ));
    }
    (case.outcome == Outcome::Ok && !is_baseline(case))
        .then(|| never_right(case))
        .flatten()
}

/// What contradicts that a case is right.
pub(crate) fn never_right(case: &Case) -> Option<String> {
    let name = case.id();
    match case.value(MISMATCHED_PX_OUTSIDE_BAND) {
        None => Some(format!("{name}: ok, but never compared with the reference")),
        Some(px) if px > 0.0 => Some(format!(
            "{name}: ok, though {px} pixels outside the boundary band are wrong"
        )),
        Some(_) => None,
    }
}

/// Which pictures were compared and whether they match, seen at once where some do not.
fn pictures_sentence(data: &Data<'_>) -> Option<Block> {
    let scope = answers::scope(data)?;
    Some(match answers::wrong(data) {
        0 => Block::Text(scope),
        _ => Block::Alarm(scope),
    })
}
