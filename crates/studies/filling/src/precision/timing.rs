// SPDX-License-Identifier: MIT OR Apache-2.0
//! Times of formulas beyond the loop around them.

use super::kernel::lost;
use crate::BenchError;
use std::collections::BTreeMap;
use terrafill_gpu::Evaluator;
use terrafill_results::legacy::{
    PrecisionPart, PrecisionRow, PrecisionTime, Spread, median, spread,
};

/// Passes of the empty formula per round: every other time is held against their median.
const EMPTY_PASSES: usize = 3;

/// What the loop alone took in a round.
pub(crate) struct LoopTime {
    pub(crate) cpu_ms: f64,
    pub(crate) gpu_ms: Option<f64>,
}

impl LoopTime {
    pub(crate) fn of_empty(empty: &Evaluator, turns: u32) -> Result<Self, BenchError> {
        let mut cpu_ms = Vec::new();
        let mut gpu_ms = Vec::new();
        for _ in 0..EMPTY_PASSES {
            let time = empty.time(turns).map_err(lost)?;
            cpu_ms.push(time.cpu_ms);
            gpu_ms.extend(time.gpu_ms);
        }
        Ok(Self {
            cpu_ms: median(&cpu_ms).unwrap_or(f64::NAN),
            gpu_ms: median(&gpu_ms),
        })
    }
}

/// Nanoseconds per evaluation of every formula.
pub(crate) struct Times {
    spreads: BTreeMap<(PrecisionPart, String), FormulaTime>,
}

struct FormulaTime {
    cpu_ns: Option<Spread>,
    gpu_ns: Option<f64>,
    rounds: usize,
}

impl Times {
    pub(crate) fn of(rows: &[PrecisionTime]) -> Self {
        let mut of_formula: BTreeMap<(PrecisionPart, String), Vec<&PrecisionTime>> =
            BTreeMap::new();
        for row in rows {
            let key = (row.part, row.route.clone());
            of_formula.entry(key).or_default().push(row);
        }
        let spreads = of_formula.into_iter().map(|(key, rows)| {
            let cpu: Vec<f64> = rows.iter().map(|row| row.cpu_ns()).collect();
            let gpu: Vec<f64> = rows.iter().filter_map(|row| row.gpu_ns()).collect();
            let time = FormulaTime {
                cpu_ns: spread(&cpu),
                gpu_ns: median(&gpu),
                rounds: rows.len(),
            };
            (key, time)
        });
        Self {
            spreads: spreads.collect(),
        }
    }

    /// Puts a formula's times into its row.
    pub(crate) fn put(&self, row: &mut PrecisionRow, part: PrecisionPart, timed_name: &str) {
        let Some(time) = self.spreads.get(&(part, timed_name.to_owned())) else {
            return;
        };
        row.cpu_ns = time.cpu_ns.map(|ns| ns.median);
        row.cpu_ns_p5 = time.cpu_ns.map(|ns| ns.p5);
        row.cpu_ns_p95 = time.cpu_ns.map(|ns| ns.p95);
        row.gpu_ns = time.gpu_ns;
        row.rounds = u32::try_from(time.rounds).unwrap_or(u32::MAX);
    }
}
