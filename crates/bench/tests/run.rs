// SPDX-License-Identifier: MIT OR Apache-2.0
//! A whole small run: started, killed, resumed.

use std::path::Path;
use terrafill_bench::{BenchError, BenchOptions, run};
use terrafill_results::{RunFolder, Status};
use terrafill_scene::ImageSize;

fn options(out: &Path) -> BenchOptions {
    BenchOptions {
        scenes: vec!["california".to_owned()],
        backends: Vec::new(),
        quick: true,
        out: out.to_owned(),
        resume: false,
        data_dir: None,
        frames: Some(3),
        size: ImageSize {
            width: 128,
            height: 128,
        },
        shard: None,
        adapter: None,
        ladder: None,
        matrix: None,
    }
}

/// Whether a run can be made here; says why not.
fn has_device(result: &Result<terrafill_bench::BenchOutcome, BenchError>) -> bool {
    match result {
        Err(BenchError::NoDevice(why)) => {
            assert!(
                std::env::var_os("TERRAFILL_REQUIRE_DEVICE").is_none(),
                "{why}"
            );
            eprintln!("skipped: {why}");
            false
        }
        _ => true,
    }
}

#[test]
fn a_run_is_measured_killed_and_resumed_without_measuring_twice() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("run");
    let result = run(&options(&out));
    if !has_device(&result) {
        return;
    }
    let outcome = result.expect("runs");
    assert_eq!((outcome.ok, outcome.wrong, outcome.failed), (6, 0, 0));
    let whole = RunFolder::open(&out).expect("a run");
    let (summaries, samples) = (
        whole.summaries().expect("rows"),
        whole.samples().expect("rows"),
    );
    // Three views of two baselines and two layouts, three frames each.
    assert_eq!((summaries.len(), samples.len()), (12, 36));
    assert!(summaries.iter().all(|row| row.status == Status::Ok));
    assert!(summaries.iter().all(|row| row.samples == 3));

    // As a kill would leave it: one view summed up, the second half measured, a torn last row.
    let path = out.join("samples.csv");
    let text = std::fs::read_to_string(&path).expect("readable");
    let kept: Vec<&str> = text.lines().take(1 + 12 + 6).collect();
    std::fs::write(&path, kept.join("\n") + "\ncalifornia,top-d").expect("writable");
    let path = out.join("summary.csv");
    let text = std::fs::read_to_string(&path).expect("readable");
    let kept: Vec<&str> = text.lines().take(1 + 4).collect();
    std::fs::write(&path, kept.join("\n") + "\n").expect("writable");

    let again = run(&options(&out)).expect_err("the folder holds a run");
    assert!(again.to_string().contains("--resume"), "{again}");
    let mut resumed = options(&out);
    resumed.resume = true;
    let outcome = run(&resumed).expect("resumes");
    assert_eq!(outcome.ok, 6);
    let run_again = RunFolder::open(&out).expect("a run");
    let after = run_again.samples().expect("rows");
    assert_eq!(after.len(), 36);
    assert_eq!(after[..18], samples[..18], "what was measured stays");
    let mut keys: Vec<_> = after.iter().map(|row| (row.key(), row.frame)).collect();
    keys.sort();
    keys.dedup();
    assert_eq!(keys.len(), 36, "no frame of a case stands twice");
    assert!(run_again.missing().expect("a plan").is_empty());
}

#[test]
fn wrong_requests_are_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("run");
    let mut wrong = options(&out);
    wrong.backends = vec!["metal".to_owned()];
    let error = run(&wrong).expect_err("no such backend");
    assert_eq!(
        error.to_string(),
        "backend \"metal\", allowed: vertex, compute, native"
    );
    let mut wrong = options(&out);
    wrong.scenes = vec!["atlantis".to_owned()];
    let error = run(&wrong).expect_err("no such scene");
    assert!(error.to_string().contains("atlantis"), "{error}");
    assert!(!out.exists(), "nothing was written");
}
