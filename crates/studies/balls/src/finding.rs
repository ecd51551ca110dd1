// SPDX-License-Identifier: MIT OR Apache-2.0
//! A finding with the figure that it rests on.

use terrafill_results::{Finding, Standing};

pub(crate) fn finding(claim: String, holds: Option<bool>, because: String) -> Finding {
    let end = if because.is_empty() { "" } else { ":" };
    Finding {
        claim: claim + end,
        standing: holds.map_or(Standing::NotMeasured, Standing::holds_if),
        because,
    }
}
