// SPDX-License-Identifier: MIT OR Apache-2.0
//! A block of the time gate: fresh processes that give one number for a case.

use crate::sides::{Side, Times, Trio};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use terrafill_results::median;

/// Fresh processes that give one number: their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Block {
    /// Three processes, frame by frame.
    LockStep(Trio),
    /// Four processes, in the order in which each side's ran.
    Turns {
        /// Processes of the base.
        base: [u32; 2],
        /// Processes of the new program.
        new: [u32; 2],
    },
}

impl Block {
    /// Processes of a side.
    #[must_use]
    pub fn processes(&self, side: Side) -> Vec<u32> {
        match (self, side) {
            (Self::LockStep(trio), Side::Base) => vec![trio.base, trio.null],
            (Self::LockStep(trio), Side::New) => vec![trio.new],
            (Self::Turns { base, .. }, Side::Base) => base.to_vec(),
            (Self::Turns { new, .. }, Side::New) => new.to_vec(),
        }
    }

    /// ln(new) less ln(base) of a case; `None` where a process has no usable time.
    pub(crate) fn difference(&self, case: &str, times: &[Times; 2]) -> Option<f64> {
        match self {
            Self::LockStep(trio) => {
                let bursts = bursts(case, *trio, times)?;
                // Against each base process by itself. Disturbances only ever lengthen a frame, so times are skewed. The
                // difference of two such times is symmetric, and its median is 0 for equal work; that of one time and
                // the mean of two is not, and its median was 0.2 % below 0.
                let against = |base: usize| {
                    let gaps: Vec<f64> = bursts.iter().map(|of| of[2] - of[base]).collect();
                    median(&gaps)
                };
                Some(0.5 * (against(0)? + against(1)?))
            }
            Self::Turns { base, new } => {
                let of = |times, processes: &[u32; 2]| {
                    let [first, second] = processes.map(|process| level(case, times, process));
                    Some(first? + second?)
                };
                Some(0.5 * (of(&times[1], new)? - of(&times[0], base)?))
            }
        }
    }
}

/// Logarithm of the median over a process's usable samples of a case.
pub(crate) fn level(case: &str, times: &Times, process: u32) -> Option<f64> {
    let samples = times.get(case)?.get(&process)?.values();
    let usable: Vec<f64> = samples.filter_map(|ms| logarithm(*ms)).collect();
    median(&usable)
}

/// `None` for what is no time.
pub(crate) fn logarithm(ms: f64) -> Option<f64> {
    (ms.is_finite() && ms > 0.0).then(|| ms.ln())
}

/// Mean logarithms of a case's bursts: base, null, new. A burst with an unusable sample does not count,
/// and `None` is where more than half of them do not.
pub(crate) fn bursts(case: &str, trio: Trio, times: &[Times; 2]) -> Option<Vec<[f64; 3]>> {
    let of_case = [times[0].get(case)?, times[1].get(case)?];
    let mut samples = Vec::new();
    for (side, process) in trio.processes() {
        samples.push(of_case[side.index()].get(&process)?);
    }
    let [base, null, new] = samples.as_slice() else {
        return None;
    };
    let last = samples.iter().flat_map(|of| of.keys()).max()?;
    let mean = |of: &BTreeMap<u32, f64>, burst: u32| {
        let there = logarithm(*of.get(&(2 * burst + 1))?)?;
        let back = logarithm(*of.get(&(2 * burst + 2))?)?;
        Some(0.5 * (there + back))
    };
    let count = last.div_ceil(2);
    let found: Vec<[f64; 3]> = (0..count)
        .filter_map(|burst| Some([mean(base, burst)?, mean(null, burst)?, mean(new, burst)?]))
        .collect();
    (2 * found.len() >= count as usize).then_some(found)
}

/// A block's difference of logarithms, for each block.
pub(crate) fn differences(case: &str, blocks: &[Block], times: &[Times; 2]) -> Option<Vec<f64>> {
    let blocks = blocks.iter();
    blocks.map(|block| block.difference(case, times)).collect()
}

/// Base against base: in lock-step in each block. By turns, of two blocks' four base processes the outer
/// ones less the inner ones, with the sign turned from pair to pair, so that an even drift falls out.
pub(crate) fn null_differences(
    case: &str,
    blocks: &[Block],
    times: &[Times; 2],
) -> Option<Vec<f64>> {
    let trio = |block: &Block| match block {
        Block::LockStep(trio) => Some(*trio),
        Block::Turns { .. } => None,
    };
    if blocks.iter().all(|block| trio(block).is_some()) {
        let of = |trio| {
            let bursts = bursts(case, trio, times)?;
            let gaps: Vec<f64> = bursts.iter().map(|[base, null, _]| null - base).collect();
            median(&gaps)
        };
        return blocks.iter().filter_map(trio).map(of).collect();
    }
    let processes = blocks.iter().flat_map(|block| block.processes(Side::Base));
    let base: Option<Vec<f64>> = processes
        .map(|process| level(case, &times[0], process))
        .collect();
    let base = base?;
    let pairs = base.chunks_exact(4).enumerate();
    Some(
        pairs
            .map(|(index, of)| {
                let gap = 0.5 * (of[0] + of[3] - of[1] - of[2]);
                if index % 2 == 0 { gap } else { -gap }
            })
            .collect(),
    )
}

/// Standard deviation; `None` for fewer than two values.
pub(crate) fn deviation(values: &[f64]) -> Option<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (values.len() > 1).then(|| (squares / (values.len() - 1) as f64).sqrt())
}

pub(crate) fn percent(logarithm: f64) -> f64 {
    100.0 * logarithm.exp_m1()
}
