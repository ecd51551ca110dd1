// SPDX-License-Identifier: MIT OR Apache-2.0
//! placeholder until the merge
use terrafill_results::{Block, Chapter, ChapterError, Run};

/// The chapter.
#[derive(Debug, Clone, Copy)]
pub struct GrowthChapter;

impl Chapter for GrowthChapter {
    fn study(&self) -> &'static str {
        crate::STUDY
    }

    fn title(&self) -> &'static str {
        "Growth"
    }

    fn blocks(&self, _run: &Run) -> Result<Vec<Block>, ChapterError> {
        Ok(Vec::new())
    }
}
