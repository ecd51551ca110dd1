// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which side of a ring is inside, where a pole lies in it.
//!
//! Degrees in, square metres of the body out. A planar ring that ends where it started encloses a
//! part of the plane of longitude and latitude. One that ends a turn on divides the body in two, and
//! so does every ring of great ellipses. Of the two sides the smaller one is meant ([`Inside`]), as
//! in S2's normalised loops. Their areas are integrals along the edges, so that a vertex on an edge
//! changes nothing: `U = ∮ Z dλ`, with Z the area from the equator to a latitude per radian of
//! longitude. For a ring that goes once round eastwards it is the area south of it, less half the
//! body. For a ring that does not go round it is the area on its left, negated.

use crate::edge::area::{ZoneArea, compensated_sum};
use crate::pieces::{or_at_pole, ring_pieces};
use crate::{EdgeRule, Ellipsoid, Inside, Polygon, Ring};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Sides that differ by less than this share of the body are halves: a thousand times what rounding
/// makes of the area of a million edges.
const HALF_TOLERANCE: f64 = 1e-9;

/// Which poles are inside a ring.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RingSide {
    /// Whether the south pole and the north pole are.
    pub holds_poles: [bool; 2],
    /// Where the smaller side is not the one that the ring's orientation says.
    pub choice: Option<SideChoice>,
}

/// Two readings of a ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SideChoice {
    /// Area of the side that was taken, square metres.
    pub taken_m2: f64,
    /// Area of the other, square metres.
    pub other_m2: f64,
    /// Whether the ring is round a pole, see [`Inside`].
    pub is_round: bool,
}

impl Polygon {
    /// Which poles each ring holds, the shell first.
    ///
    /// - cost: O(vertices) for rings round a pole, for rings of great ellipses and for shells of which the left
    ///   side is asked for; O(1) for others
    #[must_use]
    pub fn sides(&self, rule: EdgeRule, body: &Ellipsoid, inside: Inside) -> Vec<RingSide> {
        let count = 1 + self.holes.len();
        let sides: Vec<Option<Sides>> = self
            .rings()
            .enumerate()
            .map(|(index, ring)| Sides::of(ring, index > 0, rule, body, inside))
            .collect();
        if sides.iter().all(Option::is_none) {
            return vec![RingSide::default(); count];
        }
        let parts_poles = |sides: &&Sides| sides.parts_poles;
        let shell = sides[0].as_ref().filter(parts_poles);
        let mut holes = sides[1..].iter().flatten().filter(parts_poles);
        let common = shell.and_then(|shell| match (holes.next(), holes.count() % 2) {
            (None, _) => None,
            // Between the two: closed over the pole on whose side the shell holds the hole.
            (Some(hole), 0) => Some(usize::from(shell.areas_m2[0] < hole.areas_m2[0])),
            (Some(_), _) => Some(shell.taken(inside)),
        });
        let is_between = |sides: &Sides| common.is_some() && sides.parts_poles;
        let side = |sides: &Option<Sides>| match (sides, common) {
            (None, _) => RingSide::default(),
            (Some(sides), Some(common)) if is_between(sides) => RingSide {
                holds_poles: sides.poles[common],
                choice: None,
            },
            (Some(sides), _) => sides.choose(inside),
        };
        sides.iter().map(side).collect()
    }
}

impl Polygon {
    /// Area of the shell less those of the holes, each ring for itself, square metres.
    pub(crate) fn ring_by_ring_m2(&self, rule: EdgeRule, body: &Ellipsoid, inside: Inside) -> f64 {
        let zone = ZoneArea::new(body, 0.0);
        let area_m2 = |(index, ring): (usize, &Ring)| {
            let sides = Sides::of(ring, index > 0, rule, body, inside);
            let area_m2 = sides.map(|sides| sides.areas_m2[sides.taken(inside)]);
            let plain_m2 = || {
                let pieces = ring_pieces(rule, ring).unwrap_or_default();
                let under = pieces.iter();
                let under = under.map(|piece| zone.under_edge(rule, piece.start, piece.end));
                compensated_sum(under).abs()
            };
            let area_m2 = area_m2.unwrap_or_else(plain_m2);
            if index == 0 { area_m2 } else { -area_m2 }
        };
        self.rings().enumerate().map(area_m2).sum()
    }
}

/// The two sides of a ring that can be read in two ways.
#[derive(Debug)]
struct Sides {
    /// Which poles lie on each side: north or south; none or both.
    poles: [[bool; 2]; 2],
    areas_m2: [f64; 2],
    /// Which of the two the ring's orientation says.
    oriented: usize,
    /// Whether one pole lies on either side.
    parts_poles: bool,
    /// Whether it is round a pole, see [`Inside`].
    is_round: bool,
    /// Whether [`Inside::Left`] takes the side that the orientation says.
    follows_orientation: bool,
    /// The side of a ring that [`Inside::Smaller`] takes.
    smaller: usize,
}

