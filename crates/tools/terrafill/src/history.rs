// SPDX-License-Identifier: MIT OR Apache-2.0
//! `history` and `compare`.

use crate::arguments::{
    BisectArguments, CompareArguments, HistoryArguments, HistoryVerb, Sides, StoreArguments,
};
use crate::gate::primary;
use crate::outcome::{Failure, Outcome, complain, print, print_json};
use crate::registry::metrics;
use std::collections::BTreeMap;
use std::path::Path;
use terrafill_gate::{Rules, shipped_limits};
use terrafill_history::{
    Added, Bisection, Change, ChangeKind, HistoryError, Overview, Record, Repository, Series,
    Store, Trends, by_device, change_line, changes, clean, comparison_csv, comparison_page,
    device_csv, device_page, export, history_page, read_tables, runs_in_words, trend_lines,
};
use terrafill_report::write_page;
use terrafill_results::{Block, MetricRow, Run, markdown};

/// Runs that `list` prints without `--json`: the newest of about a screen.
const MAX_LISTED: usize = 30;

impl From<HistoryError> for Failure {
    fn from(error: HistoryError) -> Self {
        match error {
            HistoryError::Compare(error) => error.into(),
            _ => Self::bad_input(error),
        }
    }
}

fn load(path: &Path) -> Result<Run, Failure> {
    Run::load(path).map_err(Failure::bad_input)
}

/// Writes a page; the line that says where it is.
fn page(folder: &Path, title: &str, blocks: &[Block]) -> Result<String, Failure> {
    let declared: Vec<MetricRow> = metrics().iter().map(MetricRow::from).collect();
    let path = write_page(folder, title, blocks, declared).map_err(Failure::bad_input)?;
    Ok(format!("report: {}\n", path.display()))
}

pub(crate) fn run(arguments: &HistoryArguments) -> Result<Outcome, Failure> {
    match &arguments.verb {
        HistoryVerb::Add {
            runs,
            store,
            repository,
        } => add(runs, store, repository),
        HistoryVerb::List { store, json } => list(store, *json),
        HistoryVerb::Changes {
            store,
            metric,
            json,
        } => list_changes(store, metric, *json),
        HistoryVerb::Report {
            store,
            metric,
            repository,
            out,
        } => report(store, metric, repository, out),
        HistoryVerb::Bisect(arguments) => bisect(arguments),
        HistoryVerb::Backfill(arguments) => crate::backfill::run(arguments),
        HistoryVerb::Export { store, csv } => {
            let count = export(&Store::open(&store.store)?, csv)?;
            print(format!("exported: {count} runs to {}\n", csv.display()))?;
            Ok(Outcome::Done)
        }
        HistoryVerb::Import { csv, store } => {
            let records = read_tables(csv)?;
            let added = Store::create_or_open(&store.store)?.add(&records)?;
            let known = added.iter().filter(|added| **added == Added::Known).count();
            let new = added.len() - known;
            print(format!(
                "imported: {new} runs, {known} were there already\n"
            ))?;
            Ok(Outcome::Done)
        }
    }
}

fn add(
    runs: &[std::path::PathBuf],
    store: &StoreArguments,
    repository: &Path,
) -> Result<Outcome, Failure> {
    let repository = Repository::at(repository);
    let mut records = Vec::new();
    for path in runs {
        let (record, left_out) = Record::of(&load(path)?)?;
        if left_out > 0 {
            let path = path.display();
            complain(format!(
                "{path}: {left_out} figures are no numbers and were left out"
            ));
        }
        let position = repository
            .as_ref()
            .and_then(|at| at.position(clean(&record.commit)));
        records.push((record, position));
    }
    let added = Store::create_or_open(&store.store)?.add(&records)?;
    for ((path, (record, position)), added) in runs.iter().zip(&records).zip(added) {
        let (path, commit) = (path.display(), &record.commit);
        let words = match added {
            Added::New => "stored",
            Added::Continued => "stored, and counts instead of its earlier state",
            Added::Known => "is there already, nothing was done",
        };
        let missing: Vec<(&str, &str)> = record.missing().collect();
        let cases = record.cases.len();
        let gap = match missing.len() {
            0 => String::new(),
            some => format!(", {some} of them missing"),
        };
        print(format!("{path}: {words}: {commit}, {cases} cases{gap}\n"))?;
        if position.is_none() {
            complain(format!(
                "{path}: no repository tells where {commit} stands: it is ordered by time \
                 (--repository DIR)"
            ));
        }
    }
    Ok(Outcome::Done)
}

