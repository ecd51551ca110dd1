// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on balls: error against step and against time, orders, bottoms of f32, energy, findings.

use crate::contact::worst_symplectic;
use crate::drop::MOSTLY;
use crate::finding::finding;
use crate::integrator::Integrator;
use crate::keys::{
    ARITHMETIC, BALL_CONTACT_ENERGY_MAX, BALL_CONTACT_ENERGY_MEAN, BALL_CONTACT_ENERGY_RMS,
    BALL_ENERGY_CHANGE, BALL_REST_GAP_M, BALL_REST_SPEED, BALL_SUNK_SHARE, DATUM_M, INTEGRATOR,
    OMEGA_DT, PART, RESTITUTION, STATE, STEPS_PER_SECOND, STIFFNESS,
};
use crate::metrics::METRICS;
use terrafill_plot::number::significant;
use terrafill_plot::{
    Arrangement, Curve, Palette, Point, PointStanding, Reading, Upwards, WorkPrecision, panels,
};
use terrafill_results::{
    Answers, Block, Case, Cell, Chapter, ChapterError, Clock, ConditionKey, Finding, Heading,
    Metric, Outcome, Plot, Row, Run, Table, process_medians, sample_spread,
};

const TIME: &Metric = Metric::of(&METRICS, "ball_cpu_us");
const RMS: &Metric = Metric::of(&METRICS, "ball_rms_m");
const BLOWN: &Metric = Metric::of(&METRICS, "ball_blown_share");
/// Largest `ω·dt` at which a contact counts as resolved: 31 steps long.
const RESOLVED: f64 = 0.1;
/// What compensated exact events are held to, metres.
const EVENT_M: f64 = 2e-6;
/// To what the least work is named, metres.
const NEAR_M: f64 = 0.01;
/// By how much a fitted order may differ: few contacts are averaged over.
const ORDER_TOLERANCE: f64 = 0.25;
/// Balls that literal reflection under symplectic Euler sinks, as computed apart from this program, percent …
const SUNK_PERCENT: f64 = 10.9;
/// … and by how many points it may differ: which balls sink depends on the heights chosen.
const SUNK_TOLERANCE: f64 = 2.0;
/// What is measured.
const WHAT_IS_COMPARED: &str = "Balls are dropped at rest from 1 to 3 m onto flat ground and bounce for 5 s without loss. Below the \
     surface a spring of stiffness k/m pushes them out, or they are reflected. The reference is the \
     closed form in double precision. State gap: the height above the ground is stored; state height: the \
     height above the ellipsoid, with the ground at 1 km. Times are process CPU time of a second of a \
     ball.";

/// Balls on flat ground.
#[derive(Debug, Clone, Copy, Default)]
pub struct BallsChapter;

impl Chapter for BallsChapter {
    fn study(&self) -> &'static str {
        crate::STUDY
    }

    fn title(&self) -> &'static str {
        "Balls: stiff contact by every integrator"
    }

    fn primary_metric(&self, _clock: Clock) -> Option<&'static str> {
        Some(TIME.name)
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        Ok(Answers {
            blocks: recommended(run).into_iter().collect(),
            requirements: all_findings(run),
            ..Answers::default()
        })
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let cases = cases(run);
        if cases.is_empty() {
            return Ok(Vec::new());
        }
        let mut blocks = vec![Block::Text(WHAT_IS_COMPARED.to_owned())];
        blocks.extend(recommended(run));
        blocks.extend(all_findings(run).into_iter().map(Block::Finding));
        for stiffness in ["1e3", "1e5", "1e7", "hard"] {
            blocks.push(Block::section(format!("Contact {stiffness}")));
            blocks.extend(drawings(&cases, stiffness)?);
        }
        blocks.push(Block::section("Orders and bottoms"));
        blocks.push(Block::Table(orders(&cases)));
        for (caption, part, keys, metrics) in TABLES {
            blocks.push(Block::Table(table(&cases, caption, part, keys, metrics)));
        }
        blocks.extend(crate::device_chapter::blocks(run));
        blocks.extend(crate::drawn_chapter::blocks(run));
        Ok(blocks)
    }
}

