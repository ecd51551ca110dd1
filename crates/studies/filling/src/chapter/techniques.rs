// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every technique's best fill of every view beside the view's fastest.

use super::data::{Data, View, distinct, label};
use super::table::section;
use crate::keys::TECHNIQUE;
use terrafill_results::{Block, Cell, Row, Table, ratio};

/// A row for each view, a column for each technique in order of appearance.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let cases = data.views.iter().flat_map(View::competing);
    let techniques = distinct(cases.map(|case| case.condition(TECHNIQUE)));
    let row = |view: &View<'_>| {
        let fastest = data.timings.fastest(view.competing())?;
        let cells = techniques.iter().map(|technique| {
            let own = view.competing();
            let own = own.filter(|case| case.condition(TECHNIQUE) == *technique);
            let Some(case) = data.timings.fastest(own) else {
                return Cell::absent("no fill of this technique is right here and was timed");
            };
            let over = ratio(case, fastest, data.timings.metric);
            let named = data.name_cell(case, label(case));
            Cell {
                detail: named.text,
                marker: named.marker,
                command: named.command,
                ..data
                    .timings
                    .ratio_cell(over.as_ref(), "no process measured both")
            }
        });
        let view = Cell {
            section: view.scene.to_owned(),
            ..Cell::name(view.title())
        };
        Some(Row::named(view, cells))
    };
    let rows = data.views.iter().filter_map(row).collect();
    let headings = std::iter::once("scene, view").chain(techniques.iter().copied());
    let text = "Each technique's fastest right fill of each view, and its time over that of the view's fastest fill \
                by any technique, paired by process.";
    section("Techniques", text, Table::of(headings, rows))
}
