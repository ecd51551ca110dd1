// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on radii of the spiral held by counted pixels.

use super::PART;
use super::rule::{PER_TURN, Rule, radii};
use super::view::SIDE_PX;
use crate::counts::course::drawing;
use crate::metrics::{self, *};
use std::collections::BTreeSet;
use terrafill_lab::{Cases, Column, Names, Section, Select, finding};
use terrafill_plot::number::{digits, significant};
use terrafill_results::{Block, Case, ChapterError, Finding, Kind, Metric};

pub(crate) const SECTION: Section<'static> = Section {
    title: "Radii of the spiral by counted pixels",
    text: "From 100 km straight down, fan and turns are drawn by ranges of one static buffer, and their pixels are \
           counted apart: by precise occlusion queries on Vulkan, by a histogram on wgpu. Counts of frame k decide on \
           frame k + delay; the page of arithmetic counts a delay from the frame after, so that its 0 is 1 here. The \
           fan begins with half its 1,257 pixels, the outer radius 20 % beyond the corners; the other radius is in \
           closed form. A rising eye doubles its height each second of 60 frames. All counts are held against rays in \
           f64. A frame is timed with its decision and with its counts read at once.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[
        ("path", PATH),
        ("counted by", COUNTED_BY),
        ("held", CONTROLLER),
        ("rule", RULE),
        ("step", STEP),
        ("delay", DELAY),
    ]),
    columns: &[
        Column::metric("period, frames", GLOBE_CONTROLLER_PERIOD).or_of(why_no_period),
        Column::metric("at rest after, frames", GLOBE_CONTROLLER_REST_FRAMES).or_of(why_no_rest),
        Column::metric("swing, %", GLOBE_CONTROLLER_SWING).or("the eye moves"),
        Column::metric("off closed form, %", GLOBE_CONTROLLER_OFF),
        Column::metric("fan off wanted px, %", GLOBE_FAN_OFF).or("the fan is in closed form"),
        Column::metric("bare px", GLOBE_BARE_PX).or("the outer radius is in closed form"),
        Column::metric("along the diagonal", GLOBE_BARE_DIAGONAL_PX)
            .or("the outer radius is in closed form"),
        Column::metric("px in the rounding band", GLOBE_CONTROLLER_BAND_PX),
        Column::metric("frames off rays", GLOBE_CONTROLLER_WRONG_FRAMES),
        Column::metric("sent a frame", GLOBE_UPLOAD_BYTES),
        Column::metric("frame with counts, CPU ms", GLOBE_CONTROLLED_CPU_MS),
        Column::metric("without", GLOBE_UNCOUNTED_CPU_MS),
    ],
    findings: &[exact, closed, steps, gains, flicker, disc, behind],
    more: &[courses],
    ..Section::EMPTY
};

fn why_no_period(case: &Case) -> &'static str {
    match case.condition(PATH) {
        "rest" => "it does not repeat within a quarter of the frames",
        _ => "the eye moves",
    }
}

fn why_no_rest(case: &Case) -> &'static str {
    match case.condition(PATH) {
        "rest" => "it does not rest",
        _ => "the eye moves",
    }
}

fn number(case: &Case, key: terrafill_results::ConditionKey) -> f64 {
    case.condition(key).parse().unwrap_or(f64::NAN)
}

/// Cases of a rule and a path; those of a step where one is named.
fn of<'a>(cases: &Cases<'a>, rule: Rule, path: &str, step: Option<&str>) -> Cases<'a> {
    let own = cases.with(&[(RULE, rule.name()), (PATH, path)]);
    own.fitting(|case| step.is_none_or(|step| case.condition(STEP) == step))
}

/// From the least to the most of a figure.
fn range(cases: &Cases<'_>, metric: &Metric) -> String {
    let values: Vec<f64> = cases.iter().filter_map(|case| case.value(metric)).collect();
    let [low, high] = [f64::min, f64::max].map(|of| values.iter().copied().reduce(of));
    let text = |value: f64| match metric.kind {
        Kind::Counter if value.fract() == 0.0 => digits(value),
        _ => significant(value),
    };
    match low.zip(high) {
        Some((low, high)) if low == high => text(low),
        Some((low, high)) => format!("{} to {}", text(low), text(high)),
        None => "not measured".to_owned(),
    }
}

/// Whether all of some cases are so; `None` without one.
fn all(cases: &Cases<'_>, metric: &Metric, is: impl Fn(&Case, f64) -> bool) -> Option<bool> {
    let mut figures = cases
        .iter()
        .filter_map(|case| Some((case, case.value(metric)?)));
    let (first, value) = figures.next()?;
    Some(is(first, value) && figures.all(|(case, value)| is(case, value)))
}

