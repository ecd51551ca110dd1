// SPDX-License-Identifier: MIT OR Apache-2.0
//! Budgets and the fills that are within them, of made-up runs.

use super::*;
use crate::chapter::FillingChapter;
use crate::chapter::tests::on_cpu;
use terrafill_results::made_up::{MadeUpCase, MadeUpRun, case_id};
use terrafill_results::{Chapter as _, Status};

const VIEWS: [&str; 2] = ["all", "near"];

/// A fill in two views, the second of which takes twice as long, with 5 processes.
fn fill(run: &mut MadeUpRun, name: &str, [ms, bytes]: [f64; 2], with: impl Fn(&mut MadeUpCase)) {
    let approximate = if name.starts_with("mask") { "yes" } else { "" };
    for (view, factor) in VIEWS.iter().zip([1.0, 2.0]) {
        let key = format!("s/{view}/{name}");
        let (technique, layout) = name.split_once('/').expect("two parts");
        let conditions = [
            ("scene", "s"),
            ("view", view),
            ("technique", technique),
            ("variant", layout),
            ("layout", layout),
            ("role", "main"),
            ("approximate", approximate),
        ];
        let case = run.case(case_id("filling", &key, &conditions));
        case.figure("mismatched_px", 5.0)
            .figure("mismatched_px_outside_band", 0.0)
            .figure("geometry_bytes", bytes)
            .timed(
                "fill_cpu_ms",
                &[1.0, 1.01, 0.99, 1.0, 1.02].map(|of| of * ms * factor),
            );
        if approximate == "yes" {
            case.may_be_wrong = true;
            case.ended(Status::Wrong, "approximate");
        }
        with(case);
    }
}

/// A mask that is off by 3 px, volumes with levels of detail, and exact ones, cheaper to dearer.
fn made() -> MadeUpRun {
    let mut run = on_cpu();
    fill(&mut run, "mask/texture", [1.0, 100.0], |case| {
        case.figure("target_bytes", 4e6)
            .figure("boundary_moved_px", 2.0)
            .figure("hausdorff_px", 3.0);
    });
    fill(&mut run, "vertex/levels", [4.0, 1e6], |case| {
        case.figure("boundary_moved_px", 0.5);
    });
    // Of teeth thinner than a pixel rounding was measured: it moves nothing on purpose.
    fill(&mut run, "vertex/exact", [8.0, 2e6], |case| {
        case.figure("boundary_moved_px", 1.0 / 64.0);
    });
    fill(&mut run, "vertex/wrong", [0.1, 10.0], |case| {
        case.ended(Status::Wrong, "9 pixels outside the band");
    });
    let repeat = run.cases[4].id.repeat();
    run.case(repeat)
        .timed("fill_cpu_ms", &[8.0, 8.08, 7.92, 8.0, 8.16]);
    run
}

/// What the limits are, and the answers for all scenes.
fn told(run: &MadeUpRun, budget: Budget) -> [String; 2] {
    let folder = tempfile::tempdir().expect("a folder");
    let run = run.write(folder.path()).expect("a run");
    budget.write(folder.path()).expect("written");
    let answers = FillingChapter.answers(&run).expect("answers");
    let folded = answers.blocks.iter().find_map(|block| match block {
        Block::Folded { blocks, .. } => Some(&blocks[..]),
        _ => None,
    });
    match folded {
        Some([Block::Text(limits), Block::List(lines)]) => [limits.clone(), lines.join("\n")],
        other => panic!("{other:?}"),
    }
}

fn answer(run: &MadeUpRun, budget: Budget) -> String {
    let [_, lines] = told(run, budget);
    lines
}

fn starts(text: &str, words: &str) {
    assert!(text.starts_with(words), "{words:?}: {text}");
}

fn has(text: &str, words: &[&str]) {
    for words in words {
        assert!(text.contains(words), "{words:?}: {text}");
    }
}

