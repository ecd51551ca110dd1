// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a run set out to measure, written before the first measurement.

use crate::PlannedCase;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Part `index` (from 1) of `count` of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// From 1.
    pub index: usize,
    /// At least `index`.
    pub count: usize,
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("shard {text:?}, allowed: m/n with 1 ≤ m ≤ n");
        let (index, count) = text.split_once('/').ok_or_else(wrong)?;
        let index: usize = index.parse().map_err(|_| wrong())?;
        let count: usize = count.parse().map_err(|_| wrong())?;
        if index == 0 || index > count {
            return Err(wrong());
        }
        Ok(Self { index, count })
    }
}

/// Something that was left out of a run, and why.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Skipped {
    /// Scene or data set.
    pub what: String,
    /// Why.
    pub reason: String,
}

/// Every case of a run and how often each is measured.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, Default)]
pub struct RunPlan {
    /// Every case, in order, repeats included.
    pub cases: Vec<PlannedCase>,
    /// What was left out.
    pub skipped: Vec<Skipped>,
    /// Processes that measure every timed case: one process is one replicate.
    pub processes: u32,
    /// Blocks that are measured and dropped at the start of each process.
    pub warm_up: u32,
    /// Seed of the blocks' order.
    pub seed: u64,
    /// Which part of the work this is; `None`: all.
    pub shard: Option<Shard>,
}

/// Conditions that come first among the columns of `cases.csv`.
const FIRST_CONDITIONS: [&str; 3] = ["scene", "view", "technique"];

impl RunPlan {
    /// Condition columns of `cases.csv`: the well-known ones first, the others in alphabetical order.
    #[must_use]
    pub fn conditions(&self) -> Vec<String> {
        let keys: BTreeSet<&str> = self
            .cases
            .iter()
            .flat_map(|case| case.id.conditions.keys().map(String::as_str))
            .collect();
        let first = FIRST_CONDITIONS
            .into_iter()
            .filter(|key| keys.contains(key));
        let others = keys
            .iter()
            .copied()
            .filter(|key| !FIRST_CONDITIONS.contains(key));
        first.chain(others).map(str::to_owned).collect()
    }

    /// The planned case of this key.
    #[must_use]
    pub fn case(&self, key: &str) -> Option<&PlannedCase> {
        self.cases.iter().find(|case| case.id.key() == key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CaseId;

    #[test]
    fn shards_are_read_and_refused() {
        assert_eq!("2/3".parse(), Ok(Shard { index: 2, count: 3 }));
        for wrong in ["0/3", "4/3", "1", "a/b", "1/0", "-1/2"] {
            let error = wrong.parse::<Shard>().expect_err(wrong);
            assert!(
                error.contains(wrong) && error.contains("1 ≤ m ≤ n"),
                "{error}"
            );
        }
    }

    #[test]
    fn each_condition_of_any_case_is_one_column() {
        let case = |conditions: &[(&'static str, &str)]| PlannedCase {
            id: CaseId::new(
                "filling",
                "a",
                conditions
                    .iter()
                    .map(|&(key, value)| (key, value.to_owned())),
            ),
            samples: 1,
            may_be_wrong: false,
        };
        let plan = RunPlan {
            cases: vec![
                case(&[("colour", "xor"), ("view", "globe"), ("scene", "moon")]),
                case(&[("shape", "comb")]),
            ],
            ..RunPlan::default()
        };
        assert_eq!(plan.conditions(), ["scene", "view", "colour", "shape"]);
    }
}