type TableOf = (
    &'static str,
    &'static str,
    &'static [ConditionKey],
    &'static [(&'static str, &'static Metric)],
);
const TABLES: [TableOf; 3] = [
    (
        "Energy of one contact",
        "contact",
        &[INTEGRATOR, OMEGA_DT],
        &[
            ("mean", BALL_CONTACT_ENERGY_MEAN),
            ("largest", BALL_CONTACT_ENERGY_MAX),
            ("change, rms", BALL_CONTACT_ENERGY_RMS),
        ],
    ),
    (
        "Reflection, 2 000 balls, 10 s",
        "reflect",
        &[INTEGRATOR, RESTITUTION, STEPS_PER_SECOND],
        &[
            ("sunk", BALL_SUNK_SHARE),
            ("energy change", BALL_ENERGY_CHANGE),
        ],
    ),
    (
        "A ball at rest, by the height that its state includes",
        "rest",
        &[STIFFNESS, ARITHMETIC, DATUM_M],
        &[("gap, m", BALL_REST_GAP_M), ("speed, m/s", BALL_REST_SPEED)],
    ),
];

fn cases(run: &Run) -> Vec<&Case> {
    let own = run.of_study(crate::STUDY);
    // What blew up is shown, at the edge of its plot.
    let is_shown = |case: &Case| case.counts() || case.outcome == Outcome::Wrong;
    own.filter(|case| !case.is_twin() && is_shown(case))
        .collect()
}

/// Of the conditions named.
fn of<'a>(cases: &[&'a Case], conditions: &[(ConditionKey, &str)]) -> Vec<&'a Case> {
    let fits = |case: &&Case| {
        conditions
            .iter()
            .all(|(key, value)| case.condition(key) == *value)
    };
    cases.iter().copied().filter(fits).collect()
}

fn number(case: &Case, key: ConditionKey) -> f64 {
    case.condition(key).parse().unwrap_or(f64::NAN)
}

fn is_blown(case: &Case) -> bool {
    case.value(BLOWN).is_some_and(|share| share > MOSTLY)
}

