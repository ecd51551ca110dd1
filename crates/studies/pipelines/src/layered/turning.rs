// SPDX-License-Identifier: MIT OR Apache-2.0
//! The pot that turns while the shutter is open: its matrices for devices, and its blurred pictures by rays in `f64`.
//!
//! Moments are shares of the exposure. Grey falls with the distance from the eye: it is the depth that a layer holds,
//! 1 at the near plane, and 0 at the far plane and where nothing is. So a layer needs no colour beside its depth.

use crate::lights::LightColumns;
use crate::meshes::pot_mesh;
use glam::{DMat4, DQuat, DVec2, DVec4};
use std::cell::OnceCell;
use terrafill_shapes::grid::{GridCamera, NEAR_M, nearest};
use terrafill_shapes::mesh::Mesh;
use terrafill_shapes::mesh_rays::MeshRays;
use terrafill_shapes::pot::{POT_MIDDLE, pot_view};
use terrafill_shapes::rays::{BAND_PX, around};

/// How far it turns: the tip of the spout by a tenth of the picture.
const TURN_RAD: f64 = 0.2;
/// Planes before and behind all that turns.
const BEFORE_M: f64 = 3.2;
const BEHIND_M: f64 = 7.5;
/// Moments that stand for all.
const SUB_FRAMES: u32 = 1_024;

/// What a layer shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Layer {
    pub(super) moment: f64,
    /// Which pixel of a tile it is for.
    pub(super) place: [u32; 2],
}

/// The pot, and the pixels of its picture that are judged.
pub(super) struct Turning {
    mesh: Mesh,
    /// Of the square picture.
    side: u32,
    /// Column and row of each judged pixel.
    pub(super) pixels: Vec<[u32; 2]>,
    exact: OnceCell<Vec<[f64; 2]>>,
}

/// From where the resting pot looks as the turned one does from where it is seen.
fn view_at(moment: f64) -> GridCamera {
    let view = pot_view();
    // Across the picture, so that all silhouettes move, and a little towards the eye.
    let axis = 0.8 * view.forward + 0.6 * view.up;
    let turn = DQuat::from_axis_angle(axis, -TURN_RAD * moment);
    GridCamera {
        eye: POT_MIDDLE + turn * (view.eye - POT_MIDDLE),
        right: turn * view.right,
        up: turn * view.up,
        forward: turn * view.forward,
        ..view
    }
}

/// Grey of what is so far along the view's axis.
fn grey(away_m: f64) -> f64 {
    (away_m.recip() - BEHIND_M.recip()) / (BEFORE_M.recip() - BEHIND_M.recip())
}

/// Matrix of a layer, whose depth is [`grey`].
///
/// - `side`: of the picture, pixels
/// - `tile`: a side of its tiles, pixels
pub(super) fn columns(layer: Layer, side: u32, tile: u32) -> LightColumns {
    let texels = f64::from(side.div_ceil(tile));
    let [side, tile] = [side, tile].map(f64::from);
    let scale = side / (tile * texels);
    // A texel's middle lies on that of its pixel.
    let by = layer
        .place
        .map(|place| scale + (0.5 * tile - f64::from(place) - 0.5) * 2.0 / (tile * texels) - 1.0);
    let depth = (BEFORE_M.recip() - BEHIND_M.recip()).recip();
    let from_clip = DMat4::from_cols(
        DVec4::X * scale,
        // Rows of a layer run down.
        DVec4::NEG_Y * scale,
        DVec4::Z * (depth / NEAR_M),
        DVec4::new(by[0], by[1], -depth / BEHIND_M, 1.0),
    );
    LightColumns::of_matrix(&(from_clip * view_at(layer.moment).clip_from_world()), 1.0)
}

impl Turning {
    /// - `level`: how often a side of a patch is divided
    pub(super) fn new(level: u32, side: u32) -> Self {
        // Fewer of a small picture, whose rays meet more triangles; an odd step meets all places of a tile.
        let every = (side as usize / 8) | 1;
        let all = (0..side).flat_map(|row| (0..side).map(move |column| [column, row]));
        Self {
            mesh: pot_mesh(level),
            side,
            pixels: all.step_by(every).collect(),
            exact: OnceCell::new(),
        }
    }

    /// Grey of all moments, and of a trail that fades linearly with age, of each judged pixel.
    pub(super) fn exact(&self) -> &[[f64; 2]] {
        self.exact.get_or_init(|| self.over_time())
    }

