// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter's section on balls over terrain that are drawn.

use crate::drawing::Drawn;
use crate::finding::finding;
use crate::keys::{
    BALL_DIFFERING_PX, BALL_DRAW_GPU_US, BALL_DRAWS, BALL_MISMATCHED_PX, BALL_TERRAIN_BEYOND,
    BALL_TERRAIN_GUIDED_M, BALL_TERRAIN_MAX_M, BALL_TERRAIN_P95_M, BALL_TERRAIN_STEP_M,
    BALL_TERRAIN_UNEXPLAINED, BALL_UPLOAD_BYTES, BALLS, DRAWN, INTERFACE, PART, WAY,
};
use crate::metrics::METRICS;
use crate::stepping::Way;
use crate::walk::ALLOWED_M;
use terrafill_lab::Comparison;
use terrafill_plot::dotted;
use terrafill_plot::number::{significant, times};
use terrafill_results::{
    Block, Case, Cell, Claim, Clock, Estimate, Finding, Heading, Metric, Noise, Outcome, Row, Run,
    Scope, Table, ratio,
};

const FRAME_CPU: &Metric = Metric::of(&METRICS, "ball_frame_cpu_us");
const FRAME_WALL: &Metric = Metric::of(&METRICS, "ball_frame_wall_us");
const DRAW_CPU: &Metric = Metric::of(&METRICS, "ball_draw_cpu_us");
/// The one number that was published with balls.
const PUBLISHED_BALLS: u32 = 4_000;
const WHAT_IS_COMPARED: &str = "Balls fall from 0.1 to 0.3 m onto bilinear terrain of 64 × 64 m, whose spring of k/m = 1e3 1/s² pushes along the \
     normal, and are drawn as points from the buffer that the step wrote: not at all, by one draw for all, or \
     by a draw each. A frame is one step and its draws. Each step is held against the same integrator in f64, \
     pictures against the places that the device has. Slopes jump from cell to cell: a ball that touches the \
     ground within rounding of a border may be pushed from either side and ends elsewhere. So its end is \
     compared with f64 that takes the device's cell there.";
const WHAT_FIGURE_12_CANNOT_SHOW: &str = "Published is a figure of seconds a step up to 5,000 balls, and one number: 4,000 balls at 21 frames per second, \
     11.9 µs a ball. It does not separate physics from drawing, and the published text draws one point by a call. \
     Beside it stands here how many times as long a frame takes by a draw each.";

fn cases(run: &Run) -> Vec<&Case> {
    let own = run.of_study(crate::STUDY);
    own.filter(|case| !case.is_twin() && case.condition(PART) == "drawn")
        .collect()
}

fn one<'a>(cases: &[&'a Case], way: Way, drawn: Drawn, balls: u32) -> Option<&'a Case> {
    let (interface, name) = way.names();
    let balls = balls.to_string();
    let is_it = |case: &&&Case| {
        case.condition(INTERFACE) == interface
            && case.condition(WAY) == name
            && case.condition(DRAWN) == drawn.name()
            && case.condition(BALLS) == balls
    };
    cases.iter().find(is_it).copied()
}

/// The section; nothing where no case was planned.
pub(crate) fn blocks(run: &Run) -> Vec<Block> {
    let cases = cases(run);
    if cases.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![
        Block::section("Balls over terrain, drawn"),
        Block::Text(WHAT_IS_COMPARED.to_owned()),
    ];
    for way in Way::ALL {
        blocks.push(Block::Finding(each_is_slower(run, &cases, way)));
    }
    blocks.push(Block::Table(table(&cases)));
    blocks.push(Block::Remark(WHAT_FIGURE_12_CANNOT_SHOW.to_owned()));
    blocks
}

/// Frame of a draw each over that of one draw.
///
/// A GPU's clock does not cover the calls of a frame, so on hardware it is the wall clock.
fn slowdown(cases: &[&Case], way: Way, balls: u32, clock: Clock) -> Option<Estimate> {
    let of = |drawn| one(cases, way, drawn, balls).filter(|case| case.counts());
    ratio(
        of(Drawn::Each)?,
        of(Drawn::All)?,
        clock.pick(FRAME_WALL, FRAME_CPU),
    )
}

/// How to draw balls, by the number that was published.
pub(crate) fn recommended(run: &Run) -> Vec<String> {
    let cases = cases(run);
    let of_way = |way: Way| {
        let (interface, name) = way.names();
        let slowdown = slowdown(&cases, way, PUBLISHED_BALLS, run.clock())?;
        let draws = |drawn| one(&cases, way, drawn, PUBLISHED_BALLS)?.value(BALL_DRAWS);
        let (each, all) = (draws(Drawn::Each)?, draws(Drawn::All)?);
        let how = match slowdown.middle > 1.0 {
            true => "by one draw for all",
            false => "by a draw each",
        };
        Some(format!(
            "{PUBLISHED_BALLS} balls stepped by {interface} {name} are best drawn {how}: {each} draws take {} times a \
             frame with {all}.",
            times(&slowdown)
        ))
    };
    Way::ALL.into_iter().filter_map(of_way).collect()
}

fn each_is_slower(run: &Run, cases: &[&Case], way: Way) -> Finding {
    let (interface, name) = way.names();
    let of = |drawn| one(cases, way, drawn, PUBLISHED_BALLS);
    let pair = of(Drawn::Each).zip(of(Drawn::All)).map(<[&Case; 2]>::from);
    let comparison = Comparison {
        changed: DRAWN.name(),
        follows: &[],
        one_sided: None,
        metric: run.clock().pick(FRAME_WALL, FRAME_CPU),
        needs: Scope::DISPATCH.and(Scope::DRAW),
    };
    let noise = Noise::of(
        run.of_study(crate::STUDY).collect::<Vec<_>>().into_iter(),
        comparison.metric,
    );
    let claim = format!(
        "{PUBLISHED_BALLS} balls stepped by {interface} {name}: a frame with one draw for all is faster than one with \
         a draw each, as the published text has it:"
    );
    comparison.finding(run, pair.as_slice(), Claim::Faster, claim, noise)
}

