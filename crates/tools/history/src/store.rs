// SPDX-License-Identifier: MIT OR Apache-2.0
//! The file of a history: SQLite, appended to and never edited.
//!
//! Each run is one transaction, so that a full disk or a kill leaves the store as it was. Triggers refuse
//! every update and deletion. The file says what it is (`application_id`) and its schema
//! (`user_version`), and is checked whole before it is written to.

mod reading;
mod writing;

use crate::device::CONTROL;
use crate::record::{Machine, Record, clean};
use crate::series::{Point, Series};
use crate::{HistoryError, Position, Primary};
pub use reading::Entry;
pub use writing::{Added, STORE_SCHEMA};

use reading::{declared, entries, names, outcomes, ranks, record};
use rusqlite::{Connection, OpenFlags, OptionalExtension as _};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Duration;
use terrafill_results::condition::TECHNIQUE;
use terrafill_results::{MetricRow, Outcome, median};
use writing::{APPLICATION_ID, add_one, begin, make_tables};

/// How long another process that is writing is waited for.
const MAX_WAIT: Duration = Duration::from_secs(20);

/// A history on disk.
#[derive(Debug)]
pub struct Store {
    connection: Connection,
    path: PathBuf,
}

/// Runs, machines and the order of commits.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Overview {
    /// By number.
    pub machines: BTreeMap<i64, Machine>,
    /// In the order in which they were added.
    pub runs: Vec<Entry>,
    /// Commits of the runs that count, the oldest first.
    pub commits: Vec<String>,
    /// Whether ancestry gave their order; else the time of the commit, or of the run.
    pub is_by_ancestry: bool,
}

/// A case of the newest commit of a machine that gave no result, or is gone.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Absent {
    /// Number of the machine.
    pub machine: i64,
    /// [`terrafill_results::CaseId::key`].
    pub case: String,
    /// `missing`, `wrong`, `failed`, `skipped` or `gone`.
    pub outcome: String,
    /// Why.
    pub reason: String,
    /// Newest commit with a result.
    pub last: String,
}

/// Place of a run's commit, number of the run, and its values of one figure.
type ValuesOfRun = (usize, i64, Vec<f64>);

impl Store {
    /// Opens a store, or begins one where there is no file.
    ///
    /// # Errors
    /// [`HistoryError`] for another file, another schema, a damaged store, a folder that is not there.
    pub fn create_or_open(path: &Path) -> Result<Self, HistoryError> {
        let is_new = !path.exists() || std::fs::metadata(path).is_ok_and(|file| file.len() == 0);
        if !is_new {
            return Self::open(path);
        }
        let failed = HistoryError::sql(path);
        let mut connection = Connection::open(path).map_err(&failed)?;
        connection.busy_timeout(MAX_WAIT).map_err(&failed)?;
        let begun = begin(&mut connection).map_err(&failed);
        if let Err(error) = begun {
            drop(connection);
            // Of a file that was begun here and holds nothing.
            drop(std::fs::remove_file(path));
            return Err(error);
        }
        Self::open(path)
    }

    /// Opens a store that is there.
    ///
    /// # Errors
    /// As [`Store::create_or_open`]; [`HistoryError::NoStore`].
    pub fn open(path: &Path) -> Result<Self, HistoryError> {
        let owned = path.to_owned();
        if !path.exists() {
            return Err(HistoryError::NoStore { path: owned });
        }
        let failed = HistoryError::sql(path);
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection = Connection::open_with_flags(path, flags).map_err(&failed)?;
        connection.busy_timeout(MAX_WAIT).map_err(&failed)?;
        let number = |pragma: &str| {
            connection
                .pragma_query_value(None, pragma, |row| row.get::<_, i64>(0))
                .map_err(&failed)
        };
        let application = number("application_id")?;
        if application != APPLICATION_ID {
            return Err(HistoryError::NotAStore {
                path: owned,
                found: format!("a database of another program ({application:#x})"),
            });
        }
        let found = number("user_version")?;
        if found != STORE_SCHEMA {
            return Err(HistoryError::Schema {
                path: owned,
                found,
                allowed: STORE_SCHEMA,
            });
        }
        let check: String = connection
            .pragma_query_value(None, "quick_check", |row| row.get(0))
            .map_err(&failed)?;
        if check != "ok" {
            return Err(HistoryError::Damaged {
                path: owned,
                message: check,
            });
        }
        connection
            .pragma_update(None, "foreign_keys", true)
            .map_err(&failed)?;
        Ok(Self {
            connection,
            path: owned,
        })
    }

