// SPDX-License-Identifier: MIT OR Apache-2.0
//! How fill time grows with vertices: one map in two scales, seen by the same camera.

use crate::interval::{Interval, exponent};
use crate::number::{count, significant};
use crate::page::breakable;
use crate::run_data::{Case, RunData};

/// The same countries, coarse and fine.
const SCENES: [&str; 2] = ["countries-110m", "countries-50m"];

/// The view that shows all of them.
const VIEW: &str = "globe";

/// One technique in both scenes.
pub(crate) struct GrowthRow {
    pub(crate) name_parts: Vec<String>,
    pub(crate) cells: Vec<String>,
}

/// Scenes, view and rows; no rows when a run lacks one of the scenes.
pub(crate) struct GrowthTable {
    pub(crate) scenes: [&'static str; 2],
    pub(crate) view: &'static str,
    pub(crate) rows: Vec<GrowthRow>,
}

/// The table; `None` when nothing can be said.
pub(crate) fn table(data: &RunData) -> Option<GrowthTable> {
    let scenes = data.scenes();
    let of = |scene: &str| {
        let scene = scenes.iter().find(|found| found.name == scene)?;
        scene.views.iter().find(|view| view.name == VIEW)
    };
    let [few, many] = SCENES.map(of);
    let (few, many) = (few?, many?);
    let rows: Vec<GrowthRow> = few
        .cases
        .iter()
        .filter(|case| !case.is_sweep())
        .filter_map(|case| {
            let other = many
                .cases
                .iter()
                .find(|other| other.name() == case.name())?;
            row(case, other)
        })
        .collect();
    (!rows.is_empty()).then_some(GrowthTable {
        scenes: SCENES,
        view: VIEW,
        rows,
    })
}

fn row(few: &Case, many: &Case) -> Option<GrowthRow> {
    if !few.counts() || !many.counts() {
        return None;
    }
    let vertices = [few, many].map(|case| case.value(|row| row.vertices));
    let [Some(of_few), Some(of_many)] = vertices else {
        return None;
    };
    let found = exponent(
        [of_few as f64, of_many as f64],
        [&few.fill_cpu_ms, &many.fill_cpu_ms],
    )?;
    let time = |case: &Case| {
        case.fill_cpu
            .map_or_else(|| "–".to_owned(), |fill| significant(fill.median))
    };
    Some(GrowthRow {
        name_parts: breakable(&few.name()),
        cells: vec![
            count(of_few),
            count(of_many),
            time(few),
            time(many),
            text(found),
        ],
    })
}

fn text(exponent: Interval) -> String {
    format!(
        "{} [{}–{}]",
        significant(exponent.middle),
        significant(exponent.low),
        significant(exponent.high)
    )
}
