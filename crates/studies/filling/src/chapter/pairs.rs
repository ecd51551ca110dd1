// SPDX-License-Identifier: MIT OR Apache-2.0
//! Controlled pairs: two cases that differ in one thing, as it should be used, in every view.

use super::data::{Data, View, name};
use terrafill_results::{Block, Cell, Estimate, Heading, Row, Table};

/// What is compared.
#[derive(Debug, Clone, Copy)]
struct Pair {
    heading: &'static str,
    /// Its time is divided …
    case: &'static str,
    /// … by this one's.
    control: &'static str,
}

/// Techniques on one interface, one algorithm on two interfaces, and expansion against storage.
const PAIRS: [Pair; 4] = [
    Pair {
        heading: "geometry shader (degenerate triangles) ÷ vertex shader, both on Vulkan",
        case: "native/gs-degenerate",
        control: "native/vs-control",
    },
    Pair {
        heading: "geometry shader (lines) ÷ vertex shader, both on Vulkan",
        case: "native/gs-line",
        control: "native/vs-control",
    },
    Pair {
        heading: "Vulkan ÷ wgpu, the same vertex shader",
        case: "native/vs-control",
        control: "vertex/doubled",
    },
    Pair {
        heading: "compute every frame ÷ vertex shader, both on wgpu",
        case: "compute/per-frame",
        control: "vertex/doubled",
    },
];

/// A row for every view in which a pair was timed.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let mut rows = Vec::new();
    for scene in data.scenes() {
        for view in &scene.views {
            let ratios = PAIRS.map(|pair| ratio(data, view, pair));
            if ratios.iter().all(Option::is_none) {
                continue;
            }
            let mut cells = vec![Cell::name(format!("{}, {}", scene.name, view.name))];
            let why = "one of the two is not right or was not timed in this view";
            cells.extend(
                ratios
                    .iter()
                    .map(|ratio| data.ratio_cell(ratio.as_ref(), why)),
            );
            rows.push(Row::new(cells));
        }
    }
    if rows.is_empty() {
        return Vec::new();
    }
    let headings = PAIRS.iter().map(|pair| Heading::plain(pair.heading));
    vec![
        Block::section("One thing changed"),
        Block::Text(format!(
            "Ratios of {}: the first over the second, paired by process, with the 95 % interval where \
             there are processes enough; below 1 the first is faster. Both as they should be used, \
             with the full picture right.",
            data.run.clock().name()
        )),
        Block::Table(Table {
            headings: std::iter::once(Heading::plain("view"))
                .chain(headings)
                .collect(),
            rows,
            is_main: true,
            ..Table::default()
        }),
    ]
}

fn ratio(data: &Data<'_>, view: &View<'_>, pair: Pair) -> Option<Estimate> {
    let find = |wanted: &str| view.cases.iter().find(|case| name(case) == wanted);
    data.over(find(pair.case)?, find(pair.control)?)
}
