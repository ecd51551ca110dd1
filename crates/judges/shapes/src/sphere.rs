// SPDX-License-Identifier: MIT OR Apache-2.0
//! Directions of an irregular mesh's vertices: where each triangle lies on a sphere, and which one holds a direction.

use crate::tetrahedra::IrregularMesh;
use glam::DVec3;

/// Boxes of directions a side, whose triangles are listed.
const BOXES: usize = 24;
/// A triangle's arc bulges by less than this share of its longest side.
const BULGE: f64 = 0.3;
/// Rounds that turn triangles back; a handful is enough where the mesh is coarse for a crease.
const ROUNDS: usize = 200;

/// A mesh on a sphere.
pub struct Sphere {
    /// The surface whose vertices lie on it.
    pub mesh: IrregularMesh,
    /// Of each vertex, length 1.
    pub directions: Vec<DVec3>,
    /// Triangles by the box of directions that they may lie in.
    boxes: Vec<Vec<u32>>,
}

impl Sphere {
    /// - `direction`: of a place of the surface
    pub fn new(mesh: IrregularMesh, direction: impl Fn(DVec3) -> DVec3) -> Self {
        let directions = mesh.vertices.iter().copied().map(direction).collect();
        let mut sphere = Self {
            mesh,
            directions,
            boxes: vec![Vec::new(); BOXES.pow(3)],
        };
        sphere.turn_back();
        for (index, corners) in (0..).zip(&sphere.mesh.triangles) {
            let [a, b, c] = corners.map(|corner| sphere.directions[corner as usize]);
            let longest = (a - b).length().max((b - c).length()).max((c - a).length());
            let low = place_of(a.min(b).min(c) - BULGE * longest);
            let high = place_of(a.max(b).max(c) + BULGE * longest);
            for z in low[2]..=high[2] {
                for y in low[1]..=high[1] {
                    for x in low[0]..=high[0] {
                        sphere.boxes[(z * BOXES + y) * BOXES + x].push(index);
                    }
                }
            }
        }
        sphere
    }

    fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|corner| self.directions[corner as usize])
    }

    /// Triangles that lie the wrong way round on the sphere.
    pub fn turned(&self) -> usize {
        let all = self.mesh.triangles.iter();
        all.filter(|triangle| volume(self.corners(**triangle)) <= 0.0)
            .count()
    }

    /// Moves corners of triangles that lie the wrong way round into the middle of their neighbours. A coarse triangle
    /// over a crease may lie so, though no two lines of the field meet.
    fn turn_back(&mut self) {
        for _ in 0..ROUNDS {
            let mut sums = vec![DVec3::ZERO; self.directions.len()];
            let mut moved = vec![false; self.directions.len()];
            for &triangle in &self.mesh.triangles {
                let corners = self.corners(triangle);
                let is_turned = volume(corners) <= 0.0;
                let sum: DVec3 = corners.into_iter().sum();
                for (vertex, corner) in triangle.into_iter().zip(corners) {
                    sums[vertex as usize] += sum - corner;
                    moved[vertex as usize] |= is_turned;
                }
            }
            if !moved.contains(&true) {
                return;
            }
            let all = self.directions.iter_mut().zip(sums.iter().zip(moved));
            for (direction, (sum, _)) in all.filter(|(_, (_, is_moved))| *is_moved) {
                *direction = sum.normalize();
            }
        }
    }

    /// Where a direction meets the mesh: a place of one of its triangles, metres.
    pub fn place(&self, direction: DVec3) -> DVec3 {
        let [x, y, z] = place_of(direction);
        let listed = &self.boxes[(z * BOXES + y) * BOXES + x];
        let weighed = listed.iter().map(|&index| {
            let triangle = self.mesh.triangles[index as usize];
            let [a, b, c] = self.corners(triangle);
            let weights = [[direction, b, c], [a, direction, c], [a, b, direction]].map(volume);
            let sum: f64 = weights.iter().sum();
            let weights = weights.map(|weight| weight / sum);
            // The opposite side of the sphere has the same weights with another sign of the sum.
            let least = if sum > 0.0 {
                weights.into_iter().fold(f64::INFINITY, f64::min)
            } else {
                f64::NEG_INFINITY
            };
            (least, triangle, weights)
        });
        let best = weighed.max_by(|one, other| one.0.total_cmp(&other.0));
        let (_, triangle, weights) = best.unwrap_or((0.0, [0; 3], [1.0, 0.0, 0.0]));
        let corners = triangle.map(|corner| self.mesh.vertices[corner as usize]);
        corners.into_iter().zip(weights).map(|(c, w)| c * w).sum()
    }
}

fn volume([a, b, c]: [DVec3; 3]) -> f64 {
    a.dot(b.cross(c))
}

/// Box of a direction, or the next one to it.
fn place_of(direction: DVec3) -> [usize; 3] {
    let scaled = (direction + 1.0) * (0.5 * BOXES as f64);
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "held between 0 and the last box"
    )]
    let index = |along: f64| along.clamp(0.0, (BOXES - 1) as f64) as usize;
    scaled.to_array().map(index)
}
