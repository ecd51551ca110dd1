// SPDX-License-Identifier: MIT OR Apache-2.0
//! What sections of figures are made of: series over a condition, slopes, curves, and tables of a row a case.

use super::cells::{headings, of};
use crate::keys::EXPERIMENT;
use terrafill_plot::number::significant;
use terrafill_plot::{
    Arrangement, Curve, Palette, Point, PointStanding, Reading, Upwards, WorkPrecision, panels,
};
use terrafill_results::{
    Block, Case, Cell, ChapterError, ConditionKey, Finding, Metric, Plot, Row, Standing, Table,
};

pub(super) fn finding(claim: &str, holds: Option<bool>, because: String) -> Finding {
    Finding {
        claim: format!("{claim}:"),
        standing: holds.map_or(Standing::NotMeasured, Standing::holds_if),
        because,
    }
}

/// Figure by a condition that is a number, in rising order.
pub(super) fn series(
    cases: &[&Case],
    conditions: &[(ConditionKey, &str)],
    key: ConditionKey,
    metric: &Metric,
) -> Vec<(f64, f64)> {
    let own = of(cases, conditions);
    let pair = |case: &&Case| Some((case.condition(key).parse().ok()?, case.value(metric)?));
    let mut pairs: Vec<(f64, f64)> = own.iter().filter_map(pair).collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    pairs
}

/// Least squares of log error over log number; `None` below three points.
pub(super) fn slope(errors: &[(f64, f64)]) -> Option<f64> {
    let usable = errors.iter().filter(|pair| pair.1 > 0.0);
    let logs: Vec<(f64, f64)> = usable.map(|pair| (pair.0.ln(), pair.1.ln())).collect();
    if logs.len() < 3 {
        return None;
    }
    let count = logs.len() as f64;
    let mean_x = logs.iter().map(|log| log.0).sum::<f64>() / count;
    let mean_y = logs.iter().map(|log| log.1).sum::<f64>() / count;
    let products = logs.iter().map(|log| (log.0 - mean_x) * (log.1 - mean_y));
    let squares = logs.iter().map(|log| (log.0 - mean_x).powi(2));
    Some(products.sum::<f64>() / squares.sum::<f64>())
}

/// `3.95 to 4.02`.
pub(super) fn range(values: &[f64]) -> Option<String> {
    let least = values.iter().copied().min_by(f64::total_cmp)?;
    let most = values.iter().copied().max_by(f64::total_cmp)?;
    Some(format!("{} to {}", significant(least), significant(most)))
}

pub(super) fn curve(name: &str, pairs: &[(f64, f64)]) -> Curve {
    let point = |&(x, y): &(f64, f64)| Point {
        knob: x,
        label: String::new(),
        x: Some(Reading::exact(x)),
        y: Some(Reading::exact(y)),
        y_rms: None,
        standing: PointStanding::Right,
        command: String::new(),
    };
    Curve {
        name: name.to_owned(),
        points: pairs.iter().map(point).collect(),
    }
}

pub(super) fn draw(
    title: &str,
    caption: &str,
    plots: &[WorkPrecision<'_>],
) -> Result<Option<Block>, ChapterError> {
    let mut names: Vec<String> = Vec::new();
    for curve in plots.iter().flat_map(|plot| &plot.curves) {
        if !names.contains(&curve.name) {
            names.push(curve.name.clone());
        }
    }
    let svg = panels(title, plots, Arrangement::SideBySide, &Palette::new(names))?;
    Ok(svg.map(|svg| {
        Block::Plot(Plot {
            caption: caption.to_owned(),
            svg,
        })
    }))
}

pub(super) fn plot<'a>(
    title: &'a str,
    across: &'a str,
    up: &'a str,
    curves: Vec<Curve>,
) -> WorkPrecision<'a> {
    WorkPrecision {
        title,
        across,
        up,
        upwards: Upwards::Error,
        curves,
        lines: Vec::new(),
    }
}

/// Figures of an experiment, a row for each case.
pub(super) fn table(
    cases: &[&Case],
    caption: &str,
    experiment: &str,
    keys: &[(&str, ConditionKey)],
    metrics: &[(&str, &'static Metric)],
) -> Table {
    let rows = of(cases, &[(EXPERIMENT, experiment)])
        .into_iter()
        .map(|case| {
            let mut cells: Vec<Cell> = Vec::new();
            cells.extend(keys.iter().map(|(_, key)| Cell::name(case.condition(*key))));
            let values = metrics.iter().map(|(_, metric)| case.value(metric));
            cells.extend(values.map(|value| Cell::or_absent(value.map(significant), "not finite")));
            Row::new(cells)
        });
    let plain = keys.iter().map(|(text, _)| (*text, None));
    let measured = metrics.iter().map(|(text, metric)| (*text, Some(*metric)));
    Table {
        caption: caption.to_owned(),
        headings: headings(&plain.chain(measured).collect::<Vec<_>>()),
        rows: rows.collect(),
        ..Table::default()
    }
}
