// SPDX-License-Identifier: MIT OR Apache-2.0
//! Published figures of the best-known web globe, to lay ours beside.
//!
//! Natural Earth countries on CesiumJS's globe at the three cameras that the scenes of the same
//! names use. `volumes` is its `GroundPrimitive` (stencil volumes, one per polygon), `lookup` its
//! newer world-cell path, which looks a pixel's edges up in a grid instead of using the stencil.

use super::data::{Data, View, counter, distinct, name};
use super::table::{part, plain_figures, row};
use crate::keys::{FILL_CPU_MS, GEOMETRY_BYTES};
use terrafill_plot::number::{bytes, significant};
use terrafill_results::{Block, Cell, Row, sample_spread};

/// Where all figures of this module come from, in the words printed under the table.
const SOURCE: &str = "CesiumJS 1.145, llvmpipe, 1024², same kind of machine; \
    process CPU ms of shown minus hidden";

/// Image side of those measurements, pixels.
const IMAGE_SIDE_PX: u32 = 1024;

/// The software driver of those measurements; ratios across drivers would say nothing.
const DRIVER: &str = "llvmpipe";

/// The views that were measured.
const VIEWS: [&str; 3] = ["globe", "fill", "horizon"];

/// Scene of the same regions here, technique, CPU time of the process for the fill of a frame in each of
/// [`VIEWS`] in milliseconds, and bytes on the GPU.
type Published = (&'static str, &'static str, [f64; 3], u64);

const PUBLISHED: [Published; 4] = [
    (
        "countries-110m",
        "volumes",
        [361.0, 66.0, 119.0],
        13_900_000,
    ),
    ("countries-110m", "lookup", [120.0, 47.0, 53.0], 510_000),
    ("countries-50m", "volumes", [743.0, 73.0, 178.0], 59_800_000),
    ("countries-50m", "lookup", [133.0, 50.0, 61.0], 3_340_000),
];

/// The published figures of a scene beside ours; nothing for a scene without them.
///
/// Ratios are given only where they say something: on the driver and at the size of those
/// measurements. Both sides are process CPU time, whatever the run's clock.
pub(super) fn blocks(data: &Data<'_>, views: &[View<'_>]) -> Vec<Block> {
    let scene = views[0].scene;
    let published = PUBLISHED.into_iter().filter(|row| row.0 == scene);
    let published: Vec<Published> = published.collect();
    let has_a_view = views.iter().any(|view| VIEWS.contains(&view.name));
    if published.is_empty() || !has_a_view {
        return Vec::new();
    }
    let is_comparable = is_comparable(data);
    let theirs = published.iter().map(|(_, method, fill_cpu_ms, held)| {
        let times = fill_cpu_ms.map(|ms| Cell::plain(format!("{} ms", significant(ms))));
        let cells = times.into_iter().chain([Cell::plain(bytes(*held))]);
        row(Cell::name(format!("CesiumJS, {method}")), cells)
    });
    let cases = views.iter().flat_map(|view| &view.cases);
    let names = distinct(cases.map(|case| name(case))).into_iter();
    let ours = names.map(|name| our_row(views, &name, &published, is_comparable));
    let caveat = match is_comparable {
        true => String::new(),
        false => format!(
            " This run was not made on {DRIVER} at {IMAGE_SIDE_PX} × {IMAGE_SIDE_PX} px, so no ratios \
             are given."
        ),
    };
    let [globe, fill, horizon] = VIEWS;
    let headings = ["technique", globe, fill, horizon, "geometry bytes"];
    vec![
        part(format!("{scene} beside the best-known web globe")),
        Block::Table(plain_figures(&headings, theirs.chain(ours).collect())),
        Block::Remark(format!(
            "CPU time of the process per frame for the fill. After the dot: how many times less than \
             CesiumJS's volumes / its lookup (below 1: more). Published figures: {SOURCE}.{caveat}"
        )),
    ]
}

fn is_comparable(data: &Data<'_>) -> bool {
    let e = &data.run.environment;
    let named = [&e.gpu, &e.driver, &e.driver_info];
    named.iter().any(|text| text.contains(DRIVER))
        && (e.width, e.height) == (IMAGE_SIDE_PX, IMAGE_SIDE_PX)
}

/// Our figure for each published view and the bytes, each followed by how many times less it is
/// than each published technique's.
fn our_row(views: &[View<'_>], wanted: &str, published: &[Published], is_comparable: bool) -> Row {
    let of_view = |name_of_view: &str| {
        let view = views.iter().find(|view| view.name == name_of_view)?;
        view.cases.iter().find(|case| name(case) == wanted).copied()
    };
    let ratios = |ours: f64, theirs: &dyn Fn(&Published) -> f64| {
        let texts = published.iter();
        let texts = texts.map(|row| format!("{} ×", significant(theirs(row) / ours)));
        match is_comparable && ours > 0.0 {
            true => format!(" · {}", texts.collect::<Vec<_>>().join(" / ")),
            false => String::new(),
        }
    };
    let times = VIEWS
        .iter()
        .enumerate()
        .map(|(index, view)| match of_view(view) {
            None => Cell::absent("not measured in this view"),
            Some(case) if !case.counts() => Cell::absent(case.outcome.name()),
            Some(case) => {
                let ours = sample_spread(case, FILL_CPU_MS).map(|ms| ms.median);
                let text = ours.map(|ms| {
                    let ratios = ratios(ms, &|(.., times, _)| times[index]);
                    format!("{} ms{ratios}", significant(ms))
                });
                Cell::or_absent(text, "not timed")
            }
        });
    let held = VIEWS
        .iter()
        .filter_map(|view| counter(of_view(view)?, GEOMETRY_BYTES));
    let held = held.max().map(|held| {
        let ratios = ratios(held as f64, &|(.., theirs)| *theirs as f64);
        format!("{}{ratios}", bytes(held))
    });
    let held = Cell::or_absent(held, "not counted");
    row(Cell::name(wanted), times.chain([held]))
}
