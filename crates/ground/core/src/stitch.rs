// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangulated groups → one mesh on the body: seams closed, cuts removed, boundary loops followed.
//!
//! Vertices at longitude −180 and +180 with the same latitude become one, all vertices at a pole
//! become one, and what that makes degenerate vanishes. A boundary edge whose reverse then exists too
//! was a cut, not a border.

use crate::Ellipsoid;
use crate::edge::{Degrees, normal, surface_point};
use crate::triangulate::GroupMesh;
use glam::DVec3;
use std::collections::HashMap;
use terrafill_planar::index_u32;

fn append<T>(list: &mut Vec<T>, mut more: Vec<T>) {
    if list.is_empty() {
        *list = more;
    } else {
        list.append(&mut more);
    }
}

/// Puts pieces together on the body.
#[derive(Default)]
pub(crate) struct Stitcher {
    pub(crate) vertices_ecef: Vec<DVec3>,
    pub(crate) vertices_deg: Vec<Degrees>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Directed, inside on the left; cuts still among them.
    boundary: Vec<[u32; 2]>,
    /// Vertices on the antimeridian and at the poles, by the bits of their one position.
    shared: HashMap<[u64; 2], u32>,
}

impl Stitcher {
    pub(crate) fn add(&mut self, body: &Ellipsoid, group: GroupMesh) {
        self.vertices_ecef.reserve(group.vertices.len());
        self.vertices_deg.reserve(group.vertices.len());
        let index: Vec<u32> = group
            .vertices
            .into_iter()
            .map(|position| self.vertex(body, position))
            .collect();
        let distinct = |ends: &[u32]| {
            ends.iter()
                .zip(ends.iter().cycle().skip(1))
                .all(|(a, b)| a != b)
        };
        // In place, and the lists of the first group, mostly the only one, become the region's.
        let GroupMesh {
            mut triangles,
            mut boundary,
            ..
        } = group;
        for corners in &mut triangles {
            *corners = corners.map(|i| index[i as usize]);
        }
        triangles.retain(|corners| distinct(corners));
        append(&mut self.triangles, triangles);
        for ends in &mut boundary {
            *ends = ends.map(|i| index[i as usize]);
        }
        boundary.retain(|ends| distinct(ends));
        append(&mut self.boundary, boundary);
    }

    fn vertex(&mut self, body: &Ellipsoid, position: Degrees) -> u32 {
        let new = index_u32(self.vertices_deg.len());
        let position = if position[1].abs() == 90.0 {
            [0.0, position[1]]
        } else if position[0].abs() == 180.0 {
            [180.0, position[1]]
        } else {
            self.push(body, position);
            return new;
        };
        let key = position.map(f64::to_bits);
        if let Some(existing) = self.shared.get(&key) {
            return *existing;
        }
        self.shared.insert(key, new);
        self.push(body, position);
        new
    }

    fn push(&mut self, body: &Ellipsoid, position: Degrees) {
        self.vertices_deg.push(position);
        self.vertices_ecef.push(surface_point(body, position));
    }

    /// Whether stitching may have laid another edge on this one: along the antimeridian, and at a
    /// pole, where lines towards different longitudes become one.
    fn may_be_doubled(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a, b].map(|vertex| self.vertices_deg[vertex as usize]);
        let at_pole = |position: Degrees| position[1].abs() == 90.0;
        at_pole(a) || at_pole(b) || a[0] == 180.0 && b[0] == 180.0
    }

    /// Drops the edges whose reverse is there too, and chains the rest; `None` where one leads
    /// nowhere.
    pub(crate) fn boundary_loops(&mut self) -> Option<Vec<Vec<u32>>> {
        let (mut maybe_cuts, mut edges): (Vec<_>, Vec<_>) = std::mem::take(&mut self.boundary)
            .into_iter()
            .partition(|[a, b]| self.may_be_doubled(*a, *b));
        maybe_cuts.sort_unstable_by_key(|&[a, b]| (a.min(b), a.max(b), a));
        for same_ends in maybe_cuts.chunk_by(|a, b| a == b || *a == [b[1], b[0]]) {
            let forward = same_ends.iter().filter(|ends| ends[0] < ends[1]).count();
            let backward = same_ends.len() - forward;
            let [low, high] = [
                same_ends[0][0].min(same_ends[0][1]),
                same_ends[0][0].max(same_ends[0][1]),
            ];
            for _ in backward..forward {
                edges.push([low, high]);
            }
            for _ in forward..backward {
                edges.push([high, low]);
            }
        }
        self.chain(edges)
    }

    fn chain(&self, mut edges: Vec<[u32; 2]>) -> Option<Vec<Vec<u32>>> {
        edges.sort_unstable();
        let angles = self.sort_by_angle(&mut edges);
        let mut first_from = vec![u32::MAX; self.vertices_deg.len()];
        for (i, edge) in edges.iter().enumerate().rev() {
            first_from[edge[0] as usize] = index_u32(i);
        }
        let mut used = vec![false; edges.len()];
        let mut loops = Vec::new();
        for start in 0..edges.len() {
            if used[start] {
                continue;
            }
            let mut ring = Vec::new();
            let mut at = start;
            while !used[at] {
                used[at] = true;
                let [from, to] = edges[at];
                ring.push(from);
                let first = first_from[to as usize] as usize;
                at = match edges.get(first..)? {
                    [_, second, ..] if second[0] == to => {
                        let leaving = edges[first..].partition_point(|edge| edge[0] == to);
                        let leaving = first..first + leaving;
                        let back = self.angle(to, from);
                        let split = angles[leaving.clone()].partition_point(|angle| *angle <= back);
                        let split = first + split;
                        // The smallest clockwise turn from the way back.
                        let mut clockwise = (first..split).rev().chain((split..leaving.end).rev());
                        clockwise.find(|&i| !used[i]).unwrap_or(start)
                    }
                    _ => first,
                };
            }
            loops.push(ring);
        }
        Some(loops)
    }

    /// Sorts edges that leave the same vertex by their angles there, so that a vertex where very many
    /// meet does not take the square of their number; returns the angles, 0 where one edge leaves.
    fn sort_by_angle(&self, edges: &mut [[u32; 2]]) -> Vec<f64> {
        let mut angles = Vec::with_capacity(edges.len());
        for leaving in edges.chunk_by_mut(|a, b| a[0] == b[0]) {
            if let [_] = leaving {
                angles.push(0.0);
                continue;
            }
            leaving.sort_by(|[at, a], [_, b]| self.angle(*at, *a).total_cmp(&self.angle(*at, *b)));
            angles.extend(leaving.iter().map(|[at, next]| self.angle(*at, *next)));
        }
        angles
    }

    /// Direction from one vertex to another, counter-clockwise seen from outside. The inside lies
    /// left of the way in, so the smallest clockwise turn from the way back leads on along the other
    /// side of the same corner of the inside.
    fn angle(&self, at: u32, to: u32) -> f64 {
        let up = normal(self.vertices_deg[at as usize]);
        let x_axis = up.any_orthonormal_vector();
        let y_axis = up.cross(x_axis);
        let direction = self.vertices_ecef[to as usize] - self.vertices_ecef[at as usize];
        direction.dot(y_axis).atan2(direction.dot(x_axis))
    }
}
