// SPDX-License-Identifier: MIT OR Apache-2.0
//! What users would pick instead, beside the fastest correct technique of the same view and run.

use super::data::{Data, distinct, name};
use super::table::{STATUS, section};
use crate::keys::*;
use terrafill_lab::{Column, case_table};
use terrafill_plot::number::{significant, times};
use terrafill_results::{Block, Cell, Heading, ratio};

/// What is said before the rival's own figures.
const SAID: [&str; 5] = [
    "view",
    "rival",
    "fastest of ours",
    "ours, ms",
    "rival ÷ ours",
];

const COLUMNS: [Column; 5] = [
    STATUS,
    Column::sampled("{unit} (5–95 %)", FILL_GPU_MS, FILL_CPU_MS),
    Column::metric("px that differ", MISMATCHED_PX),
    Column::metric("outside band", MISMATCHED_PX_OUTSIDE_BAND),
    Column::metric("bytes", GEOMETRY_BYTES),
];

/// A row for every rival in every view.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let rivals = data.views.iter();
    let rivals = rivals.flat_map(|view| view.rivals.iter().map(move |rival| (view, *rival)));
    let notes = rivals.clone().map(|(_, rival)| rival.note("texture_route"));
    let made_by = distinct(notes.filter(|note| !note.is_empty())).join("; ");
    let rows = rivals.map(|(view, rival)| {
        let ours = data.timings.fastest(view.competing());
        let no_ours = "no correct technique was timed in this view";
        let time = ours.and_then(|ours| data.timings.samples(ours));
        let over = ours.and_then(|ours| ratio(rival, ours, data.timings.metric));
        let said = vec![
            Cell::name(view.title()),
            Cell::name(name(rival)),
            Cell::name(ours.map_or_else(String::new, name)),
            Cell::or_absent(time.map(|ms| significant(ms.median)), no_ours),
            Cell::or_absent(over.as_ref().map(times), "no process timed both"),
        ];
        (rival, said)
    });
    let text = format!(
        "Each rival beside the fastest correct technique of the same view, measured in the same blocks of \
         this run, by {}: of a rival over all its processes, a frame with its regions shown less one with them \
         hidden. Ratio: rival ÷ ours, paired by process, with the 95 % interval where there are processes \
         enough. Its pixels are compared with a reference that takes ring edges for what they are to it and \
         meets rays with the body itself: its globe is its own, and its error contains that. Measured: {made_by}.",
        data.run.clock().name(),
    );
    let table = case_table(&data.study, SAID.map(Heading::from).into(), &COLUMNS, rows);
    section("What users would pick instead", text, table)
}
