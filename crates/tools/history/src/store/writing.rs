// SPDX-License-Identifier: MIT OR Apache-2.0
//! The tables of a store, and what is written into them.

use super::reading::{self, declared};
use crate::record::Record;
use crate::{HistoryError, Position};
use rusqlite::{Connection, OptionalExtension as _, Transaction, params};
use std::collections::BTreeMap;
use std::path::Path;
use terrafill_results::MetricRow;

/// Version of the store's tables.
pub const STORE_SCHEMA: i64 = 1;

/// `tfhi` in ASCII: what `file` and SQLite know the store by.
pub(super) const APPLICATION_ID: i64 = 0x7466_6869;

/// What became of a run that was added.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Added {
    /// It is stored.
    New,
    /// It is stored, and counts instead of an earlier state of the same run.
    Continued,
    /// It was there already: nothing was done.
    Known,
}

/// All of them again where a store has some already: those of older programs lack `ranks`.
const TABLES: &str = "
CREATE TABLE IF NOT EXISTS machines (id INTEGER PRIMARY KEY, facts TEXT NOT NULL UNIQUE);
CREATE TABLE IF NOT EXISTS metrics (id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, unit TEXT NOT NULL,
    kind TEXT NOT NULL, better TEXT NOT NULL, meaning TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS cases (id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, conditions TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS runs (id INTEGER PRIMARY KEY, digest TEXT NOT NULL UNIQUE, identity TEXT NOT NULL,
    commit_id TEXT NOT NULL, ordinal INTEGER, committed_unix_s INTEGER,
    started_unix_s INTEGER NOT NULL, shader_hash TEXT NOT NULL,
    machine INTEGER NOT NULL REFERENCES machines);
CREATE TABLE IF NOT EXISTS outcomes (run INTEGER NOT NULL REFERENCES runs, case_id INTEGER NOT NULL REFERENCES cases,
    outcome TEXT NOT NULL, reason TEXT NOT NULL, PRIMARY KEY (run, case_id)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS figures (run INTEGER NOT NULL REFERENCES runs, case_id INTEGER NOT NULL REFERENCES cases,
    metric INTEGER NOT NULL REFERENCES metrics, process INTEGER NOT NULL, value REAL NOT NULL,
    PRIMARY KEY (run, case_id, metric, process)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS ranks (run INTEGER NOT NULL REFERENCES runs, study TEXT NOT NULL,
    metric TEXT NOT NULL, PRIMARY KEY (run, study)) WITHOUT ROWID;
";

const TABLE_NAMES: [&str; 7] = [
    "machines", "metrics", "cases", "runs", "outcomes", "figures", "ranks",
];

pub(super) fn begin(connection: &mut Connection) -> rusqlite::Result<()> {
    let transaction = connection.transaction()?;
    make_tables(&transaction)?;
    transaction.pragma_update(None, "application_id", APPLICATION_ID)?;
    transaction.pragma_update(None, "user_version", STORE_SCHEMA)?;
    transaction.commit()
}

pub(super) fn make_tables(transaction: &Transaction<'_>) -> rusqlite::Result<()> {
    transaction.execute_batch(TABLES)?;
    for table in TABLE_NAMES {
        for what in ["UPDATE", "DELETE"] {
            transaction.execute_batch(&format!(
                "CREATE TRIGGER IF NOT EXISTS {table}_{what} BEFORE {what} ON {table}
                 BEGIN SELECT RAISE(ABORT, 'a history is appended to and never edited'); END;"
            ))?;
        }
    }
    Ok(())
}

pub(super) fn add_one(
    transaction: &Transaction<'_>,
    path: &Path,
    record: &Record,
    position: Option<Position>,
) -> Result<Added, HistoryError> {
    let failed = HistoryError::sql(path);
    let (digest, identity) = (record.digest(), record.identity());
    let known: Option<i64> = transaction
        .query_row("SELECT id FROM runs WHERE digest = ?1", [&digest], |row| {
            row.get(0)
        })
        .optional()
        .map_err(&failed)?;
    if let Some(known) = known {
        // A program that did not know of marks may have stored it.
        insert_ranks(transaction, known, record).map_err(&failed)?;
        return Ok(Added::Known);
    }
    let earlier: Option<i64> = transaction
        .query_row(
            "SELECT max(id) FROM runs WHERE identity = ?1",
            [&identity],
            |row| row.get(0),
        )
        .map_err(&failed)?;
    // Two machines of one kind may begin the same run in the same second.
    let is_continued = match earlier {
        None => false,
        Some(earlier) => record.continues(&reading::record(transaction, path, earlier)?),
    };
    let identity = match earlier {
        Some(_) if !is_continued => digest.clone(),
        _ => identity,
    };
    for metric in &record.metrics {
        check_metric(transaction, path, metric)?;
    }
    insert(transaction, record, &digest, &identity, position).map_err(&failed)?;
    Ok(if is_continued {
        Added::Continued
    } else {
        Added::New
    })
}

/// Refuses a metric that another run declares otherwise: its figures cannot stand in one series.
pub(super) fn check_metric(
    transaction: &Transaction<'_>,
    path: &Path,
    metric: &MetricRow,
) -> Result<(), HistoryError> {
    let failed = HistoryError::sql(path);
    let stored = declared(transaction).map_err(&failed)?;
    let key = |of: &MetricRow| {
        let (unit, kind, better) = (&of.unit, of.kind.name(), of.better);
        format!("{kind} in {unit}, better {better:?}").to_lowercase()
    };
    match stored.values().find(|stored| stored.name == metric.name) {
        Some(stored) if key(stored) != key(metric) => Err(HistoryError::Run {
            run: path.display().to_string(),
            message: format!(
                "metric {}: found {}, the store has {}; begin another store",
                metric.name,
                key(metric),
                key(stored)
            ),
        }),
        Some(_) => Ok(()),
        None => {
            let word = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
            let row = serde_json::to_value(metric).unwrap_or_default();
            transaction
                .execute(
                    "INSERT INTO metrics (name, unit, kind, better, meaning)
                     VALUES (?1, ?2, ?3, ?4, ?5)",
                    params![
                        metric.name,
                        metric.unit,
                        word(&row["kind"]),
                        word(&row["better"]),
                        metric.meaning
                    ],
                )
                .map_err(&failed)?;
            Ok(())
        }
    }
}

/// Number of the row with this text, which is made where there is none.
pub(super) fn number(
    transaction: &Transaction<'_>,
    table: &str,
    column: &str,
    text: &str,
) -> rusqlite::Result<i64> {
    let mut insert = transaction.prepare(&format!(
        "INSERT OR IGNORE INTO {table} ({column}) VALUES (?1)"
    ))?;
    insert.execute([text])?;
    let mut select = transaction.prepare(&format!("SELECT id FROM {table} WHERE {column} = ?1"))?;
    select.query_row([text], |row| row.get(0))
}

pub(super) fn insert(
    transaction: &Transaction<'_>,
    record: &Record,
    digest: &str,
    identity: &str,
    position: Option<Position>,
) -> rusqlite::Result<()> {
    let facts = serde_json::to_string(&record.machine).unwrap_or_default();
    let machine = number(transaction, "machines", "facts", &facts)?;
    transaction.execute(
        "INSERT INTO runs (digest, identity, commit_id, ordinal, committed_unix_s, started_unix_s,
             shader_hash, machine) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
        params![
            digest,
            identity,
            record.commit,
            position.map(|at| at.ordinal),
            position.map(|at| at.unix_s),
            i64::try_from(record.started_unix_s).unwrap_or(i64::MAX),
            record.shader_hash,
            machine
        ],
    )?;
    let run = transaction.last_insert_rowid();
    insert_ranks(transaction, run, record)?;
    let metrics: BTreeMap<String, i64> = declared(transaction)?
        .into_iter()
        .map(|(id, metric)| (metric.name, id))
        .collect();
    let mut new_case =
        transaction.prepare("INSERT OR IGNORE INTO cases (name, conditions) VALUES (?1, ?2)")?;
    let mut find_case = transaction.prepare("SELECT id FROM cases WHERE name = ?1")?;
    let mut outcome = transaction
        .prepare("INSERT INTO outcomes (run, case_id, outcome, reason) VALUES (?1, ?2, ?3, ?4)")?;
    let mut figure = transaction.prepare(
        "INSERT INTO figures (run, case_id, metric, process, value) VALUES (?1, ?2, ?3, ?4, ?5)",
    )?;
    for case in &record.cases {
        let conditions = serde_json::to_string(&case.conditions).unwrap_or_default();
        new_case.execute([&case.case, &conditions])?;
        let id: i64 = find_case.query_row([&case.case], |row| row.get(0))?;
        outcome.execute(params![run, id, case.outcome, case.reason])?;
        for (metric, process, value) in &case.figures {
            figure.execute(params![run, id, metrics.get(metric), process, value])?;
        }
    }
    Ok(())
}

pub(super) fn insert_ranks(
    transaction: &Transaction<'_>,
    run: i64,
    record: &Record,
) -> rusqlite::Result<()> {
    let mut insert = transaction
        .prepare("INSERT OR IGNORE INTO ranks (run, study, metric) VALUES (?1, ?2, ?3)")?;
    for (study, metric) in &record.ranks {
        insert.execute(params![run, study, metric])?;
    }
    Ok(())
}
