// SPDX-License-Identifier: MIT OR Apache-2.0
//! What opened data does, on whichever interface: it is drawn, counted and timed.

use crate::divided::{Divided, TEXELS, VERTEX_BYTES};
use crate::judge::number;
use crate::place::{Data, Shape};
use glam::DVec2;
use std::ops::Range;
use std::sync::LazyLock;
use terrafill_contract::{CpuStopwatch, DeviceError, Picture};
use terrafill_study::Figures;

/// Data on a device.
pub(crate) trait Draws {
    /// Sends constants, draws, and waits; gives the GPU's time.
    fn frame(&mut self) -> Result<Option<f64>, DeviceError>;

    /// What was drawn.
    fn read(&self) -> Result<Picture, DeviceError>;

    /// Sends vertices of the same data, divided otherwise.
    fn divide(&mut self, divided: &Divided) -> Result<(), DeviceError>;

    /// Samples of the data that passed the depth test, by a precise query.
    fn count(&mut self) -> Result<u64, DeviceError>;
}

/// Draws a frame and takes its times.
pub(crate) fn time(draws: &mut dyn Draws) -> Result<Figures, DeviceError> {
    let watch = CpuStopwatch::start();
    let gpu_ms = draws.frame()?;
    let mut figures = vec![
        ("decal_cpu_ms", watch.cpu_ms()),
        ("decal_wall_ms", watch.wall_ms()),
    ];
    figures.extend(gpu_ms.map(|ms| ("decal_gpu_ms", ms)));
    Ok(figures)
}

/// The shader of a draw.
pub(crate) fn shader(divided: &Divided) -> &'static str {
    match (divided.data.shape, divided.is_tested) {
        (Shape::Decal(_), false) => "decals/decal.wgsl",
        (Shape::Decal(_), true) => "decals/decal_tested.wgsl",
        (Shape::Line(_), false) => "decals/line.wgsl",
        (Shape::Line(_), true) => "decals/line_tested.wgsl",
    }
}

/// Ranges of vertices, a draw each: the body where depth is tested, and then the data.
pub(crate) fn ranges(divided: &Divided) -> Vec<Range<u32>> {
    let first = if divided.is_tested { 3 } else { 0 };
    let count = u32::try_from(3 * divided.triangles()).unwrap_or(u32::MAX - first);
    let body = divided.is_tested.then_some(0..first);
    let data = std::iter::once(first..first + count);
    body.into_iter().chain(data).collect()
}

/// Bytes of vertices that are sent once.
pub(crate) fn sent_bytes(divided: &Divided) -> usize {
    let vertices = ranges(divided).last().map_or(0, |range| range.end as usize);
    vertices * VERTEX_BYTES
}

/// Texels that say their own address, row by row from the decal's corner: the same for all data.
pub(crate) static ADDRESSES: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let decal = Data::square(DVec2::ZERO, 1.0).shape;
    let all = (0..TEXELS).flat_map(|y| (0..TEXELS).map(move |x| [x, y]));
    // Whole numbers up to 2²⁰.
    all.map(|texel| number(decal, texel) as f32).collect()
});
