// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is read from the tables of a store.

use crate::HistoryError;
use crate::record::{CaseRecord, Record, is_dirty};
use rusqlite::Connection;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use terrafill_results::MetricRow;

/// A run of the store, without its figures.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Entry {
    /// Number in the store.
    pub id: i64,
    /// Hash over everything in it.
    pub digest: String,
    /// Its commit.
    pub commit: String,
    /// See [`crate::Position::ordinal`]; absent where no repository knew the commit.
    pub ordinal: Option<i64>,
    /// See [`crate::Position::unix_s`].
    pub committed_unix_s: Option<i64>,
    /// Seconds since 1970 at its start.
    pub started_unix_s: i64,
    /// Number of its machine.
    pub machine: i64,
    /// Cases.
    pub cases: i64,
    /// Of these, without a result for want of time.
    pub missing: i64,
    /// Of these, wrong or broken off.
    pub wrong: i64,
    /// Whether a later state of the same run counts instead.
    pub is_superseded: bool,
    #[serde(skip)]
    pub(super) identity: String,
}

impl Entry {
    /// Whether it takes part in trends: its commit tells what was measured.
    #[must_use]
    pub fn counts(&self) -> bool {
        !self.is_superseded && !is_dirty(&self.commit)
    }
}

/// By run and study the metric that the run marks as ranking it; nothing of stores of older programs.
pub(super) fn ranks(connection: &Connection) -> rusqlite::Result<BTreeMap<(i64, String), String>> {
    let is_there: bool = connection.query_row(
        "SELECT count(*) > 0 FROM sqlite_master WHERE type = 'table' AND name = 'ranks'",
        [],
        |row| row.get(0),
    )?;
    if !is_there {
        return Ok(BTreeMap::new());
    }
    let mut statement = connection.prepare("SELECT run, study, metric FROM ranks")?;
    let rows = statement.query_map([], |row| Ok(((row.get(0)?, row.get(1)?), row.get(2)?)))?;
    rows.collect()
}

pub(super) fn declared(connection: &Connection) -> rusqlite::Result<BTreeMap<i64, MetricRow>> {
    let mut statement =
        connection.prepare("SELECT id, name, unit, kind, better, meaning FROM metrics")?;
    let mut rows = statement.query([])?;
    let mut all = BTreeMap::new();
    while let Some(row) = rows.next()? {
        let text = |column: usize| row.get::<_, String>(column).map(serde_json::Value::String);
        let metric = serde_json::json!({
            "name": text(1)?, "unit": text(2)?, "kind": text(3)?, "better": text(4)?, "meaning": text(5)?,
        });
        if let Ok(metric) = serde_json::from_value(metric) {
            all.insert(row.get(0)?, metric);
        }
    }
    Ok(all)
}

pub(super) fn names(connection: &Connection) -> rusqlite::Result<BTreeMap<i64, String>> {
    let mut statement = connection.prepare("SELECT id, name FROM cases")?;
    let rows = statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?;
    rows.collect()
}

pub(super) type CaseOutcome = (String, String, String);

pub(super) fn outcomes(connection: &Connection, run: i64) -> rusqlite::Result<Vec<CaseOutcome>> {
    let mut statement = connection.prepare(
        "SELECT cases.name, outcome, reason FROM outcomes JOIN cases ON cases.id = case_id
         WHERE run = ?1 ORDER BY cases.name",
    )?;
    let rows = statement.query_map([run], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))?;
    rows.collect()
}

pub(super) fn entries(connection: &Connection) -> rusqlite::Result<Vec<Entry>> {
    let mut statement = connection.prepare(
        "SELECT id, digest, identity, commit_id, ordinal, committed_unix_s, started_unix_s, machine,
             (SELECT count(*) FROM outcomes WHERE run = runs.id),
             (SELECT count(*) FROM outcomes WHERE run = runs.id AND outcome = 'missing'),
             (SELECT count(*) FROM outcomes WHERE run = runs.id AND outcome IN ('wrong', 'failed'))
         FROM runs ORDER BY id",
    )?;
    let rows = statement.query_map([], |row| {
        Ok(Entry {
            id: row.get(0)?,
            digest: row.get(1)?,
            identity: row.get(2)?,
            commit: row.get(3)?,
            ordinal: row.get(4)?,
            committed_unix_s: row.get(5)?,
            started_unix_s: row.get(6)?,
            machine: row.get(7)?,
            cases: row.get(8)?,
            missing: row.get(9)?,
            wrong: row.get(10)?,
            is_superseded: false,
        })
    })?;
    rows.collect()
}

pub(super) fn record(
    connection: &Connection,
    path: &Path,
    run: i64,
) -> Result<Record, HistoryError> {
    let failed = HistoryError::sql(path);
    let damaged = |error: serde_json::Error| HistoryError::Damaged {
        path: path.to_owned(),
        message: error.to_string(),
    };
    let (commit, started, shader_hash, facts): (String, i64, String, String) = connection
        .query_row(
            "SELECT commit_id, started_unix_s, shader_hash, facts FROM runs
             JOIN machines ON machines.id = machine WHERE runs.id = ?1",
            [run],
            |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?)),
        )
        .map_err(&failed)?;
    let declared = declared(connection).map_err(&failed)?;
    let mut statement = connection
        .prepare(
            "SELECT cases.name, conditions, outcome, reason, case_id FROM outcomes
             JOIN cases ON cases.id = case_id WHERE run = ?1 ORDER BY cases.name",
        )
        .map_err(&failed)?;
    let mut figures = connection
        .prepare(
            "SELECT metrics.name, process, value, metric FROM figures
             JOIN metrics ON metrics.id = metric WHERE run = ?1 AND case_id = ?2
             ORDER BY metrics.name, process",
        )
        .map_err(&failed)?;
    let mut used = BTreeSet::new();
    let mut cases = Vec::new();
    let mut rows = statement.query([run]).map_err(&failed)?;
    while let Some(row) = rows.next().map_err(&failed)? {
        let text = |column: usize| row.get::<_, String>(column).map_err(&failed);
        let case: i64 = row.get(4).map_err(&failed)?;
        let of_case = figures
            .query_map([run, case], |row| {
                used.insert(row.get::<_, i64>(3)?);
                Ok((row.get(0)?, row.get(1)?, row.get(2)?))
            })
            .map_err(&failed)?;
        cases.push(CaseRecord {
            case: text(0)?,
            conditions: serde_json::from_str(&text(1)?).map_err(damaged)?,
            outcome: text(2)?,
            reason: text(3)?,
            figures: of_case.collect::<Result<_, _>>().map_err(&failed)?,
        });
    }
    let mut metrics: Vec<MetricRow> = declared
        .into_iter()
        .filter(|(id, _)| used.contains(id))
        .map(|(_, metric)| metric)
        .collect();
    metrics.sort_by(|a, b| a.name.cmp(&b.name));
    let ranks = ranks(connection).map_err(&failed)?;
    let ranks = ranks.into_iter().filter(|((of, _), _)| *of == run);
    Ok(Record {
        ranks: ranks.map(|((_, study), metric)| (study, metric)).collect(),
        commit,
        started_unix_s: u64::try_from(started).unwrap_or(0),
        shader_hash,
        machine: serde_json::from_str(&facts).map_err(damaged)?,
        metrics,
        cases,
    })
}
