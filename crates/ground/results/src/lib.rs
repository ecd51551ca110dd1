// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cases, metrics and measurements: the vocabulary between studies and their readers, and the folder
//! that holds a run.
//!
//! A run is a folder of plain tables. `plan.json` names every case before the first is measured, so
//! that a reader can say what is missing; `cases.csv` has a row for each case that was verified, with
//! a column for each condition; `measurements.csv` has a row for each measured value; `notes.csv` has
//! texts, such as paths of pictures; `features.csv` has what cases hold and leave out; `metrics.csv` and `schema.json` say what all of it means. An
//! absent value is an absent row, and `reason` says why; it is never 0.

mod block;
mod budget;
mod case;
pub mod condition;
mod device_clock;
mod duration;
mod environment;
mod feature;
mod folder;
mod front;
mod input;
pub mod made_up;
mod markdown;
mod merge;
mod metric;
mod noise;
mod numbered;
mod paired;
mod plan;
mod process_part;
mod random;
mod ratio;
mod read;
mod resample;
mod scope;
mod side_table;
mod statistic;
mod term;
pub mod threshold;

pub use block::{
    Answers, Block, Cell, CellClass, Chapter, ChapterError, DerivedTable, Finding, Heading,
    Picture, PictureFigure, Pictures, Plot, Row, Standing, Table, TableLayout, with_figures,
};
pub use budget::Budget;
pub use case::{
    CaseFeature, CaseId, Measurement, Note, PlannedCase, Status, UNSTEADY_CLOCK, Verdict,
};
pub use condition::{ConditionKey, REPEATS};
pub use device_clock::{CLOCK_COLUMNS, DeviceClock, Moment, append_clocks, read_clocks};
pub use duration::{DURATION_COLUMNS, GroupDuration, append_durations, read_durations};
pub use environment::{Clock, RunEnvironment};
pub use folder::{
    CASE_COLUMNS, MEASUREMENT_COLUMNS, METRIC_COLUMNS, NOTE_COLUMNS, OLD_METRIC_COLUMNS, RunError,
    RunFolder, SCHEMA,
};
pub use front::{Candidate, front, front_survival};
pub use input::{INPUT_COLUMNS, RunInput, append_inputs, read_inputs};
pub use markdown::{escaped, markdown, markdown_list};
pub use merge::{MergeError, merge};
pub use metric::{Direction, Kind, Metric, MetricRow, NOT_MEASURED, Primary, Timer};
pub use noise::{Between, Noise, has_two_groups};
pub use numbered::Numbered;
pub use paired::{Shift, rate_bounds};
pub use plan::{RunPlan, Shard, Skipped};
pub use process_part::VerifiedRun;
pub use random::SplitMix64;
pub use ratio::{
    Claim, Estimate, over_processes, over_typical, process_medians, ratio, sample_spread, share,
    typical,
};
pub use read::{Case, Outcome, Run, Samples, repeated_cases};
pub use scope::Scope;
pub use statistic::{Spread, median, quantile, spread};
pub use term::Term;
