// SPDX-License-Identifier: MIT OR Apache-2.0
//! [`Unwrap::Auto`](crate::Unwrap::Auto): which way edges over more than 180° of longitude are read, ring
//! by ring.
//!
//! Degrees as in the file. Both readings of a ring have the same vertices, so only evidence decides:
//!
//! 1. A ring that encloses nothing as the numbers stand is read the shorter way.
//! 2. A reading whose edges cross others of the region loses against one whose edges do not.
//! 3. Of two that are left, the one that RFC 7946 orients is taken: shells counter-clockwise, holes
//!    clockwise. The shorter way turns the winding round, so that is seldom both or neither.
//! 4. If it is both or neither, the numbers stand.
//!
//! So a band from −171 to 171 stays a band, and a box from 171 to −171 becomes one over the antimeridian.
//! Holes of a shell that has such edges are read as it is. Edges of a whole turn at one latitude
//! are no jumps: they belong to a band.

use super::ring::{jump, shorter_turn};
use crate::{EdgeRule, Polygon, Region, RegionWarning, Ring, WarningSubject};

/// Share of its terms below which a sum of areas is rounding.
const AREA_ROUNDING: f64 = 1e-12;

/// Whole turns that the shorter way takes from an edge, those of a whole turn left as they are.
pub(super) fn shorter_turn_off_bands(start: [f64; 2], end: [f64; 2]) -> isize {
    if jump(start, end) == 0 {
        shorter_turn(start, end)
    } else {
        0
    }
}

/// Edges of a closed ring over more than 180° of longitude that may be meant the shorter way.
pub(super) fn jump_count(positions: &[[f64; 2]]) -> usize {
    let next = positions.iter().cycle().skip(1);
    let edges = positions.iter().zip(next);
    edges
        .filter(|(start, end)| shorter_turn_off_bands(**start, **end) != 0)
        .count()
}

/// A ring that the numbers and the shorter way read in two ways.
#[derive(Clone)]
pub(super) struct ShorterReading {
    /// Of the polygons that were read.
    pub(super) polygon: usize,
    /// Of its rings.
    pub(super) ring: usize,
    /// Edges over more than 180°.
    pub(super) edges: usize,
    pub(super) shorter: Ring,
}

/// Puts the shorter reading into place where the evidence says so; returns a warning for each.
///
/// - `polygons`: as the numbers stand
/// - `readings`: in order of polygons and rings
pub(super) fn choose_readings(
    polygons: &mut Vec<Polygon>,
    readings: &[ShorterReading],
) -> Vec<RegionWarning> {
    let mut warnings = Vec::new();
    for of_polygon in readings.chunk_by(|a, b| a.polygon == b.polygon) {
        let together = if of_polygon[0].ring == 0 {
            of_polygon.len()
        } else {
            1
        };
        for unit in of_polygon.chunks(together) {
            let shorter = with_shorter(polygons, unit);
            if is_shorter_meant(polygons, &shorter, &unit[0]) {
                warnings.extend(unit.iter().map(|reading| warning(polygons, reading)));
                *polygons = shorter;
            }
        }
    }
    warnings
}

fn with_shorter(polygons: &[Polygon], unit: &[ShorterReading]) -> Vec<Polygon> {
    let mut polygons = polygons.to_vec();
    for reading in unit {
        *ring_mut(&mut polygons[reading.polygon], reading.ring) = reading.shorter.clone();
    }
    polygons
}

fn ring_mut(polygon: &mut Polygon, ring: usize) -> &mut Ring {
    match ring.checked_sub(1) {
        None => &mut polygon.shell,
        Some(hole) => &mut polygon.holes[hole],
    }
}

fn is_shorter_meant(written: &[Polygon], shorter: &[Polygon], reading: &ShorterReading) -> bool {
    let ring = |polygons: &[Polygon]| -> Option<Ring> {
        polygons[reading.polygon].rings().nth(reading.ring).cloned()
    };
    let (Some(written_ring), Some(shorter_ring)) = (ring(written), ring(shorter)) else {
        return false;
    };
    let written_turn = counter_clockwise(&written_ring);
    if written_turn == 0.0 {
        return true;
    }
    match (crosses(written), crosses(shorter)) {
        (true, false) => true,
        (false, true) => false,
        _ => {
            let sense = if reading.ring == 0 { 1.0 } else { -1.0 };
            let is_oriented = |turn: f64| turn * sense > 0.0;
            is_oriented(counter_clockwise(&shorter_ring)) && !is_oriented(written_turn)
        }
    }
}

fn crosses(polygons: &[Polygon]) -> bool {
    let region = Region {
        polygons: polygons.to_vec(),
        ..Region::default()
    };
    region.has_crossings(EdgeRule::Planar)
}

/// Above 0 where the inside is on the left; 0 for a ring that encloses nothing.
///
/// Of a ring round a pole the inside is the side with less area: north of an eastward ring of the
/// northern half.
fn counter_clockwise(ring: &Ring) -> f64 {
    let is_round = ring.winding_deg() != 0.0;
    let height = |latitude: f64| {
        if is_round {
            latitude.to_radians().sin()
        } else {
            -latitude
        }
    };
    let (mut sum, mut scale) = (0.0_f64, 0.0_f64);
    for (start, end) in ring.edges_deg() {
        let term = 0.5 * (height(start[1]) + height(end[1])) * (end[0] - start[0]);
        sum += term;
        scale += term.abs();
    }
    if sum.abs() <= AREA_ROUNDING * scale {
        0.0
    } else {
        sum
    }
}

fn warning(polygons: &[Polygon], reading: &ShorterReading) -> RegionWarning {
    let polygon = &polygons[reading.polygon];
    let edges = match reading.edges {
        1 => "1 edge over more than 180° of longitude is".to_owned(),
        many => format!("{many} edges over more than 180° of longitude are"),
    };
    WarningSubject::Inside.warn(format!(
        "polygon {}, ring {}: {edges} read the shorter way, over the antimeridian; --unwrap literal \
         takes the numbers as they stand",
        polygon.shell.file_polygon(reading.polygon),
        reading.shorter.file_ring(reading.ring)
    ))
}
