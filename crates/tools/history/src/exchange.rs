// SPDX-License-Identifier: MIT OR Apache-2.0
//! A history as CSV tables, for people's own tools and for joining stores.
//!
//! `runs.csv`, `cases.csv`, `figures.csv`, `metrics.csv` and `ranks.csv` hold everything that the store has. A run's
//! digest is over all but the last, so that a table with an edited or a missing row is noticed. Tables of older
//! programs lack `ranks.csv`.

use crate::record::{CaseRecord, Machine, Record};
use crate::{HistoryError, Position, Store};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use terrafill_results::{METRIC_COLUMNS, MetricRow, OLD_METRIC_COLUMNS};

const RUNS: (&str, &[&str]) = (
    "runs.csv",
    &[
        "digest",
        "commit",
        "ordinal",
        "committed_unix_s",
        "started_unix_s",
        "shader_hash",
        "machine",
    ],
);
const CASES: (&str, &[&str]) = (
    "cases.csv",
    &["digest", "case", "outcome", "reason", "conditions"],
);
const FIGURES: (&str, &[&str]) = (
    "figures.csv",
    &["digest", "case", "metric", "process", "value"],
);
const METRICS: (&str, &[&str]) = ("metrics.csv", METRIC_COLUMNS.split_at(OLD_METRIC_COLUMNS).0);
const RANKS: (&str, &[&str]) = ("ranks.csv", &["digest", "study", "metric"]);

#[derive(Serialize, Deserialize)]
struct RunRow {
    digest: String,
    commit: String,
    ordinal: Option<i64>,
    committed_unix_s: Option<i64>,
    started_unix_s: u64,
    shader_hash: String,
    /// JSON.
    machine: String,
}

#[derive(Serialize, Deserialize)]
struct CaseRow {
    digest: String,
    case: String,
    outcome: String,
    reason: String,
    /// JSON.
    conditions: String,
}

#[derive(Serialize, Deserialize)]
struct FigureRow {
    digest: String,
    case: String,
    metric: String,
    process: u32,
    value: f64,
}

/// By which metric a run ranks a study.
#[derive(Serialize, Deserialize)]
struct RankRow {
    digest: String,
    study: String,
    metric: String,
}

/// Writes the tables of a store into `folder`, which is made where there is none.
///
/// # Errors
/// [`HistoryError::Io`] for a folder that holds tables already, or that cannot be written.
pub fn export(store: &Store, folder: &Path) -> Result<usize, HistoryError> {
    let (mut runs, mut cases, mut figures) = (Vec::new(), Vec::new(), Vec::new());
    let mut ranks = Vec::new();
    let mut metrics: BTreeMap<String, MetricRow> = BTreeMap::new();
    let overview = store.overview()?;
    for entry in &overview.runs {
        let (record, position) = store.record(entry)?;
        let digest = record.digest();
        runs.push(RunRow {
            digest: digest.clone(),
            commit: record.commit,
            ordinal: position.map(|at| at.ordinal),
            committed_unix_s: position.map(|at| at.unix_s),
            started_unix_s: record.started_unix_s,
            shader_hash: record.shader_hash,
            machine: json(&record.machine),
        });
        ranks.extend(record.ranks.into_iter().map(|(study, metric)| RankRow {
            digest: digest.clone(),
            study,
            metric,
        }));
        metrics.extend(record.metrics.into_iter().map(|m| (m.name.clone(), m)));
        for case in record.cases {
            let of_case = case
                .figures
                .into_iter()
                .map(|(metric, process, value)| FigureRow {
                    digest: digest.clone(),
                    case: case.case.clone(),
                    metric,
                    process,
                    value,
                });
            figures.extend(of_case);
            cases.push(CaseRow {
                digest: digest.clone(),
                conditions: json(&case.conditions),
                case: case.case,
                outcome: case.outcome,
                reason: case.reason,
            });
        }
    }
    std::fs::create_dir_all(folder).map_err(HistoryError::io(folder))?;
    for (name, _) in [RUNS, CASES, FIGURES, METRICS, RANKS] {
        let path = folder.join(name);
        if path.exists() {
            let message = "it is there already, allowed: a folder without tables";
            return Err(HistoryError::io(&path)(std::io::Error::other(message)));
        }
    }
    write(folder, METRICS, &metrics.into_values().collect::<Vec<_>>())?;
    write(folder, RANKS, &ranks)?;
    write(folder, FIGURES, &figures)?;
    write(folder, CASES, &cases)?;
    // Last: where it is, the others are.
    write(folder, RUNS, &runs)?;
    Ok(runs.len())
}

