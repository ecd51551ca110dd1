// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rows and folders of the first frame; goes when the studies write cases and measurements.
mod precision;
mod row;
mod run;

pub use crate::{Spread, Status, median, quantile, spread};
pub use precision::{
    PrecisionGrid, PrecisionKey, PrecisionPart, PrecisionPlan, PrecisionRow, PrecisionTime,
};
pub use row::{
    Baselines, CaseKey, GrowthRow, LadderRung, MemoryRow, RunEnvironment, RunPlan, Sample, Summary,
};
pub use run::{RunError, RunFolder};
