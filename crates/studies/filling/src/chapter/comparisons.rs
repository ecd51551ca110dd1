// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pairs of cases that differ in one thing.

use super::data::{Data, ViewCases, name};
use super::table::section;
use terrafill_results::{Block, Cell, Row, Table};

/// Techniques on one interface, one algorithm on two interfaces, and expansion against storage: heading, the
/// case whose time is divided, and the one by whose.
const PAIRS: [(&str, &str, &str); 4] = [
    (
        "geometry shader (degenerate triangles) ÷ vertex shader, both on Vulkan",
        "native/gs-degenerate",
        "native/vs-control",
    ),
    (
        "geometry shader (lines) ÷ vertex shader, both on Vulkan",
        "native/gs-line",
        "native/vs-control",
    ),
    (
        "Vulkan ÷ wgpu, the same vertex shader",
        "native/vs-control",
        "vertex/doubled",
    ),
    (
        "compute every frame ÷ vertex shader, both on wgpu",
        "compute/per-frame",
        "vertex/doubled",
    ),
];

/// A row for every view in which a pair was timed.
pub(super) fn pairs(data: &Data<'_>) -> Vec<Block> {
    let of = |view: &ViewCases<'_>| {
        let find = |wanted: &str| view.cases.iter().find(|case| name(case) == wanted);
        let ratios = PAIRS.map(|(_, case, control)| data.timings.over(find(case)?, find(control)?));
        let why = "one of the two is not right or was not timed in this view";
        let cells = ratios
            .iter()
            .map(|ratio| data.timings.ratio_cell(ratio.as_ref(), why));
        let has_any = ratios.iter().any(Option::is_some);
        has_any.then(|| Row::named(Cell::name(view.title()), cells))
    };
    let headings = std::iter::once("view").chain(PAIRS.map(|pair| pair.0));
    let text = format!(
        "Ratios of {}: the first over the second, paired by process, with the 95 % interval where there are \
         processes enough; below 1 the first is faster. Both as they should be used, with the full picture right.",
        data.run.clock().name()
    );
    let rows = data.views.iter().filter_map(of).collect();
    section("One thing changed", text, Table::of(headings, rows))
}
