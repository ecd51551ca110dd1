// SPDX-License-Identifier: MIT OR Apache-2.0
//! The glossary explains every word that tables use for how a case ended, what a figure is and what is concluded.

use terrafill_results::{Kind, Standing, Status};

/// Words in code type in the row of `term`.
fn explained<'a>(glossary: &'a str, term: &str) -> Vec<&'a str> {
    let row = glossary
        .lines()
        .find_map(|line| line.strip_prefix(&format!("| {term} |")));
    let marked = row.unwrap_or_default().split('`');
    marked.skip(1).step_by(2).collect()
}

#[test]
fn every_word_of_a_column_is_explained() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../GLOSSARY.md");
    let glossary = std::fs::read_to_string(path).expect("GLOSSARY.md");
    let kinds = [
        Kind::Counter,
        Kind::DriverCounter,
        Kind::Bytes,
        Kind::Time,
        Kind::Error,
    ];
    let columns = [
        ("`status`", Status::ALL.map(Status::name).to_vec()),
        ("standing", Standing::ALL.map(Standing::name).to_vec()),
        ("kind", kinds.map(Kind::name).to_vec()),
    ];
    for (term, words) in columns {
        let found = explained(&glossary, term);
        for word in words {
            assert!(
                found.contains(&word),
                "{term}: {word} is missing: {found:?}"
            );
        }
        // Controls: a word that is used nowhere, and a glossary without the row.
        assert!(!found.contains(&"passed"));
        assert_eq!(explained("# Glossary\n", term), Vec::<&str>::new());
    }
}
