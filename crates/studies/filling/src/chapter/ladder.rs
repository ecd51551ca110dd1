// SPDX-License-Identifier: MIT OR Apache-2.0
//! The ladder: what each switch gives on the way from the method of 2007 to the full plan, and whether
//! what was found then is still found.
//!
//! A rung is compared with the last one before it whose picture is right. Claims are compared with the
//! measured interval; nothing here knows what came out.

use super::data::{Data, counter, distinct, name};
use terrafill_plot::number::{bytes, count, significant, times};
use terrafill_plot::{RatioAxis, Step, Steps};
use terrafill_results::{
    Block, Case, Cell, ChapterError, Claim, Estimate, Finding, Heading, Outcome, Plot, Row,
    Standing, Table,
};

/// What Cozzi (2007) found for a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PublishedFinding {
    /// The step that repeats the experiment.
    pub(super) step: &'static str,
    /// In one sentence.
    pub(super) sentence: &'static str,
    /// The same as a claim about the gain.
    pub(super) claim: Claim,
}

/// Findings in the document's own order.
pub(super) const FINDINGS: [PublishedFinding; 7] = [
    PublishedFinding {
        step: "back-faces",
        sentence: "Culling back faces in the colour pass was kept as a gain.",
        claim: Claim::Faster,
    },
    PublishedFinding {
        step: "buffer-layout",
        sentence: "How the flag was laid out in buffers made no difference.",
        claim: Claim::NoDifference,
    },
    PublishedFinding {
        step: "strips",
        sentence: "Strips instead of lists made no difference.",
        claim: Claim::NoDifference,
    },
    PublishedFinding {
        step: "cache-order",
        sentence: "Ordering triangles for the vertex cache made no difference.",
        claim: Claim::NoDifference,
    },
    PublishedFinding {
        step: "vertex-size",
        sentence: "Smaller vertices made no difference.",
        claim: Claim::NoDifference,
    },
    PublishedFinding {
        step: "bottom-cap",
        sentence: "Leaving the bottom cap out was kept as a gain.",
        claim: Claim::Faster,
    },
    PublishedFinding {
        step: "z-pass",
        sentence: "Counting fragments in front of the surface was faster than behind it.",
        claim: Claim::Faster,
    },
];

/// Where the findings come from, as printed.
pub(super) const SOURCE: &str = "Cozzi (2007)";

/// The view whose limit was fill rate.
const FILL_RATE_VIEW: &str = "horizon";

const FILL_RATE_SENTENCE: &str =
    "Along the horizon fill rate is the limit, not the number of vertices.";

/// Fragments that differ by less than this factor are the same work.
const SAME_FRAGMENTS: f64 = 1.05;

/// How many times fewer vertices a view must draw to show whether they are the limit.
const MIN_FEWER_VERTICES: f64 = 1.2;

/// Ratios of this chapter's axes.
pub(super) const AXIS_ONE: &str = "depth-pass = 1";

/// One rung as measured.
struct Rung<'a> {
    number: u32,
    step: &'a str,
    case: &'a Case,
    /// The last right rung before it.
    before: Option<&'a Case>,
    /// Time of that rung over this one's.
    gain: Option<Estimate>,
}

/// A ladder on one view.
struct Ladder<'a> {
    title: String,
    view: &'a str,
    rungs: Vec<Rung<'a>>,
}

/// Every ladder of the run.
pub(super) fn blocks(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    let ladders = ladders(data);
    if ladders.is_empty() {
        return Ok(Vec::new());
    }
    let mut blocks = vec![
        Block::section("From 2007 to the full plan"),
        Block::Text(format!(
            "One switch at a time, from the un-optimised method to the full plan. Gain = {} of the \
             last right step before ÷ this step's, paired by process; above 1 is faster. After each \
             table: what {SOURCE} found for the steps that repeat its experiments, and whether the \
             interval measured here says so still. Less than 5 % either way counts as no difference.",
            data.run.clock().name()
        )),
        Block::Table(overview(data, &ladders)),
    ];
    for ladder in &ladders {
        blocks.extend(ladder_blocks(data, ladder)?);
    }
    Ok(blocks)
}

