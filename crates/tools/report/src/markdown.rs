// SPDX-License-Identifier: MIT OR Apache-2.0
//! `summary.md`: the verdict, the findings and the main tables, for a merge request or a terminal.

use terrafill_results::{Block, escaped, markdown_finding, markdown_list, markdown_table};

/// Starts the text with the verdict.
pub(crate) fn head(sentences: &[String], facts: &[(&str, String)]) -> String {
    let mut text = format!(
        "# terrafill: measurement report\n\n{}\n",
        sentences.join(" ")
    );
    for (label, value) in facts.iter().filter(|(_, value)| !value.is_empty()) {
        text.push_str(&format!("\n- {label}: {}", escaped(value)));
    }
    text.push('\n');
    text
}

/// Adds names under a heading; nothing where there are none.
pub(crate) fn names(text: &mut String, heading: &str, names: &[String]) {
    if names.is_empty() {
        return;
    }
    text.push_str(&format!("\n## {heading}\n\n{}", markdown_list(names)));
}

/// Adds a chapter's findings and main tables, each under the last heading before it.
pub(crate) fn chapter(text: &mut String, title: &str, blocks: &[Block]) {
    let mut own = String::new();
    let mut heading: Option<&str> = None;
    let mut is_after_finding = false;
    for block in blocks {
        let piece = match block {
            Block::Heading { text, .. } => {
                heading = Some(text);
                continue;
            }
            Block::Finding(finding) => markdown_finding(finding),
            Block::Lead(answer) => format!("\n{}\n", escaped(answer)),
            Block::Table(main) if main.is_main => format!("\n{}", markdown_table(main)),
            _ => continue,
        };
        if let Some(heading) = heading.take() {
            own.push_str(&format!("\n### {}\n", escaped(heading)));
            is_after_finding = false;
        }
        let is_finding = matches!(block, Block::Finding(_));
        if is_finding && !is_after_finding {
            own.push('\n');
        }
        is_after_finding = is_finding;
        own.push_str(&piece);
    }
    if !own.is_empty() {
        text.push_str(&format!("\n## {title}\n\n{}\n", own.trim()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::{Cell, Finding, Heading, Row, Standing, Table};

    #[test]
    fn main_tables_and_findings_are_repeated_and_others_are_not() {
        let table = |is_main, text: &str| {
            Block::Table(Table {
                headings: vec![Heading::plain("view"), Heading::plain("time")],
                rows: vec![Row::new(vec![Cell::name(text), Cell::plain("2.00 ×")])],
                is_main,
                ..Table::default()
            })
        };
        let blocks = [
            Block::section("One thing changed"),
            table(true, "a|b\nc"),
            table(false, "hidden"),
            Block::Finding(Finding {
                claim: "Strips made no <difference>.".to_owned(),
                standing: Standing::CannotTell,
                because: "1.02 ×".to_owned(),
            }),
        ];
        let mut text = String::new();
        chapter(&mut text, "Filling", &blocks);
        assert!(text.contains("### One thing changed\n\n| view | time |\n| --- | --- |\n"));
        assert!(text.contains("| a\\|b c | 2.00 × |"), "{text}");
        assert!(!text.contains("hidden"));
        let finding =
            "| a\\|b c | 2.00 × |\n\n- Strips made no \\<difference\\>. 1.02 ×: **undecided**";
        assert!(text.contains(finding), "{text}");
        // Negative control: a chapter without either is not mentioned.
        let mut text = String::new();
        chapter(&mut text, "Filling", &[table(false, "hidden")]);
        assert_eq!(text, "");
    }
}
