// SPDX-License-Identifier: MIT OR Apache-2.0
//! Inside tests for a ring whose edges are straight in longitude and latitude.
//!
//! Degrees. A ring lies where its numbers put it, so a point is looked for at its longitude plus
//! every whole number of turns. Two tests:
//!
//! - *Meridian*: parity of the edges crossed on the way north, exact orientation (Shewchuk, 1997,
//!   "Adaptive Precision Floating-Point Arithmetic", by the crate `robust`). A ring that winds
//!   round the axis is a periodic curve, crossed an odd number of times on the way from pole to
//!   pole; so the parity says on which side of it a point is.
//! - *Parallel*: winding number from signed crossings on the way east, in plain f64. A ring that
//!   winds round the axis is closed over its pole first: up the meridian where it ends and down
//!   the one where it starts, which are the same and cancel.
//!
//! Edges are half-open, so a vertex between two of them counts once. The plain test may differ
//! from the exact one within rounding of an edge; that is what comparing the two is for.
//!
//! Which pole a winding ring holds is decided by `sides`, and also whether one that does not wind holds
//! all but what it goes round. Where a ring crosses itself, the
//! even-odd rule counts.

use crate::point::{
    Bounds, LocatorError, Point, RingCourse, RingSource, Verdicts, on_longitude_grid,
};
use crate::slabs::Slabs;
use robust::{Coord, orient2d};
use terrafill_core::Ellipsoid;

/// Longitudes farther out are refused: beyond 1024 the grid is no longer exact.
const LARGEST_LONGITUDE_DEG: f64 = 720.0;

/// A ring with an index for each of the two tests.
#[derive(Debug, Clone)]
pub(crate) struct PlanarRing {
    /// The ring's edges; of a winding ring, one period.
    edges: Vec<[[f64; 2]; 2]>,
    /// The same, closed over the pole.
    closed_edges: Vec<[[f64; 2]; 2]>,
    /// Which pole a winding ring holds.
    holds_north: Option<bool>,
    /// Whether it holds all but the part of the plane that it goes round.
    is_inverted: bool,
    bounds: Bounds,
    by_longitude: Slabs,
    by_latitude: Slabs,
}

impl PlanarRing {
    /// # Errors
    /// [`LocatorError`] when the numbers leave open where the ring is.
    pub(crate) fn new(source: &RingSource<'_>) -> Result<Self, LocatorError> {
        let edges = edges_of(source);
        let bounds = bounds_of(source, &edges)?;
        let winds = source.winding_deg != 0.0;
        let holds_north = winds.then_some(source.holds_poles[1]);
        let is_inverted = !winds && source.holds_poles == [true; 2];
        let mut closed_edges = edges.clone();
        if let (Some(north), Some(first), Some(last)) = (holds_north, edges.first(), edges.last()) {
            let pole = if north { 90.0 } else { -90.0 };
            let (start, end) = (first[0], last[1]);
            closed_edges.push([end, [end[0], pole]]);
            closed_edges.push([[end[0], pole], [start[0], pole]]);
            closed_edges.push([[start[0], pole], start]);
        }
        let bounds = Bounds {
            north: if is_inverted || holds_north == Some(true) {
                90.0
            } else {
                bounds.north
            },
            south: if is_inverted || holds_north == Some(false) {
                -90.0
            } else {
                bounds.south
            },
            east: if is_inverted {
                bounds.east.max(bounds.west + 360.0)
            } else {
                bounds.east
            },
            ..bounds
        };
        Ok(Self {
            by_longitude: Slabs::new(bounds.west, bounds.east, &intervals(&edges, 0)),
            by_latitude: Slabs::new(bounds.south, bounds.north, &intervals(&closed_edges, 1)),
            edges,
            closed_edges,
            holds_north,
            is_inverted,
            bounds,
        })
    }

    /// Nothing of the ring's inside lies beyond.
    pub(crate) fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Both tests, by the index.
    pub(crate) fn holds(&self, point: &Point) -> Verdicts {
        if point.latitude_deg < self.bounds.south || point.latitude_deg > self.bounds.north {
            return Verdicts::default();
        }
        let mut north = 0;
        let mut winding = 0;
        for x in self.longitudes_of(point) {
            let near = self
                .by_longitude
                .at(x)
                .iter()
                .map(|&edge| &self.edges[edge as usize]);
            north += crossings_to_the_north(near, x, point.latitude_deg);
            let near = self.by_latitude.at(point.latitude_deg).iter();
            let near = near.map(|&edge| &self.closed_edges[edge as usize]);
            winding += winding_by_the_parallel(near, x, point.latitude_deg);
        }
        self.verdicts(north, winding)
    }

    /// Both tests over every edge.
    #[cfg(test)]
    pub(crate) fn holds_brute(&self, point: &Point) -> Verdicts {
        let mut north = 0;
        let mut winding = 0;
        for turn in -3..=3 {
            let x = point.longitude_deg + 360.0 * f64::from(turn);
            north += crossings_to_the_north(self.edges.iter(), x, point.latitude_deg);
            winding += winding_by_the_parallel(self.closed_edges.iter(), x, point.latitude_deg);
        }
        self.verdicts(north, winding)
    }

    fn verdicts(&self, crossings_north: u32, winding: i32) -> Verdicts {
        let holds_north = self.is_inverted || self.holds_north == Some(true);
        Verdicts {
            first: (crossings_north % 2 == 1) != holds_north,
            second: (winding % 2 != 0) != self.is_inverted,
        }
    }

