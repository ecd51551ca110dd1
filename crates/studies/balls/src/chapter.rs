// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on balls: error against step and against time, orders, bottoms of f32, energy, findings.

mod claims;
mod craters;
mod devices;
mod drawn;
mod number;

use crate::drop::MOSTLY;
use crate::integrator::Integrator;
use crate::metrics::*;
use number::number;
use terrafill_lab::{
    Cases, Drawing, Figure, Names, Panel, Section, SectionedChapter, Select, finding, log_slope,
};
use terrafill_plot::number::significant;
use terrafill_plot::{PointStanding, Upwards};
use terrafill_results::{Answers, Block, Case, Cell, Finding, Heading, Row, Table};

/// Largest `ω·dt` at which a contact counts as resolved: 31 steps long.
const RESOLVED: f64 = 0.1;
/// What compensated exact events are held to, metres.
const EVENT_M: f64 = 2e-6;
/// To what the least work is named, metres.
const NEAR_M: f64 = 0.01;
/// By how much a fitted order may differ: few contacts are averaged over.
const ORDER_TOLERANCE: f64 = 0.25;
/// Contacts by their stiffness.
const CONTACTS: [&str; 4] = ["1e3", "1e5", "1e7", "hard"];

/// Balls on flat ground, on devices, and drawn.
pub(crate) const CHAPTER: SectionedChapter = SectionedChapter {
    study: crate::STUDY,
    title: "Balls: stiff contact by every integrator",
    question: "Which integrator takes a bouncing ball to which error, and what does a step cost on devices?",
    text: "Balls are dropped at rest from 1 to 3 m onto flat ground and bounce for 5 s without loss. Below the \
           surface a spring of stiffness k/m pushes them out, or they are reflected. The reference is the \
           closed form in double precision. State gap: the height above the ground is stored; state height: the \
           height above the ellipsoid, with the ground at 1 km. Times are process CPU time of a second of a \
           ball. Runs of which more than half the balls blew up are at the upper edge of the plots. What \
           Patidar, Bhattacharjee, Singh and Narayanan (2007) claim of balls on a device is the last section.",
    terms: crate::metrics::TERMS,
    primary: Figure::Metric(BALL_CPU_US),
    answers,
    sections: &[
        contact("Contact 1e3", |case| is_drop(case, "1e3")),
        contact("Contact 1e5", |case| is_drop(case, "1e5")),
        contact("Contact 1e7", |case| is_drop(case, "1e7")),
        contact("Contact hard", |case| is_drop(case, "hard")),
        Section {
            title: "Orders and bottoms",
            cases: Select::With(PART, "drop"),
            more: &[|cases| Ok(Some(Block::Table(orders(cases))))],
            ..Section::EMPTY
        },
        devices::SECTION,
        drawn::SECTION,
        craters::SECTION,
    ],
    claims: Some(&claims::CLAIMS),
};

/// Error against step and against time, a plot for each arithmetic.
const fn contact(title: &'static str, cases: fn(&Case) -> bool) -> Section<'static> {
    Section {
        title,
        cases: Select::Fitting(cases),
        per: Some(ARITHMETIC),
        drawing: Some(Drawing {
            caption: "Height after 5 s against the closed form.",
            panels: &[
                Panel {
                    title: "against step",
                    across: (
                        "time step, s",
                        Figure::Computed(|case| Some(1.0 / number(case, STEPS_PER_SECOND))),
                    ),
                    ..ERRORS
                },
                Panel {
                    title: "against time",
                    across: ("CPU µs for a second of a ball", Figure::Metric(BALL_CPU_US)),
                    ..ERRORS
                },
            ],
        }),
        ..Section::EMPTY
    }
}

const ERRORS: Panel<'static> = Panel {
    // What blew up is at the edge, whatever is left of it.
    up: (
        "height after 5 s, rms error in m",
        Figure::Computed(|case| case.value(BALL_RMS_M).or(is_blown(case).then_some(1.0))),
    ),
    upwards: Upwards::Error,
    curve: Names::Joined(&[INTEGRATOR]),
    knob: Figure::Condition(STEPS_PER_SECOND),
    standing: |case| {
        if is_blown(case) {
            PointStanding::Failed
        } else {
            PointStanding::Right
        }
    },
    ..Panel::EMPTY
};

