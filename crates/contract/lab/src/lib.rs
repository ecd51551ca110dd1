// SPDX-License-Identifier: MIT OR Apache-2.0
//! How chapters are made. A [`Section`] says as data which cases it is about, what names a row, and what its columns
//! and curves are; [`Cases`] finds figures. A [`Comparison`] holds two cases side by side, and refuses what cannot be
//! compared. A [`Paper`] has the claims of one document, as read from its file, and [`StudyClaims`]
//! those that cases of a study test. [`Timings`] rank cases; [`ablation`]
//! says what each step gains, and [`cheapest_within`] what a reader's budget buys.

mod ablation;
mod budget;
mod case_claims;
mod cases;
mod claims;
mod comparison;
mod curves;
mod figure;
mod lines;
#[cfg(test)]
mod made_up;
mod page_claims;
mod published;
mod quotations;
mod section;
mod settling;
mod timings;

pub use ablation::{
    AblationStep, ShownStep, StepKeys, StepsSection, ablation, changed_work, gains_table,
    missing_steps, work_exponent,
};
pub use budget::{Contender, cheapest_within, some_of};
pub use case_claims::{ClaimedTime, StudyClaims};
pub use cases::{
    Best, Cases, distinct, finding, grouped, in_every_group, log_slope, measured, none_differs,
    range,
};
pub use claims::{ClaimAnswer, Claimed, Paper, PaperError, Tested, claims_blocks, claims_table};
pub use comparison::{Answer, Comparison, Follows, REFUSED, Refused, is_more, overall, sentences};
pub use curves::{Drawing, Panel, draw, slope_one};
pub use figure::{Figure, Names};
pub use lines::Lines;
pub use page_claims::Bound;
pub use published::PublishedTable;
pub use section::{Column, Section, SectionedChapter, Select, case_table};
pub use settling::{answers_with_commands, full_command, scene_argument, with_commands};
pub use timings::{Timings, band_sentence};
