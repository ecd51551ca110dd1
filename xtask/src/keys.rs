// SPDX-License-Identifier: MIT OR Apache-2.0
//! Studies read conditions and metrics by constants, never by a name in quotes: a misspelt name gives `""`
//! or "not measured", and nothing says so.
//!
//! Most of it is the compiler's work, since constants have types. Three things would still compile, and are
//! refused here. They are a name in quotes where a result is read, a list of nothing but conditions, and the
//! name of a metric anywhere but where it is declared or given a value.

use crate::source::{SourceFile, crates, quoted, without_comments, without_tests};
use anyhow::{Result, bail};
use std::collections::BTreeSet;
use std::path::Path;

/// What reads a result by its first argument, and what does so by a later one.
const READS_FIRST: &[&str] = &[
    "condition",
    "condition_named",
    "samples",
    "replicates",
    "value",
];
const READS_LATER: &[&str] = &[
    "counter",
    "metric",
    "over_typical",
    "process_medians",
    "ratio",
    "sample_spread",
    "share",
    "typical",
    "value",
];
/// What gives a metric its value.
const WRITES: &[&str] = &["add", "ends"];
/// A technique's own parameters, which are no conditions where they are asked.
const NO_CASE: &str = "variant.value";

/// Names that a study declares.
#[derive(Default)]
struct Declared {
    conditions: BTreeSet<String>,
    metrics: BTreeSet<String>,
}

/// A string literal in its brackets.
struct Literal<'a> {
    line: usize,
    text: String,
    /// `(`, `[` or `{`; a space at the top.
    bracket: char,
    /// What stands before the bracket: `case.condition`, `&`, nothing.
    callee: &'a str,
    /// Everything in the brackets before it.
    before: &'a str,
    /// Nothing else stands between the commas, and nothing follows: the last argument.
    is_last: bool,
}

pub(crate) fn check(root: &Path) -> Result<String> {
    let mut studies = crates(root)?;
    studies.retain(|study| study.name.starts_with("crates/studies/"));
    // Of all together: a study may be several crates.
    let files = studies.iter().flat_map(|study| {
        let of_file = |file: &SourceFile| format!("{} {}", study.name, file.module.join("::"));
        let files = study.files.iter();
        files.map(move |file| (of_file(file), file.text.as_str()))
    });
    let files: Vec<(String, &str)> = files.collect();
    let declared = declared(&files);
    let keys = declared.conditions.len() + declared.metrics.len();
    let (wrong, read) = (judge(&files, &declared), files.len());
    if keys == 0 {
        bail!("no study declares a condition or a metric: the sources were not read");
    }
    if !wrong.is_empty() {
        bail!(
            "{} names in quotes, allowed: constants of the study's keys\n{}",
            wrong.len(),
            wrong.join("\n")
        );
    }
    Ok(format!(
        "{read} files of studies read {keys} conditions and metrics by constants alone"
    ))
}

/// Whether a file declares: in a macro's braces, or as an array of metrics.
fn declares(text: &str) -> bool {
    ["conditions! {", "metrics! {", "METRICS: [Metric;"]
        .iter()
        .any(|mark| text.contains(mark))
}

fn declared(files: &[(String, &str)]) -> Declared {
    let mut found = Declared::default();
    for (_, text) in files.iter().filter(|(_, text)| declares(text)) {
        each_literal(text, |literal| {
            let is_named = literal.before.trim_end().ends_with('=') && literal.bracket == '{';
            let names = match literal.callee {
                of if of.ends_with("conditions!") && is_named => &mut found.conditions,
                of if of.starts_with("Metric::") && literal.before.trim().is_empty() => {
                    &mut found.metrics
                }
                _ if literal.before.trim_end().ends_with("name:") => &mut found.metrics,
                _ => return,
            };
            names.insert(literal.text);
        });
        // Constants that studies share are called as their names are.
        let shared = text.split("conditions! {\n    shared ").skip(1);
        let shared = shared.flat_map(|list| list.split(';').next().unwrap_or_default().split(','));
        let shared = shared.map(|key| key.trim().to_lowercase());
        found
            .conditions
            .extend(shared.filter(|name| !name.is_empty()));
    }
    found
}

fn judge(files: &[(String, &str)], declared: &Declared) -> Vec<String> {
    let mut wrong = Vec::new();
    for (name, text) in files.iter().filter(|(_, text)| !declares(text)) {
        each_literal(text, |literal| {
            let callee = literal.callee;
            let word = callee.rsplit(['.', ':']).next().unwrap_or_default();
            let is_call = literal.bracket == '(' && literal.is_last && !word.is_empty();
            let is_first = literal.before.trim().is_empty();
            let reads = if is_first { READS_FIRST } else { READS_LATER };
            let is_read = is_call && reads.contains(&word) && callee != NO_CASE;
            let is_given =
                literal.bracket == '(' && is_first && (word.is_empty() || WRITES.contains(&word));
            let is_found = callee.ends_with("Metric::of");
            let is_metric = literal.text.contains('_') && declared.metrics.contains(&literal.text);
            if is_read || is_metric && !is_given && !is_found {
                wrong.push(format!("{name}, line {}: {:?}", literal.line, literal.text));
            }
        });
        wrong.extend(
            lists(text, declared)
                .into_iter()
                .map(|(line, list)| format!("{name}, line {line}: [{list}]")),
        );
    }
    wrong
}