fn list(store: &StoreArguments, json: bool) -> Result<Outcome, Failure> {
    let overview = Store::open(&store.store)?.overview()?;
    if json {
        print_json(&overview)?;
        return Ok(Outcome::Done);
    }
    let mut text = runs_in_words(&overview) + "\n";
    for (number, machine) in &overview.machines {
        text += &format!(
            "machine {number}: {}; {}\n",
            machine.label(),
            machine.options.join(" ")
        );
    }
    let hidden = overview.runs.len().saturating_sub(MAX_LISTED);
    if hidden > 0 {
        text += &format!("… {hidden} earlier runs, --json lists all\n");
    }
    for run in &overview.runs[hidden..] {
        let mark = match (run.is_superseded, run.counts()) {
            (true, _) => ", continued later",
            (_, false) => ", of edited sources: in no trend",
            _ => "",
        };
        text += &format!(
            "{}  machine {}  {} cases, {} missing, {} wrong{mark}\n",
            run.commit, run.machine, run.cases, run.missing, run.wrong
        );
    }
    print(text)?;
    Ok(Outcome::Done)
}

/// A store with all that is looked at in it.
fn read(
    store: &StoreArguments,
    metric: &[String],
) -> Result<(Store, Overview, Vec<Series>), Failure> {
    let store = Store::open(&store.store)?;
    let overview = store.overview()?;
    let series = store.series(&overview, &primary, metric)?;
    if let Some(unknown) = metric
        .iter()
        .find(|name| series.iter().all(|s| s.metric.name != **name))
    {
        return Err(Failure::bad_input(format!(
            "--metric: found {unknown:?}, allowed: a figure that a run of the store has"
        )));
    }
    Ok((store, overview, series))
}

/// Nothing to compare is no "nothing changed".
fn outcome(series: &[Series]) -> Outcome {
    if series.iter().any(|series| series.points.len() > 1) {
        return Outcome::Done;
    }
    complain("no figure was measured at two commits on one kind of machine");
    Outcome::NothingMeasured
}

fn list_changes(store: &StoreArguments, metric: &[String], json: bool) -> Result<Outcome, Failure> {
    let (store, overview, series) = read(store, metric)?;
    let (changes, absent) = (changes(&series), store.absent(&overview)?);
    if json {
        let value = serde_json::json!({
            "machines": overview.machines, "changes": changes, "absent": absent,
        });
        print_json(&value)?;
    } else {
        let trends = Trends {
            commits: &BTreeMap::new(),
            overview: &overview,
            series: &series,
            changes: &changes,
            absent: &absent,
        };
        print(trend_lines(&trends).join("\n") + "\n")?;
    }
    Ok(outcome(&series))
}

fn report(
    store: &StoreArguments,
    metric: &[String],
    repository: &Path,
    out: &Path,
) -> Result<Outcome, Failure> {
    let (store, overview, series) = read(store, metric)?;
    let (changes, absent) = (changes(&series), store.absent(&overview)?);
    let commits = Repository::at(repository).map(|at| at.facts(&overview.commits));
    let blocks = history_page(&Trends {
        commits: &commits.unwrap_or_default(),
        overview: &overview,
        series: &series,
        changes: &changes,
        absent: &absent,
    });
    print(page(out, "History", &blocks)?)?;
    Ok(outcome(&series))
}

