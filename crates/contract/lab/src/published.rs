// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tables of figures that a document printed, and ratios within them.

use serde::Deserialize;
use std::collections::BTreeMap;
use terrafill_plot::number::significant;

/// A table of a document, each figure once.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct PublishedTable {
    /// What it is called here, where the document does not number it.
    pub name: String,
    /// Section and its title.
    pub place: String,
    /// Of its figures: more is better.
    pub unit: String,
    /// What its columns are.
    pub columns: Vec<String>,
    /// Figures of each row, in the order of the columns.
    pub rows: BTreeMap<String, Vec<f64>>,
}

/// Ratios of two columns in every row of a table: the second's figure over the first's. Figures are rates, so this is
/// the first's time over the second's.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct PublishedRatio {
    /// The table's name.
    pub table: String,
    /// Two columns; one for its figures alone.
    pub of: Vec<String>,
}

impl PublishedTable {
    /// Rows by their number, or as they stand.
    pub(crate) fn ordered(&self) -> Vec<(&str, &[f64])> {
        let number = |row: &str| {
            let digits = row.split(|c: char| !c.is_ascii_digit()).next();
            digits.and_then(|digits| digits.parse::<u64>().ok())
        };
        let rows = self.rows.iter();
        let mut rows: Vec<(&str, &[f64])> = rows
            .map(|(row, figures)| (row.as_str(), figures.as_slice()))
            .collect();
        rows.sort_by_key(|(row, _)| number(row));
        rows
    }

    /// What each row says of one column or of two.
    fn says(&self, of: &[String]) -> Option<String> {
        let places = of
            .iter()
            .map(|name| self.columns.iter().position(|own| own == name));
        let places: Vec<usize> = places.collect::<Option<_>>()?;
        let rows = self.ordered().into_iter().map(|(row, figures)| {
            let figures: Option<Vec<f64>> =
                places.iter().map(|at| figures.get(*at).copied()).collect();
            match figures?[..] {
                [first, second] => Some(format!(
                    "{row}: {second} ÷ {first} = {} ×",
                    significant(second / first)
                )),
                [alone] => Some(format!("{row}: {alone}")),
                _ => None,
            }
        });
        let rows: Vec<String> = rows.collect::<Option<_>>()?;
        let columns = of.iter().rev().map(String::as_str).collect::<Vec<_>>();
        let (name, unit) = (&self.name, &self.unit);
        Some(format!(
            "Table “{name}”, {}, {unit}, row {}",
            columns.join(" ÷ "),
            rows.join("; row ")
        ))
    }

    /// Whether rows are as long as there are columns.
    fn is_whole(&self) -> bool {
        !self.rows.is_empty()
            && self
                .rows
                .values()
                .all(|row| row.len() == self.columns.len())
    }
}

/// What is wrong with the tables, or with a ratio that names one.
pub(crate) fn table_problem(
    tables: &[PublishedTable],
    ratios: &[PublishedRatio],
) -> Option<&'static str> {
    if !tables.iter().all(PublishedTable::is_whole) {
        return Some("stands beside a table whose rows are not as long as its columns are many");
    }
    let is_known = |ratio: &PublishedRatio| says(tables, ratio).is_some();
    (!ratios.iter().all(is_known)).then_some("names a table or a column that there is not")
}

fn says(tables: &[PublishedTable], ratio: &PublishedRatio) -> Option<String> {
    let table = tables.iter().find(|table| table.name == ratio.table)?;
    table.says(&ratio.of)
}

/// What tables say of these ratios, each in a sentence.
pub(crate) fn published(tables: &[PublishedTable], ratios: &[PublishedRatio]) -> Vec<String> {
    ratios
        .iter()
        .filter_map(|ratio| says(tables, ratio))
        .collect()
}
