// SPDX-License-Identifier: MIT OR Apache-2.0
//! The mesh before it is laid on a body: turns of each vertex, and triangles.
//!
//! Vertex `k` lies at the angle `k · step` clockwise from north, and at the share `k · step / turns` of the
//! way from the inner radius to the outer one. A strip joins each turn with the next; a fan fills the hole
//! inside the first turn. Beyond the outer radius vertices stay on it, so that the rim is a circle.

use std::f64::consts::TAU;

/// Which vertices triangles name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Indices {
    /// Vertices `k` and `k + n`: neighbouring turns share every vertex, whatever the step.
    Watertight,
    /// As published: each quad of the strip makes vertices at `spin`, `spin + 360°` and a step further. Where
    /// the step does not divide a turn, neighbouring turns are sampled at other angles and cracks open. The
    /// fan ends on the first edge of the strip, on which vertex 0 lies: a T-junction.
    Published,
}

impl Indices {
    pub(crate) const ALL: [(&'static str, Self); 2] = [
        ("watertight", Self::Watertight),
        ("published", Self::Published),
    ];
}

/// A vertex of the spiral.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SpiralVertex {
    /// Clockwise from north, radians.
    pub(crate) angle_rad: f64,
    /// 0 … 1 from the inner radius to the outer one; the centre of the fan has none.
    pub(crate) along: Option<f64>,
}

/// Vertices and triangles, the fan's first; counter-clockwise seen from above.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    pub(crate) places: Vec<SpiralVertex>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Triangles of the fan.
    pub(crate) fan: usize,
}

/// Steps of a turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Steps {
    /// Vertices of a turn.
    pub(crate) per_turn: u32,
    /// Between two vertices, radians.
    pub(crate) step_rad: f64,
}

impl Steps {
    pub(crate) fn new(step_deg: f64) -> Self {
        #[allow(
            clippy::cast_possible_truncation,
            reason = "a step is at least a degree"
        )]
        let per_turn = (360.0 / step_deg).round() as u32;
        Self {
            per_turn,
            step_rad: step_deg.to_radians(),
        }
    }

    /// Whether a whole number of steps is a turn.
    fn divides(self) -> bool {
        (self.step_rad * f64::from(self.per_turn) - TAU).abs() < 1e-9
    }

    /// The widest angle between two vertices of an edge that goes around, radians: the last of a turn may
    /// be wider than a step.
    pub(crate) fn widest_rad(self) -> f64 {
        let rest = TAU - self.step_rad * f64::from(self.per_turn);
        self.step_rad + rest.abs()
    }

    /// Angle of vertex `k`, the same to the bit in every turn where the step divides one.
    fn angle_rad(self, k: u32) -> f64 {
        if self.divides() {
            f64::from(k % self.per_turn) * (TAU / f64::from(self.per_turn))
        } else {
            f64::from(k) * self.step_rad
        }
    }

    /// Turns up to vertex `k`.
    fn turns(self, k: u32) -> f64 {
        if self.divides() {
            f64::from(k) / f64::from(self.per_turn)
        } else {
            f64::from(k) * self.step_rad / TAU
        }
    }
}

/// - `turns`: from the inner radius to the outer one; 0 leaves the fan alone
pub(crate) fn lay_out(steps: Steps, turns: f64, indices: Indices) -> Layout {
    match indices {
        Indices::Watertight => watertight(steps, turns),
        Indices::Published => published(steps, turns),
    }
}

const CENTER: SpiralVertex = SpiralVertex {
    angle_rad: 0.0,
    along: None,
};

/// Share of the way after `at` turns of `turns`.
fn along(at: f64, turns: f64) -> Option<f64> {
    Some(if at < turns { at / turns } else { 1.0 })
}

/// Vertex 0 is the centre, the spiral follows. The last fan triangle and one more close the first turn
/// without the T-junction; one triangle closes the rim. Where the step does not divide a turn its edge on the
/// rim is wider than others, and the triangle may lie beyond it, turned over.
fn watertight(steps: Steps, turns: f64) -> Layout {
    let n = steps.per_turn;
    // The first vertex on the outer radius.
    let mut rim = 0;
    while steps.turns(rim) < turns {
        rim += 1;
    }
    let spiral = (0..rim + n).map(|k| SpiralVertex {
        angle_rad: steps.angle_rad(k),
        along: along(steps.turns(k), turns),
    });
    let at = |k: u32| k + 1;
    let mut triangles: Vec<[u32; 3]> = (0..n).map(|k| [0, at((k + 1) % n), at(k)]).collect();
    if rim > 0 {
        triangles.push([at(0), at(n), at(n - 1)]);
    }
    let fan = triangles.len();
    for k in 0..rim {
        triangles.push([at(k), at(k + 1), at(k + n)]);
        // After the last one the circle is closed by the first vertex on it.
        if k + 1 < rim {
            triangles.push([at(k + 1), at(k + n + 1), at(k + n)]);
        }
    }
    Layout {
        places: std::iter::once(CENTER).chain(spiral).collect(),
        triangles,
        fan,
    }
}

/// Each of the strip's vertices is made twice, once as an outer and once as an inner one.
fn published(steps: Steps, turns: f64) -> Layout {
    let n = steps.per_turn;
    let mut places = vec![CENTER];
    let mut triangles = Vec::new();
    let inner = |k: u32| SpiralVertex {
        angle_rad: steps.angle_rad(k),
        along: along(steps.turns(k), turns),
    };
    let outer = |k: u32| SpiralVertex {
        along: along(steps.turns(k) + 1.0, turns),
        ..inner(k)
    };
    // The fan's last spoke is a whole turn after its first.
    let mut last = 0;
    while steps.turns(last) < 1.0 - 1e-12 {
        places.push(inner(last));
        last += 1;
    }
    places.push(outer(0));
    triangles.extend((1..=last).map(|k| [0, k + 1, k]));
    let fan = triangles.len();
    let mut first = last + 2;
    let mut k = 0;
    while steps.turns(k) < turns {
        places.extend([inner(k), outer(k), inner(k + 1), outer(k + 1)]);
        triangles.push([first, first + 2, first + 1]);
        triangles.push([first + 2, first + 3, first + 1]);
        first += 4;
        k += 1;
    }
    debug_assert!(n >= 3, "a turn has three vertices at least");
    Layout {
        places,
        triangles,
        fan,
    }
}
