// SPDX-License-Identifier: MIT OR Apache-2.0
//! Distant lights all round the ground, and how a device reads them.

use crate::draws::count;
use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec2, DVec3, DVec4};
use terrafill_shapes::grid::{Grid, nearest};

/// Most lights, as shaders have room for.
pub(crate) const MOST_LIGHTS: usize = 16;
/// What a light's map shows: the ball around the whole ground.
pub(crate) const CENTRE: DVec3 = DVec3::new(1_000.0, 1_000.0, 0.0);
pub(crate) const RADIUS_M: f64 = 1_530.0;
/// What hides a place is nearer to the light by more than this, in texels. The steepest light is 20° above level
/// ground, whose depth changes by 1.4 texels half a texel's diagonal away.
const BIAS_TEXELS: f64 = 2.5;

/// A distant light: axes of its map and the direction towards it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DistantLight {
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
    pub(crate) toward: DVec3,
}

/// Lights at even angles around, from 20° to 50° above the horizon.
pub(crate) fn lights(count: u32) -> Vec<DistantLight> {
    let light = |number: u32| {
        let part = |number: u32| f64::from(number) / f64::from(count);
        let around = (20.0 + 360.0 * part(number)).to_radians();
        // Neighbours are of different heights.
        let above = (20.0 + 30.0 * part(7 * number % count)).to_radians();
        let level = DVec3::new(around.cos(), around.sin(), 0.0);
        let toward = level * above.cos() + DVec3::Z * above.sin();
        let right = toward.cross(DVec3::Z).normalize();
        DistantLight {
            right,
            up: right.cross(toward),
            toward,
        }
    };
    (0..count).map(light).collect()
}

/// A side of a texel of a map, metres.
pub(crate) fn texel_m(side: u32) -> f64 {
    2.0 * RADIUS_M / f64::from(side)
}

pub(crate) fn bias_m(side: u32) -> f64 {
    BIAS_TEXELS * texel_m(side)
}

/// Ground with objects on it, as heights: towers with steep sides and domes. They do not overhang, so that rays over
/// heights are the reference.
pub(crate) fn ground(cells: u32) -> Grid {
    let mut grid = Grid::new(cells);
    let step_m = grid.step_m();
    for row in 0..=cells {
        for column in 0..=cells {
            let place = DVec2::new(f64::from(column), f64::from(row)) * step_m;
            let vertex = grid.index(column, row);
            grid.heights[vertex] += nearest(object_m(place));
        }
    }
    grid
}

/// Height of the object at a place above the ground, metres; 0 where there is none. Every 250 m stands one, towers and
/// domes in turn.
fn object_m(place: DVec2) -> f64 {
    const EACH_M: f64 = 250.0;
    const RADIUS_M: f64 = 62.5;
    const TOWER_M: f64 = 70.0;
    let number = (place / EACH_M).floor();
    let from = place - (number + 0.5) * EACH_M;
    let is_tower = (number.x + number.y).rem_euclid(2.0) < 0.5;
    if is_tower {
        let is_inside = from.abs().max_element() < 0.6 * RADIUS_M;
        TOWER_M * f64::from(u8::from(is_inside))
    } else {
        (RADIUS_M * RADIUS_M - from.length_squared())
            .max(0.0)
            .sqrt()
    }
}

/// Twin of `Light` in `shared/lit.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct LightColumns {
    column: [f32; 4],
    row: [f32; 4],
    height: [f32; 4],
    origin: [f32; 4],
}

impl LightColumns {
    /// Of a layer whose places are moved across and along the rows by what their depth is above `level`, and then by
    /// `by`; from 0 to 1 across and along.
    pub(crate) fn sheared(by: [f64; 2], shear: [f64; 2], level: f64) -> Self {
        let [x, y] = [0, 1].map(|axis| nearest(2.0 * (by[axis] - shear[axis] * level) - 1.0));
        let [across, along] = shear.map(|of| 2.0 * nearest(of));
        Self {
            column: [2.0, 0.0, 0.0, 0.0],
            row: [0.0, 2.0, 0.0, 0.0],
            height: [across, along, 1.0, 0.0],
            origin: [x, y, 0.0, 1.0],
        }
    }

