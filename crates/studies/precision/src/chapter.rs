// SPDX-License-Identifier: MIT OR Apache-2.0
//! placeholder until the merge
use terrafill_results::{Block, Chapter, ChapterError, Clock, Run};

/// The chapter.
#[derive(Debug, Clone, Copy)]
pub struct PrecisionChapter;

impl Chapter for PrecisionChapter {
    fn study(&self) -> &'static str {
        crate::STUDY
    }

    fn title(&self) -> &'static str {
        "Precision"
    }

    fn primary_metric(&self, clock: Clock) -> Option<&'static str> {
        Some(clock.pick("gpu_ns", "cpu_ns"))
    }

    fn blocks(&self, _run: &Run) -> Result<Vec<Block>, ChapterError> {
        Ok(Vec::new())
    }
}
