// SPDX-License-Identifier: MIT OR Apache-2.0
//! Claims, findings and the answer, on made-up figures.

use super::*;
use crate::DecalsStudy;
use terrafill_fixtures::studies::{misquoted_if, untested_without};
use terrafill_results::made_up::{MadeUpRun, case_id};
use terrafill_results::{CaseId, Standing};

#[test]
fn every_claim_is_tested_by_cases_that_are_planned() {
    // Negative control: a plan without lines.
    let is_line = |case: &CaseId| case.condition("part") == "line";
    let untested = untested_without(&DecalsStudy, &CLAIMS, is_line);
    assert_eq!(untested.len(), 2, "{untested:?}");
}

#[test]
#[ignore = "needs data: papers"]
fn quotations_are_words_of_the_paper() {
    let wrong = misquoted_if(&CLAIMS, "cut through the Earth", "cut the Earth");
    assert_eq!(wrong.len(), 1, "{wrong:?}");
}

#[test]
fn an_answer_has_the_largest_error_of_each_rule_and_its_cells() {
    let mut run = MadeUpRun::default();
    let rows = [
        ("nadir", "10", 0.5, 10.0),
        ("limb", "10", 2.0, 10.0),
        ("nadir", "formula", 0.125, 6.0),
    ];
    for (view, division, px, cells) in rows {
        let conditions = [
            ("part", "decal"),
            ("extent", "country"),
            ("view", view),
            ("division", division),
            ("origin", "corner"),
            ("series", "14"),
            ("projection", "globe"),
            ("size_px", "256x256"),
        ];
        let name = format!("{view}{division}");
        let case = run.case(case_id(crate::STUDY, &name, &conditions));
        case.figure(DECAL_PX_MAX.name, px);
        case.figure(DECAL_CELLS.name, cells);
    }
    // Negative control: a decal elsewhere is of no extent's answer.
    let pole = [
        ("part", "decal"),
        ("extent", "city"),
        ("location", "pole"),
        ("projection", "globe"),
        ("origin", "corner"),
        ("series", "14"),
        ("division", "10"),
    ];
    run.case(case_id(crate::STUDY, "pole", &pole))
        .figure(DECAL_PX_MAX.name, 9.0);
    let found = answers(&Cases::of_study(&run.loaded(), crate::STUDY)).blocks;
    let [Block::List(sentences)] = &found[..] else {
        panic!("{found:?}");
    };
    let expected = "A decal of a country is off by at most, in 2 views of 256x256 px. 10 × 10: 2.00 px; by the formula, at \
                    most 6 cells a side: 0.125 px.";
    assert_eq!(sentences[..], [expected]);
}

#[test]
fn errors_above_their_bounds_are_said() {
    let standings = |px: f64, hidden: f64| {
        let mut run = MadeUpRun::default();
        for division in ["1", "10", "formula", "query"] {
            for (part, depth, extent) in [
                ("decal", "", "country"),
                ("decal", "", "continent"),
                ("decal", "tested", "continent"),
                ("line", "tested", "continent"),
            ] {
                let name = format!("{part}{division}{depth}{extent}");
                let conditions = [
                    ("part", part),
                    ("extent", extent),
                    ("view", "nadir"),
                    ("division", division),
                    ("depth", depth),
                    ("origin", "corner"),
                    ("series", "14"),
                    ("projection", "globe"),
                ];
                let case = run.case(case_id(crate::STUDY, &name, &conditions));
                case.figure(DECAL_PX_MAX.name, px);
                case.figure(DECAL_MAX_MIL.name, px);
                case.figure(DECAL_MISMATCHED_PX.name, px.floor());
                case.figure(DECAL_HIDDEN_SHARE.name, hidden);
            }
        }
        let run = run.loaded();
        let cases = Cases::of_study(&run, crate::STUDY);
        let of = |findings: Vec<Finding>| findings.into_iter().map(|of| of.standing);
        let all = of(DIVIDED.found(&cases)).chain(of(TESTED.found(&cases)));
        let mut all: Vec<Standing> = all.collect();
        all.push(answers(&cases).requirements[0].standing);
        all
    };
    use Standing::{DoesNotHold, Holds};
    assert_eq!(
        standings(0.1, 0.0),
        [Holds, Holds, DoesNotHold, Holds, Holds, DoesNotHold, Holds]
    );
    // Negative control.
    let others = [
        DoesNotHold,
        DoesNotHold,
        Holds,
        DoesNotHold,
        DoesNotHold,
        Holds,
        DoesNotHold,
    ];
    assert_eq!(standings(1.5, 0.95), others);
}

#[test]
fn what_some_map_shows_is_refuted_by_all_of_them_alone() {
    let standing = |maps: &[(&str, &str)], px: f64| {
        let mut run = MadeUpRun {
            metrics: METRICS.to_vec(),
            ..MadeUpRun::default()
        };
        for (projection, view) in maps {
            let conditions = [
                ("part", "decal"),
                ("projection", projection),
                ("view", view),
                ("division", "query"),
            ];
            let name = format!("{projection}/{view}");
            let case = run.case(case_id(crate::STUDY, &name, &conditions));
            case.figure(DECAL_PX_MAX, px);
        }
        counts_may_fail(&Cases::of_study(&run.loaded(), crate::STUDY)).standing
    };
    assert_eq!(standing(&MAP_VIEWS, 0.5), Standing::DoesNotHold);
    assert_eq!(standing(&MAP_VIEWS[..1], 2.0), Standing::Holds);
    // Negative control: one map less, as in a quick run.
    assert_eq!(standing(&MAP_VIEWS[1..], 0.5), Standing::NotMeasured);
}
