// SPDX-License-Identifier: MIT OR Apache-2.0
//! Limits that a report answers by.

use clap::Args;
use terrafill_results::Budget;

/// A number above 0, or none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Limit(Option<f64>);

/// What is left out stays as the run's folder has it. `report --help` shows these; `bench` takes them, too.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct BudgetArguments {
    /// How far boundaries may be off; 0: exact [default: 1]
    #[arg(long, value_name = "PIXELS", value_parser = parse_tolerance)]
    tolerance_px: Option<f64>,
    /// Megabytes that a fill may hold, or none [default: none]
    #[arg(long, value_name = "MB", value_parser = parse_limit)]
    max_mb: Option<Limit>,
    /// Time that a view's fill may take, ms, or none [default: none]
    #[arg(long, value_name = "MS", value_parser = parse_limit)]
    budget_ms: Option<Limit>,
}

impl BudgetArguments {
    /// The budget with what is given in place of what was; `None` where nothing is given.
    pub(crate) fn over(&self, was: Budget) -> Option<Budget> {
        let is_given =
            self.tolerance_px.is_some() || self.max_mb.is_some() || self.budget_ms.is_some();
        is_given.then(|| Budget {
            tolerance_px: self.tolerance_px.unwrap_or(was.tolerance_px),
            max_mb: self.max_mb.map_or(was.max_mb, |limit| limit.0),
            budget_ms: self.budget_ms.map_or(was.budget_ms, |limit| limit.0),
        })
    }
}

fn parse_tolerance(text: &str) -> Result<f64, &'static str> {
    let pixels = text.parse().ok();
    let pixels = pixels.filter(|pixels: &f64| pixels.is_finite() && *pixels >= 0.0);
    pixels.ok_or("0 or more pixels")
}

fn parse_limit(text: &str) -> Result<Limit, &'static str> {
    if text == "none" {
        return Ok(Limit(None));
    }
    let limit = text.parse().ok();
    let limit = limit.filter(|limit: &f64| limit.is_finite() && *limit > 0.0);
    limit
        .map(|limit| Limit(Some(limit)))
        .ok_or("a number above 0, or none")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_given_replaces_what_was_and_nothing_else() {
        let was = Budget {
            tolerance_px: 2.0,
            max_mb: Some(3.0),
            budget_ms: Some(4.0),
        };
        let given = |tolerance_px, max_mb, budget_ms| BudgetArguments {
            tolerance_px,
            max_mb,
            budget_ms,
        };
        assert_eq!(given(None, None, None).over(was), None);
        let other = given(Some(0.0), None, parse_limit("none").ok()).over(was);
        let expected = Budget {
            tolerance_px: 0.0,
            budget_ms: None,
            ..was
        };
        assert_eq!(other, Some(expected));
        for wrong in ["0", "-1", "inf", "NaN", "much"] {
            assert!(parse_limit(wrong).is_err(), "{wrong}");
        }
        for wrong in ["-0.1", "inf", "NaN", "none"] {
            assert!(parse_tolerance(wrong).is_err(), "{wrong}");
        }
    }
}
