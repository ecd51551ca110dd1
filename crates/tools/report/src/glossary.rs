// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the words of a report mean. Each is explained once, where the thing is declared that it names: general words in
//! `GLOSSARY.md`, a technique's and a study's with them, metrics in the run.
//!
//! A page ends with the words that stand on it; its script says them where they stand. A word that this program does
//! not know, such as a switch of an older one, has no entry.

use askama::Template;
use std::collections::BTreeSet;
use terrafill_results::{Block, MetricRow, Table, Term};

/// General words, in sections of tables.
const GENERAL: &str = include_str!("../../../../GLOSSARY.md");

/// Groups of words that names in answers are made of.
const OF_NAMES: [&str; 2] = [TECHNIQUES, "In names of fills"];

/// The group of techniques and their layouts.
pub const TECHNIQUES: &str = "Techniques and their layouts";

/// Its sections about other pages than a report's.
const OF_OTHER_PAGES: [&str; 2] = ["In the gate", "In a history"];

/// Words that belong together, under a title.
pub type TermGroup = (&'static str, Vec<Term>);

/// A word and what it means.
struct Entry {
    word: String,
    /// Of a metric; else empty.
    unit: String,
    meaning: String,
}

impl Entry {
    fn new(word: &str, meaning: &str) -> Self {
        Self {
            word: word.to_owned(),
            unit: String::new(),
            meaning: meaning.to_owned(),
        }
    }
}

/// Every word that a report may use, in groups with titles.
pub(crate) struct Glossary(Vec<(String, Vec<Entry>)>);

/// The entries of a page.
#[derive(Template)]
#[template(path = "glossary.html")]
pub(crate) struct Entries<'a> {
    groups: Vec<(&'a str, Vec<&'a Entry>)>,
}

impl Glossary {
    /// - `terms`: of techniques and chapters
    pub(crate) fn new(terms: impl IntoIterator<Item = TermGroup>, metrics: &[MetricRow]) -> Self {
        let mut groups = general();
        groups.extend(terms.into_iter().map(|(title, terms)| {
            let terms = terms.into_iter();
            let entries = terms.map(|(word, meaning)| Entry::new(word, meaning));
            (title.to_owned(), entries.collect())
        }));
        let metrics = metrics.iter().map(|metric| Entry {
            unit: metric.unit.clone(),
            ..Entry::new(&metric.name, &metric.meaning)
        });
        groups.push(("Metrics".to_owned(), metrics.collect()));
        Self(groups)
    }

    /// What the names in a text are made of, a line for each word, in the order in which they stand there first.
    pub(crate) fn of_names(&self, text: &str) -> Vec<String> {
        let text = plain(text);
        let groups = self.0.iter();
        let groups = groups.filter(|(title, _)| OF_NAMES.contains(&title.as_str()));
        let entries = groups.flat_map(|(_, entries)| entries);
        let found = entries.filter_map(|entry| {
            let word = plain(&entry.word);
            let place = text.find(&word).filter(|_| stands_in(&word, &text))?;
            Some((place, format!("{}: {}", entry.word, entry.meaning)))
        });
        let mut found: Vec<(usize, String)> = found.collect();
        found.sort();
        found.into_iter().map(|(_, line)| line).collect()
    }

    /// The entries of words that stand in one of `texts`.
    pub(crate) fn of(&self, texts: &BTreeSet<String>) -> Entries<'_> {
        // No word goes over the end of a line, so that all texts are searched at once.
        let text = texts
            .iter()
            .map(String::as_str)
            .collect::<Vec<_>>()
            .join("\n");
        let stands = |entry: &&Entry| stands_in(&plain(&entry.word), &text);
        let groups = self.0.iter().map(|(title, entries)| {
            let own: Vec<&Entry> = entries.iter().filter(stands).collect();
            (title.as_str(), own)
        });
        Entries {
            groups: groups.filter(|(_, entries)| !entries.is_empty()).collect(),
        }
    }
}

/// The tables of `GLOSSARY.md`: a group for each section.
fn general() -> Vec<(String, Vec<Entry>)> {
    let sections = GENERAL.split("\n## ").skip(1);
    let sections = sections.filter_map(|section| {
        let (title, rows) = section.split_once('\n')?;
        let rows = rows.lines().filter_map(|row| {
            let (words, meaning) = row.strip_prefix("| ")?.split_once(" | ")?;
            (words != "term").then(|| (words.replace('`', ""), meaning.replace('`', "")))
        });
        let entries = rows.flat_map(|(words, meaning)| {
            let meaning = meaning.trim_end_matches(['|', ' ']).to_owned();
            let words: Vec<String> = words.split(", ").map(str::to_owned).collect();
            words
                .into_iter()
                .map(move |word| Entry::new(&word, &meaning))
        });
        Some((title.to_owned(), entries.collect()))
    });
    sections
        .filter(|(title, _): &(String, _)| !OF_OTHER_PAGES.contains(&title.as_str()))
        .collect()
}

