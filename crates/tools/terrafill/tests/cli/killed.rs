// SPDX-License-Identifier: MIT OR Apache-2.0
//! A run of each study that is killed: the report names what is missing, and the run goes on where it
//! was.

use crate::harness::{Desk, NAMED, QUICK, Ran, has_device, ran};
use std::collections::BTreeSet;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use terrafill_results::{Outcome, Run};

/// Longest wait for a run's first rows: a debug build on a busy machine takes seconds.
const MAX_WAIT: Duration = Duration::from_secs(120);

/// Samples of each case: a few seconds of work on a software driver, by several techniques and by one.
const SAMPLES: [&str; 2] = ["20", "40"];

/// A run of `study` that takes long enough to be killed.
fn bench<'a>(study: &'a str, samples: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let options = ["--quick", "--samples", samples, "--out", "run"];
    let scene = ["california", "--size", "64"];
    let scene = if study == "filling" { &scene[..] } else { &[] };
    [&["bench", "--study", study][..], scene, &options, more].concat()
}

/// The same of `filling`, by the techniques that are counted.
fn filling<'a>(more: &[&'a str]) -> Vec<&'a str> {
    bench("filling", SAMPLES[0], &[&NAMED[..], more].concat())
}

/// The same by one technique, where only the end of a run matters.
fn short<'a>(more: &[&'a str]) -> Vec<&'a str> {
    bench(
        "filling",
        SAMPLES[1],
        &[&["--technique", "vertex"], more].concat(),
    )
}

fn measured_rows(desk: &Desk) -> usize {
    let text = std::fs::read(desk.path("run/measurements.csv")).unwrap_or_default();
    let lines = text.iter().filter(|byte| **byte == b'\n').count();
    lines.saturating_sub(1)
}

/// Starts the run and kills it with SIGKILL once so many values are measured.
fn kill_after(desk: &Desk, command: &mut Command, rows: usize) {
    kill_when(command, || measured_rows(desk) >= rows);
}

/// Starts the run and kills it with SIGKILL at a moment.
fn kill_when(command: &mut Command, is_now: impl Fn() -> bool) {
    let mut child = command.spawn().expect("the program starts");
    let started = Instant::now();
    let mut ended = None;
    while !is_now() && ended.is_none() && started.elapsed() < MAX_WAIT {
        std::thread::sleep(Duration::from_millis(2));
        ended = child.try_wait().expect("a child");
    }
    // Killed before anything is asserted, so that no failure leaves it running.
    child.kill().expect("killed");
    let status = child.wait().expect("a child");
    assert_eq!(status.code(), None, "ended by itself before it was killed");
    assert!(is_now(), "no rows came");
}

fn load(desk: &Desk) -> Run {
    Run::load(&desk.path("run")).expect("a run")
}

/// The file's finished lines: what a kill must not take away.
fn whole_lines(desk: &Desk, name: &str) -> Vec<u8> {
    let mut bytes = desk.read(&format!("run/{name}"));
    let end = bytes.iter().rposition(|byte| *byte == b'\n');
    bytes.truncate(end.map_or(0, |end| end + 1));
    bytes
}

/// `report` on what is left: a page, the names of the missing cases, and exit code 3.
fn check_report(desk: &Desk) -> Ran {
    let run = load(desk);
    let missing: BTreeSet<String> = run
        .cases
        .iter()
        .filter(|case| case.outcome == Outcome::Missing)
        .map(|case| case.id().key())
        .collect();
    assert!(!missing.is_empty());
    let ran = desk.run(&["report", "run"]);
    assert_eq!(
        (ran.code, ran.stdout.as_str()),
        (3, "report: run/index.html\n"),
        "{}",
        ran.stderr
    );
    let mut lines = ran.stderr.lines();
    let heading = lines.next().unwrap_or_default();
    let count = heading.strip_suffix(" planned cases are missing:");
    let named: BTreeSet<String> = lines.map(|line| line.trim().to_owned()).collect();
    assert_eq!(count, Some(named.len().to_string().as_str()));
    assert!(named.is_subset(&missing), "{named:?}");
    let repeats = missing.difference(&named);
    for name in repeats {
        assert!(name.ends_with(" (again)"), "{name} is not named");
    }
    let html = desk.read_text("run/index.html");
    assert!(html.trim_end().ends_with("</html>"));
    ran
}

