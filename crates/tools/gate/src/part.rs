// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which part of a gate a report is, as the report says it.

use serde::{Deserialize, Serialize};
use terrafill_results::Shard;

/// Which part of a gate a report is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct GateShard {
    /// Which of how many.
    pub shard: Shard,
    /// Its scenes.
    pub scenes: Vec<String>,
    /// Scenes of the whole gate.
    pub all: Vec<String>,
}
