// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lines through cases: a time as a fixed cost and what each further piece of work adds.
//!
//! A line is fitted by least squares of the relative residuals, since noise grows with time; by absolute
//! ones the largest work alone would set both. Every process has a line of its own, and the range over
//! processes is the fit's spread.

use crate::cases::{Cases, range};
use crate::figure::Figure;
use terrafill_results::{Block, Cell, ConditionKey, Heading, Row, Table, process_medians};

/// A line through two points has no residual that could speak against it.
const MIN_POINTS: usize = 3;

/// A table of lines, one for each value of a condition.
#[derive(Debug, Clone, Copy)]
pub struct Lines<'a> {
    /// What a line says.
    pub caption: &'a str,
    /// What names a line, with its heading.
    pub by: (&'a str, ConditionKey),
    /// The amount of work.
    pub across: Figure,
    /// The time that it takes.
    pub up: Figure,
    /// Heading of the time without any work.
    pub start: &'a str,
    /// Heading of what follows from the time of a unit of work, and how.
    pub slope: (&'a str, fn(f64) -> f64),
}

impl Lines<'_> {
    /// The table of these cases.
    #[must_use]
    pub fn block(&self, cases: &Cases<'_>) -> Block {
        let rows = cases.by(self.by.1).into_iter().map(|(name, own)| {
            let lines = self.of_processes(&own);
            let cell = |of: &dyn Fn(&[f64; 2]) -> f64| {
                let values: Vec<f64> = lines.iter().map(of).collect();
                let why = format!("fewer than {MIN_POINTS} cases, or no rising times");
                Cell::or_absent(range(&values), why)
            };
            let slope = |line: &[f64; 2]| (self.slope.1)(line[1]);
            Row::new(vec![Cell::name(name), cell(&|line| line[0]), cell(&slope)])
        });
        Block::Table(Table {
            caption: self.caption.to_owned(),
            headings: [self.by.0, self.start, self.slope.0]
                .map(Heading::plain)
                .into(),
            rows: rows.collect(),
            ..Table::default()
        })
    }

    /// Start and slope by process.
    fn of_processes(&self, cases: &Cases<'_>) -> Vec<[f64; 2]> {
        let clock = cases.clock();
        let Some(time) = self.up.metric(clock) else {
            return Vec::new();
        };
        let counted = cases.iter().filter(|case| case.counts());
        let points = counted
            .filter_map(|case| Some((self.across.of(case, clock)?, process_medians(case, time))));
        let points: Vec<_> = points.collect();
        let processes = points
            .first()
            .into_iter()
            .flat_map(|(_, times)| times.keys());
        let line = |process: &u32| {
            let own = points
                .iter()
                .filter_map(|(work, times)| Some([*work, *times.get(process)?]));
            fit(&own.collect::<Vec<_>>())
        };
        processes.filter_map(line).collect()
    }
}

/// Start and slope by weighted regression of time on work, weights 1 / time²; `None` with too few points or where time
/// does not rise.
fn fit(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    if points.len() < MIN_POINTS {
        return None;
    }
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        let terms = points.iter().map(|&[x, y]| of(x, y) / (y * y));
        terms.sum()
    };
    let weight = sum(&|_, _| 1.0);
    let middle = [sum(&|x, _| x) / weight, sum(&|_, y| y) / weight];
    let spread = sum(&|x, _| (x - middle[0]).powi(2));
    let slope = sum(&|x, y| (x - middle[0]) * (y - middle[1])) / spread;
    (slope > 0.0).then_some([middle[1] - slope * middle[0], slope])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_and_two_points_are_none() {
        let points = [[1e5, 0.6], [1e6, 1.5], [1e7, 10.5], [1e8, 100.5]];
        let [start, slope] = fit(&points).expect("a line");
        assert!((start - 0.5).abs() < 1e-9, "{start}");
        assert!((slope - 1e-6).abs() < 1e-15, "{slope}");
        assert_eq!(fit(&points[..2]), None);
        // Negative control: times that fall with work are no line.
        assert_eq!(fit(&points.map(|[x, y]| [x, 1.0 / y])), None);
    }
}
