// SPDX-License-Identifier: MIT OR Apache-2.0
//! A condition as a number.

use terrafill_results::{Case, ConditionKey};

/// NaN where it is none.
pub(super) fn number(case: &Case, key: ConditionKey) -> f64 {
    case.condition(key).parse().unwrap_or(f64::NAN)
}
