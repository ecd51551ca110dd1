// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the sections of the chapter have in common: a column for how a case ended, and the steps of a ladder.

use super::data::{Data, name, standing};
use super::rungs::Rung;
use terrafill_lab::{Column, Figure, case_table};
use terrafill_plot::number::{significant, spread};
use terrafill_plot::{RatioAxis, Step, Steps};
use terrafill_results::{Block, Case, Cell, ChapterError, Heading, Outcome, Table};

/// How a case ended.
pub(super) const STATUS: Column = Column::of(
    "status",
    Figure::Words(|case| Some(standing(case).to_owned())),
);

/// A section with a table that `summary.md` repeats; nothing where it has no row.
pub(super) fn section(title: &str, text: impl Into<String>, table: Table) -> Vec<Block> {
    if table.rows.is_empty() {
        return Vec::new();
    }
    let table = Table {
        is_main: true,
        ..table
    };
    [head(title, text), vec![Block::Table(table)]].concat()
}

/// A section's heading and what is said below it.
pub(super) fn head(title: &str, text: impl Into<String>) -> Vec<Block> {
    vec![Block::section(title), Block::Text(text.into())]
}

/// Sentences after each other, without the empty ones.
pub(super) fn sentences<T: AsRef<str>>(texts: impl IntoIterator<Item = T>) -> String {
    let texts = texts.into_iter().map(|text| text.as_ref().to_owned());
    let texts: Vec<String> = texts.filter(|text| !text.is_empty()).collect();
    texts.join(". ")
}

/// A figure within a sentence.
pub(super) fn or_dash(figure: Option<String>) -> String {
    figure.unwrap_or_else(|| "–".to_owned())
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
    Ok(Block::plot("", steps.draw()?))
}

/// The steps of a ladder, each with what it gained, its figures, and what it changed of the work.
pub(super) fn steps_table(
    data: &Data<'_>,
    rungs: &[Rung<'_>],
    columns: &[Column],
    changed: impl Fn(&Case, &Case) -> Cell,
) -> Table {
    let rows = rungs.iter().map(|rung| {
        let aside = if rung.is_aside { "aside, " } else { "" };
        let step = Cell {
            detail: name(rung.case),
            ..Cell::name(format!(
                "{} · {aside}{}: {}",
                rung.number, rung.step, rung.change
            ))
        };
        let why = "no kept step before it, or no times of both";
        let over = data.spread_over_depth_pass(rung.case).map(spread);
        let said = vec![
            step,
            data.timings.ratio_cell(rung.gain.as_ref(), why),
            Cell::or_absent(over, no_ratio(data, rung.case)),
            match rung.before {
                Some(before) => changed(before, rung.case),
                None => Cell::absent("nothing comes before it"),
            },
        ];
        (rung.case, said)
    });
    let said = [
        ("step", ""),
        (
            "gain [95\u{a0}%]",
            "time of the last kept step before over this one's, paired by process",
        ),
        (
            "÷\u{a0}depth-pass (5\u{2060}–\u{2060}95\u{a0}%)",
            "times over the median of the full-screen depth-pass of the same view",
        ),
        ("changed", "of the work that is done"),
    ];
    case_table(&data.study, said.map(Heading::from).into(), columns, rows)
}

/// Why a case has no ratio to another's time.
pub(super) fn no_ratio(data: &Data<'_>, case: &Case) -> String {
    let why = match case.outcome {
        Outcome::Ok if data.timings.samples(case).is_none() => "no fill time",
        Outcome::Ok => "no depth-pass measured",
        _ => standing(case),
    };
    why.to_owned()
}