/// Reads the runs of exported tables.
///
/// # Errors
/// [`HistoryError::Row`] for what does not fit; [`HistoryError::Run`] for a run whose rows are not those
/// that were exported.
pub fn read_tables(folder: &Path) -> Result<Vec<(Record, Option<Position>)>, HistoryError> {
    let metrics: Vec<MetricRow> = read(folder, METRICS)?;
    let mut records: Vec<(String, Record, Option<Position>)> = Vec::new();
    let mut place: BTreeMap<String, usize> = BTreeMap::new();
    for (row, run) in (2..).zip(read::<RunRow>(folder, RUNS)?) {
        let machine: Machine = parse(folder, RUNS.0, row, &run.machine)?;
        let position = run.ordinal.zip(run.committed_unix_s);
        place.insert(run.digest.clone(), records.len());
        let record = Record {
            commit: run.commit,
            started_unix_s: run.started_unix_s,
            shader_hash: run.shader_hash,
            machine,
            metrics: Vec::new(),
            cases: Vec::new(),
            ranks: BTreeMap::new(),
        };
        let position = position.map(|(ordinal, unix_s)| Position { ordinal, unix_s });
        records.push((run.digest, record, position));
    }
    let unknown = |file: &str, row: usize, found: &str| HistoryError::Row {
        path: folder.join(file),
        row,
        message: format!("found {found:?}, expected one of the tables beside it"),
    };
    for (row, case) in (2..).zip(read::<CaseRow>(folder, CASES)?) {
        let conditions = parse(folder, CASES.0, row, &case.conditions)?;
        let at = place.get(&case.digest);
        let at = *at.ok_or_else(|| unknown(CASES.0, row, &case.digest))?;
        records[at].1.cases.push(CaseRecord {
            case: case.case,
            conditions,
            outcome: case.outcome,
            reason: case.reason,
            figures: Vec::new(),
        });
    }
    for (_, record, _) in &mut records {
        record.cases.sort_by(|a, b| a.case.cmp(&b.case));
    }
    for (row, figure) in (2..).zip(read::<FigureRow>(folder, FIGURES)?) {
        let at = place.get(&figure.digest);
        let at = *at.ok_or_else(|| unknown(FIGURES.0, row, &figure.digest))?;
        let record = &mut records[at].1;
        let declared = metrics.iter().find(|metric| metric.name == figure.metric);
        let declared = declared.ok_or_else(|| unknown(FIGURES.0, row, &figure.metric))?;
        if !record.metrics.contains(declared) {
            record.metrics.push(declared.clone());
        }
        let case = record
            .cases
            .binary_search_by(|case| case.case.cmp(&figure.case));
        let case = case.map_err(|_| unknown(FIGURES.0, row, &figure.case))?;
        let value = (figure.metric, figure.process, figure.value);
        record.cases[case].figures.push(value);
    }
    if folder.join(RANKS.0).exists() {
        for (row, rank) in (2..).zip(read::<RankRow>(folder, RANKS)?) {
            let at = place.get(&rank.digest);
            let at = *at.ok_or_else(|| unknown(RANKS.0, row, &rank.digest))?;
            records[at].1.ranks.insert(rank.study, rank.metric);
        }
    }
    let mut checked = Vec::new();
    for (digest, mut record, position) in records {
        record.metrics.sort_by(|a, b| a.name.cmp(&b.name));
        for case in &mut record.cases {
            case.figures.sort_by(|a, b| (&a.0, a.1).cmp(&(&b.0, b.1)));
        }
        let found = record.digest();
        if found != digest {
            return Err(HistoryError::Run {
                run: format!("{}: run {digest}", folder.display()),
                message: format!(
                    "its rows have the digest {found}: some were edited or are missing"
                ),
            });
        }
        record.check_commit(&digest)?;
        checked.push((record, position));
    }
    Ok(checked)
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

fn parse<T: DeserializeOwned>(
    folder: &Path,
    file: &str,
    row: usize,
    text: &str,
) -> Result<T, HistoryError> {
    serde_json::from_str(text).map_err(|error| HistoryError::Row {
        path: folder.join(file),
        row,
        message: error.to_string(),
    })
}

/// Writes a table beside its place and renames it: a full disk leaves no half of one.
fn write<T: Serialize>(
    folder: &Path,
    (name, columns): (&str, &[&str]),
    rows: &[T],
) -> Result<(), HistoryError> {
    let path = folder.join(name);
    let unfinished = folder.join(format!(".{name}.unfinished"));
    let encoded = || -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::WriterBuilder::new()
            .has_headers(false)
            .from_writer(Vec::new());
        writer.write_record(columns)?;
        rows.iter().try_for_each(|row| writer.serialize(row))?;
        writer
            .into_inner()
            .map_err(|error| csv::Error::from(std::io::Error::other(error.to_string())))
    };
    let written = encoded()
        .map_err(std::io::Error::from)
        .and_then(|text| std::fs::write(&unfinished, text))
        .and_then(|()| std::fs::rename(&unfinished, &path));
    written.map_err(|error| {
        drop(std::fs::remove_file(&unfinished));
        HistoryError::io(&path)(error)
    })
}

fn read<T: DeserializeOwned>(
    folder: &Path,
    (name, columns): (&str, &[&str]),
) -> Result<Vec<T>, HistoryError> {
    let path = folder.join(name);
    let wrong = |row: usize, message: String| HistoryError::Row {
        path: path.clone(),
        row,
        message,
    };
    let text = std::fs::read(&path).map_err(HistoryError::io(&path))?;
    let mut reader = csv::Reader::from_reader(text.as_slice());
    let header = reader
        .headers()
        .map_err(|error| wrong(1, error.to_string()))?;
    if !header.iter().eq(columns.iter().copied()) {
        let found: Vec<&str> = header.iter().collect();
        let (found, expected) = (found.join(","), columns.join(","));
        return Err(wrong(1, format!("found {found:?}, expected {expected:?}")));
    }
    let rows = (2..).zip(reader.deserialize());
    rows.map(|(row, value)| value.map_err(|error: csv::Error| wrong(row, error.to_string())))
        .collect()
}
