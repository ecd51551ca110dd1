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
    text: "From 100 km straight down, fan and turns are drawn by ranges of one static buffer. Their pixels are counted \
           apart: by precise occlusion queries on Vulkan, by a histogram on wgpu. Counts of frame k decide on \
           frame k + delay; the page of arithmetic counts a delay from the frame after, so that its 0 is 1 here. The \
           fan begins with half its 1,257 pixels, the outer radius 20 % beyond the corners; the other radius is in \
           closed form. A rising eye doubles its height each second of 60 frames. All counts are held against rays in \
           f64. That trying flickers follows from its rule: it takes steps until pixels are bare. A frame is timed with its \
           decision and with its counts read at once.",
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
        Column::metric("grows a frame", GLOBE_FAN_GROWTH_LEAST).or_of(why_no_growth),
        Column::metric("cut off at frame", GLOBE_FAN_CUT_FRAME).or_of(why_not_cut),
        Column::metric("bare px", GLOBE_BARE_PX).or("the outer radius is in closed form"),
        Column::metric("share of frames", GLOBE_BARE_SHARE)
            .or("the outer radius is in closed form"),
        Column::metric("last third over middle", GLOBE_BARE_GROWTH)
            .or("of an outer radius that is tried while the eye rises"),
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

fn why_no_growth(case: &Case) -> &'static str {
    match (case.condition(CONTROLLER), case.condition(PATH)) {
        ("fan", "rest") => "the fan is cut off within three frames",
        ("fan", _) => "the eye moves",
        _ => "the fan is in closed form",
    }
}

fn why_not_cut(case: &Case) -> &'static str {
    match (case.condition(CONTROLLER), case.condition(PATH)) {
        ("fan", "rest") => "nothing cuts it off",
        ("fan", _) => "the eye moves",
        _ => "the fan is in closed form",
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

/// Whether all cases that were run have such a period; `None` without one. A loop that never repeats has none.
fn repeat(cases: &Cases<'_>, is: impl Fn(&Case, Option<f64>) -> bool) -> Option<bool> {
    let run: Vec<&Case> = cases.iter().filter(|case| case.counts()).collect();
    let mut repeat = run
        .iter()
        .map(|case| is(case, case.value(GLOBE_CONTROLLER_PERIOD)));
    (!run.is_empty()).then(|| repeat.all(|is| is))
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
        repeat(&rest, |case, period| {
            period == Some(4.0 * number(case, DELAY) - 2.0)
        }),
        format!(
            "{}. While the eye rises the radius is off by {} %: a constant step falls behind a wanted radius that doubles.",
            periods.join("; "),
            range(&rising, GLOBE_CONTROLLER_OFF)
        ),
    )
}

fn gains(cases: &Cases<'_>) -> Finding {
    let [calm, wild] = ["0.25", "1.2"].map(|step| of(cases, Rule::Logarithmic, "rest", Some(step)));
    // With counts of the last frame each step jumps past by more than it was off; with older ones the delay does it.
    let next = wild.fitting(|case| case.condition(DELAY) == "1");
    let rests = repeat(&calm, |_, period| period == Some(1.0));
    let grows = all(&next, GLOBE_FAN_GROWTH_LEAST, |_, growth| growth > 1.0);
    finding(
        "Logarithmic steps come to rest with a quarter of the limit's gain, and explode exponentially with 1.2 of it",
        rests.zip(grows).map(|(rests, grows)| rests && grows),
        format!(
            "A quarter: at rest after {} frames, {} % off the wanted pixels, since less than half a stored vertex moves nothing. \
             1.2 with a delay of 1: the error grows at least {} times each frame until frame {}, where the picture cuts the fan \
             off. Over all delays it is {} times as far off at last as it began.",
            range(&calm, GLOBE_CONTROLLER_REST_FRAMES),
            range(&calm, GLOBE_FAN_OFF),
            range(&next, GLOBE_FAN_GROWTH_LEAST),
            range(&next, GLOBE_FAN_CUT_FRAME),
            range(&wild, GLOBE_FAN_GROWTH)
        ),
    )
}

