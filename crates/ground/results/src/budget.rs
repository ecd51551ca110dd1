// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a reader of a report wants to spend, and by how much pictures may be off: a report names the cheapest that is
//! within.
//!
//! `budget.json` is no result and no part of the schema: a run without it has [`Budget::default`].

use crate::RunError;
use crate::folder::{malformed, read_json, write_json};
use serde::{Deserialize, Serialize};
use std::path::Path;

const FILE: &str = "budget.json";

/// Limits of error, bytes and time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    /// How far a picture's boundaries may be off, pixels; 0: not at all.
    pub tolerance_px: f64,
    /// Megabytes of 10^6 that may be held; absent: any number.
    pub max_mb: Option<f64>,
    /// Time that one frame's work may take, milliseconds; absent: any.
    pub budget_ms: Option<f64>,
}

impl Default for Budget {
    /// What counts as right, at any cost: rounding moves a boundary by a pixel at most.
    fn default() -> Self {
        Self {
            tolerance_px: 1.0,
            max_mb: None,
            budget_ms: None,
        }
    }
}

impl Budget {
    /// That of the run in `folder`.
    ///
    /// # Errors
    /// [`RunError::Malformed`] for a file that does not fit, or with a limit that nothing could be within.
    pub fn read(folder: &Path) -> Result<Self, RunError> {
        let path = folder.join(FILE);
        if !path.exists() {
            return Ok(Self::default());
        }
        let budget: Self = read_json(&path)?;
        let check = |key: &str, found: f64, is_right: bool, allowed: &str| {
            let message = || format!("{key}: found {found}, allowed: {allowed}");
            let wrong = (!(is_right && found.is_finite())).then(message);
            wrong.map_or(Ok(()), |message| Err(malformed(&path, message)))
        };
        let tolerance_px = budget.tolerance_px;
        check(
            "tolerance_px",
            tolerance_px,
            tolerance_px >= 0.0,
            "0 or more",
        )?;
        for (key, limit) in [("max_mb", budget.max_mb), ("budget_ms", budget.budget_ms)] {
            let limit = limit.unwrap_or(1.0);
            check(key, limit, limit > 0.0, "more than 0, or null")?;
        }
        Ok(budget)
    }

    /// Puts it into the run's folder, in place of another one.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn write(&self, folder: &Path) -> Result<(), RunError> {
        write_json(&folder.join(FILE), self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_comes_back_and_an_impossible_one_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let read = || Budget::read(folder.path());
        assert_eq!(read().expect("none"), Budget::default());
        let budget = Budget {
            tolerance_px: 0.0,
            max_mb: Some(2.5),
            budget_ms: None,
        };
        budget.write(folder.path()).expect("written");
        assert_eq!(read().expect("readable"), budget);
        // Negative controls: less than nothing, no time at all, and a word that is none of its keys.
        for (text, words) in [
            (r#"{"tolerance_px":-1}"#, "tolerance_px: found -1"),
            (
                r#"{"tolerance_px":1,"budget_ms":0}"#,
                "budget_ms: found 0, allowed: more than 0",
            ),
            (r#"{"tolerance_px":1,"max_gb":1}"#, "max_gb"),
        ] {
            std::fs::write(folder.path().join(FILE), text).expect("written");
            let error = read().expect_err(words).to_string();
            assert!(error.contains(words) && error.contains(FILE), "{error}");
        }
    }
}