    /// The point's longitude plus whole turns, as far as the ring reaches.
    fn longitudes_of(&self, point: &Point) -> impl Iterator<Item = f64> + use<> {
        let (west, east) = (self.bounds.west, self.bounds.east);
        let first = ((west - point.longitude_deg) / 360.0).ceil();
        let start = point.longitude_deg + 360.0 * first;
        (0..4)
            .map(move |turn| start + 360.0 * f64::from(turn))
            .take_while(move |&x| x <= east)
    }
}

/// How a ring lies round the axis.
pub(crate) fn course(
    vertices_deg: &[[f64; 2]],
    winding_deg: f64,
    body: &Ellipsoid,
) -> Option<RingCourse> {
    let first = *vertices_deg.first()?;
    let end = [first[0] + winding_deg, first[1]];
    let ends = vertices_deg[1..].iter().chain([&end]);
    let edges = vertices_deg.iter().zip(ends);
    Some(RingCourse {
        turns: if winding_deg == 0.0 {
            0
        } else if winding_deg > 0.0 {
            1
        } else {
            -1
        },
        above_equator_m2: edges
            .map(|(from, to)| above_equator_m2(*from, *to, body))
            .sum(),
    })
}

/// Area between an edge and the equator by Simpson's rule: along it, the area of the zone up to it
/// changes evenly with longitude.
fn above_equator_m2(from: [f64; 2], to: [f64; 2], body: &Ellipsoid) -> f64 {
    /// An error of 1e-13.
    const STEP_DEG: f64 = 0.25;
    let steps = ((to[1] - from[1]).abs() / STEP_DEG).ceil().max(1.0);
    let zone_m2 = |step: f64| {
        let latitude_deg = from[1] + (to[1] - from[1]) * step / steps;
        body.zone_area_per_radian(latitude_deg.to_radians())
    };
    let mut sum = 0.0;
    let mut step = 0.0;
    while step < steps {
        sum += zone_m2(step) + 4.0 * zone_m2(step + 0.5) + zone_m2(step + 1.0);
        step += 1.0;
    }
    (to[0] - from[0]).to_radians() * sum / (6.0 * steps)
}

/// Edges north of (`x`, `y`) on its meridian.
fn crossings_to_the_north<'a>(
    edges: impl Iterator<Item = &'a [[f64; 2]; 2]>,
    x: f64,
    y: f64,
) -> u32 {
    let mut crossings = 0;
    for &[a, b] in edges {
        let (west, east) = if a[0] < b[0] { (a, b) } else { (b, a) };
        if west[0] <= x && x < east[0] {
            let coordinate = |p: [f64; 2]| Coord { x: p[0], y: p[1] };
            let side = orient2d(coordinate(west), coordinate(east), Coord { x, y });
            crossings += u32::from(side < 0.0);
        }
    }
    crossings
}

/// Winding number of `edges`, a closed curve or several, round (`x`, `y`).
fn winding_by_the_parallel<'a>(
    edges: impl Iterator<Item = &'a [[f64; 2]; 2]>,
    x: f64,
    y: f64,
) -> i32 {
    let mut winding = 0;
    for &[from, to] in edges {
        let rises = from[1] <= y && to[1] > y;
        let falls = to[1] <= y && from[1] > y;
        if rises || falls {
            let share = (y - from[1]) / (to[1] - from[1]);
            let longitude = from[0] + share * (to[0] - from[0]);
            if longitude > x {
                winding += if rises { 1 } else { -1 };
            }
        }
    }
    winding
}

fn edges_of(source: &RingSource<'_>) -> Vec<[[f64; 2]; 2]> {
    let vertices: Vec<[f64; 2]> = source
        .vertices_deg
        .iter()
        .map(|vertex| [on_longitude_grid(vertex[0]), vertex[1]])
        .collect();
    let first = vertices
        .first()
        .map(|first| [first[0] + source.winding_deg, first[1]]);
    let ends = vertices.iter().skip(1).copied().chain(first);
    vertices
        .iter()
        .copied()
        .zip(ends)
        .map(|(from, to)| [from, to])
        .collect()
}

fn bounds_of(source: &RingSource<'_>, edges: &[[[f64; 2]; 2]]) -> Result<Bounds, LocatorError> {
    let winding_is_a_turn = source.winding_deg == 0.0 || source.winding_deg.abs() == 360.0;
    if !winding_is_a_turn {
        return Err(source.winding_error());
    }
    let mut bounds = Bounds::EMPTY;
    for vertex in edges.iter().flatten() {
        bounds.include(*vertex);
    }
    let farthest = bounds.west.abs().max(bounds.east.abs());
    if farthest > LARGEST_LONGITUDE_DEG {
        return Err(source.longitude_error(farthest, LARGEST_LONGITUDE_DEG));
    }
    // A ring that comes back to where it started after more than a turn lies over itself.
    let width = bounds.east - bounds.west;
    if source.winding_deg == 0.0 && width > 360.0 {
        return Err(source.width_error(width));
    }
    Ok(bounds)
}

/// Reach of each edge along `axis`.
fn intervals(edges: &[[[f64; 2]; 2]], axis: usize) -> Vec<(u32, f64, f64)> {
    edges
        .iter()
        .zip(0..)
        .map(|([a, b], item)| (item, a[axis].min(b[axis]), a[axis].max(b[axis])))
        .collect()
}
