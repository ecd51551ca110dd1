// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter's section on balls over terrain that are drawn.

use crate::drawing::Drawn;
use crate::finding::finding;
use crate::stepping::Way;
use crate::walk::ALLOWED_M;
use terrafill_plot::number::{significant, times};
use terrafill_results::{
    Block, Case, Cell, Claim, Clock, Estimate, Finding, Heading, Outcome, Row, Run, Standing,
    Table, ratio,
};

const FRAME_CPU: &str = "ball_frame_cpu_us";
const FRAME_WALL: &str = "ball_frame_wall_us";
const DRAW_CPU: &str = "ball_draw_cpu_us";
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
    own.filter(|case| !case.is_twin() && case.condition("part") == "drawn")
        .collect()
}

fn one<'a>(cases: &[&'a Case], way: Way, drawn: Drawn, balls: u32) -> Option<&'a Case> {
    let (interface, name) = way.names();
    let balls = balls.to_string();
    let is_it = |case: &&&Case| {
        case.condition("interface") == interface
            && case.condition("way") == name
            && case.condition("drawn") == drawn.name()
            && case.condition("balls") == balls
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
    blocks.extend(Way::ALL.map(|way| Block::Finding(each_is_slower(&cases, way, run.clock()))));
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
        let draws = |drawn| one(&cases, way, drawn, PUBLISHED_BALLS)?.value("ball_draws");
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

fn each_is_slower(cases: &[&Case], way: Way, clock: Clock) -> Finding {
    let (interface, name) = way.names();
    let slowdown = slowdown(cases, way, PUBLISHED_BALLS, clock);
    Finding {
        claim: format!(
            "{PUBLISHED_BALLS} balls stepped by {interface} {name}: a frame with one draw for all is faster than one \
             with a draw each, as the published text has it:"
        ),
        standing: slowdown.as_ref().map_or(Standing::NotMeasured, |slowdown| {
            Claim::Faster.standing(slowdown)
        }),
        because: slowdown.as_ref().map(times).unwrap_or_default(),
    }
}

fn table(cases: &[&Case]) -> Table {
    let rows = cases.iter().map(|case| {
        let why = match case.reason.as_str() {
            "" => "not measured",
            reason => reason,
        };
        let shown = |value: Option<f64>| Cell::or_absent(value.map(significant), why);
        let of_drawn = |value: Option<f64>| match case.condition("drawn") {
            "none" => Cell::absent("nothing is drawn"),
            _ => shown(value),
        };
        let balls: Option<f64> = case.condition("balls").parse().ok();
        let frame = case.value(FRAME_CPU).filter(|_| case.counts());
        let each_ns = frame.zip(balls).map(|(us, balls)| 1e3 * us / balls);
        Row {
            cells: vec![
                Cell::name(format!(
                    "{} {}",
                    case.condition("interface"),
                    case.condition("way")
                )),
                Cell::name(case.condition("drawn")),
                Cell::name(case.condition("balls")),
                shown(frame),
                shown(each_ns),
                of_drawn(case.value(DRAW_CPU)),
                of_drawn(case.value("ball_draw_gpu_us")),
                shown(case.value("ball_draws")),
                shown(case.value("ball_upload_bytes")),
                shown(case.value("ball_terrain_step_m")),
                shown(case.value("ball_terrain_guided_m")),
                shown(case.value("ball_terrain_p95_m")),
                shown(case.value("ball_terrain_max_m")),
                of_drawn(case.value("ball_mismatched_px")),
            ],
            status: case.outcome.name().to_owned(),
            remark: case.reason.clone(),
        }
    });
    let measured = |text: &str, metric: &str| Heading::metric(text, metric);
    Table {
        caption: "Balls over terrain, by way, draws and number of balls".to_owned(),
        headings: vec![
            Heading::plain("way"),
            Heading::plain("drawn"),
            Heading::plain("balls"),
            measured("CPU µs a frame", FRAME_CPU),
            Heading::plain("CPU ns a frame and ball"),
            measured("CPU µs of the draws", DRAW_CPU),
            measured("GPU µs of the draws", "ball_draw_gpu_us"),
            measured("draws", "ball_draws"),
            measured("uploaded, B", "ball_upload_bytes"),
            measured("a step's error, m", "ball_terrain_step_m"),
            measured(
                "largest error in the same cells, m",
                "ball_terrain_guided_m",
            ),
            measured("95 % within, m", "ball_terrain_p95_m"),
            measured("largest error, m", "ball_terrain_max_m"),
            measured("wrong pixels", "ball_mismatched_px"),
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
    let pixels = [most("ball_mismatched_px"), most("ball_differing_px")];
    let sent = most("ball_upload_bytes");
    let (step, guided) = (most("ball_terrain_step_m"), most("ball_terrain_guided_m"));
    let (beyond, unexplained) = (
        most("ball_terrain_beyond"),
        most("ball_terrain_unexplained"),
    );
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
            beyond.zip(most("ball_terrain_max_m")).map_or_else(String::new, |(beyond, far)| {
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
