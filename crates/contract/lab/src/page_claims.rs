// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where figures of a claim must lie, and tests that need no run: sums, and figures of a page. A test of the study holds
//! the page to what the code computes.

use crate::claims::ClaimAnswer;
use serde::Deserialize;
use terrafill_plot::number::{digits, significant};
use terrafill_results::Standing;

/// Where figures must lie.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Bound {
    /// At 0.
    None,
    /// At or below this.
    AtMost(f64),
    /// At or above this.
    AtLeast(f64),
    /// Within both, ends included.
    Between([f64; 2]),
}

/// Products, added up.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct ClaimSum {
    /// Products that are added up.
    pub terms: Vec<Vec<f64>>,
    /// What the document says that it gives.
    pub says: f64,
    /// By what share the document may be off, since it rounds.
    #[serde(default)]
    pub within: f64,
}

/// A cell of a table in Markdown.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct PageFigure {
    /// Words of the text before the table.
    pub below: String,
    /// The row's first cell.
    pub row: String,
    /// The column's heading.
    pub column: String,
    /// Where the figure must lie.
    pub is: Bound,
}

impl Bound {
    pub(crate) fn holds(self, value: f64) -> bool {
        match self {
            Self::None => value == 0.0,
            Self::AtMost(most) => value <= most,
            Self::AtLeast(least) => value >= least,
            Self::Between([least, most]) => (least..=most).contains(&value),
        }
    }

    /// Of an interval; without one nothing can be told.
    #[must_use]
    pub fn standing(self, interval: Option<[f64; 2]>) -> Standing {
        let Some(ends) = interval else {
            return Standing::CannotTell;
        };
        let [low, high] = ends;
        let [is_below, is_above] = match self {
            Self::None => [false, low > 0.0],
            Self::AtMost(most) => [false, low > most],
            Self::AtLeast(least) => [high < least, false],
            Self::Between([least, most]) => [high < least, low > most],
        };
        match (
            ends.iter().all(|end| self.holds(*end)),
            is_below || is_above,
        ) {
            (true, _) => Standing::Holds,
            (_, true) => Standing::DoesNotHold,
            _ => Standing::CannotTell,
        }
    }
}

impl ClaimSum {
    pub(crate) fn answer(&self) -> ClaimAnswer {
        let products = self.terms.iter().map(|term| term.iter().product::<f64>());
        let sum: f64 = products.sum();
        let is_same = (sum - self.says).abs() <= self.within * sum.abs();
        ClaimAnswer {
            ours: if sum.fract() == 0.0 {
                digits(sum)
            } else {
                significant(sum)
            },
            standing: Standing::holds_if(is_same),
            reason: String::new(),
        }
    }
}

/// The cells of a row, without the empty ends.
fn cells(line: &str) -> Vec<&str> {
    let line = line.trim().trim_start_matches('|').trim_end_matches('|');
    line.split('|').map(str::trim).collect()
}

/// Between which numbers a cell's first one lies, both the same where it is exact. `< 1e-6` is of a size below 1e-6.
fn number(cell: &str) -> Option<[f64; 2]> {
    let (low, cell) = match cell.strip_prefix("< ") {
        Some(below) => (Some(0.0), below),
        None => (None, cell),
    };
    let high: f64 = cell.split([' ', ',']).next()?.parse().ok()?;
    Some([low.unwrap_or(high), high])
}

