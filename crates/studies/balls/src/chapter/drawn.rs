// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter's section on balls over terrain that are drawn.

use super::devices::{PROPORTIONAL, time_name};
use super::number::number;
use crate::drawing::DrawCalls;
use crate::flight::{ALLOWED_STEP_M, ALLOWED_STEP_SPEED, Law};
use crate::metrics::*;
use crate::stepping::Stepping;
use crate::walk::{ALLOWED_ENERGY, ALLOWED_EVENT_S};
use std::collections::BTreeMap;
use terrafill_lab::{
    Cases, Column, Comparison, Drawing, Figure, Names, Panel, Section, Select, finding, log_slope,
};
use terrafill_plot::number::{figure, significant, times};
use terrafill_results::{
    Block, Case, Cell, Claim, Clock, Estimate, Finding, Heading, Metric, Noise, Row, Scope, Table,
    over_processes, process_medians, ratio,
};

/// The one number that was published with balls.
const PUBLISHED_BALLS: &str = "4000";
const WHAT_FIGURE_12_CANNOT_SHOW: &str = "Published is a figure of seconds a step up to 5,000 balls, and one number: 4,000 balls at 21 frames per second, \
     11.9 µs a ball. It does not separate physics from drawing, and the published text draws one point by a call. \
     Beside it stands here how many times as long a frame takes by a draw each.";

pub(super) const SECTION: Section<'static> = Section {
    title: "Balls over terrain, drawn",
    text: "Balls fly level at up to 3 m/s from 0.1 to 1.3 m above bilinear terrain of 4 × 4 blocks with 257 × 257 heights \
           each. The blocks are layers of one array texture, and a ball's place chooses its layer. In 144 steps of 1/240 s, \
           a million in 48, a ball that is below the ground is reflected about its normal, which leaves 0.8 of the speed \
           along it. A step is from one buffer into another; the CPU's way writes all balls for the device. They are drawn \
           as points: not at all, by one draw for all, or by a draw each; a frame is one step and its draws. Each step is \
           held against f64 from the same state, the first impact against the exact event in f64, pictures against the \
           places that the device has.",
    cases: Select::With(PART, "drawn"),
    named_by: Names::Columns(&[
        ("interface", INTERFACE),
        ("way", WAY),
        ("reflected", INTEGRATOR),
        ("drawn", DRAWN),
        ("balls", BALLS),
    ]),
    columns: &[
        Column::metric("CPU µs a frame", BALL_FRAME_CPU_US),
        Column::of(
            "CPU ns a frame and ball",
            Figure::Computed(|case| {
                Some(1e3 * case.value(BALL_FRAME_CPU_US)? / number(case, BALLS))
            }),
        ),
        of_drawn("CPU µs of the draws", BALL_DRAW_CPU_US),
        of_drawn("GPU µs of the draws", BALL_DRAW_GPU_US),
        Column::metric("draws", BALL_DRAWS),
        Column::metric("uploaded", BALL_UPLOAD_BYTES),
        Column::metric("GPU µs of the step", BALL_STEP_GPU_US).or("the device keeps no time"),
        Column::metric("a step's error, m", BALL_TERRAIN_STEP_M),
        Column::metric("first impact's error, s", BALL_IMPACT_MAX_S),
        Column::metric("its place's, m", BALL_IMPACT_PLACE_M).or(OF_FEW),
        Column::metric("its energy's, share", BALL_IMPACT_ENERGY).or(OF_FEW),
        Column::metric("missed, share", BALL_IMPACT_MISSED),
        Column::metric("sunk, share", BALL_SUNK_SHARE),
        of_drawn("wrong pixels", BALL_MISMATCHED_PX),
    ],
    findings: &[
        |cases| each_is_slower(cases, Stepping::ALL[0]),
        |cases| each_is_slower(cases, Stepping::ALL[1]),
        |cases| each_is_slower(cases, Stepping::ALL[2]),
        |cases| each_is_slower(cases, Stepping::ALL[3]),
    ],
    drawing: Some(Drawing {
        caption: "A step of balls that are reflected as published, nothing drawn.",
        panels: &[Panel {
            title: "as figure 12",
            across: ("balls", Figure::Condition(BALLS)),
            up: (
                "a step, µs: the device's clock where it keeps time, else process CPU",
                Figure::Computed(step_us),
            ),
            curve: Names::Joined(&[INTERFACE, WAY]),
            knob: Figure::Condition(BALLS),
            ..Panel::EMPTY
        }],
    }),
    more: &[
        |cases| Ok(Some(Block::Table(growth(cases)))),
        |_| Ok(Some(Block::Remark(WHAT_FIGURE_12_CANNOT_SHOW.to_owned()))),
    ],
    ..Section::EMPTY
};