fn drawings(cases: &[&Case], stiffness: &str) -> Result<Vec<Block>, ChapterError> {
    let mut blocks = Vec::new();
    for arithmetic in ["f64", "f32", "compensated-f32"] {
        let conditions = [
            (PART, "drop"),
            (STIFFNESS, stiffness),
            (ARITHMETIC, arithmetic),
            (STATE, "gap"),
        ];
        let own = of(cases, &conditions);
        let blown = own.iter().filter(|case| is_blown(case)).count();
        let mut names: Vec<String> = Vec::new();
        for case in &own {
            let name = case.condition(INTEGRATOR).to_owned();
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let plot = |title, across, by_time: bool| WorkPrecision {
            title,
            across,
            up: "height after 5 s, rms error in m",
            upwards: Upwards::Error,
            curves: names
                .iter()
                .map(|name| curve(&own, name, by_time))
                .collect(),
            lines: Vec::new(),
        };
        let plots = [
            plot("against step", "time step, s", false),
            plot("against time", "CPU µs for a second of a ball", true),
        ];
        let title = format!("contact {stiffness} in {arithmetic}");
        let palette = Palette::new(names.clone());
        let svg = panels(&title, &plots, Arrangement::SideBySide, &palette)?;
        blocks.extend(svg.map(|svg| {
            Block::Plot(Plot {
                caption: format!(
                    "Contact {stiffness}, {arithmetic}. {blown} of {} runs blew up (more than half of \
                     their balls) and are at the upper edge.",
                    own.len()
                ),
                svg,
            })
        }));
    }
    Ok(blocks)
}

fn curve(cases: &[&Case], integrator: &str, by_time: bool) -> Curve {
    let own = of(cases, &[(INTEGRATOR, integrator)]);
    let point = |case: &&Case| {
        let steps = number(case, STEPS_PER_SECOND);
        let x = if by_time {
            sample_spread(case, TIME).map(|spread| {
                let replicates: Vec<f64> = process_medians(case, TIME).into_values().collect();
                Reading::sampled(spread, &replicates)
            })
        } else {
            Some(Reading::exact(1.0 / steps))
        };
        Point {
            knob: steps,
            label: String::new(),
            x,
            y: case.value(RMS).map(Reading::exact),
            y_rms: None,
            standing: match is_blown(case) {
                true => PointStanding::Failed,
                false => PointStanding::Right,
            },
            command: String::new(),
        }
    };
    Curve {
        name: integrator.to_owned(),
        points: own.iter().map(point).collect(),
    }
}

/// Step and error of the cases of one curve that did not blow up, by falling step.
fn errors(cases: &[&Case], conditions: &[(ConditionKey, &str)]) -> Vec<(f64, f64)> {
    let own = of(cases, conditions);
    let sound = own.iter().filter(|case| !is_blown(case));
    let mut errors: Vec<(f64, f64)> = sound
        .filter_map(|case| Some((1.0 / number(case, STEPS_PER_SECOND), case.value(RMS)?)))
        .collect();
    errors.sort_by(|a, b| b.0.total_cmp(&a.0));
    errors
}

fn drop_of<'a>(
    integrator: &'a str,
    stiffness: &'a str,
    arithmetic: &'a str,
) -> [(ConditionKey, &'a str); 5] {
    [
        (PART, "drop"),
        (INTEGRATOR, integrator),
        (STIFFNESS, stiffness),
        (ARITHMETIC, arithmetic),
        (STATE, "gap"),
    ]
}

/// Least squares of log error over log step, where contact is resolved; `None` below three steps.
fn fitted_order(errors: &[(f64, f64)], stiffness: &str) -> Option<f64> {
    // A reflection has no contact to resolve.
    let frequency = stiffness.parse::<f64>().map_or(1.0, f64::sqrt);
    let fine = errors
        .iter()
        .filter(|(dt, error)| dt * frequency <= RESOLVED && *error > 0.0);
    let logs: Vec<(f64, f64)> = fine.map(|(dt, error)| (dt.ln(), error.ln())).collect();
    if logs.len() < 3 {
        return None;
    }
    let count = logs.len() as f64;
    let mean_x = logs.iter().map(|log| log.0).sum::<f64>() / count;
    let mean_y = logs.iter().map(|log| log.1).sum::<f64>() / count;
    let products: f64 = logs
        .iter()
        .map(|log| (log.0 - mean_x) * (log.1 - mean_y))
        .sum();
    let squares: f64 = logs.iter().map(|log| (log.0 - mean_x).powi(2)).sum();
    Some(products / squares)
}

/// The step with the least error, and that error.
fn bottom(errors: &[(f64, f64)]) -> Option<(f64, f64)> {
    errors.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1))
}

