// SPDX-License-Identifier: MIT OR Apache-2.0
//! Each way in which two runs can differ is found, and two equal ones differ in none.

use super::*;
use crate::{Verdict, shipped_limits, verdict};
use std::path::Path;
use terrafill_results::made_up::{MadeUpRun, case_id};
use terrafill_results::{Metric, Status};

const METRICS: [Metric; 6] = [
    Metric::less("draws", "", Kind::Counter, "Draws."),
    Metric::less("geometry_bytes", "bytes", Kind::Bytes, "Bytes."),
    Metric::neither("filled_px", "px", Kind::DriverCounter, "Pixels."),
    Metric::less("mismatched_px", "px", Kind::Error, "Wrong pixels."),
    Metric::less("fill_cpu_ms", "ms", Kind::Time, "Time."),
    Metric::less("steady_uploads", "", Kind::Counter, "Uploads."),
];

/// A run of a case that is right, with figures that tests change.
fn run_of(figures: &[(&'static str, f64)]) -> MadeUpRun {
    let mut run = MadeUpRun {
        metrics: METRICS.to_vec(),
        ..MadeUpRun::default()
    };
    add(&mut run, "a", figures);
    run
}

fn add(run: &mut MadeUpRun, name: &str, figures: &[(&'static str, f64)]) {
    let case = run.case(case_id("filling", name, &[("scene", "square")]));
    for &(metric, value) in figures {
        case.figures.push((metric, 0, vec![vec![value]]));
    }
}

const FIGURES: [(&str, f64); 5] = [
    ("draws", 3.0),
    ("geometry_bytes", 1200.0),
    ("filled_px", 500.0),
    ("mismatched_px", 2.0),
    ("steady_uploads", 0.0),
];

fn with(metric: &str, value: f64) -> Vec<(&'static str, f64)> {
    let figures = FIGURES.into_iter();
    figures
        .map(|(name, was)| (name, if name == metric { value } else { was }))
        .collect()
}

/// Both runs written and compared.
fn compared(base: &MadeUpRun, new: &MadeUpRun) -> Result<(Exact, Verdict), GateError> {
    let place = tempfile::tempdir().expect("a folder");
    let write = |run: &MadeUpRun, name: &str| {
        let path = place.path().join(name);
        std::fs::create_dir(&path).expect("a folder");
        run.write(&path).expect("a run")
    };
    let (base, new) = (write(base, "base"), write(new, "new"));
    let limits = shipped_limits().expect("limits");
    let exact = compare_exactly(&base, &new, &limits)?;
    let verdict = verdict(&exact.findings, exact.compared.len());
    Ok((exact, verdict))
}

/// The verdict and the sentences of all findings.
fn sentences(base: &MadeUpRun, new: &MadeUpRun) -> (Verdict, Vec<String>) {
    let (exact, verdict) = compared(base, new).expect("comparable");
    (
        verdict,
        exact.findings.iter().map(Finding::sentence).collect(),
    )
}

#[test]
fn equal_runs_pass_with_what_was_compared() {
    let (exact, verdict) = compared(&run_of(&FIGURES), &run_of(&FIGURES)).expect("comparable");
    assert_eq!(verdict, Verdict::Pass);
    assert_eq!(
        (exact.findings.len(), exact.figures, exact.compared.len()),
        (0, 5, 1)
    );
}

#[test]
fn a_counter_that_changes_either_way_fails_by_its_name() {
    for (value, sentence) in [
        (6.0, "draws 3 → 6: +100.0000 %"),
        (1.0, "draws 3 → 1: -66.6667 %"),
        (0.0, "draws 3 → 0: -100.0000 %"),
        (f64::NAN, "draws 3 → NaN: not a number"),
        (f64::INFINITY, "draws 3 → inf: not a number"),
    ] {
        let changed = run_of(&with("draws", value));
        let found = sentences(&run_of(&FIGURES), &changed);
        assert_eq!(found, (Verdict::Regression, vec![sentence.to_owned()]));
        // Reversed operands.
        let (verdict, found) = sentences(&changed, &run_of(&FIGURES));
        assert_eq!(
            (verdict, found.len()),
            (Verdict::Regression, 1),
            "{found:?}"
        );
    }
}

#[test]
fn no_number_on_both_sides_is_no_agreement() {
    let nan = run_of(&with("mismatched_px", f64::NAN));
    let (verdict, found) = sentences(&nan, &nan);
    assert_eq!(verdict, Verdict::Regression, "{found:?}");
}

#[test]
fn errors_fail_in_both_directions() {
    for value in [3.0, 1.0] {
        let (exact, verdict) =
            compared(&run_of(&FIGURES), &run_of(&with("mismatched_px", value))).expect("compared");
        assert_eq!(verdict, Verdict::Regression);
        assert_eq!(exact.findings[0].gate, Gate::Errors);
        let better = exact.findings[0].severity == Severity::Better;
        assert_eq!(better, value < 2.0);
    }
}

#[test]
fn a_case_or_a_figure_that_is_gone_fails_and_a_new_one_is_a_note() {
    let mut two = run_of(&FIGURES);
    add(&mut two, "b", &FIGURES);
    let (verdict, found) = sentences(&two, &run_of(&FIGURES));
    assert_eq!(verdict, Verdict::Regression);
    assert_eq!(found, ["status ok → absent: not planned any more"]);
    let (verdict, found) = sentences(&run_of(&FIGURES), &two);
    assert_eq!((verdict, found.len()), (Verdict::Pass, 1), "{found:?}");

    let without: Vec<_> = FIGURES.into_iter().skip(1).collect();
    let (verdict, found) = sentences(&run_of(&FIGURES), &run_of(&without));
    assert_eq!(verdict, Verdict::Regression);
    assert_eq!(found, ["draws 3 → absent: not counted any more"]);
    let (exact, verdict) = compared(&run_of(&without), &run_of(&FIGURES)).expect("comparable");
    assert_eq!((verdict, exact.figures), (Verdict::Pass, 4));
    // What was not counted before is compared with nothing.
    let other = run_of(&[("draws", 3.0)]);
    let (_, verdict) = compared(&run_of(&without), &other).expect("comparable");
    assert_eq!(verdict, Verdict::Regression);
    let (_, verdict) = compared(&run_of(&[]), &other).expect("comparable");
    assert_eq!(verdict, Verdict::NothingMeasured);
}

#[test]
fn a_case_that_drew_nothing_or_uploads_every_frame_fails_on_both_sides_alike() {
    for (metric, value, words) in [
        ("filled_px", 0.0, "filled_px 0: allowed: 1 or more"),
        (
            "steady_uploads",
            1.0,
            "steady_uploads 1: allowed: 0 or less",
        ),
    ] {
        let both = run_of(&with(metric, value));
        let (verdict, found) = sentences(&both, &both);
        assert_eq!(verdict, Verdict::Regression);
        assert!(found[0].starts_with(words), "{found:?}");
    }
    let nothing = run_of(&[("draws", 0.0)]);
    let (verdict, found) = sentences(&nothing, &nothing);
    assert_eq!(verdict, Verdict::Regression);
    assert!(found[0].contains("measured nothing"), "{found:?}");
}

#[test]
fn how_a_case_ends_decides_before_its_figures() {
    let ended = |status: Option<Status>| {
        let mut run = run_of(&FIGURES);
        run.cases[0].row = status.map(|status| (status, "why".to_owned()));
        run
    };
    let (ok, wrong) = (Some(Status::Ok), Some(Status::Wrong));
    let (skipped, failed) = (Some(Status::Skipped), Some(Status::Failed));
    use Verdict::{Inconclusive, NothingMeasured, Pass, Regression};
    for (base, new, expected) in [
        (ok, ok, Pass),
        (ok, wrong, Regression),
        (wrong, wrong, Regression),
        (ok, failed, Regression),
        (failed, failed, Regression),
        (ok, skipped, Regression),
        (ok, None, Inconclusive),
        (None, ok, Inconclusive),
        (None, None, Inconclusive),
        (skipped, skipped, NothingMeasured),
        (skipped, ok, NothingMeasured),
        (wrong, ok, NothingMeasured),
    ] {
        let (mut base_run, mut new_run) = (ended(base), ended(new));
        if (base, new) == (None, None) || base.is_none() || new.is_none() {
            // Something beside it is compared, so that the missing case alone decides.
            add(&mut base_run, "b", &FIGURES);
            add(&mut new_run, "b", &FIGURES);
        }
        let (verdict, found) = sentences(&base_run, &new_run);
        assert_eq!(verdict, expected, "{base:?} {new:?}: {found:?}");
    }
}

#[test]
fn a_known_driver_fault_passes_against_itself_alone() {
    let ended = |status: Status| {
        let mut run = run_of(&FIGURES);
        run.cases[0].row = Some((status, "1 px lost".to_owned()));
        run
    };
    let (fault, right) = (ended(Status::DriverFault), run_of(&FIGURES));
    assert_eq!(
        compared(&fault, &fault).expect("comparable").1,
        Verdict::Pass
    );
    let (verdict, words) = sentences(&right, &fault);
    assert_eq!(verdict, Verdict::Regression, "{words:?}");
    assert!(words[0].contains("1 px lost"), "{words:?}");
    assert_eq!(sentences(&fault, &right).0, Verdict::Pass);
    // Negative control: one pixel more is wrong.
    let wrong = ended(Status::Wrong);
    assert_eq!(sentences(&fault, &wrong).0, Verdict::Regression);
}

#[test]
fn a_wrong_answer_that_is_a_result_must_stay_what_it_was() {
    let ended = |status| {
        let mut run = run_of(&FIGURES);
        run.cases[0].may_be_wrong = true;
        run.cases[0].row = Some((status, String::new()));
        run
    };
    let found = sentences(&ended(Status::Wrong), &ended(Status::Wrong));
    assert_eq!(found, (Verdict::Pass, Vec::new()));
    for (base, new) in [(Status::Wrong, Status::Ok), (Status::Ok, Status::Wrong)] {
        let (verdict, _) = sentences(&ended(base), &ended(new));
        assert_eq!(verdict, Verdict::Regression);
    }
}

#[test]
fn another_driver_is_compared_by_what_no_driver_decides_and_never_passes() {
    let on = |driver: &str, figures: &[(&'static str, f64)]| {
        let mut run = run_of(figures);
        run.environment.driver_info = driver.to_owned();
        run
    };
    let (verdict, found) = sentences(
        &on("Mesa 25", &FIGURES),
        &on("Mesa 26", &with("filled_px", 7.0)),
    );
    assert_eq!(
        (verdict, found.len()),
        (Verdict::Inconclusive, 1),
        "{found:?}"
    );
    // Negative controls: a counter of the plan differs all the same, and one driver's pixels are compared.
    let (verdict, _) = sentences(
        &on("Mesa 25", &FIGURES),
        &on("Mesa 26", &with("draws", 7.0)),
    );
    assert_eq!(verdict, Verdict::Regression);
    let (verdict, _) = sentences(
        &on("Mesa 25", &FIGURES),
        &on("Mesa 25", &with("filled_px", 7.0)),
    );
    assert_eq!(verdict, Verdict::Regression);
}

#[test]
fn one_folder_a_copy_other_options_and_another_size_are_refused() {
    let refused = |base: &MadeUpRun, new: &MadeUpRun| {
        let error = compared(base, new).map(|_| ()).expect_err("refused");
        assert_eq!(error.exit_code(), 2);
        error.to_string()
    };
    let timed = |ms: f64| {
        let mut run = run_of(&FIGURES);
        run.cases[0]
            .figures
            .push(("fill_cpu_ms", 1, vec![vec![ms]]));
        run
    };
    assert!(refused(&timed(1.5), &timed(1.5)).contains("a copy"));
    assert!(compared(&timed(1.5), &timed(1.6)).is_ok());
    let mut other = run_of(&FIGURES);
    other.environment.options = vec!["depth=full".to_owned(), "samples=3".to_owned()];
    assert!(refused(&run_of(&FIGURES), &other).contains("options: found \"depth=full\""));
    other.environment.options.remove(0);
    assert!(compared(&run_of(&FIGURES), &other).is_ok());
    other.environment.width = 512;
    assert!(refused(&run_of(&FIGURES), &other).contains("image size"));

    let place = tempfile::tempdir().expect("a folder");
    let run = run_of(&FIGURES).write(place.path()).expect("a run");
    let error = compare_exactly(&run, &run, &[]).expect_err("one folder");
    assert!(error.to_string().contains("one folder"), "{error}");
    assert!(Run::load(Path::new("/nowhere")).is_err());
}

#[test]
fn a_figure_that_differs_within_a_run_is_no_counter() {
    let mut unsteady = run_of(&FIGURES);
    unsteady.cases[0].figures[0].2 = vec![vec![3.0], vec![4.0]];
    let (verdict, found) = sentences(&unsteady, &unsteady);
    assert_eq!(verdict, Verdict::Regression);
    assert!(found[0].contains("differs within one run"), "{found:?}");
}

#[test]
fn fingerprints_name_device_and_driver_alone() {
    let mut a = RunEnvironment {
        gpu: "llvmpipe (LLVM 15.0.6, 256 bits)".to_owned(),
        driver_info: "Mesa 25.0.7-2".to_owned(),
        ..RunEnvironment::default()
    };
    assert_eq!(
        driver_fingerprint(&a),
        "llvmpipe-llvm-15-0-6-256-bits-0000-0000-mesa-25-0-7-2"
    );
    let b = RunEnvironment {
        commit: "def".to_owned(),
        cpu: "another".to_owned(),
        ..a.clone()
    };
    assert!(same_driver(&a, &b));
    a.driver_info = "Mesa 25.0.8".to_owned();
    assert!(!same_driver(&a, &b));
}

#[test]
fn a_limit_that_is_about_no_figure_is_named() {
    let of = |case: &str, metric: &str, is_shipped| Limit {
        case: case.to_owned(),
        metric: metric.to_owned(),
        min: None,
        max: Some(1e9),
        reason: "so".to_owned(),
        is_shipped,
    };
    let place = tempfile::tempdir().expect("a folder");
    let write = |name: &str| {
        run_of(&FIGURES)
            .write(&place.path().join(name))
            .expect("a run")
    };
    let (base, new) = (write("base"), write("new"));
    let unmatched = |limit| {
        let exact = compare_exactly(&base, &new, &[limit]).expect("comparable");
        exact.unmatched_limits
    };
    assert_eq!(unmatched(of("filling/*", "draws", false)), [""; 0]);
    assert_eq!(
        unmatched(of("filling/*", "nope", false)),
        ["case \"filling/*\", metric \"nope\""]
    );
    assert_eq!(unmatched(of("fillin/*", "draws", false)).len(), 1);
    // Limits that ship hold for studies that a gate need not measure.
    assert_eq!(unmatched(of("filling/*", "nope", true)), [""; 0]);
}
