// SPDX-License-Identifier: MIT OR Apache-2.0
//! Committed limits of single figures: that something was drawn, that an unchanged frame makes and
//! uploads nothing, and how large an error may be. A value on either side of its limits fails.

use crate::{GateError, glob, table};
use serde::Deserialize;
use std::path::Path;

/// The limits that hold everywhere, compiled in so that they hold wherever the program runs.
const SHIPPED: &str = include_str!("../limits.csv");

/// Columns of a table of limits.
const COLUMNS: [&str; 5] = ["case", "metric", "min", "max", "reason"];

/// Limits of one metric.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Limit {
    /// Key of a case, or a pattern of keys with `*`.
    pub case: String,
    /// Which metric.
    pub metric: String,
    /// Smallest value allowed.
    pub min: Option<f64>,
    /// Largest value allowed.
    pub max: Option<f64>,
    /// Why.
    pub reason: String,
    /// Whether it ships with the program, and need not be about a case at hand.
    #[serde(skip)]
    pub is_shipped: bool,
}

impl Limit {
    /// Whether it is about this figure.
    #[must_use]
    pub fn covers(&self, case: &str, metric: &str) -> bool {
        metric == self.metric && glob::matches(&self.case, case)
    }

    /// What is wrong with a value; a value that is no number is always wrong.
    #[must_use]
    pub fn objection(&self, value: f64) -> Option<String> {
        let is_below = self.min.is_some_and(|min| value < min);
        let is_above = self.max.is_some_and(|max| value > max);
        let allowed = match (self.min, self.max) {
            (Some(min), Some(max)) if min == max => format!("{min}"),
            (Some(min), Some(max)) => format!("{min} … {max}"),
            (Some(min), None) => format!("{min} or more"),
            (None, Some(max)) => format!("{max} or less"),
            (None, None) => "a number".to_owned(),
        };
        (is_below || is_above || value.is_nan())
            .then(|| format!("allowed: {allowed} ({})", self.reason))
    }
}

/// The limits that ship with the program.
///
/// # Errors
/// [`GateError::Row`], which a test rules out.
pub fn shipped_limits() -> Result<Vec<Limit>, GateError> {
    let mut limits = parse(Path::new("limits.csv"), SHIPPED)?;
    for limit in &mut limits {
        limit.is_shipped = true;
    }
    Ok(limits)
}

/// Limits of a file, beside those that ship.
///
/// # Errors
/// [`GateError::Io`]; [`GateError::Row`] for a wrong column or value.
pub fn read_limits(path: &Path) -> Result<Vec<Limit>, GateError> {
    let text = std::fs::read_to_string(path).map_err(GateError::io(path))?;
    parse(path, &text)
}

fn parse(path: &Path, text: &str) -> Result<Vec<Limit>, GateError> {
    table::parse(path, text, &COLUMNS, |limit: &Limit| {
        if limit.min.is_none() && limit.max.is_none() {
            return Err("found neither min nor max, needs one".to_owned());
        }
        table::check_reason(&limit.reason)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_limits_hold_something_and_refuse_what_they_are_for() {
        let limits = shipped_limits().expect("they parse");
        let objection = |metric: &str, value: f64| {
            let case = "filling/california/globe/vertex/doubled";
            let mut limits = limits.iter().filter(|limit| limit.covers(case, metric));
            limits.find_map(|limit| limit.objection(value))
        };
        let zero = objection("filled_px", 0.0).expect("nothing drawn");
        assert!(zero.contains("1 or more"), "{zero}");
        assert_eq!(objection("filled_px", 1.0), None);
        for steady in [
            "steady_buffer_creations",
            "steady_pipeline_creations",
            "steady_uploads",
        ] {
            assert!(objection(steady, 1.0).is_some() && objection(steady, 0.0).is_none());
        }
        assert!(objection("non_finite", f64::NAN).is_some());
        assert_eq!(objection("draws", f64::NAN), None, "no limit on draws");
        let swings = |hysteresis: &str| {
            let case = format!("paging/flights/addresses/zoom/counted/{hysteresis}/any/512");
            let mut limits = limits.iter();
            limits.any(|limit| {
                limit.covers(&case, "paging_steady_bytes") && limit.objection(4.0).is_some()
            })
        };
        assert_eq!(["4", "1"].map(swings), [true, false]);
        let sends = |eye: &str| {
            let case = format!("globes/controllers/{eye}/queries/constant steps/step=0.02/delay=1");
            let mut limits = limits.iter();
            limits.any(|limit| {
                limit.covers(&case, "globe_upload_bytes") && limit.objection(4.0).is_some()
            })
        };
        assert_eq!(["rest", "rising"].map(sends), [true, false]);
    }

    #[test]
    fn patterns_cover_what_they_begin() {
        let limit = |case: &str| Limit {
            case: case.to_owned(),
            metric: "draws".to_owned(),
            min: None,
            max: Some(3.0),
            reason: "so".to_owned(),
            is_shipped: false,
        };
        assert!(limit("filling/*").covers("filling/a", "draws"));
        assert!(limit("filling/a").covers("filling/a", "draws"));
        assert!(!limit("filling/a").covers("filling/ab", "draws"));
        assert!(!limit("filling/*").covers("filling/a", "vertices"));
        assert!(limit("*").objection(3.0).is_none() && limit("*").objection(3.5).is_some());
    }

    #[test]
    fn a_wrong_table_is_refused_with_its_row() {
        let refused = |text: &str| {
            let error = parse(Path::new("l.csv"), text).expect_err("wrong");
            error.to_string()
        };
        assert!(refused("case,metric,max,reason\n").contains("row 1: found"));
        let head = "case,metric,min,max,reason\n";
        assert!(refused(&format!("{head}a,b,,,why\n")).contains("row 2: found neither"));
        assert!(refused(&format!("{head}a,b,1,,why\na,b,1,, \n")).contains("row 3: found no"));
        assert!(refused(&format!("{head}a,b,x,,why\n")).contains("row 2"));
    }
}