fn orders(cases: &[&Case]) -> Table {
    let mut rows = Vec::new();
    for stiffness in ["1e3", "1e5", "1e7", "hard"] {
        let integrators: &[Integrator] = match stiffness {
            "hard" => &Integrator::HARD,
            _ => &Integrator::SPRING,
        };
        for integrator in integrators {
            let of = |arithmetic| errors(cases, &drop_of(integrator.name(), stiffness, arithmetic));
            let (double, single) = (of("f64"), of("f32"));
            // What has no order errs by rounding alone, which no line describes.
            let order = integrator
                .order()
                .and_then(|_| fitted_order(&double, stiffness))
                .map(significant);
            let least = bottom(&single);
            let finest = single.last().copied();
            let turns = least.zip(finest).map(|(least, finest)| finest.0 < least.0);
            let turns = turns.map(|turns| if turns { "yes" } else { "no" }.to_owned());
            let exact = "exact but for rounding";
            let absent = match integrator.order() {
                None => exact,
                Some(_) => "fewer than three resolved steps",
            };
            rows.push(Row::new(vec![
                Cell::name(format!("{} {stiffness}", integrator.name())),
                Cell::or_absent(integrator.order().map(significant), exact),
                Cell::or_absent(order, absent),
                Cell::or_absent(least.map(|l| format!("1/{:.0}", 1.0 / l.0)), "all blew up"),
                Cell::or_absent(least.map(|l| significant(l.1)), "all blew up"),
                Cell::or_absent(turns, "all blew up"),
            ]));
        }
    }
    Table {
        caption: "Orders fitted in f64 over steps with ω·dt ≤ 0.1, and the bottom of f32"
            .to_owned(),
        headings: [
            "integrator",
            "order by theory",
            "order fitted",
            "f32: best step, s",
            "f32: least error, m",
            "f32: worse below it",
        ]
        .map(Heading::plain)
        .into(),
        rows,
        is_main: true,
        ..Table::default()
    }
}

fn table(
    cases: &[&Case],
    caption: &str,
    part: &str,
    keys: &[ConditionKey],
    metrics: &[(&'static str, &'static Metric)],
) -> Table {
    let rows = of(cases, &[(PART, part)]).into_iter().map(|case| {
        let mut cells: Vec<Cell> = Vec::new();
        cells.extend(keys.iter().map(|key| Cell::name(case.condition(key))));
        let values = metrics.iter().map(|(_, metric)| case.value(metric));
        cells.extend(values.map(|value| Cell::or_absent(value.map(significant), "no ball left")));
        Row::new(cells)
    });
    let plain = keys.iter().map(|key| Heading::plain(key.name()));
    let measured = metrics
        .iter()
        .map(|(text, metric)| Heading::metric(*text, *metric));
    Table {
        caption: caption.to_owned(),
        headings: plain.chain(measured).collect(),
        rows: rows.collect(),
        ..Table::default()
    }
}

/// The least work to 1 cm by stiffness, how to step many balls, and how to draw them, with the figures behind it.
fn recommended(run: &Run) -> Option<Block> {
    let cases = cases(run);
    let cheapest = |stiffness: &str| {
        let own = of(
            &cases,
            &[(PART, "drop"), (STIFFNESS, stiffness), (STATE, "gap")],
        );
        let near = own
            .into_iter()
            .filter(|case| case.counts() && case.value(RMS).is_some_and(|rms| rms <= NEAR_M));
        let timed = near.filter_map(|case| Some((case.value(TIME)?, case)));
        let (us, best) = timed.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let error = best.value(RMS).map(significant).unwrap_or_default();
        Some(format!(
            "Contact {stiffness} is taken to {} cm with least work by {} in {} at {} steps a second: {} µs a second \
             of a ball, {error} m off.",
            significant(100.0 * NEAR_M),
            best.condition(INTEGRATOR),
            best.condition(ARITHMETIC),
            best.condition(STEPS_PER_SECOND),
            significant(us),
        ))
    };
    let mut sentences: Vec<String> = ["1e3", "1e5", "1e7", "hard"]
        .into_iter()
        .filter_map(cheapest)
        .collect();
    sentences.extend(crate::device_chapter::recommended(run));
    sentences.extend(crate::drawn_chapter::recommended(run));
    (!sentences.is_empty()).then_some(Block::List(sentences))
}

fn all_findings(run: &Run) -> Vec<Finding> {
    let mut all = findings(&cases(run));
    all.extend(crate::device_chapter::findings(run));
    all.extend(crate::drawn_chapter::findings(run));
    all
}

