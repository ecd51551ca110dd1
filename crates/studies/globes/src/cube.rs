// SPDX-License-Identifier: MIT OR Apache-2.0
//! Directions and the faces of a cube map that they meet.

use glam::DVec3;

/// Direction of a place, −1 … 1 both ways, on a face of a cube in WebGPU's order: +x, −x, +y, −y, +z, −z.
pub(crate) fn on_cube(face: u32, [s, t]: [f64; 2]) -> DVec3 {
    let direction = match face {
        0 => [1.0, -t, -s],
        1 => [-1.0, -t, s],
        2 => [s, 1.0, t],
        3 => [s, -1.0, -t],
        4 => [s, -t, 1.0],
        _ => [-s, -t, -1.0],
    };
    DVec3::from(direction)
}

/// A direction's parts along a face's sides and out of it; `globes/spiral.wgsl` has the same.
pub(crate) fn along_face(face: u32, d: DVec3) -> [f64; 3] {
    match face {
        0 => [-d.z, -d.y, d.x],
        1 => [d.z, -d.y, -d.x],
        2 => [d.x, d.z, d.y],
        3 => [d.x, -d.z, -d.y],
        4 => [d.x, -d.y, d.z],
        _ => [-d.x, -d.y, -d.z],
    }
}

/// The face that a direction meets.
pub(crate) fn face_of(d: DVec3) -> u32 {
    let size = d.abs();
    let (axis, value) = if size.x >= size.y && size.x >= size.z {
        (0, d.x)
    } else if size.y >= size.z {
        (2, d.y)
    } else {
        (4, d.z)
    };
    axis + u32::from(value < 0.0)
}
