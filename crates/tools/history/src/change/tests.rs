// SPDX-License-Identifier: MIT OR Apache-2.0

use super::*;
use crate::Point;
use terrafill_results::{Kind, SplitMix64};

/// Normal numbers (Box and Muller, 1958).
struct Random(SplitMix64);

impl Random {
    fn new(seed: u64) -> Self {
        Self(SplitMix64::new(seed))
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.0.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.0.unit()).cos()
    }

    /// Noise of one run: this much scatter, and one run in ten is later by four times as much on average.
    fn noise(&mut self, scatter: f64) -> f64 {
        let late = if self.0.unit() < 0.1 {
            -4.0 * scatter * (1.0 - self.0.unit()).ln()
        } else {
            0.0
        };
        (scatter * self.normal()).exp() * (1.0 + late)
    }
}

fn series(case: &str, kind: Kind, values: &[f64]) -> Series {
    let points = values.iter().enumerate().map(|(place, value)| Point {
        place,
        commit: format!("c{place:03}"),
        value: *value,
    });
    Series {
        machine: 1,
        case: case.to_owned(),
        metric: MetricRow {
            name: "fill_cpu_ms".to_owned(),
            unit: "ms".to_owned(),
            kind,
            better: Direction::Less,
            meaning: String::new(),
            primary: terrafill_results::Primary::No,
            scope: String::new(),
        },
        is_control: false,
        points: points.collect(),
    }
}

/// A time of 10 ms under noise of 2 %, times a factor by commit.
fn noisy(random: &mut Random, case: &str, commits: usize, factor: impl Fn(usize) -> f64) -> Series {
    under(random, case, 0.02, commits, factor)
}

/// As [`noisy`], under noise of this size.
fn under(
    random: &mut Random,
    case: &str,
    scatter: f64,
    commits: usize,
    factor: impl Fn(usize) -> f64,
) -> Series {
    let values: Vec<f64> = (0..commits)
        .map(|at| 10.0 * factor(at) * random.noise(scatter))
        .collect();
    series(case, Kind::Time, &values)
}

/// Histories of nothing but noise: 30 series each.
fn alarms(histories: usize, commits: usize) -> (usize, usize) {
    let mut random = Random::new(7);
    let (mut alarms, mut with_any) = (0, 0);
    for _ in 0..histories {
        let all: Vec<Series> = (0..30)
            .map(|case| noisy(&mut random, &format!("f/{case}"), commits, |_| 1.0))
            .collect();
        let found = changes(&all).changes.len();
        alarms += found;
        with_any += usize::from(found > 0);
    }
    (alarms, with_any)
}

#[test]
fn unchanged_work_gives_no_more_alarms_than_stated() {
    let histories = 40;
    let (alarms, with_any) = alarms(histories, 20);
    // With no change at all, at most this share of histories may have any (Benjamini and Hochberg).
    let allowed = FALSE_DISCOVERY_RATE * histories as f64;
    assert!(with_any as f64 <= allowed, "{with_any} of {histories}");
    assert!(
        alarms <= 4,
        "{alarms} in {histories} histories of 30 series"
    );
}

/// Of 30 histories with a step of 5 % at the 22nd of 40 commits, up and down by turns, under noise of this
/// size. Counted are those in which it is named a step, and is placed within two commits.
fn steps_found(scatter: f64) -> [usize; 2] {
    let mut random = Random::new(11);
    let mut found = [0, 0];
    for trial in 0..30 {
        let factor = if trial % 2 == 0 { 1.05 } else { 1.0 / 1.05 };
        let mut all: Vec<Series> = (0..9)
            .map(|case| under(&mut random, &format!("f/{case}"), scatter, 40, |_| 1.0))
            .collect();
        let step = |at: usize| if at < 22 { 1.0 } else { factor };
        all.push(under(&mut random, "f/stepped", scatter, 40, step));
        let changes = changes(&all);
        assert_eq!((changes.times, changes.undecided.len()), (10, 0));
        let is_step =
            |change: &&Change| change.case == "f/stepped" && change.kind == ChangeKind::Step;
        for change in changes.changes.iter().filter(is_step) {
            found[0] += 1;
            found[1] += usize::from(change.at.abs_diff(21) <= 2);
            assert_eq!(change.is_better, Some(factor < 1.0));
            let size = change.percent().expect("not from 0") / 100.0 + 1.0;
            assert!((size / factor - 1.0).abs() < 0.03, "{size}");
        }
    }
    found
}