/// Of a step of balls that are reflected as published and not drawn.
fn step_us(case: &Case) -> Option<f64> {
    let is_shown = case.condition(DRAWN) == DrawCalls::Nothing.name()
        && case.condition(INTEGRATOR) == Law::Published.name();
    let time = || {
        case.value(BALL_STEP_GPU_US)
            .or(case.value(BALL_FRAME_CPU_US))
    };
    is_shown.then(time)?
}

/// Why figures of a first impact are absent.
const OF_FEW: &str = "of so many balls not every step is looked at";
/// Frames a second of the one number that was published.
const PUBLISHED_FPS: f64 = 21.0;
/// Numbers of balls between which the exponent is taken, and up to which figure 12 goes.
const EXPONENT: [f64; 2] = [1e4, 1e6];
const FIGURE_12: f64 = 5_000.0;

/// Time of a step of each process, microseconds, by the number of balls.
fn steps(cases: &Cases<'_>, way: Stepping) -> Vec<(f64, BTreeMap<u32, f64>)> {
    let (interface, name) = way.names();
    let metric = match way {
        Stepping::Cpu => BALL_FRAME_CPU_US,
        _ => cases.clock().pick(BALL_STEP_GPU_US, BALL_FRAME_CPU_US),
    };
    let own = cases.with(&[
        (INTERFACE, interface),
        (WAY, name),
        (DRAWN, DrawCalls::Nothing.name()),
        (INTEGRATOR, Law::Published.name()),
    ]);
    let own = own.iter().filter(|case| case.counts());
    own.map(|case| (number(case, BALLS), process_medians(case, metric)))
        .collect()
}

/// Fixed microseconds and microseconds a ball by least squares of relative errors; `None` below three points.
fn line(points: &[(f64, f64)]) -> Option<[f64; 2]> {
    if points.len() < 3 {
        return None;
    }
    let mut sums = [0.0_f64; 5];
    for (balls, us) in points {
        let weight = (us * us).recip();
        let terms = [1.0, *balls, balls * balls, *us, balls * us];
        for (sum, term) in sums.iter_mut().zip(terms) {
            *sum += weight * term;
        }
    }
    let [one, x, xx, y, xy] = sums;
    let determinant = one * xx - x * x;
    let each = (one * xy - x * y) / determinant;
    Some([(y - each * x) / one, each])
}

/// What a fit finds in every process that measured all of it.
fn over<const N: usize>(
    steps: &[(f64, BTreeMap<u32, f64>)],
    fits: impl Fn(f64) -> bool,
    fit: impl Fn(&[(f64, f64)]) -> Option<[f64; N]>,
) -> Option<[Estimate; N]> {
    let steps: Vec<_> = steps.iter().filter(|(balls, _)| fits(*balls)).collect();
    let (_, first) = steps.first()?;
    let of_process = |process: &u32| {
        let point =
            |(balls, times): &&(f64, BTreeMap<u32, f64>)| Some((*balls, *times.get(process)?));
        fit(&steps.iter().map(point).collect::<Option<Vec<_>>>()?)
    };
    let fits: Vec<[f64; N]> = first.keys().filter_map(of_process).collect();
    let estimates: Option<Vec<Estimate>> = (0..N)
        .map(|at| over_processes(&fits.iter().map(|fit| fit[at]).collect::<Vec<_>>()))
        .collect();
    estimates?.try_into().ok()
}

/// The exponent of time over numbers of balls.
fn exponent(cases: &Cases<'_>, way: Stepping) -> Option<Estimate> {
    let inside = |balls: f64| (EXPONENT[0]..=EXPONENT[1]).contains(&balls);
    let fit = |points: &[(f64, f64)]| Some([log_slope(points.iter().copied())?]);
    over(&steps(cases, way), inside, fit).map(|[exponent]| exponent)
}

