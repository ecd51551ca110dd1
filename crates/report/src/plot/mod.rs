// SPDX-License-Identifier: MIT OR Apache-2.0
//! The plots, as inline SVG that takes text colour and background from the page.
//!
//! Text is measured by an estimate, since the reader's font is not known here; labels therefore have
//! room to spare.

mod bytes;
mod canvas;
mod error_time;
mod palette;
mod ratio;
mod scale;

pub(crate) use bytes::geometry_bytes;
pub(crate) use error_time::error_against_time;
pub(crate) use palette::{Palette, dark_rules};
pub(crate) use ratio::time_over_bound;

/// Width of every plot, pixels.
const WIDTH_PX: f64 = 1080.0;

/// Longest label before its middle is left out.
const LABEL_CHARS: usize = 62;

/// Width of the label column: the longest label, or what the limit allows.
fn label_column(labels: impl IntoIterator<Item = usize>) -> f64 {
    let longest = labels.into_iter().max().unwrap_or(0).min(LABEL_CHARS);
    longest as f64 * canvas::text_width("m", canvas::TEXT_PX) + 16.0
}
