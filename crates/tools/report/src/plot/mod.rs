// SPDX-License-Identifier: MIT OR Apache-2.0
//! The plots, as inline SVG that takes text colour and background from the page.
//!
//! Text is measured by an estimate, since the reader's font is not known here; labels therefore have
//! room to spare.

mod bytes;
mod canvas;
mod error_time;
mod growth;
mod labels;
mod log_log;
mod memory;
mod palette;
mod precision;
mod ratio;
mod scale;
mod steps;
mod subdivision;
mod work_precision;

pub(crate) use bytes::geometry_bytes;
pub(crate) use error_time::error_against_time;
pub(crate) use growth::growth;
pub(crate) use memory::bytes_over_regions;
pub(crate) use palette::{Palette, dark_rules};
pub(crate) use precision::precision;
pub(crate) use ratio::{ratio, time_over_bound};
pub(crate) use steps::ladder_steps;
pub(crate) use subdivision::subdivision;
pub(crate) use work_precision::{Curve, Point, Reading, ReferenceLine, Standing};

use crate::number;
use crate::run_data::Case;

/// Width of every plot, pixels.
const WIDTH_PX: f64 = 1080.0;

/// Longest label before its middle is left out.
const LABEL_CHARS: usize = 62;

/// A case's name as a plot has room for it: the knob, in short, after the rest, where cutting a long
/// name leaves it.
fn label(case: &Case) -> String {
    let label = match case.named_knob_m() {
        Some(knob) => format!("{} · {}", case.series(), scale::length(knob)),
        None => case.name(),
    };
    number::elided(&label, LABEL_CHARS)
}

/// Width of the label column: as the longest label needs.
fn label_column(labels: impl IntoIterator<Item = String>) -> f64 {
    let lengths = labels.into_iter().map(|label| label.chars().count());
    let longest = lengths.max().unwrap_or(0);
    longest as f64 * canvas::text_width("m", canvas::TEXT_PX) + 16.0
}
