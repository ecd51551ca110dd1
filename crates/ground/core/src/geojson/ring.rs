// SPDX-License-Identifier: MIT OR Apache-2.0
//! Positions of a ring as written: neighbours that are one, jumps between two spellings of a place, and
//! how far round the axis it goes.
//!
//! Degrees as they stand in the file; a ring's end is not its first position again.

use crate::pieces::ANTIMERIDIAN_SNAP_DEG;

/// Longitudes beyond this are refused: one turn past the antimeridian is how uncut rings are
/// written; more is a mistake, most often another unit.
pub(crate) const LARGEST_LONGITUDE_DEG: f64 = 540.0;

/// A position a rounding outside of ±180 or ±90 on them: the one place where that is done.
///
/// Writers round to both sides: Natural Earth has 180.00000000000014, others 90.00000000000001. Adding
/// zero turns −0 into 0, so that equal places have equal bits.
pub(super) fn rounded_to_limits([longitude, latitude]: [f64; 2]) -> [f64; 2] {
    let onto = |value: f64, limit: f64| {
        let is_outside = value.abs() > limit && value.abs() <= limit + ANTIMERIDIAN_SNAP_DEG;
        if is_outside {
            limit.copysign(value)
        } else {
            value + 0.0
        }
    };
    [onto(longitude, 180.0), onto(latitude, 90.0)]
}

/// Indices of the positions that differ from the next; none where all do.
pub(super) fn without_repeated(positions: &[[f64; 2]]) -> Vec<usize> {
    if positions.windows(2).all(|pair| pair[0] != pair[1]) {
        return Vec::new();
    }
    let last = positions.len() - 1;
    (0..=last)
        .filter(|&i| i == last || positions[i] != positions[i + 1])
        .collect()
}

/// Whole turns to take from the edge between two places.
pub(super) type TurnOf = fn([f64; 2], [f64; 2]) -> isize;

/// ±1 for an edge between two spellings, one turn apart, of a place that is not a pole; else 0.
pub(super) fn jump(start: [f64; 2], end: [f64; 2]) -> isize {
    let step = end[0] - start[0];
    if start[1] != end[1] || start[1].abs() == 90.0 || step.abs() != 360.0 {
        0
    } else if step > 0.0 {
        1
    } else {
        -1
    }
}

/// Whole turns that the edge between two places is longer than the shorter way; 0 along a pole, which
/// is one place, and where both ways are half a turn.
#[allow(
    clippy::cast_possible_truncation,
    reason = "longitudes within ±540 are three turns apart at most"
)]
pub(super) fn shorter_turn(start: [f64; 2], end: [f64; 2]) -> isize {
    let step = end[0] - start[0];
    let along_pole = start[1].abs() == 90.0 && start[1] == end[1];
    if step.abs() <= 180.0 || along_pole {
        0
    } else {
        (step / 360.0).round() as isize
    }
}

/// Sum of the jumps of a closed ring.
///
/// Not 0: the ring goes round the axis and was cut open at the antimeridian to be written down.
/// 0 with jumps: edges along a whole parallel, as in the rectangle −180 … 180 × −10 … 10. The
/// rectangle −180 … 180 × 80 … 90 comes back along a pole, in one edge or in several, so its one
/// jump is such an edge too.
pub(super) fn net_jumps(positions: &[[f64; 2]]) -> isize {
    let next = || positions.iter().cycle().skip(1);
    let turns: isize = positions
        .iter()
        .zip(next())
        .map(|(start, end)| jump(*start, *end))
        .sum();
    // By the ends of each run along a pole, which round nothing where its edges would.
    let along_pole = |a: &[f64; 2], b: &[f64; 2]| a[1].abs() == 90.0 && a[1] == b[1];
    let previous = positions.iter().cycle().skip(positions.len() - 1);
    let along_poles_deg: f64 = previous
        .zip(positions)
        .zip(next())
        .map(|((previous, at), next)| {
            f64::from(along_pole(previous, at)) * at[0] - f64::from(along_pole(at, next)) * at[0]
        })
        .sum();
    if along_poles_deg == -360.0 * turns as f64 {
        0
    } else {
        turns
    }
}

/// Shifts what follows each edge that turns by that many turns, and drops the position that a jump
/// repeats. Returns how far from the start the ring ends, the longitudes before they were shifted, and
/// how many positions became one with their neighbour because 360° more cost them their last bits. The
/// same positions are dropped from `file_vertices`.
pub(super) fn unroll(
    positions: &mut Vec<[f64; 2]>,
    file_vertices: &mut Vec<usize>,
    turn: TurnOf,
) -> (f64, Vec<f64>, usize) {
    let mut offset = 0.0;
    let mut repeated = 0;
    let mut written: Vec<f64> = Vec::with_capacity(positions.len());
    let mut unrolled: Vec<[f64; 2]> = Vec::with_capacity(positions.len());
    let mut kept: Vec<usize> = Vec::with_capacity(positions.len());
    let next = positions.iter().cycle().skip(1);
    let mut after_jump = false;
    for (i, (start, end)) in positions.iter().zip(next).enumerate() {
        let file_vertex = file_vertices.get(i).copied().unwrap_or(i);
        let place = [start[0] + offset, start[1]];
        let is_repeated = !after_jump && unrolled.last() == Some(&place);
        repeated += usize::from(is_repeated);
        if after_jump || is_repeated {
            // The edge to come starts from the position that repeats the one before the jump.
            kept.pop();
            if let Some(kept) = written.last_mut() {
                *kept = nearer_spelling(*kept, start[0]);
            }
        } else {
            unrolled.push(place);
            written.push(start[0]);
        }
        kept.push(file_vertex);
        let turns = turn(*start, *end);
        after_jump = turns != 0 && jump(*start, *end) != 0;
        offset -= 360.0 * turns as f64;
    }
    let ends_at_start = |unrolled: &[[f64; 2]]| match unrolled {
        [first, .., last] => *last == [first[0] + offset, first[1]],
        _ => false,
    };
    while after_jump || ends_at_start(&unrolled) {
        // The closing edge was the jump: the first position repeats the last.
        repeated += usize::from(!after_jump);
        after_jump = false;
        unrolled.pop();
        kept.pop();
        if let Some(last) = written.pop()
            && let Some(first) = written.first_mut()
        {
            *first = nearer_spelling(*first, last);
        }
    }
    if unrolled
        .iter()
        .any(|place| place[0].abs() > LARGEST_LONGITUDE_DEG + 360.0)
    {
        // Edges each taken the shorter way may lead further round than a file may be written.
        let back = 360.0 * (unrolled[0][0] / 360.0).round();
        for place in &mut unrolled {
            place[0] -= back;
        }
    }
    *positions = unrolled;
    *file_vertices = kept;
    (offset, written, repeated)
}

/// Of a place's longitudes on either side of a jump, the one that a ring in the other direction keeps
/// as well. They are a turn apart to the nearest number, and may be a last bit apart on the body.
fn nearer_spelling(a: f64, b: f64) -> f64 {
    if b.abs() < a.abs() { b } else { a }
}

/// Number of distinct positions, counting no further than 3.
pub(super) fn distinct_up_to_three(positions: &[[f64; 2]]) -> usize {
    let mut seen: Vec<[f64; 2]> = Vec::with_capacity(3);
    for position in positions {
        if !seen.contains(position) {
            seen.push(*position);
            if seen.len() == 3 {
                break;
            }
        }
    }
    seen.len()
}