    /// Of a matrix from metres to clip space.
    pub(crate) fn of_matrix(clip: &DMat4, step_m: f64) -> Self {
        let column = |of: DVec4| of.as_vec4().to_array();
        Self {
            column: column(clip.x_axis * step_m),
            row: column(clip.y_axis * step_m),
            height: column(clip.z_axis),
            origin: column(clip.w_axis),
        }
    }

    fn new(light: &DistantLight, step_m: f64) -> Self {
        let DistantLight { right, up, toward } = *light;
        let scale = RADIUS_M.recip();
        // What an axis of the ground adds across, upwards and in depth.
        let along = |axis: DVec3| {
            let depth = 0.5 * axis.dot(toward);
            DVec4::new(axis.dot(right), axis.dot(up), depth, 0.0) * scale
        };
        let column = |of: DVec4| of.as_vec4().to_array();
        Self {
            column: column(along(DVec3::X) * step_m),
            row: column(along(DVec3::Y) * step_m),
            height: column(along(DVec3::Z)),
            origin: column(DVec4::new(0.0, 0.0, 0.5, 1.0) - along(CENTRE)),
        }
    }
}

/// Twin of `Lights` in `shared/lit.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct LightConstants {
    each: [LightColumns; MOST_LIGHTS],
    count: u32,
    texels: u32,
    bias: f32,
    padding: u32,
}

impl LightConstants {
    /// - `side`: of a map, texels
    pub(crate) fn new(grid: &Grid, lights: &[DistantLight], side: u32) -> Self {
        let columns = lights
            .iter()
            .map(|light| LightColumns::new(light, grid.step_m()));
        let columns: Vec<LightColumns> = columns.collect();
        Self::of_columns(&columns, side, 0.5 * bias_m(side) / RADIUS_M)
    }

    /// - `bias`: as the picture's shader has it
    pub(super) fn of_columns(columns: &[LightColumns], side: u32, bias: f64) -> Self {
        let mut each = [LightColumns::default(); MOST_LIGHTS];
        each[..columns.len()].copy_from_slice(columns);
        Self {
            each,
            count: count(columns),
            texels: side,
            bias: nearest(bias),
            padding: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;
    use terrafill_shaders::struct_layout;

    #[test]
    fn lights_lie_as_the_shader_reads_them() {
        let layout = struct_layout("pipelines/lit.wgsl", "Lights").expect("a struct");
        let offset = |name: &str| layout.offset(name).expect(name);
        assert_eq!(offset("each"), offset_of!(LightConstants, each));
        assert_eq!(offset("count"), offset_of!(LightConstants, count));
        assert_eq!(offset("texels"), offset_of!(LightConstants, texels));
        assert_eq!(offset("bias"), offset_of!(LightConstants, bias));
        assert_eq!(layout.stride as usize, size_of::<LightConstants>());
        assert_ne!(offset("count"), offset_of!(LightConstants, texels));
    }

    #[test]
    fn objects_stand_on_the_ground_and_change_nothing_beside_it() {
        let (with, without) = (ground(256), Grid::new(256));
        let above = |column, row| {
            let vertex = with.index(column, row);
            with.heights[vertex] - without.heights[vertex]
        };
        // Middles of a tower and of a dome, and between them.
        assert!((above(16, 16) - 70.0).abs() < 1e-3, "{}", above(16, 16));
        assert!((above(48, 16) - 62.5).abs() < 1e-3, "{}", above(48, 16));
        assert_eq!(above(32, 16), 0.0);
        let most = with.heights.iter().copied().fold(0.0_f32, f32::max);
        assert!(most > 120.0 && most < 180.0, "{most}");
    }

    #[test]
    fn the_whole_ground_is_on_every_map() {
        for light in lights(16) {
            for corner in [[0.0, 0.0], [2_000.0, 0.0], [0.0, 2_000.0], [2_000.0; 2]] {
                for height in [-110.0, 180.0] {
                    let place = DVec3::new(corner[0], corner[1], height) - CENTRE;
                    for axis in [light.right, light.up, light.toward] {
                        assert!(place.dot(axis).abs() < RADIUS_M, "{corner:?}");
                    }
                }
            }
        }
    }
}
