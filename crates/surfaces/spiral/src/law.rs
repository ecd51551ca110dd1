// SPDX-License-Identifier: MIT OR Apache-2.0
//! Radius of a vertex by its place along the spiral.
//!
//! Radii are angles at the body's centre, radians; `along` runs from 0 at the inner radius to 1 at the
//! outer one, in equal steps from vertex to vertex.

/// How radii grow from the inner one to the outer one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Law {
    /// By the same factor in each turn: the spiral as published.
    Exponential,
    /// The exponential one with the published correction, `√((r − r₀)/(r₁ − r₀))·(r₁ − r₀) + r₀`.
    Published,
    /// The root of the radius grows by equal steps: nearly the fewest turns on a smooth body.
    Quadratic,
    /// All turns have the same area.
    EqualArea,
    /// All turns are equally wide.
    Linear,
}

impl Law {
    pub(crate) const ALL: [(&'static str, Self); 5] = [
        ("exponential", Self::Exponential),
        ("published", Self::Published),
        ("quadratic", Self::Quadratic),
        ("equal-area", Self::EqualArea),
        ("linear", Self::Linear),
    ];

    /// Radius at `along`, from `inner` to `outer`, both above 0.
    pub(crate) fn radius(self, along: f64, inner: f64, outer: f64) -> f64 {
        // Beyond the ends the root of a negative number waits; the ends themselves must be met to the bit.
        if along <= 0.0 {
            return inner;
        }
        if along >= 1.0 {
            return outer;
        }
        let exponential = inner * (outer / inner).powf(along);
        let width = outer - inner;
        match self {
            Self::Exponential => exponential,
            Self::Published if width <= 0.0 => inner,
            // The difference may round below 0 near the inner end.
            Self::Published => ((exponential - inner).max(0.0) / width)
                .sqrt()
                .mul_add(width, inner),
            Self::Quadratic => {
                let root = inner.sqrt();
                along.mul_add(outer.sqrt() - root, root).powi(2)
            }
            Self::EqualArea => {
                let square = inner * inner;
                along.mul_add(outer * outer - square, square).sqrt()
            }
            Self::Linear => along.mul_add(width, inner),
        }
    }

    /// The widest turn that a spiral by this law may have, as a share of its outer radius, whatever its
    /// inner one.
    ///
    /// - `doubling`: turns in which the exponential radius doubles
    ///
    /// With `x` the inner radius over the outer one there are `doubling · log₂(1/x)` turns. Since
    /// `1 − x ≤ ln(1/x)`, a linear turn is at most `ln 2 / doubling` wide. So is a quadratic one: its
    /// last turn is at most `2 (1 − √x)` over their number. An equal-area turn is at most the root of the
    /// difference of squares, and a published one the root of the exponential turn.
    pub(crate) fn widest_turn(self, doubling: f64) -> f64 {
        let turn = 1.0 - (-1.0 / doubling).exp2();
        let share = match self {
            Self::Exponential => turn,
            Self::Published => turn.sqrt(),
            Self::Quadratic | Self::Linear => std::f64::consts::LN_2 / doubling,
            Self::EqualArea => (2.0 * std::f64::consts::LN_2 / doubling).sqrt(),
        };
        share.min(1.0)
    }
}