/// Lists of two or more literals that are all conditions, with their lines.
fn lists(text: &str, declared: &Declared) -> Vec<(usize, String)> {
    let code = without_tests(&without_comments(text));
    let (source, marks): (Vec<char>, Vec<char>) = (text.chars().collect(), code.chars().collect());
    let starts = (0..marks.len()).filter(|&at| marks[at] == '[');
    let list = |start: usize| {
        let length = marks[start..].iter().position(|c| *c == ']')?;
        let inside = start + 1..start + length;
        let is_plain = |c: &char| matches!(c, '"' | ',') || c.is_whitespace();
        let is_plain = marks[inside.clone()].iter().all(is_plain);
        let list: String = source[inside].iter().collect();
        let names: Vec<&str> = list
            .split(',')
            .map(str::trim)
            .filter(|name| !name.is_empty())
            .collect();
        let is_key = |name: &&str| declared.conditions.contains(name.trim_matches('"'));
        let are_keys = names.len() > 1 && names.iter().all(is_key);
        (is_plain && are_keys).then(|| (line(&marks[..start]), names.join(", ")))
    };
    starts.filter_map(list).collect()
}

/// The line that follows these characters.
fn line(before: &[char]) -> usize {
    1 + before.iter().filter(|c| **c == '\n').count()
}

/// Calls `say` with every literal outside of comments and tests.
fn each_literal(text: &str, mut say: impl FnMut(Literal<'_>)) {
    let code = without_tests(&without_comments(text));
    // As long as `text`, character by character.
    let (source, marks): (Vec<char>, Vec<char>) = (text.chars().collect(), code.chars().collect());
    let code: String = marks.iter().collect();
    let bytes: Vec<usize> = code.char_indices().map(|(at, _)| at).collect();
    let mut open: Vec<usize> = Vec::new();
    let mut at = 0;
    while at < marks.len() {
        match marks[at] {
            '(' | '[' | '{' => open.push(at),
            ')' | ']' | '}' => drop(open.pop()),
            '"' => {
                let length = match source[at] {
                    '"' => quoted(&source[at..], '"'),
                    // A character, or a raw text.
                    _ => marks[at..]
                        .iter()
                        .take_while(|c| matches!(c, '"' | '\n'))
                        .count(),
                };
                let end = (at + length).min(marks.len());
                let start = open.last().copied();
                let inside = start.map_or(0, |start| start + 1);
                let next = marks[end..]
                    .iter()
                    .find(|c| !c.is_whitespace() && **c != ',');
                let before = &code[bytes[inside]..bytes[at]];
                let is_last = next == Some(&')')
                    && (before.trim().is_empty() || before.trim_end().ends_with(','));
                let content: String = source[at..end].iter().collect();
                say(Literal {
                    line: line(&marks[..at]),
                    text: content.trim_matches('"').to_owned(),
                    bracket: start.map_or(' ', |start| marks[start]),
                    callee: start.map_or("", |start| callee(&code[..bytes[start]])),
                    before,
                    is_last,
                });
                at = end;
                continue;
            }
            _ => {}
        }
        at += 1;
    }
}

/// The path, method or macro that a bracket belongs to, with what it is called on.
fn callee(code: &str) -> &str {
    let code = code.trim_end();
    let is_part = |c: char| c.is_alphanumeric() || "_.:!?".contains(c);
    &code[code.trim_end_matches(is_part).len()..]
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEYS: &str = "terrafill_results::conditions! {\n    shared VIEW;\n    SUN = \"sun\"; RULE = \"rule\";\n}\n\
                        terrafill_results::metrics! {\n    COST_MS = Metric::less(\n        \"cost_ms\",\n        \"ms\",\n    );\n}\n\
                        const METRICS: [Metric; 1] = [Metric { name: \"draws\", unit: \"\" }];\n";

    fn judged(text: &str) -> Vec<String> {
        let files = [("keys".to_owned(), KEYS), ("a".to_owned(), text)];
        judge(&files, &declared(&files))
    }

    #[test]
    fn names_are_declared_in_macros_and_arrays() {
        let found = declared(&[("keys".to_owned(), KEYS)]);
        let of = |names: &BTreeSet<String>| names.iter().cloned().collect::<Vec<_>>().join(" ");
        assert_eq!(of(&found.conditions), "rule sun view");
        assert_eq!(of(&found.metrics), "cost_ms draws");
    }

    #[test]
    fn constants_texts_and_written_values_are_right() {
        for line in [
            "case.condition(SUN); case.value(COST_MS);",
            "Heading::metric(\"cost\", COST); Heading::plain(\"sun\");",
            "figures.push((\"cost_ms\", 1.0)); watch.ends(\"cost_ms\");",
            "const COST: &Metric = Metric::of(&METRICS, \"cost_ms\");",
            "variant.value(\"walls\");",
            "let names = [\"sun\", \"by its rule\"]; // case.condition(\"sun\")",
            "#[cfg(test)]\nmod tests {\n    fn a() { case.condition(\"sun\"); }\n}",
        ] {
            assert_eq!(judged(line), Vec::<String>::new(), "{line}");
        }
    }

    #[test]
    fn each_name_in_quotes_that_is_read_is_refused_with_its_place() {
        for line in [
            "case.condition(\"sun\");",
            "case.condition(\n    \"sung\",\n);",
            "case.value(\"draws\");",
            "case.samples(\"draws\");",
            "ratio(a, b, \"draws\");",
            "Heading::metric(\"draws\", \"draws\");",
            "let cost = figure(case, \"cost_ms\");",
            "const COST: &str = \"cost_ms\";",
            "clock.pick(GPU, \"cost_ms\");",
            "[\"sun\", \"rule\"].map(|key| of(key));",
            "let same = [\n    \"view\",\n    \"sun\",\n];",
        ] {
            let found = judged(&format!("\n{line}"));
            assert_eq!(found.len(), 1, "{line}: {found:?}");
            assert!(found[0].starts_with("a, line "), "{found:?}");
        }
    }
}
