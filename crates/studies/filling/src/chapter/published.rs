// SPDX-License-Identifier: MIT OR Apache-2.0
//! Published figures of the best-known web globe, to lay ours beside.
//!
//! Natural Earth countries on CesiumJS's globe at the three cameras that the scenes of the same
//! names use. `volumes` is its `GroundPrimitive` (stencil volumes, one per polygon), `lookup` its
//! newer world-cell path, which looks a pixel's edges up in a grid instead of using the stencil.

use super::data::{Data, Scene, counter, distinct, name};
use crate::keys::{FILL_CPU_MS, GEOMETRY_BYTES};
use terrafill_plot::number::{bytes, significant};
use terrafill_results::{Block, Cell, Heading, Row, Table, sample_spread};

/// Where all figures of this module come from, in the words printed under the table.
const SOURCE: &str = "CesiumJS 1.145, llvmpipe, 1024², same kind of machine; \
    process CPU ms of shown minus hidden";

/// Image side of those measurements, pixels.
const IMAGE_SIDE_PX: u32 = 1024;

/// The software driver of those measurements; ratios across drivers would say nothing.
const DRIVER: &str = "llvmpipe";

/// The views that were measured, in the order of [`Published::fill_cpu_ms`].
const VIEWS: [&str; 3] = ["globe", "fill", "horizon"];

/// One technique on one scene.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Published {
    /// Scene of the same regions here.
    scene: &'static str,
    /// Technique.
    method: &'static str,
    /// Cost of the fill per frame for each of [`VIEWS`], CPU time of the process, milliseconds.
    fill_cpu_ms: [f64; 3],
    /// Bytes on the GPU.
    bytes: u64,
}

/// Every published row.
const PUBLISHED: [Published; 4] = [
    Published {
        scene: "countries-110m",
        method: "volumes",
        fill_cpu_ms: [361.0, 66.0, 119.0],
        bytes: 13_900_000,
    },
    Published {
        scene: "countries-110m",
        method: "lookup",
        fill_cpu_ms: [120.0, 47.0, 53.0],
        bytes: 510_000,
    },
    Published {
        scene: "countries-50m",
        method: "volumes",
        fill_cpu_ms: [743.0, 73.0, 178.0],
        bytes: 59_800_000,
    },
    Published {
        scene: "countries-50m",
        method: "lookup",
        fill_cpu_ms: [133.0, 50.0, 61.0],
        bytes: 3_340_000,
    },
];

/// The published rows for `scene`.
fn of_scene(scene: &str) -> Vec<Published> {
    PUBLISHED
        .into_iter()
        .filter(|row| row.scene == scene)
        .collect()
}

/// The published figures of a scene beside ours; nothing for a scene without them.
///
/// Ratios are given only where they say something: on the driver and at the size of those
/// measurements. Both sides are process CPU time, whatever the run's clock.
pub(super) fn blocks(data: &Data<'_>, scene: &Scene<'_>) -> Vec<Block> {
    let published = of_scene(scene.name);
    let has_a_view = scene.views.iter().any(|view| VIEWS.contains(&view.name));
    if published.is_empty() || !has_a_view {
        return Vec::new();
    }
    let is_comparable = is_comparable(data);
    let mut rows: Vec<Row> = published
        .iter()
        .map(|row| {
            let mut cells = vec![Cell::name(format!("CesiumJS, {}", row.method))];
            let times = row.fill_cpu_ms.iter();
            cells.extend(times.map(|ms| Cell::plain(format!("{} ms", significant(*ms)))));
            cells.push(Cell::plain(bytes(row.bytes)));
            Row::new(cells)
        })
        .collect();
    let cases = scene.views.iter().flat_map(|view| &view.cases);
    let names = distinct(cases.map(|case| name(case)));
    rows.extend(
        names
            .iter()
            .map(|name| our_row(scene, name, &published, is_comparable)),
    );
    let caveat = match is_comparable {
        true => String::new(),
        false => format!(
            " This run was not made on {DRIVER} at {IMAGE_SIDE_PX} × {IMAGE_SIDE_PX} px, so no ratios \
             are given."
        ),
    };
    let views = VIEWS.map(Heading::plain);
    vec![
        Block::Heading {
            level: 4,
            text: format!("{} beside the best-known web globe", scene.name),
        },
        Block::Table(Table {
            headings: [Heading::plain("technique")]
                .into_iter()
                .chain(views)
                .chain([Heading::plain("geometry bytes")])
                .collect(),
            rows,
            ..Table::default()
        }),
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
fn our_row(scene: &Scene<'_>, wanted: &str, published: &[Published], is_comparable: bool) -> Row {
    let of_view = |view: &str| {
        let view = scene.views.iter().find(|found| found.name == view)?;
        view.cases.iter().find(|case| name(case) == wanted).copied()
    };
    let ratios = |theirs: Vec<f64>, ours: f64| {
        let texts = theirs
            .iter()
            .map(|theirs| format!("{} ×", significant(theirs / ours)));
        match is_comparable && ours > 0.0 {
            true => format!(" · {}", texts.collect::<Vec<_>>().join(" / ")),
            false => String::new(),
        }
    };
    let mut cells = vec![Cell::name(wanted)];
    for (index, view) in VIEWS.iter().enumerate() {
        cells.push(match of_view(view) {
            None => Cell::absent("not measured in this view"),
            Some(case) if !case.counts() => Cell::absent(case.outcome.name()),
            Some(case) => {
                let ours = sample_spread(case, FILL_CPU_MS).map(|ms| ms.median);
                let text = ours.map(|ms| {
                    let theirs = published.iter().map(|row| row.fill_cpu_ms[index]).collect();
                    format!("{} ms{}", significant(ms), ratios(theirs, ms))
                });
                Cell::or_absent(text, "not timed")
            }
        });
    }
    let held = VIEWS
        .iter()
        .filter_map(|view| counter(of_view(view)?, GEOMETRY_BYTES));
    let text = held.max().map(|held| {
        let theirs = published.iter().map(|row| row.bytes as f64).collect();
        format!("{}{}", bytes(held), ratios(theirs, held as f64))
    });
    cells.push(Cell::or_absent(text, "not counted"));
    Row::new(cells)
}
