// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `extreme`: scenes that globes usually break at, each with what must come of it.
//!
//! Every view is drawn by each technique as it should be used, and compared with the reference before
//! one frame is timed: the sessions are those of the study `filling`. Around them stands what a suite
//! needs more. A scene is read, meshed and drawn only when its turn comes, and a panic is its own
//! verdict, so that one scene loses nothing of another. A refusal is a result: right where the scene
//! asks for it with these words, else a failure; a picture where a refusal is due is a failure too.

mod chapter;
mod keys;
mod plan;
mod session;

pub use chapter::{ExtremeChapter, extreme_sentence};
pub use plan::EXTREME;
pub use session::IN_HAND;

use crate::subject::{Surfaces, Techniques};
use keys::{CONDITIONS, METRICS};
use terrafill_study::{Planned, Request, Study, StudyError};

/// What must come of scenes that globes usually break at.
#[derive(Debug, Clone, Copy)]
pub struct ExtremeStudy {
    /// Techniques that draw them: those with volumes, whose pictures have to be right.
    pub techniques: Techniques,
    /// Surfaces that scenes may lie on.
    pub surfaces: Surfaces,
}

impl Study for ExtremeStudy {
    terrafill_study::study_facts!(
        name: EXTREME,
        metrics: METRICS,
        conditions: CONDITIONS,
        least_depth: Full,
        chapter: ExtremeChapter,
    );

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        plan::plan(self.techniques, self.surfaces, request)
    }
}
