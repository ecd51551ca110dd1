// SPDX-License-Identifier: MIT OR Apache-2.0
//! What users would pick instead, beside the fastest correct technique of the same view and run.

use super::data::{Data, View, counter, name};
use super::scenes::best;
use crate::keys::{GEOMETRY_BYTES, MISMATCHED_PX, MISMATCHED_PX_OUTSIDE_BAND};
use terrafill_plot::dotted;
use terrafill_plot::number::{bytes, count, significant, times};
use terrafill_results::{Block, Case, Cell, Heading, Metric, Row, Table, ratio};

/// A row for every rival in every view.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let mut rows = Vec::new();
    let mut made_by: Vec<&str> = Vec::new();
    for scene in data.scenes() {
        for view in &scene.views {
            for rival in &view.rivals {
                rows.push(row(data, scene.name, view, rival));
                let note = rival.note("texture_route");
                if !note.is_empty() && !made_by.contains(&note) {
                    made_by.push(note);
                }
            }
        }
    }
    if rows.is_empty() {
        return Vec::new();
    }
    vec![
        Block::section("What users would pick instead"),
        Block::Text(format!(
            "Each rival beside the fastest correct technique of the same view, measured in the same blocks of \
             this run, by {}: of a rival over all its processes, a frame with its regions shown less one with them \
             hidden. Ratio: rival ÷ ours, paired by process, with the 95 % interval where there are processes \
             enough. Its pixels are compared with a reference that takes ring edges for what they are to it and \
             meets rays with the body itself: its globe is its own, and its error contains that.{}",
            data.run.clock().name(),
            match made_by.as_slice() {
                [] => String::new(),
                _ => format!(" Measured: {}.", made_by.join("; ")),
            }
        )),
        Block::Table(Table {
            headings: vec![
                Heading::plain("view"),
                Heading::plain("rival"),
                Heading::plain("status"),
                Heading::metric(data.unit(), data.metric),
                Heading::plain("fastest of ours"),
                Heading::plain(format!("ours, {}", data.unit())),
                Heading::plain("rival ÷ ours"),
                Heading::metric("px that differ", MISMATCHED_PX),
                Heading::metric("outside band", MISMATCHED_PX_OUTSIDE_BAND),
                Heading::plain("ours: px that differ"),
                Heading::metric("bytes", GEOMETRY_BYTES),
                Heading::plain("bytes of ours"),
            ],
            rows,
            is_main: true,
            ..Table::default()
        }),
    ]
}

fn row(data: &Data<'_>, scene: &str, view: &View<'_>, rival: &Case) -> Row {
    let ours = best(data, view);
    let why = match rival.reason.as_str() {
        "" => "not measured",
        reason => reason,
    };
    let no_ours = "no correct technique was timed in this view";
    let of = |case: Option<&Case>, metric: &Metric| case.and_then(|case| counter(case, metric));
    let px = |case, metric, why| Cell::or_absent(of(case, metric).map(count), why);
    let over = ours.and_then(|ours| ratio(rival, ours, data.metric));
    Row {
        cells: vec![
            Cell::name(format!("{scene}, {}", view.name)),
            Cell::name(name(rival)),
            Cell::plain(rival.outcome.name()),
            dotted(
                Cell::or_absent(data.time(rival).map(|ms| significant(ms.median)), why),
                rival,
                data.metric,
            ),
            Cell::name(ours.map_or_else(String::new, name)),
            Cell::or_absent(
                ours.and_then(|ours| data.time(ours))
                    .map(|ms| significant(ms.median)),
                no_ours,
            ),
            Cell::or_absent(over.map(|over| times(&over)), why),
            px(Some(rival), MISMATCHED_PX, why),
            px(Some(rival), MISMATCHED_PX_OUTSIDE_BAND, why),
            px(ours, MISMATCHED_PX, no_ours),
            Cell::or_absent(of(Some(rival), GEOMETRY_BYTES).map(bytes), why),
            Cell::or_absent(of(ours, GEOMETRY_BYTES).map(bytes), no_ours),
        ],
        status: rival.outcome.name().to_owned(),
        remark: rival.reason.clone(),
    }
}