#[test]
fn a_step_of_five_percent_is_found_at_its_commit_both_ways() {
    let [found, near] = steps_found(0.01);
    assert!(
        found >= 28 && near >= 28,
        "{found} found, {near} near, of 30"
    );
    // Under twice the noise the scatter's threshold is as large as the step: most are found.
    let [found, near] = steps_found(0.02);
    assert!(
        found >= 20 && near >= 19,
        "{found} found, {near} near, of 30"
    );
}

#[test]
fn a_quiet_step_is_found_at_the_very_commit_and_named_once() {
    let wave = |at: usize| 1.0 + 0.001 * f64::from(u8::from(at.is_multiple_of(2)));
    for at in [5, 12, 19] {
        let values: Vec<f64> = (0..24)
            .map(|place| 10.0 * wave(place) * if place < at { 1.0 } else { 1.05 })
            .collect();
        let found = changes(&[series("f/a", Kind::Time, &values)]).changes;
        let [change] = &found[..] else {
            panic!("{found:?}");
        };
        assert_eq!(change.kind, ChangeKind::Step);
        assert_eq!(
            (&change.good, &change.bad),
            (&format!("c{:03}", at - 1), &format!("c{at:03}"))
        );
        assert_eq!(change.is_better, Some(false));
    }
    // Negative controls: below the floor, too near an end, and too few commits.
    let values = |commits: usize, at: usize, factor: f64| -> Vec<f64> {
        (0..commits)
            .map(|place| 10.0 * wave(place) * if place < at { 1.0 } else { factor })
            .collect()
    };
    for (commits, at, factor) in [(24, 12, 1.025), (24, 22, 1.05), (7, 4, 2.0)] {
        let found = changes(&[series("f/a", Kind::Time, &values(commits, at, factor))]);
        assert_eq!(found.changes, [], "{commits} {at} {factor}");
        let too_few = usize::from(commits < MIN_POINTS);
        assert_eq!(found.undecided.len(), too_few);
    }
}

#[test]
fn two_steps_are_two_changes() {
    let mut random = Random::new(3);
    let level = |at: usize| match at {
        0..15 => 1.0,
        15..30 => 1.2,
        _ => 0.9,
    };
    let found = changes(&[noisy(&mut random, "f/a", 45, level)]).changes;
    let [up, down] = &found[..] else {
        panic!("{found:?}");
    };
    // Late runs beside a step may hide a commit or two of it.
    assert!(
        up.at.abs_diff(14) <= 2 && down.at.abs_diff(29) <= 2,
        "{found:?}"
    );
    assert_eq!(found[0].is_better, Some(false));
    assert_eq!(found[1].is_better, Some(true));
}

#[test]
fn spikes_are_no_change() {
    let mut random = Random::new(5);
    let spike = |at: usize| if at == 17 || at == 30 { 3.0 } else { 1.0 };
    assert_eq!(changes(&[noisy(&mut random, "f/a", 40, spike)]).changes, []);
    // Negative control: as many in a row as a side needs, and with the level kept.
    let step = |at: usize| if at >= 35 { 3.0 } else { 1.0 };
    assert_eq!(
        changes(&[noisy(&mut random, "f/a", 40, step)])
            .changes
            .len(),
        1
    );
}

#[test]
fn slow_drift_is_found_and_is_no_step() {
    let mut random = Random::new(13);
    for (grow, is_better) in [(1.004_f64, false), (1.0 / 1.004, true)] {
        let drift = |at: usize| grow.powi(i32::try_from(at).expect("small"));
        let found = changes(&[noisy(&mut random, "f/a", 40, drift)]).changes;
        let [change] = &found[..] else {
            panic!("{found:?}");
        };
        assert_eq!(
            (change.kind, change.is_better),
            (ChangeKind::Drift, Some(is_better))
        );
        let percent = change.percent().expect("a time");
        assert!(
            (percent - 100.0 * (grow.powi(39) - 1.0)).abs() < 6.0,
            "{percent}"
        );
    }
    // Negative control: a drift below the floor over all commits.
    let slower = |at: usize| 1.0003_f64.powi(i32::try_from(at).expect("small"));
    assert_eq!(
        changes(&[noisy(&mut random, "f/a", 40, slower)]).changes,
        []
    );
}

#[test]
fn exact_figures_change_wherever_they_differ() {
    let found = changes(&[
        series("f/a", Kind::Counter, &[134.0, 134.0, 135.0, 134.0]),
        series("f/b", Kind::Bytes, &[7.0, 7.0]),
        series("f/c", Kind::Error, &[0.0]),
    ]);
    assert_eq!((found.exact, found.times), (2, 0));
    let places: Vec<(&str, usize, Option<bool>)> = found
        .changes
        .iter()
        .map(|change| (change.case.as_str(), change.at, change.is_better))
        .collect();
    assert_eq!(places, [("f/a", 1, Some(false)), ("f/a", 2, Some(true))]);
    assert_eq!(found.changes[0].probability, None);
}

