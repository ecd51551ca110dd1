// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shapes of any number of vertices, as GeoJSON, to see how cost grows with size.
//!
//! Degrees. The same bytes for the same number on one machine; no seed is needed. Families that are hard in different ways: points on one circle, long thin teeth, a coast
//! with detail at all sizes, very many holes, very many parts.

use std::f64::consts::TAU;
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
}

impl ShapeFamily {
    /// Every family.
    pub const ALL: [Self; 5] = [
        Self::Circle,
        Self::Comb,
        Self::Fractal,
        Self::Holes,
        Self::Islands,
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
        }
    }

    /// GeoJSON of the shape with about `vertices` vertices.
    #[must_use]
    pub fn geojson(self, vertices: u32) -> String {
        match self {
            Self::Circle => polygon(&[circle([20.0, 0.0], 15.0, vertices)]),
            Self::Comb => polygon(&[comb(vertices)]),
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

fn comb(vertices: u32) -> Vec<Vertex> {
    // Two vertices on every line from one side to the other, and two for the comb's back.
    let lines = vertices.max(6) / 2 - 1;
    let step = 30.0 / f64::from(lines);
    let line = |k: u32| {
        let (from, to) = if k.is_multiple_of(2) {
            (-TOOTH_DEG, TOOTH_DEG)
        } else {
            (TOOTH_DEG, -TOOTH_DEG)
        };
        let longitude = f64::from(k) * step;
        [[longitude, from], [longitude, to]]
    };
    let mut ring: Vec<Vertex> = (0..lines).flat_map(line).collect();
    ring.extend([[31.0, 1.0], [-1.0, 1.0]]);
    ring
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
