// SPDX-License-Identifier: MIT OR Apache-2.0
//! Coordinates of a polygon → its rings, put right where that is harmless, in both readings where edges
//! over more than 180° of longitude leave two.

use super::long_edges::{ShorterReading, jump_count, shorter_turn_off_bands};
use super::raw::RawCoordinates;
use super::ring::{
    LARGEST_LONGITUDE_DEG, TurnOf, distinct_up_to_three, jump, net_jumps, rounded_to_limits,
    shorter_turn, unroll, without_repeated,
};
use super::{Reader, RegionProblemKind};
use crate::{Polygon, Ring, Unwrap};

impl Reader {
    pub(super) fn read_polygon(
        &mut self,
        coordinates: RawCoordinates,
        polygons: &mut Vec<Polygon>,
    ) {
        let index = self.next_polygon();
        let rings = match coordinates {
            RawCoordinates::List(rings) => rings,
            other => {
                self.wrong_nesting(None, &other, "a list of rings");
                return;
            }
        };
        let polygon = polygons.len();
        let mut read: Vec<Ring> = Vec::with_capacity(rings.len());
        let mut shorter = Vec::new();
        for (i, ring) in rings.into_iter().enumerate() {
            self.place.ring = Some(i);
            let dropped = i - read.len();
            let placed = |ring: Ring| {
                ring.after_dropped(dropped)
                    .after_dropped_parts(index - polygon)
            };
            let Some(RingReadings {
                written,
                shorter: other,
            }) = self.read_ring(ring)
            else {
                continue;
            };
            let ring = read.len();
            shorter.extend(other.map(|(edges, other)| ShorterReading {
                polygon,
                ring,
                edges,
                shorter: placed(other),
            }));
            read.push(placed(written));
        }
        self.place.ring = None;
        let mut read = read.into_iter();
        if let Some(shell) = read.next().filter(|shell| shell.file_ring(0) == 0) {
            let holes = read.collect();
            polygons.push(Polygon { shell, holes });
            self.shorter.extend(shorter);
        }
    }

    fn read_ring(&mut self, coordinates: RawCoordinates) -> Option<RingReadings> {
        let list = match coordinates {
            RawCoordinates::List(list) => list,
            other => {
                self.wrong_nesting(None, &other, "a list of positions");
                return None;
            }
        };
        if list.is_empty() && self.place.ring > Some(0) {
            self.normalised.collapsed_holes += 1;
            return None;
        }
        if list.is_empty() {
            self.problem(None, RegionProblemKind::EmptyCoordinates);
            return None;
        }
        let problems_before = self.problems.len();
        let mut positions: Vec<[f64; 2]> = Vec::with_capacity(list.len());
        for (i, item) in list.iter().enumerate() {
            match item {
                RawCoordinates::Position(position) => {
                    let position = rounded_to_limits(*position);
                    self.check_position(i, position);
                    positions.push(position);
                }
                RawCoordinates::NotANumber(not) => {
                    let (element, found) = (not.element, not.found.clone());
                    self.problem(Some(i), RegionProblemKind::NotANumber { element, found });
                }
                other => {
                    let allowed = "a position of two or more numbers";
                    self.wrong_nesting(Some(i), other, allowed);
                }
            }
        }
        if self.problems.len() > problems_before {
            return None;
        }
        self.both_readings(positions)
    }

    /// - `positions`: known to be in range
    fn both_readings(&mut self, positions: Vec<[f64; 2]>) -> Option<RingReadings> {
        if self.reading.unwrap != Unwrap::Auto {
            let written = self.normalise_ring(positions, self.reading.unwrap)?;
            return Some(RingReadings {
                written,
                shorter: None,
            });
        }
        let edges = jump_count(&positions);
        let mut second = Self {
            place: self.place.clone(),
            ..Self::default()
        };
        // What is put right is the same in both.
        let shorter = (edges > 0).then(|| second.normalise_ring(positions.clone(), Unwrap::Auto));
        let shorter = shorter.flatten().map(|ring| (edges, ring));
        let written = self.normalise_ring(positions, Unwrap::Literal)?;
        Some(RingReadings { written, shorter })
    }

    fn check_position(&mut self, vertex: usize, [longitude, latitude]: [f64; 2]) {
        // JSON has no NaN and serde_json refuses what overflows: both are finite.
        if longitude.abs() > LARGEST_LONGITUDE_DEG {
            let found = longitude;
            self.problem(Some(vertex), RegionProblemKind::Longitude { found });
        }
        if latitude.abs() > 90.0 {
            let found = latitude;
            self.problem(Some(vertex), RegionProblemKind::Latitude { found });
        }
    }

    /// Positions known to be in range → ring.
    fn normalise_ring(&mut self, mut positions: Vec<[f64; 2]>, unwrap: Unwrap) -> Option<Ring> {
        let length = positions.len();
        let closed = length > 1 && positions[0] == positions[length - 1];
        if closed {
            positions.pop();
        }
        let length = positions.len();
        let mut file_vertices = without_repeated(&positions);
        positions.dedup();
        while positions.len() > 1 && positions.first() == positions.last() {
            positions.pop();
        }
        file_vertices.truncate(positions.len());
        self.normalised.repeated_positions += length - positions.len();

        let turn: TurnOf = match unwrap {
            Unwrap::Literal => jump,
            Unwrap::Auto if net_jumps(&positions) == 0 => shorter_turn_off_bands,
            Unwrap::Auto | Unwrap::Shortest => shorter_turn,
        };
        let (turns, is_unrolled) = if unwrap == Unwrap::Literal {
            let turns = net_jumps(&positions);
            (turns, turns != 0)
        } else {
            let next = positions.iter().cycle().skip(1);
            let edges = positions.iter().zip(next);
            let each = edges.map(|(start, end)| turn(*start, *end));
            each.fold((0, false), |(net, any), turn| {
                (net + turn, any || turn != 0)
            })
        };
        if turns.unsigned_abs() > 1 {
            let found = turns.unsigned_abs();
            self.problem(None, RegionProblemKind::ManyTurns { found });
            return None;
        }
        let last_edge_is_jump = jump(positions[positions.len() - 1], positions[0]) != 0;
        let ends_one_turn_on = turns != 0 && last_edge_is_jump;
        if !(closed || ends_one_turn_on) {
            self.normalised.open_rings += 1;
        }
        let (winding_deg, written) = if is_unrolled {
            let (winding_deg, written, repeated) = unroll(&mut positions, &mut file_vertices, turn);
            self.normalised.repeated_positions += repeated;
            (winding_deg, written)
        } else {
            (0.0, Vec::new())
        };
        let mut found = distinct_up_to_three(&positions);
        if winding_deg != 0.0 && found < 3 {
            // Its end, one turn on, is a position of its own in the file.
            found += 1;
        }
        if found < 3 && self.place.ring > Some(0) {
            self.normalised.collapsed_holes += 1;
            return None;
        }
        if found < 3 {
            let required = 3;
            let kind = RegionProblemKind::TooFewVertices { found, required };
            let problem = self.problem_here(None, kind);
            self.collapsed.push(problem);
            return None;
        }
        let ring = Ring::from_checked(positions, winding_deg)
            .with_file_vertices(file_vertices)
            .with_written_longitudes(written);
        Some(ring)
    }
}

/// A ring as the numbers stand, and the shorter way where that is another ring.
struct RingReadings {
    written: Ring,
    /// With its number of edges over more than 180°.
    shorter: Option<(usize, Ring)>,
}