/// Resumes to the end and checks that nothing was measured twice.
fn check_resumed(desk: &Desk, arguments: &[&str]) -> String {
    let before = whole_lines(desk, "measurements.csv");
    let text = ran(&mut desk.command(arguments)).succeeded();
    let after = desk.read_text("run/measurements.csv");
    assert!(
        after.as_bytes().starts_with(&before),
        "rows of the first part stay as they were"
    );
    // Figures of a probe are samples numbered 0; a case that was being verified is verified again.
    let timed: Vec<&str> = after
        .lines()
        .filter_map(|row| row.rsplit_once(',').map(|(key, _)| key))
        .filter(|key| !key.ends_with(",0"))
        .collect();
    let distinct: BTreeSet<&&str> = timed.iter().collect();
    assert_eq!(distinct.len(), timed.len(), "no sample stands twice");
    let run = load(desk);
    for case in &run.cases {
        assert_ne!(case.outcome, Outcome::Missing, "{}", case.id());
        let taken = case.timed_samples(0).len();
        assert!(
            [0, case.planned.samples as usize].contains(&taken),
            "{}: {taken} samples",
            case.id()
        );
    }
    // Once more: there is nothing left to do.
    ran(&mut desk.command(arguments)).succeeded();
    assert_eq!(desk.read_text("run/measurements.csv"), after);
    text
}

#[test]
fn filling_that_is_killed_is_reported_and_resumed() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let run = |more: &[&'static str]| desk.command(&filling(more));
    // In the first view, before any case has all its samples.
    kill_after(&desk, &mut run(&[]), 400);
    let report = check_report(&desk);
    let last = "  filling/california/horizon/vertex/pulled\n";
    assert!(report.stderr.contains(last), "{}", report.stderr);
    // In the second view: the first one is complete.
    let rows = |view: &str| {
        let text = desk.read_text("run/measurements.csv");
        text.lines().filter(|row| row.contains(view)).count()
    };
    let mut more = measured_rows(&desk);
    while rows("/top-down/") < 400 {
        more += 400;
        kill_after(&desk, &mut run(&["--resume"]), more);
    }
    let report = check_report(&desk);
    let first = "california/globe";
    assert!(!report.stderr.contains(first), "{}", report.stderr);

    // Nothing but the same run goes on here.
    let before = whole_lines(&desk, "measurements.csv");
    let others: [(&[&str], &str); 4] = [
        (&["--seed", "2"], "seed=2"),
        (&["--processes", "2"], "processes=2"),
        (&["square-200km"], "scenes=california+square-200km"),
        (&["--shard", "1/2"], "shard=1/2"),
    ];
    for (more, phrase) in others {
        let arguments = [&filling(&["--resume"]), more].concat();
        desk.run(&arguments)
            .refused(&[&["run holds a run already: cannot resume with", phrase]]);
        assert_eq!(whole_lines(&desk, "measurements.csv"), before, "{phrase}");
    }
    let text = check_resumed(&desk, &filling(&["--resume"]));
    assert!(
        text.starts_with(&format!("{QUICK}134 right, 0 wrong")),
        "{text}"
    );
    let report = desk.run(&["report", "run"]).succeeded();
    assert_eq!(report, "report: run/index.html\n");
}

#[test]
fn a_run_that_is_killed_in_its_second_process_leaves_nothing_that_goes_on_writing() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let two = ["--processes", "2"];
    let is_second = || {
        let text = std::fs::read(desk.path("run/measurements.csv")).unwrap_or_default();
        let text = String::from_utf8_lossy(&text);
        let seconds = text.lines().filter(|row| row.contains("_cpu_ms,1,"));
        seconds.count() > 20
    };
    let mut command = desk.command(&short(&two));
    kill_when(&mut command, is_second);
    // The second process hears of it within a frame.
    std::thread::sleep(Duration::from_millis(300));
    let left = measured_rows(&desk);
    check_report(&desk);
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(measured_rows(&desk), left);
    check_resumed(&desk, &short(&[&two[..], &["--resume"]].concat()));
}

#[test]
fn precision_that_is_killed_is_reported_and_resumed() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    // Among the errors, which come after the times.
    kill_after(
        &desk,
        &mut desk.command(&bench("precision", "1", &[])),
        4_000,
    );
    check_report(&desk);
    check_resumed(&desk, &bench("precision", "1", &["--resume"]));
}