impl Sides {
    /// `None` for a ring that can be read in one way only.
    fn of(
        ring: &Ring,
        is_hole: bool,
        rule: EdgeRule,
        body: &Ellipsoid,
        inside: Inside,
    ) -> Option<Self> {
        let is_plain = match rule {
            EdgeRule::Planar => ring.winding_deg() == 0.0,
            EdgeRule::GreatEllipse => is_within_half_a_turn(ring),
        };
        // Outside of its shell a hole cuts nothing out, so one that is not round a pole has no other side.
        let asks_for_left = inside == Inside::Left && !is_hole;
        if is_plain && !asks_for_left {
            return None;
        }
        // Opposite ends are refused elsewhere.
        let pieces = ring_pieces(rule, ring).ok()?;
        let turned_deg: f64 = pieces
            .iter()
            .map(|piece| piece.end[0] - piece.start[0])
            .sum();
        let turns = (turned_deg / 360.0).round();
        let whole_m2 = body.quadrangle_area_m2(TAU, -FRAC_PI_2, FRAC_PI_2);
        let zone = ZoneArea::new(body, 0.0);
        let under_m2 = compensated_sum(
            pieces
                .iter()
                .map(|piece| zone.under_edge(rule, piece.start, piece.end)),
        );
        let parts_poles = turns.rem_euclid(2.0) == 1.0;
        let (first_m2, is_first_on_the_left, poles) = if parts_poles {
            let north_m2 = 0.5 * whole_m2 - under_m2 / turns;
            (north_m2, turns > 0.0, [[false, true], [true, false]])
        } else if turns == 0.0 {
            let left_m2 = -under_m2;
            (left_m2.abs(), left_m2 >= 0.0, [[false; 2], [true; 2]])
        } else {
            // Twice round: it crosses itself, and neither pole is inside.
            return None;
        };
        let second_m2 = whole_m2 - first_m2;
        let oriented = usize::from(is_first_on_the_left == is_hole);
        let is_of_plane = rule == EdgeRule::Planar && turns == 0.0;
        let is_round = !is_of_plane && (parts_poles || second_m2 < first_m2);
        Some(Self {
            poles,
            areas_m2: [first_m2, second_m2],
            oriented,
            parts_poles,
            is_round,
            follows_orientation: is_round || asks_for_left,
            smaller: if is_of_plane {
                0
            } else if (first_m2 - second_m2).abs() <= HALF_TOLERANCE * whole_m2 {
                oriented
            } else {
                usize::from(second_m2 < first_m2)
            },
        })
    }

    fn taken(&self, inside: Inside) -> usize {
        match inside {
            Inside::Left if self.follows_orientation => self.oriented,
            _ => self.smaller,
        }
    }

    fn choose(&self, inside: Inside) -> RingSide {
        let taken = self.taken(inside);
        let differ = self.follows_orientation && self.smaller != self.oriented;
        RingSide {
            holds_poles: self.poles[taken],
            choice: differ.then(|| SideChoice {
                taken_m2: self.areas_m2[taken],
                other_m2: self.areas_m2[1 - taken],
                is_round: self.is_round,
            }),
        }
    }
}

/// Whether a ring of great ellipses lies within less than half a turn of longitude, away from the
/// poles: then it encloses less than half of the body and no pole.
fn is_within_half_a_turn(ring: &Ring) -> bool {
    let (mut at, mut west, mut east) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (start, end) in ring.edges_deg() {
        if or_at_pole(start[1]).abs() == 90.0 {
            return false;
        }
        let step = end[0] - start[0];
        at += step - 360.0 * (step / 360.0).round();
        west = west.min(at);
        east = east.max(at);
    }
    // Rounding of the sum, with room.
    east - west < 180.0 - 1e-6
}

/// What is to be said of a ring of which [`Inside`] decides the side.
pub(crate) fn side_note(is_hole: bool, inside: Inside, choice: &SideChoice) -> String {
    let SideChoice {
        taken_m2,
        other_m2,
        is_round,
    } = choice;
    let how = if *is_round {
        "goes round a pole"
    } else {
        "is written clockwise"
    };
    let oriented = if is_hole { "right" } else { "left" };
    let (taken, other) = match inside {
        Inside::Smaller => ("smaller", oriented),
        Inside::Left => (oriented, "smaller"),
    };
    let percent = |area_m2: f64| 100.0 * area_m2 / (taken_m2 + other_m2);
    let verb = if is_hole { "cut out" } else { "inside" };
    format!(
        "the ring {how}; {verb} is its {taken} side, {taken_m2:.6e} m² ({:.2} % of the \
         body), not the {other} one, {other_m2:.6e} m² ({:.2} %)",
        percent(*taken_m2),
        percent(*other_m2)
    )
}
