// SPDX-License-Identifier: MIT OR Apache-2.0
//! Comparisons and histories as blocks of a page; `report` says how they look.

mod comparison;

pub use comparison::{comparison_page, device_page};

use crate::record::{Machine, clean};
use crate::store::{Absent, Overview};
use crate::threshold::{COMMON_SHARE, FALSE_DISCOVERY_RATE, FLOOR_PERCENT};
use crate::{Change, ChangeKind, Changes, CommitFacts, Series};
use std::cmp::Ordering;
use std::collections::BTreeMap;
use terrafill_plot::Sparkline;
use terrafill_plot::number::{bytes, significant, utc};
use terrafill_results::{Block, Cell, CellClass, Heading, Row, Table};

/// Rows of a table: with its sparkline a row takes up to 1 kB, and a page at most 300.
const MAX_ROWS: usize = 60;

/// Rows of the table of all cases.
const MAX_CASES: usize = 120;

/// Changes for the worse that the conclusion names.
const MAX_CONCLUSIONS: usize = 5;

/// Changed cases whose values are listed by commit, and newest commits of each: a page stays below 300 kB.
const MAX_LISTED: (usize, usize) = (8, 20);

/// Newest points of a sparkline: two pixels each.
const MAX_DRAWN: usize = 100;

/// Digits of a commit that tell it from others.
const SHORT: usize = 10;

fn short(commit: &str) -> String {
    let hash: String = clean(commit).chars().take(SHORT).collect();
    if commit.len() > clean(commit).len() {
        hash + "+dirty"
    } else {
        hash
    }
}

fn value(value: f64, unit: &str) -> String {
    match unit {
        "bytes" if value >= 0.0 => {
            #[allow(
                clippy::cast_possible_truncation,
                reason = "bytes are whole and not negative"
            )]
            let whole = value as u64;
            bytes(whole)
        }
        "" if value.fract().abs() < f64::EPSILON => format!("{value}"),
        "" => significant(value),
        unit => format!("{} {unit}", significant(value)),
    }
}

fn table(caption: &str, headings: &[(&str, &str)], rows: Vec<Row>) -> Block {
    let heading = |(text, meaning): &(&str, &str)| Heading::explained(*text, *meaning);
    Block::Table(Table {
        caption: caption.to_owned(),
        headings: headings.iter().map(heading).collect(),
        rows,
        ..Table::default()
    })
}

/// The first rows, and a remark on how many more there are.
fn first_rows(
    blocks: &mut Vec<Block>,
    caption: &str,
    headings: &[(&str, &str)],
    rows: impl ExactSizeIterator<Item = Row>,
    (limit, where_else): (usize, &str),
) {
    let more = rows.len().saturating_sub(limit);
    blocks.push(table(caption, headings, rows.take(limit).collect()));
    if more > 0 {
        blocks.push(Block::Remark(format!("{more} more: {where_else}.")));
    }
}

/// What a history has, found in a store.
#[derive(Debug, Clone, Copy)]
pub struct Trends<'a> {
    /// Runs, machines and commits.
    pub overview: &'a Overview,
    /// Every series.
    pub series: &'a [Series],
    /// Changes among them.
    pub changes: &'a Changes,
    /// Cases that no longer give a result.
    pub absent: &'a [Absent],
    /// What is known of commits.
    pub commits: &'a BTreeMap<String, CommitFacts>,
}

impl Trends<'_> {
    /// Date of a commit; empty where it is not known.
    fn date(&self, commit: &str) -> String {
        let known = self.commits.get(commit).map(|facts| facts.unix_s);
        let of_run = || {
            let mut runs = self.overview.runs.iter();
            let run = runs.find(|run| clean(&run.commit) == commit)?;
            u64::try_from(run.committed_unix_s?).ok()
        };
        let time = known.or_else(of_run).map(utc).unwrap_or_default();
        time.split(' ').next().unwrap_or_default().to_owned()
    }

    /// A commit with its date and subject, linked to its page.
    fn commit(&self, commit: &str) -> Cell {
        let facts = self.commits.get(clean(commit)).cloned().unwrap_or_default();
        Cell {
            detail: format!("{} {}", self.date(clean(commit)), facts.subject)
                .trim()
                .to_owned(),
            link: facts.link,
            ..Cell::plain(short(commit))
        }
    }
}