fn exact(cases: &Cases<'_>) -> Finding {
    let [wrong, frames] = [GLOBE_CONTROLLER_WRONG_FRAMES, GLOBE_CONTROLLER_FRAMES];
    let counts = cases.sum(wrong).zip(cases.sum(frames));
    finding(
        "The pixels of fan and spiral that devices count are those of rays in f64",
        counts.map(|(wrong, _)| wrong == 0.0),
        match counts {
            Some((wrong, frames)) => format!(
                "{wrong} of {frames} frames are off; rounding decides on {} pixels of a frame.",
                range(cases, GLOBE_CONTROLLER_BAND_PX)
            ),
            None => "Not measured.".to_owned(),
        },
    )
}

fn closed(cases: &Cases<'_>) -> Finding {
    let own = cases.with(&[(RULE, Rule::Closed.name())]);
    finding(
        "In closed form no corner goes bare, at rest or while the eye rises",
        all(&own, GLOBE_BARE_PX, |_, px| px == 0.0),
        format!(
            "Bare: {} px; the fan is off its wanted pixels by {} %.",
            range(&own, GLOBE_BARE_PX),
            range(&own, GLOBE_FAN_OFF)
        ),
    )
}

fn steps(cases: &Cases<'_>) -> Finding {
    let [rest, rising] = ["rest", "rising"].map(|path| of(cases, Rule::Steps, path, None));
    let periods = rest.by(DELAY).into_iter().map(|(delay, own)| {
        let [period, swing] = [GLOBE_CONTROLLER_PERIOD, GLOBE_CONTROLLER_SWING];
        format!(
            "delay {delay}: {} frames and {} %",
            range(&own, period),
            range(&own, swing)
        )
    });
    let periods: Vec<String> = periods.collect();
    finding(
        "Constant steps of the fan repeat after 4 d + 2 frames, as simulated with counts used d frames after the next",
        all(&rest, GLOBE_CONTROLLER_PERIOD, |case, period| {
            period == 4.0 * number(case, DELAY) - 2.0
        }),
        format!(
            "{}. While the eye rises the radius is off by {} %: a constant step falls behind a wanted radius that doubles.",
            periods.join("; "),
            range(&rising, GLOBE_CONTROLLER_OFF)
        ),
    )
}

fn gains(cases: &Cases<'_>) -> Finding {
    let [calm, wild] = ["0.25", "1.5"].map(|step| of(cases, Rule::Logarithmic, "rest", Some(step)));
    let rests = all(&calm, GLOBE_CONTROLLER_PERIOD, |_, period| period == 1.0);
    let grows = all(&wild, GLOBE_FAN_GROWTH, |_, growth| growth > 1.0);
    finding(
        "Logarithmic steps come to rest with a quarter of the limit's gain, and explode with 1.5 of it",
        rests.zip(grows).map(|(rests, grows)| rests && grows),
        format!(
            "A quarter: at rest after {} frames, {} % off the wanted pixels, since less than half a stored vertex moves nothing. \
             1.5: the fan is {} times as far off as it began.",
            range(&calm, GLOBE_CONTROLLER_REST_FRAMES),
            range(&calm, GLOBE_FAN_OFF),
            range(&wild, GLOBE_FAN_GROWTH)
        ),
    )
}

fn flicker(cases: &Cases<'_>) -> Finding {
    let rest = of(cases, Rule::Trying, "rest", None);
    let words = rest.by(STEP).into_iter().map(|(step, own)| {
        let [px, diagonal] = [GLOBE_BARE_PX, GLOBE_BARE_DIAGONAL_PX].map(|of| range(&own, of));
        format!("steps of {step}: {px} px, up to {diagonal} px along the diagonal")
    });
    let words: Vec<String> = words.collect();
    finding(
        "Gebbie & Bailey: trying the outer radius causes a flicker in the corners",
        all(&rest, GLOBE_BARE_PX, |_, px| px > 0.0),
        format!("Bare in turn, over all delays: {}.", words.join("; ")),
    )
}

