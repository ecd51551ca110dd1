// SPDX-License-Identifier: MIT OR Apache-2.0
//! Case, sample, summary and environment: the vocabulary between bench and report, and its CSV.
//!
//! A run is a folder: `samples.csv` (one row per timed frame), `summary.csv` (one row per case),
//! `growth.csv` (one row per mesh built of a made-up shape; runs over all scenes only),
//! `environment.json`, `plan.json` (the cases that the run set out to measure, so that a report can
//! name what is missing), `ladder.csv` (which cases form a ladder), `memory.csv` (bytes by formula
//! and as allocated), `precision.csv` with its times and plan (the numerical suite) and `images/`. Column names are stable; new columns are added at the end.
//! An absent value is an empty cell, and `reason` says why; it is never 0.

mod precision;
mod row;
mod run;
mod statistic;

pub use precision::{
    PrecisionGrid, PrecisionKey, PrecisionPart, PrecisionPlan, PrecisionRow, PrecisionTime,
};
pub use row::{
    Baselines, CaseKey, ErrorFigures, GrowthRow, LadderRung, MemoryRow, RunEnvironment, RunPlan,
    Sample, Status, Summary,
};
pub use run::{RunError, RunFolder};
pub use statistic::{Spread, median, quantile, spread};
