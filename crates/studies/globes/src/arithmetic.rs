// SPDX-License-Identifier: MIT OR Apache-2.0
//! Constants of formulas, which no run changes: `docs/globe-arithmetic.md` holds them, and this module proves it.

mod controllers;
mod grid;
mod printed;
mod probe;
mod quadtree;
mod radius;
mod segments;
mod spiral;
mod texels;
mod zones;

use terrafill_fixtures::page::{assert_page, markdown_table as table};
use terrafill_plot::number::significant;

const HEAD: &str = "# Arithmetic of globes

What follows from formulas alone, or was printed by others: no run measures it. A test of `terrafill-globes` compares
this page with what the code computes; with `TERRAFILL_WRITE_DOCS=1` it writes the page.
";

fn numbers(values: impl IntoIterator<Item = f64>) -> Vec<String> {
    let text = |value: f64| {
        if value.fract() == 0.0 {
            value.to_string()
        } else {
            significant(value)
        }
    };
    values.into_iter().map(text).collect()
}

fn page() -> String {
    let parts = [
        HEAD.to_owned(),
        spiral::page(),
        grid::page(),
        segments::page(),
        texels::page(),
        controllers::page(),
        printed::page(),
    ];
    parts.join("\n")
}

#[test]
fn the_page_is_what_the_code_computes() {
    assert_page("globe-arithmetic.md", &page());
}
