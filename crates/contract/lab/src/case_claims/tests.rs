// SPDX-License-Identifier: MIT OR Apache-2.0

use super::*;
use crate::cases::finding;
use crate::made_up::{TIME, empty};
use terrafill_results::made_up::case_id;
use terrafill_results::{Run, Status};

const STUDY: &str = "s";
const ERRORS: [Metric; 1] = [Metric::error("grid_error", "px", "Wrong pixels.")];
const ERROR: &Metric = &ERRORS[0];

const TEXT: &str = "source = 'A (2007)'\ndocument = 'a'\nremark = ''\n\
    [[claim]]\nwords = 'other'\nplace = '1'\nbasis = 'observed'\nstudy = 'other'\ntest = { no = 'not here' }\n\
    [[claim]]\nwords = 'faster'\nplace = '1'\nbasis = 'observed'\nstudy = 's'\nexperiment = 'ways'\n\
    test = { ratio = { figure = 'frame', changes = 'way', of = ['sent', 'fetched'], \
    with = { cells = ['64', '128', '256'] }, named-by = ['cells'], expects = 'faster' } }\n\
    [[claim]]\nwords = 'right'\nplace = '1'\nbasis = 'observed'\nstudy = 's'\nexperiment = 'pixels'\n\
    test = { figures = { figure = 'grid_error', with = { way = ['fetched'] }, is = 'none' } }\n\
    [[claim]]\nwords = 'linear'\nplace = '1'\nbasis = 'observed'\nstudy = 's'\nexperiment = 'growth'\n\
    test = { growth = { figure = 'frame', over = 'cells', with = { way = ['sent'] }, between = [0.9, 1.1] } }\n";

fn claims(text: &'static str) -> StudyClaims {
    StudyClaims {
        study: STUDY,
        title: "The claims",
        file: ["a.toml", text],
        times: &[ClaimedTime {
            name: "frame",
            by: [TIME, TIME],
            needs: Scope::DRAW,
        }],
        metrics: &ERRORS,
        findings: |cases| {
            let all = [("ways are right", cases.sum(ERROR)), ("none", None)];
            let all =
                all.map(|(claim, wrong)| finding(claim, wrong.map(|px| px == 0.0), "by rays"));
            all.into_iter().collect()
        },
        page: ["a.md", "Sizes\n\n| | px |\n| --- | --- |\n| one | 4 |\n"],
    }
}

/// Both ways at three sizes: ms of a process for a cell, and wrong pixels of the second way.
fn run_of(sent: f64, fetched: f64, wrong: f64, power: f64) -> Run {
    let mut made = empty();
    made.metrics.extend(ERRORS);
    for cells in ["64", "128", "256"] {
        for (way, ms) in [("sent", sent), ("fetched", fetched)] {
            let size: f64 = cells.parse().expect("a number");
            let ms = ms * size.powf(power);
            let conditions = [("way", way), ("cells", cells)];
            let case = made.case(case_id(STUDY, &format!("{way}/{cells}"), &conditions));
            let spread = [0.99, 1.0, 1.01, 0.995, 1.005, 1.0, 0.99, 1.01];
            case.timed(TIME, &spread.map(|of| of * ms));
            case.figure(ERROR, if way == "fetched" { wrong } else { 0.0 });
        }
    }
    made.loaded()
}

fn standings(claims: &StudyClaims, run: &Run) -> Vec<Standing> {
    let (_, answers) = claims
        .answered(&Cases::of_study(run, STUDY))
        .expect("a paper");
    answers.iter().map(|answer| answer.standing).collect()
}

#[test]
fn a_study_answers_its_own_claims_by_ratios_figures_and_growth() {
    use Standing::{DoesNotHold, Holds, NoDifference, NotMeasured};
    let of = |run: &Run| standings(&claims(TEXT), run);
    assert_eq!(of(&run_of(3.0, 1.0, 0.0, 1.0)), [Holds; 3]);
    // Negative controls: operands swapped, one wrong pixel, growth by the square, nothing measured.
    assert_eq!(of(&run_of(1.0, 3.0, 0.0, 1.0))[0], DoesNotHold);
    assert_eq!(of(&run_of(1.0, 1.0, 0.0, 1.0))[0], NoDifference);
    assert_eq!(of(&run_of(3.0, 1.0, 1.0, 1.0))[1], DoesNotHold);
    assert_eq!(of(&run_of(3.0, 1.0, 0.0, 2.0))[2], DoesNotHold);
    assert_eq!(of(&empty().loaded()), [NotMeasured; 3]);
}

#[test]
fn sums_are_one_ratio_of_all_pairs() {
    let run = run_of(3.0, 1.0, 0.0, 1.0);
    let ours = |text: &'static str| {
        let (_, answers) = claims(text)
            .answered(&Cases::of_study(&run, STUDY))
            .expect("a paper");
        answers[0].ours.clone()
    };
    assert_eq!(ours(TEXT).matches(" ×").count(), 3);
    let summed = TEXT.replace("expects = 'faster'", "is-summed = true, expects = 'faster'");
    let summed = ours(Box::leak(summed.into_boxed_str()));
    assert!(
        summed.starts_with("3.00 ×") && summed.ends_with("over 3 pairs"),
        "{summed}"
    );
}

