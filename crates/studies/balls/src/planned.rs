// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cases by their conditions, and what was opened for them.

use crate::STUDY;
use std::collections::BTreeMap;
use terrafill_results::{CaseId, ConditionKey, PlannedCase};
use terrafill_study::Failure;

/// Conditions of a case, in the order of its name.
pub(crate) type Conditions = Vec<(ConditionKey, String)>;

/// A case named by the values of its conditions.
///
/// - `unnamed`: a condition that its name leaves out
pub(crate) fn planned(
    mut conditions: Conditions,
    unnamed: Option<(ConditionKey, String)>,
    samples: u32,
) -> PlannedCase {
    let values: Vec<&str> = conditions.iter().map(|(_, value)| value.as_str()).collect();
    let name = values.join("/");
    conditions.extend(unnamed);
    PlannedCase {
        id: CaseId::new(STUDY, name, conditions),
        samples,
        may_be_wrong: false,
    }
}

/// What was opened for a case.
pub(crate) fn verified<T>(opened: &mut BTreeMap<usize, T>, case: usize) -> Result<&mut T, Failure> {
    let opened = opened.get_mut(&case);
    opened.ok_or_else(|| Failure::Broken("it was not verified".to_owned()))
}
