// SPDX-License-Identifier: MIT OR Apache-2.0
//! What opened ways do, on whichever interface: they draw, count and take time.

use terrafill_contract::{CpuStopwatch, DeviceError, Picture, numbers_hash};
use terrafill_shapes::rays::Judged;
use terrafill_study::Figures;
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
    /// Until now.
    pub(crate) fn since(watch: &CpuStopwatch, gpu_ms: Option<f64>) -> Self {
        Self {
            cpu_ms: watch.cpu_ms(),
            wall_ms: watch.wall_ms(),
            gpu_ms,
        }
    }

    pub(crate) fn figures(self) -> Figures {
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

impl From<Option<PassStatistics>> for Counted {
    fn from(of: Option<PassStatistics>) -> Self {
        of.map_or_else(Self::default, |of| Self {
            vertex_invocations: Some(of.vertex_shader_invocations),
            geometry_invocations: of.geometry_shader_invocations.filter(|count| *count > 0),
            primitives: Some(of.clipper_invocations),
        })
    }
}

/// Hash of a picture's numbers and of what was counted and is judged with them.
pub(crate) fn shown_hash(numbers: &[u32], counted: &Counted) -> String {
    let primitives = counted.primitives.map(|count| format!("-{count}"));
    numbers_hash(numbers) + &primitives.unwrap_or_default()
}

/// What a judged picture says in the study's words.
pub(crate) trait JudgedFigures {
    /// What is counted of every picture.
    fn figures(&self) -> Figures;
    /// What is wrong with it; nothing of what is right.
    ///
    /// - `expected`: primitives that reach clipping
    fn reason(&self, counted: &Counted, expected: u64) -> String;
}

impl JudgedFigures for Judged {
    fn figures(&self) -> Figures {
        vec![
            ("pipeline_mismatched_px", self.mismatched as f64),
            ("pipeline_band_px", self.in_band as f64),
            ("pipeline_shown_px", self.shown as f64),
        ]
    }

    fn reason(&self, counted: &Counted, expected: u64) -> String {
        match counted.primitives {
            _ if self.mismatched > 0 => {
                let pixels = self.mismatched;
                format!("{pixels} pixels show what the reference does not allow")
            }
            _ if self.shown == 0 => "it shows nothing".to_owned(),
            Some(found) if found != expected => {
                format!("{found} primitives reached clipping, expected {expected}")
            }
            _ => String::new(),
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

/// What a frame of layers and of the picture that looks them up showed.
#[derive(Debug)]
pub(crate) struct Looked {
    pub(crate) picture: Picture,
    /// Of all layers, one after the other.
    pub(crate) depths: Vec<f32>,
    /// Of the layers.
    pub(crate) counted: Counted,
}

/// Times of a frame, and of its layers alone.
pub(crate) struct FrameTimes {
    pub(crate) all: Times,
    pub(crate) maps: Times,
}

impl FrameTimes {
    pub(crate) fn figures(&self) -> Figures {
        let mut figures = self.all.figures();
        figures.push(("lights_maps_cpu_ms", self.maps.cpu_ms));
        figures.extend(self.maps.gpu_ms.map(|ms| ("lights_maps_gpu_ms", ms)));
        figures
    }
}

/// Layers and their picture on a device.
pub(crate) trait LooksUp {
    fn draw(&mut self) -> Result<Looked, DeviceError>;
    fn time(&mut self) -> Result<FrameTimes, DeviceError>;
    /// Of a frame: those of the layers and that of the picture.
    fn passes(&self) -> usize;
    /// Of all layers.
    fn bytes(&self) -> u64;
}

/// How often two lists differ; places that one of them lacks differ.
pub(crate) fn differing<T: PartialEq>(one: &[T], other: &[T]) -> usize {
    let differ = one.iter().zip(other).filter(|(a, b)| a != b).count();
    differ + one.len().abs_diff(other.len())
}

/// How many there are: no list here is longer than a device can count.
pub(crate) fn count<T>(items: &[T]) -> u32 {
    u32::try_from(items.len()).unwrap_or(u32::MAX)
}

/// Depths bit by bit.
pub(crate) fn bits(depths: &[f32]) -> Vec<u32> {
    depths.iter().map(|depth| depth.to_bits()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_that_differ_in_a_bit_or_in_length_are_told_apart() {
        let of = |one: &[f32], other: &[f32]| differing(&bits(one), &bits(other));
        assert_eq!(of(&[0.0, 1.0], &[0.0, 1.0]), 0);
        assert_eq!(of(&[0.0, 1.0], &[-0.0, 1.0]), 1);
        assert_eq!(of(&[0.0, 1.0], &[0.0]), 1);
    }
}
