// SPDX-License-Identifier: MIT OR Apache-2.0
//! Controlled pairs: two cases that differ in one thing, as it should be used, in every view.

use crate::interval::{Interval, gain};
use crate::ladder::interval_text;
use crate::run_data::{RunData, ViewCases};

/// What is compared.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair {
    pub(crate) heading: &'static str,
    /// Its time is divided …
    case: &'static str,
    /// … by this one's.
    control: &'static str,
}

/// Techniques on one interface, one algorithm on two interfaces, and expansion against storage.
pub(crate) const PAIRS: [Pair; 4] = [
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

/// A view with each pair's ratio.
pub(crate) struct PairRow {
    pub(crate) name: String,
    pub(crate) cells: Vec<String>,
}

/// Rows of every view in which a pair was timed.
pub(crate) fn rows(data: &RunData) -> Vec<PairRow> {
    let mut rows = Vec::new();
    for scene in data.scenes() {
        for view in &scene.views {
            let ratios = PAIRS.map(|pair| ratio(data, view, pair));
            if ratios.iter().any(Option::is_some) {
                rows.push(PairRow {
                    name: format!("{}, {}", scene.name, view.name),
                    cells: ratios
                        .map(|ratio| ratio.map_or_else(|| "–".to_owned(), interval_text))
                        .into(),
                });
            }
        }
    }
    rows
}

fn ratio(data: &RunData, view: &ViewCases<'_>, pair: Pair) -> Option<Interval> {
    let find = |name: &str| {
        view.cases
            .iter()
            .find(|case| case.counts() && case.name() == name)
            .and_then(|case| data.frames.get(&case.key))
    };
    gain(find(pair.case)?, find(pair.control)?)
}