    /// Stores runs, all of them or none.
    ///
    /// - `records`: each with the place of its commit, where a repository knows it
    ///
    /// # Errors
    /// [`HistoryError`]; nothing is stored then.
    pub fn add(
        &mut self,
        records: &[(Record, Option<Position>)],
    ) -> Result<Vec<Added>, HistoryError> {
        let failed = HistoryError::sql(&self.path);
        let behaviour = rusqlite::TransactionBehavior::Immediate;
        let transaction = self
            .connection
            .transaction_with_behavior(behaviour)
            .map_err(&failed)?;
        make_tables(&transaction).map_err(&failed)?;
        let mut added = Vec::new();
        for (record, position) in records {
            added.push(add_one(&transaction, &self.path, record, *position)?);
        }
        transaction.commit().map_err(&failed)?;
        Ok(added)
    }

    /// Runs, machines and commits.
    ///
    /// # Errors
    /// [`HistoryError`] where the file cannot be read.
    pub fn overview(&self) -> Result<Overview, HistoryError> {
        let failed = HistoryError::sql(&self.path);
        let mut overview = Overview::default();
        let mut statement = self
            .connection
            .prepare("SELECT id, facts FROM machines")
            .map_err(&failed)?;
        let mut rows = statement.query([]).map_err(&failed)?;
        while let Some(row) = rows.next().map_err(&failed)? {
            let facts: String = row.get(1).map_err(&failed)?;
            let id = row.get(0).map_err(&failed)?;
            overview.machines.insert(id, self.json(&facts)?);
        }
        overview.runs = entries(&self.connection).map_err(&failed)?;
        let mut newest = BTreeSet::new();
        for run in overview.runs.iter_mut().rev() {
            run.is_superseded = !newest.insert(run.identity.clone());
        }
        (overview.commits, overview.is_by_ancestry) = in_order(&overview.runs);
        Ok(overview)
    }

    fn json<T: DeserializeOwned>(&self, text: &str) -> Result<T, HistoryError> {
        serde_json::from_str(text).map_err(|error| HistoryError::Damaged {
            path: self.path.clone(),
            message: error.to_string(),
        })
    }

