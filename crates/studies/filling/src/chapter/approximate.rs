// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes against what is approximate by nature: error against time, a plot and a table for each view
//! in which such fills were drawn.
//!
//! Of each technique that competes the fastest fill stands for all; of the others every one does.

use super::data::{
    Data, View, competes, counter, distinct, is_approximate, is_baseline, name, setting, standing,
};
use super::error_time::point;
use crate::keys::{
    BOUNDARY_MOVED_PX, GEOMETRY_BYTES, HAUSDORFF_PX, MISMATCHED_PX, MISMATCHED_PX_OUTSIDE_BAND,
    PREPARE_CPU_MS, TARGET_BYTES, TECHNIQUE,
};
use terrafill_conformance::MAX_HAUSDORFF_PX;
use terrafill_plot::number::{bytes, count, significant, spread, times};
use terrafill_plot::{Arrangement, Curve, Palette, Upwards, WorkPrecision, dotted, panels};
use terrafill_results::{
    Block, Case, Cell, ChapterError, Heading, Metric, Plot, Row, Table, over_typical,
};

/// Title, axis and metric of each panel.
const ERRORS: [(&str, &str, &Metric); 2] = [
    (
        "Error of the boundary",
        "Hausdorff distance, px",
        HAUSDORFF_PX,
    ),
    ("Wrong pixels", "mismatched pixels", MISMATCHED_PX),
];

/// The section; nothing where no approximate fill was drawn.
pub(super) fn blocks(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    let palette = Palette::new(data.all_series());
    let mut blocks = Vec::new();
    for scene in data.scenes() {
        for view in &scene.views {
            if !view.cases.iter().any(|case| is_approximate(case)) {
                continue;
            }
            let title = format!("{}, {}", scene.name, view.name);
            blocks.push(Block::Heading {
                level: 4,
                text: format!("Volumes and approximate fills: {title}"),
            });
            blocks.extend(plot(data, &title, view, &palette)?);
            blocks.push(Block::Table(table(data, &palette, view)));
        }
    }
    if blocks.is_empty() {
        return Ok(blocks);
    }
    let head = [
        Block::section("Volumes against approximate fills"),
        Block::Text(
            "What one would take instead of volumes: the region's triangles at one height \
             (flat-mesh; the “original fill” of 2007), the region cut on the CPU along the surface's \
             triangles as drawn (draped-mesh), and all regions drawn into a texture over longitude and \
             latitude, by its size (mask-texture). Their pictures differ from the reference by nature: \
             they never count as right, and compete with none. Of each kind of volumes the fastest \
             right fill is shown."
                .to_owned(),
        ),
    ];
    let within = Block::List(within_tolerances(data));
    Ok(head.into_iter().chain([within]).chain(blocks).collect())
}

/// In how many views each approximate fill was within the tolerances that volumes are held to, a
/// sentence a fill.
fn within_tolerances(data: &Data<'_>) -> Vec<String> {
    let drawn = || {
        let cases = data
            .cases
            .iter()
            .copied()
            .filter(|case| is_approximate(case));
        cases.filter(|case| case.value(MISMATCHED_PX).is_some())
    };
    let sentence = |fill: String| {
        let own = || drawn().filter(|case| name(case) == fill);
        let is_within = |case: &&Case| {
            let distance = case.value(HAUSDORFF_PX).unwrap_or(0.0);
            case.value(MISMATCHED_PX_OUTSIDE_BAND) == Some(0.0) && distance <= MAX_HAUSDORFF_PX
        };
        let (within, all) = (own().filter(is_within).count(), own().count());
        format!(
            "{fill}: within the tolerances in {within} of {all} views, which it does not promise."
        )
    };
    distinct(drawn().map(name))
        .into_iter()
        .map(sentence)
        .collect()
}

/// The fastest right fill of each technique that competes, then every approximate one.
fn shown<'a>(data: &Data<'a>, view: &View<'a>) -> Vec<&'a Case> {
    let volumes = || {
        let own = view.cases.iter().copied();
        own.filter(|case| competes(case) && !is_baseline(case) && case.counts())
    };
    let techniques = distinct(volumes().map(|case| case.condition(TECHNIQUE)));
    let fastest = techniques.into_iter().filter_map(|technique| {
        let own = volumes().filter(|case| case.condition(TECHNIQUE) == technique);
        data.fastest(own)
    });
    let approximate = view.cases.iter().copied();
    fastest
        .chain(approximate.filter(|case| is_approximate(case)))
        .collect()
}

