// SPDX-License-Identifier: MIT OR Apache-2.0
//! A height field of hills in zones, each at a level of its own. Between two rows of zones a row of spikes stands on
//! every second vertex, so that all levels but the finest drop them.
//!
//! Zones share the vertices of their edges: those that the coarser of two zones does not have lie on its edges.

use crate::counts::scene::NodeVertices;
use glam::DVec3;
use std::sync::Arc;
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_globe_views::Eye;
use terrafill_maps::Node;

/// Zones along a side of the field.
pub(super) const ZONES: usize = ZONES_U32 as usize;
const ZONES_U32: u32 = 5;
/// The finest level, and cells along a side of a zone at level 0.
pub(super) const FINEST: u32 = 3;
const COARSE_CELLS: u32 = 2;
const FINE_CELLS: u32 = COARSE_CELLS << FINEST;
pub(super) const SIDE_CELLS: u32 = FINE_CELLS * ZONES_U32;
/// Triangles of a zone at level 0.
pub(super) const COARSE_TRIANGLES: u32 = 2 * COARSE_CELLS * COARSE_CELLS;
const ZONE_VERTICES: u32 = 6 * FINE_CELLS * FINE_CELLS;
/// Side of a cell of the finest level: 125 m.
const CELL_DEG: f64 = CELL_M / 111_132.0;
pub(super) const CELL_M: f64 = 125.0;
/// Of its south-western corner.
const CORNER_DEG: [f64; 2] = [15.0, 45.0];
/// The row of vertices with spikes: between the second and the third row of zones.
const SPIKE_ROW: u32 = 2 * FINE_CELLS;
const HILLS_M: f64 = 40.0;
/// Where the eye stands, in cells from the corner.
pub(super) const EYE_CELLS: [f64; 2] = [0.5 * SIDE_CELLS as f64, -8.0];

/// A bell, in cells of the finest level and metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hill {
    /// Of its top, east and north of the field's corner.
    pub(super) at: [f64; 2],
    /// From its top to its steepest slope.
    pub(super) sigma: f64,
    pub(super) height_m: f64,
}

impl Hill {
    fn height_m(&self, east: f64, north: f64) -> f64 {
        let [east, north] = [east - self.at[0], north - self.at[1]];
        let squared = (east * east + north * north) / (self.sigma * self.sigma);
        self.height_m * (-0.5 * squared).exp()
    }
}

/// Heights with spikes of this height, metres, or with a hill.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Field {
    pub(super) spike_m: f64,
    pub(super) hill: Option<Hill>,
}

/// A level for each zone, row by row from the south.
pub(super) type Levels = [u32; ZONES * ZONES];

/// Number of a zone; `None` outside the field.
fn zone(column: i64, row: i64) -> Option<usize> {
    let side = ZONES as i64;
    let is_there = (0..side).contains(&column) && (0..side).contains(&row);
    usize::try_from(row * side + column)
        .ok()
        .filter(|_| is_there)
}

/// A zone as a node of that number.
pub(super) fn node(number: usize) -> Node {
    (0, number % ZONES, number / ZONES)
}

/// The number again.
pub(super) fn number((_, column, row): Node) -> usize {
    row * ZONES + column
}

fn step(level: u32) -> u32 {
    1 << (FINEST - level.min(FINEST))
}

impl Field {
    /// Where the eye stands: before the southern edge, over its middle column.
    pub(super) fn eye_deg() -> [f64; 2] {
        Self::degrees(EYE_CELLS)
    }

    /// Longitude and latitude of a place in cells from the corner.
    pub(super) fn degrees([east, north]: [f64; 2]) -> [f64; 2] {
        [
            CORNER_DEG[0] + east * CELL_DEG / CORNER_DEG[1].to_radians().cos(),
            CORNER_DEG[1] + north * CELL_DEG,
        ]
    }

    /// Of a vertex of the finest level.
    fn height_m(&self, [x, y]: [u32; 2]) -> f64 {
        let [east, north] = [x, y].map(f64::from);
        let hill_m = self.hill.map_or(0.0, |hill| hill.height_m(east, north));
        let hills = HILLS_M * (0.13 * east).sin() * (0.11 * north + 0.4).cos() + hill_m;
        if y == SPIKE_ROW && x % 2 == 1 {
            hills + self.spike_m
        } else {
            hills
        }
    }

