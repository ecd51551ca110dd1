use super::table_2::smooths;
use super::*;
use crate::PagingStudy;
use terrafill_fixtures::studies::{misquoted_if, untested_without};
use terrafill_results::made_up::{MadeUpRun, case_id};
use terrafill_results::{CaseId, Chapter as _, Metric, Standing};

#[test]
fn every_claim_is_tested_by_cases_that_are_planned() {
    // Negative control: a plan without the windows of Table 2.
    let is_window = |case: &CaseId| case.condition("part") == "table-2";
    let untested = untested_without(&PagingStudy, &CLAIMS, is_window);
    assert_eq!(untested.len(), 3, "{untested:?}");
}

#[test]
#[ignore = "needs data: papers"]
fn quotations_are_words_of_the_paper() {
    let wrong = misquoted_if(&CLAIMS, "occasional spikes", "frequent spikes");
    assert_eq!(wrong.len(), 1, "{wrong:?}");
}

/// Rule, hysteresis and pages a frame of a flight, and its figures.
type Flown<'a> = (&'a str, &'a str, &'a str, &'a [(&'static Metric, f64)]);

fn run(flights: &[Flown<'_>]) -> MadeUpRun {
    let mut run = MadeUpRun {
        metrics: METRICS.to_vec(),
        ..MadeUpRun::default()
    };
    for (rule, hysteresis, transfers, figures) in flights {
        let conditions = [
            ("part", FLIGHTS),
            ("path", "jump"),
            ("rule", *rule),
            ("hysteresis", *hysteresis),
            ("transfers", *transfers),
        ];
        let name = format!("{rule}/{hysteresis}/{transfers}");
        let case = run.case(case_id(crate::STUDY, &name, &conditions));
        for (metric, value) in *figures {
            case.figure(*metric, *value);
        }
    }
    run
}

#[test]
fn findings_follow_figures_and_their_controls_do_not_hold() {
    let standing = |of: fn(&Cases<'_>) -> Finding, run: &MadeUpRun| {
        of(&Cases::of_study(&run.loaded(), crate::STUDY)).standing
    };
    let of = |wrong: f64, steady: f64, lost: f64, missing: f64| {
        run(&[
            (
                "counted",
                "4",
                "any",
                &[
                    (PAGING_MISMATCHED_PX, wrong),
                    (PAGING_STEADY_BYTES, steady),
                    (PAGING_EDGE_LOSS, lost),
                    (PAGING_MISSING_PX, 10.0),
                ],
            ),
            ("counted", "4", "1", &[(PAGING_MISSING_PX, missing)]),
            ("counted", "1", "any", &[(PAGING_STEADY_BYTES, 1e6)]),
            // Distance does not see the edge.
            ("distance", "4", "any", &[(PAGING_EDGE_LOSS, 0.0)]),
        ])
    };
    let all: [fn(&Cases<'_>) -> Finding; 4] = [exact, steady, edges, late];
    let right = of(0.0, 0.0, 0.5, 20.0);
    assert_eq!(all.map(|of| standing(of, &right)), [Standing::Holds; 4]);
    let wrong = of(1.0, 4.0, 0.05, 5.0);
    assert_eq!(
        all.map(|of| standing(of, &wrong)),
        [Standing::DoesNotHold; 4]
    );
    // A hysteresis of 1 that rests as well tells nothing of the other.
    let calm = run(&[
        ("counted", "4", "any", &[(PAGING_STEADY_BYTES, 0.0)]),
        ("counted", "1", "any", &[(PAGING_STEADY_BYTES, 0.0)]),
    ]);
    assert_eq!(standing(steady, &calm), Standing::DoesNotHold);
    let none = run(&[("counted", "4", "any", &[])]);
    assert_eq!(
        all.map(|of| standing(of, &none)),
        [Standing::NotMeasured; 4]
    );
    let page = format!("{:?}", CHAPTER.blocks(&right.loaded()).expect("a chapter"));
    assert!(page.contains("Flights by every rule") && !page.contains("Table 2: an"));
}

#[test]
fn spikes_within_the_noise_decide_nothing() {
    // A repeat takes 10 % longer than what it repeats.
    let standing = |any: f64, one: f64| {
        let mut run = MadeUpRun::default();
        for (transfers, ms) in [("any", any), ("1", one)] {
            let conditions = [
                ("part", "table-2"),
                ("path", "zoom"),
                ("transfers", transfers),
            ];
            let id = case_id(crate::STUDY, transfers, &conditions);
            let metric = PAGING_UPDATE_MAX_MS;
            run.case(id.repeat()).timed(metric, &[1.1 * ms; 5]);
            run.case(id).timed(metric, &[ms; 5]);
        }
        smooths(&Cases::of_study(&run.loaded(), crate::STUDY)).standing
    };
    assert_eq!(standing(1.05, 1.0), Standing::NoDifference);
    // Controls: beyond it, either way.
    assert_eq!(standing(2.0, 1.0), Standing::Holds);
    assert_eq!(standing(1.0, 2.0), Standing::DoesNotHold);
}
