// SPDX-License-Identifier: MIT OR Apache-2.0
//! The height grid that is drawn, its camera, and both as a device reads them.
//!
//! Metres; x along columns, y along rows, z up. The field is analytic, two waves of 1 km and 250 m, so
//! that every size shows the same ground.

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec2, DVec3, DVec4};
use std::f64::consts::TAU;

/// A side of the square of ground.
const SIDE_M: f64 = 2_000.0;
/// Tangent of half the field of view, either way: 60° hold the whole square.
const TAN_HALF_VIEW: f64 = 0.577_350_269_189_625_8;
/// Distance of the near plane: nothing is nearer.
pub const NEAR_M: f64 = 1.0;
const EYE: DVec3 = DVec3::new(930.0, -1_500.0, 1_200.0);
const TARGET: DVec3 = DVec3::new(1_000.0, 600.0, 0.0);

/// The nearest number that a device can read.
#[allow(clippy::cast_possible_truncation, reason = "rounding is the purpose")]
pub fn nearest(value: f64) -> f32 {
    value as f32
}

/// Heights of (cells + 1)² vertices, so that no cell reaches beyond the grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// A side.
    pub cells: u32,
    /// A side, metres.
    pub side_m: f64,
    /// Metres, row by row, as the device gets them.
    pub heights: Vec<f32>,
}

impl Grid {
    /// The square of ground with so many cells a side.
    #[must_use]
    pub fn new(cells: u32) -> Self {
        let step_m = SIDE_M / f64::from(cells);
        let vertices = (0..=cells).flat_map(|row| (0..=cells).map(move |column| (column, row)));
        let height = |(column, row)| {
            let (x, y) = (f64::from(column) * step_m, f64::from(row) * step_m);
            let wave = |length: f64| (TAU * x / length).sin() * (TAU * y / length + 0.3).sin();
            nearest(100.0 * wave(1_000.0) + 10.0 * wave(250.0))
        };
        Self {
            cells,
            side_m: SIDE_M,
            heights: vertices.map(height).collect(),
        }
    }

    /// A side of a cell, metres.
    #[must_use]
    pub fn step_m(&self) -> f64 {
        self.side_m / f64::from(self.cells)
    }

    /// Where the height of a vertex is.
    #[must_use]
    pub fn index(&self, column: u32, row: u32) -> usize {
        row as usize * (self.cells as usize + 1) + column as usize
    }

    /// Column, row and height of a vertex, as they are sent.
    pub fn vertex(&self, column: u32, row: u32) -> [f32; 3] {
        let height = self.heights[self.index(column, row)];
        [column as f32, row as f32, height]
    }
}

/// From where the grid is seen: an eye and the axes of the screen.
#[derive(Debug, Clone, Copy)]
pub struct GridCamera {
    /// Metres.
    pub eye: DVec3,
    /// Unit vector along the rows of the picture.
    pub right: DVec3,
    /// Unit vector up its columns.
    pub up: DVec3,
    /// Unit vector into the picture.
    pub forward: DVec3,
    /// Tangent of half the field of view, either way.
    pub tan_half: f64,
}

impl Default for GridCamera {
    fn default() -> Self {
        Self::new()
    }
}

impl GridCamera {
    /// The view that holds the whole square of ground.
    #[must_use]
    pub fn new() -> Self {
        Self::looking(EYE, TARGET, TAN_HALF_VIEW)
    }

    /// From an eye to a target that is not straight above or below it, z up.
    pub fn looking(eye: DVec3, target: DVec3, tan_half: f64) -> Self {
        let forward = (target - eye).normalize();
        let right = forward.cross(DVec3::Z).normalize();
        Self {
            eye,
            right,
            up: right.cross(forward),
            forward,
            tan_half,
        }
    }

    /// Of the ray through a place of a picture of this size; its part along the view's axis is 1.
    pub fn direction(&self, at_px: DVec2, size: [u32; 2]) -> DVec3 {
        let [width, height] = size.map(f64::from);
        let across = self.tan_half * (2.0 * at_px.x / width - 1.0);
        let upwards = self.tan_half * (1.0 - 2.0 * at_px.y / height);
        self.forward + self.right * across + self.up * upwards
    }