    /// Along an edge that a zone with this step draws, the height of a vertex that may lie between two of its own.
    fn on_edge_m(&self, at: u32, step: u32, vertex: impl Fn(u32) -> [u32; 2]) -> f64 {
        let before = at - at % step;
        let share = f64::from(at - before) / f64::from(step);
        let [from, to] = [before, before + step].map(|at| vertex(at.min(SIDE_CELLS)));
        let from_m = self.height_m(from);
        from_m + share * (self.height_m(to) - from_m)
    }

    /// A vertex as the zones about it draw it, metres.
    fn drawn_m(&self, [x, y]: [u32; 2], levels: &Levels) -> f64 {
        let beside = |at: u32| {
            let zone = i64::from(at / FINE_CELLS);
            [zone - i64::from(at.is_multiple_of(FINE_CELLS)), zone]
        };
        let coarsest = |columns: [i64; 2], rows: [i64; 2]| {
            let all = columns
                .into_iter()
                .flat_map(|column| rows.map(|row| (column, row)));
            let steps = all.filter_map(|(column, row)| Some(step(levels[zone(column, row)?])));
            steps.max().unwrap_or(1)
        };
        let step = coarsest(beside(x), beside(y));
        match (x.is_multiple_of(FINE_CELLS), y.is_multiple_of(FINE_CELLS)) {
            (true, false) => self.on_edge_m(y, step, |y| [x, y]),
            (false, true) => self.on_edge_m(x, step, |x| [x, y]),
            _ => self.height_m([x, y]),
        }
    }

    fn place(&self, body: &Ellipsoid, at: [u32; 2], levels: &Levels) -> DVec3 {
        let [east, north] = at.map(|at| f64::from(at) * CELL_DEG);
        let east = east / CORNER_DEG[1].to_radians().cos();
        let height_m = self.drawn_m(at, levels);
        let (longitude, latitude) = (CORNER_DEG[0] + east, CORNER_DEG[1] + north);
        body.geodetic_to_ecef(Geodetic::from_degrees(longitude, latitude, height_m))
    }

    /// All zones at their levels.
    pub(super) fn drawn(&self, eye: &Eye, levels: &Levels) -> NodeVertices {
        let zones = (0..ZONES * ZONES).map(|number| {
            let (_, column, row) = node(number);
            let first = [column, row].map(|at| FINE_CELLS * u32::try_from(at).unwrap_or(0));
            let step = step(levels[number]);
            let cells = FINE_CELLS / step;
            let at = |x: u32, y: u32| {
                let vertex = [first[0] + x * step, first[1] + y * step];
                self.place(&eye.body, vertex, levels)
            };
            let mut vertices = Vec::with_capacity(ZONE_VERTICES as usize);
            for y in 0..cells {
                for x in 0..cells {
                    let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
                    vertices.extend([a, b, d, a, d, c]);
                }
            }
            // Triangles without area, so that all zones have as many vertices.
            vertices.resize(ZONE_VERTICES as usize, vertices[0]);
            (node(number), Arc::new(vertices))
        });
        NodeVertices::sorted(eye, ZONE_VERTICES, zones.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spikes_are_the_finest_levels_alone_and_edges_are_those_of_the_coarser_zone() {
        let field = Field {
            spike_m: 500.0,
            hill: None,
        };
        let mut levels = [FINEST; ZONES * ZONES];
        let spike = [SPIKE_ROW + 1, SPIKE_ROW];
        assert!(field.drawn_m(spike, &levels) > 400.0);
        // One of the two zones about it is a level coarser.
        levels[2 * ZONES + 2] = FINEST - 1;
        assert!(field.drawn_m(spike, &levels).abs() < 2.0 * HILLS_M);
        // The zone beside has its spikes still.
        assert!(field.drawn_m([SPIKE_ROW - 1, SPIKE_ROW], &levels) > 400.0);
        // A vertex that the coarser zone does not have lies between two that it has.
        levels[2 * ZONES + 2] = 0;
        let edge = |y: u32| field.drawn_m([2 * FINE_CELLS, 2 * FINE_CELLS + y], &levels);
        assert!((edge(3) - (edge(0) + 3.0 / 8.0 * (edge(8) - edge(0)))).abs() < 1e-9);
        // Negative control: within a zone at the finest level it does not.
        let inside = |y: u32| field.drawn_m([FINE_CELLS + 5, FINE_CELLS + y], &levels);
        assert!((inside(3) - (inside(0) + 3.0 / 8.0 * (inside(8) - inside(0)))).abs() > 0.01);
    }
}
