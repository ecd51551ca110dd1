// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every technique's best fill of every view beside the view's fastest, and what could not be drawn rightly.

use super::data::{Data, View, grouped, name, title};
use super::table::{plain_figures, row, section};
use crate::keys::{LAYOUT, TECHNIQUE};
use terrafill_results::{Block, Case, Cell, Outcome, ratio};

/// A row for each view, a column for each technique in order of appearance; then its fills that are not right.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let cases = data.views.iter().flat_map(View::competing);
    let techniques = grouped(cases, |case| case.condition(TECHNIQUE));
    let of = |view: &View<'_>| {
        let fastest = data.fastest(view.competing());
        let cells = techniques.iter().map(|(technique, _)| {
            let own = || {
                view.competing()
                    .filter(|case| case.condition(TECHNIQUE) == *technique)
            };
            let Some(case) = data.fastest(own()) else {
                return Cell::absent(match own().next() {
                    Some(_) => "no fill of this technique is right here and was timed",
                    None => "it was not planned for this view",
                });
            };
            let over = fastest.and_then(|fastest| ratio(case, fastest, data.metric));
            let over = data.ratio_cell(over.as_ref(), "no process measured both");
            Cell {
                detail: data.label(case),
                text: over.text,
                title: over.title,
                class: over.class,
                ..data.name_cell(case, String::new())
            }
        });
        let view = Cell {
            section: view.scene.to_owned(),
            ..Cell::name(view.title())
        };
        row(view, cells)
    };
    let rows = data
        .views
        .iter()
        .filter(|view| view.competing().next().is_some());
    let rows = rows.map(of).collect();
    let headings = techniques.iter().map(|(technique, _)| *technique);
    let headings: Vec<&str> = std::iter::once("scene, view").chain(headings).collect();
    let text = "Each technique's fastest right fill of each view, and its time over that of the view's fastest fill \
                by any technique, paired by process.";
    let mut blocks = section("Techniques", text, plain_figures(&headings, rows));
    for (technique, own) in &techniques {
        blocks.extend(not_right(technique, own).into_iter().flatten());
    }
    blocks
}

/// How many fills of a technique are right, and why the others are not.
fn not_right(technique: &str, own: &[&Case]) -> [Option<Block>; 2] {
    let right = own.iter().filter(|case| case.counts()).count();
    let layouts = grouped(own, |case| case.condition(LAYOUT)).into_iter();
    let layouts: Vec<&str> = layouts.map(|(layout, _)| layout).collect();
    let others = own
        .iter()
        .filter(|case| !case.counts() && case.outcome != Outcome::Ok);
    let others = others.map(|case| {
        let (of, status) = (name(case), case.outcome.name());
        format!("{}, {of}: {status}: {}", title(case), case.reason)
    });
    let others: Vec<String> = others.collect();
    let summary = format!(
        "{technique}: {} fills without a right picture",
        others.len()
    );
    let text = format!(
        "{technique}: {right} of {} fills are right. Layouts: {}.",
        own.len(),
        layouts.join(", ")
    );
    [Some(Block::Text(text)), Block::folded_list(summary, others)]
}
