// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on precision: every route from a fragment to its texture coordinate, its error against
//! its cost, and where formula and measurement differ.

mod data;
mod findings;
mod plots;
mod tables;
#[cfg(test)]
mod tests;

use crate::metrics::{CPU_NS, GPU_NS, POINTS, ROUTE};
use data::{Data, MIN_NS, count_of};
use terrafill_plot::number::{count, significant};
use terrafill_results::{Answers, Block, Chapter, ChapterError, Clock, Outcome, Run, Term};

/// Errors and costs of the routes to a texture coordinate.
#[derive(Debug, Clone, Copy, Default)]
pub struct PrecisionChapter;

impl Chapter for PrecisionChapter {
    fn study(&self) -> &'static str {
        crate::STUDY
    }

    fn title(&self) -> &'static str {
        "Precision: from a fragment to its texture coordinate"
    }

    fn question(&self) -> &'static str {
        "Which formula finds a texture coordinate with which error, at which cost?"
    }

    fn terms(&self) -> &'static [Term] {
        crate::metrics::TERMS
    }

    fn primary_metric(&self, clock: Clock) -> Option<&'static str> {
        Some(clock.pick(GPU_NS, CPU_NS).name)
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let data = Data::new(run);
        if data.formulas.is_empty() {
            return Ok(Vec::new());
        }
        let mut blocks = tables::recommended(&data);
        blocks.push(Block::Text(format!(
            "Every way to longitude and latitude, evaluated at places of regions from 0.001° to the \
             globe, from the equator to the pole, with terrain from −110 to 90 km: on the CPU in the \
             shader's steps, and on the device by the shader's text. Errors are against the exact map \
             in double precision. Times are of the formula alone, without the loop around it. {}",
            summary(&data)
        )));
        blocks.push(Block::section("What was computed, and what was measured"));
        blocks.extend(findings::findings(&data).into_iter().map(Block::Finding));
        blocks.push(Block::Remark(format!(
            "In the plots terrain reaches up to 9 km where it says nothing else; one curve per family \
             through its knob: degree, or texels of a table. Filled: largest error on the device; open: \
             root mean square. A cross: an error above its bound; on the upper edge: no finite answer, \
             or no map of that region. Ringed and dashed: the Pareto front, where 95 % of the resamples \
             of processes keep it. A formula cheaper than {} ns, below the timer's resolution, stands \
             there. cubic-cesium: the arctangent of the best-known web globe (CesiumJS, after Drobot \
             2014) with the geodetic latitude; +geocentric: with the geocentric one, as it is used \
             there, where extents are computed by the same formula, so that edges fall together and \
             pictures are distorted between them. A label has its curve's colour. Dashed lines, named at \
             the right: a quarter of a texel; half a unit in the last place of the largest answer in \
             f32; 4096 units in the last place, which WGSL and Vulkan grant atan2.",
            significant(MIN_NS)
        )));
        blocks.extend(plots::plots(&data)?);
        blocks.extend(tables::tables(&data));
        Ok(blocks)
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let data = Data::new(run);
        if data.formulas.is_empty() {
            return Ok(Answers::default());
        }
        let formulas = || data.formulas.iter();
        let compared = formulas().filter(|row| row.value(POINTS).is_some());
        let meant = formulas().filter(|row| row.planned.may_be_wrong);
        Ok(Answers {
            scope: vec![format!(
                "{} of {} formulas at a place compared with the exact map in double precision; {} may be \
                 wrong: their error is the question.",
                count(compared.count() as u64),
                count(formulas().count() as u64),
                count(meant.count() as u64),
            )],
            blocks: tables::recommended(&data),
            requirements: findings::findings(&data),
        })
    }
}

fn summary(data: &Data<'_>) -> String {
    let formulas = || data.formulas.iter();
    let of = |status| formulas().filter(|row| row.outcome == status).count();
    let points: u64 = formulas().map(|row| count_of(row, POINTS)).sum();
    let routes = data.of("coordinate").distinct(ROUTE);
    format!(
        "{} rows of {} places in all, {} coordinate routes: {} within their bound, {} not finite, above \
         their bound or without one, {} not measured.",
        count(formulas().count() as u64),
        count(points),
        routes.len(),
        of(Outcome::Ok),
        of(Outcome::Wrong),
        of(Outcome::Skipped) + of(Outcome::Failed),
    )
}