fn table(cases: &[&Case]) -> Table {
    let rows = cases.iter().map(|case| {
        let why = match case.reason.as_str() {
            "" => "not measured",
            reason => reason,
        };
        let shown = |value: Option<f64>| Cell::or_absent(value.map(significant), why);
        let of_drawn = |value: Option<f64>| match case.condition(DRAWN) {
            "none" => Cell::absent("nothing is drawn"),
            _ => shown(value),
        };
        let drawn_in = |metric| dotted(of_drawn(case.value(metric)), case, metric);
        let balls: Option<f64> = case.condition(BALLS).parse().ok();
        let frame = case.value(FRAME_CPU).filter(|_| case.counts());
        let each_ns = frame.zip(balls).map(|(us, balls)| 1e3 * us / balls);
        Row {
            cells: vec![
                Cell::name(format!(
                    "{} {}",
                    case.condition(INTERFACE),
                    case.condition(WAY)
                )),
                Cell::name(case.condition(DRAWN)),
                Cell::name(case.condition(BALLS)),
                dotted(shown(frame), case, FRAME_CPU),
                shown(each_ns),
                drawn_in(DRAW_CPU),
                drawn_in(BALL_DRAW_GPU_US),
                shown(case.value(BALL_DRAWS)),
                shown(case.value(BALL_UPLOAD_BYTES)),
                shown(case.value(BALL_TERRAIN_STEP_M)),
                shown(case.value(BALL_TERRAIN_GUIDED_M)),
                shown(case.value(BALL_TERRAIN_P95_M)),
                shown(case.value(BALL_TERRAIN_MAX_M)),
                of_drawn(case.value(BALL_MISMATCHED_PX)),
            ],
            status: case.outcome.name().to_owned(),
            remark: case.reason.clone(),
        }
    });
    let measured = |text: &str, metric: &Metric| Heading::metric(text, metric);
    Table {
        caption: "Balls over terrain, by way, draws and number of balls".to_owned(),
        headings: vec![
            Heading::plain("way"),
            Heading::plain("drawn"),
            Heading::plain("balls"),
            measured("CPU µs a frame", FRAME_CPU),
            Heading::plain("CPU ns a frame and ball"),
            measured("CPU µs of the draws", DRAW_CPU),
            measured("GPU µs of the draws", BALL_DRAW_GPU_US),
            measured("draws", BALL_DRAWS),
            measured("uploaded, B", BALL_UPLOAD_BYTES),
            measured("a step's error, m", BALL_TERRAIN_STEP_M),
            measured("largest error in the same cells, m", BALL_TERRAIN_GUIDED_M),
            measured("95 % within, m", BALL_TERRAIN_P95_M),
            measured("largest error, m", BALL_TERRAIN_MAX_M),
            measured("wrong pixels", BALL_MISMATCHED_PX),
        ],
        rows: rows.collect(),
        ..Table::default()
    }
}

pub(crate) fn findings(run: &Run) -> Vec<Finding> {
    let cases = cases(run);
    if cases.is_empty() {
        return Vec::new();
    }
    let judged = |case: &&&Case| case.counts() || case.outcome == Outcome::Wrong;
    let most = |metric| {
        let values = cases
            .iter()
            .filter(judged)
            .filter_map(|case| case.value(metric));
        values.max_by(f64::total_cmp)
    };
    let wrong = cases
        .iter()
        .filter(|case| case.outcome == Outcome::Wrong)
        .count();
    let pixels = [most(BALL_MISMATCHED_PX), most(BALL_DIFFERING_PX)];
    let sent = most(BALL_UPLOAD_BYTES);
    let (step, guided) = (most(BALL_TERRAIN_STEP_M), most(BALL_TERRAIN_GUIDED_M));
    let (beyond, unexplained) = (most(BALL_TERRAIN_BEYOND), most(BALL_TERRAIN_UNEXPLAINED));
    vec![
        finding(
            "Every step of a ball over terrain is that of f64 from the same state, to the last places".to_owned(),
            step.map(|_| wrong == 0),
            step.map_or_else(String::new, |far| format!("at most {} m apart", significant(far))),
        ),
        finding(
            "Balls over terrain are within 1 mm of f64 that takes the device's cell at borders".to_owned(),
            guided.map(|guided| guided <= ALLOWED_M),
            guided.map_or_else(String::new, |far| format!("at most {} m", significant(far))),
        ),
        finding(
            "Balls farther from f64 of its own have all touched ground in another cell".to_owned(),
            unexplained.map(|unexplained| unexplained <= 0.0),
            beyond.zip(most(BALL_TERRAIN_MAX_M)).map_or_else(String::new, |(beyond, far)| {
                format!("at most {beyond} such balls in a case, up to {} m", significant(far))
            }),
        ),
        finding(
            "One draw for all and a draw each show the same balls, those of the reference"
                .to_owned(),
            pixels[0].zip(pixels[1]).map(|(a, b)| a + b <= 0.0),
            pixels[0].map_or_else(String::new, |most| format!("at most {most} wrong pixels")),
        ),
        finding(
            "The CPU uploads nothing while balls over terrain step and are drawn".to_owned(),
            sent.map(|sent| sent <= 0.0),
            sent.map_or_else(String::new, |sent| format!("at most {sent} B")),
        ),
    ]
}
