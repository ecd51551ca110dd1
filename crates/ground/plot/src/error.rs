// SPDX-License-Identifier: MIT OR Apache-2.0
//! How drawing can fail.

/// A plot could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("plot {plot:?}: {message}")]
pub struct PlotError {
    /// Which plot.
    pub plot: String,
    /// Why.
    pub message: String,
}

impl From<PlotError> for terrafill_results::ChapterError {
    fn from(error: PlotError) -> Self {
        Self::Block {
            what: format!("plot {:?}", error.plot),
            message: error.message,
        }
    }
}
