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
            RingSides::new(vertices, winding, index > 0, rule, body, inside)
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
    let inside = Inside::Smaller;
    RingSides::new(vertices_deg, winding_deg, false, rule, body, inside).choose(inside)
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
        /// Of a shell, whatever it goes round.
        left_is_asked_for: bool,
    },
}

impl RingSides {
    fn new(
        vertices_deg: &[[f64; 2]],
        winding_deg: f64,
        is_hole: bool,
        rule: EdgeRule,
        body: &Ellipsoid,
        inside: Inside,
    ) -> Self {
        let left_is_asked_for = inside == Inside::Left && !is_hole;
        let course = match rule {
            EdgeRule::Planar if winding_deg == 0.0 && !left_is_asked_for => None,
            EdgeRule::Planar => planar::course(vertices_deg, winding_deg, body),
            // What cannot be followed is refused when the ring is made ready.
            EdgeRule::GreatEllipse => great_ellipse::course(vertices_deg, left_is_asked_for, body),
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
        Self::Two {
            oriented,
            other,
            left_is_asked_for,
        }
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
        let Self::Two {
            oriented,
            other,
            left_is_asked_for,
        } = self
        else {
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
            Inside::Left if is_round || *left_is_asked_for => oriented.holds,
            _ => smaller.holds,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODIES: [Ellipsoid; 3] = [
        Ellipsoid::UNIT_SPHERE,
        Ellipsoid::WGS84,
        Ellipsoid::SATURN_LIKE,
    ];

    fn north_m2(ring: &[[f64; 2]], winding_deg: f64, rule: EdgeRule, body: &Ellipsoid) -> f64 {
        RingSides::new(ring, winding_deg, false, rule, body, Inside::Smaller).north_m2()
    }

    #[test]
    fn areas_north_of_rings_are_those_of_closed_forms() {
        for body in BODIES {
            let north_of = |width_deg: f64, latitude_deg: f64| {
                let width_rad = width_deg.to_radians();
                body.quadrangle_area_m2(width_rad, latitude_deg.to_radians(), FRAC_PI_2)
            };
            let near = |found: f64, expected: f64| {
                let error = (found / expected - 1.0).abs();
                assert!(error < 1e-12, "{}: {found}, not {expected}", body.name());
            };
            for latitude in [-80.0, -10.0, 0.0, 45.0, 89.0] {
                let parallel = [[0.0, latitude], [100.0, latitude]];
                near(
                    north_m2(&parallel, 360.0, EdgeRule::Planar, &body),
                    north_of(360.0, latitude),
                );
            }
            // A triangle wave is as much north of its middle as south of it only about the equator.
            let wave = [[0.0, -60.0], [90.0, 60.0], [180.0, -60.0], [270.0, 60.0]];
            near(
                north_m2(&wave, 360.0, EdgeRule::Planar, &body),
                north_of(360.0, 0.0),
            );
            // Three quarters of the equator and two meridians, closed on the pole's other side.
            let wide = [
                [0.0, 0.0],
                [90.0, 0.0],
                [180.0, 0.0],
                [270.0, 0.0],
                [7.0, 90.0],
            ];
            near(
                north_m2(&wide, 0.0, EdgeRule::GreatEllipse, &body),
                north_of(270.0, 0.0),
            );
            // Inclined great ellipses are halves, those that come near the poles too.
            for top in [1.0, 45.0, 89.999_999] {
                let inclined = [[0.0, 0.0], [90.0, top], [180.0, 0.0], [-90.0, -top]];
                near(
                    north_m2(&inclined, 0.0, EdgeRule::GreatEllipse, &body),
                    north_of(360.0, 0.0),
                );
            }
        }
        // Negative control: the formulas of another body are noticed.
        let wide = [[0.0, 10.0], [90.0, 10.0], [180.0, 10.0], [270.0, 10.0]];
        let share = |body: &Ellipsoid| {
            let whole_m2 = body.quadrangle_area_m2(TAU, -FRAC_PI_2, FRAC_PI_2);
            north_m2(&wide, 0.0, EdgeRule::GreatEllipse, body) / whole_m2
        };
        assert!((share(&BODIES[1]) - share(&BODIES[2])).abs() > 1e-4);
    }

    #[test]
    fn great_ellipses_on_the_sphere_leave_girards_areas() {
        // Right triangles between the equator and a meridian: tan(E/2) = tan(a/2) tan(b/2).
        let top = 60_f64;
        let lens =
            4.0 * ((45_f64.to_radians() / 2.0).tan() * (top.to_radians() / 2.0).tan()).atan();
        let ring = [
            [0.0, 0.0],
            [45.0, top],
            [90.0, 0.0],
            [180.0, 0.0],
            [-90.0, 0.0],
        ];
        let found = north_m2(&ring, 0.0, EdgeRule::GreatEllipse, &Ellipsoid::UNIT_SPHERE);
        assert!((found - (TAU - lens)).abs() < 1e-12, "{found}");
    }

    #[test]
    fn orientation_decides_of_halves_and_of_nothing_else_unless_asked_for() {
        let equator = |latitude: f64| [[-180.0, latitude], [-60.0, latitude], [60.0, latitude]];
        let held = |latitude: f64, eastward: bool, is_hole: bool, inside: Inside, rule| {
            let mut ring = equator(latitude);
            let mut winding_deg = 360.0;
            if !eastward {
                ring.reverse();
                winding_deg = -360.0;
            }
            let body = &Ellipsoid::WGS84;
            RingSides::new(&ring, winding_deg, is_hole, rule, body, inside).choose(inside)
        };
        for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
            for (eastward, is_hole) in [(true, false), (false, false), (true, true), (false, true)]
            {
                let oriented = if eastward == is_hole { SOUTH } else { NORTH };
                for inside in [Inside::Smaller, Inside::Left] {
                    assert_eq!(held(0.0, eastward, is_hole, inside, rule), oriented);
                }
                assert_eq!(held(1.0, eastward, is_hole, Inside::Smaller, rule), NORTH);
                assert_eq!(held(-1.0, eastward, is_hole, Inside::Smaller, rule), SOUTH);
                for latitude in [1.0, -1.0] {
                    assert_eq!(
                        held(latitude, eastward, is_hole, Inside::Left, rule),
                        oriented
                    );
                }
            }
        }
    }
}
