// SPDX-License-Identifier: MIT OR Apache-2.0
//! The tables of sections that have not moved to the kit yet.

use super::data::{DEPTH_PASS, Data, counter, is_approximate, is_baseline, is_rival, standing};
use crate::keys::*;
use crate::metrics::METRICS;
pub(super) use terrafill_lab::none_differs;
use terrafill_plot::dotted;
use terrafill_plot::number::{bytes, count, significant, spread};
use terrafill_results::{
    Block, Case, Cell, CellClass, Heading, Kind, Metric, Outcome, Row, Spread, Table, sample_spread,
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

impl Show {
    /// The metric that it shows; `None` of what is made of several, or is none.
    fn metric(self, data: &Data<'_>) -> Option<&'static Metric> {
        match self {
            Self::Times | Self::Median => Some(data.metric),
            Self::OtherClock => Some(data.run.clock().pick(FILL_CPU_MS, FILL_GPU_MS)),
            Self::Figure(metric) | Self::Count(metric) | Self::Bytes(metric) => Some(metric),
            Self::Own(_) | Self::Status | Self::Over(_) | Self::Ratios => None,
        }
    }

    /// What its heading means, unless that is the metric's to say.
    fn meaning(self) -> &'static str {
        match self {
            Self::Own(meaning) => meaning,
            Self::Over(DEPTH_PASS) => {
                "over the full-screen pass that reads depth, paired by process"
            }
            Self::Over(_) => {
                "over the full-screen pass that clears and tests the stencil, paired by process"
            }
            Self::Ratios => "times over the median of the full-screen depth-pass of the same view",
            _ => "",
        }
    }
}

/// Heading, in which `{unit}` is that of the run's clock and `{other}` that of the other one, and what is shown.
pub(super) type Column = (&'static str, Show);

pub(super) const NOT_COMPARED: &str = "not compared with the reference";
pub(super) const NOT_RECORDED: &str = "not recorded by this run";
pub(super) const NOT_TIMED: &str = "no frame was timed";
pub(super) const NO_TEXELS: &str = "a plain fill has no texels";

/// Why a case that is right may lack a figure, where it is not [`NOT_RECORDED`].
const MAY_LACK: [(&str, &[&Metric]); 10] = [
    (NOT_TIMED, &[FILL_CPU_MS]),
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
    match show.metric(data) {
        Some(metric) => Heading::metric(text, metric),
        None => Heading::explained(text, show.meaning()),
    }
}

/// A cell of a case.
fn cell(data: &Data<'_>, case: &Case, show: Show) -> Cell {
    let median = |times: Spread| significant(times.median);
    let metric = show.metric(data);
    let text = match show {
        Show::Own(_) => return Cell::default(),
        Show::Status => return Cell::plain(standing(case)),
        Show::Times => data.time(case).map(spread),
        Show::Median | Show::OtherClock => {
            metric.and_then(|metric| sample_spread(case, metric).map(median))
        }
        Show::Figure(metric) => case.value(metric).map(significant),
        Show::Count(metric) => counter(case, metric).map(count),
        Show::Bytes(metric) => counter(case, metric).map(bytes),
        Show::Over(technique) => {
            let ratio = data
                .baseline(case, technique)
                .and_then(|pass| data.over(case, pass));
            ratio.map(|ratio| significant(ratio.middle))
        }
        Show::Ratios => data.spread_over_depth_pass(case).map(spread),
    };
    let why = match (show, metric) {
        (Show::Times | Show::Median, _) => NOT_TIMED,
        (_, Some(metric)) => why_absent(metric),
        (_, None) => "this pass was not measured in this run",
    };
    match (text, metric.filter(|metric| metric.kind == Kind::Time)) {
        (None, _) => absent(case, why),
        (Some(text), Some(metric)) => dotted(time_cell(case, text), case, metric),
        (Some(text), None) => Cell::plain(text),
    }
}

/// A time, which counts for nothing when the picture is wrong.
fn time_cell(case: &Case, text: String) -> Cell {
    let (class, title) = match case.outcome {
        _ if is_approximate(case) => (
            CellClass::Plain,
            "approximate: its picture differs by nature, and it competes with none",
        ),
        // An error that is part of the answer is shown next to the time.
        Outcome::Wrong if !is_rival(case) => (
            CellClass::Void,
            "the picture is wrong: this time counts for nothing",
        ),
        _ => (CellClass::Plain, ""),
    };
    Cell {
        class,
        title: title.to_owned(),
        ..Cell::plain(text)
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
pub(super) fn figures(headings: &[(&str, &str)], rows: Vec<Row>) -> Table {
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
pub(super) fn row(name: Cell, cells: impl IntoIterator<Item = Cell>) -> Row {
    Row::new([name].into_iter().chain(cells).collect())
}

/// The same where headings say what they mean.
pub(super) fn plain_figures(headings: &[&str], rows: Vec<Row>) -> Table {
    let headings: Vec<(&str, &str)> = headings.iter().map(|text| (*text, "")).collect();
    figures(&headings, rows)
}

/// A table among those that `summary.md` repeats; nothing where it has no row.
pub(super) fn main_table(table: Table) -> Option<Block> {
    let is_main = !table.rows.is_empty();
    is_main.then_some(Block::Table(Table { is_main, ..table }))
}

pub(super) fn alarm(text: impl Into<String>, wrong: Vec<String>) -> Vec<Block> {
    Block::alarm(text, wrong)
}

/// A section's heading and what is said below it.
pub(super) fn head(title: &str, text: impl Into<String>) -> Vec<Block> {
    vec![Block::section(title), Block::Text(text.into())]
}

/// Heading of a part of a section.
pub(super) fn part(text: String) -> Block {
    Block::Heading { level: 4, text }
}
