// SPDX-License-Identifier: MIT OR Apache-2.0
//! Decides whether one version of the program does more work, errs more or takes longer than another.
//!
//! Three gates. *Exact*: how cases ended, counters, bytes and errors, compared bit by bit and both ways,
//! and committed limits. *Time*: two programs run by turns in one job on one device, one process being one
//! number, never against a stored time. *Blessings* and *baselines* are files that are reviewed. Nothing
//! here names a study or opens a device: it reads run folders and starts programs.
//!
//! Nothing that was not measured passes: an absent case, an absent figure, a figure that is no number and
//! a budget that ended early each have a verdict of their own.

mod baseline;
mod bias;
mod bless;
mod block;
mod carry;
mod cores;
mod error;
mod exact;
#[cfg(all(test, unix))]
mod fake_program;
mod files;
mod finding;
mod gated;
mod glob;
mod hold;
mod job;
mod junit;
mod limits;
mod lockstep;
#[cfg(test)]
mod made_up_report;
mod output;
mod page;
mod part;
mod pictures;
mod program;
mod prune;
mod replace;
mod report;
mod self_test;
mod setup;
mod shard;
mod sides;
mod table;
pub mod threshold;
mod time;

pub use baseline::{load_baseline, save_baseline};
pub use bias::{Bias, GroupBias, MAX_BIAS_PERCENT, Mean};
pub use bless::{Blessing, add_blessings, apply, read_blessings};
pub use block::Block;
pub use carry::{CarriedScenes, carry_scenes};
pub use error::GateError;
pub use exact::{Exact, compare_exactly, driver_fingerprint, same_driver};
pub use files::write_files;
pub use finding::{Finding, Gate, Severity, Verdict, verdict};
pub use gated::{Floor, Floors, GatedTime, Span};
pub use glob::matches;
pub use hold::clear_processes;
pub use job::{GatedTimes, Job, Workload, watched};
pub use junit::junit;
pub use limits::{Limit, read_limits, shipped_limits};
pub use output::{annotations, read_json, text};
pub use page::markdown;
pub use part::GateShard;
pub use pictures::{PICTURES, ShownCase};
pub use program::{Program, refuse_equal_programs};
pub use prune::prune_blessings;
pub use report::{GATE_SCHEMA, GateOptions, GateReport, Rules, gate};
pub use self_test::{Injection, Proof, Rates, SelfTest, self_test};
pub use setup::compare_setups;
pub use shard::merge_gates;
pub use sides::{Side, Sides, Times, TimingOrder, Trio};
pub use time::{CaseTime, Pace, Stage, TimeGate, TimeOptions, Watched, compare_times};