    /// Corners of all triangles, as a device reads them.
    pub(super) fn places(&self) -> Vec<[f32; 4]> {
        let corners = (0..self.mesh.triangles.len()).flat_map(|index| self.mesh.corners(index));
        let place = |at: glam::DVec3| at.extend(0.0).to_array().map(nearest);
        corners.map(place).collect()
    }

    fn rays(&self, moment: f64) -> MeshRays<'_> {
        MeshRays::new(&self.mesh, view_at(moment), self.side)
    }

    fn over_time(&self) -> Vec<[f64; 2]> {
        let mut sums = vec![[0.0; 2]; self.pixels.len()];
        let count = f64::from(SUB_FRAMES);
        for frame in 0..SUB_FRAMES {
            let moment = (f64::from(frame) + 0.5) / count;
            let rays = self.rays(moment);
            for (sum, pixel) in sums.iter_mut().zip(&self.pixels) {
                let share = rays.away_m(middle(*pixel)).map_or(0.0, grey) / count;
                sum[0] += share;
                // What is left of the time is its age: weights 2 (1 − age) have the mean 1.
                sum[1] += 2.0 * moment * share;
            }
        }
        sums
    }

    /// Least and greatest grey that each judged pixel's own layers may have, by rays within the band around its middle.
    pub(super) fn ranges(&self, layers: &[Layer], tile: u32) -> Vec<Vec<[f64; 2]>> {
        let mut ranges = vec![Vec::new(); self.pixels.len()];
        // Vertices are snapped to shares of a texel, which is as wide as a tile.
        let band = BAND_PX * f64::from(tile);
        for layer in layers {
            let rays = self.rays(layer.moment);
            for (own, pixel) in ranges.iter_mut().zip(&self.pixels) {
                if pixel.map(|at| at % tile) != layer.place {
                    continue;
                }
                let greys = around(band).map(|off| rays.away_m(middle(*pixel) + off));
                let greys = greys.map(|away_m| away_m.map_or(0.0, grey));
                own.push(greys.fold([f64::INFINITY, 0.0], |[low, high], grey| {
                    [low.min(grey), high.max(grey)]
                }));
            }
        }
        ranges
    }
}

fn middle([column, row]: [u32; 2]) -> DVec2 {
    DVec2::new(f64::from(column), f64::from(row)) + 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_of_the_pot_lies_between_the_planes_while_it_turns() {
        let mesh = pot_mesh(8);
        let least = |before_m: f64| {
            let moments = [0.0, 0.25, 0.5, 0.75, 1.0].map(view_at);
            let away = moments.into_iter().flat_map(|view| {
                let from_eye = mesh.vertices.iter().map(move |at| *at - view.eye);
                from_eye.map(move |from| from.dot(view.forward))
            });
            let room = away.map(|away_m| (away_m - before_m).min(BEHIND_M - away_m));
            room.fold(f64::INFINITY, f64::min)
        };
        assert!(least(BEFORE_M) > 0.0, "{}", least(BEFORE_M));
        // Negative control: a plane that cuts into it.
        assert!(least(4.5) < 0.0);
        assert_eq!([BEFORE_M, BEHIND_M].map(grey), [1.0, 0.0]);
    }

    #[test]
    fn means_of_many_moments_near_the_exact_picture_and_those_of_half_the_time_do_not() {
        let turning = Turning::new(4, 64);
        let off = |until: f64| {
            let layers: Vec<Layer> = (0..64)
                .map(|layer| Layer {
                    moment: until * (f64::from(layer) + 0.5) / 64.0,
                    place: [0; 2],
                })
                .collect();
            let means = turning.ranges(&layers, 1).into_iter().map(|own| {
                let [low, high] = [0, 1].map(|end| own.iter().map(|of| of[end]).sum::<f64>());
                0.5 * (low + high) / 64.0
            });
            let squares = means
                .zip(turning.exact())
                .map(|(mean, of)| (mean - of[0]).powi(2));
            (squares.sum::<f64>() / turning.pixels.len() as f64).sqrt()
        };
        assert!(off(1.0) < 5e-3, "{}", off(1.0));
        // Negative control: the shutter closes early.
        assert!(off(0.5) > 3e-2, "{}", off(0.5));
    }
}