impl PageFigure {
    /// The cell as it stands, with its number.
    ///
    /// # Errors
    /// What the page does not have, or has more than once.
    pub(crate) fn figure<'p>(&self, page: &'p str) -> Result<(&'p str, [f64; 2]), String> {
        let mut places = page.match_indices(&self.below);
        let (Some((at, _)), None) = (places.next(), places.next()) else {
            let count = page.matches(&self.below).count();
            return Err(format!("{:?} {count} times, needed once", self.below));
        };
        let lines = page[at..].lines().skip_while(|line| !line.starts_with('|'));
        let mut lines = lines.take_while(|line| line.starts_with('|'));
        let headings = cells(lines.next().unwrap_or_default());
        let no_column = || format!("no column {:?} below {:?}", self.column, self.below);
        let column = headings.iter().position(|text| *text == self.column);
        let column = column.ok_or_else(no_column)?;
        let mut rows = lines.map(cells);
        let row = rows.find(|row| row.first() == Some(&self.row.as_str()));
        let no_row = || format!("no row {:?} below {:?}", self.row, self.below);
        let cell = row.ok_or_else(no_row)?.get(column).copied();
        let cell = cell.unwrap_or_default();
        let no_number = || format!("no number but {cell:?} in {}, {}", self.row, self.column);
        Ok((cell, number(cell).ok_or_else(no_number)?))
    }

    /// - `page`: its name, and its text
    pub(crate) fn answer(&self, [name, text]: [&str; 2]) -> ClaimAnswer {
        let (cell, [low, high]) = match self.figure(text) {
            Ok(found) => found,
            Err(missing) => {
                let why = format!("{name} has {missing}");
                return ClaimAnswer::unanswered(Standing::CannotBeTested, &why);
            }
        };
        ClaimAnswer {
            ours: format!("{}, {}: {cell}", self.row, self.column),
            standing: if low < high {
                self.is.standing(Some([low, high]))
            } else {
                Standing::holds_if(self.is.holds(high))
            },
            reason: format!("By {name}, which a test holds to what the code computes"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "# A page\n\nTurns, px. More words.\n\n| | 1 km | 2 km |\n| --- | --- | --- |\n\
                        | 1/2 | < 1e-6 | 0.627 |\n| 3/2 | 12 of 300 | +1.4 % |\n\nOthers.\n\n| | 1 km |\n| --- | --- |\n\
                        | 5/4 | 9 |\n";

    fn of(row: &str, column: &str, is: Bound) -> PageFigure {
        PageFigure {
            below: "Turns, px.".to_owned(),
            row: row.to_owned(),
            column: column.to_owned(),
            is,
        }
    }

    #[test]
    fn a_figure_of_a_page_decides_and_one_that_is_not_there_does_not() {
        let standing =
            |row: &str, column: &str, is| of(row, column, is).answer(["a.md", PAGE]).standing;
        assert_eq!(
            standing("1/2", "2 km", Bound::AtMost(0.63)),
            Standing::Holds
        );
        assert_eq!(
            standing("1/2", "1 km", Bound::AtMost(1e-6)),
            Standing::Holds
        );
        assert_eq!(
            standing("3/2", "1 km", Bound::AtLeast(12.0)),
            Standing::Holds
        );
        assert_eq!(
            standing("3/2", "2 km", Bound::Between([1.0, 2.0])),
            Standing::Holds
        );
        // Below 1e-6 is not 1e-6, and may be none.
        for (is, says) in [
            (Bound::AtMost(1e-7), Standing::CannotTell),
            (Bound::AtLeast(1e-6), Standing::CannotTell),
            (Bound::AtLeast(1e-5), Standing::DoesNotHold),
            (Bound::None, Standing::CannotTell),
        ] {
            assert_eq!(standing("1/2", "1 km", is), says, "{is:?}");
        }
        // Negative controls: the other side of the bound, another column, and a row of the next table.
        assert_eq!(
            standing("1/2", "2 km", Bound::AtMost(0.62)),
            Standing::DoesNotHold
        );
        assert_eq!(standing("1/2", "2 km", Bound::None), Standing::DoesNotHold);
        assert_eq!(
            standing("1/2", "3 km", Bound::None),
            Standing::CannotBeTested
        );
        assert_eq!(
            standing("5/4", "1 km", Bound::AtLeast(1.0)),
            Standing::CannotBeTested
        );
        // Words that are there twice name no table, and that is said.
        let twice = format!("{PAGE}\nTurns, px. Again.\n");
        let answer = of("1/2", "2 km", Bound::AtMost(0.63)).answer(["a.md", &twice]);
        assert_eq!(answer.standing, Standing::CannotBeTested);
        assert_eq!(
            answer.reason,
            "a.md has \"Turns, px.\" 2 times, needed once"
        );
    }

    #[test]
    fn a_sum_is_what_it_is() {
        let sum = |says, within| {
            let terms = vec![vec![640.0, 480.0], vec![2.0, 3.0]];
            ClaimSum {
                terms,
                says,
                within,
            }
            .answer()
        };
        assert_eq!(sum(307_206.0, 0.0).standing, Standing::Holds);
        assert_eq!(sum(307_206.0, 0.0).ours, digits(307_206.0));
        assert_eq!(sum(3e5, 0.03).standing, Standing::Holds);
        // Negative control.
        assert_eq!(sum(307_200.0, 0.0).standing, Standing::DoesNotHold);
    }
}