#[test]
fn a_claim_that_selects_nothing_or_names_no_figure_is_untestable() {
    let run = run_of(3.0, 1.0, 0.0, 1.0);
    let cases = Cases::of_study(&run, STUDY);
    let of = |from: &str, to: &str| {
        let text = TEXT.replace(from, to);
        let claims = claims(Box::leak(text.into_boxed_str()));
        claims.untestable(&cases).expect("a paper")
    };
    assert_eq!(of("", ""), [""; 0]);
    // Negative controls.
    assert_eq!(of("['sent', 'fetched']", "['sent', 'drawn']"), ["faster"]);
    assert_eq!(of("'grid_error'", "'grid_errors'"), ["right"]);
    assert_eq!(
        of(
            "over = 'cells', with = { way = ['sent'] }",
            "over = 'cells', with = { way = ['lost'] }"
        ),
        ["linear"]
    );
}

#[test]
fn an_interval_across_a_bound_decides_nothing() {
    let bound = Bound::Between([0.9, 1.1]);
    assert_eq!(bound.standing(Some([0.95, 1.05])), Standing::Holds);
    assert_eq!(bound.standing(Some([1.05, 1.2])), Standing::CannotTell);
    assert_eq!(bound.standing(Some([1.15, 1.2])), Standing::DoesNotHold);
    assert_eq!(bound.standing(None), Standing::CannotTell);
    assert_eq!(
        Bound::AtMost(2.0).standing(Some([2.1, 3.0])),
        Standing::DoesNotHold
    );
    assert_eq!(Bound::None.standing(Some([0.0, 0.0])), Standing::Holds);
}

#[test]
fn a_case_that_failed_leaves_its_claim_open_and_one_that_a_device_lacks_does_not() {
    let standing = |status| {
        let mut made = empty();
        made.metrics.extend(ERRORS);
        for (way, ms) in [("sent", 3.0), ("fetched", 1.0)] {
            for (cells, size) in [("64", 64.0), ("128", 128.0), ("256", 256.0), ("512", 512.0)] {
                let conditions = [("way", way), ("cells", cells)];
                let case = made.case(case_id(STUDY, &format!("{way}/{cells}"), &conditions));
                if cells == "128" {
                    case.ended(status, "more than the device allows");
                } else {
                    case.timed(TIME, &[ms * size; 8]).figure(ERROR, 0.0);
                }
            }
        }
        standings(&claims(TEXT), &made.loaded())
    };
    assert_eq!(standing(Status::Skipped), [Standing::Holds; 3]);
    // Negative control.
    assert_eq!(standing(Status::Failed), [Standing::CannotTell; 3]);
}

#[test]
fn a_claim_may_rest_on_a_finding_a_sum_or_a_page() {
    const OTHERS: &str = "source = 'A (2007)'\ndocument = 'a'\nremark = ''\n\
        [[claim]]\nwords = 'found'\nplace = '1'\nbasis = 'observed'\nstudy = 's'\nexperiment = 'ways'\n\
        test = { finding = 'are right' }\n\
        [[claim]]\nwords = 'added'\nplace = '1'\nbasis = 'observed'\nstudy = 's'\nexperiment = 'a sum'\n\
        test = { sum = { terms = [[2, 3]], says = 6 } }\n\
        [[claim]]\nwords = 'tabled'\nplace = '1'\nbasis = 'observed'\nstudy = 's'\nexperiment = 'a page'\n\
        test = { page = { below = 'Sizes', row = 'one', column = 'px', is = { at-least = 5 } } }\n\
        [[claim]]\nwords = 'unknown'\nplace = '1'\nbasis = 'observed'\nstudy = 's'\nexperiment = 'ways'\n\
        test = { finding = 'are left' }\n\
        [[claim]]\nwords = 'ambiguous'\nplace = '1'\nbasis = 'observed'\nstudy = 's'\nexperiment = 'ways'\n\
        test = { finding = 'e' }\n\
        [[claim]]\nwords = 'open'\nplace = '1'\nbasis = 'observed'\nstudy = 's'\nexperiment = 'ways'\n\
        test = { finding = 'none' }\n";
    let (claims, right) = (claims(OTHERS), run_of(2.0, 1.0, 0.0, 1.0));
    let expected = |of: Standing| {
        // No finding has the words, several have them, and one has and was not measured.
        let open = [
            Standing::NotMeasured,
            Standing::CannotBeTested,
            Standing::NotMeasured,
        ];
        [[of, Standing::Holds, Standing::DoesNotHold], open].concat()
    };
    assert_eq!(standings(&claims, &right), expected(Standing::Holds));
    let cases = Cases::of_study(&right, STUDY);
    let untestable = claims.untestable(&cases).expect("a paper");
    assert_eq!(untestable, ["unknown", "ambiguous"]);
    // Negative control: a wrong pixel.
    let wrong = run_of(2.0, 1.0, 1.0, 1.0);
    assert_eq!(standings(&claims, &wrong), expected(Standing::DoesNotHold));
}