/// Adds the texts of `blocks` in which words are explained: headings, names in tables and drawings, answers. Metrics
/// that columns show are among them by name.
pub(crate) fn collect(blocks: &[Block], texts: &mut BTreeSet<String>) {
    for block in blocks {
        match block {
            Block::Heading { text, .. } | Block::Lead(text) => {
                texts.insert(plain(text));
            }
            Block::List(items) => texts.extend(items.iter().map(|item| plain(item))),
            Block::Table(table) => of_table(table, texts),
            Block::Plot(plot) => texts.extend(of_drawing(&plot.svg)),
            Block::Folded { blocks, .. } => collect(blocks, texts),
            Block::Finding(finding) => {
                texts.insert(plain(finding.standing.name()));
            }
            Block::Text(_) | Block::Remark(_) | Block::Alarm(_) | Block::Pictures(_) => {}
        }
    }
}

fn of_table(table: &Table, texts: &mut BTreeSet<String>) {
    for heading in &table.headings {
        texts.extend([plain(&heading.text), plain(&heading.metric)]);
    }
    for cell in table.rows.iter().flat_map(|row| &row.cells) {
        texts.insert(plain(&cell.text));
    }
}

/// The texts of an SVG element.
pub(crate) fn of_drawing(svg: &str) -> impl Iterator<Item = String> {
    svg.split("<text").skip(1).filter_map(|rest| {
        let (_, text) = rest.split_once('>')?;
        Some(plain(text.split_once('<')?.0))
    })
}

/// As words are looked for: in small letters, with spaces in place of what joins words in names of columns.
fn plain(text: &str) -> String {
    text.to_lowercase().replace('_', " ")
}

/// Whether `word` stands in `text` by itself or in its plural; both are [`plain`].
fn stands_in(word: &str, text: &str) -> bool {
    let goes_on = |c: char| c.is_alphanumeric() || c == '-';
    text.match_indices(word).any(|(at, _)| {
        let after = &text[at + word.len()..];
        let singular = ["", "s", "es"].into_iter();
        let mut ends = singular.filter_map(|ending| after.strip_prefix(ending));
        !text[..at].ends_with(goes_on) && ends.any(|rest| !rest.starts_with(goes_on))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_stands_by_itself_or_in_its_plural() {
        for (word, text) in [
            ("gs-line", "native/gs-line, full plan"),
            ("full plan", "native/gs-line, full plan"),
            ("part-culling", "part-culling=all"),
            ("tie", "ties"),
            ("near_m", "sun, near m"),
        ] {
            assert!(stands_in(&plain(word), &plain(text)), "{word} in {text}");
        }
        // Negative controls: a piece of another word.
        for (word, text) in [
            ("line", "gs-line"),
            ("full", "fully"),
            ("tie", "untied ties-up"),
        ] {
            assert!(!stands_in(&plain(word), &plain(text)), "{word} in {text}");
        }
    }

    #[test]
    fn the_general_words_are_read_and_those_of_other_pages_left_out() {
        let general = general();
        let meaning = |word: &str| {
            let mut entries = general.iter().flat_map(|(_, entries)| entries);
            entries
                .find(|entry| entry.word == word)
                .map(|entry| entry.meaning.as_str())
        };
        assert_eq!(
            meaning("whisker"),
            Some("From the 5th to the 95th percentile.")
        );
        assert!(meaning("mask_hash").is_some() && meaning("ids_hash").is_some());
        for absent in ["blessing", "drift", "term", "made-up"] {
            assert_eq!(meaning(absent), None, "{absent}");
        }
    }

    #[test]
    fn a_name_in_an_answer_is_explained_word_by_word() {
        let fills = (
            TECHNIQUES,
            vec![
                ("gs-line", "from lines"),
                ("cached", "kept"),
                ("native", "Vulkan"),
            ],
        );
        let glossary = Glossary::new([fills, ("Switches", vec![("take", "no name")])], &[]);
        assert_eq!(
            glossary.of_names("Take native/gs-line: 1 ms."),
            ["native: Vulkan", "gs-line: from lines"]
        );
        let planned = glossary.of_names("Take native/gs-line, full plan");
        assert!(planned[2].starts_with("full plan: "), "{planned:?}");
        assert!(glossary.of_names("Take strips.").is_empty(), "control");
    }

    #[test]
    fn only_words_that_stand_on_a_page_are_on_its_list() {
        let glossary = Glossary::new(
            [("Fills", vec![("gs-line", "lines"), ("cached", "kept")])],
            &[],
        );
        let mut texts = BTreeSet::new();
        let svg = "<svg><text x=\"1\">native/gs-line</text></svg>";
        collect(
            &Block::plot("", Some(svg.to_owned()))
                .into_iter()
                .collect::<Vec<_>>(),
            &mut texts,
        );
        let page = glossary.of(&texts).render().expect("a list");
        assert!(
            page.contains("gs-line") && !page.contains("cached"),
            "{page}"
        );
    }
}
