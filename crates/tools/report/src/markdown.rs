// SPDX-License-Identifier: MIT OR Apache-2.0
//! `summary.md`: the verdict, the findings and the main tables, for a merge request or a terminal.

use terrafill_results::{Answers, Block, Chapter, escaped, markdown, markdown_list};

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

/// Adds a chapter: its question, its answer, what it requires; then findings and main tables, each under the last
/// heading before it. Nothing is said twice; nothing at all where there is only the question.
pub(crate) fn chapter(text: &mut String, chapter: &dyn Chapter, blocks: &[Block], of: &Answers) {
    let mut shown = of.blocks.clone();
    let required = of.requirements.iter().cloned().map(Block::Finding);
    let required = required.filter(|finding| !of.blocks.contains(finding));
    let required: Vec<Block> = required.collect();
    if !required.is_empty() {
        shown.push(Block::section("Requirements"));
        shown.extend(required);
    }
    let mut heading: Option<&Block> = None;
    for block in blocks {
        let is_shown = match block {
            Block::Heading { .. } => {
                heading = Some(block);
                false
            }
            Block::Table(table) => table.is_main,
            Block::Lead(_) | Block::Finding(_) => true,
            _ => false,
        };
        if is_shown && !shown.contains(block) {
            shown.extend(heading.take().cloned());
            shown.push(block.clone());
        }
    }
    if !shown.is_empty() {
        let (title, question) = (chapter.title(), escaped(chapter.question()));
        text.push_str(&format!(
            "\n## {title}\n\n{question}\n\n{}",
            markdown(&shown)
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::{
        Cell, ChapterError, Clock, Finding, Heading, Row, Run, Standing, Table, TableLayout,
    };

    struct Filling;

    impl Chapter for Filling {
        fn study(&self) -> &'static str {
            "filling"
        }

        fn title(&self) -> &'static str {
            "Filling"
        }

        fn question(&self) -> &'static str {
            "Which is fastest?"
        }

        fn primary_metric(&self, _clock: Clock) -> Option<&'static str> {
            None
        }

        fn blocks(&self, _run: &Run) -> Result<Vec<Block>, ChapterError> {
            Ok(Vec::new())
        }
    }

    fn summary(blocks: &[Block], of: &Answers) -> String {
        let mut text = String::new();
        chapter(&mut text, &Filling, blocks, of);
        text
    }

    fn table(is_main: bool, text: &str) -> Block {
        let cell = Cell {
            detail: "2.00 ms".to_owned(),
            ..Cell::name(text)
        };
        Block::Table(Table {
            headings: vec![Heading::plain("view"), Heading::plain("best")],
            rows: vec![Row::new(vec![Cell::name("a"), cell])],
            is_main,
            layout: TableLayout::Cards,
            ..Table::default()
        })
    }

    #[test]
    fn the_answer_comes_first_with_its_advice_and_its_figures_and_nothing_twice() {
        let finding = |claim: &str| Finding {
            claim: claim.to_owned(),
            standing: Standing::CannotTell,
            because: "1.02 ×".to_owned(),
        };
        let of = Answers {
            blocks: vec![
                Block::Lead("Take strips.".to_owned()),
                table(true, "strips"),
                Block::section("What to take"),
                Block::List(vec!["Far → strips.".to_owned()]),
            ],
            requirements: vec![finding("All are right.")],
            ..Answers::default()
        };
        let blocks = [
            Block::Lead("Take strips.".to_owned()),
            Block::section("One thing changed"),
            table(true, "a|b"),
            table(false, "hidden"),
            Block::List(vec!["names".to_owned()]),
            Block::Finding(finding("Strips made no <difference>.")),
        ];
        assert_eq!(
            summary(&blocks, &of),
            "\n## Filling\n\nWhich is fastest?\n\nTake strips.\n\n| view | best |\n| --- | --- |\n\
             | a | strips: 2.00 ms |\n\n### What to take\n\n- Far → strips.\n\n### Requirements\n\n\
             - All are right. 1.02 ×: **undecided**\n\n### One thing changed\n\n| view | best |\n\
             | --- | --- |\n| a | a\\|b: 2.00 ms |\n\n\
             - Strips made no \\<difference\\>. 1.02 ×: **undecided**\n"
        );
        // Negative control: a chapter that says nothing is not mentioned.
        let nothing = summary(&[table(false, "hidden")], &Answers::default());
        assert_eq!(nothing, "");
    }
}
