// SPDX-License-Identifier: MIT OR Apache-2.0
//! By how much the time gate leans to one side where both do the same work.
//!
//! Calls beyond the floor do not show it: a gate that reads one side 2 % too fast calls nothing, and lets a
//! slow-down of 5 % pass as 3 %. So the mean itself is looked at, over the first blocks of each gate, which
//! measure every case. A group is the cases of one scene and view, as a process draws these one after another: what
//! a process brings from its start weighs most in its first group. One block is one number of a group, since its
//! cases share their processes.

use crate::block::differences;
use crate::{Span, TimeGate, Times};
use std::collections::BTreeMap;

/// Coverage of a mean's interval is 95 %: the normal quantile of its upper end.
const NORMAL_QUANTILE: f64 = 1.959_964;

/// By how many percent the interval of a mean may miss 0: a tenth of what the gate calls a change.
pub const MAX_BIAS_PERCENT: f64 = 0.3;

/// Mean of differences of logarithms with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    mean: f64,
    /// Variance of the mean; `None` of one block alone.
    variance: Option<f64>,
    blocks: usize,
}

impl Mean {
    fn of(differences: &[f64]) -> Option<Self> {
        let count = differences.len() as f64;
        let mean = differences.iter().sum::<f64>() / count;
        let squares: f64 = differences.iter().map(|gap| (gap - mean).powi(2)).sum();
        (mean.is_finite()).then(|| Self {
            mean,
            variance: (differences.len() > 1).then(|| squares / (count - 1.0) / count),
            blocks: differences.len(),
        })
    }

    /// What is left of a difference that turns its sign with the roles: half of the sum.
    fn and_mirrored(self, swapped: Self) -> Self {
        let variance = self.variance.zip(swapped.variance);
        Self {
            mean: 0.5 * (self.mean + swapped.mean),
            variance: variance.map(|(a, b)| 0.25 * (a + b)),
            blocks: self.blocks + swapped.blocks,
        }
    }

    /// In percent.
    #[must_use]
    pub fn percent(&self) -> f64 {
        100.0 * self.mean.exp_m1()
    }

    /// Its 95 % interval in percent; `None` of one block alone.
    #[must_use]
    pub fn interval_percent(&self) -> Option<[f64; 2]> {
        let half = student_quantile(self.blocks - 1) * self.variance?.sqrt();
        Some([-half, half].map(|off| 100.0 * (self.mean + off).exp_m1()))
    }

    /// Whether the interval misses 0 by more than [`MAX_BIAS_PERCENT`].
    #[must_use]
    pub fn is_biased(&self) -> bool {
        let is_off = |[low, high]: [f64; 2]| low > MAX_BIAS_PERCENT || high < -MAX_BIAS_PERCENT;
        self.interval_percent().is_some_and(is_off)
    }

    fn sentence(&self) -> String {
        let interval = self
            .interval_percent()
            .map_or(String::new(), |[low, high]| {
                format!(" [{low:+.2} … {high:+.2}]")
            });
        format!(
            "{:+.2} %{interval} over {} blocks",
            self.percent(),
            self.blocks
        )
    }
}

/// The quantile of Student's distribution where the normal one has [`NORMAL_QUANTILE`], by its expansion in
/// 1 / degrees (Abramowitz and Stegun, 26.7.5): within 0.3 % from 4 degrees on.
fn student_quantile(degrees: usize) -> f64 {
    let (z, n) = (NORMAL_QUANTILE, degrees.max(1) as f64);
    let first = (z.powi(3) + z) / 4.0;
    let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
    let third = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
    z + first / n + second / n.powi(2) + third / n.powi(3)
}

/// Differences of the same work, by group and block.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bias {
    /// As given, and with the programs' roles swapped.
    groups: BTreeMap<String, [Vec<f64>; 2]>,
}

/// What one group of cases came to.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupBias {
    /// Study, scene and view.
    pub group: String,
    /// New against base.
    pub as_given: Option<Mean>,
    /// Base against new.
    pub swapped: Option<Mean>,
}

impl Bias {
    /// Counts the first look of a gate at its frames.
    ///
    /// - `times`: of base and new by metric
    /// - `is_swapped`: the programs had each other's roles
    pub fn count(
        &mut self,
        gate: &TimeGate,
        times: &BTreeMap<String, [Times; 2]>,
        is_swapped: bool,
    ) {
        let mut groups: BTreeMap<String, Vec<Vec<f64>>> = BTreeMap::new();
        for case in gate.cases.iter().filter(|case| case.span == Span::Frame) {
            let Some(times) = times.get(&case.metric) else {
                continue;
            };
            if let Some(of_blocks) = differences(&case.case, &gate.screen, times) {
                groups
                    .entry(group_of(&case.case))
                    .or_default()
                    .push(of_blocks);
            }
        }
        for (group, cases) in groups {
            let of_block = |block: usize| {
                let gaps = cases.iter().map(|of_blocks| of_blocks[block]);
                gaps.sum::<f64>() / cases.len() as f64
            };
            let blocks = (0..gate.screen.len()).map(of_block);
            self.groups.entry(group).or_default()[usize::from(is_swapped)].extend(blocks);
        }
    }

    /// Every group, by name.
    #[must_use]
    pub fn groups(&self) -> Vec<GroupBias> {
        let groups = self.groups.iter();
        groups
            .map(|(group, [as_given, swapped])| GroupBias {
                group: group.clone(),
                as_given: Mean::of(as_given),
                swapped: Mean::of(swapped),
            })
            .collect()
    }
}

impl GroupBias {
    /// What does not turn its sign when the roles are swapped: the gate's own, and not the programs'.
    #[must_use]
    pub fn mirror(&self) -> Option<Mean> {
        Some(self.as_given?.and_mirrored(self.swapped?))
    }

