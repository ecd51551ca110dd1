// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tables that fit: what stands in every row is said once, below.

use terrafill_plot::{DOTS_FACTOR, TWO_GROUPS};
use terrafill_results::{Cell, CellClass, Table, TableLayout};

/// Before the range of a figure.
const RANGES: [&str; 2] = [" (", " ["];

/// A table of so many columns leaves out those that say the same in every row.
const MIN_WIDE: usize = 9;

/// A figure and its range, between which a line may break.
pub(crate) fn before_range(text: &str) -> Vec<&str> {
    let place = RANGES.iter().find_map(|range| text.find(range));
    match place {
        Some(place) => vec![&text[..=place], &text[place + 1..]],
        None => vec![text],
    }
}

/// The columns of a table that are shown, and what the others say. Of a wide table of several rows those are left out
/// whose every figure is the same, and those without one.
pub(crate) fn same_columns(table: &Table) -> (Vec<usize>, String) {
    let is_wide = table.layout == TableLayout::Figures && table.headings.len() >= MIN_WIDE;
    let said_once = |column: usize| {
        let mut cells = table.rows.iter().map(|row| &row.cells[column]);
        let first = cells.clone().find(|cell| cell.class != CellClass::Absent);
        let first = first.or_else(|| cells.clone().next())?;
        let is_same = |cell: &Cell| match cell.class {
            CellClass::Absent => first.class != CellClass::Absent || cell.title == first.title,
            // Processes differ where their medians are written alike.
            class => (class, &cell.text, &cell.mark) == (first.class, &first.text, &first.mark),
        };
        let heading = &table.headings[column].text;
        cells.all(is_same).then(|| match first.class {
            CellClass::Absent => format!("{heading} none ({})", first.title),
            _ => format!("{heading} {}", first.text),
        })
    };
    let is_offered = |column: &usize| is_wide && table.rows.len() > 2 && *column > 0;
    let mut same = Vec::new();
    let varying = (0..table.headings.len()).filter(|column| {
        let said = Some(*column).filter(is_offered).and_then(said_once);
        let is_varying = said.is_none();
        same.extend(said);
        is_varying
    });
    let varying = varying.collect();
    let same = match same.as_slice() {
        [] => String::new(),
        some => format!(
            "The same in every row that has a figure: {}.",
            some.join("; ")
        ),
    };
    (varying, same)
}

/// What the dots of a table are, what its marks mean, and where its commands are; empty where it has none.
pub(crate) fn about_cells(table: &Table) -> String {
    let cells = || table.rows.iter().flat_map(|row| &row.cells);
    let is_cards = table.layout == TableLayout::Cards;
    let has_commands = is_cards && cells().any(|cell| !cell.command.is_empty());
    let commands = if has_commands {
        "Point at a cell for the command that draws it."
    } else {
        ""
    };
    if cells().all(|cell| cell.dots.is_empty()) {
        return commands.to_owned();
    }
    let scale = format!(
        "A dot is a process: the tick is their median, the ends are {DOTS_FACTOR} times less and more, and a \
         triangle lies beyond."
    );
    let groups = if cells().any(|cell| cell.mark == TWO_GROUPS) {
        format!(
            " “{TWO_GROUPS}”: the processes ran as at two clocks, so that the figure is of one of them."
        )
    } else {
        String::new()
    };
    format!("{commands} {scale}{groups}").trim().to_owned()
}

/// Number of the footnote with this text, from 1.
pub(crate) fn footnote<'a>(text: &'a str, footnotes: &mut Vec<&'a str>) -> usize {
    if let Some(index) = footnotes.iter().position(|known| *known == text) {
        index + 1
    } else {
        footnotes.push(text);
        footnotes.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::{Heading, Row};

    #[test]
    fn a_wide_table_says_once_what_every_row_has() {
        let table = |columns: usize, odd: &str| {
            let row = |name: &str, third: Cell| {
                let same = std::iter::repeat_n(Cell::plain("7"), columns - 3);
                let cells = [Cell::name(name), Cell::plain(name), third];
                Row::new(cells.into_iter().chain(same).collect())
            };
            let rows = vec![
                row("a", Cell::absent("no clock")),
                row("b", Cell::plain("0")),
                row("c", Cell::plain(odd)),
            ];
            let headings = (0..columns).map(|column| Heading::plain(format!("h{column}")));
            Table {
                headings: headings.collect(),
                rows,
                ..Table::default()
            }
        };
        let (varying, same) = same_columns(&table(MIN_WIDE, "0"));
        assert_eq!(varying, [0, 1]);
        let said = "The same in every row that has a figure: h2 0; h3 7; h4 7; ";
        assert!(same.starts_with(said), "{same}");
        // Negative controls: a figure that differs, and a table that is narrow as it is.
        assert_eq!(same_columns(&table(MIN_WIDE, "1")).0, [0, 1, 2]);
        let all: Vec<usize> = (0..MIN_WIDE - 1).collect();
        assert_eq!(
            same_columns(&table(MIN_WIDE - 1, "0")),
            (all, String::new())
        );
    }

    #[test]
    fn a_line_may_break_before_a_range_and_nowhere_else() {
        assert_eq!(before_range("1.0 (0.9–1.1)"), ["1.0 ", "(0.9–1.1)"]);
        assert_eq!(before_range("1.0 × [0.9–1.1]"), ["1.0 × ", "[0.9–1.1]"]);
        assert_eq!(before_range("1 234"), ["1 234"]);
    }
}
