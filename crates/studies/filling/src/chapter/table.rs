// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the sections of the chapter have in common: their heads, and a column for how a case ended.

use super::data::standing;
use terrafill_lab::{Column, Figure};
use terrafill_results::{Block, Table};

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

/// A figure within a sentence.
pub(super) fn or_dash(figure: Option<String>) -> String {
    figure.unwrap_or_else(|| "–".to_owned())
}
