// SPDX-License-Identifier: MIT OR Apache-2.0
//! The report of a gate as JUnit, for the pages of continuous integration.
//!
//! A case is a test, and a study's scene and view is its class. The file keeps to Jenkins' `junit-10.xsd`, which
//! knows fewer attributes than other readers do.

use crate::{Finding, Gate, GateReport, Severity, Span};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// What is said of one case.
#[derive(Default)]
struct Test<'a> {
    findings: Vec<&'a Finding>,
    /// Why neither side ran it.
    skipped: Option<&'a str>,
}

impl Test<'_> {
    /// The worst that counts: findings come sorted.
    fn worst(&self) -> Option<&Finding> {
        self.findings
            .iter()
            .copied()
            .find(|finding| finding.counts())
    }

    fn is_failure(&self) -> bool {
        self.worst()
            .is_some_and(|worst| worst.severity != Severity::Unknown)
    }

    fn is_skipped(&self) -> bool {
        !self.is_failure() && (self.worst().is_some() || self.skipped.is_some())
    }
}

/// A JUnit file: a case is a test; an inconclusive one is skipped, with its reason; what is blessed stands in the
/// test's output.
#[must_use]
pub fn junit(report: &GateReport) -> String {
    let mut tests: BTreeMap<(String, &str), Test<'_>> = BTreeMap::new();
    for case in &report.compared {
        tests.entry(class_and_name(case)).or_default();
    }
    for (case, reason) in &report.skipped {
        tests.entry(class_and_name(case)).or_default().skipped = Some(reason);
    }
    for finding in &report.findings {
        if finding.counts() || finding.blessed.is_some() {
            tests
                .entry(class_and_name(&finding.case))
                .or_default()
                .findings
                .push(finding);
        }
    }
    let seconds = seconds(report);
    let mut classes: BTreeMap<&str, Vec<(&str, &Test<'_>)>> = BTreeMap::new();
    for ((class, name), test) in &tests {
        classes.entry(class).or_default().push((name, test));
    }
    let count = |is_so: fn(&Test<'_>) -> bool| tests.values().filter(|test| is_so(test)).count();
    let mut xml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <testsuites name=\"terrafill gate\" tests=\"{}\" failures=\"{}\" errors=\"0\" time=\"{:.3}\">\n",
        tests.len(),
        count(|test| test.is_failure()),
        report.elapsed_s
    );
    for (class, tests) in classes {
        let time = |name: &str| {
            seconds
                .get(&(class.to_owned(), name))
                .copied()
                .unwrap_or(0.0)
        };
        let count =
            |is_so: fn(&Test<'_>) -> bool| tests.iter().filter(|(_, test)| is_so(test)).count();
        let _ = writeln!(
            xml,
            "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"{}\" time=\"{:.3}\">",
            escape(class),
            tests.len(),
            count(|test| test.is_failure()),
            count(|test| test.is_skipped()),
            tests.iter().map(|(name, _)| time(name)).sum::<f64>()
        );
        for (name, test) in tests {
            let _ = writeln!(
                xml,
                "    <testcase classname=\"{}\" name=\"{}\" time=\"{:.6}\">",
                escape(class),
                escape(name),
                time(name)
            );
            xml += &body(test);
            xml += "    </testcase>\n";
        }
        xml += "  </testsuite>\n";
    }
    xml + "</testsuites>\n"
}

fn body(test: &Test<'_>) -> String {
    let mut xml = String::new();
    let counted: Vec<&&Finding> = test
        .findings
        .iter()
        .filter(|finding| finding.counts())
        .collect();
    if let Some(worst) = test.worst() {
        let element = if test.is_failure() {
            "failure"
        } else {
            "skipped"
        };
        let mut text: Vec<String> = counted.iter().map(|finding| finding.sentence()).collect();
        text.extend(worst.command().map(|command| format!("see: {command}")));
        let _ = writeln!(
            xml,
            "      <{element} type=\"{}\" message=\"{}\">{}</{element}>",
            kind(worst),
            escape(&worst.sentence()),
            escape(&text.join("\n"))
        );
    } else if let Some(reason) = test.skipped {
        let _ = writeln!(
            xml,
            "      <skipped type=\"not-run\" message=\"{}\"/>",
            escape(reason)
        );
    }
    let blessed = test.findings.iter().filter_map(|finding| {
        let reason = finding.blessed.as_ref()?;
        Some(format!("blessed: {}; {reason}", finding.sentence()))
    });
    let blessed: Vec<String> = blessed.collect();
    if !blessed.is_empty() {
        let _ = writeln!(
            xml,
            "      <system-out>{}</system-out>",
            escape(&blessed.join("\n"))
        );
    }
    xml
}

fn kind(finding: &Finding) -> &'static str {
    match finding.gate {
        Gate::Status => "status",
        Gate::Counters => "counters",
        Gate::Errors => "errors",
        Gate::Limits => "limits",
        Gate::Time => "time",
    }
}

/// Study, scene and view with dots between them, as readers make a tree of them; and the rest of the key.
fn class_and_name(case: &str) -> (String, &str) {
    let mut slashes = case.match_indices('/').map(|(at, _)| at);
    match slashes.nth(2).or_else(|| case.rfind('/')) {
        Some(at) => (case[..at].replace('/', "."), &case[at + 1..]),
        None => ("gate".to_owned(), case),
    }
}

/// Seconds of the new program's frame, by class and name.
fn seconds(report: &GateReport) -> BTreeMap<(String, &str), f64> {
    let times = report.time.iter().flat_map(|time| &time.cases);
    let frames = times.filter(|case| case.span == Span::Frame);
    frames
        .filter_map(|case| Some((class_and_name(&case.case), 1e-3 * case.new_ms?)))
        .collect()
}

/// Text that stands between tags and in quotes. What XML cannot hold is replaced.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\n' => escaped += "&#10;",
            '\u{fffe}' | '\u{ffff}' => escaped.push('\u{fffd}'),
            other if other.is_control() && other != '\t' => escaped.push('\u{fffd}'),
            other => escaped.push(other),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CaseTime;
    use crate::made_up_report::{finding, report};

    /// An element with its attributes and what stands in it.
    #[derive(Debug)]
    struct Element {
        name: String,
        attributes: BTreeMap<String, String>,
        children: Vec<Self>,
        text: String,
    }

    /// Reads an element of a document without comments; what does not fit is an error.
    fn parse(xml: &mut &str) -> Result<Element, String> {
        let start = xml
            .trim_start()
            .strip_prefix('<')
            .ok_or_else(|| format!("no tag: {xml:.40}"))?;
        let end = start.find('>').ok_or("an open tag")?;
        let (tag, is_empty) = match start[..end].strip_suffix('/') {
            Some(tag) => (tag, true),
            None => (&start[..end], false),
        };
        let (name, mut rest) = tag.split_once(' ').unwrap_or((tag, ""));
        let mut element = Element {
            name: name.to_owned(),
            attributes: BTreeMap::new(),
            children: Vec::new(),
            text: String::new(),
        };
        while !rest.trim().is_empty() {
            let (key, value) = rest.trim_start().split_once("=\"").ok_or("no value")?;
            let (value, after) = value.split_once('"').ok_or("an open quote")?;
            if element
                .attributes
                .insert(key.to_owned(), value.to_owned())
                .is_some()
            {
                return Err(format!("{key} twice"));
            }
            rest = after;
        }
        *xml = &start[end + 1..];
        if is_empty {
            return Ok(element);
        }
        loop {
            let next = xml
                .find('<')
                .ok_or_else(|| format!("{name} is not closed"))?;
            element.text += xml[..next].trim();
            *xml = &xml[next..];
            if let Some(after) = xml.strip_prefix("</") {
                let after = after
                    .strip_prefix(name)
                    .and_then(|after| after.strip_prefix('>'));
                *xml = after.ok_or_else(|| format!("{name} is closed by another tag"))?;
                break;
            }
            element.children.push(parse(xml)?);
        }
        Ok(element)
    }

    /// What `junit-10.xsd` allows of the elements that the gate writes: attributes, those that are needed, children.
    type Rule<'a> = (&'a str, &'a [&'a str], &'a [&'a str], &'a [&'a str]);
    const RULES: [Rule<'_>; 6] = [
        (
            "testsuites",
            &["name", "time", "tests", "failures", "errors"],
            &[],
            &["testsuite"],
        ),
        (
            "testsuite",
            &[
                "name",
                "tests",
                "failures",
                "errors",
                "group",
                "time",
                "skipped",
                "timestamp",
                "hostname",
                "id",
                "package",
            ],
            &["name", "tests", "failures", "errors"],
            &[
                "testsuite",
                "properties",
                "testcase",
                "system-out",
                "system-err",
            ],
        ),
        (
            "testcase",
            &["name", "time", "classname", "group"],
            &["name"],
            &["skipped", "error", "failure", "system-out", "system-err"],
        ),
        ("failure", &["type", "message"], &[], &[]),
        ("skipped", &["type", "message"], &[], &[]),
        ("system-out", &[], &[], &[]),
    ];

    fn check(element: &Element) -> Result<(), String> {
        let rule = RULES.iter().find(|(name, ..)| *name == element.name);
        let (name, allowed, needed, children) =
            rule.ok_or_else(|| format!("element {}", element.name))?;
        for (key, value) in &element.attributes {
            if !allowed.contains(&key.as_str()) {
                return Err(format!("{name}/@{key}"));
            }
            // The pattern of a suite's time: digits, a point, three more at most.
            let decimals = value.split_once('.').map_or("", |(_, decimals)| decimals);
            let is_number = value.chars().all(|c| c.is_ascii_digit() || c == '.');
            if key == "time" && !(is_number && (name == &"testcase" || decimals.len() <= 3)) {
                return Err(format!("{name}/@time {value}"));
            }
        }
        if let Some(key) = needed
            .iter()
            .find(|key| !element.attributes.contains_key(**key))
        {
            return Err(format!("{name} without @{key}"));
        }
        for child in &element.children {
            if !children.contains(&child.name.as_str()) {
                return Err(format!("{} in {name}", child.name));
            }
            check(child)?;
        }
        Ok(())
    }

    fn checked(xml: &str) -> Result<Element, String> {
        let declaration = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
        let mut rest = xml.strip_prefix(declaration).ok_or("no declaration")?;
        let root = parse(&mut rest)?;
        if !rest.trim().is_empty() || root.name != "testsuites" {
            return Err(format!("root {}, then {rest:?}", root.name));
        }
        check(&root)?;
        Ok(root)
    }

    fn full() -> GateReport {
        let mut blessed = finding("filling/b/globe/vertex", Severity::Worse, Gate::Counters);
        blessed.blessed = Some("two <caps> & \"more\"\u{1b}".to_owned());
        let mut report = report(vec![
            finding("filling/a/globe/vertex", Severity::Worse, Gate::Counters),
            finding("filling/a/globe/vertex", Severity::Unknown, Gate::Time),
            blessed,
            finding("filling/d/globe/vertex", Severity::Unknown, Gate::Time),
            finding("(all cases)", Severity::Unknown, Gate::Status),
        ]);
        report.compared = ["a", "b", "d"]
            .map(|scene| format!("filling/{scene}/globe/vertex"))
            .to_vec();
        report.time = Some(crate::TimeGate {
            cases: vec![CaseTime {
                case: "filling/a/globe/vertex".to_owned(),
                new_ms: Some(12.5),
                ..CaseTime::default()
            }],
            ..crate::TimeGate::default()
        });
        report
    }

    #[test]
    fn the_file_is_what_jenkins_schema_allows() {
        for report in [full(), report(Vec::new()), GateReport::default()] {
            let xml = junit(&report);
            checked(&xml).unwrap_or_else(|error| panic!("{error}: {xml}"));
        }
        // Negative controls: what it was refused for, and what would not be well-formed.
        let xml = junit(&full());
        for (from, to, error) in [
            (
                "<testsuites name",
                "<testsuites skipped=\"1\" name",
                "testsuites/@skipped",
            ),
            (
                "<testcase classname",
                "<testcase class=\"x\" classname",
                "testcase/@class",
            ),
            (
                " errors=\"0\" skipped",
                " skipped",
                "testsuite without @errors",
            ),
            ("</failure>", "</skipped>", "closed by another tag"),
            ("time=\"0.012500\"", "time=\"12 ms\"", "@time"),
            ("time=\"12.000\"", "time=\"12.000001\"", "testsuites/@time"),
            ("<system-out>", "<failure><system-out>", ""),
        ] {
            let wrong = xml.replace(from, to);
            assert_ne!(wrong, xml, "{from}");
            let refused = checked(&wrong).expect_err(to);
            assert!(refused.contains(error), "{refused}");
        }
    }

    #[test]
    fn a_case_is_a_test_of_its_scene_and_view_with_kind_time_and_text() {
        let root = checked(&junit(&full())).expect("valid");
        let of = |element: &Element, key: &str| element.attributes[key].clone();
        assert_eq!([of(&root, "tests"), of(&root, "failures")], ["5", "1"]);
        let suite = |name: &str| {
            root.children
                .iter()
                .find(|suite| of(suite, "name") == name)
                .expect(name)
        };
        let a = suite("filling.a.globe");
        let test = &a.children[0];
        let words = ["classname", "name", "time"].map(|key| of(test, key));
        assert_eq!(words, ["filling.a.globe", "vertex", "0.012500"]);
        let failure = &test.children[0];
        assert_eq!(
            [failure.name.as_str(), &of(failure, "type")],
            ["failure", "counters"]
        );
        assert!(
            of(failure, "message").starts_with("draws 3 → 6"),
            "{failure:?}"
        );
        assert!(
            failure.text.contains("see: terrafill bench california"),
            "{failure:?}"
        );
        let b = &suite("filling.b.globe").children[0];
        assert_eq!(
            (b.children.len(), b.children[0].name.as_str()),
            (1, "system-out")
        );
        assert!(
            b.children[0]
                .text
                .ends_with("two &lt;caps&gt; &amp; &quot;more&quot;\u{fffd}"),
            "{b:?}"
        );
        let d = suite("filling.d.globe");
        assert_eq!(of(d, "skipped"), "1");
        assert_eq!(of(&d.children[0].children[0], "type"), "time");
        // Neither side ran it.
        assert_eq!(of(&suite("filling").children[0], "name"), "c");
        assert_eq!(of(&suite("gate").children[0], "name"), "(all cases)");
    }
}