    /// Every figure without noise, and the times that studies are ranked by, as series over the commits.
    ///
    /// - `primary`: what a study is ranked by on machines of whose runs none marks it
    /// - `metrics`: names of times to look at instead of the studies' own; empty for those
    ///
    /// # Errors
    /// [`HistoryError`] where the file cannot be read.
    pub fn series(
        &self,
        overview: &Overview,
        primary: Primary<'_>,
        metrics: &[String],
    ) -> Result<Vec<Series>, HistoryError> {
        let failed = HistoryError::sql(&self.path);
        let places: BTreeMap<&str, usize> = overview
            .commits
            .iter()
            .enumerate()
            .map(|(place, commit)| (commit.as_str(), place))
            .collect();
        let runs: BTreeMap<i64, (i64, usize)> = overview
            .runs
            .iter()
            .filter(|run| run.counts())
            .filter_map(|run| Some((run.id, (run.machine, *places.get(run.commit.as_str())?))))
            .collect();
        let cases = names(&self.connection).map_err(&failed)?;
        let controls = self.controls()?;
        let declared = declared(&self.connection).map_err(&failed)?;
        // The newest run of a machine decides, so that no series ends where a mark moved.
        let mut marked: BTreeMap<(i64, String), String> = BTreeMap::new();
        for ((run, study), metric) in ranks(&self.connection).map_err(&failed)? {
            if let Some((machine, _)) = runs.get(&run) {
                marked.insert((*machine, study), metric);
            }
        }
        let is_wanted = |case: &str, metric: &MetricRow, machine: i64| {
            if metric.kind.is_exact() {
                return metrics.is_empty() || metrics.contains(&metric.name);
            }
            if !metrics.is_empty() {
                return metrics.contains(&metric.name);
            }
            let study = case.split('/').next().unwrap_or_default();
            let by_mark = marked.get(&(machine, study.to_owned())).map(String::as_str);
            let clock = || overview.machines.get(&machine).map(Machine::clock);
            by_mark.or_else(|| primary(study, clock()?)) == Some(metric.name.as_str())
        };
        // Values of a run at a place, by machine, case and metric.
        let mut values: BTreeMap<(i64, i64, i64), Vec<ValuesOfRun>> = BTreeMap::new();
        let mut statement = self
            .connection
            .prepare(
                "SELECT run, case_id, metric, value FROM figures ORDER BY run, case_id, metric",
            )
            .map_err(&failed)?;
        let mut rows = statement.query([]).map_err(&failed)?;
        while let Some(row) = rows.next().map_err(&failed)? {
            let get = |column: usize| row.get::<_, i64>(column).map_err(&failed);
            let (run, case, metric) = (get(0)?, get(1)?, get(2)?);
            let value: f64 = row.get(3).map_err(&failed)?;
            let Some(&(machine, place)) = runs.get(&run) else {
                continue;
            };
            let of_series = values.entry((machine, case, metric)).or_default();
            match of_series.last_mut() {
                Some((_, last, all)) if *last == run => all.push(value),
                _ => of_series.push((place, run, vec![value])),
            }
        }
        let mut all = Vec::new();
        for ((machine, case, metric), of_runs) in values {
            let (Some(case), Some(metric)) = (cases.get(&case), declared.get(&metric)) else {
                continue;
            };
            if is_wanted(case, metric, machine) {
                all.push(Series {
                    machine,
                    case: case.clone(),
                    is_control: controls.contains(case),
                    points: points(metric, of_runs, &overview.commits),
                    metric: metric.clone(),
                });
            }
        }
        all.sort_by(|a, b| {
            (a.machine, &a.case, &a.metric.name).cmp(&(b.machine, &b.case, &b.metric.name))
        });
        Ok(all)
    }

    /// Cases of the pass that no technique has a part in.
    fn controls(&self) -> Result<BTreeSet<String>, HistoryError> {
        let failed = HistoryError::sql(&self.path);
        let mut statement = self
            .connection
            .prepare("SELECT name, conditions FROM cases")
            .map_err(&failed)?;
        let mut rows = statement.query([]).map_err(&failed)?;
        let mut found = BTreeSet::new();
        while let Some(row) = rows.next().map_err(&failed)? {
            let text: String = row.get(1).map_err(&failed)?;
            let conditions: BTreeMap<String, String> = self.json(&text)?;
            if conditions
                .get(TECHNIQUE.name())
                .is_some_and(|of| of == CONTROL)
            {
                found.insert(row.get(0).map_err(&failed)?);
            }
        }
        Ok(found)
    }