/// How time grows with balls, by lines and exponents.
fn growth(cases: &Cases<'_>) -> Table {
    let row = |way: Stepping| {
        let (interface, name) = way.names();
        let fitted = over(&steps(cases, way), |balls| balls <= FIGURE_12, line);
        let of = |at: usize| fitted.as_ref().map(|fitted| &fitted[at]);
        let spread = |estimate: Option<&Estimate>, scale: f64| {
            let scaled = estimate.map(|of| Estimate {
                middle: of.middle * scale,
                interval: of.interval.map(|both| both.map(|end| end * scale)),
                processes: of.processes,
            });
            Cell::or_absent(
                scaled.as_ref().map(figure),
                "fewer than three numbers of balls were measured",
            )
        };
        let frame_us = 1e6 / PUBLISHED_FPS;
        let ends = of(0).zip(of(1)).filter(|(_, each)| each.middle > 0.0);
        let most = ends
            .map(|(fixed, each)| significant(((frame_us - fixed.middle) / each.middle).max(0.0)));
        Row::new(vec![
            Cell::name(format!("{interface} {name}")),
            spread(of(0), 1.0),
            spread(of(1), 1e3),
            spread(exponent(cases, way).as_ref(), 1.0),
            Cell::or_absent(most, "no line that rises"),
        ])
    };
    let headings = [
        "stepped by",
        "fixed, µs",
        "each ball, ns",
        "exponent, 1e4 to 1e6 balls",
        "balls at 21 frames a second",
    ];
    Table {
        caption: "A step's time by number of balls: a line through those of up to 5,000, an exponent above"
            .to_owned(),
        headings: headings.map(Heading::plain).into(),
        rows: Stepping::ALL.map(row).into(),
        is_main: true,
        ..Table::default()
    }
}

/// Whether time grows as balls do: the whole interval lies within 0.9 to 1.1.
fn is_linear(cases: &Cases<'_>, way: Stepping) -> Finding {
    let (interface, name) = way.names();
    let found = exponent(cases, way);
    let ends = |of: &Estimate| of.interval.unwrap_or([of.middle; 2]);
    let holds = found
        .as_ref()
        .map(|of| ends(of).iter().all(|end| PROPORTIONAL.contains(end)));
    finding(
        format!(
            "{} of a step over terrain by {interface} {name} grows as the balls do, from 1e4 to 1e6:",
            time_name(way, cases.clock())
        ),
        holds,
        found.map_or_else(String::new, |of| format!("exponent {}", figure(&of))),
    )
}

const fn of_drawn(heading: &'static str, metric: &'static Metric) -> Column {
    Column::metric(heading, metric).or_of(|case| match case.condition(DRAWN) {
        "none" => "nothing is drawn",
        _ => "not measured",
    })
}

/// A GPU's clock does not cover the calls of a frame, so on hardware it is the wall clock.
fn frame(clock: Clock) -> &'static Metric {
    clock.pick(BALL_FRAME_WALL_US, BALL_FRAME_CPU_US)
}

/// The published number of balls by a draw each and by one for all.
fn pair<'a>(cases: &Cases<'a>, way: Stepping) -> Option<[&'a Case; 2]> {
    let (interface, name) = way.names();
    let own = cases.with(&[
        (PART, "drawn"),
        (INTERFACE, interface),
        (WAY, name),
        (BALLS, PUBLISHED_BALLS),
    ]);
    let drawn = [DrawCalls::Each, DrawCalls::All].map(DrawCalls::name);
    own.pairs(DRAWN, drawn, &[]).first().copied()
}

/// How to draw balls, by the number that was published.
pub(super) fn recommended(cases: &Cases<'_>) -> Vec<String> {
    let metric = frame(cases.clock());
    let noise = cases.noise(metric);
    let of_way = |way: Stepping| {
        let (interface, name) = way.names();
        let [each, all] = pair(cases, way)?;
        let slowdown = ratio(each, all, metric).filter(|_| each.counts() && all.counts())?;
        let how = match faster(&slowdown, noise) {
            Some(true) => "best drawn by one draw for all",
            Some(false) => "best drawn by a draw each",
            None => "drawn as well by one draw for all as by a draw each, a tie",
        };
        let (each, all) = (each.value(BALL_DRAWS)?, all.value(BALL_DRAWS)?);
        Some(format!(
            "{PUBLISHED_BALLS} balls stepped by {interface} {name} are {how}: {each} draws take {} times a frame with \
             {all}.",
            times(&slowdown)
        ))
    };
    Stepping::ALL.into_iter().filter_map(of_way).collect()
}

/// Whether a draw each takes longer; `None` where identical work differed by as much. Too few processes for an interval
/// leave the ratio itself.
fn faster(slowdown: &Estimate, noise: Option<Noise>) -> Option<bool> {
    let band = Noise::band(noise);
    let [low, high] = slowdown.interval.unwrap_or([slowdown.middle; 2]);
    match (low > band, high < 1.0 / band) {
        (true, _) => Some(true),
        (_, true) => Some(false),
        _ => None,
    }
}

