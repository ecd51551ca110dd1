// SPDX-License-Identifier: MIT OR Apache-2.0
//! A value of a point, with its range and what each process found.

use terrafill_results::Spread;
use terrafill_results::threshold::MIN_REPLICATES;

/// A value as read.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    pub(crate) middle: f64,
    /// 5 and 95 %.
    pub(crate) range: Option<[f64; 2]>,
    pub(crate) samples: Vec<f64>,
}

impl Reading {
    /// A count or a formula: no range, and no other value if it is taken again.
    #[must_use]
    pub fn exact(value: f64) -> Self {
        Self {
            middle: value,
            range: None,
            samples: vec![value; MIN_REPLICATES],
        }
    }

    /// - `replicates`: one number per process, for the front
    #[must_use]
    pub fn sampled(spread: Spread, replicates: &[f64]) -> Self {
        Self {
            middle: spread.median,
            range: Some([spread.p5, spread.p95]),
            samples: replicates.to_vec(),
        }
    }

    /// Its middle.
    #[must_use]
    pub fn middle(&self) -> f64 {
        self.middle
    }

    pub(crate) fn extent(&self) -> [f64; 2] {
        self.range.unwrap_or([self.middle; 2])
    }

    /// What each process found, where several measured it.
    pub(crate) fn processes(&self) -> impl Iterator<Item = f64> {
        let several = self.range.is_some() && self.samples.len() > 1;
        self.samples.iter().copied().filter(move |_| several)
    }
}
