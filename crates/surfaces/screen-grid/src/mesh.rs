// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles of one view: the screen in N × N cells, a ray through each corner, two triangles a cell.
//!
//! Positions are relative to the eye, metres, `f64`, ECEF axes. Places on the screen are pixels from its upper
//! left corner.

use crate::rays::{Eye, Rays};
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use terrafill_core::{Ellipsoid, nearest_f32};
use terrafill_scene::{Camera, ImageSize};

/// What becomes of corners whose rays miss the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Limb {
    /// They are moved onto the horizon, as published.
    #[default]
    Snap,
    /// They are left out. Vertices on the horizon, where the cells' edges meet it and evenly round it, close
    /// the cells that it crosses.
    Ring,
}

impl Limb {
    /// Every way, with its name in scene files.
    pub const ALL: [(&'static str, Self); 2] = [("snap", Self::Snap), ("ring", Self::Ring)];
}

/// How a view's triangles are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GridOptions {
    /// Cells along each side of the screen, N.
    pub cells: u32,
    /// What becomes of corners whose rays miss.
    pub limb: Limb,
    /// In what arithmetic.
    pub rays: Rays,
}

/// Triangles of one view.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScreenMesh {
    /// On the body, relative to the eye, before they are rounded for the GPU.
    pub vertices_rte: Vec<DVec3>,
    /// Counter-clockwise seen from the eye. Those without area are left out.
    pub triangles: Vec<[u32; 3]>,
    /// Cell that each triangle is of, row by row from the upper left.
    pub cells: Vec<u32>,
}

impl ScreenMesh {
    /// What `camera` sees of the bare `body`; `None` for an eye that is not above it.
    ///
    /// - cost: O(N²)
    #[must_use]
    pub fn new(
        body: &Ellipsoid,
        camera: &Camera,
        size: ImageSize,
        options: GridOptions,
    ) -> Option<Self> {
        let mut builder = Builder {
            camera,
            size,
            n: options.cells,
            eye: Eye::new(body, camera.eye_ecef, options.rays)?,
            mesh: Self::default(),
        };
        match options.limb {
            Limb::Snap => builder.snap(),
            Limb::Ring => builder.ring(),
        }
        Some(builder.mesh)
    }

    /// What the GPU reads.
    #[must_use]
    pub fn rounded(&self) -> Vec<[f32; 3]> {
        let vertices = self.vertices_rte.iter();
        vertices.map(|v| v.to_array().map(nearest_f32)).collect()
    }
}

struct Builder<'a> {
    camera: &'a Camera,
    size: ImageSize,
    n: u32,
    eye: Eye,
    mesh: ScreenMesh,
}

/// A vertex and its place on the screen.
type Placed = ([f64; 2], u32);

