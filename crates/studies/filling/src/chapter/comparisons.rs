// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pairs of cases that differ in one thing, and one map in two scales.

use super::data::{Data, View, has_role, name};
use super::table::section;
use crate::keys::*;
use terrafill_plot::number::{figure, significant};
use terrafill_results::{Block, Case, Cell, Row, Table, exponent};

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

/// The same countries, coarse and fine, and the view that shows all of them.
const SCALES: [[&str; 2]; 2] = [["countries-110m", "globe"], ["countries-50m", "globe"]];

/// A row for every view in which a pair was timed.
pub(super) fn pairs(data: &Data<'_>) -> Vec<Block> {
    let of = |view: &View<'_>| {
        let find = |wanted: &str| view.cases.iter().find(|case| name(case) == wanted);
        let ratios = PAIRS.map(|(_, case, control)| data.timings.over(find(case)?, find(control)?));
        let why = "one of the two is not right or was not timed in this view";
        let cells = ratios
            .iter()
            .map(|ratio| data.timings.ratio_cell(ratio.as_ref(), why));
        let has_any = ratios.iter().any(Option::is_some);
        has_any.then(|| Row::named(Cell::name(view.title()), cells))
    };
    let headings = ["view"].into_iter().chain(PAIRS.map(|pair| pair.0));
    let text = format!(
        "Ratios of {}: the first over the second, paired by process, with the 95 % interval where there are \
         processes enough; below 1 the first is faster. Both as they should be used, with the full picture right.",
        data.run.clock().name()
    );
    let rows = data.views.iter().filter_map(of).collect();
    section("One thing changed", text, Table::of(headings, rows))
}

/// How fill time grows with vertices: a row for each technique that is right in both scales.
pub(super) fn scales(data: &Data<'_>) -> Vec<Block> {
    let of = |[scene, name]: [&str; 2]| {
        let mut views = data.views.iter();
        views.find(|view| view.scene == scene && view.name == name)
    };
    let [Some(few), Some(many)] = SCALES.map(of) else {
        return Vec::new();
    };
    let fills = |case: &&Case| {
        let other = many.cases.iter().find(|other| name(other) == name(case))?;
        let vertices = [case.value(VERTICES)?, other.value(VERTICES)?];
        let times = [
            data.timings.typical(case)?.middle,
            data.timings.typical(other)?.middle,
        ];
        let [of_few, of_many] = [*case, *other].map(|case| data.timings.replicates(case));
        let found = exponent(vertices, [&of_few, &of_many])?;
        let grown = [vertices, times].map(|[few, many]| format!("{} ×", significant(many / few)));
        let cells = grown.into_iter().chain([figure(&found)]);
        Some(Row::named(Cell::name(name(case)), cells.map(Cell::plain)))
    };
    let own = few.cases.iter().filter(|case| !has_role(case, "sweep"));
    let rows = own.filter_map(fills).collect();
    let [[few, view], [many, _]] = SCALES;
    let text = format!(
        "{many} over {few}, {view}: the same countries from the same eye. The exponent b of {} \
         = c · verticesᵇ, with its 95 % interval over resampled processes: 0 where pixels cost \
         everything, 1 where vertices do.",
        data.run.clock().name()
    );
    let headings = ["technique", "vertices", "time", "exponent"];
    let table = Table::of(headings, rows);
    section("Fill time against vertices", text, table)
}