/// A history as a page: for each machine regressions, improvements, what is missing, and every case
/// with the course of its time.
#[must_use]
pub fn history_page(of: &Trends<'_>) -> Vec<Block> {
    let mut blocks = Vec::new();
    for number in of.overview.machines.keys() {
        conclusion(&mut blocks, of, *number);
    }
    blocks.push(Block::Text(format!(
        "{}. {}.",
        runs_in_words(of.overview),
        followed_in_words(of.changes)
    )));
    blocks.push(Block::Remark(format!(
        "A time's change is named from {FLOOR_PERCENT} % on; of those named, up to {:.0} % are expected to be \
         false. Times of different jobs are not paired, so all of this is advice; terrafill gate \
         decides.",
        100.0 * FALSE_DISCOVERY_RATE
    )));
    if !of.overview.is_by_ancestry && of.overview.commits.len() > 1 {
        blocks.push(Block::Remark(
            "Commits are in the order of their times, since not every one's ancestry is known."
                .to_owned(),
        ));
    }
    for (number, machine) in &of.overview.machines {
        machine_blocks(&mut blocks, of, *number, machine);
    }
    runs_table(&mut blocks, of);
    blocks
}

/// What a machine's history comes to, and its newest changes for the worse.
fn conclusion(blocks: &mut Vec<Block>, of: &Trends<'_>, number: i64) {
    let changes = of.changes.changes.iter().filter(|c| c.machine == number);
    let changes: Vec<&Change> = changes.collect();
    let count = |is_better: bool| {
        let some = changes.iter().filter(|c| c.is_better == Some(is_better));
        some.count()
    };
    let (worse, better) = (count(false), count(true));
    let missing = of.absent.iter().filter(|a| a.machine == number).count();
    let undecided = of.changes.undecided.iter().filter(|u| u.machine == number);
    let sentence = format!(
        "Machine {number}: {worse} changed for the worse, {better} for the better, {missing} without a result \
         at the newest commit, {} cannot be decided.",
        undecided.count()
    );
    blocks.push(match (worse, missing) {
        (0, 0) => Block::Text(sentence),
        _ => Block::Alarm(sentence),
    });
    let mut bad: Vec<&&Change> = changes
        .iter()
        .filter(|c| c.is_better == Some(false))
        .collect();
    let place = |change: &Change| of.overview.commits.iter().position(|c| *c == change.bad);
    let size = |change: &Change| change.percent().map_or(f64::INFINITY, f64::abs);
    bad.sort_by(|a, b| {
        (place(b), size(b))
            .partial_cmp(&(place(a), size(a)))
            .unwrap_or(Ordering::Equal)
    });
    let lines = bad.iter().take(MAX_CONCLUSIONS).map(|change| {
        let subject = of
            .commits
            .get(&change.bad)
            .map_or("", |facts| facts.subject.as_str());
        let size = change
            .percent()
            .map_or(String::new(), |p| format!(" ({p:+.1} %)"));
        let at = format!("{} {} {subject}", short(&change.bad), of.date(&change.bad));
        format!(
            "{}, {}: {} → {}{size}, {} {}",
            change.case,
            change.metric,
            value(change.from, &change.unit),
            value(change.to, &change.unit),
            match change.kind {
                ChangeKind::Drift => "little by little up to",
                ChangeKind::Exact | ChangeKind::Step => "from",
            },
            at.trim_end()
        )
    });
    let lines: Vec<String> = lines.collect();
    blocks.extend((!lines.is_empty()).then_some(Block::List(lines)));
}

