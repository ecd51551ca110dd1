// SPDX-License-Identifier: MIT OR Apache-2.0
//! Constants of formulas, which no run changes: `docs/globe-arithmetic.md` holds them, and this module proves it.

mod controllers;
mod grid;
mod printed;
mod segments;
mod spiral;

use terrafill_plot::number::significant;

const PAGE: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../../docs/globe-arithmetic.md"
);

/// Written anew where this variable is set.
const WRITE: &str = "TERRAFILL_WRITE_DOCS";

const HEAD: &str = "# Arithmetic of globes

What follows from formulas alone, or was printed by others: no run measures it. A test of `terrafill-globes` compares
this page with what the code computes; with `TERRAFILL_WRITE_DOCS=1` it writes the page.
";

/// A table in Markdown.
fn table(headings: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let headings: Vec<String> = headings.iter().map(|text| (*text).to_owned()).collect();
    let rule = format!("|{}\n", " --- |".repeat(headings.len()));
    let rows = rows.into_iter().map(|row| line(&row));
    format!("\n{}{rule}{}", line(&headings), rows.collect::<String>())
}

fn numbers(values: impl IntoIterator<Item = f64>) -> Vec<String> {
    let text = |value: f64| match value.fract() == 0.0 {
        true => value.to_string(),
        false => significant(value),
    };
    values.into_iter().map(text).collect()
}

fn page() -> String {
    let parts = [
        HEAD.to_owned(),
        spiral::page(),
        grid::page(),
        segments::page(),
        controllers::page(),
        printed::page(),
    ];
    parts.join("\n")
}

/// The first line in which a page differs from what was computed.
fn differing<'a>(written: &'a str, computed: &'a str) -> Option<[&'a str; 2]> {
    let ends = |text: &'a str| text.lines().chain(["end of the page"]);
    let mut pairs = ends(written).zip(ends(computed));
    pairs.find(|(a, b)| a != b).map(<[&str; 2]>::from)
}

#[test]
fn the_page_is_what_the_code_computes() {
    let computed = page();
    if std::env::var_os(WRITE).is_some() {
        std::fs::write(PAGE, &computed).expect("writable");
    }
    let written = std::fs::read_to_string(PAGE).expect("docs/globe-arithmetic.md");
    let found = differing(&written, &computed);
    assert_eq!(found, None, "with {WRITE}=1 this test writes the page anew");
    // Negative controls: a digit, and a line that is lost.
    assert!(differing(&written.replacen('7', "8", 1), &computed).is_some());
    let end = written.trim_end().rfind('\n').expect("lines");
    assert!(differing(&written[..end], &computed).is_some());
}
