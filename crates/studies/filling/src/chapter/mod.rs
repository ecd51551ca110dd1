// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on filling: scenes with their techniques, the ladder from 2007, the matrix of switches,
//! bytes of layouts, textured fills, and what the measurements say of published claims.
//!
//! It reads cases, metrics and notes of a run and nothing else. Ratios, rankings and plots use the
//! run's clock: [`Run::clock`].

mod answers;
mod approximate;
mod claims;
mod data;
mod error_time;
mod exponent;
mod fill_rate;
mod fronts;
mod ladder;
mod matrix;
mod memory;
mod needs;
mod pairs;
mod published;
mod rivals;
mod rungs;
mod scenes;
mod subdivision;
mod summary;
mod techniques;
#[cfg(test)]
mod tests;
mod textured;
mod walls;

use crate::keys::{FILL_CPU_MS, FILL_GPU_MS, MISMATCHED_PX_OUTSIDE_BAND};
use crate::request::STUDY;
use data::{Data, is_baseline};
use terrafill_results::{Answers, Block, Chapter, ChapterError, Clock, DerivedTable, Outcome, Run};

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
        let mut blocks = Vec::new();
        blocks.extend(pictures_sentence(&data));
        blocks.extend(scenes::overview(&data));
        blocks.extend(fronts::section(&data)?);
        blocks.extend(approximate::blocks(&data)?);
        let ladders = rungs::ladders(&data);
        blocks.extend(claims::blocks(&data, &ladders));
        blocks.extend(ladder::blocks(&data, &ladders)?);
        blocks.extend(walls::blocks(&data, &ladders));
        blocks.extend(rivals::blocks(&data));
        blocks.extend(pairs::blocks(&data));
        blocks.extend(matrix::blocks(&data));
        blocks.extend(memory::blocks(&data)?);
        blocks.extend(needs::blocks(&data)?);
        blocks.extend(exponent::blocks(&data));
        blocks.extend(subdivision::blocks(&data)?);
        blocks.extend(textured::blocks(&data));
        blocks.extend(scenes::blocks(&data)?);
        blocks.extend(techniques::blocks(&data));
        Ok(blocks)
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        answers::answers(&self.data(run))
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
        let ladders = rungs::ladders(&data);
        Ok(vec![
            summary::table(&data)?,
            claims::table(&data, &ladders)?,
        ])
    }

    fn undecided(&self, run: &Run) -> Vec<String> {
        let data = self.data(run);
        claims::undecided(&data, &rungs::ladders(&data))
    }
}

/// What in a case's figures contradicts its outcome.
fn contradiction(data: &Data<'_>, case: &terrafill_results::Case) -> Option<String> {
    let outside = case.value(MISMATCHED_PX_OUTSIDE_BAND);
    let name = case.id();
    let samples = case.samples(data.metric).into_iter().flatten();
    let times = samples.flat_map(|(_, of_process)| of_process.values());
    let (all, usable) = times.fold((0_usize, 0_usize), |(all, usable), ms| {
        (all + 1, usable + usize::from(ms.is_finite() && *ms > 0.0))
    });
    if usable < all {
        let lost = all - usable;
        return Some(format!(
            "{name}: {lost} of {all} times are 0, negative or not finite; left out"
        ));
    }
    match outside {
        _ if case.outcome != Outcome::Ok || is_baseline(case) => None,
        None => Some(format!("{name}: ok, but never compared with the reference")),
        Some(px) if px > 0.0 => Some(format!(
            "{name}: ok, though {px} pixels outside the boundary band are wrong"
        )),
        Some(_) => None,
    }
}

/// Whether the pictures match the reference, those aside whose error is the question.
fn pictures_sentence(data: &Data<'_>) -> Option<Block> {
    if data.cases.is_empty() {
        return None;
    }
    let outside = |case: &terrafill_results::Case| data::counter(case, MISMATCHED_PX_OUTSIDE_BAND);
    let has_to_match = |case: &&&terrafill_results::Case| {
        !case.planned.may_be_wrong && case.outcome != Outcome::DriverFault
    };
    let cases = data.cases.iter().filter(has_to_match);
    let compared: Vec<_> = cases.filter(|case| outside(case).is_some()).collect();
    let differing = compared
        .iter()
        .filter(|case| outside(case) != Some(0) || case.outcome == Outcome::Wrong)
        .count();
    Some(match (compared.len(), differing) {
        (0, _) => Block::Text("No picture was compared with the reference.".to_owned()),
        (all, 0) => Block::Text(format!(
            "Every picture that was compared ({all}) matches the reference outside the 1-pixel \
             boundary band."
        )),
        (all, some) => Block::Alarm(format!(
            "{some} of {all} compared pictures do not match the reference."
        )),
    })
}
