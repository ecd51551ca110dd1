// SPDX-License-Identifier: MIT OR Apache-2.0
//! Minimax approximations of the arctangent on [0, 1]: the generator of `coefficients.csv`.
//!
//! Remez' exchange with one reference point per sign: solve for the coefficients and the levelled
//! error on the reference, take the error's extrema as the next reference, until they are equal to
//! twelve digits. Rationals solve the levelled equations with the last error in the products, until
//! it stands still (Fraser and Hart 1962, "On the computation of rational approximations to
//! continuous functions"; Cody 1970, "A survey of practical rational and polynomial approximation
//! of functions", for weights). All in double-double, see there for why.
//!
//! Every family is `x · R(x)` with `R` near `g(x) = atan(x) / x`, so the error looked at is
//! `s(x) (g(x) − R(x))` with `s = x` for the absolute and `1 / g` for the relative one.

use crate::double_double::DoubleDouble as Dd;
use std::fmt::Write as _;
use terrafill_texture::{AngleCore, Weight};

/// Exchanges after which a fit is given up; none needs more than nine.
const EXCHANGES: usize = 40;
/// Equal extrema, relative.
const LEVEL: f64 = 1e-12;
/// Grid points for each point of the reference.
const GRID_PER_POINT: u32 = 60;

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum RemezError {
    /// The core has no coefficients to be fitted: the device's own, a table, another project's.
    #[error("{core} has no coefficients")]
    NoFamily {
        /// Its name.
        core: String,
    },
    /// The error changes sign too seldom for an exchange.
    #[error("{core}: error alternates {found} times, needs {needed}")]
    Alternations {
        /// Its name.
        core: String,
        /// Extrema of alternating sign.
        found: usize,
        /// Points of the reference.
        needed: usize,
    },
    /// The extrema did not become equal.
    #[error("{core}: extrema still differ by {found} of the error, needs {required}")]
    NotLevel {
        /// Its name.
        core: String,
        /// Relative difference.
        found: f64,
        /// What would do.
        required: f64,
    },
}

/// A minimax approximation.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fit {
    /// Largest error: absolute in radians, or relative for [`Weight::Relative`].
    pub(crate) error: f64,
    /// Coefficients of P, ascending.
    pub(crate) numerator: Vec<f64>,
    /// Coefficients of Q, ascending, the first 1; empty for polynomials.
    pub(crate) denominator: Vec<f64>,
    /// Where the error is largest, ascending: one more than there are free coefficients.
    pub(crate) reference: Vec<f64>,
}

/// The shape of an approximation.
struct Family {
    core: AngleCore,
    /// Powers go up by two: `R` in x².
    even: bool,
    weight: Weight,
    /// Free coefficients of P and Q.
    numerator: usize,
    denominator: usize,
}

/// Place, target `g` and scale `s` there.
#[derive(Clone, Copy)]
struct Node {
    x: Dd,
    g: Dd,
    s: Dd,
}

impl Family {
    fn of(core: AngleCore) -> Option<Self> {
        let family = |even, weight, numerator: u8, denominator: u8| Self {
            core,
            even,
            weight,
            numerator: usize::from(numerator),
            denominator: usize::from(denominator),
        };
        match core {
            AngleCore::Native | AngleCore::CesiumCubic | AngleCore::Lookup { .. } => None,
            AngleCore::Odd { degree, weight } => {
                // Pinning fixes two of the coefficients.
                let fixed = if weight == Weight::Pinned { 2 } else { 0 };
                Some(family(true, weight, degree / 2 + 1 - fixed, 0))
            }
            AngleCore::Dense { degree } => Some(family(false, Weight::Absolute, degree, 0)),
            AngleCore::Rational {
                numerator,
                denominator,
                weight,
            } => Some(family(true, weight, numerator + 1, denominator)),
        }
    }

    fn points(&self) -> usize {
        self.numerator + self.denominator + 1
    }

    fn node(&self, x: f64) -> Node {
        let x = Dd::from(x);
        let g = if x.to_f64() > 0.0 {
            x.arctangent() / x
        } else {
            Dd::ONE
        };
        let s = match self.weight {
            Weight::Relative => Dd::ONE / g,
            Weight::Absolute | Weight::Pinned => x,
        };
        Node { x, g, s }
    }

    /// What the powers are powers of.
    fn variable(&self, x: Dd) -> Dd {
        if self.even { x * x } else { x }
    }

    /// The part of `R` that is not free: `1 + (π/4 − 1) u` for pinned ones.
    fn base(&self, u: Dd) -> Dd {
        match self.weight {
            Weight::Pinned => Dd::ONE + (Dd::ONE.arctangent() - Dd::ONE) * u,
            Weight::Absolute | Weight::Relative => Dd::ZERO,
        }
    }

    /// Basis functions of P at `u`: powers, or `uᵏ⁺² − u` for pinned ones, which vanish at 0 and 1.
    fn basis(&self, u: Dd) -> Vec<Dd> {
        let pinned = self.weight == Weight::Pinned;
        let mut power = if pinned { u * u } else { Dd::ONE };
        let mut list = Vec::with_capacity(self.numerator);
        for _ in 0..self.numerator {
            list.push(if pinned { power - u } else { power });
            power = power * u;
        }
        list
    }