fn ladders<'a>(data: &Data<'a>) -> Vec<Ladder<'a>> {
    let rungs = || {
        data.cases
            .iter()
            .copied()
            .filter(|case| !case.condition("rung").is_empty())
    };
    let key = |case: &'a Case| ["scene", "view", "technique"].map(|key| case.condition(key));
    let ladder = |of: [&'a str; 3]| {
        let [scene, view, technique] = of;
        Ladder {
            title: format!("{scene}, {view}: {technique}"),
            view,
            rungs: climb(data, rungs().filter(|case| key(case) == of)),
        }
    };
    distinct(rungs().map(key)).into_iter().map(ladder).collect()
}

/// Rungs by number, each with its gain.
fn climb<'a>(data: &Data<'a>, cases: impl Iterator<Item = &'a Case>) -> Vec<Rung<'a>> {
    let numbered = cases.filter_map(|case| Some((case.condition("rung").parse().ok()?, case)));
    let mut cases: Vec<(u32, &Case)> = numbered.collect();
    cases.sort_by_key(|(number, _)| *number);
    let mut before: Option<&Case> = None;
    let mut rungs = Vec::new();
    for (number, case) in cases {
        rungs.push(Rung {
            number,
            step: case.condition("step"),
            case,
            before,
            gain: before.and_then(|before| data.over(before, case)),
        });
        before = Some(case).filter(|case| case.counts()).or(before);
    }
    rungs
}

fn ladder_blocks(data: &Data<'_>, ladder: &Ladder<'_>) -> Result<Vec<Block>, ChapterError> {
    let mut blocks = vec![Block::Heading {
        level: 4,
        text: ladder.title.clone(),
    }];
    let missing = missing(&ladder.rungs);
    if !missing.is_empty() {
        blocks.push(Block::Alarm(format!(
            "Rungs without a result: {}.",
            missing.join("; ")
        )));
    }
    let sentences = sentences(data, &ladder.rungs);
    if !sentences.is_empty() {
        blocks.push(Block::Text(sentences.join(" ")));
    }
    if let Some(svg) = plot(data, ladder)? {
        blocks.push(Block::Plot(Plot {
            caption: String::new(),
            svg,
        }));
    }
    blocks.push(Block::Table(table(data, &ladder.rungs)));
    blocks.extend(findings(data, ladder).into_iter().map(Block::Finding));
    Ok(blocks)
}

fn table(data: &Data<'_>, rungs: &[Rung<'_>]) -> Table {
    let mut headings = vec![
        Heading::plain("step"),
        Heading::plain("status"),
        Heading::explained(
            "÷\u{a0}depth-pass (5\u{2060}–\u{2060}95\u{a0}%)",
            "times over the median of the full-screen depth-pass of the same view",
        ),
        Heading::explained(
            "gain over the step before [95\u{a0}%]",
            "time of the last right step before over this one's, paired by process",
        ),
    ];
    let metrics = [
        ("geometry bytes", "geometry_bytes"),
        ("draws", "draws"),
        ("vertices", "vertices"),
        ("stencil-tested fragments", "stencil_fragments"),
        ("px that differ", "mismatched_px"),
        ("outside band", "mismatched_px_outside_band"),
    ];
    headings.extend(metrics.map(|(text, metric)| Heading::metric(text, metric)));
    let rows = rungs.iter().map(|rung| {
        let case = rung.case;
        let why = match case.reason.as_str() {
            "" => case.outcome.name(),
            reason => reason,
        };
        let absent = |text: Option<String>| Cell::or_absent(text, why);
        let ratio = data
            .spread_over_depth_pass(case)
            .map(terrafill_plot::number::spread);
        let mut cells = vec![
            Cell {
                detail: name(case),
                ..Cell::name(format!(
                    "{} · {}: {}",
                    rung.number,
                    rung.step,
                    case.note("change")
                ))
            },
            Cell::plain(case.outcome.name()),
            absent(ratio),
            match &rung.gain {
                Some(gain) => Cell::plain(data.ratio_text(gain)),
                None => Cell::absent("no right step before it, or no times of both"),
            },
        ];
        cells.extend(metrics.map(|(_, metric)| {
            let print = if metric.ends_with("bytes") {
                bytes
            } else {
                count
            };
            absent(counter(case, metric).map(print))
        }));
        Row {
            cells,
            status: case.outcome.name().to_owned(),
            remark: match case.outcome {
                Outcome::Ok => String::new(),
                _ => case.reason.clone(),
            },
        }
    });
    Table {
        rows: rows.collect(),
        headings,
        ..Table::default()
    }
}

