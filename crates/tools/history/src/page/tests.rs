// SPDX-License-Identifier: MIT OR Apache-2.0

use super::*;
use crate::Point;
use crate::changes;
use terrafill_results::{Direction, Kind, MetricRow, Primary};

fn series(case: &str, values: &[f64]) -> Series {
    let points = values.iter().enumerate().map(|(place, value)| Point {
        place,
        commit: format!("{place:040x}"),
        value: *value,
    });
    Series {
        machine: 1,
        case: case.to_owned(),
        metric: MetricRow {
            name: "fill_cpu_ms".to_owned(),
            unit: "ms".to_owned(),
            kind: Kind::Time,
            better: Direction::Less,
            meaning: String::new(),
            primary: Primary::No,
            scope: String::new(),
        },
        is_control: false,
        points: points.collect(),
    }
}

/// Twenty commits, the time of which goes up at the twelfth.
fn stepped(case: &str) -> Series {
    let values: Vec<f64> = (0..20)
        .map(|at| if at < 12 { 10.0 } else { 12.0 } + 0.01 * f64::from(at % 3))
        .collect();
    series(case, &values)
}

fn overview(series: &[Series]) -> Overview {
    Overview {
        machines: BTreeMap::from([(1, Machine::default())]),
        commits: series[0]
            .points
            .iter()
            .map(|point| point.commit.clone())
            .collect(),
        ..Overview::default()
    }
}

fn text(blocks: &[Block]) -> String {
    format!("{blocks:?}")
}

#[test]
fn a_change_stands_under_its_heading_with_its_course_and_its_command() {
    let all = [stepped("filling/a"), series("filling/b", &[5.0; 20])];
    let (overview, changes) = (overview(&all), changes(&all));
    let page = history_page(&Trends {
        overview: &overview,
        series: &all,
        changes: &changes,
        absent: &[],
        commits: &BTreeMap::new(),
    });
    let tables: Vec<&Table> = page
        .iter()
        .filter_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        })
        .collect();
    // Regressions, all times, runs; no improvement, nothing missing.
    let rows: Vec<usize> = tables.iter().map(|table| table.rows.len()).collect();
    assert_eq!(rows, [1, 2, 0], "values by commit are folded");
    let cells = &tables[0].rows[0].cells;
    assert_eq!(
        cells[0].command,
        "terrafill history bisect filling/a --metric fill_cpu_ms --machine 1"
    );
    assert!(
        cells[2].marker.contains("l5 9h-10z"),
        "a mark that says worse"
    );
    assert_eq!(cells[5].text, "+20.0 %");
    assert!(
        !tables[1].rows[1].cells[1].marker.contains("l5 9h-10z"),
        "negative control: no change, no mark"
    );
}

#[test]
fn the_conclusion_comes_first_and_commits_have_dates_subjects_and_links() {
    let all = [stepped("filling/a"), series("filling/b", &[5.0; 20])];
    let (overview, changes) = (overview(&all), changes(&all));
    let facts = CommitFacts {
        subject: "Draw twice".to_owned(),
        unix_s: 86_400,
        link: "https://example.org/o/n/commit/c".to_owned(),
    };
    let commits = BTreeMap::from([(overview.commits[12].clone(), facts)]);
    let trends = Trends {
        overview: &overview,
        series: &all,
        changes: &changes,
        absent: &[],
        commits: &commits,
    };
    let page = history_page(&trends);
    let [Block::Alarm(conclusion), Block::List(newest), ..] = &page[..] else {
        panic!("{page:?}");
    };
    assert!(conclusion.starts_with("Machine 1: 1 changed for the worse, 0 for the better"));
    assert!(
        newest[0].contains("10.0 ms → 12.0 ms (+20.0 %), from")
            && newest[0].ends_with("1970-01-02 Draw twice"),
        "{newest:?}"
    );
    let cell = trends.commit(&overview.commits[12]);
    assert_eq!(
        (cell.detail.as_str(), cell.link.as_str()),
        ("1970-01-02 Draw twice", "https://example.org/o/n/commit/c")
    );
    // The values of what changed, by commit, and of nothing else.
    let folded: Vec<&String> = page
        .iter()
        .filter_map(|block| match block {
            Block::Folded { summary, .. } => Some(summary),
            _ => None,
        })
        .collect();
    assert_eq!(folded, ["filling/a, fill_cpu_ms by commit"]);
    // Negative control: where nothing changed, nothing alarms, and no commit is named.
    let quiet = crate::changes(&all[1..]);
    let page = history_page(&Trends {
        changes: &quiet,
        ..trends
    });
    assert!(
        matches!(&page[..], [Block::Text(_), Block::Text(_), ..]),
        "{page:?}"
    );
}

#[test]
fn most_times_at_one_commit_are_the_machines() {
    let some = [
        stepped("filling/a"),
        stepped("filling/b"),
        series("filling/c", &[5.0; 20]),
    ];
    let said = |all: &[Series]| {
        let found = changes(all);
        let changes: Vec<&Change> = found.changes.iter().collect();
        common(&all.iter().collect::<Vec<_>>(), &changes)
    };
    assert_eq!(said(&some).len(), 1);
    assert!(
        said(&some)[0].contains("2 of 3 times changed"),
        "{:?}",
        said(&some)
    );
    // Negative controls: one alone, and few of many.
    assert!(said(&some[1..]).is_empty());
    let quiet = [
        series("filling/d", &[5.0; 20]),
        series("filling/e", &[5.0; 20]),
    ];
    assert!(said(&[&some[..], &quiet].concat()).is_empty());
}

#[test]
fn long_histories_are_cut_and_say_so() {
    let all: Vec<Series> = (0..300)
        .map(|case| stepped(&format!("filling/{case}")))
        .collect();
    let (overview, changes) = (overview(&all), changes(&all));
    assert_eq!(changes.changes.len(), 300);
    let page = history_page(&Trends {
        overview: &overview,
        series: &all,
        changes: &changes,
        absent: &[],
        commits: &BTreeMap::new(),
    });
    let words = text(&page);
    assert!(words.contains("240 more: terrafill history changes") && words.contains("180 more:"));
    // As Rust prints blocks, which is longer than the page.
    assert!(words.len() < 400_000, "{}", words.len());
}

#[test]
fn commits_are_short_and_say_that_sources_were_edited() {
    assert_eq!(short("0123456789abcdef"), "0123456789");
    assert_eq!(short("0123456789abcdef+dirty"), "0123456789+dirty");
    assert_eq!(value(2048.0, "bytes"), "2.05 kB");
    assert_eq!(value(134.0, ""), "134");
    assert_eq!(value(1.5, "ms"), "1.50 ms");
}