fn flicker(cases: &Cases<'_>) -> Finding {
    let rest = of(cases, Rule::Trying, "rest", None);
    let words = rest.by(STEP).into_iter().map(|(step, own)| {
        let [px, diagonal] = [GLOBE_BARE_PX, GLOBE_BARE_DIAGONAL_PX].map(|of| range(&own, of));
        let share = range(&own, GLOBE_BARE_SHARE);
        format!("steps of {step}: {px} px in {share} of the frames, up to {diagonal} px along the diagonal")
    });
    let words: Vec<String> = words.collect();
    finding(
        "Gebbie & Bailey: trying the outer radius causes a flicker in the corners",
        all(&rest, GLOBE_BARE_SHARE, |_, share| {
            share > 0.0 && share < 1.0
        }),
        format!(
            "Bare and covered in turn, over all delays: {}. It follows from the rule.",
            words.join("; ")
        ),
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
            "Pixels along the diagonal, {}. A spiral's rim is no circle: it steps by {} % where its last turn ends. That step \
             moves round with the range's end, and so does the corner that goes bare first.",
            words.join("; "),
            significant(100.0 * (radii(PER_TURN, 0) - 1.0))
        ),
    )
}

/// Bare pixels of a rise have to grow so many times from its middle third to its last.
const FALLS_BEHIND: f64 = 2.0;