    /// First reference: where Chebyshev polynomials have their extrema, at the ends only where the
    /// error is not zero by construction.
    fn first_reference(&self) -> Vec<f64> {
        let count = self.points();
        let number = |i: usize| u32::try_from(i).map_or(f64::NAN, f64::from);
        (0..count)
            .map(|i| {
                let turn = match self.weight {
                    Weight::Absolute => (number(i) + 1.0) / number(count),
                    Weight::Relative => number(i) / number(count - 1),
                    Weight::Pinned => (number(i) + 0.5) / number(count),
                };
                if self.even {
                    (turn * std::f64::consts::FRAC_PI_2).sin()
                } else {
                    0.5 - 0.5 * (turn * std::f64::consts::PI).cos()
                }
            })
            .collect()
    }

    /// Free coefficients and the levelled error on the reference.
    ///
    /// A rational's equations hold products of the error and Q's coefficients: with an error assumed
    /// in them they are linear and give another one, and the secant method finds where the two are
    /// equal. Assuming the last one given instead swings about the solution and from degree 2, 3 on
    /// leaves it.
    fn solve(&self, nodes: &[Node]) -> Solution {
        let mut assumed = Dd::ZERO;
        let mut solution = self.solve_with(nodes, assumed);
        if self.denominator == 0 {
            return solution;
        }
        let mut excess = solution.error;
        let mut next = solution.error;
        for _ in 0..40 {
            solution = self.solve_with(nodes, next);
            let next_excess = solution.error - next;
            let size = next.abs().to_f64();
            if next_excess.abs().to_f64() <= 1e-24 * size {
                break;
            }
            let step = next_excess * (next - assumed) / (next_excess - excess);
            (assumed, excess) = (next, next_excess);
            next = next - step;
        }
        solution
    }

    fn solve_with(&self, nodes: &[Node], last_error: Dd) -> Solution {
        let mut sign = Dd::ONE;
        let mut rows = Vec::with_capacity(nodes.len());
        for node in nodes {
            let u = self.variable(node.x);
            let target = node.g - self.base(u);
            let mut row = self.basis(u);
            let mut power = u;
            for _ in 0..self.denominator {
                row.push(-(power * (target - sign * last_error / node.s)));
                power = power * u;
            }
            row.push(sign / node.s);
            row.push(target);
            rows.push(row);
            sign = -sign;
        }
        let mut unknowns = eliminate(rows);
        let error = unknowns.pop().unwrap_or(Dd::ZERO);
        let denominator = unknowns.split_off(self.numerator);
        Solution {
            numerator: unknowns,
            denominator,
            error,
        }
    }

    /// `s (g − R)` at a node.
    fn error_at(&self, solution: &Solution, node: &Node) -> f64 {
        let u = self.variable(node.x);
        let mut top = Dd::ZERO;
        for (basis, coefficient) in self.basis(u).into_iter().zip(&solution.numerator) {
            top = top + basis * *coefficient;
        }
        let (mut bottom, mut power) = (Dd::ONE, u);
        for coefficient in &solution.denominator {
            bottom = bottom + power * *coefficient;
            power = power * u;
        }
        (node.s * (node.g - self.base(u) - top / bottom)).to_f64()
    }

    /// Extrema of alternating sign, as many as the reference has points.
    fn extrema(&self, solution: &Solution, grid: &[Node]) -> Result<Vec<(f64, f64)>, RemezError> {
        let errors: Vec<f64> = grid
            .iter()
            .map(|node| self.error_at(solution, node))
            .collect();
        let mut runs: Vec<(usize, f64)> = Vec::new();
        for (place, &error) in errors.iter().enumerate() {
            match runs.last_mut() {
                Some(last) if last.1 * error > 0.0 => {
                    let larger = error.abs() > last.1.abs();
                    *last = if larger { (place, error) } else { *last };
                }
                _ if error.abs() > 0.0 => runs.push((place, error)),
                _ => {}
            }
        }
        let needed = self.points();
        // The ends may show a sign of rounding where the error is zero by construction.
        while runs.len() > needed {
            let smaller_first = runs[0].1.abs() < runs[runs.len() - 1].1.abs();
            runs.remove(if smaller_first { 0 } else { runs.len() - 1 });
        }
        if runs.len() < needed {
            return Err(RemezError::Alternations {
                core: self.core.name(),
                found: runs.len(),
                needed,
            });
        }
        let refine = |(place, error)| self.refined(solution, grid, place, error);
        Ok(runs.into_iter().map(refine).collect())
    }