#[test]
fn the_cheapest_within_the_tolerance_is_named_with_what_exactness_costs() {
    let budget = |tolerance_px| Budget {
        tolerance_px,
        ..Budget::default()
    };
    let usual = answer(&made(), Budget::default());
    starts(
        &usual,
        "s, 2 views: vertex/levels: 12.0 ms for all views together, 8.00",
    );
    has(
        &usual,
        &[
            "moves boundaries by up to 0.500 px",
            "Without moved boundaries: vertex/exact, 2.00 ×",
            "2.00 × the bytes.",
        ],
    );
    let rough = answer(&made(), budget(3.0));
    starts(&rough, "s, 2 views: mask/texture: 3.00 ms");
    has(
        &rough,
        &[
            "4.00 MB",
            "off by up to 3.00 px here",
            "8.00 ×",
            "0.500 × the bytes",
        ],
    );
    let exact = answer(&made(), budget(0.0));
    starts(&exact, "s, 2 views: vertex/exact");
    has(&exact, &["moves no boundary"]);
    // Negative control: by a hair too much.
    starts(&answer(&made(), budget(2.999)), "s, 2 views: vertex/levels");
}

#[test]
fn limits_of_bytes_and_time_exclude_and_the_closest_says_which() {
    let small = Budget {
        tolerance_px: 3.0,
        max_mb: Some(1.0),
        budget_ms: Some(8.1),
    };
    let found = answer(&made(), small);
    starts(&found, "s, 2 views: vertex/levels");
    // 16 ms of the exact one.
    has(
        &found,
        &[
            "over --max-mb 1 by 2.00 ×",
            "over --budget-ms 8.1 by 1.98 ×",
        ],
    );
    let tight = Budget {
        max_mb: Some(0.9),
        ..small
    };
    let found = answer(&made(), tight);
    starts(&found, "s, 2 views: none is within. Closest: vertex/levels");
    has(&found, &["; over --max-mb 0.9 by 1.11 ×."]);
    // A time whose interval reaches over the budget is named as such; one far within is not.
    let near = Budget {
        budget_ms: Some(8.05),
        ..Budget::default()
    };
    has(&answer(&made(), near), &["reaches over the budget"]);
    let far = Budget {
        budget_ms: Some(20.0),
        ..Budget::default()
    };
    assert!(!answer(&made(), far).contains("reaches over"));
}

#[test]
fn ties_are_named_and_the_smaller_is_taken_and_what_is_unknown_is_not_within() {
    let mut run = made();
    fill(&mut run, "vertex/tied", [4.0001, 5e5], |case| {
        case.figure("boundary_moved_px", 0.5);
    });
    // Identical work differed by 1 %.
    let repeat = run.cases[8].clone();
    run.cases.retain(|case| case.id != repeat.id);
    run.case(repeat.id)
        .timed("fill_cpu_ms", &[8.08, 8.16, 8.0, 8.08, 8.24]);
    let found = answer(&run, Budget::default());
    starts(&found, "s, 2 views: vertex/tied");
    has(&found, &["Ties: vertex/levels."]);
    // A mask beyond what is measured is off by an unknown amount, however much is allowed.
    let mut run = made();
    for case in &mut run.cases[..2] {
        case.figures
            .retain(|(metric, ..)| *metric != "boundary_moved_px");
    }
    let any = Budget {
        tolerance_px: 1e6,
        ..Budget::default()
    };
    starts(&answer(&run, any), "s, 2 views: vertex/levels");
}

#[test]
fn one_process_decides_nothing_and_says_so() {
    let limits = |run: &MadeUpRun| {
        let [limits, _] = told(run, Budget::default());
        limits
    };
    assert!(!limits(&made()).contains("decides nothing"));
    let mut one = made();
    for case in &mut one.cases {
        for (.., processes) in &mut case.figures {
            processes.truncate(1);
        }
    }
    has(&limits(&one), &["One process decides nothing"]);
}
