// SPDX-License-Identifier: MIT OR Apache-2.0
//! One list of vertices for all levels of detail of a region.
//!
//! The boundary of a coarser level keeps vertices of the finer one, bit by bit, and so do the cap's inner
//! vertices where both levels have the same ones. Each place is stored once, and a level is indices into
//! the list. The coarsest level's vertices come first: what a coarse level uses is the list's beginning,
//! so that its indices stay short and its vertices lie together.

use std::collections::HashMap;
use terrafill_core::RegionMesh;
use terrafill_fill::FixedPoint;

/// Vertices of all levels of a region, and each level over them.
pub(crate) struct Pool {
    /// All levels' vertices; of triangles and loops it has none.
    pub(crate) vertices: RegionMesh,
    /// The levels in the order given, their triangles and loops counting in `vertices`, without any of their own.
    pub(crate) levels: Vec<PooledLevel>,
}

/// A level over the vertices of its region.
pub(crate) struct PooledLevel {
    /// Triangles and loops.
    pub(crate) mesh: RegionMesh,
    /// It uses none but so many of the first vertices.
    pub(crate) used: usize,
}

impl Pool {
    /// - `levels`: coarsest first; at least one
    pub(crate) fn new(levels: &[&RegionMesh]) -> Self {
        let mut vertices = RegionMesh::without_geometry();
        let mut places: HashMap<[u64; 3], u32> = HashMap::new();
        let mut pooled = Vec::with_capacity(levels.len());
        for level in levels {
            let both = level.vertices_ecef.iter().zip(&level.vertices_deg);
            let place = |(ecef, degrees): (&glam::DVec3, &[f64; 2])| {
                let key = ecef.to_array().map(f64::to_bits);
                *places.entry(key).or_insert_with(|| {
                    vertices.vertices_ecef.push(*ecef);
                    vertices.vertices_deg.push(*degrees);
                    index_u32(vertices.vertices_ecef.len() - 1)
                })
            };
            let moved: Vec<u32> = both.map(place).collect();
            let at = |vertex: u32| moved[vertex as usize];
            let triangles = level.triangles.iter().map(|corners| corners.map(at));
            let loops = level.boundary_loops.iter();
            pooled.push(PooledLevel {
                used: moved.iter().max().map_or(0, |&last| last as usize + 1),
                mesh: RegionMesh {
                    triangles: triangles.collect(),
                    boundary_loops: loops
                        .map(|ring| ring.iter().map(|&vertex| at(vertex)).collect())
                        .collect(),
                    ..RegionMesh::without_geometry()
                },
            });
        }
        Self {
            vertices,
            levels: pooled,
        }
    }

    /// Origin and unit that hold all levels.
    pub(crate) fn fixed(&self) -> FixedPoint {
        FixedPoint::for_mesh(&self.vertices)
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "meshes have fewer than 2^32 vertices"
)]
fn index_u32(index: usize) -> u32 {
    index as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use terrafill_fixtures::by_hand::{circle_deg, mesh};

    fn fan(places: Vec<[f64; 2]>) -> RegionMesh {
        let count = index_u32(places.len());
        let triangles = (1..count - 1).map(|i| [0, i, i + 1]).collect();
        mesh(places, triangles, vec![(0..count).collect()])
    }

    fn corners(mesh: &RegionMesh, vertices: &[DVec3]) -> Vec<DVec3> {
        let loops = mesh.boundary_loops.iter().flatten();
        let used = mesh.triangles.as_flattened().iter().chain(loops);
        used.map(|&vertex| vertices[vertex as usize]).collect()
    }

    #[test]
    fn each_place_is_stored_once_and_every_level_finds_its_own() {
        let all = circle_deg(12, 1.0);
        let fine = fan(all.clone());
        let coarse = fan(all.iter().copied().step_by(3).collect());
        let pool = Pool::new(&[&coarse, &fine]);
        assert_eq!(pool.vertices.vertices_ecef.len(), 12);
        let used: Vec<usize> = pool.levels.iter().map(|level| level.used).collect();
        assert_eq!(used, [4, 12]);
        for (level, own) in pool.levels.iter().zip([&coarse, &fine]) {
            let found = corners(&level.mesh, &pool.vertices.vertices_ecef);
            assert_eq!(found, corners(own, &own.vertices_ecef));
        }
        // Twin: a level one of whose vertices has moved by a bit shares all but that one.
        let mut moved = coarse.clone();
        moved.vertices_ecef[1].x = moved.vertices_ecef[1].x.next_up();
        let pool = Pool::new(&[&moved, &fine]);
        assert_eq!(pool.vertices.vertices_ecef.len(), 13);
    }
}
