// SPDX-License-Identifier: MIT OR Apache-2.0
//! Studies, and the one runner that measures them all.
//!
//! A [`Study`] names its cases in groups. A [`Group`] opens a [`Session`], in which every case is
//! verified before anything is timed. The [`run`] function measures the groups in shuffled blocks,
//! writes each value as it is measured, goes on with broken-off runs and measures a few cases twice.
//! No study repeats any of that, and the runner names no study.
//!
//! Nothing here opens a device, reads a clock or starts a thread or a process: `Devices` keeps what
//! studies open, [`Progress`] receives progress, and who wants several processes starts
//! them with another [`RunOptions::process`] each.

mod driver_fault;
mod failure;
mod files_read;
mod picture;
mod plan;
mod run;
mod schedule;
mod session;
mod share;
mod shows;
mod steady;
mod study;
mod trial;
mod turns;

pub use driver_fault::{Driver, DriverFault, LOSES_SLIVERS};
pub use failure::{Failure, StudyError};
pub use files_read::files_read;
pub use picture::{file_stem, write_photo, write_rgb};
pub use plan::{FramesPerSample, Plan, RunOptions, plan, plan_shared};
pub use run::{Progress, RunOutcome, Silent, run, run_by_turns};
pub use session::{CaseGroup, OpenSession, judged, planned_case, verified};
pub use share::Share;
pub use shows::{JudgedOnce, Shows};
pub use steady::Settling;
pub use study::{Context, Depth, Figures, Group, Planned, Request, Session, Study, size_name};
pub use terrafill_results::SplitMix64;
pub use trial::{Trial, trials};
pub use turns::{Turn, Turns};