fn plot(data: &Data<'_>, ladder: &Ladder<'_>) -> Result<Option<String>, ChapterError> {
    let rows = ladder.rungs.iter().map(|rung| {
        let ratio = data.spread_over_depth_pass(rung.case);
        let gain = rung.gain.map_or_else(String::new, |gain| {
            format!(" · gain {}", significant(gain.middle))
        });
        let value = ratio.map_or_else(String::new, |ratio| {
            format!("{} ×{gain}", significant(ratio.median))
        });
        Step {
            label: format!("{} · {}", rung.number, rung.step),
            ratio: ratio.ok_or_else(|| no_ratio(data, rung.case)),
            value,
            command: data.command(rung.case),
        }
    });
    let axis = axis_title(data);
    let steps = Steps {
        title: format!("{}: time over depth-pass, step by step", ladder.title),
        axis: RatioAxis {
            title: &axis,
            one: AXIS_ONE,
        },
        rows: rows.collect(),
    };
    Ok(steps.draw()?)
}

/// What the axis of every plot of ratios says.
pub(super) fn axis_title(data: &Data<'_>) -> String {
    format!(
        "{} of the fill ÷ that of the depth-pass, median with 5–95 % of samples (logarithmic)",
        data.run.clock().name()
    )
}

/// Why a case has no ratio to the depth-pass.
pub(super) fn no_ratio(data: &Data<'_>, case: &Case) -> String {
    let why = match case.outcome {
        Outcome::Ok if data.time(case).is_none() => "no fill time",
        Outcome::Ok => "no depth-pass measured",
        outcome => outcome.name(),
    };
    why.to_owned()
}

fn findings(data: &Data<'_>, ladder: &Ladder<'_>) -> Vec<Finding> {
    let repeated = ladder.rungs.iter().filter_map(|rung| {
        let found = FINDINGS.iter().find(|finding| finding.step == rung.step)?;
        let (standing, because) = match &rung.gain {
            Some(gain) => (found.claim.standing(gain), data.ratio_text(gain)),
            None => (Standing::NotMeasured, String::new()),
        };
        Some(Finding {
            claim: format!("{SOURCE}: {}", found.sentence),
            standing,
            because,
        })
    });
    let fill_rate = (ladder.view == FILL_RATE_VIEW).then(|| fill_rate(&ladder.rungs));
    repeated.chain(fill_rate).collect()
}