fn behind(cases: &Cases<'_>) -> Finding {
    let slow = of(cases, Rule::Trying, "rising", Some("0.01"));
    let fast = of(cases, Rule::Trying, "rising", Some("0.04"));
    let covered = of(cases, Rule::Closed, "rising", None);
    // The same eye with the same counts, whose radius is in closed form.
    let closed = |case: &Case| {
        let mut own = covered.iter();
        let own = own.find(|other| other.condition(COUNTED_BY) == case.condition(COUNTED_BY))?;
        own.value(GLOBE_BARE_PX)
    };
    let falls = |case: &Case, growth| growth >= FALLS_BEHIND && closed(case) == Some(0.0);
    let by_delay = |own: &Cases<'_>| {
        let words = own.by(DELAY).into_iter().map(|(delay, own)| {
            let [growth, px] = [GLOBE_BARE_GROWTH, GLOBE_BARE_PX].map(|of| range(&own, of));
            format!("delay {delay}: {growth} times, to {px} px")
        });
        words.collect::<Vec<_>>().join(", ")
    };
    finding(
        "Gebbie & Bailey: where the eye rises fast the user will see the spiral falling behind",
        all(&slow, GLOBE_BARE_GROWTH, falls),
        format!(
            "While the height doubles each second, bare pixels grow from the rise's middle third to its last. Steps of 0.01: {}. \
             Steps of 0.04, which are faster than the eye and hover: {}. In closed form {} px are bare.",
            by_delay(&slow),
            by_delay(&fast),
            range(&covered, GLOBE_BARE_PX)
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

    /// A case by path, rule, step and delay, with its figures.
    type MadeUp<'a> = ([&'a str; 2], [&'a str; 2], &'a [(&'static Metric, f64)]);

    fn standing(of: fn(&Cases<'_>) -> Finding, cases: &[MadeUp<'_>]) -> Standing {
        let mut run = MadeUpRun::default();
        for ([path, rule], [step, delay], figures) in cases {
            let conditions = [
                ("part", PART),
                ("path", path),
                ("rule", rule),
                ("step", step),
                ("delay", delay),
                ("counted_by", "queries"),
            ];
            let name = format!("{path}/{rule}/{step}/{delay}");
            let case = run.case(case_id(crate::STUDY, &name, &conditions));
            for (metric, value) in *figures {
                case.figure(*metric, *value);
            }
        }
        of(&Cases::of_study(&run.loaded(), crate::STUDY)).standing
    }

    #[test]
    fn findings_follow_their_figures() {
        let one = |of, rule: Rule, path, figures: &[(&'static Metric, f64)]| {
            standing(of, &[([path, rule.name()], ["0.01", "2"], figures)])
        };
        let of_rest = |of, rule, metric, values: [f64; 2]| {
            values.map(|value| one(of, rule, "rest", &[(metric, value)]))
        };
        let two = [Standing::Holds, Standing::DoesNotHold];
        // A disc has 1 % of the corner's distance for each frame of delay: 3.6 px.
        let px = GLOBE_BARE_DIAGONAL_PX;
        assert_eq!(of_rest(disc, Rule::Trying, px, [4.5, 4.8]), two);
        // Bare and covered in turn; always bare is no flicker, and neither is never.
        for steady in [0.0, 1.0] {
            let share = [0.4, steady];
            assert_eq!(of_rest(flicker, Rule::Trying, GLOBE_BARE_SHARE, share), two);
        }
        let period = GLOBE_CONTROLLER_PERIOD;
        assert_eq!(of_rest(steps, Rule::Steps, period, [6.0, 7.0]), two);
        assert_eq!(
            of_rest(closed, Rule::Closed, GLOBE_BARE_PX, [0.0, 1.0]),
            two
        );
        let exact = [0.0, 1.0].map(|wrong| {
            let figures = [
                (GLOBE_CONTROLLER_FRAMES, 9.0),
                (GLOBE_CONTROLLER_WRONG_FRAMES, wrong),
            ];
            one(exact, Rule::Steps, "rest", &figures)
        });
        assert_eq!(exact, two);
    }

    #[test]
    fn a_loop_that_never_repeats_does_not_rest() {
        let [rests, swings] = [
            (GLOBE_CONTROLLER_PERIOD, 1.0),
            (GLOBE_CONTROLLER_PERIOD, 6.0),
        ];
        let of_steps = |second: &[(&'static Metric, f64)]| {
            let rule = ["rest", Rule::Steps.name()];
            let first: MadeUp<'_> = (rule, ["0.02", "2"], &[swings]);
            standing(steps, &[first, (rule, ["0.03", "2"], second)])
        };
        assert_eq!(of_steps(&[swings]), Standing::Holds);
        // Negative control: a second case without a period.
        assert_eq!(of_steps(&[]), Standing::DoesNotHold);
        let of_gains = |calm: &[(&'static Metric, f64)], growth: f64| {
            let rule = ["rest", Rule::Logarithmic.name()];
            let cases: [MadeUp<'_>; 4] = [
                (rule, ["0.25", "1"], &[rests]),
                (rule, ["0.25", "3"], calm),
                (rule, ["1.2", "1"], &[(GLOBE_FAN_GROWTH_LEAST, growth)]),
                (rule, ["1.2", "3"], &[(GLOBE_FAN_GROWTH_LEAST, 0.5)]),
            ];
            standing(gains, &cases)
        };
        assert_eq!(of_gains(&[rests], 1.4), Standing::Holds);
        // Negative controls: one that does not repeat, and one whose error shrinks in a frame.
        assert_eq!(of_gains(&[], 1.4), Standing::DoesNotHold);
        assert_eq!(of_gains(&[rests], 0.9), Standing::DoesNotHold);
    }

    #[test]
    fn what_hovers_does_not_fall_behind() {
        let found = |growth: f64, closed: f64| {
            let rule = ["rising", Rule::Trying.name()];
            let other = ["rising", Rule::Closed.name()];
            let cases: [MadeUp<'_>; 3] = [
                (rule, ["0.01", "2"], &[(GLOBE_BARE_GROWTH, growth)]),
                (rule, ["0.04", "2"], &[(GLOBE_BARE_GROWTH, 1.0)]),
                (other, ["", ""], &[(GLOBE_BARE_PX, closed)]),
            ];
            standing(behind, &cases)
        };
        assert_eq!(found(3.0, 0.0), Standing::Holds);
        // Negative controls: one that hovers, and corners that closed form leaves bare as well.
        assert_eq!(found(1.1, 0.0), Standing::DoesNotHold);
        assert_eq!(found(3.0, 9.0), Standing::DoesNotHold);
    }
}
