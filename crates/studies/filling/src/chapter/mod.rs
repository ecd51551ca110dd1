// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on filling: scenes with their techniques, the ablation from 2007, the matrix of switches,
//! bytes of layouts, textured fills, and what the measurements say of published claims.
//!
//! It reads cases, metrics and notes of a run and nothing else. Ratios, rankings and plots use the
//! run's clock: [`Run::clock`].

mod ablations;
mod answers;
mod approximate;
mod budget;
mod claims;
mod comparisons;
mod contest;
mod data;
mod error_time;
mod from_2007;
mod matrix;
mod memory;
mod needs;
mod rivals;
mod scenes;
mod subdivision;
mod summary;
mod table;
mod take;
#[cfg(test)]
mod tests;
mod textured;

pub use answers::answer_text;

use crate::keys::{FILL_CPU_MS, FILL_GPU_MS};
use crate::purpose::never_right;
use crate::request::STUDY;
use ablations::FULL_PLAN;
use data::{Data, is_baseline};
use terrafill_lab::{answers_with_commands, with_commands};
use terrafill_results::{
    Answers, Block, Budget, Case, Chapter, ChapterError, Clock, DerivedTable, Outcome, Run, Term,
};

/// What filling regions costs and how right it is.
#[derive(Debug, Clone, Copy, Default)]
pub struct FillingChapter;

impl Chapter for FillingChapter {
    fn study(&self) -> &'static str {
        STUDY
    }

    fn title(&self) -> &'static str {
        "Region fill on terrain"
    }

    fn question(&self) -> &'static str {
        "Which technique fills regions on a surface with which error, time and memory?"
    }

    fn terms(&self) -> &'static [Term] {
        crate::keys::TERMS
    }

    fn primary_metric(&self, clock: Clock) -> Option<&'static str> {
        Some(clock.pick(FILL_GPU_MS, FILL_CPU_MS).name)
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let data = Data::new(run);
        let ablations = ablations::measured(&data, FULL_PLAN);
        let sections = [
            approximate::blocks(&data),
            claims::blocks(&data, &ablations),
            from_2007::blocks(&data, &ablations)?,
            rivals::blocks(&data),
            comparisons::pairs(&data),
            matrix::blocks(&data),
            memory::blocks(&data)?,
            needs::blocks(&data)?,
            subdivision::blocks(&data)?,
            textured::blocks(&data),
            scenes::blocks(&data)?,
        ];
        let answer = self.answers(run)?.blocks.into_iter();
        let lead = answer.filter(|block| matches!(block, Block::Lead(_)));
        let blocks = lead.chain(sections.into_iter().flatten()).collect();
        Ok(with_commands(blocks, run, STUDY))
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let data = Data::new(run);
        let mut answers = answers::answers(&data)?;
        let within = budget::block(&data, &Budget::read(&run.path)?);
        // Behind the answer in a sentence and its picture.
        let place = answers
            .blocks
            .iter()
            .position(|block| matches!(block, Block::Table(_)));
        let place = place.unwrap_or(0);
        answers.blocks.splice(place..place, within);
        Ok(answers_with_commands(answers, run, STUDY))
    }

    fn has_long_sections(&self) -> bool {
        true
    }

    fn contradictions(&self, run: &Run) -> Vec<String> {
        let data = Data::new(run);
        let all = data.cases.iter();
        all.filter_map(|case| contradiction(&data, case)).collect()
    }

    fn tables(&self, run: &Run) -> Result<Vec<DerivedTable>, ChapterError> {
        let data = Data::new(run);
        if data.cases.is_empty() {
            return Ok(Vec::new());
        }
        let ablations = ablations::measured(&data, FULL_PLAN);
        Ok(vec![
            summary::table(&data)?,
            claims::table(&data, &ablations)?,
        ])
    }

    fn undecided(&self, run: &Run) -> Vec<String> {
        let data = Data::new(run);
        claims::undecided(&data, &ablations::measured(&data, FULL_PLAN))
    }
}

/// What in a case's figures contradicts its outcome.
fn contradiction(data: &Data<'_>, case: &Case) -> Option<String> {
    let is_ok = case.outcome == Outcome::Ok && !is_baseline(case);
    let of_times = data.timings.contradiction(case);
    of_times.or_else(|| is_ok.then(|| never_right(case))?)
}
