// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the numerical suite has against a route: where its error was measured above its bound, or its
//! answer was not finite although the bound is.
//!
//! The suite measures on a grid of extents × latitudes. A finding in one of its cells is held against
//! every region between the cell's neighbours, since what went wrong there begins somewhere before.
//! The findings that a plan knows are those of `suite_findings.csv`, which is printed by
//! `cargo run --release -p terrafill-precision --example findings`. Print into another file and move it: the
//! example embeds this one. A test of the bench makes a part of it anew.

use crate::{CoordinateRoute, MapRegion, SAMPLING_SLACK};
use std::fmt;

/// Heights and widths of the suite's regions, degrees, ascending.
pub const SUITE_EXTENTS_DEG: [f64; 7] = [1e-3, 1e-2, 0.1, 1.0, 10.0, 90.0, 360.0];

/// Latitudes of their middles, degrees, ascending; at 90 they are caps round the pole.
pub const SUITE_LATITUDES_DEG: [f64; 5] = [0.0, 45.0, 70.0, 85.0, 90.0];

/// The table of what was found.
const CHECKED_IN: &str = include_str!("suite_findings.csv");

/// Its first line.
const HEADINGS: &str = "route,extent_deg,latitude_deg,worst_over_bound,non_finite";

/// A region of the suite, without its heights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SuiteCell {
    /// Height and width, degrees; a cap's is across the pole.
    pub extent_deg: f64,
    /// Latitude of the middle, degrees.
    pub latitude_deg: f64,
}

impl SuiteCell {
    /// Whether a region is closer to this cell than the next ones on the suite's grid are.
    #[must_use]
    pub fn covers(&self, region: &MapRegion) -> bool {
        let extent = region.extent();
        let [width, height] = extent.size_rad().map(f64::to_degrees);
        let middle = 0.5 * (extent.south_rad + extent.north_rad).to_degrees().abs();
        let is_near = |extent_deg: f64, latitude_deg: f64| {
            is_between_neighbours(&SUITE_EXTENTS_DEG, self.extent_deg, extent_deg)
                && is_between_neighbours(&SUITE_LATITUDES_DEG, self.latitude_deg, latitude_deg)
        };
        // A region that ends at a pole may be a square or half a cap.
        is_near(width.max(height), middle) || (region.touches_pole() && is_near(2.0 * height, 90.0))
    }
}

impl fmt::Display for SuiteCell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "extent {}°, latitude {}°",
            self.extent_deg, self.latitude_deg
        )
    }
}

/// Whether `value` lies between the values of `grid` before and after `at`.
fn is_between_neighbours(grid: &[f64], at: f64, value: f64) -> bool {
    let below = grid.iter().copied().filter(|other| *other < at);
    let above = grid.iter().copied().filter(|other| *other > at);
    // Degrees from radians are off in their last places.
    const SLACK: f64 = 1e-9;
    value > below.fold(f64::NEG_INFINITY, f64::max) * (1.0 + SLACK)
        && value < above.fold(f64::INFINITY, f64::min) * (1.0 - SLACK)
}

/// What the numerical suite found about a route, on whichever device.
#[derive(Debug, Clone, PartialEq)]
pub struct SuiteFinding {
    /// The route.
    pub route: CoordinateRoute,
    /// Where.
    pub cell: SuiteCell,
    /// Largest measured error over its computed bound; above [`SAMPLING_SLACK`] the bound does not
    /// hold there.
    pub worst_over_bound: f64,
    /// Results that were not finite.
    pub non_finite: u64,
}

impl SuiteFinding {
    /// Whether it speaks against the route: a ratio that is NaN does too.
    #[must_use]
    pub fn contradicts(&self) -> bool {
        let ratio = self.worst_over_bound;
        self.non_finite > 0 || ratio > SAMPLING_SLACK || ratio.is_nan()
    }

    /// The findings as a table, as [`Self::parse`] reads it.
    #[must_use]
    pub fn table(findings: &[Self]) -> String {
        let lines = findings.iter().map(|finding| {
            format!(
                "{},{},{},{:.3},{}\n",
                finding.route.name(),
                finding.cell.extent_deg,
                finding.cell.latitude_deg,
                finding.worst_over_bound,
                finding.non_finite
            )
        });
        std::iter::once(format!("{HEADINGS}\n"))
            .chain(lines)
            .collect()
    }

    /// Reads a table.
    ///
    /// # Errors
    /// What is wrong and where, for another table, and for a route that there is not: a finding that nothing is
    /// held against would be none.
    pub fn parse(table: &str) -> Result<Vec<Self>, String> {
        let mut lines = table.lines();
        let first = lines.next().unwrap_or_default();
        if first != HEADINGS {
            return Err(format!("first line is “{first}”, must be “{HEADINGS}”"));
        }
        let row = |(line, text)| {
            Self::parse_line(text).map_err(|problem| format!("line {line}: {problem}"))
        };
        (2..).zip(lines).map(row).collect()
    }

