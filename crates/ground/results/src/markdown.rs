// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blocks as Markdown, for a merge request, a step's summary or a terminal.
//!
//! What only a page can show is left out: drawings, pictures, and what a reader would have to open first.

use crate::{Block, Cell, CellClass, Finding, Table, TableLayout, with_figures};

/// All blocks, a blank line between two that are no findings.
#[must_use]
pub fn markdown(blocks: &[Block]) -> String {
    let mut text = String::new();
    let mut is_after_finding = false;
    for block in blocks {
        let is_finding = matches!(block, Block::Finding(_));
        let piece = match block {
            Block::Heading { level, text } => {
                format!("{} {}\n", "#".repeat(usize::from(*level)), escaped(text))
            }
            Block::Lead(words) | Block::Text(words) | Block::Remark(words) => {
                format!("{}\n", escaped(words))
            }
            Block::Alarm(words) => format!("**{}**\n", escaped(words)),
            Block::List(items) => markdown_list(items),
            Block::Table(table) => markdown_table(table),
            Block::Finding(finding) => markdown_finding(finding),
            Block::Folded {
                summary,
                is_open: true,
                blocks,
            } => format!("{}:\n\n{}", escaped(summary), markdown(blocks)),
            Block::Folded { .. } | Block::Plot(_) | Block::Pictures(_) => {
                continue;
            }
        };
        if !(text.is_empty() || is_finding && is_after_finding) {
            text.push('\n');
        }
        is_after_finding = is_finding;
        text.push_str(&piece);
    }
    text
}

/// A line for each item.
#[must_use]
pub fn markdown_list(items: &[String]) -> String {
    let lines = items.iter().map(|item| format!("- {}\n", escaped(item)));
    lines.collect()
}

/// A finding in a line.
fn markdown_finding(finding: &Finding) -> String {
    let said = escaped(&with_figures(&finding.claim, &finding.because));
    format!("- {said}: **{}**\n", finding.standing.name())
}

/// A table below its caption. Cells of cards say their details too: figures that the caption explains.
fn markdown_table(table: &Table) -> String {
    let mut text = String::new();
    if !table.caption.is_empty() {
        text.push_str(&format!("{}\n\n", escaped(&table.caption)));
    }
    let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    text.push_str(&row(table
        .headings
        .iter()
        .map(|h| escaped(&h.text))
        .collect()));
    text.push_str(&row(vec!["---".to_owned(); table.headings.len()]));
    let is_cards = table.layout == TableLayout::Cards;
    for line in &table.rows {
        let cells = line.cells.iter().map(|own| {
            let detail = Some(escaped(&own.detail)).filter(|_| is_cards && !own.detail.is_empty());
            detail.map_or_else(|| cell(own), |detail| format!("{}: {detail}", cell(own)))
        });
        text.push_str(&row(cells.collect()));
    }
    text
}

/// Its text and its mark.
fn cell(cell: &Cell) -> String {
    match (cell.class, cell.mark.as_str()) {
        (CellClass::Void, _) => format!("~~{}~~", escaped(&cell.text)),
        (_, "") => escaped(&cell.text),
        (_, mark) => format!("{} ({})", escaped(&cell.text), escaped(mark)),
    }
}

/// Text that cannot end a cell or become markup. Intervals such as `[0.98, 1.02]` stay readable: brackets make a link
/// only where `(`, `[` or `:` follows.
#[must_use]
pub fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        let is_link = c == ']' && matches!(rest.peek(), Some('(' | '[' | ':'));
        match c {
            '\n' | '\r' => escaped.push(' '),
            '|' | '<' | '>' | '*' | '`' | '\\' | '~' | '#' => {
                escaped.push('\\');
                escaped.push(c);
            }
            _ if is_link => escaped.push_str("\\]"),
            _ => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Heading, Plot, Row, Standing};

    #[test]
    fn brackets_are_escaped_where_they_would_make_a_link() {
        assert_eq!(escaped("1.20 [1.1, 1.3]"), "1.20 [1.1, 1.3]");
        assert_eq!(escaped("[a](http://b)"), "[a\\](http://b)");
        assert_eq!(escaped("[a]: b"), "[a\\]: b");
    }

    #[test]
    fn blocks_stand_apart_and_findings_together() {
        let table = Block::Table(Table {
            caption: "Times: <advice>".to_owned(),
            headings: vec![Heading::plain("view"), Heading::plain("time")],
            rows: vec![Row::new(vec![Cell::name("a|b\nc"), Cell::plain("2.00 ×")])],
            ..Table::default()
        });
        let finding = |claim: &str| {
            Block::Finding(Finding {
                claim: claim.to_owned(),
                standing: Standing::Holds,
                because: "1.02 ×".to_owned(),
            })
        };
        let folded = |is_open| Block::Folded {
            summary: "names".to_owned(),
            is_open,
            blocks: vec![Block::List(vec!["one".to_owned(), "two".to_owned()])],
        };
        let blocks = [
            Block::section("Times"),
            table,
            finding("First."),
            finding("Second."),
            folded(true),
            // Negative control: nothing of these is shown.
            folded(false),
            Block::Plot(Plot {
                caption: "drawn".to_owned(),
                svg: "<svg/>".to_owned(),
            }),
            Block::Alarm("Lost".to_owned()),
        ];
        let expected = "### Times\n\nTimes: \\<advice\\>\n\n| view | time |\n| --- | --- |\n\
                        | a\\|b c | 2.00 × |\n\n- First. 1.02 ×: **holds**\n- Second. 1.02 ×: **holds**\n\n\
                        names:\n\n- one\n- two\n\n**Lost**\n";
        assert_eq!(markdown(&blocks), expected);
        assert_eq!(markdown(&[]), "");
    }
}