/// If vertices were the limit, time would fall as they do; if fill rate is, it hardly falls. The
/// limit is drawn in the middle, for the step that leaves out most vertices and no fragments.
fn fill_rate(rungs: &[Rung<'_>]) -> Finding {
    let most = rungs
        .iter()
        .filter_map(|rung| Some((rung, fewer_vertices(rung)?, rung.gain.as_ref()?)))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    let (standing, because) = match most {
        Some((rung, fewer, gain)) if fewer >= MIN_FEWER_VERTICES => (
            Claim::LessThan(f64::midpoint(1.0, fewer)).standing(gain),
            format!(
                "at “{}” {} × fewer vertices for the same fragments give {}",
                rung.step,
                significant(fewer),
                times(gain)
            ),
        ),
        _ => (
            Standing::CannotTell,
            "no step leaves out vertices alone".to_owned(),
        ),
    };
    Finding {
        claim: format!("{SOURCE}: {FILL_RATE_SENTENCE}"),
        standing,
        because,
    }
}

/// How many times fewer vertices a rung draws for the same fragments as the one before; `None` where
/// the fragments differ or were not counted.
fn fewer_vertices(rung: &Rung<'_>) -> Option<f64> {
    let before = rung.before?;
    let ratio = |metric: &str| {
        let (before, after) = (before.value(metric)?, rung.case.value(metric)?);
        (before > 0.0 && after > 0.0).then(|| before / after)
    };
    let is_same = |ratio: f64| (1.0 / SAME_FRAGMENTS..=SAME_FRAGMENTS).contains(&ratio);
    let same_stencil = ratio("stencil_fragments").is_some_and(is_same);
    let same_colour = ratio("fragment_shader_invocations").is_some_and(is_same);
    ratio("vertices").filter(|_| same_stencil && same_colour)
}

/// Steps by what they gave, most first.
fn by_gain<'r>(rungs: &'r [Rung<'_>]) -> Vec<(&'r str, &'r Estimate)> {
    let gains = rungs
        .iter()
        .filter_map(|rung| Some((rung.step, rung.gain.as_ref()?)));
    let mut gains: Vec<(&str, &Estimate)> = gains.collect();
    gains.sort_by(|a, b| b.1.middle.total_cmp(&a.1.middle));
    gains
}

fn overview(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Table {
    let rows = ladders.iter().map(|ladder| {
        let right = || {
            ladder
                .rungs
                .iter()
                .map(|rung| rung.case)
                .filter(|case| case.counts())
        };
        let over_depth_pass = |case: Option<&Case>| {
            let ratio = case.and_then(|case| data.spread_over_depth_pass(case));
            Cell::or_absent(ratio.map(|ratio| significant(ratio.median)), "no ratio")
        };
        let (first, last) = (right().next(), right().next_back());
        let total = first
            .zip(last)
            .and_then(|(first, last)| data.over(first, last));
        let gains = by_gain(&ladder.rungs);
        let most = gains
            .first()
            .map(|(step, gain)| format!("{step}: {}", data.ratio_text(gain)));
        Row::new(vec![
            Cell::name(&ladder.title),
            over_depth_pass(first),
            over_depth_pass(last),
            data.ratio_cell(total.as_ref(), "no two right steps with times"),
            Cell::or_absent(most, "no gain was measured"),
        ])
    });
    Table {
        headings: [
            "scene, view: technique",
            "first right step ÷\u{a0}depth-pass",
            "last ÷\u{a0}depth-pass",
            "first ÷ last [95\u{a0}%]",
            "gave most",
        ]
        .map(Heading::plain)
        .into(),
        rows: rows.collect(),
        is_main: true,
        ..Table::default()
    }
}

/// What gave most, and where the ladder ends.
fn sentences(data: &Data<'_>, rungs: &[Rung<'_>]) -> Vec<String> {
    let mut sentences = Vec::new();
    let gains = by_gain(rungs);
    if let Some((step, most)) = gains.first() {
        let is_close = |second: &Estimate| match (second.interval, most.interval) {
            (Some([_, high]), Some([low, _])) => high > low,
            _ => true,
        };
        sentences.push(format!(
            "“{step}” gave most: {}{}.",
            data.ratio_text(most),
            match gains.get(1) {
                Some((second, gain)) if is_close(gain) =>
                    format!(", not clearly more than “{second}”"),
                _ => String::new(),
            }
        ));
    }
    let last_right = rungs.iter().rev().find(|rung| rung.case.counts());
    if let (Some(right), Some(last)) = (last_right, rungs.last())
        && right.number != last.number
    {
        sentences.push(format!(
            "The last step that is right is {}, “{}”.",
            right.number, right.step
        ));
    }
    sentences
}

/// Names of rungs that are not there.
fn missing(rungs: &[Rung<'_>]) -> Vec<String> {
    let mut missing = Vec::new();
    for (rung, number) in rungs.iter().zip(1_u32..) {
        if rung.number != number {
            missing.push(format!(
                "rung {number} (the ladder goes on with {}, “{}”)",
                rung.number, rung.step
            ));
            break;
        }
    }
    let absent = rungs
        .iter()
        .filter(|rung| rung.case.outcome == Outcome::Missing);
    missing.extend(
        absent.map(|rung| format!("rung {}, “{}”: {}", rung.number, rung.step, rung.case.id())),
    );
    missing
}
