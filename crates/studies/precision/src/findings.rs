// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the suite's rows have against a route: the table that the chooser reads.
//!
//! There is a finding against a route where its bound is finite, so that its formula has an answer, and
//! an error was measured above the bound nonetheless or an answer was not finite.

use crate::metrics::{MAX_OVER_RESIDUAL, RESIDUAL_MAX_M};
use crate::row::{PrecisionPart, PrecisionRow};
use terrafill_results::Status;
use terrafill_texture::{CoordinateRoute, SuiteCell, SuiteFinding};

/// Findings of `rows`, one for each route and cell at most: the worst over all heights, special inputs
/// counted with the region they lie in. In the rows' order.
#[must_use]
pub fn suite_findings(rows: &[PrecisionRow]) -> Vec<SuiteFinding> {
    let mut cells: Vec<SuiteFinding> = Vec::new();
    for row in rows.iter().filter(|row| is_believed(row)) {
        let Some(found) = finding(row) else { continue };
        match find(&mut cells, &found) {
            Some(there) => add(there, &found),
            None => cells.push(found),
        }
    }
    let special =
        |row: &&PrecisionRow| row.part == PrecisionPart::Special && row.status == Status::Wrong;
    for found in rows.iter().filter(special).filter_map(finding) {
        // Outside its domain a route may answer as it likes.
        if let Some(there) = find(&mut cells, &found) {
            add(there, &found);
        }
    }
    cells.retain(SuiteFinding::contradicts);
    cells
}

/// Whether the formula says that there is an answer.
fn is_believed(row: &PrecisionRow) -> bool {
    row.part == PrecisionPart::Coordinate && row.figure(RESIDUAL_MAX_M).is_some_and(f64::is_finite)
}

fn finding(row: &PrecisionRow) -> Option<SuiteFinding> {
    Some(SuiteFinding {
        route: CoordinateRoute::parse(&row.route)?,
        cell: SuiteCell {
            extent_deg: row.extent_deg?,
            latitude_deg: row.latitude_deg?,
        },
        worst_over_bound: row.figure(MAX_OVER_RESIDUAL).unwrap_or(0.0),
        non_finite: row.non_finite(),
    })
}

fn find<'a>(cells: &'a mut [SuiteFinding], like: &SuiteFinding) -> Option<&'a mut SuiteFinding> {
    let same = |other: &&mut SuiteFinding| (other.route, other.cell) == (like.route, like.cell);
    cells.iter_mut().find(same)
}

fn add(there: &mut SuiteFinding, found: &SuiteFinding) {
    // A ratio that is NaN is the worst, and stays: no number is above it.
    if found.worst_over_bound.is_nan() || found.worst_over_bound > there.worst_over_bound {
        there.worst_over_bound = found.worst_over_bound;
    }
    there.non_finite += found.non_finite;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::NON_FINITE_DEVICE;

    fn row(part: PrecisionPart, route: &str, ratio: f64, non_finite: u64) -> PrecisionRow {
        let is_wrong = non_finite > 0 || ratio > 1.02;
        let mut row = PrecisionRow {
            extent_deg: Some(10.0),
            latitude_deg: Some(45.0),
            status: if is_wrong { Status::Wrong } else { Status::Ok },
            ..PrecisionRow::new(part, route, String::new())
        };
        row.put(RESIDUAL_MAX_M, 5.0);
        row.put(MAX_OVER_RESIDUAL, ratio);
        row.put(NON_FINITE_DEVICE, non_finite as f64);
        row
    }

    #[test]
    fn heights_and_special_inputs_are_one_cell_and_what_holds_is_left_out() {
        use PrecisionPart::{Coordinate, Position, Special};
        let rows = [
            row(Coordinate, "gnomonic-3", 0.9, 0),
            row(Coordinate, "planes", 1.1, 0),
            row(Coordinate, "planes", 1.3, 0),
            row(Coordinate, "odd-7+bowring-1", 0.9, 0),
            row(Special, "odd-7+bowring-1", 0.0, 1),
            row(Position, "planes", 9.0, 9),
        ];
        let found = suite_findings(&rows);
        let of: Vec<_> = found
            .iter()
            .map(|f| (f.route.name(), f.worst_over_bound, f.non_finite))
            .collect();
        let expected = [
            ("planes".to_owned(), 1.3, 0),
            ("odd-7+bowring-1".to_owned(), 0.9, 1),
        ];
        assert_eq!(of, expected);
        let mut unknown = rows.clone();
        unknown[1].put(MAX_OVER_RESIDUAL, f64::NAN);
        assert!(suite_findings(&unknown)[0].worst_over_bound.is_nan());
        // Negative control: where the formula says itself that it is no map, no finding is needed.
        let beyond = rows.map(|mut row| {
            row.put(RESIDUAL_MAX_M, f64::INFINITY);
            row
        });
        assert_eq!(suite_findings(&beyond), []);
    }
}
