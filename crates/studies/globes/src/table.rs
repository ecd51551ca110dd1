// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cases of a part, and tables with a row for each of them.

use crate::keys::PART;
use terrafill_plot::dotted;
use terrafill_plot::number::{measured_bytes, significant};
use terrafill_results::{Case, Cell, ConditionKey, Heading, Metric, Row, Run, Table};

/// Headings of the columns that name a case, and their texts.
pub(crate) type Names<'a> = (&'a [&'a str], &'a dyn Fn(&Case) -> Vec<String>);

/// A heading, and the metric below it.
pub(crate) type Column<'a> = (&'a str, &'static Metric);

/// Cases of a part, without those that repeat another.
pub(crate) fn cases<'a>(run: &'a Run, part: &str) -> Vec<&'a Case> {
    let own = run.of_study(crate::STUDY);
    own.filter(|case| !case.is_twin() && case.condition(PART) == part)
        .collect()
}

/// Those of which a condition has a value.
pub(crate) fn with<'a>(cases: &[&'a Case], condition: ConditionKey, value: &str) -> Vec<&'a Case> {
    let own = cases.iter().copied();
    own.filter(|case| case.condition(condition) == value)
        .collect()
}

/// Why a case lacks a figure.
pub(crate) fn why<'a>(case: &'a Case, otherwise: &'a str) -> &'a str {
    match case.reason.as_str() {
        "" => otherwise,
        reason => reason,
    }
}

/// A table with a row for each case.
///
/// - `names`: headings of the first columns, and their texts
/// - `figures`: further columns; sizes are written with their units
/// - `absent`: why a case lacks a figure where it has no reason of its own
pub(crate) fn by_case(
    caption: &str,
    cases: &[&Case],
    (headings, names): Names<'_>,
    figures: &[Column<'_>],
    absent: &dyn Fn(&Case) -> &'static str,
) -> Table {
    let rows = cases.iter().map(|case| {
        let mut cells: Vec<Cell> = names(case).into_iter().map(Cell::name).collect();
        cells.extend(figures.iter().map(|(_, metric)| {
            let text = case
                .value(metric)
                .map(|value| match metric.name.ends_with("_bytes") {
                    true => measured_bytes(value),
                    false => significant(value),
                });
            let figure = Cell::or_absent(text, why(case, absent(case)));
            dotted(figure, case, metric)
        }));
        Row {
            cells,
            status: case.outcome.name().to_owned(),
            remark: case.reason.clone(),
        }
    });
    let mut all: Vec<Heading> = headings.iter().map(|text| Heading::plain(*text)).collect();
    let metrics = figures.iter();
    all.extend(metrics.map(|(text, metric)| Heading::metric(*text, *metric)));
    Table {
        caption: caption.to_owned(),
        headings: all,
        rows: rows.collect(),
        ..Table::default()
    }
}

/// Texts of conditions, for [`by_case`].
pub(crate) fn conditions<'a>(names: &'a [ConditionKey]) -> impl Fn(&Case) -> Vec<String> + 'a {
    move |case| {
        let names = names.iter();
        names.map(|key| case.condition(*key).to_owned()).collect()
    }
}