#[test]
fn growth_that_is_killed_is_reported_and_resumed() {
    let desk = Desk::new();
    // Each of 24 shapes is verified, and a few are timed.
    kill_after(&desk, &mut desk.command(&bench("growth", "2", &[])), 27);
    let report = check_report(&desk);
    assert!(report.stderr.contains("growth/"), "{}", report.stderr);
    let text = check_resumed(&desk, &bench("growth", "2", &["--resume"]));
    assert!(
        text.starts_with(&format!("{QUICK}24 right, 0 wrong")),
        "{text}"
    );
}

#[test]
fn a_run_that_is_told_to_stop_says_what_is_left_and_goes_on() {
    if !has_device() {
        return;
    }
    for (signal, name, code) in [("-TERM", "SIGTERM", 143), ("-INT", "SIGINT", 130)] {
        let desk = Desk::new();
        let mut command = desk.command(&short(&[]));
        let child = command.stderr(Stdio::piped()).spawn().expect("starts");
        let started = Instant::now();
        while measured_rows(&desk) < 400 && started.elapsed() < MAX_WAIT {
            std::thread::sleep(Duration::from_millis(2));
        }
        let told = Command::new("kill")
            .args([signal, &child.id().to_string()])
            .status();
        assert!(told.expect("kill").success());
        let output = child.wait_with_output().expect("a child");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        // Negative control: what SIGKILL ends has no exit code and says nothing, see `kill_when`.
        assert_eq!(output.status.code(), Some(code), "{said}");
        let expected = format!("stopped by {name}: run keeps what was measured");
        assert!(said.contains(&expected), "{said}");
        check_report(&desk);
        check_resumed(&desk, &short(&["--resume"]));
    }
}

#[test]
fn a_run_on_a_full_disk_says_what_was_not_written_and_goes_on() {
    const FULL: &str = "/dev/full";
    if !has_device() || !std::path::Path::new(FULL).exists() {
        return;
    }
    let desk = Desk::new();
    let mut command = desk.command(&short(&[]));
    let mut child = command.stderr(Stdio::piped()).spawn().expect("starts");
    let started = Instant::now();
    while measured_rows(&desk) < 400 && started.elapsed() < MAX_WAIT {
        std::thread::sleep(Duration::from_millis(2));
    }
    // From one moment to the next there is no room for another row.
    let [table, kept, full] =
        ["run/measurements.csv", "kept.csv", "full"].map(|name| desk.path(name));
    let swapped = std::fs::hard_link(&table, &kept)
        .and_then(|()| std::os::unix::fs::symlink(FULL, &full))
        .and_then(|()| std::fs::rename(&full, &table));
    if swapped.is_err() {
        child.kill().expect("killed");
    }
    let output = child.wait_with_output().expect("a child");
    swapped.expect("swapped");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    for words in [
        "run/measurements.csv: No space left on device",
        "run keeps what was measured; the same command with --resume goes on",
    ] {
        assert!(said.contains(words), "{said}");
    }
    std::fs::rename(&kept, &table).expect("room again");
    check_report(&desk);
    check_resumed(&desk, &short(&["--resume"]));
}

#[test]
fn a_suite_that_is_told_to_stop_fails_no_case_and_leaves_nothing_that_goes_on_writing() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let mut arguments = vec!["bench", "--suite", "extreme", "--technique", "vertex"];
    arguments.extend(["--size", "64", "--out", "run"]);
    let mut command = desk.command(&arguments);
    let child = command.stderr(Stdio::piped()).spawn().expect("starts");
    let started = Instant::now();
    while measured_rows(&desk) < 60 && started.elapsed() < MAX_WAIT {
        std::thread::sleep(Duration::from_millis(2));
    }
    // This process alone, not the one that it measures in.
    let told = Command::new("kill")
        .args(["-TERM", &child.id().to_string()])
        .status();
    assert!(told.expect("kill").success());
    let output = child.wait_with_output().expect("a child");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(143), "{said}");
    assert!(
        said.contains("stopped by SIGTERM: run keeps what was measured"),
        "{said}"
    );
    // The other one hears of it within a case.
    std::thread::sleep(Duration::from_secs(1));
    let left = measured_rows(&desk);
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(measured_rows(&desk), left);
    let run = load(&desk);
    let of = |outcome: Outcome| {
        run.cases
            .iter()
            .filter(|case| case.outcome == outcome)
            .count()
    };
    assert_eq!(of(Outcome::Failed), 0);
    // Negative control: there was more to do, and some of it was done.
    assert!(of(Outcome::Missing) > 0 && of(Outcome::Ok) > 0);
}