fn bisect(arguments: &BisectArguments) -> Result<Outcome, Failure> {
    let (store, overview, series) = read(&arguments.store, &arguments.metric)?;
    let case = &arguments.case;
    let is_asked = |of: &str, machine: i64| {
        of == case && arguments.machine.is_none_or(|number| number == machine)
    };
    if !series
        .iter()
        .any(|series| is_asked(&series.case, series.machine))
    {
        return Err(Failure::bad_input(format!(
            "{case:?}: found in no run that counts; terrafill history changes lists cases"
        )));
    }
    let found = changes(&series).changes;
    let mut of_case: Vec<Change> = found
        .into_iter()
        .filter(|change| is_asked(&change.case, change.machine))
        .collect();
    // The newest that bisection can find; of one commit the one that is worse.
    let place = |commit: &str| overview.commits.iter().position(|known| known == commit);
    let is_found = |change: &Change| change.kind != ChangeKind::Drift;
    of_case.sort_by_key(|change| {
        let is_worse = change.is_better == Some(false);
        (is_found(change), place(&change.bad), is_worse)
    });
    let Some(change) = of_case.pop() else {
        print(format!(
            "{case}: no change among the commits of the store\n"
        ))?;
        return Ok(Outcome::Done);
    };
    let repository = Repository::at(&arguments.repository);
    let outcome = if is_found(&change) {
        Outcome::Done
    } else {
        Outcome::Inconclusive
    };
    let machine = overview.machines.get(&change.machine).cloned();
    let bisection = Bisection::of(change, &series, repository.as_ref())?;
    let conditions = store.conditions(case)?.unwrap_or_default();
    let lines = bisection.lines(&conditions, &machine.unwrap_or_default());
    let mut text = lines.join("\n") + "\n";
    for other in of_case.iter().rev() {
        text += &format!("also: {}\n", change_line(other));
    }
    print(text)?;
    Ok(outcome)
}

pub(crate) fn compare(arguments: &CompareArguments) -> Result<Outcome, Failure> {
    if arguments.by == Some(Sides::Device) {
        return compare_devices(arguments);
    }
    let [base, new] = arguments.runs.as_slice() else {
        let found = arguments.runs.len();
        let message = format!("found {found} runs, allowed: two, or any number with --by device");
        return Err(Failure::bad_input(message));
    };
    let (base, new) = (load(base)?, load(new)?);
    let limits = shipped_limits()?;
    let rules = Rules {
        limits: &limits,
        blessings: &[],
    };
    let compared = terrafill_history::compare(&base, &new, &rules, &primary)?;
    let (title, blocks) = ("Two runs compared", comparison_page(&compared));
    let written = arguments.html.as_deref().map(|to| page(to, title, &blocks));
    let written = written.transpose()?.unwrap_or_default();
    match (arguments.json, arguments.csv) {
        (true, _) => print_json(&compared)?,
        (_, true) => print(comparison_csv(&compared)?)?,
        _ => print(format!("## {title}\n\n{}{written}", markdown(&blocks)))?,
    }
    Ok(Outcome::from_code(compared.exact.exit_code))
}

/// No device is better or worse than another: the table decides nothing.
fn compare_devices(arguments: &CompareArguments) -> Result<Outcome, Failure> {
    let runs: Vec<Run> = arguments
        .runs
        .iter()
        .map(|path| load(path))
        .collect::<Result<_, _>>()?;
    let table = by_device(&runs, &arguments.control, &primary);
    if table.rows.is_empty() {
        complain("no run has a time");
        return Ok(Outcome::NothingMeasured);
    }
    let (title, blocks) = ("Cases by device", device_page(&table));
    let written = arguments.html.as_deref().map(|to| page(to, title, &blocks));
    let written = written.transpose()?.unwrap_or_default();
    match (arguments.json, arguments.csv) {
        (true, _) => print_json(&table)?,
        (_, true) => print(device_csv(&table)?)?,
        _ => print(format!("## {title}\n\n{}{written}", markdown(&blocks)))?,
    }
    Ok(Outcome::Done)
}