fn each_is_slower(cases: &Cases<'_>, way: Stepping) -> Finding {
    let (interface, name) = way.names();
    let comparison = Comparison {
        changed: DRAWN.name(),
        follows: &[],
        one_sided: None,
        metric: frame(cases.clock()),
        needs: Scope::DISPATCH.and(Scope::DRAW),
    };
    let claim = format!(
        "{PUBLISHED_BALLS} balls stepped by {interface} {name}: a frame with one draw for all is faster than one with \
         a draw each, as the published text has it:"
    );
    cases.compared(
        &comparison,
        pair(cases, way).as_slice(),
        Claim::Faster,
        claim,
    )
}

pub(super) fn findings(cases: &Cases<'_>) -> Vec<Finding> {
    let own = cases.with(&[(PART, "drawn")]);
    if own.is_empty() {
        return Vec::new();
    }
    let most = |metric| own.greatest(metric);
    let text = |found: Option<f64>, unit: &str| {
        found.map_or_else(String::new, |found| {
            format!("at most {} {unit}", significant(found))
        })
    };
    let at_most = |claim: String, unit: &str, most: Option<f64>, allowed: f64| {
        finding(claim, most.map(|most| most <= allowed), text(most, unit))
    };
    let devices = own.fitting(|case| case.condition(INTERFACE) != Stepping::Cpu.names().0);
    let of_law = |law: Law| own.with(&[(INTEGRATOR, law.name())]);
    let pixels = most(BALL_MISMATCHED_PX).zip(most(BALL_DIFFERING_PX));
    let mut findings = vec![
        at_most(
            format!(
                "Every step of a ball over terrain is within {ALLOWED_STEP_M} m of f64 from the same state:"
            ),
            "m",
            most(BALL_TERRAIN_STEP_M),
            ALLOWED_STEP_M,
        ),
        at_most(
            format!("And its velocity within {ALLOWED_STEP_SPEED} m/s:"),
            "m/s",
            most(BALL_TERRAIN_STEP_SPEED),
            ALLOWED_STEP_SPEED,
        ),
    ];
    for law in Law::ALL {
        let [late, energy, sunk] = [BALL_IMPACT_MAX_S, BALL_IMPACT_ENERGY, BALL_SUNK_SHARE]
            .map(|metric| of_law(law).greatest(metric));
        findings.push(finding(
            format!(
                "Balls reflected {} meet the ground within {} ms of the exact event, and lose what the restitution says:",
                law.name(),
                1e3 * ALLOWED_EVENT_S
            ),
            late.zip(energy)
                .map(|(late, energy)| late <= ALLOWED_EVENT_S && energy <= ALLOWED_ENERGY),
            [
                text(late, "s"),
                text(energy, "of the energy that the impact takes"),
                text(sunk.map(|sunk| 100.0 * sunk), "% of the balls sink"),
            ]
            .join(", "),
        ));
    }
    findings.extend(Stepping::ALL.map(|way| is_linear(&own, way)));
    findings.push(at_most(
        "One draw for all and a draw each show the same balls, those of the reference:".to_owned(),
        "wrong pixels",
        pixels.map(|(wrong, differing)| wrong + differing),
        0.0,
    ));
    findings.push(at_most(
        "The CPU uploads nothing while balls over terrain step on a device and are drawn:"
            .to_owned(),
        "B",
        devices.greatest(BALL_UPLOAD_BYTES),
        0.0,
    ));
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_its_fixed_cost_and_its_cost_of_a_ball_and_three_points_at_least() {
        let points = [500.0, 1_000.0, 5_000.0].map(|balls| (balls, 30.0 + 0.02 * balls));
        let [fixed, each] = line(&points).expect("three points");
        assert!((fixed - 30.0).abs() < 1e-6 && (each - 0.02).abs() < 1e-9);
        // Negative controls: a fixed cost is no cost of a ball, and two points are no line.
        let [_, level] = line(&points.map(|(balls, _)| (balls, 30.0))).expect("three points");
        assert!(level.abs() < 1e-9);
        assert_eq!(line(&points[..2]), None);
    }

    #[test]
    fn what_the_noise_covers_is_a_tie_with_few_processes_too() {
        let of = |middle: f64, interval| {
            let processes = 5;
            let slowdown = Estimate {
                middle,
                interval,
                processes,
            };
            faster(&slowdown, None)
        };
        assert_eq!(of(2.0, None), Some(true));
        assert_eq!(of(0.5, Some([0.4, 0.6])), Some(false));
        assert_eq!(of(1.0, None), None);
        // Negative control: an interval that reaches 1 decides nothing.
        assert_eq!(of(2.0, Some([0.9, 3.0])), None);
    }
}
