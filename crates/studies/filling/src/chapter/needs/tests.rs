// SPDX-License-Identifier: MIT OR Apache-2.0
//! What made-up runs hold and leave out, as a reader sees it.

use super::*;
use crate::chapter::tests::{answers, on_cpu, section, tables};
use terrafill_results::made_up::{MadeUpCase, MadeUpRun, case_id};
use terrafill_results::{Row, Standing};

const PROCESSES: [f64; 4] = [1.0, 1.1, 0.9, 1.05];

fn feature(name: &str, bytes: u64, pipelines: u64) -> CaseFeature {
    CaseFeature {
        feature: name.to_owned(),
        is_held: bytes + pipelines > 0,
        bytes,
        spared_bytes: if bytes == 0 { 64 } else { 0 },
        pipelines,
        reason: format!("{name} because of {bytes}"),
    }
}

/// A case that holds `needs` and says that this was made.
fn add<'a>(
    run: &'a mut MadeUpRun,
    (view, variant): (&str, &str),
    more: &[(&str, &str)],
    needs: &[CaseFeature],
    ms: f64,
) -> &'a mut MadeUpCase {
    let key = format!("s/{view}/vertex/{variant}");
    let mut conditions = vec![
        ("scene", "s"),
        ("view", view),
        ("technique", "vertex"),
        ("variant", variant),
        ("layout", "doubled"),
    ];
    conditions.extend(more);
    let bytes: u64 = needs.iter().map(|need| need.bytes).sum();
    let pipelines: u64 = needs.iter().map(|need| need.pipelines).sum();
    let case = run.case(case_id("filling", &key, &conditions));
    for (metric, value) in [
        ("held_bytes", bytes),
        ("made_bytes", bytes),
        ("held_pipelines", pipelines),
        ("made_pipelines", pipelines),
        ("spared_bytes", 64),
        ("mismatched_px", 0),
        ("mismatched_px_outside_band", 0),
        ("vertices", 10 * bytes),
    ] {
        case.figure(metric, value as f64);
    }
    case.features = needs.to_vec();
    case.timed("fill_cpu_ms", &PROCESSES.map(|factor| factor * ms))
}

/// Two views, of which one needs bottom caps; an ablation of the other.
fn run() -> MadeUpRun {
    let mut run = on_cpu();
    let depth_pass = case_id(
        "filling",
        "s/far/depth-pass/full-screen",
        &[("scene", "s"), ("view", "far"), ("technique", "depth-pass")],
    );
    run.case(depth_pass).timed("fill_cpu_ms", &PROCESSES);
    let everything = [
        feature("bottom caps", 300, 0),
        feature("walls", 100, 0),
        feature("count behind", 0, 2),
    ];
    let needed = [
        feature("bottom caps", 0, 0),
        feature("walls", 100, 0),
        feature("count behind", 0, 0),
    ];
    let step = |number, step| {
        [
            ("role", "needs"),
            ("needs-rung", number),
            ("needs-step", step),
        ]
    };
    let first = step("1", "everything");
    add(&mut run, ("far", "doubled,a=b"), &first, &everything, 8.0);
    let last = step("2", "bottom-caps");
    add(&mut run, ("far", "doubled,c=d"), &last, &needed, 2.0);
    let near = [("role", "needs")];
    add(&mut run, ("near", "doubled,c=d"), &near, &everything, 4.0);
    run
}

fn texts(row: &Row) -> Vec<&str> {
    row.cells.iter().map(|cell| cell.text.as_str()).collect()
}

#[test]
fn what_views_need_is_told_feature_by_feature_and_step_by_step() {
    let blocks = section(&run(), TITLE);
    let tables = tables(&blocks);
    let [features, steps] = tables[..] else {
        panic!("{} tables", tables.len());
    };
    let rows: Vec<Vec<&str>> = features.rows.iter().map(texts).collect();
    assert_eq!(
        rows[0],
        [
            "bottom caps",
            "far",
            "left out",
            "–",
            "–",
            "64",
            "bottom caps because of 0"
        ]
    );
    assert_eq!(rows[1][..4], ["bottom caps", "near", "yes", "300"]);
    // Views of which the same is said share a row.
    assert_eq!(rows[2][..4], ["walls", "all", "yes", "100"]);
    assert_eq!(rows.len(), 5);
    assert_eq!(texts(&steps.rows[1])[5..7], ["100", "0"]);
    let last = &steps.rows[1].cells;
    assert_eq!(last[3].text, "without bottom caps, count behind");
    assert!(last[1].text.starts_with('4'), "{}", last[1].text);
}

#[test]
fn bytes_that_no_feature_declares_are_named_by_the_requirement() {
    let requirement = |run: &MadeUpRun| {
        let mut all = answers(run).requirements.into_iter();
        all.find(|of| of.claim.starts_with("Every byte and pipeline"))
    };
    let standing = |run: &MadeUpRun| requirement(run).map(|of| of.standing);
    assert_eq!(standing(&run()), Some(Standing::Holds));
    // Negative controls: bytes; a pipeline; and a run that says nothing has no such section.
    let mut forged = run();
    forged.cases[3].figure("made_bytes", 500.0);
    let found = requirement(&forged).expect("a requirement");
    assert_eq!(found.standing, Standing::DoesNotHold);
    let said = "400 bytes declared, 500 made";
    assert!(found.because.contains(said), "{}", found.because);
    let mut forged = run();
    forged.cases[1].figure("made_pipelines", 9.0);
    assert_eq!(standing(&forged), Some(Standing::DoesNotHold));
    assert!(section(&MadeUpRun::default(), TITLE).is_empty());
    assert_eq!(standing(&MadeUpRun::default()), None);
}
