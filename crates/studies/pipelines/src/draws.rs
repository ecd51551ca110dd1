// SPDX-License-Identifier: MIT OR Apache-2.0
//! What an opened way does, on whichever interface.

use terrafill_fill::{DeviceError, Picture};
use terrafill_results::Verdict;
use terrafill_vulkan::PassStatistics;

/// Times of a frame, milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Times {
    /// Process CPU time from sending until the device is done.
    pub(crate) cpu_ms: f64,
    /// Wall clock over the same span.
    pub(crate) wall_ms: f64,
    /// GPU clock of dispatch and draw.
    pub(crate) gpu_ms: Option<f64>,
}

impl Times {
    pub(crate) fn figures(self) -> Vec<(&'static str, f64)> {
        let mut figures = vec![
            ("pipeline_cpu_ms", self.cpu_ms),
            ("pipeline_wall_ms", self.wall_ms),
        ];
        figures.extend(self.gpu_ms.map(|ms| ("pipeline_gpu_ms", ms)));
        figures
    }
}

/// What the device counted; absent where it counts nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Counted {
    pub(crate) vertex_invocations: Option<u64>,
    pub(crate) geometry_invocations: Option<u64>,
    pub(crate) primitives: Option<u64>,
    pub(crate) fragments: Option<u64>,
}

impl Counted {
    /// Those that are known.
    pub(crate) fn figures(&self) -> impl Iterator<Item = (&'static str, f64)> + use<> {
        let counters = [
            ("pipeline_vertex_invocations", self.vertex_invocations),
            ("pipeline_geometry_invocations", self.geometry_invocations),
            ("pipeline_primitives", self.primitives),
        ];
        let known = counters.into_iter();
        known.filter_map(|(name, count)| Some((name, count? as f64)))
    }
}

impl From<PassStatistics> for Counted {
    fn from(of: PassStatistics) -> Self {
        Self {
            vertex_invocations: Some(of.vertex_shader_invocations),
            geometry_invocations: of.geometry_shader_invocations.filter(|count| *count > 0),
            primitives: Some(of.clipper_invocations),
            fragments: Some(of.fragment_shader_invocations),
        }
    }
}

/// A grid by one way, ready to be drawn.
pub(crate) trait Draws {
    /// Draws it and reads it back.
    fn draw(&mut self) -> Result<(Picture, Counted), DeviceError>;

    /// Sends what is sent each frame, draws, and waits.
    fn time(&mut self) -> Result<Times, DeviceError>;
}

/// A device, a stage or a limit that is not there is no defect.
pub(crate) fn verdict_of(error: &DeviceError) -> Verdict {
    match error {
        DeviceError::Unsupported { .. } | DeviceError::OverCapacity { .. } => {
            Verdict::skipped(error.to_string())
        }
        _ => Verdict::failed(error.to_string()),
    }
}