    /// Whether one of its means misses 0.
    #[must_use]
    pub fn is_biased(&self) -> bool {
        let means = [self.as_given, self.swapped, self.mirror()];
        means.iter().flatten().any(Mean::is_biased)
    }

    /// A line for people.
    #[must_use]
    pub fn sentence(&self) -> String {
        let means = [
            ("", self.as_given),
            ("roles swapped ", self.swapped),
            ("what does not turn with the roles ", self.mirror()),
        ];
        let means = means.into_iter().filter_map(|(what, mean)| {
            let mean = mean?;
            Some(format!("{what}{}", mean.sentence()))
        });
        let verdict = if self.is_biased() {
            format!(": biased, allowed: an interval within {MAX_BIAS_PERCENT} % of 0")
        } else {
            String::new()
        };
        let means = means.collect::<Vec<_>>().join("; ");
        format!("mean of {}: {means}{verdict}", self.group)
    }
}

/// Study, scene and view: a key begins with them.
fn group_of(case: &str) -> String {
    case.split('/').take(3).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Block, CaseTime, Side, Trio};
    use terrafill_results::SplitMix64;

    const CASES: [&str; 3] = [
        "filling/a/globe/vertex/x",
        "filling/a/globe/vertex/y",
        "filling/a/near/vertex/x",
    ];

    const METRIC: &str = "fill_cpu_ms";

    /// A gate of five blocks: `factor` is what the new side takes of the base's time in the first group.
    fn gate(factor: f64, seed: u32) -> (TimeGate, [Times; 2]) {
        let trios: Vec<Trio> = (0..5).map(Trio::of_block).collect();
        let mut times = [Times::new(), Times::new()];
        for (index, case) in CASES.iter().enumerate() {
            for trio in &trios {
                for (side, process) in trio.processes() {
                    // Up to 1 % either way.
                    let seed = u64::from(seed) << 32 | u64::from(process);
                    let noise = 0.02 * SplitMix64::new(seed).unit() - 0.01;
                    let is_moved = side == Side::New && index < 2;
                    let ms = noise.exp() * if is_moved { factor } else { 1.0 };
                    let of = times[side.index()].entry((*case).to_owned()).or_default();
                    of.insert(process, (1..=12).map(|sample| (sample, ms)).collect());
                }
            }
        }
        let cases = CASES.map(|case| CaseTime {
            case: case.to_owned(),
            metric: METRIC.to_owned(),
            ..CaseTime::default()
        });
        let gate = TimeGate {
            cases: cases.to_vec(),
            screen: trios.into_iter().map(Block::LockStep).collect(),
            ..TimeGate::default()
        };
        (gate, times)
    }

    /// Ten gates, every second one with its roles swapped.
    fn ten_gates(as_given: f64, swapped: f64) -> Vec<GroupBias> {
        let mut bias = Bias::default();
        for number in 0..10 {
            let is_swapped = number % 2 == 1;
            let (gate, times) = gate(if is_swapped { swapped } else { as_given }, number);
            let times = BTreeMap::from([(METRIC.to_owned(), times)]);
            bias.count(&gate, &times, is_swapped);
        }
        bias.groups()
    }

    #[test]
    fn a_gate_that_reads_the_new_side_too_fast_in_one_group_is_found_and_the_group_is_named() {
        let even = ten_gates(1.0, 1.0);
        assert_eq!(even.len(), 2);
        assert!(even.iter().all(|group| !group.is_biased()), "{even:?}");
        // Negative control: the bias that a shared folder made, far below the floor of 3 %.
        let biased = ten_gates(0.977, 0.977);
        let named: Vec<&GroupBias> = biased.iter().filter(|group| group.is_biased()).collect();
        assert_eq!(named.len(), 1);
        let sentence = named[0].sentence();
        assert!(
            sentence.starts_with("mean of filling/a/globe: -2.") && sentence.contains(": biased"),
            "{sentence}"
        );
        assert!(!biased[1].sentence().contains("biased"), "{biased:?}");
    }

    #[test]
    fn roles_swapped_give_the_mirror_image() {
        // Programs that differ by 2 % turn their sign with their roles: no bias of the gate's.
        let groups = ten_gates(1.02, 1.0 / 1.02);
        let mirror = groups[0].mirror().expect("both ways round");
        assert!(!mirror.is_biased(), "{mirror:?}");
        let [there, back] = [groups[0].as_given, groups[0].swapped].map(|mean| mean.expect("one"));
        assert!(there.percent() > 1.0 && back.percent() < -1.0);
        // Negative control: the same sign both ways round is the gate's.
        let mirror = ten_gates(1.02, 1.02)[0].mirror().expect("both ways round");
        assert!(mirror.is_biased() && mirror.percent() > 1.0, "{mirror:?}");
    }

    #[test]
    fn intervals_are_those_of_printed_tables() {
        for (degrees, quantile) in [(4, 2.776), (9, 2.262), (19, 2.093), (49, 2.010)] {
            let found = student_quantile(degrees);
            assert!((found - quantile).abs() < 8e-3, "{degrees}: {found}");
        }
        let mean = Mean::of(&[0.0, 0.02, 0.01, 0.03, -0.01]).expect("five");
        let [low, high] = mean.interval_percent().expect("five");
        // 0.01 ± 2.776 · 0.0158 / √5.
        assert!(
            (low + 0.958).abs() < 0.01 && (high - 3.008).abs() < 0.01,
            "{low} {high}"
        );
        assert_eq!(Mean::of(&[]), None);
        assert_eq!(Mean::of(&[0.1]).expect("one").interval_percent(), None);
        // One block decides nothing.
        assert!(!Mean::of(&[0.1]).expect("one").is_biased());
    }
}
