// SPDX-License-Identifier: MIT OR Apache-2.0
//! How often `history changes` finds a step of known size, and how often it names a change where there is
//! none, over simulated histories.
//!
//! `cargo run --release -p terrafill-history --example simulated_histories [HISTORIES]`

#![allow(clippy::print_stdout, reason = "printing is what an example is for")]

use terrafill_history::{ChangeKind, Point, Series, changes};
use terrafill_results::{Direction, Kind, MetricRow, SplitMix64};

const SERIES: usize = 300;
const STEP: f64 = 1.08;
const SCATTER: f64 = 0.015;
/// Fewest commits on each side of a step.
const BEHIND: usize = 3;

/// Noise of a time.
#[derive(Debug, Clone, Copy)]
enum Noise {
    /// Normal, of one size.
    Normal,
    /// Normal, its size from 0.5 to 5 %, by series; the one with a step has the usual.
    Mixed,
    /// Normal, and one time in ten is later by four times as much on average.
    Late,
    /// Normal, and every run has a shift of 3 % in all of its times; ten of them are control passes.
    Shifted,
}

fn normal(random: &mut SplitMix64) -> f64 {
    let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.unit()).cos()
}

/// A history; the first series is longer by this factor from `at` on.
fn history(
    random: &mut SplitMix64,
    noise: Noise,
    commits: usize,
    at: usize,
    factor: f64,
) -> Vec<Series> {
    let shifts: Vec<f64> = (0..commits).map(|_| 0.03 * normal(random)).collect();
    let series = |case: usize| {
        let scatter = match noise {
            Noise::Mixed if case > 0 => 0.005 * 10.0_f64.powf(random.unit()),
            _ => SCATTER,
        };
        let mut value = |place: usize| {
            let mut value = 10.0 * (scatter * normal(random)).exp();
            match noise {
                Noise::Late if random.unit() < 0.1 => {
                    value *= 1.0 - 4.0 * scatter * (1.0 - random.unit()).ln();
                }
                Noise::Shifted => value *= shifts[place].exp(),
                _ => {}
            }
            if case == 0 && place >= at {
                value * factor
            } else {
                value
            }
        };
        Series {
            machine: 1,
            case: format!("filling/{case}"),
            metric: MetricRow {
                name: "fill_ms".to_owned(),
                unit: "ms".to_owned(),
                kind: Kind::Time,
                better: Direction::Less,
                meaning: String::new(),
                primary: terrafill_results::Primary::No,
                scope: String::new(),
            },
            is_control: case % 30 == 29,
            points: (0..commits)
                .map(|place| Point {
                    place,
                    commit: format!("{place:040x}"),
                    value: value(place),
                })
                .collect(),
        }
    };
    (0..SERIES).map(series).collect()
}

/// Counts over histories.
#[derive(Default)]
struct Counts {
    histories: usize,
    found: usize,
    near: usize,
    named: usize,
    false_ones: usize,
    with_false: usize,
    false_share: f64,
}

fn count(
    random: &mut SplitMix64,
    noise: Noise,
    commits: usize,
    at: usize,
    factor: f64,
    counts: &mut Counts,
) {
    let found = changes(&history(random, noise, commits, at, factor)).changes;
    let is_true = |case: &str| case == "filling/0" && factor > 1.0;
    let step = found
        .iter()
        .find(|c| is_true(&c.case) && c.kind == ChangeKind::Step);
    let false_ones = found.iter().filter(|c| !is_true(&c.case)).count();
    counts.histories += 1;
    counts.found += usize::from(step.is_some());
    counts.near += usize::from(step.is_some_and(|c| (c.at + 1).abs_diff(at) <= 1));
    counts.named += found.len();
    counts.false_ones += false_ones;
    counts.with_false += usize::from(false_ones > 0);
    counts.false_share += false_ones as f64 / found.len().max(1) as f64;
}

fn main() {
    let asked = std::env::args().nth(1);
    let histories: usize = asked.map_or(200, |text| text.parse().expect("a number of histories"));
    let mut lines = vec![
        "| noise | commits | change | histories | found | at worst place | within 1 commit | histories with a false change | mean false share |".to_owned(),
        "|---|---|---|---|---|---|---|---|---|".to_owned(),
    ];
    println!("{}\n{}", lines[0], lines[1]);
    for noise in [Noise::Normal, Noise::Mixed, Noise::Late, Noise::Shifted] {
        for commits in [12, 16, 20, 40] {
            let mut random = SplitMix64::new(commits as u64);
            let mut none = Counts::default();
            for _ in 0..histories {
                count(&mut random, noise, commits, 0, 1.0, &mut none);
            }
            let mut all = Counts::default();
            let mut worst: f64 = 1.0;
            if commits <= 20 {
                // Every place under the noise that is promised, else one near an end and one in the middle.
                let places: Vec<usize> = match noise {
                    Noise::Normal => (BEHIND..=commits - BEHIND).collect(),
                    _ => vec![BEHIND, commits / 2],
                };
                for at in places {
                    let before = all.found;
                    for _ in 0..histories {
                        count(&mut random, noise, commits, at, STEP, &mut all);
                    }
                    worst = worst.min((all.found - before) as f64 / histories as f64);
                }
            }
            for (what, of) in [("none", none), ("8 %", all)] {
                if of.histories == 0 {
                    continue;
                }
                let share = |n: usize| format!("{:.1} %", 100.0 * n as f64 / of.histories as f64);
                let found = |n: usize| {
                    if what == "none" {
                        "–".to_owned()
                    } else {
                        share(n)
                    }
                };
                let line = format!(
                    "| {noise:?} | {commits} | {what} | {} | {} | {} | {} | {} | {:.1} % |",
                    of.histories,
                    found(of.found),
                    if what == "none" {
                        "–".to_owned()
                    } else {
                        format!("{:.1} %", 100.0 * worst)
                    },
                    found(of.near),
                    share(of.with_false),
                    100.0 * of.false_share / of.histories as f64
                );
                println!("{line}");
                lines.push(line);
            }
        }
    }
}