    /// The extremum near a grid point: parabolas through three points, each a tenth as wide.
    fn refined(&self, solution: &Solution, grid: &[Node], place: usize, error: f64) -> (f64, f64) {
        let x = |i: usize| grid[i].x.to_f64();
        let mut best = (x(place), error);
        if place == 0 || place + 1 == grid.len() {
            return best;
        }
        let mut step = 0.5 * (x(place + 1) - x(place - 1));
        for _ in 0..4 {
            let at = |x: f64| self.error_at(solution, &self.node(x.clamp(0.0, 1.0)));
            let (left, right) = (at(best.0 - step), at(best.0 + step));
            let bend = left - 2.0 * best.1 + right;
            if bend * best.1 < 0.0 {
                let moved = best.0 + (0.5 * step * (left - right) / bend).clamp(-step, step);
                let there = at(moved);
                if there.abs() >= best.1.abs() {
                    best = (moved, there);
                }
            }
            step *= 0.1;
        }
        best
    }

    /// All coefficients of P, the fixed ones put back.
    fn numerator_of(&self, solution: &Solution) -> Vec<f64> {
        if self.weight != Weight::Pinned {
            return solution.numerator.iter().map(|c| c.to_f64()).collect();
        }
        let mut linear = Dd::ONE.arctangent() - Dd::ONE;
        for coefficient in &solution.numerator {
            linear = linear - *coefficient;
        }
        let free = solution.numerator.iter().map(|c| c.to_f64());
        [1.0, linear.to_f64()].into_iter().chain(free).collect()
    }
}

/// What a levelled system gives.
struct Solution {
    numerator: Vec<Dd>,
    denominator: Vec<Dd>,
    error: Dd,
}

/// Gauss' elimination with the largest pivot of each column; the last column is the right-hand side.
fn eliminate(mut rows: Vec<Vec<Dd>>) -> Vec<Dd> {
    let count = rows.len();
    for column in 0..count {
        let size = |row: usize, rows: &[Vec<Dd>]| rows[row][column].abs().to_f64();
        let pivot = (column..count)
            .max_by(|&a, &b| size(a, &rows).total_cmp(&size(b, &rows)))
            .unwrap_or(column);
        rows.swap(column, pivot);
        let (above, below) = rows.split_at_mut(column + 1);
        let top = &above[column];
        for row in below {
            let factor = row[column] / top[column];
            for (cell, over) in row.iter_mut().zip(top).skip(column) {
                *cell = *cell - factor * *over;
            }
        }
    }
    let mut unknowns = vec![Dd::ZERO; count];
    for row in (0..count).rev() {
        let mut rest = rows[row][count];
        for column in row + 1..count {
            rest = rest - rows[row][column] * unknowns[column];
        }
        unknowns[row] = rest / rows[row][row];
    }
    unknowns
}

/// Coefficients of `core` with the smallest largest error on [0, 1].
///
/// # Errors
/// [`RemezError::NoFamily`] for cores without coefficients, the others where the exchange fails.
pub(crate) fn fit(core: AngleCore) -> Result<Fit, RemezError> {
    let Some(family) = Family::of(core) else {
        return Err(RemezError::NoFamily { core: core.name() });
    };
    let points = u32::try_from(family.points()).unwrap_or(u32::MAX);
    let cells = f64::from(points * GRID_PER_POINT);
    let grid: Vec<Node> = (0..=points * GRID_PER_POINT)
        .map(|i| 0.5 - 0.5 * (f64::from(i) / cells * std::f64::consts::PI).cos())
        .map(|x| family.node(x))
        .collect();
    let mut reference = family.first_reference();
    let mut spread = f64::INFINITY;
    for _ in 0..EXCHANGES {
        let nodes: Vec<Node> = reference.iter().map(|x| family.node(*x)).collect();
        let solution = family.solve(&nodes);
        let extrema = family.extrema(&solution, &grid)?;
        let sizes = || extrema.iter().map(|(_, error)| error.abs());
        let (least, most) = (
            sizes().fold(f64::INFINITY, f64::min),
            sizes().fold(0.0, f64::max),
        );
        spread = (most - least) / most;
        if spread < LEVEL {
            let ones = std::iter::once(1.0);
            let denominator = solution.denominator.iter().map(|c| c.to_f64());
            return Ok(Fit {
                error: most,
                numerator: family.numerator_of(&solution),
                denominator: if family.denominator > 0 {
                    ones.chain(denominator).collect()
                } else {
                    Vec::new()
                },
                reference: extrema.into_iter().map(|(x, _)| x).collect(),
            });
        }
        reference = extrema.into_iter().map(|(x, _)| x).collect();
    }
    Err(RemezError::NotLevel {
        core: core.name(),
        found: spread,
        required: LEVEL,
    })
}

/// The text of `coefficients.csv`: every core that has coefficients, fitted anew.
///
/// # Errors
/// Of the first core that has no fit.
pub(crate) fn coefficients_table() -> Result<String, RemezError> {
    let list = |numbers: &[f64]| {
        let numbers: Vec<String> = numbers.iter().map(|number| format!("{number:?}")).collect();
        numbers.join(" ")
    };
    let mut text = "core,error,numerator,denominator\n".to_owned();
    let all = AngleCore::all().into_iter();
    for core in all.filter(|core| Family::of(*core).is_some()) {
        let found = fit(core)?;
        let (numerator, denominator) = (list(&found.numerator), list(&found.denominator));
        let (name, error) = (core.name(), found.error);
        let _ = writeln!(text, "{name},{error:e},{numerator},{denominator}");
    }
    Ok(text)
}
