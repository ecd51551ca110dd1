// SPDX-License-Identifier: MIT OR Apache-2.0
//! placeholder until the merge
use terrafill_results::{Block, Chapter, ChapterError, Clock, Run};

/// The chapter.
#[derive(Debug, Clone, Copy)]
pub struct FillingChapter;

impl Chapter for FillingChapter {
    fn study(&self) -> &'static str {
        crate::study::STUDY
    }

    fn title(&self) -> &'static str {
        "Filling"
    }

    fn primary_metric(&self, clock: Clock) -> Option<&'static str> {
        Some(clock.pick("gpu_ns", "cpu_ns"))
    }

    fn blocks(&self, _run: &Run) -> Result<Vec<Block>, ChapterError> {
        Ok(Vec::new())
    }
}