fn findings(cases: &[&Case]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for name in ["symplectic-euler", "velocity-verlet", "rk4", "split-verlet"] {
        let expected = Integrator::from_name(name).and_then(Integrator::order);
        let order = fitted_order(&errors(cases, &drop_of(name, "1e3", "f64")), "1e3");
        let holds = order
            .zip(expected)
            .map(|(a, b)| (a - b).abs() <= ORDER_TOLERANCE);
        findings.push(finding(
            format!(
                "{name} through contact has order {}",
                expected.unwrap_or(0.0)
            ),
            holds,
            order.map(significant).unwrap_or_default(),
        ));
    }
    for name in ["velocity-verlet", "rk4", "split-verlet"] {
        let single = errors(cases, &drop_of(name, "1e3", "f32"));
        let turn = bottom(&single).zip(single.last().copied());
        findings.push(finding(
            format!(
                "In f32 the error of {name} has a bottom, below which smaller steps make it worse"
            ),
            turn.map(|(least, finest)| finest.0 < least.0),
            turn.map_or_else(String::new, |(least, finest)| {
                format!(
                    "bottom at 1/{:.0} s with {} m, {} m at 1/{:.0} s",
                    1.0 / least.0,
                    significant(least.1),
                    significant(finest.1),
                    1.0 / finest.0
                )
            }),
        ));
    }
    let gains = of(cases, &[(PART, "contact"), (INTEGRATOR, "explicit-euler")]);
    let gains: Vec<f64> = gains
        .iter()
        .filter_map(|case| case.value(BALL_CONTACT_ENERGY_MEAN))
        .collect();
    let least = gains.iter().copied().min_by(f64::total_cmp);
    findings.push(finding(
        "Explicit Euler gains energy in contact at every step".to_owned(),
        least.map(|least| least > 1.0),
        least.map_or_else(String::new, |least| {
            format!("least ratio {}", significant(least))
        }),
    ));
    let near_limit = [
        (PART, "contact"),
        (INTEGRATOR, "symplectic-euler"),
        (OMEGA_DT, "1.9"),
    ];
    let largest = of(cases, &near_limit).first().copied();
    let largest = largest.and_then(|case| case.value(BALL_CONTACT_ENERGY_MAX));
    let formula = worst_symplectic(1.9);
    findings.push(finding(
        format!(
            "Symplectic Euler at ω·dt = 1.9, inside its limit, multiplies energy by up to {}",
            significant(formula)
        ),
        largest.map(|largest| (largest / formula - 1.0).abs() <= 0.02),
        largest.map(significant).unwrap_or_default(),
    ));
    let events = errors(cases, &drop_of("exact-event", "hard", "compensated-f32"));
    let worst = events.iter().map(|event| event.1).max_by(f64::total_cmp);
    findings.push(finding(
        "Exact events in compensated f32 are right to 2 µm at every step".to_owned(),
        worst.map(|worst| worst <= EVENT_M),
        worst.map_or_else(String::new, |worst| {
            format!("worst {} m", significant(worst))
        }),
    ));
    let sunk = |integrator| {
        let conditions = [
            (PART, "reflect"),
            (INTEGRATOR, integrator),
            (RESTITUTION, "1"),
            (STEPS_PER_SECOND, "60"),
        ];
        let case = of(cases, &conditions).first().copied();
        case.and_then(|case| case.value(BALL_SUNK_SHARE))
    };
    let literal = sunk("reflect-symplectic");
    findings.push(finding(
        "Literal reflection under symplectic Euler sinks balls at 1/60 s; put onto the surface none sinks"
            .to_owned(),
        literal.zip(sunk("reflect-guarded")).map(|(literal, guarded)| literal > 0.0 && guarded <= 0.0),
        literal.map_or_else(String::new, |s| format!("{} % sink", significant(100.0 * s))),
    ));
    findings.push(finding(
        format!("By literal reflection at 1/60 s {SUNK_PERCENT} % sink, to within {SUNK_TOLERANCE} points"),
        literal.map(|share| (100.0 * share - SUNK_PERCENT).abs() <= SUNK_TOLERANCE),
        literal.map_or_else(String::new, |s| format!("{} % sink", significant(100.0 * s))),
    ));
    findings
}
