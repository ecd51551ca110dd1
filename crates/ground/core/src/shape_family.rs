// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shapes of any number of vertices, as GeoJSON, to see how cost grows with size.
//!
//! Degrees. The same bytes for the same number on one machine; no seed is needed. Families that are
//! hard in different ways: points on one circle, long thin teeth, a coast with detail at all sizes,
//! very many holes, very many parts. Edges of most of them are too short to be split; those of a long
//! comb and of a star are not.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};
use std::fmt::Write;

/// A family of shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShapeFamily {
    /// Points on one circle: every triangulation of them is as good, which only exact predicates
    /// can tell.
    Circle,
    /// Teeth that hang from one side to the other.
    Comb,
    /// Koch's curve, a little flatter, so that it stays clear of itself.
    Fractal,
    /// A square with octagonal holes.
    Holes,
    /// Octagons apart from one another.
    Islands,
    /// Teeth so long that their edges are split.
    LongComb,
    /// The same, turned by 45°: the box of every edge overlaps those of all others.
    TurnedComb,
    /// Vertices at random distances from the middle, the edges of many of which are split.
    Star,
}

impl ShapeFamily {
    /// Every family.
    pub const ALL: [Self; 8] = [
        Self::Circle,
        Self::Comb,
        Self::Fractal,
        Self::Holes,
        Self::Islands,
        Self::LongComb,
        Self::TurnedComb,
        Self::Star,
    ];

    /// Name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Circle => "circle",
            Self::Comb => "comb",
            Self::Fractal => "fractal",
            Self::Holes => "holes",
            Self::Islands => "islands",
            Self::LongComb => "long-comb",
            Self::TurnedComb => "turned-comb",
            Self::Star => "star",
        }
    }

    /// GeoJSON of the shape with about `vertices` vertices.
    #[must_use]
    pub fn geojson(self, vertices: u32) -> String {
        match self {
            Self::Circle => polygon(&[circle([20.0, 0.0], 15.0, vertices)]),
            Self::Comb => polygon(&[comb(vertices, TOOTH_DEG)]),
            Self::LongComb => polygon(&[comb(vertices, LONG_TOOTH_DEG)]),
            Self::TurnedComb => {
                let ring = comb(vertices, LONG_TOOTH_DEG).into_iter();
                polygon(&[ring.map(turned).collect()])
            }
            Self::Star => polygon(&[star(vertices)]),
            Self::Fractal => polygon(&[coast(vertices)]),
            Self::Holes => {
                let mut rings = vec![vec![[0.0, -15.0], [30.0, -15.0], [30.0, 15.0], [0.0, 15.0]]];
                rings.extend(octagons(vertices));
                polygon(&rings)
            }
            Self::Islands => {
                let parts: Vec<String> = octagons(vertices)
                    .map(|ring| format!("[{}]", ring_text(&ring)))
                    .collect();
                let parts = parts.join(",");
                format!(r#"{{"type":"MultiPolygon","coordinates":[{parts}]}}"#)
            }
        }
    }
}

type Vertex = [f64; 2];

/// Half a tooth of the comb: short enough that edges are not split, and the vertices of the file are
/// those of the mesh.
const TOOTH_DEG: f64 = 0.2;
/// Half a tooth of the long comb.
const LONG_TOOTH_DEG: f64 = 4.75;

fn circle(center: Vertex, radius: f64, vertices: u32) -> Vec<Vertex> {
    (0..vertices)
        .map(|k| TAU * f64::from(k) / f64::from(vertices))
        .map(|angle| {
            [
                center[0] + radius * angle.cos(),
                center[1] + radius * angle.sin(),
            ]
        })
        .collect()
}

fn comb(vertices: u32, tooth_deg: f64) -> Vec<Vertex> {
    // Two vertices on every line from one side to the other, and two for the comb's back.
    let lines = vertices.max(6) / 2 - 1;
    let step = 30.0 / f64::from(lines);
    let line = |k: u32| {
        let (from, to) = if k.is_multiple_of(2) {
            (-tooth_deg, tooth_deg)
        } else {
            (tooth_deg, -tooth_deg)
        };
        let longitude = f64::from(k) * step;
        [[longitude, from], [longitude, to]]
    };
    let mut ring: Vec<Vertex> = (0..lines).flat_map(line).collect();
    ring.extend([[31.0, tooth_deg + 0.8], [-1.0, tooth_deg + 0.8]]);
    ring
}

/// By 45° about the middle of a comb.
fn turned([x, y]: Vertex) -> Vertex {
    let (x, y) = ((x - 15.0) * FRAC_1_SQRT_2, y * FRAC_1_SQRT_2);
    [15.0 + x - y, x + y]
}

/// Radii between 5° and 10°, from a linear congruential generator (Knuth's MMIX).
fn star(vertices: u32) -> Vec<Vertex> {
    let mut state = 7_u64;
    let mut radius = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        5.0 + 5.0 * (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let middle = [20.0, 0.0];
    let directions = circle([0.0, 0.0], 1.0, vertices).into_iter();
    let vertex = |direction: Vertex| {
        let radius = radius();
        [0, 1].map(|i| middle[i] + radius * direction[i])
    };
    directions.map(vertex).collect()
}

/// Triangle whose edges are replaced, in order, again and again, until there are enough vertices.
fn coast(vertices: u32) -> Vec<Vertex> {
    let mut ring = circle([20.0, 0.0], 15.0, 3);
    while ring.len() < vertices as usize {
        let mut missing = vertices as usize - ring.len();
        let mut finer = Vec::with_capacity(4 * ring.len());
        for (i, &[x, y]) in ring.iter().enumerate() {
            finer.push([x, y]);
            if missing == 0 {
                continue;
            }
            let [to_x, to_y] = ring[(i + 1) % ring.len()];
            let (dx, dy) = (to_x - x, to_y - y);
            // Outwards is to the right of a counter-clockwise ring; √3/6 would be Koch's.
            let peak = [x + 0.5 * dx + 0.25 * dy, y + 0.5 * dy - 0.25 * dx];
            let third = |k: f64| [x + dx * k / 3.0, y + dy * k / 3.0];
            for vertex in [third(1.0), peak, third(2.0)].into_iter().take(missing) {
                finer.push(vertex);
                missing -= 1;
            }
        }
        ring = finer;
    }
    ring
}

/// Octagons in rows and columns.
fn octagons(vertices: u32) -> impl Iterator<Item = Vec<Vertex>> {
    let count = (vertices / 8).max(1);
    let columns = f64::from(count).sqrt().ceil();
    let step = 28.0 / columns;
    (0..count).map(move |k| {
        let row = (f64::from(k) / columns).floor();
        let column = f64::from(k) - row * columns;
        let center = [1.0 + (column + 0.5) * step, -14.0 + (row + 0.5) * step];
        circle(center, 0.3 * step, 8)
    })
}

fn ring_text(ring: &[Vertex]) -> String {
    let mut text = String::with_capacity(40 * ring.len());
    text.push('[');
    for [longitude, latitude] in ring.iter().chain(ring.first()) {
        // Writing to a string cannot fail.
        let _ = write!(text, "[{longitude},{latitude}],");
    }
    text.pop();
    text.push(']');
    text
}

fn polygon(rings: &[Vec<Vertex>]) -> String {
    let rings: Vec<String> = rings.iter().map(|ring| ring_text(ring)).collect();
    let rings = rings.join(",");
    format!(r#"{{"type":"Polygon","coordinates":[{rings}]}}"#)
}
