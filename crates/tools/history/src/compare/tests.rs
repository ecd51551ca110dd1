// SPDX-License-Identifier: MIT OR Apache-2.0

use super::*;
use std::path::Path;
use terrafill_results::made_up::{MadeUpRun, case_id};
use terrafill_results::{Clock, Kind, Metric, Status};

const METRIC: &str = "fill_cpu_ms";

fn primary(study: &str, _: Clock) -> Option<&'static str> {
    (study == "filling").then_some(METRIC)
}

/// A run of cases with these times, one number a process, and a pair of identical work that differs by 1 %.
fn run(folder: &Path, name: &str, gpu: &str, cases: &[(&str, &[f64])]) -> Run {
    let mut run = MadeUpRun {
        metrics: vec![Metric::less(METRIC, "ms", Kind::Time, "made up")],
        ..MadeUpRun::default()
    };
    run.environment.device_type = "cpu".to_owned();
    run.environment.gpu = gpu.to_owned();
    for (case, times) in cases {
        run.case(case_id("filling", case, &[("scene", "moon")]))
            .figure("draws", 134.0)
            .timed(METRIC, times);
    }
    let id = case_id("filling", "pair", &[]);
    run.case(id.repeat()).timed(METRIC, &[1.01; 5]);
    run.case(id).timed(METRIC, &[1.0; 5]);
    run.write(&folder.join(name)).expect("written")
}

fn compared(base: &Run, new: &Run) -> Comparison {
    let rules = Rules {
        limits: &[],
        blessings: &[],
    };
    compare(base, new, &rules, &primary).expect("comparable")
}

fn standing_of(comparison: &Comparison, case: &str) -> TimeStanding {
    let cases = &comparison.times[0].cases;
    cases
        .iter()
        .find(|of| of.case == format!("filling/{case}"))
        .expect("compared")
        .standing
}

#[test]
fn times_stand_by_floor_noise_and_interval() {
    let folder = tempfile::tempdir().expect("a folder");
    let level = |factor: f64| [10.0, 10.1, 9.9, 10.05, 9.95].map(|time| time * factor);
    let wide = [8.0, 12.0, 9.0, 13.0, 14.0];
    let (same, slow, fast, small) = (level(1.0), level(1.2), level(0.8), level(1.02));
    let base = run(
        folder.path(),
        "base",
        "gpu",
        &[
            ("slow", &same),
            ("fast", &same),
            ("small", &same),
            ("wide", &same),
            ("gone", &same),
        ],
    );
    let new = run(
        folder.path(),
        "new",
        "gpu",
        &[
            ("slow", &slow),
            ("fast", &fast),
            ("small", &small),
            ("wide", &wide),
            ("fresh", &same),
        ],
    );
    let found = compared(&base, &new);
    for (case, standing) in [
        ("slow", TimeStanding::Slower),
        ("fast", TimeStanding::Faster),
        ("small", TimeStanding::Unchanged),
        ("wide", TimeStanding::Inconclusive),
        ("pair", TimeStanding::Unchanged),
    ] {
        assert_eq!(standing_of(&found, case), standing, "{case}");
    }
    let [base_noise, new_noise] = found.times[0].noise_percent.map(|p| p.expect("a pair"));
    assert!((base_noise - 1.0).abs() < 1e-9 && (new_noise - 1.0).abs() < 1e-9);
    assert_eq!(found.unchanged(), ["filling/small"]);
    // A case that is gone counts, times do not.
    assert_eq!(found.exact.exit_code, 1);
    let status: Vec<&str> = found
        .findings(Severity::Worse, true)
        .map(|f| f.case.as_str())
        .collect();
    assert_eq!(status, ["filling/gone"]);
    let fresh: Vec<&str> = found
        .findings(Severity::Note, true)
        .map(|f| f.case.as_str())
        .collect();
    assert_eq!(fresh, ["filling/fresh"]);
    // Negative control: swapped operands swap slower and faster.
    let swapped = compared(&new, &base);
    assert_eq!(standing_of(&swapped, "slow"), TimeStanding::Faster);
    assert_eq!(standing_of(&swapped, "fast"), TimeStanding::Slower);
}

#[test]
fn times_alone_fail_nothing_and_three_processes_say_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let base = run(folder.path(), "base", "gpu", &[("a", &[10.0, 10.1, 9.9])]);
    let new = run(folder.path(), "new", "gpu", &[("a", &[20.0, 20.1, 19.9])]);
    let found = compared(&base, &new);
    assert_eq!(
        (found.exact.exit_code, standing_of(&found, "a")),
        (0, TimeStanding::Inconclusive)
    );
    assert_eq!(found.times[0].cases[0].interval, None);
}

#[test]
fn times_of_other_machines_are_not_compared() {
    let folder = tempfile::tempdir().expect("a folder");
    let base = run(folder.path(), "base", "gpu", &[("a", &[10.0; 5])]);
    let other = run(folder.path(), "other", "another", &[("a", &[20.0; 5])]);
    let found = compared(&base, &other);
    assert!(found.times.is_empty());
    let sentences = found.sentences();
    assert!(
        sentences[0].contains("gpu \"gpu\" and \"another\""),
        "{sentences:?}"
    );
    // Negative control: a run of the same machine is.
    let same = run(folder.path(), "same", "gpu", &[("a", &[20.1; 5])]);
    assert_eq!(
        standing_of(&compared(&base, &same), "a"),
        TimeStanding::Slower
    );
}

#[test]
fn a_wrong_case_has_no_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let base = run(folder.path(), "base", "gpu", &[("a", &[10.0; 5])]);
    let mut wrong = MadeUpRun {
        environment: base.environment.clone(),
        ..MadeUpRun::default()
    };
    wrong
        .case(case_id("filling", "a", &[("scene", "moon")]))
        .timed(METRIC, &[1.0; 5])
        .ended(Status::Wrong, "8 pixels");
    let wrong = wrong.write(&folder.path().join("wrong")).expect("written");
    let found = compared(&base, &wrong);
    assert!(found.times.is_empty() || found.times[0].cases.is_empty());
    assert_eq!(found.exact.exit_code, 1);
}