fn is_drop(case: &Case, stiffness: &str) -> bool {
    let conditions = [(PART, "drop"), (STIFFNESS, stiffness), (STATE, "gap")];
    conditions
        .iter()
        .all(|(key, value)| case.condition(*key) == *value)
}

fn is_blown(case: &Case) -> bool {
    case.value(BALL_BLOWN_SHARE)
        .is_some_and(|share| share > MOSTLY)
}

fn answers(cases: &Cases<'_>) -> Answers {
    let cheapest = CONTACTS
        .into_iter()
        .filter_map(|stiffness| cheapest(cases, stiffness));
    let mut sentences: Vec<String> = cheapest.collect();
    sentences.extend(devices::recommended(cases));
    sentences.extend(drawn::recommended(cases));
    let blocks = (!sentences.is_empty()).then_some(Block::List(sentences));
    let mut requirements = findings(cases);
    requirements.extend(devices::findings(cases));
    requirements.extend(drawn::findings(cases));
    requirements.extend(craters::findings(cases));
    Answers {
        blocks: blocks.into_iter().collect(),
        requirements,
        ..Answers::default()
    }
}

/// The least work to 1 cm.
fn cheapest(cases: &Cases<'_>, stiffness: &str) -> Option<String> {
    let near = cases.fitting(|case| {
        is_drop(case, stiffness) && case.value(BALL_RMS_M).is_some_and(|rms| rms <= NEAR_M)
    });
    let best = near.best(BALL_CPU_US)?;
    let name = |case: &Case| {
        let [integrator, arithmetic, steps] =
            [INTEGRATOR, ARITHMETIC, STEPS_PER_SECOND].map(|key| case.condition(key));
        format!("{integrator} in {arithmetic} at {steps} steps a second")
    };
    let error = best.case.value(BALL_RMS_M).map(significant);
    Some(format!(
        "Contact {stiffness} is taken to {} cm with least work by {}{}: {} µs a second of a ball, {} m off.",
        significant(100.0 * NEAR_M),
        name(best.case),
        best.tied_with(name),
        significant(best.value),
        error.unwrap_or_default(),
    ))
}

/// Step and error of the cases of one curve that did not blow up, by falling step.
fn errors(
    cases: &Cases<'_>,
    integrator: &str,
    stiffness: &str,
    arithmetic: &str,
) -> Vec<(f64, f64)> {
    let own = cases.with(&[(INTEGRATOR, integrator), (ARITHMETIC, arithmetic)]);
    let sound = own.fitting(|case| is_drop(case, stiffness) && !is_blown(case));
    let errors = sound.series(STEPS_PER_SECOND, BALL_RMS_M).into_iter();
    errors.map(|(steps, error)| (1.0 / steps, error)).collect()
}

/// Least squares of log error over log step, where contact is resolved; `None` below three steps.
fn fitted_order(errors: &[(f64, f64)], stiffness: &str) -> Option<f64> {
    // A reflection has no contact to resolve.
    let frequency = stiffness.parse::<f64>().map_or(1.0, f64::sqrt);
    let fine = errors
        .iter()
        .filter(|(dt, error)| dt * frequency <= RESOLVED && *error > 0.0);
    log_slope(fine.copied())
}

/// The step with the least error, and that error.
fn bottom(errors: &[(f64, f64)]) -> Option<(f64, f64)> {
    errors.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1))
}

