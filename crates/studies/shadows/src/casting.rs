// SPDX-License-Identifier: MIT OR Apache-2.0
//! What rivals of shadow volumes are handed, and what they answer.

/// Twin of `Receivers` in `shared/receiver.wgsl`.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Receivers {
    /// Axes of the view over the tangents of half its fields.
    pub(crate) right: [f32; 4],
    pub(crate) up: [f32; 4],
    pub(crate) ahead: [f32; 4],
    pub(crate) to_light: [f32; 4],
    /// Pixels.
    pub(crate) size: [u32; 2],
    pub(crate) triangles: u32,
    pub(crate) near_m: f32,
    /// m a metre of depth.
    pub(crate) margin: f32,
    pub(crate) unused: [u32; 3],
}

/// What a rival is handed.
pub(crate) struct Casting {
    pub(crate) receivers: Receivers,
    /// x, y, z from the eye, m, and 1.
    pub(crate) places: Vec<[f32; 4]>,
    /// Corners, and which triangle of the mesh it is.
    pub(crate) triangles: Vec<[u32; 4]>,
}

/// 1 for a pixel in shadow.
pub(crate) fn mask_of(bytes: &[u8]) -> Vec<bool> {
    let words = bytes.as_chunks::<4>().0.iter();
    words.map(|word| u32::from_ne_bytes(*word) != 0).collect()
}
