// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pairs of cases that differ in one thing. Two further tables compare one map in two scales, and volumes whose heights
//! are those of each view's surface with volumes of one range for the whole Earth.

use super::data::{Data, View, counter, has_role, name};
use super::rungs::Ladder;
use super::table::section;
use crate::keys::*;
use terrafill_plot::number::{count, figure, significant};
use terrafill_results::{Block, Case, Cell, Estimate, Row, Table, exponent};

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

/// The step of every ladder that measures global heights against the rung before it.
const WALLS_STEP: &str = "walls-global";

/// A row for every view in which a pair was timed.
pub(super) fn pairs(data: &Data<'_>) -> Vec<Block> {
    let of = |view: &View<'_>| {
        let find = |wanted: &str| view.cases.iter().find(|case| name(case) == wanted);
        let ratios = PAIRS.map(|(_, case, control)| data.over(find(case)?, find(control)?));
        row_of_ratios(data, view.title(), &ratios)
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

/// Nothing where there is no ratio at all.
pub(super) fn row_of_ratios(
    data: &Data<'_>,
    title: String,
    ratios: &[Option<Estimate>],
) -> Option<Row> {
    let why = "one of the two is not right or was not timed in this view";
    let cells = ratios
        .iter()
        .map(|ratio| data.ratio_cell(ratio.as_ref(), why));
    let has_any = ratios.iter().any(Option::is_some);
    has_any.then(|| Row::named(Cell::name(title), cells))
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
        let times = [data.typical(case)?.middle, data.typical(other)?.middle];
        let [of_few, of_many] = [*case, *other].map(|case| data.replicates(case));
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

/// What the walls' height costs: a row for every ladder that has both. The two fills differ in nothing else, the
/// mesh included.
pub(super) fn walls(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Vec<Block> {
    let both = |ladder: &Ladder<'_>| {
        let rung = ladder.step(WALLS_STEP)?;
        let (region, global) = (rung.before?, rung.case);
        let of = |figure: &dyn Fn(&Case) -> Option<u64>, why: &str| {
            let both = figure(region).zip(figure(global));
            Cell::or_absent(both.map(|(region, global)| over(region, global)), why)
        };
        let why = "one of the two is not right or was not timed";
        let uncounted = "the device does not count them";
        let cells = [
            data.ratio_cell(data.over(region, global).as_ref(), why),
            of(&|case| counter(case, STENCIL_FRAGMENTS), uncounted),
            of(&|case| counter(case, WALL_HEIGHT_M), WALL_HEIGHT_M.absent),
            of(&wrong_in_band, MISMATCHED_PX.absent),
        ];
        let is_right = region.counts() && global.counts();
        Some(Row::named(Cell::name(&ladder.title), cells).bad_if(!is_right))
    };
    let headings = [
        ("scene, view: technique", ""),
        (
            "time [95\u{a0}%]",
            "of the whole fill, paired by process; both pictures must be right",
        ),
        ("fragments of volumes", STENCIL_FRAGMENTS.meaning),
        ("tallest wall, m", WALL_HEIGHT_M.meaning),
        (
            "px that differ in the band",
            "mismatched_px − mismatched_px_outside_band",
        ),
    ];
    let text = "Volumes that reach as far as the surface does over each region in the view at hand, facets that \
         hang between their corners included (`wall-heights=region`), ÷ volumes from 12 km below the \
         ellipsoid to 12 km above it (`wall-heights=global`); below 1 lower walls are better. \
         `terrafill bench hills --ladder hills --technique vertex` measures \
         both on terrain.";
    let rows = ladders.iter().filter_map(both).collect();
    section("Lower walls", text, Table::of(headings, rows))
}

/// Pixels that differ from the reference beside its boundaries.
fn wrong_in_band(case: &Case) -> Option<u64> {
    let outside = counter(case, MISMATCHED_PX_OUTSIDE_BAND)?;
    counter(case, MISMATCHED_PX)?.checked_sub(outside)
}

/// Both figures, and their ratio where there is one.
fn over(region: u64, global: u64) -> String {
    let both = format!("{} ÷ {}", count(region), count(global));
    match global {
        0 => both,
        _ => format!("{both} = {}", significant(region as f64 / global as f64)),
    }
}