/// A history of 300 series under normal noise of 1.5 %, the first of which is this much longer from a
/// commit on.
fn lone_step(random: &mut Random, commits: usize, at: usize, factor: f64) -> Vec<Series> {
    let normal = |case: usize, random: &mut Random| {
        let values: Vec<f64> = (0..commits)
            .map(|place| {
                let factor = if case == 0 && place >= at {
                    factor
                } else {
                    1.0
                };
                10.0 * factor * (0.015 * random.normal()).exp()
            })
            .collect();
        series(&format!("f/{case:03}"), Kind::Time, &values)
    };
    (0..300).map(|case| normal(case, random)).collect()
}

#[test]
fn a_lone_step_among_300_series_is_found() {
    // `examples/simulated_histories.rs` does so at every place, 200 times.
    let mut random = Random::new(23);
    for (commits, at, factor) in [
        (12, 6, 1.08),
        (16, 13, 1.08),
        (20, 4, 1.0 / 1.08),
        (20, 8, 10.0),
    ] {
        let found = changes(&lone_step(&mut random, commits, at, factor));
        assert_eq!((found.times, found.undecided.len()), (300, 0));
        let [change] = &found.changes[..] else {
            panic!("{commits} {at} {factor}: {:?}", found.changes);
        };
        assert_eq!(
            (change.case.as_str(), change.kind),
            ("f/000", ChangeKind::Step)
        );
        assert!(change.at.abs_diff(at - 1) <= 1, "{change:?}");
        let percent = found.finds_percent.expect("times");
        assert!((3.0..8.0).contains(&percent), "{percent}");
    }
    // Negative control: a step as large as the scatter is in the noise of one commit.
    assert_eq!(changes(&lone_step(&mut random, 12, 6, 1.015)).changes, []);
}

#[test]
fn a_shift_of_the_machine_is_taken_from_the_control_passes() {
    let mut random = Random::new(29);
    let mut all: Vec<Series> = (0..40)
        .map(|case| {
            // From the ninth commit on the machine is slower by a tenth, and one case too.
            let factor = |at: usize| {
                let machine = if at < 9 { 1.0 } else { 1.1 };
                let own = if case == 0 && at >= 5 { 1.2 } else { 1.0 };
                machine * own
            };
            let values: Vec<f64> = (0..16)
                .map(|at| 10.0 * factor(at) * (0.01 * random.normal()).exp())
                .collect();
            series(&format!("f/{case:02}"), Kind::Time, &values)
        })
        .collect();
    // Negative control: without controls the machine's shift is everybody's change.
    assert!(changes(&all).changes.len() > 30);
    all[36..]
        .iter_mut()
        .for_each(|control| control.is_control = true);
    let found = changes(&all);
    assert_eq!(found.relative, 36);
    let named: Vec<&str> = found.changes.iter().map(|c| c.case.as_str()).collect();
    // Controls stay as they are, and show what the machine did.
    assert_eq!(named, ["f/00", "f/36", "f/37", "f/38", "f/39"]);
    // A quiet machine's control would add noise, and is not used.
    let mut quiet = lone_step(&mut random, 12, 6, 1.08);
    quiet[299].is_control = true;
    assert_eq!(changes(&quiet).relative, 0);
}

#[test]
fn a_time_that_hides_large_steps_is_undecided_and_named() {
    let mut random = Random::new(31);
    let mut all = lone_step(&mut random, 16, 8, 1.0);
    all.truncate(20);
    let wild: Vec<f64> = (0..16).map(|_| (0.5 * random.normal()).exp()).collect();
    all.push(series("f/wild", Kind::Time, &wild));
    let found = changes(&all);
    let [undecided] = &found.undecided[..] else {
        panic!("{:?}", found.undecided);
    };
    assert_eq!((undecided.case.as_str(), found.times), ("f/wild", 20));
    assert!(
        undecided.reason.contains("hides steps below"),
        "{undecided:?}"
    );
}

#[test]
fn values_that_are_no_times_are_left_out() {
    let mut values = vec![10.0; 12];
    values[3] = f64::NAN;
    values[4] = 0.0;
    let found = changes(&[series("f/a", Kind::Time, &values)]);
    assert_eq!((found.times, found.changes.len()), (1, 0));
    values[5] = -1.0;
    values[6] = f64::INFINITY;
    values[7] = -0.0;
    let found = changes(&[series("f/a", Kind::Time, &values)]);
    assert_eq!(
        found.undecided[0].reason,
        "found 7 commits with a time, needs 8"
    );
}