impl Builder<'_> {
    /// Corner of cells, pixels.
    fn corner_px(&self, column: u32, row: u32) -> [f64; 2] {
        let along = |at: u32, pixels: u32| f64::from(pixels) * f64::from(at) / f64::from(self.n);
        [along(column, self.size.width), along(row, self.size.height)]
    }

    fn direction(&self, px: [f64; 2]) -> DVec3 {
        self.camera.direction_ecef(self.size, px)
    }

    fn push(&mut self, vertex: DVec3) -> u32 {
        self.mesh.vertices_rte.push(vertex);
        // A grid of 80 has 6,561 corners.
        u32::try_from(self.mesh.vertices_rte.len() - 1).unwrap_or(u32::MAX)
    }

    /// Adds a triangle, turned towards the eye: moved corners turn some over.
    fn add(&mut self, cell: u32, [a, b, c]: [u32; 3]) {
        let [p, q, r] = [a, b, c].map(|i| self.mesh.vertices_rte[i as usize]);
        if p == q || q == r || r == p {
            return;
        }
        // A triangle's normal points at the eye where its corners run counter-clockwise.
        let faces = (q - p).cross(r - p).dot(p) < 0.0;
        self.mesh
            .triangles
            .push(if faces { [a, b, c] } else { [a, c, b] });
        self.mesh.cells.push(cell);
    }

    /// The two triangles of a cell from its four corners: upper left, upper right, lower left, lower right.
    fn add_cell(&mut self, cell: u32, [a, b, c, d]: [u32; 4]) {
        self.add(cell, [a, c, d]);
        self.add(cell, [a, d, b]);
    }

    fn snap(&mut self) {
        for row in 0..=self.n {
            for column in 0..=self.n {
                let direction = self.direction(self.corner_px(column, row));
                let hit = self.eye.hit(direction);
                self.push(hit.unwrap_or_else(|| self.eye.tangent(direction)));
            }
        }
        for row in 0..self.n {
            for column in 0..self.n {
                let first = row * (self.n + 1) + column;
                let below = first + self.n + 1;
                let corners = [first, first + 1, below, below + 1];
                self.add_cell(row * self.n + column, corners);
            }
        }
    }

    fn ring(&mut self) {
        let n = self.n;
        let mut corners = Vec::new();
        for row in 0..=n {
            for column in 0..=n {
                let hit = self.eye.hit(self.direction(self.corner_px(column, row)));
                corners.push(hit.map(|hit| self.push(hit)));
            }
        }
        let round = self.round_the_horizon();
        // Where edges cross the horizon, by their first corner and whether they run down.
        let mut crossings: BTreeMap<(u32, u32, bool), Vec<Placed>> = BTreeMap::new();
        for row in 0..=n {
            for column in 0..=n {
                for is_down in [false, true] {
                    let end = [column + u32::from(!is_down), row + u32::from(is_down)];
                    if end[0] <= n && end[1] <= n {
                        let found = self.crossings([column, row], end);
                        crossings.insert((column, row, is_down), found);
                    }
                }
            }
        }
        let none = Vec::new();
        for row in 0..n {
            for column in 0..n {
                let cell = row * n + column;
                let at = |c: u32, r: u32| corners[(r * (n + 1) + c) as usize];
                let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(c, r)| (column + c, row + r));
                let hits = four.map(|(c, r)| at(c, r));
                if let [Some(a), Some(b), Some(c), Some(d)] = hits {
                    self.add_cell(cell, [a, b, c, d]);
                    continue;
                }
                let mut rim: Vec<Placed> = Vec::new();
                for (&(c, r), hit) in four.iter().zip(hits) {
                    rim.extend(hit.map(|vertex| (self.corner_px(c, r), vertex)));
                }
                for edge in [
                    (column, row, false),
                    (column, row + 1, false),
                    (column, row, true),
                    (column + 1, row, true),
                ] {
                    rim.extend(crossings.get(&edge).unwrap_or(&none));
                }
                rim.extend(round.get(&cell).unwrap_or(&none));
                self.add_fan(cell, rim);
            }
        }
    }

    /// Vertices evenly round the horizon, four a cell's side and no fewer than 16, by the cell in which they are
    /// seen.
    fn round_the_horizon(&mut self) -> BTreeMap<u32, Vec<Placed>> {
        let count = (4 * self.n).max(16);
        let up = self.eye.scaled.normalize();
        let one = up.any_orthonormal_vector();
        let other = up.cross(one);
        let mut found: BTreeMap<u32, Vec<Placed>> = BTreeMap::new();
        for i in 0..count {
            let (sin, cos) = (f64::from(i) / f64::from(count) * TAU).sin_cos();
            let vertex = self.eye.horizon(one * cos + other * sin);
            let Some((px, cell)) = self.seen_at(vertex) else {
                continue;
            };
            let index = self.push(vertex);
            found.entry(cell).or_default().push((px, index));
        }
        found
    }

    /// Place on the screen and cell of a point; `None` beside the screen and behind the eye.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "cells of a place on the screen"
    )]
    fn seen_at(&self, rte: DVec3) -> Option<([f64; 2], u32)> {
        let view = self.camera.view_from_ecef * rte;
        let tan = self.camera.tan_half_fov();
        let x = 0.5 + 0.5 * view.x / (-view.z * tan * self.size.aspect());
        let y = 0.5 - 0.5 * view.y / (-view.z * tan);
        let is_seen = view.z < 0.0 && (0.0..1.0).contains(&x) && (0.0..1.0).contains(&y);
        let n = f64::from(self.n);
        let [column, row] = [x, y].map(|at| (at * n) as u32);
        let px = [
            x * f64::from(self.size.width),
            y * f64::from(self.size.height),
        ];
        is_seen.then_some((px, row * self.n + column))
    }

    /// Where the edge between two corners crosses the horizon: the roots of a form of the rays.
    fn crossings(&mut self, from: [u32; 2], to: [u32; 2]) -> Vec<Placed> {
        let [from, to] = [from, to].map(|[column, row]| self.corner_px(column, row));
        let [start, end] = [from, to].map(|px| self.direction(px));
        let along = end - start;
        let (a, b, c) = (
            self.eye.form(along, along),
            self.eye.form(start, along),
            self.eye.form(start, start),
        );
        let under_root = b * b - a * c;
        if under_root <= 0.0 {
            return Vec::new();
        }
        // Without cancellation (Press et al., 2007, 5.6).
        let q = -(b + b.signum() * under_root.sqrt());
        let mut found = Vec::new();
        for t in [q / a, c / q] {
            let direction = start + along * t;
            let is_ahead = self.eye.is_ahead(direction);
            if (0.0..=1.0).contains(&t) && is_ahead {
                let px = [0, 1].map(|i| from[i] + (to[i] - from[i]) * t);
                let vertex = self.eye.tangent(direction);
                found.push((px, self.push(vertex)));
            }
        }
        found
    }

    /// Triangles round the middle of a convex rim.
    fn add_fan(&mut self, cell: u32, mut rim: Vec<Placed>) {
        // Between two crossings of one edge there is nothing but the arc over it.
        if rim.len() < 3 {
            return;
        }
        let count = rim.len() as f64;
        let middle = [0, 1].map(|i| rim.iter().map(|(px, _)| px[i]).sum::<f64>() / count);
        let direction = self.direction(middle);
        let hit = self.eye.hit(direction);
        let middle_vertex = self.push(hit.unwrap_or_else(|| self.eye.tangent(direction)));
        let angle = |px: &[f64; 2]| (px[1] - middle[1]).atan2(px[0] - middle[0]);
        rim.sort_by(|(one, _), (other, _)| angle(one).total_cmp(&angle(other)));
        for i in 0..rim.len() {
            let next = rim[(i + 1) % rim.len()];
            self.add(cell, [middle_vertex, rim[i].1, next.1]);
        }
    }
}