/// How many runs, commits and machines there are.
#[must_use]
pub fn runs_in_words(of: &Overview) -> String {
    let left_out = of.runs.iter().filter(|run| !run.counts()).count();
    let left_out = match left_out {
        0 => String::new(),
        some => format!(" ({some} of edited sources or continued later, left out)"),
    };
    let machines = match of.machines.len() {
        1 => "1 kind of machine".to_owned(),
        some => format!("{some} kinds of machines"),
    };
    format!(
        "{}{left_out} of {} on {machines}",
        plural(of.runs.len(), "run"),
        plural(of.commits.len(), "commit")
    )
}

/// `1 run`, `2 runs`.
pub(crate) fn plural(count: usize, noun: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

fn machine_blocks(blocks: &mut Vec<Block>, of: &Trends<'_>, number: i64, machine: &Machine) {
    blocks.push(Block::section(format!("Machine {number}: {}", machine.gpu)));
    let options = machine.options.join(" ");
    blocks.push(Block::Text(format!("{}; {options}", machine.label())));
    let series: Vec<&Series> = of.series.iter().filter(|s| s.machine == number).collect();
    let changes: Vec<&Change> = of
        .changes
        .changes
        .iter()
        .filter(|c| c.machine == number)
        .collect();
    blocks.extend(common(&series, &changes).into_iter().map(Block::Alarm));
    for (title, is_better) in [
        ("Regressions", Some(false)),
        ("Improvements", Some(true)),
        ("Other changes", None),
    ] {
        let mut some: Vec<&&Change> = changes
            .iter()
            .filter(|c| c.is_better == is_better)
            .collect();
        if some.is_empty() && is_better.is_none() {
            continue;
        }
        blocks.push(Block::part(title));
        if some.is_empty() {
            blocks.push(Block::Text("None.".to_owned()));
            continue;
        }
        // The newest first: those are what a reader can still do something about.
        let place = |change: &Change| of.overview.commits.iter().position(|c| *c == change.bad);
        some.sort_by_key(|change| std::cmp::Reverse(place(change)));
        let rows = some
            .iter()
            .map(|change| change_row(of, change, &series, &changes));
        let headings = [
            ("case", ""),
            ("figure", ""),
            (
                "course",
                "from the oldest commit to the newest; ▲ worse, ▼ better, ◆ neither",
            ),
            ("before", "of a step the median of its side"),
            ("after", ""),
            ("change", ""),
            (
                "how",
                "exact: a figure without noise; step: from one commit on; drift: little by little",
            ),
            ("first commit", "of a drift the newest one"),
        ];
        let more = "terrafill history changes --json lists all";
        first_rows(blocks, "", &headings, rows, (MAX_ROWS, more));
    }
    let absent: Vec<&Absent> = of.absent.iter().filter(|a| a.machine == number).collect();
    blocks.push(Block::part("Missing at the newest commit"));
    if absent.is_empty() {
        blocks.push(Block::Text("None.".to_owned()));
    } else {
        let rows = absent.iter().map(|absent| {
            Row::new(vec![
                Cell::name(&absent.case),
                Cell::plain(&absent.outcome),
                Cell::name(&absent.reason),
                of.commit(&absent.last),
            ])
        });
        let headings = [
            ("case", ""),
            ("ended", ""),
            ("why", ""),
            ("last result", ""),
        ];
        let more = "terrafill history changes --json lists all";
        first_rows(blocks, "", &headings, rows, (MAX_ROWS, more));
    }
    values_by_commit(blocks, of, &series, &changes);
    undecided_list(blocks, of, number);
    cases_table(blocks, of, &series, &changes);
}

/// The values of changed cases, the newest commit first.
fn values_by_commit(
    blocks: &mut Vec<Block>,
    of: &Trends<'_>,
    series: &[&Series],
    changes: &[&Change],
) {
    let is_changed = |series: &&&Series| {
        let mut changes = changes.iter();
        changes.any(|c| (&c.case, &c.metric) == (&series.case, &series.metric.name))
    };
    let (max_series, max_commits) = MAX_LISTED;
    for series in series.iter().filter(is_changed).take(max_series) {
        let rows = series.points.iter().rev().take(max_commits).map(|point| {
            Row::new(vec![
                of.commit(&point.commit),
                Cell::plain(value(point.value, &series.metric.unit)),
            ])
        });
        let headings = [
            ("commit", ""),
            (series.metric.name.as_str(), "median over its runs"),
        ];
        blocks.push(Block::Folded {
            summary: format!("{}, {} by commit", series.case, series.metric.name),
            is_open: false,
            blocks: vec![table("", &headings, rows.collect())],
        });
    }
}

fn undecided_list(blocks: &mut Vec<Block>, of: &Trends<'_>, number: i64) {
    let undecided = of.changes.undecided.iter().filter(|u| u.machine == number);
    let undecided: Vec<String> = undecided
        .map(|u| format!("{}, {}: {}", u.case, u.metric, u.reason))
        .collect();
    let summary = format!("{} that cannot be decided", plural(undecided.len(), "time"));
    let shown = undecided.into_iter().take(MAX_CASES).collect();
    blocks.extend(Block::folded_list(summary, shown));
}

/// Commits at which most times of a machine changed together.
#[must_use]
pub(crate) fn common(series: &[&Series], changes: &[&Change]) -> Vec<String> {
    let times = series
        .iter()
        .filter(|series| !series.metric.kind.is_exact())
        .count();
    let mut by_commit: BTreeMap<&str, usize> = BTreeMap::new();
    for change in changes
        .iter()
        .filter(|change| change.kind == ChangeKind::Step)
    {
        *by_commit.entry(change.bad.as_str()).or_default() += 1;
    }
    let is_common =
        |(_, count): &(&str, usize)| *count > 1 && *count as f64 >= COMMON_SHARE * times as f64;
    let common = by_commit.into_iter().filter(is_common);
    common
        .map(|(commit, count)| {
            format!(
                "{count} of {times} times changed at {}: rather the machine than the code.",
                short(commit)
            )
        })
        .collect()
}

fn spark(series: &Series, changes: &[&Change]) -> Cell {
    let skipped = series.points.len().saturating_sub(MAX_DRAWN);
    let values: Vec<f64> = series.points[skipped..]
        .iter()
        .map(|point| point.value)
        .collect();
    let of_series = changes.iter().filter(|change| {
        (&change.case, &change.metric) == (&series.case, &series.metric.name)
            && change.kind != ChangeKind::Drift
    });
    let marks: Vec<(usize, Option<bool>)> = of_series
        .filter_map(|change| {
            let at = series
                .points
                .iter()
                .position(|point| point.commit == change.bad)?;
            Some((at.checked_sub(skipped)?, change.is_better))
        })
        .collect();
    let title = match (values.first(), values.last()) {
        (Some(first), Some(last)) => format!(
            "{} commits, from {} to {}",
            values.len(),
            value(*first, &series.metric.unit),
            value(*last, &series.metric.unit)
        ),
        _ => "no value".to_owned(),
    };
    let drawing = Sparkline {
        title: &title,
        values: &values,
        marks: &marks,
    };
    Cell {
        marker: drawing.svg(),
        title,
        ..Cell::plain("")
    }
}

fn change_row(of: &Trends<'_>, change: &Change, series: &[&Series], changes: &[&Change]) -> Row {
    let of_change = series
        .iter()
        .find(|series| (&series.case, &series.metric.name) == (&change.case, &change.metric));
    let percent = change.percent();
    let size = percent.map_or_else(
        || format!("{:+}", change.to - change.from),
        |p| format!("{p:+.1} %"),
    );
    let mut size = Cell::plain(size);
    size.class = match change.is_better {
        Some(true) => CellClass::Good,
        Some(false) => CellClass::Bad,
        None => CellClass::Plain,
    };
    let how = match (change.kind, change.probability) {
        (ChangeKind::Exact, _) | (_, None) => "exact".to_owned(),
        (ChangeKind::Step, Some(p)) => format!("step, p {}", significant(p)),
        (ChangeKind::Drift, Some(p)) => format!("drift, p {}", significant(p)),
    };
    let mut case = Cell::name(&change.case);
    case.command = format!(
        "terrafill history bisect {} --metric {} --machine {}",
        change.case, change.metric, change.machine
    );
    Row::new(vec![
        case,
        Cell::plain(&change.metric),
        of_change.map_or_else(
            || Cell::absent("no series"),
            |series| spark(series, changes),
        ),
        Cell::plain(value(change.from, &change.unit)),
        Cell::plain(value(change.to, &change.unit)),
        size,
        Cell::plain(how),
        of.commit(&change.bad),
    ])
}

/// Every case with its time over the commits.
fn cases_table(blocks: &mut Vec<Block>, of: &Trends<'_>, series: &[&Series], changes: &[&Change]) {
    blocks.push(Block::part("All times"));
    let times: Vec<&&Series> = series
        .iter()
        .filter(|s| !s.metric.kind.is_exact())
        .collect();
    if times.is_empty() {
        blocks.push(Block::Text("None.".to_owned()));
        return;
    }
    let rows = times.iter().map(|series| {
        let newest = series.points.last();
        Row::new(vec![
            Cell::name(&series.case),
            spark(series, changes),
            Cell::or_absent(
                newest.map(|p| value(p.value, &series.metric.unit)),
                "no value",
            ),
            newest.map_or_else(|| Cell::absent("no value"), |p| of.commit(&p.commit)),
            Cell::plain(series.points.len().to_string()),
        ])
    });
    let headings = [
        ("case", ""),
        (
            "course",
            "from the oldest commit to the newest; ▲ worse, ▼ better",
        ),
        ("newest", "median over the runs of the newest commit"),
        ("at", "newest commit with a value"),
        ("commits", ""),
    ];
    let more = "terrafill history export --csv has all";
    first_rows(blocks, "", &headings, rows, (MAX_CASES, more));
}

fn runs_table(blocks: &mut Vec<Block>, of: &Trends<'_>) {
    blocks.push(Block::section("Runs"));
    let rows = of.overview.runs.iter().rev().map(|run| {
        let mut commit = of.commit(&run.commit);
        if !run.counts() {
            commit.class = CellClass::Void;
            commit.title = if run.is_superseded {
                "continued later: the later state counts".to_owned()
            } else {
                "of edited sources: its commit does not tell what was measured".to_owned()
            };
        }
        let started = u64::try_from(run.started_unix_s)
            .map(utc)
            .unwrap_or_default();
        Row::new(vec![
            Cell::name(started),
            commit,
            Cell::plain(run.machine.to_string()),
            Cell::plain(run.cases.to_string()),
            Cell::plain(run.missing.to_string()),
            Cell::plain(run.wrong.to_string()),
        ])
    });
    let headings = [
        ("started", ""),
        ("commit", ""),
        ("machine", ""),
        ("cases", ""),
        ("missing", "planned, and not reached"),
        ("wrong", "wrong or broken off"),
    ];
    let more = "terrafill history list lists all";
    first_rows(blocks, "", &headings, rows, (MAX_ROWS, more));
}

/// How many figures were followed, and what was to be found in them.
pub(crate) fn followed_in_words(found: &Changes) -> String {
    let finds = found.finds_percent.map_or(String::new(), |percent| {
        let percent = significant(percent);
        format!(
            ", half of which would show a lone step of {percent} % between halves of their commits"
        )
    });
    let relative = match found.relative {
        0 => String::new(),
        some => format!("; {some} are relative to the control passes of the same runs"),
    };
    let rate = 100.0 * FALSE_DISCOVERY_RATE;
    format!(
        "{} figures without noise and {} times over the commits{finds}{relative}; {} times cannot be \
         decided; of the changes of times up to {rate:.0} % may be false",
        found.exact,
        found.times,
        found.undecided.len()
    )
}

#[cfg(test)]
mod tests;