fn plot(
    data: &Data<'_>,
    title: &str,
    view: &View<'_>,
    palette: &Palette,
) -> Result<Option<Block>, ChapterError> {
    let across = format!("fill, {}: median, 5–95 % of samples", data.unit());
    let shown = shown(data, view);
    let names = distinct(shown.iter().map(|case| data.marked(case)));
    let curves = |metric: &Metric| {
        let curve = |name: &String| {
            let own = shown.iter().filter(|case| data.marked(case) == *name);
            let drawn =
                own.filter(|case| data.time(case).is_some() && case.value(metric).is_some());
            Curve {
                name: name.clone(),
                points: drawn.map(|case| point(data, view, case, metric)).collect(),
            }
        };
        names.iter().map(curve).collect()
    };
    let plots = ERRORS.map(|(title, up, metric)| WorkPrecision {
        title,
        across: &across,
        up,
        upwards: Upwards::Error,
        curves: curves(metric),
        lines: Vec::new(),
    });
    let title = format!("{title}: error of volumes and of approximate fills against run time");
    let svg = panels(&title, &plots, Arrangement::SideBySide, palette)?;
    Ok(svg.map(|svg| {
        Block::Plot(Plot {
            caption: "Left and low is better; an error of 0 stands on the line at the bottom. An open \
                      mark is an approximate fill, labelled by its setting: a mask's longer side in texels, a \
                      height in metres, a share of the distance."
                .to_owned(),
            svg,
        })
    }))
}

fn table(data: &Data<'_>, palette: &Palette, view: &View<'_>) -> Table {
    let shown = shown(data, view);
    let fastest = data.fastest(shown.iter().copied());
    Table {
        rows: shown
            .iter()
            .map(|case| row(data, palette, view, case, fastest))
            .collect(),
        headings: vec![
            Heading::plain("fill"),
            Heading::plain("status"),
            Heading::metric(format!("fill, {}", data.unit()), data.metric),
            Heading::explained(
                "÷\u{a0}fastest right",
                "medians over processes; no right fill is below 1, an approximate one may be",
            ),
            Heading::metric("px that differ", MISMATCHED_PX),
            Heading::metric("Hausdorff, px", HAUSDORFF_PX),
            Heading::metric("moved, px", BOUNDARY_MOVED_PX),
            Heading::metric("to prepare, CPU\u{a0}ms", PREPARE_CPU_MS),
            Heading::metric("geometry", GEOMETRY_BYTES),
            Heading::metric("targets", TARGET_BYTES),
        ],
        is_main: true,
        ..Table::default()
    }
}

fn row(
    data: &Data<'_>,
    palette: &Palette,
    view: &View<'_>,
    case: &Case,
    fastest: Option<&Case>,
) -> Row {
    let why = match case.reason.as_str() {
        "" => "not measured",
        reason => reason,
    };
    let cell = |text: Option<String>| Cell::or_absent(text, why);
    let figure = |metric: &Metric| cell(case.value(metric).map(significant));
    let sized = |metric: &Metric| cell(counter(case, metric).map(bytes));
    let over = fastest.and_then(|fastest| over_typical(case, fastest, data.metric));
    let cells = vec![
        Cell {
            marker: palette.marker(&data.marked(case)),
            command: data.command(case),
            detail: match setting(case, view).filter(|_| is_approximate(case)) {
                Some(setting) => setting.to_owned(),
                None => String::new(),
            },
            ..Cell::name(name(case))
        },
        Cell::plain(standing(case)),
        dotted(cell(data.time(case).map(spread)), case, data.metric),
        cell(over.map(|over| times(&over))),
        cell(counter(case, MISMATCHED_PX).map(count)),
        figure(HAUSDORFF_PX),
        match case.value(BOUNDARY_MOVED_PX) {
            Some(px) => Cell::plain(significant(px)),
            None if is_approximate(case) => Cell::absent("by more than 64 pixels"),
            None => Cell::absent("moves no boundary on purpose"),
        },
        dotted(figure(PREPARE_CPU_MS), case, PREPARE_CPU_MS),
        sized(GEOMETRY_BYTES),
        sized(TARGET_BYTES),
    ];
    Row {
        cells,
        status: standing(case).to_owned(),
        remark: case.reason.clone(),
    }
}
