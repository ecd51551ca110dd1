// SPDX-License-Identifier: MIT OR Apache-2.0
//! The drawing kit of a report's chapters: numbers as people read them, and plots as inline SVG that
//! takes text colour and background from the page.
//!
//! A chapter says what is drawn, such as [`WorkPrecision`] or [`RatioPlot`]; nothing here knows a
//! study. Text is measured by an estimate, since the reader's font is not known; labels therefore have
//! room to spare.

mod canvas;
mod courses;
mod error;
mod labels;
mod log_log;
pub mod number;
mod palette;
mod panels;
mod processes;
mod ratio;
mod reading;
mod scale;
mod sparkline;
mod steps;
mod work_precision;

pub use courses::{Course, Courses};
pub use error::PlotError;
pub use palette::{Palette, dark_rules};
pub use panels::{Arrangement, named_aside, panels};
pub use processes::{DOTS_FACTOR, TWO_GROUPS, dotted};
pub use ratio::{DOTS_OF_PROCESSES, RatioAxis, RatioGroup, RatioPlot, RatioRow};
pub use reading::Reading;
pub use scale::length;
pub use sparkline::Sparkline;
pub use steps::{Step, Steps};
pub use work_precision::{Curve, Point, PointStanding, ReferenceLine, Upwards, WorkPrecision};

/// Width of every plot, pixels.
pub(crate) const WIDTH_PX: f64 = 1080.0;

/// Longest label before its middle is left out.
const LABEL_CHARS: usize = 62;

/// A row's label as a plot has room for it.
fn label(text: &str) -> String {
    number::elided(text, LABEL_CHARS)
}

/// Width of the label column: as the longest label needs.
fn label_column<'a>(labels: impl IntoIterator<Item = &'a str>) -> f64 {
    let lengths = labels.into_iter().map(|text| label(text).chars().count());
    let longest = lengths.max().unwrap_or(0);
    longest as f64 * canvas::text_width("m", canvas::TEXT_PX) + 16.0
}
