// SPDX-License-Identifier: MIT OR Apache-2.0
//! When a device's clock has settled: looks at the first timed case of a group agree.
//!
//! A GPU at rest has a slow clock, and needs some 0.1 s of work before it is fast: one was 3.7 times
//! slower in its first process than in the next. The runner reads no clock. It looks at the times that
//! a session measures, and keeps none of them.

use crate::Figures;
use terrafill_results::{Clock, Kind, Metric, median};

/// Looks in a row that have to agree.
const IN_A_ROW: usize = 3;

/// The largest of them over the smallest.
const AGREE: f64 = 1.03;

/// A look lasts until its frames took this long, milliseconds: shorter ones agree before the clock
/// begins to rise.
const LOOK_MS: f64 = 50.0;

/// Frames of a look at most: most of what is timed takes longer than 0.5 ms.
const MAX_FRAMES: usize = 100;

/// How long a process waits for a steady clock before it times anything.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Settling {
    /// Looks at most in a group; 0: it does not wait.
    pub max_looks: u32,
    /// Whether each group waits, and not only the first of a process: while the CPU verifies, a GPU rests.
    pub each_group: bool,
}

/// A time that samples may hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TimeMetric {
    name: &'static str,
    ms: f64,
}

/// What a study's samples are looked at by, best first: its primary metrics, then its other times.
pub(crate) fn times(
    metrics: &[Metric],
    primary: impl Fn(Clock) -> Option<&'static str>,
) -> Vec<TimeMetric> {
    let first = [Clock::Gpu, Clock::ProcessCpu].map(primary);
    let rank = |metric: &Metric| {
        let place = first.iter().position(|name| *name == Some(metric.name));
        place.unwrap_or(first.len())
    };
    let of_times = metrics.iter().filter(|metric| metric.kind == Kind::Time);
    let mut found: Vec<&Metric> = of_times.collect();
    found.sort_by_key(|metric| rank(metric));
    let time = |metric: &Metric| TimeMetric {
        name: metric.name,
        ms: match metric.unit {
            "s" => 1e3,
            "us" | "µs" => 1e-3,
            "ns" => 1e-6,
            _ => 1.0,
        },
    };
    found.into_iter().map(time).collect()
}

/// How looks at identical work ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Settled {
    Steady,
    /// The largest of the last looks over the smallest.
    Unsteady(f64),
    /// Samples hold no time.
    NoTimes,
}

/// Looks until some in a row agree, so many times at most.
///
/// # Errors
/// What a sample says.
pub(crate) fn settle(
    max_looks: u32,
    times: &[TimeMetric],
    mut sample: impl FnMut() -> Result<Figures, String>,
) -> Result<Settled, String> {
    let mut looks: Vec<f64> = Vec::new();
    for _ in 0..max_looks {
        let Some(look) = look(times, &mut sample)? else {
            return Ok(Settled::NoTimes);
        };
        looks.push(look);
        if looks.len() >= IN_A_ROW && spread(&looks) <= AGREE {
            return Ok(Settled::Steady);
        }
    }
    Ok(Settled::Unsteady(spread(&looks)))
}

/// The largest of the last looks over the smallest; 1 where all are 0, below the clock's resolution.
fn spread(looks: &[f64]) -> f64 {
    let last = &looks[looks.len().saturating_sub(IN_A_ROW)..];
    let low = last.iter().copied().fold(f64::INFINITY, f64::min);
    let high = last.iter().copied().fold(0.0, f64::max);
    if high <= low { 1.0 } else { high / low }
}

/// The median time of some frames, milliseconds.
fn look(
    times: &[TimeMetric],
    sample: &mut impl FnMut() -> Result<Figures, String>,
) -> Result<Option<f64>, String> {
    let (mut taken, mut sum) = (Vec::new(), 0.0);
    while sum < LOOK_MS && taken.len() < MAX_FRAMES {
        let values = sample()?;
        let of = |time: &TimeMetric| {
            let mut values = values.iter();
            let (_, value) = values.find(|(name, _)| *name == time.name)?;
            Some(value * time.ms)
        };
        let Some(ms) = times.iter().find_map(of) else {
            return Ok(None);
        };
        taken.push(ms);
        sum += ms;
    }
    Ok(median(&taken))
}

#[cfg(test)]
mod tests {
    use super::*;

    const METRICS: [Metric; 4] = [
        Metric::less("wall_ms", "ms", Kind::Time, ""),
        Metric::less("draws", "", Kind::Counter, ""),
        Metric::less("cpu_us", "us", Kind::Time, ""),
        Metric::less("gpu_ms", "ms", Kind::Time, ""),
    ];

    fn primary(clock: Clock) -> Option<&'static str> {
        Some(clock.pick("gpu_ms", "cpu_us"))
    }

    #[test]
    fn the_primary_metrics_come_first_and_counters_never() {
        let times = times(&METRICS, primary);
        let names: Vec<&str> = times.iter().map(|time| time.name).collect();
        assert_eq!(names, ["gpu_ms", "cpu_us", "wall_ms"]);
    }

    /// How looks of one frame each end, of which the last goes on, and how many there were.
    fn ends(ms: &[f64], max_looks: u32) -> (Settled, usize) {
        let times = times(&METRICS, primary);
        let mut count = 0;
        let settled = settle(max_looks, &times, || {
            count += 1;
            let at = count.min(ms.len()) - 1;
            Ok(vec![("draws", 7.0), ("cpu_us", 1e3 * ms[at])])
        });
        (settled.expect("settled"), count)
    }

    #[test]
    fn three_looks_that_agree_end_the_wait_and_two_do_not() {
        assert_eq!(ends(&[370.0, 200.0, 100.0], 40), (Settled::Steady, 5));
        assert_eq!(ends(&[100.0, 102.0, 100.0], 40), (Settled::Steady, 3));
        // Negative control: each third one is off.
        let waves: Vec<f64> = (0..99).map(|at| [100.0, 100.0, 110.0][at % 3]).collect();
        let (settled, looks) = ends(&waves, 9);
        assert_eq!(looks, 9);
        assert!(matches!(settled, Settled::Unsteady(off) if (off - 1.1).abs() < 1e-9));
    }

    #[test]
    fn a_look_at_short_frames_takes_many_and_no_more_than_a_hundred() {
        assert_eq!(ends(&[10.0], 40), (Settled::Steady, 3 * 5));
        assert_eq!(ends(&[0.0], 40), (Settled::Steady, 3 * MAX_FRAMES));
    }

    #[test]
    fn without_a_time_nothing_is_waited_for_and_errors_are_handed_on() {
        let times = times(&METRICS, primary);
        let none = settle(9, &times, || Ok(vec![("draws", 7.0)]));
        assert_eq!(none, Ok(Settled::NoTimes));
        let broken = settle(9, &times, || Err("lost".to_owned()));
        assert_eq!(broken, Err("lost".to_owned()));
    }
}