    /// A place on a picture of this size, pixels, and its distance along the view's axis.
    pub fn project(&self, place: DVec3, size: [u32; 2]) -> (DVec2, f64) {
        let from_eye = place - self.eye;
        let away = from_eye.dot(self.forward);
        let [width, height] = size.map(f64::from);
        let across = from_eye.dot(self.right) / (away * self.tan_half);
        let upwards = from_eye.dot(self.up) / (away * self.tan_half);
        let at = DVec2::new(0.5 * width * (1.0 + across), 0.5 * height * (1.0 - upwards));
        (at, away)
    }

    /// Clip space from metres, reversed depth with the far plane at infinity.
    pub fn clip_from_world(&self) -> DMat4 {
        let axes = [self.right, self.up, -self.forward];
        let rows = axes.map(|axis| axis.extend(-axis.dot(self.eye)));
        let view_from_world = DMat4::from_cols(rows[0], rows[1], rows[2], DVec4::W).transpose();
        let scale = self.tan_half.recip();
        let clip_from_view = DMat4::from_cols(
            DVec4::X * scale,
            DVec4::Y * scale,
            DVec4::NEG_W,
            DVec4::Z * NEAR_M,
        );
        clip_from_view * view_from_world
    }
}

/// Twin of `GridConstants` in `shared/cells.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct GridConstants {
    /// Clip space of a step along a row.
    pub column: [f32; 4],
    /// Of a step along a column.
    pub row: [f32; 4],
    /// Of a metre upwards.
    pub height: [f32; 4],
    /// Of the first vertex at height 0.
    pub origin: [f32; 4],
    /// A side of the grid.
    pub cells: u32,
    /// A side of a block; the grid's own where it is one.
    pub block_cells: u32,
    /// Zeros.
    pub padding: [u32; 2],
}

impl GridConstants {
    /// Of a grid in the view that holds all of it.
    #[must_use]
    pub fn new(grid: &Grid) -> Self {
        let clip = GridCamera::new().clip_from_world();
        let step_m = grid.step_m();
        let column = |of: DVec4| of.as_vec4().to_array();
        Self {
            column: column(clip.x_axis * step_m),
            row: column(clip.y_axis * step_m),
            height: column(clip.z_axis),
            origin: column(clip.w_axis),
            cells: grid.cells,
            block_cells: grid.cells,
            padding: [0; 2],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;
    use terrafill_shaders::struct_layout;

    #[test]
    fn constants_lie_as_the_shader_reads_them() {
        let layout = struct_layout("pipelines/grid.wgsl", "GridConstants").expect("a struct");
        let offset = |name: &str| layout.offset(name).expect(name);
        assert_eq!(offset("column"), offset_of!(GridConstants, column));
        assert_eq!(offset("row"), offset_of!(GridConstants, row));
        assert_eq!(offset("height"), offset_of!(GridConstants, height));
        assert_eq!(offset("origin"), offset_of!(GridConstants, origin));
        assert_eq!(offset("cells"), offset_of!(GridConstants, cells));
        let of_block = offset_of!(GridConstants, block_cells);
        assert_eq!(offset("block_cells"), of_block);
        assert_eq!(layout.stride as usize, size_of::<GridConstants>());
        // Negative control: two members lie apart.
        assert_ne!(offset("row"), offset_of!(GridConstants, height));
    }

    #[test]
    fn every_corner_of_the_ground_is_on_screen_and_before_the_near_plane() {
        let view = GridCamera::new();
        for x in [0.0, SIDE_M] {
            for y in [0.0, SIDE_M] {
                for z in [-110.0, 110.0] {
                    let from_eye = DVec3::new(x, y, z) - view.eye;
                    let away = from_eye.dot(view.forward);
                    assert!(away > NEAR_M, "{x} {y} {z}");
                    let across = from_eye.dot(view.right).abs();
                    let upwards = from_eye.dot(view.up).abs();
                    assert!(across < away * TAN_HALF_VIEW, "{x} {y} {z}");
                    assert!(upwards < away * TAN_HALF_VIEW, "{x} {y} {z}");
                }
            }
        }
    }
}
