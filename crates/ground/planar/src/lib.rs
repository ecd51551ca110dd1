// SPDX-License-Identifier: MIT OR Apache-2.0
//! Plane geometry that meshing is built on: exact predicates, where edges cross, trees of boxes, and a
//! constrained Delaunay triangulation. It knows places and edges, no regions and no bodies.

pub mod box_tree;
pub mod delaunay;
pub mod intersection;
pub mod sweep;

/// Longitude and latitude, degrees.
pub type Degrees = [f64; 2];

/// Same result for an edge and its reverse.
pub fn in_order(start: Degrees, end: Degrees) -> (Degrees, Degrees) {
    if (end[0], end[1]) < (start[0], start[1]) {
        (end, start)
    } else {
        (start, end)
    }
}

/// A vertex index as meshes store it.
#[allow(
    clippy::cast_possible_truncation,
    reason = "four billion vertices need 64 GiB for their positions alone"
)]
pub fn index_u32(index: usize) -> u32 {
    debug_assert!(index < u32::MAX as usize);
    index as u32
}

/// The nearest number that a device has. Where rounding to it is meant, this says so, and no cast does.
#[must_use]
#[allow(clippy::cast_possible_truncation, reason = "rounding is the purpose")]
pub fn nearest_f32(value: f64) -> f32 {
    value as f32
}
