// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every word of a report's columns, legends, names of fills and answers has a line in its glossary.

use crate::committed::{committed, unpacked};
use crate::harness::Desk;
use std::collections::BTreeSet;
use std::fs;

/// Names in committed runs of older programs, which have no entry and are shown as they are.
const OF_OLDER_PROGRAMS: [&str; 4] = ["depth-bounds", "shared-levels", "wall-band", "xor-front"];

/// Attributes and contents of each `element` of the page.
pub(crate) fn elements<'p>(page: &'p str, element: &str) -> Vec<(&'p str, &'p str)> {
    let (begin, end) = (format!("<{element}"), format!("</{element}>"));
    let elements = page.split(begin.as_str()).skip(1).filter_map(|rest| {
        let rest = rest.split_once(end.as_str())?.0;
        rest.split_once('>')
    });
    let is_whole =
        |(attributes, _): &(&str, &str)| attributes.is_empty() || attributes.starts_with(' ');
    elements.filter(is_whole).collect()
}

/// What a reader sees of an element, its small print left out.
pub(crate) fn text(html: &str) -> String {
    let html = html
        .split("<div class=\"detail\">")
        .next()
        .unwrap_or_default();
    let pieces = html.split('<').enumerate();
    let pieces = pieces.map(|(index, piece)| match piece.split_once('>') {
        Some((_, text)) if index > 0 => text,
        _ => piece,
    });
    let text = pieces.collect::<String>();
    text.replace("&#39;", "'")
        .replace("&apos;", "'")
        .replace("&#38;", "&")
        .replace("&amp;", "&")
        .replace('\u{a0}', " ")
}

/// Words apart from each other, in small letters, with a space at both ends.
fn spaced(text: &str) -> String {
    let is_of_word = |c: char| c.is_alphanumeric() || ['-', '%', '÷'].contains(&c);
    let words = text.to_lowercase();
    let words = words
        .split(|c| !is_of_word(c))
        .filter(|word| !word.is_empty());
    format!(" {} ", words.collect::<Vec<_>>().join(" "))
}

/// The parts of names that need an entry: words, and no names of scenes and views, figures or units.
fn parts<'t>(name: &'t str, of_data: &'t BTreeSet<String>) -> impl Iterator<Item = &'t str> {
    let parts = name
        .split([',', '/', '·', ':', ';', '(', ')'])
        .map(str::trim);
    parts.filter(|part| {
        part.starts_with(char::is_alphabetic)
            && part.chars().count() > 2
            && *part != "degrees"
            && !of_data.contains(*part)
    })
}

/// Parts of names in `page` without an entry in its glossary.
fn unexplained(page: &str, of_data: &BTreeSet<String>) -> BTreeSet<String> {
    let entries = elements(page, "dt").into_iter();
    let entries = entries.filter_map(|(_, entry)| Some(elements(entry, "code").first()?.1));
    let entries: Vec<String> = entries.map(spaced).collect();
    let has_entry = |part: &str| {
        let part = spaced(part);
        let is_in = |entry: &String| {
            let entry = entry.trim_end();
            ["", "s", "es"]
                .iter()
                .any(|ending| part.contains(&format!("{entry}{ending} ")))
        };
        entries.iter().any(is_in)
    };
    let columns = elements(page, "th").into_iter().filter(|(attributes, _)| {
        attributes.contains("scope=\"col\"") && !attributes.contains("title=")
    });
    let legends = elements(page, "text").into_iter();
    let cells = elements(page, "th").into_iter().chain(elements(page, "td"));
    let leads = elements(page, "p").into_iter();
    let leads = leads.filter(|(attributes, _)| attributes.contains("class=\"lead\""));
    let answers = leads.flat_map(|(_, lead)| lead.split(' '));
    let fills = cells.map(|(_, cell)| text(cell)).chain(answers.map(text));
    let fills = fills.filter(|name| is_fill(name));
    let names = columns
        .chain(legends)
        .map(|(_, name)| text(name))
        .chain(fills);
    let missing = names.flat_map(|name| {
        let missing = parts(&name, of_data).filter(|part| !has_entry(part));
        missing.map(str::to_owned).collect::<Vec<_>>()
    });
    missing.collect()
}

/// Whether it begins with a technique and its layout.
fn is_fill(name: &str) -> bool {
    let is_of_name = |c: char| c.is_ascii_lowercase() || c == '-';
    let technique = name.split_once('/');
    technique.is_some_and(|(technique, layout)| {
        !technique.is_empty() && technique.chars().all(is_of_name) && layout.starts_with(is_of_name)
    })
}

/// Names of scenes and views of the run on the desk.
fn names_of_data(desk: &Desk) -> BTreeSet<String> {
    let mut cases = csv::Reader::from_path(desk.path("run/cases.csv")).expect("a table");
    let headers = cases.headers().expect("a header").clone();
    let of_data = |name: &str| ["scene", "view"].contains(&name);
    let columns: Vec<usize> = (0..headers.len())
        .filter(|at| of_data(&headers[*at]))
        .collect();
    let rows = cases.records().map(|row| row.expect("a row"));
    rows.flat_map(|row| {
        columns
            .iter()
            .map(|at| row[*at].to_owned())
            .collect::<Vec<_>>()
    })
    .collect()
}

#[test]
fn every_word_of_a_committed_report_has_an_entry() {
    let reports = committed();
    assert!(reports.len() > 4, "{reports:?}");
    let (mut missing, mut of_older) = (Vec::new(), BTreeSet::new());
    for report in reports {
        let desk = unpacked(&report);
        assert_eq!(desk.run(&["report", "run", "--single-file"]).code, 0);
        let page = fs::read_to_string(desk.path("run/index.html")).expect("a page");
        let of_data = names_of_data(&desk);
        for word in unexplained(&page, &of_data) {
            if OF_OLDER_PROGRAMS.contains(&word.as_str()) {
                of_older.insert(word);
            } else {
                missing.push(format!("{}: {word}", report.display()));
            }
        }
        // Negative controls: a column, a legend, and an entry that is gone.
        let wrong =
            format!("{page}<th scope=\"col\">glorp</th><text x=\"1\">gs-glorp, cached</text>");
        let found = unexplained(&wrong, &of_data);
        assert!(
            found.contains("glorp") && found.contains("gs-glorp"),
            "{found:?}"
        );
        let without = page.replace("<dt><code>", "<dt><code>un");
        assert!(unexplained(&without, &of_data).len() > 4);
    }
    assert!(
        missing.is_empty(),
        "without an entry:\n{}",
        missing.join("\n")
    );
    assert_eq!(of_older.len(), OF_OLDER_PROGRAMS.len(), "{of_older:?}");
}
