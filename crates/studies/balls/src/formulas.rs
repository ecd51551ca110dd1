// SPDX-License-Identifier: MIT OR Apache-2.0
//! Arithmetic of balls that no run changes: `docs/ball-arithmetic.md` holds it, and this module proves it.

mod contact;
mod reflection;
mod rest;

use terrafill_fixtures::page::{assert_page, markdown_table as table};
use terrafill_plot::number::significant;

const HEAD: &str = "# Arithmetic of balls

What follows from the integrators alone: no run measures it. A test of `terrafill-balls` compares this page with what
the code computes; with `TERRAFILL_WRITE_DOCS=1` it writes the page.
";

/// A figure, or why there is none.
fn or(value: Option<f64>, why: &str) -> String {
    let value = value.filter(|value| value.is_finite());
    value.map_or_else(|| why.to_owned(), significant)
}

#[test]
fn the_page_is_what_the_code_computes() {
    let parts = [
        HEAD.to_owned(),
        contact::page(),
        reflection::page(),
        rest::page(),
    ];
    assert_page("ball-arithmetic.md", &parts.join("\n"));
}
