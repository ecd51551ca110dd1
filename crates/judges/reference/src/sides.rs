// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which poles each ring of a polygon holds, by the rule that [`Inside`] states.
//!
//! Degrees in, square metres of the body. A ring's two sides are known by their poles: the north and
//! the south, or neither and both. How large they are follows from the number of turns that the ring
//! makes round the axis and from what lies between it and the equator.

use crate::{great_ellipse, planar};
use std::f64::consts::{FRAC_PI_2, TAU};
use terrafill_core::{EdgeRule, Ellipsoid, Inside, Polygon};

/// Sides that differ by no more than this share of the body are halves.
const HALVES: f64 = 1e-9;

/// Whether the south pole and the north pole are inside a ring.
pub(crate) type HoldsPoles = [bool; 2];

const NORTH: HoldsPoles = [false, true];
const SOUTH: HoldsPoles = [true, false];
const NEITHER: HoldsPoles = [false, false];
const BOTH: HoldsPoles = [true, true];

/// How a ring lies round the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Course {
    /// Eastwards positive.
    pub(crate) turns: i32,
    /// Signed area between the equator and the ring on its way east, square metres.
    pub(crate) above_equator_m2: f64,
}

/// The poles that each ring holds, the shell first.
pub(crate) fn poles_held(
    polygon: &Polygon,
    rule: EdgeRule,
    body: &Ellipsoid,
    inside: Inside,
) -> Vec<HoldsPoles> {
    let rings: Vec<RingSides> = polygon
        .rings()
        .enumerate()
        .map(|(index, ring)| {
            let (vertices, winding) = (ring.vertices_deg(), ring.winding_deg());
            RingSides::new(vertices, winding, index > 0, rule, body)
        })
        .collect();
    let mut held: Vec<HoldsPoles> = rings.iter().map(|ring| ring.choose(inside)).collect();
    let round_holes: Vec<usize> = (1..rings.len())
        .filter(|&i| rings[i].parts_poles())
        .collect();
    if let ([shell, ..], [first, ..]) = (&rings[..], &round_holes[..])
        && shell.parts_poles()
    {
        // All are closed over one pole; between a shell and a hole, over that on the hole's side.
        let common = match round_holes.len() % 2 {
            1 if shell.north_m2() >= rings[*first].north_m2() => NORTH,
            1 => SOUTH,
            _ => held[0],
        };
        held[0] = common;
        for hole in round_holes {
            held[hole] = common;
        }
    }
    held
}

/// The pole that a ring on its own holds.
#[cfg(test)]
pub(crate) fn poles_held_alone(
    vertices_deg: &[[f64; 2]],
    winding_deg: f64,
    rule: EdgeRule,
    body: &Ellipsoid,
) -> HoldsPoles {
    RingSides::new(vertices_deg, winding_deg, false, rule, body).choose(Inside::Smaller)
}

/// One of the two sides of a ring.
#[derive(Debug, Clone, Copy)]
struct Side {
    holds: HoldsPoles,
    area_m2: f64,
}

#[derive(Debug)]
enum RingSides {
    /// It encloses no pole, however it is read.
    OneReading,
    Two {
        /// For a shell on the left, for a hole on the right.
        oriented: Side,
        other: Side,
    },
}

impl RingSides {
    fn new(
        vertices_deg: &[[f64; 2]],
        winding_deg: f64,
        is_hole: bool,
        rule: EdgeRule,
        body: &Ellipsoid,
    ) -> Self {
        let course = match rule {
            EdgeRule::Planar => planar::course(vertices_deg, winding_deg, body),
            // What cannot be followed is refused when the ring is made ready.
            EdgeRule::GreatEllipse => great_ellipse::course(vertices_deg, body),
        };
        let Some(course) = course else {
            return Self::OneReading;
        };
        let whole_m2 = body.quadrangle_area_m2(TAU, -FRAC_PI_2, FRAC_PI_2);
        let side = |holds, area_m2| Side { holds, area_m2 };
        let turns = f64::from(course.turns);
        let [left, right] = if course.turns % 2 != 0 {
            let north_m2 = whole_m2 / 2.0 - course.above_equator_m2 / turns;
            let north = side(NORTH, north_m2);
            let south = side(SOUTH, whole_m2 - north_m2);
            if course.turns > 0 {
                [north, south]
            } else {
                [south, north]
            }
        } else if course.turns == 0 {
            // Going round a piece of the body with the piece on the left, its southern rim is passed
            // on the way east.
            let left_m2 = -course.above_equator_m2;
            let neither = side(NEITHER, left_m2.abs());
            let both = side(BOTH, whole_m2 - left_m2.abs());
            if left_m2 >= 0.0 {
                [neither, both]
            } else {
                [both, neither]
            }
        } else {
            return Self::OneReading;
        };
        let [oriented, other] = if is_hole {
            [right, left]
        } else {
            [left, right]
        };
        Self::Two { oriented, other }
    }

    fn parts_poles(&self) -> bool {
        matches!(self, Self::Two { oriented, .. } if oriented.holds[0] != oriented.holds[1])
    }

    fn north_m2(&self) -> f64 {
        match self {
            Self::Two {
                oriented, other, ..
            } => {
                if oriented.holds == NORTH {
                    oriented.area_m2
                } else {
                    other.area_m2
                }
            }
            Self::OneReading => 0.0,
        }
    }

    fn choose(&self, inside: Inside) -> HoldsPoles {
        let Self::Two { oriented, other } = self else {
            return NEITHER;
        };
        let whole_m2 = oriented.area_m2 + other.area_m2;
        let is_half = (oriented.area_m2 - other.area_m2).abs() <= HALVES * whole_m2;
        let smaller = if is_half || oriented.area_m2 < other.area_m2 {
            oriented
        } else {
            other
        };
        let is_round = smaller.holds != NEITHER;
        match inside {
            Inside::Left if is_round => oriented.holds,
            _ => smaller.holds,
        }
    }
}
