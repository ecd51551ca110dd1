// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter's section on balls over terrain that are drawn.

use super::number::number;
use crate::drawing::DrawCalls;
use crate::metrics::*;
use crate::stepping::Stepping;
use crate::walk::ALLOWED_M;
use terrafill_lab::{Cases, Column, Comparison, Figure, Names, Section, Select, finding};
use terrafill_plot::number::{significant, times};
use terrafill_results::{
    Block, Case, Claim, Clock, Estimate, Finding, Metric, Noise, Outcome, Scope, ratio,
};

/// The one number that was published with balls.
const PUBLISHED_BALLS: &str = "4000";
const WHAT_FIGURE_12_CANNOT_SHOW: &str = "Published is a figure of seconds a step up to 5,000 balls, and one number: 4,000 balls at 21 frames per second, \
     11.9 µs a ball. It does not separate physics from drawing, and the published text draws one point by a call. \
     Beside it stands here how many times as long a frame takes by a draw each.";

pub(super) const SECTION: Section<'static> = Section {
    title: "Balls over terrain, drawn",
    text: "Balls fall from 0.1 to 0.3 m onto bilinear terrain of 64 × 64 m, whose spring of k/m = 1e3 1/s² pushes along \
           the normal, and are drawn as points from the buffer that the step wrote: not at all, by one draw for all, or \
           by a draw each. A frame is one step and its draws. Each step is held against the same integrator in f64, \
           pictures against the places that the device has. Slopes jump from cell to cell: a ball that touches the \
           ground within rounding of a border may be pushed from either side and ends elsewhere. So its end is \
           compared with f64 that takes the device's cell there.",
    cases: Select::With(PART, "drawn"),
    named_by: Names::Columns(&[
        ("interface", INTERFACE),
        ("way", WAY),
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
        Column::metric("a step's error, m", BALL_TERRAIN_STEP_M),
        Column::metric("largest error in the same cells, m", BALL_TERRAIN_GUIDED_M),
        Column::metric("95 % within, m", BALL_TERRAIN_P95_M),
        Column::metric("largest error, m", BALL_TERRAIN_MAX_M),
        of_drawn("wrong pixels", BALL_MISMATCHED_PX),
    ],
    findings: &[
        |cases| each_is_slower(cases, Stepping::ALL[0]),
        |cases| each_is_slower(cases, Stepping::ALL[1]),
        |cases| each_is_slower(cases, Stepping::ALL[2]),
    ],
    more: &[|_| Ok(Some(Block::Remark(WHAT_FIGURE_12_CANNOT_SHOW.to_owned())))],
    ..Section::EMPTY
};

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
    let wrong = own.iter().any(|case| case.outcome == Outcome::Wrong);
    let most = |metric| own.greatest(metric);
    let none = |claim: &str, what: &str, most: Option<f64>| {
        let because = most.map(|most| format!("at most {most} {what}"));
        finding(
            claim,
            most.map(|most| most <= 0.0),
            because.unwrap_or_default(),
        )
    };
    let far = |far: Option<f64>| {
        far.map_or_else(String::new, |far| format!("at most {} m", significant(far)))
    };
    let (step, guided) = (most(BALL_TERRAIN_STEP_M), most(BALL_TERRAIN_GUIDED_M));
    let beyond = most(BALL_TERRAIN_BEYOND).zip(most(BALL_TERRAIN_MAX_M));
    let pixels = most(BALL_MISMATCHED_PX).zip(most(BALL_DIFFERING_PX));
    vec![
        finding(
            "Every step of a ball over terrain is that of f64 from the same state, to the last places:",
            step.map(|_| !wrong),
            far(step),
        ),
        finding(
            "Balls over terrain are within 1 mm of f64 that takes the device's cell at borders:",
            guided.map(|guided| guided <= ALLOWED_M),
            far(guided),
        ),
        finding(
            "Balls farther from f64 of its own have all touched ground in another cell:",
            most(BALL_TERRAIN_UNEXPLAINED).map(|unexplained| unexplained <= 0.0),
            beyond.map_or_else(String::new, |(beyond, far)| {
                format!(
                    "at most {beyond} such balls in a case, up to {} m",
                    significant(far)
                )
            }),
        ),
        none(
            "One draw for all and a draw each show the same balls, those of the reference:",
            "wrong pixels",
            pixels.map(|(wrong, differing)| wrong + differing),
        ),
        none(
            "The CPU uploads nothing while balls over terrain step and are drawn:",
            "B",
            most(BALL_UPLOAD_BYTES),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

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
