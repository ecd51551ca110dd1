// SPDX-License-Identifier: MIT OR Apache-2.0
//! What users would pick instead, beside the fastest correct technique of the same view and run.

use super::data::{Data, counter, distinct, name};
use super::table::Show::{Bytes, Count, Median, Own, Status};
use super::table::{Column, section, table};
use crate::keys::{GEOMETRY_BYTES, MISMATCHED_PX, MISMATCHED_PX_OUTSIDE_BAND};
use terrafill_plot::number::{bytes, count, significant, times};
use terrafill_results::{Block, Cell, ratio};

const COLUMNS: [Column; 12] = [
    ("view", Own("")),
    ("rival", Own("")),
    ("status", Status),
    ("{unit}", Median),
    ("fastest of ours", Own("")),
    ("ours, {unit}", Own("")),
    ("rival ÷ ours", Own("")),
    ("px that differ", Count(MISMATCHED_PX)),
    ("outside band", Count(MISMATCHED_PX_OUTSIDE_BAND)),
    ("ours: px that differ", Own("")),
    ("bytes", Bytes(GEOMETRY_BYTES)),
    ("bytes of ours", Own("")),
];

/// A row for every rival in every view.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let rivals = data.views.iter();
    let rivals = rivals.flat_map(|view| view.rivals.iter().map(move |rival| (view, *rival)));
    let notes = rivals.clone().map(|(_, rival)| rival.note("texture_route"));
    let made_by = distinct(notes.filter(|note| !note.is_empty()));
    let rows = rivals.map(|(view, rival)| {
        let ours = data.fastest(view.competing());
        let no_ours = "no correct technique was timed in this view";
        let of_ours = |metric, print: fn(u64) -> String| {
            let figure = ours.and_then(|ours| counter(ours, metric));
            Cell::or_absent(figure.map(print), no_ours)
        };
        let time = ours.and_then(|ours| data.time(ours));
        let over = ours.and_then(|ours| ratio(rival, ours, data.metric));
        let own = vec![
            Cell::name(view.title()),
            Cell::name(name(rival)),
            Cell::name(ours.map_or_else(String::new, name)),
            Cell::or_absent(time.map(|ms| significant(ms.median)), no_ours),
            Cell::or_absent(over.map(|over| times(&over)), "no process timed both"),
            of_ours(MISMATCHED_PX, count),
            of_ours(GEOMETRY_BYTES, bytes),
        ];
        (rival, own)
    });
    let text = format!(
        "Each rival beside the fastest correct technique of the same view, measured in the same blocks of \
         this run, by {}: of a rival over all its processes, a frame with its regions shown less one with them \
         hidden. Ratio: rival ÷ ours, paired by process, with the 95 % interval where there are processes \
         enough. Its pixels are compared with a reference that takes ring edges for what they are to it and \
         meets rays with the body itself: its globe is its own, and its error contains that.{}",
        data.run.clock().name(),
        match made_by.is_empty() {
            true => String::new(),
            false => format!(" Measured: {}.", made_by.join("; ")),
        }
    );
    section(
        "What users would pick instead",
        text,
        table(data, &COLUMNS, rows),
    )
}