fn disc(cases: &Cases<'_>) -> Finding {
    let corner_px = f64::from(SIDE_PX) * std::f64::consts::FRAC_1_SQRT_2;
    let simulated = |case: &Case| number(case, STEP) * number(case, DELAY) * corner_px;
    let rest = of(cases, Rule::Trying, "rest", None);
    let words = rest.by(STEP).into_iter().map(|(step, own)| {
        let pairs = own.iter().filter_map(|case| {
            let found = case.value(GLOBE_BARE_DIAGONAL_PX)?;
            let delay = case.condition(DELAY);
            let [found, simulated] = [found, simulated(case)].map(significant);
            Some(format!("{found} for {simulated} at a delay of {delay}"))
        });
        // Once for both ways of counting, where they agree.
        let pairs: BTreeSet<String> = pairs.collect();
        let pairs = Vec::from_iter(pairs);
        format!("steps of {step}: {}", pairs.join(", "))
    });
    let words: Vec<String> = words.collect();
    finding(
        "Trying leaves as much bare as a simulated disc, p (d + 1) of the corner's distance, within a pixel",
        all(&rest, GLOBE_BARE_DIAGONAL_PX, |case, px| {
            (px - simulated(case)).abs() <= 1.0
        }),
        format!(
            "Pixels along the diagonal, {}. A spiral's rim is no circle: it steps by {} % where its last turn ends, and that step \
             moves round with the range's end, so which corner goes bare first hangs on where the range ends.",
            words.join("; "),
            significant(100.0 * (radii(PER_TURN, 0) - 1.0))
        ),
    )
}

fn behind(cases: &Cases<'_>) -> Finding {
    let [slow, fast] = ["0.01", "0.04"]
        .map(|step| ["rest", "rising"].map(|path| of(cases, Rule::Trying, path, Some(step))));
    let most = |own: &Cases<'_>| own.greatest(GLOBE_BARE_PX);
    let falls = most(&slow[0]).zip(most(&slow[1]));
    finding(
        "Gebbie & Bailey: where the eye rises fast the user will see the spiral falling behind",
        falls.map(|(rest, rising)| rising > 2.0 * rest),
        format!(
            "Bare while the height doubles each second: {} px with steps of 0.01, which at rest leave {}; {} px with steps of \
             0.04, which at rest leave {}.",
            range(&slow[1], GLOBE_BARE_PX),
            range(&slow[0], GLOBE_BARE_PX),
            range(&fast[1], GLOBE_BARE_PX),
            range(&fast[0], GLOBE_BARE_PX)
        ),
    )
}

fn courses(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let shown = cases.fitting(|case| {
        case.condition(COUNTED_BY) == "queries"
            && case.condition(DELAY) == "1"
            && (case.condition(PATH) == "rest" || case.condition(CONTROLLER) == "outer radius")
    });
    let name = |case: &Case| {
        let [path, rule, step] = [PATH, RULE, STEP].map(|key| case.condition(key));
        format!("{path}, {rule}, {step}")
    };
    drawing(
        &shown,
        "Radius over the one in closed form, frame by frame, counts used in the next frame.",
        "radius-by-frame",
        name,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::Standing;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    /// What is found of a rule's figures, by metric: at rest, and while the eye rises.
    fn standing(
        of: fn(&Cases<'_>) -> Finding,
        rule: Rule,
        figures: &[(&'static Metric, [f64; 2])],
    ) -> Standing {
        let mut run = MadeUpRun::default();
        for (which, path) in ["rest", "rising"].into_iter().enumerate() {
            let conditions = [
                ("part", PART),
                ("path", path),
                ("rule", rule.name()),
                ("step", "0.01"),
                ("delay", "2"),
            ];
            let case = run.case(case_id(crate::STUDY, path, &conditions));
            for (metric, values) in figures {
                case.figure(*metric, values[which]);
            }
        }
        of(&Cases::of_study(&run.loaded(), crate::STUDY)).standing
    }

    #[test]
    fn findings_follow_their_figures() {
        let trying = |of, metric, px| standing(of, Rule::Trying, &[(metric, px)]);
        for (of, metric, holds, does_not) in [
            (
                flicker as fn(&Cases<'_>) -> Finding,
                GLOBE_BARE_PX,
                [16.0, 0.0],
                [0.0, 9.0],
            ),
            (behind, GLOBE_BARE_PX, [16.0, 40.0], [16.0, 20.0]),
            // A disc has 1 % of the corner's distance for each frame of delay: 3.6 px.
            (disc, GLOBE_BARE_DIAGONAL_PX, [4.5, 0.0], [4.8, 0.0]),
        ] {
            assert_eq!(trying(of, metric, holds), Standing::Holds);
            assert_eq!(trying(of, metric, does_not), Standing::DoesNotHold);
        }
        let others = |value| {
            let period = [(GLOBE_CONTROLLER_PERIOD, [6.0 + value, 6.0])];
            let frames = (GLOBE_CONTROLLER_FRAMES, [9.0; 2]);
            let wrong = [(GLOBE_CONTROLLER_WRONG_FRAMES, [0.0, value]), frames];
            [
                standing(steps, Rule::Steps, &period),
                standing(exact, Rule::Steps, &wrong),
                standing(closed, Rule::Closed, &[(GLOBE_BARE_PX, [0.0, value])]),
            ]
        };
        assert_eq!(others(0.0), [Standing::Holds; 3]);
        assert_eq!(others(1.0), [Standing::DoesNotHold; 3]);
    }
}
