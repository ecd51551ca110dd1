// SPDX-License-Identifier: MIT OR Apache-2.0
//! Frames per second as published in 2007, one figure a case, from which ratios are made.
//!
//! Patidar, Bhattacharjee, Singh and Narayanan, sections 2 and 3.1. The window, the camera and how
//! vertices were sent are not stated there, so no time of theirs can stand beside one of ours; a ratio
//! within one of their tables can.

/// A card of the first table.
pub(crate) const CARDS: [&str; 3] = ["6600 GT", "7950 GX2", "8800 GTX"];

/// A row of the grid table: for each card sent points, sent strips, fetched points; and triangles by the
/// geometry shader, which the last card alone has.
pub(crate) struct GridRow {
    pub(crate) cells: u32,
    pub(crate) fps: [[f64; 3]; 3],
    pub(crate) geometry_fps: f64,
}

pub(crate) const GRIDS: [GridRow; 4] = [
    GridRow {
        cells: 256,
        fps: [
            [259.0, 155.0, 200.0],
            [370.0, 180.0, 740.0],
            [705.0, 374.0, 1851.0],
        ],
        geometry_fps: 731.0,
    },
    GridRow {
        cells: 512,
        fps: [
            [65.0, 39.0, 80.0],
            [94.0, 50.0, 215.0],
            [177.0, 98.0, 905.0],
        ],
        geometry_fps: 284.0,
    },
    GridRow {
        cells: 1_024,
        fps: [[17.0, 10.0, 23.0], [24.0, 13.0, 59.0], [44.0, 24.0, 261.0]],
        geometry_fps: 90.0,
    },
    GridRow {
        cells: 2_048,
        fps: [[5.0, 3.0, 6.0], [6.0, 3.0, 15.0], [13.0, 7.0, 68.0]],
        geometry_fps: 27.0,
    },
];

/// A geometry image of 257 × 257 on the 8800 GTX: as points, and as triangles by the geometry shader.
pub(crate) const IMAGE_FPS: [f64; 2] = [2_281.0, 976.0];
/// Its texels along a side.
pub(crate) const IMAGE_TEXELS: u32 = 257;

/// A row of the amplification table, on the 8800 GTX: for 1, 4 and 16 cells a point, points sent each
/// frame and points in a buffer.
pub(crate) struct AmplificationRow {
    pub(crate) cells: u32,
    pub(crate) sent_fps: [f64; 3],
    pub(crate) stored_fps: [f64; 3],
}

pub(crate) const AMPLIFICATION: [AmplificationRow; 2] = [
    AmplificationRow {
        cells: 512,
        sent_fps: [203.0, 91.0, 21.0],
        stored_fps: [213.0, 91.0, 21.0],
    },
    AmplificationRow {
        cells: 1_024,
        sent_fps: [51.0, 23.0, 6.0],
        stored_fps: [60.0, 23.0, 6.0],
    },
];