    /// Cases of each machine that had a result once, and have none at its newest commit.
    ///
    /// # Errors
    /// [`HistoryError`] where the file cannot be read.
    pub fn absent(&self, overview: &Overview) -> Result<Vec<Absent>, HistoryError> {
        let failed = HistoryError::sql(&self.path);
        let place = |commit: &str| overview.commits.iter().position(|known| known == commit);
        let mut found = Vec::new();
        for machine in overview.machines.keys() {
            let of_machine = overview
                .runs
                .iter()
                .filter(|r| r.machine == *machine && r.counts());
            let mut runs: Vec<&Entry> = of_machine.collect();
            runs.sort_by_key(|run| place(&run.commit));
            let Some(newest) = runs.last().map(|run| run.commit.clone()) else {
                continue;
            };
            let mut last_good: BTreeMap<String, &str> = BTreeMap::new();
            let mut now: BTreeMap<String, (String, String)> = BTreeMap::new();
            for run in &runs {
                for (case, outcome, reason) in
                    outcomes(&self.connection, run.id).map_err(&failed)?
                {
                    let is_ok = outcome == Outcome::Ok.name();
                    if is_ok {
                        last_good.insert(case.clone(), &run.commit);
                    }
                    if run.commit == newest && (is_ok || !now.contains_key(&case)) {
                        now.insert(case, (outcome, reason));
                    }
                }
            }
            for (case, last) in last_good {
                let (outcome, reason) = match now.get(&case) {
                    Some((outcome, _)) if outcome == Outcome::Ok.name() => continue,
                    Some(now) => now.clone(),
                    None => ("gone".to_owned(), "not planned any more".to_owned()),
                };
                found.push(Absent {
                    machine: *machine,
                    case,
                    outcome,
                    reason,
                    last: last.to_owned(),
                });
            }
        }
        Ok(found)
    }

    /// Conditions of a case; `None` where no run has it.
    ///
    /// # Errors
    /// [`HistoryError`] where the file cannot be read.
    pub fn conditions(&self, case: &str) -> Result<Option<BTreeMap<String, String>>, HistoryError> {
        let failed = HistoryError::sql(&self.path);
        let found: Option<String> = self
            .connection
            .query_row(
                "SELECT conditions FROM cases WHERE name = ?1",
                [case],
                |row| row.get(0),
            )
            .optional()
            .map_err(&failed)?;
        found.map(|text| self.json(&text)).transpose()
    }

    /// A run with everything, and the place of its commit.
    ///
    /// # Errors
    /// [`HistoryError`] where the file cannot be read.
    pub fn record(&self, run: &Entry) -> Result<(Record, Option<Position>), HistoryError> {
        let record = record(&self.connection, &self.path, run.id)?;
        let position = run.ordinal.zip(run.committed_unix_s);
        Ok((
            record,
            position.map(|(ordinal, unix_s)| Position { ordinal, unix_s }),
        ))
    }
}

/// Commits of the runs that count, the oldest first: by ancestry where every one has a place there, else
/// by the time of the commit, and of the run where that is not known.
fn in_order(runs: &[Entry]) -> (Vec<String>, bool) {
    let runs: Vec<&Entry> = runs.iter().filter(|run| run.counts()).collect();
    let is_by_ancestry = !runs.is_empty() && runs.iter().all(|run| run.ordinal.is_some());
    let mut commits: BTreeMap<&str, (i64, i64)> = BTreeMap::new();
    for run in runs {
        let time = run.committed_unix_s.unwrap_or(run.started_unix_s);
        let key = match run.ordinal.filter(|_| is_by_ancestry) {
            Some(ordinal) => (ordinal, time),
            None => (time, 0),
        };
        let known = commits.entry(clean(&run.commit)).or_insert(key);
        *known = key.min(*known);
    }
    let mut ordered: Vec<(&str, (i64, i64))> = commits.into_iter().collect();
    ordered.sort_by_key(|(_, key)| *key);
    let ordered = ordered.into_iter().map(|(commit, _)| commit.to_owned());
    (ordered.collect(), is_by_ancestry)
}

/// One point a commit: the median over its runs of a time; of an exact figure what the last run found.
fn points(metric: &MetricRow, of_runs: Vec<ValuesOfRun>, commits: &[String]) -> Vec<Point> {
    let mut by_place: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for (place, _, values) in of_runs {
        let all = by_place.entry(place).or_default();
        if metric.kind.is_exact() {
            all.clear();
        }
        all.extend(median(&values));
    }
    by_place
        .into_iter()
        .filter_map(|(place, values)| {
            Some(Point {
                place,
                commit: commits.get(place)?.clone(),
                value: median(&values)?,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests;
