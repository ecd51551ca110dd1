// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sections and tables as data: what each column shows of a case, and why a case that is right may lack it.

use super::data::{
    DEPTH_PASS, Data, counter, is_approximate, is_baseline, is_rival, name, standing,
};
use super::rungs::Rung;
use crate::keys::*;
use crate::metrics::METRICS;
use terrafill_plot::number::{bytes, count, significant, spread};
use terrafill_plot::{RatioAxis, Step, Steps, dotted};
use terrafill_results::{
    Block, Case, Cell, CellClass, ChapterError, Heading, Metric, Outcome, Plot, Row, Table,
    sample_spread,
};

/// What a column shows.
#[derive(Clone, Copy)]
pub(super) enum Show {
    /// The next of the cells that the row brings along; what the heading means.
    Own(&'static str),
    /// How the case ended.
    Status,
    /// Its time by the run's clock, over all samples.
    Times,
    /// The median of that.
    Median,
    /// The median of the fill's time by the other clock.
    OtherClock,
    /// Another time, to three digits.
    Time(&'static Metric),
    /// Three digits.
    Figure(&'static Metric),
    /// Every digit.
    Count(&'static Metric),
    /// Bytes, short.
    Bytes(&'static Metric),
    /// Time over that of a full-screen pass, paired by process.
    Over(&'static str),
    /// Times over the median of the depth-pass.
    Ratios,
}

/// Heading, in which `{unit}` is that of the run's clock and `{other}` that of the other one, and what is shown.
pub(super) type Column = (&'static str, Show);

pub(super) const NOT_COMPARED: &str = "not compared with the reference";
pub(super) const NOT_RECORDED: &str = "not recorded by this run";
pub(super) const NOT_TIMED: &str = "no frame was timed";
pub(super) const NO_TEXELS: &str = "a plain fill has no texels";

/// Why a case that is right may lack a figure, where it is not [`NOT_RECORDED`].
const MAY_LACK: [(&str, &[&Metric]); 9] = [
    (NOT_COMPARED, &[MISMATCHED_PX, MISMATCHED_PX_OUTSIDE_BAND]),
    (
        "not counted by this technique",
        &[
            SURFACE_BYTES,
            GEOMETRY_BYTES,
            TARGET_BYTES,
            TEXTURE_BYTES,
            DRAWS,
            VERTICES,
            STENCIL_FRAGMENTS,
        ],
    ),
    (
        "one of the two pictures has no boundary, or they were not compared",
        &[HAUSDORFF_PX],
    ),
    (
        "only levels of detail move boundaries on purpose; or too many pixels mismatch to compare",
        &[BOUNDARY_MOVED_PX],
    ),
    (
        "the surface does not say where the ground truly is, or they were not compared",
        &[MOVED_PX_TRUE],
    ),
    (
        "the technique draws a surface of its own, untimed, or the device gave no GPU time",
        &[SURFACE_GPU_MS],
    ),
    (
        "no GPU time of its own: stencil and colour alternate region by region, or the device gave none",
        &[STENCIL_GPU_MS, COLOUR_GPU_MS],
    ),
    ("the device gave no GPU time", &[FILL_GPU_MS]),
    (
        NO_TEXELS,
        &[TEXEL_RMS, TEXEL_MAX, TEXEL_NON_FINITE, TEXEL_COMPARED_PX],
    ),
];

fn why_absent(metric: &Metric) -> &'static str {
    let mut known = MAY_LACK.iter();
    let known = known.find(|(_, metrics)| metrics.iter().any(|own| **own == *metric));
    known.map_or(NOT_RECORDED, |(why, _)| why)
}

/// A row for each case, with the cells of [`Show::Own`] in their order.
pub(super) fn table<'a>(
    data: &Data<'_>,
    columns: &[Column],
    rows: impl IntoIterator<Item = (&'a Case, Vec<Cell>)>,
) -> Table {
    let row = |(case, own): (&Case, Vec<Cell>)| {
        let mut own = own.into_iter();
        let cells = columns.iter().map(|column| match column.1 {
            Show::Own(_) => own.next().unwrap_or_default(),
            show => cell(data, case, show),
        });
        Row {
            cells: cells.collect(),
            status: standing(case).to_owned(),
            remark: match case.outcome {
                Outcome::Ok => String::new(),
                _ => case.reason.clone(),
            },
        }
    };
    Table {
        headings: columns.iter().map(|column| heading(data, column)).collect(),
        rows: rows.into_iter().map(row).collect(),
        ..Table::default()
    }
}

fn heading(data: &Data<'_>, (text, show): &Column) -> Heading {
    let other = data.run.clock().pick("CPU\u{a0}ms", "GPU\u{a0}ms");
    let text = text.replace("{unit}", data.unit());
    let text = text.replace("{other}", other);
    match show {
        Show::Own("") | Show::Status => Heading::plain(text),
        Show::Own(meaning) => Heading::explained(text, *meaning),
        Show::Times | Show::Median => Heading::metric(text, data.metric),
        Show::OtherClock => Heading::metric(text, other_clock(data)),
        Show::Time(metric) | Show::Figure(metric) | Show::Count(metric) | Show::Bytes(metric) => {
            Heading::metric(text, *metric)
        }
        Show::Over(DEPTH_PASS) => Heading::explained(
            text,
            "over the full-screen pass that reads depth, paired by process",
        ),
        Show::Over(_) => Heading::explained(
            text,
            "over the full-screen pass that clears and tests the stencil, paired by process",
        ),
        Show::Ratios => Heading::explained(
            text,
            "times over the median of the full-screen depth-pass of the same view",
        ),
    }
}

/// A cell of a case.
fn cell(data: &Data<'_>, case: &Case, show: Show) -> Cell {
    let figure = |text: Option<String>, why: &str| match text {
        Some(text) => Cell::plain(text),
        None => absent(case, why),
    };
    let counted = |metric: &Metric, print: fn(u64) -> String| {
        figure(counter(case, metric).map(print), why_absent(metric))
    };
    let timed = |metric, ms: Option<String>, why| dotted(time_cell(case, ms, why), case, metric);
    let pass = "this pass was not measured in this run";
    match show {
        Show::Own(_) => Cell::default(),
        Show::Status => Cell::plain(standing(case)),
        Show::Times => timed(data.metric, data.time(case).map(spread), NOT_TIMED),
        Show::Median => {
            let ms = data.time(case).map(|ms| significant(ms.median));
            timed(data.metric, ms, NOT_TIMED)
        }
        Show::OtherClock => {
            let metric = other_clock(data);
            let ms = sample_spread(case, metric).map(|ms| significant(ms.median));
            timed(metric, ms, why_absent(FILL_GPU_MS))
        }
        Show::Time(metric) => {
            let ms = case.value(metric).map(significant);
            timed(metric, ms, why_absent(metric))
        }
        Show::Figure(metric) => figure(case.value(metric).map(significant), why_absent(metric)),
        Show::Count(metric) => counted(metric, count),
        Show::Bytes(metric) => counted(metric, bytes),
        Show::Over(technique) => {
            let ratio = data.over_baseline(case, technique);
            figure(ratio.map(|ratio| significant(ratio.middle)), pass)
        }
        Show::Ratios => figure(data.spread_over_depth_pass(case).map(spread), pass),
    }
}

fn other_clock(data: &Data<'_>) -> &'static Metric {
    data.run.clock().pick(FILL_CPU_MS, FILL_GPU_MS)
}

/// A time, which counts for nothing when the picture is wrong.
fn time_cell(case: &Case, text: Option<String>, why: &str) -> Cell {
    match text {
        Some(text) if is_approximate(case) => Cell {
            title: "approximate: its picture differs by nature, and it competes with none"
                .to_owned(),
            ..Cell::plain(text)
        },
        // An error that is part of the answer is shown next to the time.
        Some(text) if case.outcome == Outcome::Wrong && !is_rival(case) => Cell {
            class: CellClass::Void,
            title: "the picture is wrong: this time counts for nothing".to_owned(),
            ..Cell::plain(text)
        },
        Some(text) => Cell::plain(text),
        None => absent(case, why),
    }
}

fn absent(case: &Case, why: &str) -> Cell {
    Cell::absent(match (case.outcome, case.reason.as_str()) {
        (Outcome::Ok, _) if is_baseline(case) => "does not apply to a full-screen pass".to_owned(),
        (Outcome::Ok, _) => why.to_owned(),
        (outcome, "") => format!("{}, no reason was recorded", outcome.name()),
        (outcome, reason) => format!("{}: {reason}", outcome.name()),
    })
}

/// A table whose rows are no cases: headings, each with its meaning or the name of the metric that has it.
pub(crate) fn figures(headings: &[(&str, &str)], rows: Vec<Row>) -> Table {
    let heading =
        |(text, meaning): &(&str, &str)| match METRICS.iter().any(|metric| metric.name == *meaning)
        {
            true => Heading::metric(*text, *meaning),
            false => Heading::explained(*text, *meaning),
        };
    Table {
        headings: headings.iter().map(heading).collect(),
        rows,
        ..Table::default()
    }
}

/// A row that begins with a name.
pub(crate) fn row(name: Cell, cells: impl IntoIterator<Item = Cell>) -> Row {
    Row::new([name].into_iter().chain(cells).collect())
}

/// A section of one table, among those that `summary.md` repeats; nothing where it has no row.
pub(super) fn section(title: &str, text: impl Into<String>, table: Table) -> Vec<Block> {
    if table.rows.is_empty() {
        return Vec::new();
    }
    let table = Table {
        is_main: true,
        ..table
    };
    let mut blocks = head(title, text);
    blocks.push(Block::Table(table));
    blocks
}

/// A section's heading and what is said below it.
pub(super) fn head(title: &str, text: impl Into<String>) -> Vec<Block> {
    vec![Block::section(title), Block::Text(text.into())]
}

/// Heading of a part of a section.
pub(super) fn part(text: String) -> Block {
    Block::Heading { level: 4, text }
}

/// A plot, if one was drawn.
pub(super) fn plot(caption: impl Into<String>, svg: Option<String>) -> Option<Block> {
    let caption = caption.into();
    svg.map(|svg| Block::Plot(Plot { caption, svg }))
}

/// What the steps of a ladder take over the depth-pass, from the first to the last.
///
/// - `value`: what is printed behind the ratio
pub(super) fn steps_plot(
    data: &Data<'_>,
    title: String,
    rungs: &[Rung<'_>],
    value: impl Fn(&Rung<'_>) -> String,
) -> Result<Option<Block>, ChapterError> {
    let rows = rungs.iter().map(|rung| {
        let ratio = data.spread_over_depth_pass(rung.case);
        Step {
            label: format!("{} · {}", rung.number, rung.step),
            begins: ratio.and_then(|ratio| Some(ratio.median * rung.gain?.middle)),
            is_kept: rung.is_kept(),
            value: ratio.map_or_else(String::new, |ratio| {
                format!("{} ×{}", significant(ratio.median), value(rung))
            }),
            ratio: ratio.ok_or_else(|| no_ratio(data, rung.case)),
            command: data.command(rung.case),
        }
    });
    let axis = format!(
        "{} of the fill ÷ that of the depth-pass, median with 5–95 % of samples (logarithmic)",
        data.run.clock().name()
    );
    let steps = Steps {
        title,
        axis: RatioAxis {
            title: &axis,
            one: "depth-pass = 1",
        },
        rows: rows.collect(),
    };
    Ok(plot("", steps.draw()?))
}

/// A step with its change in words, and what it gained; the latter two of a row of a ladder.
pub(super) fn step_cells(data: &Data<'_>, rung: &Rung<'_>) -> [Cell; 2] {
    let aside = if rung.is_aside { "aside, " } else { "" };
    let step = Cell {
        detail: name(rung.case),
        ..Cell::name(format!(
            "{} · {aside}{}: {}",
            rung.number, rung.step, rung.change
        ))
    };
    let why = "no kept step before it, or no times of both";
    [step, data.ratio_cell(rung.gain.as_ref(), why)]
}

/// Why a case has no ratio to another's time.
pub(super) fn no_ratio(data: &Data<'_>, case: &Case) -> String {
    let why = match case.outcome {
        Outcome::Ok if data.time(case).is_none() => "no fill time",
        Outcome::Ok => "no depth-pass measured",
        _ => standing(case),
    };
    why.to_owned()
}