fn orders(cases: &Cases<'_>) -> Table {
    let mut rows = Vec::new();
    for stiffness in CONTACTS {
        let integrators: &[Integrator] = match stiffness {
            "hard" => &Integrator::HARD,
            _ => &Integrator::SPRING,
        };
        for integrator in integrators {
            let [double, single] =
                ["f64", "f32"].map(|of| errors(cases, integrator.name(), stiffness, of));
            // What has no order errs by rounding alone, which no line describes.
            let order = integrator
                .order()
                .and_then(|_| fitted_order(&double, stiffness));
            let least = bottom(&single);
            let turns = least
                .zip(single.last())
                .map(|(least, finest)| finest.0 < least.0);
            let exact = "exact but for rounding";
            let absent = match integrator.order() {
                None => exact,
                Some(_) => "fewer than three resolved steps",
            };
            let blown = |text| Cell::or_absent(text, "all blew up");
            rows.push(Row::new(vec![
                Cell::name(format!("{} {stiffness}", integrator.name())),
                Cell::or_absent(integrator.order().map(significant), exact),
                Cell::or_absent(order.map(significant), absent),
                blown(least.map(|least| format!("1/{:.0}", 1.0 / least.0))),
                blown(least.map(|least| significant(least.1))),
                blown(turns.map(|turns| if turns { "yes" } else { "no" }.to_owned())),
            ]));
        }
    }
    let headings = [
        "integrator",
        "order by theory",
        "order fitted",
        "f32: best step, s",
        "f32: least error, m",
        "f32: worse below it",
    ];
    Table {
        caption: "Orders fitted in f64 over steps with ω·dt ≤ 0.1, and the bottom of f32"
            .to_owned(),
        headings: headings.map(Heading::plain).into(),
        rows,
        is_main: true,
        ..Table::default()
    }
}

fn findings(cases: &Cases<'_>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for integrator in [
        Integrator::SymplecticEuler,
        Integrator::VelocityVerlet,
        Integrator::Rk4,
        Integrator::SplitVerlet,
    ] {
        let (name, expected) = (integrator.name(), integrator.order());
        let order = fitted_order(&errors(cases, name, "1e3", "f64"), "1e3");
        let both = order.zip(expected);
        findings.push(finding(
            format!(
                "{name} through contact has order {}:",
                expected.unwrap_or(0.0)
            ),
            both.map(|(found, expected)| (found - expected).abs() <= ORDER_TOLERANCE),
            order.map(significant).unwrap_or_default(),
        ));
    }
    for name in ["velocity-verlet", "rk4", "split-verlet"] {
        let single = errors(cases, name, "1e3", "f32");
        let turn = bottom(&single).zip(single.last().copied());
        let because = turn.map(|(least, finest)| {
            format!(
                "bottom at 1/{:.0} s with {} m, {} m at 1/{:.0} s",
                1.0 / least.0,
                significant(least.1),
                significant(finest.1),
                1.0 / finest.0
            )
        });
        findings.push(finding(
            format!(
                "In f32 the error of {name} has a bottom, below which smaller steps make it worse:"
            ),
            turn.map(|(least, finest)| finest.0 < least.0),
            because.unwrap_or_default(),
        ));
    }
    let events = errors(cases, "exact-event", "hard", "compensated-f32");
    let worst = events.iter().map(|event| event.1).max_by(f64::total_cmp);
    findings.push(finding(
        "Exact events in compensated f32 are right to 2 µm at every step:",
        worst.map(|worst| worst <= EVENT_M),
        worst.map_or_else(String::new, |worst| {
            format!("worst {} m", significant(worst))
        }),
    ));
    findings
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    #[test]
    fn the_least_work_is_named_of_what_is_within_the_stated_error() {
        let said = |rms_m: f64| {
            let mut made = MadeUpRun::default();
            for (integrator, us, rms_m) in [("rk4", 2.0, 0.005), ("symplectic-euler", 1.0, rms_m)] {
                let conditions = [
                    ("part", "drop"),
                    ("integrator", integrator),
                    ("stiffness", "1e3"),
                    ("arithmetic", "f32"),
                    ("state", "gap"),
                    ("steps_per_second", "480"),
                ];
                let case = made.case(case_id(crate::STUDY, integrator, &conditions));
                case.timed(BALL_CPU_US, &[us]);
                case.figure(BALL_RMS_M, rms_m);
            }
            cheapest(&Cases::of_study(&made.loaded(), crate::STUDY), "1e3").expect("a sentence")
        };
        assert!(said(0.011).contains("by rk4"), "{}", said(0.011));
        // Negative control: within the error it is.
        assert!(
            said(0.009).contains("by symplectic-euler"),
            "{}",
            said(0.009)
        );
    }
}