    fn parse_line(text: &str) -> Result<Self, String> {
        let mut cells = text.split(',');
        let mut next = || cells.next().unwrap_or_default();
        let wrong = |what: &str, found: &str| format!("{what} is “{found}”");
        let number =
            |what, found: &str| found.parse::<f64>().ok().ok_or_else(|| wrong(what, found));
        let name = next();
        let route = CoordinateRoute::parse(name).ok_or_else(|| wrong("route", name))?;
        let cell = SuiteCell {
            extent_deg: number("extent", next())?,
            latitude_deg: number("latitude", next())?,
        };
        for (what, grid, at) in [
            ("extent", &SUITE_EXTENTS_DEG[..], cell.extent_deg),
            ("latitude", &SUITE_LATITUDES_DEG[..], cell.latitude_deg),
        ] {
            if !grid.contains(&at) {
                return Err(wrong(what, &at.to_string()));
            }
        }
        let worst_over_bound = number("ratio", next())?;
        let count = next();
        let non_finite = count.parse().ok().ok_or_else(|| wrong("count", count))?;
        Ok(Self {
            route,
            cell,
            worst_over_bound,
            non_finite,
        })
    }

    /// What a plan knows.
    #[must_use]
    pub fn checked_in() -> Vec<Self> {
        // A test reads the same bytes, so this cannot come to pass.
        Self::parse(CHECKED_IN).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MapExtent;
    use terrafill_core::Ellipsoid;

    fn finding(route: &str, extent_deg: f64, latitude_deg: f64) -> SuiteFinding {
        SuiteFinding {
            route: CoordinateRoute::parse(route).expect("a route"),
            cell: SuiteCell {
                extent_deg,
                latitude_deg,
            },
            worst_over_bound: 1.25,
            non_finite: 3,
        }
    }

    #[test]
    fn a_table_is_read_as_it_was_written_and_a_broken_one_is_refused() {
        let findings = [
            finding("near-odd-7+bowring-1", 90.0, 45.0),
            finding("planes", 1e-3, 90.0),
        ];
        let table = SuiteFinding::table(&findings);
        assert_eq!(SuiteFinding::parse(&table).as_deref(), Ok(&findings[..]));
        for (right, wrong, what) in [
            ("planes", "plains", "route"),
            ("0.001", "0.002", "extent"),
            (",90,1.250", ",89,1.250", "latitude"),
            ("1.250", "much", "ratio"),
            (",3\n", ",some\n", "count"),
            (HEADINGS, "route", "first line"),
        ] {
            let broken = table.replace(right, wrong);
            assert_ne!(broken, table, "{right}");
            let error = SuiteFinding::parse(&broken).expect_err(what);
            assert!(error.contains(what), "{error}");
        }
    }

    #[test]
    fn the_checked_in_table_is_one_and_every_line_speaks_against_its_route() {
        let findings = SuiteFinding::parse(CHECKED_IN).expect("a table");
        assert_eq!(findings, SuiteFinding::checked_in());
        assert!(findings.iter().all(SuiteFinding::contradicts));
        assert_eq!(SuiteFinding::table(&findings), CHECKED_IN);
        // Negative control: what was found to hold is no reason to keep away.
        let held = SuiteFinding {
            worst_over_bound: 0.99,
            non_finite: 0,
            ..finding("planes", 1.0, 0.0)
        };
        assert!(!held.contradicts());
    }

    #[test]
    fn a_cell_covers_what_lies_between_its_neighbours() {
        let region = |extent_deg: f64, latitude_deg: f64| {
            let half = 0.5 * extent_deg;
            let north = (latitude_deg + half).min(90.0);
            let extent = MapExtent::from_degrees(-half, latitude_deg - half, half, north);
            MapRegion::anchored(Ellipsoid::WGS84, extent, (0.0, 0.0)).expect("bounds")
        };
        let at = |extent_deg, latitude_deg| SuiteCell {
            extent_deg,
            latitude_deg,
        };
        let ten = at(10.0, 45.0);
        for (extent, latitude) in [
            (10.0, 45.0),
            (1.5, 45.0),
            (60.0, 40.0),
            (5.0, 69.0),
            (5.0, 1.0),
        ] {
            assert!(ten.covers(&region(extent, latitude)), "{extent} {latitude}");
        }
        // Negative controls: at and beyond the next cells, which were measured themselves.
        for (extent, latitude) in [(1.0, 45.0), (90.0, 45.0), (10.0, 70.0), (10.0, 0.0)] {
            assert!(
                !ten.covers(&region(extent, latitude)),
                "{extent} {latitude}"
            );
        }
        // The south is as the north, and a region that ends at a pole is half a cap.
        assert!(ten.covers(&region(10.0, -45.0)));
        assert!(at(10.0, 90.0).covers(&region(10.0, 90.0)));
        assert!(!at(10.0, 90.0).covers(&region(10.0, 80.0)));
    }
}
