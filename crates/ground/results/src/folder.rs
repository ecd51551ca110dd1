// SPDX-License-Identifier: MIT OR Apache-2.0
//! A run's folder while it is written: every row is appended as it is measured, so that killing a
//! run loses at most the sample in hand. Only a case that fails after it was verified gets another row
//! in place of its own.

use crate::{Measurement, Metric, MetricRow, Note, PlannedCase, RunEnvironment, RunPlan, Status};
use serde::{Serialize, de::DeserializeOwned};
use std::collections::BTreeMap;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Version of a run folder's files.
pub const SCHEMA: u32 = 1;

/// Columns of `measurements.csv`.
pub const MEASUREMENT_COLUMNS: [&str; 5] = ["case", "metric", "process", "sample", "value"];
/// Columns of `notes.csv`.
pub const NOTE_COLUMNS: [&str; 3] = ["case", "note", "text"];
/// Columns of `metrics.csv`.
pub const METRIC_COLUMNS: [&str; 7] = [
    "name", "unit", "kind", "better", "meaning", "primary", "scope",
];
/// How many of them runs have that are older than the last two.
pub const OLD_METRIC_COLUMNS: usize = 5;
/// First columns of `cases.csv`; one for each condition follows.
pub const CASE_COLUMNS: [&str; 6] = ["case", "study", "status", "reason", "timed", "commit"];

pub(crate) const MEASUREMENTS: &str = "measurements.csv";
pub(crate) const CASES: &str = "cases.csv";
pub(crate) const NOTES: &str = "notes.csv";
pub(crate) const METRICS: &str = "metrics.csv";
pub(crate) const PLAN: &str = "plan.json";
pub(crate) const ENVIRONMENT: &str = "environment.json";
pub(crate) const SCHEMA_FILE: &str = "schema.json";

/// What can be wrong with a run's folder.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// A file cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// There is no run.
    #[error(
        "{}: no such file; {folder} is no folder of a run, which holds schema.json, plan.json, environment.json \
         and tables as `terrafill bench` writes them", folder.join(SCHEMA_FILE).display()
    )]
    NoRun {
        /// As it was named; it may not exist.
        folder: PathBuf,
    },
    /// A table of the folder is missing.
    #[error("{path}: found no such file, expected a table with the columns {expected}")]
    MissingTable {
        /// Which file.
        path: PathBuf,
        /// Its columns.
        expected: String,
    },
    /// The columns of a table are not those of this schema.
    #[error("{path}, column {position}: found {found:?}, expected {expected:?}")]
    Column {
        /// Which file.
        path: PathBuf,
        /// From 1.
        position: usize,
        /// As in the file; empty where it has fewer.
        found: String,
        /// As it should be; empty where the file has more.
        expected: String,
    },
    /// A row does not fit the schema or the rest of the folder.
    #[error("{path}, row {row}, column {column}: found {found:?}, expected {expected}")]
    Cell {
        /// Which file.
        path: PathBuf,
        /// Row number, the header is 1.
        row: u64,
        /// Which column.
        column: String,
        /// What it holds.
        found: String,
        /// What it may hold.
        expected: String,
    },
    /// A file of another version of this program.
    #[error("{path}, \"schema\": found {found}, expected {expected}")]
    Schema {
        /// Which file.
        path: PathBuf,
        /// As in the file.
        found: String,
        /// That of this program.
        expected: u32,
    },
    /// A JSON file does not fit the schema, or a CSV file is none.
    #[error("{path}: {message}")]
    Malformed {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
    /// The folder holds another run and `--resume` was not given, or its plan differs.
    #[error("{path} holds a run already: {message}")]
    Occupied {
        /// Which folder.
        path: PathBuf,
        /// What to do.
        message: String,
    },
}

/// `schema.json`: which columns each table has and what they mean.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
struct Schema {
    schema: u32,
    tables: BTreeMap<&'static str, Vec<String>>,
    metrics: Vec<MetricRow>,
}

/// A run folder to append to.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    plan: RunPlan,
    environment: RunEnvironment,
    conditions: Vec<String>,
}

impl RunFolder {
    /// Refuses a folder that holds a run, ended or not.
    ///
    /// # Errors
    /// [`RunError::Occupied`].
    pub fn refuse_occupied(path: &Path) -> Result<(), RunError> {
        if !path.join(PLAN).exists() {
            return Ok(());
        }
        Err(RunError::Occupied {
            path: path.to_owned(),
            message: "give another --out, or --resume to go on with it".to_owned(),
        })
    }

    /// Starts a run in a new or empty folder: writes plan, environment, schema and empty tables.
    ///
    /// # Errors
    /// [`RunError::Occupied`] if the folder holds a run; [`RunError::Io`].
    pub fn create(
        path: &Path,
        environment: RunEnvironment,
        plan: RunPlan,
        metrics: &[Metric],
    ) -> Result<Self, RunError> {
        Self::refuse_occupied(path)?;
        let folder = Self {
            path: path.to_owned(),
            conditions: plan.conditions(),
            plan,
            environment,
        };
        let images = path.join("images");
        std::fs::create_dir_all(&images).map_err(|source| io(&images, source))?;
        let metrics: Vec<MetricRow> = metrics.iter().map(MetricRow::from).collect();
        let header = |columns: &[&str]| columns.iter().map(ToString::to_string).collect();
        let tables = BTreeMap::from([
            (MEASUREMENTS, header(&MEASUREMENT_COLUMNS)),
            (CASES, folder.case_columns()),
            (NOTES, header(&NOTE_COLUMNS)),
            (METRICS, header(&METRIC_COLUMNS)),
        ]);
        for (file, columns) in &tables {
            let text = encode(&path.join(file), |writer| writer.write_record(columns))?;
            write_whole(&path.join(file), &text)?;
        }
        folder.append(
            METRICS,
            &metrics.iter().map(MetricRow::cells).collect::<Vec<_>>(),
        )?;
        write_json(
            &path.join(SCHEMA_FILE),
            &Schema {
                schema: SCHEMA,
                tables,
                metrics,
            },
        )?;
        write_json(&path.join(ENVIRONMENT), &folder.environment)?;
        // Last: a folder with a plan has everything else.
        write_json(&path.join(PLAN), &folder.plan)?;
        Ok(folder)
    }

    /// Goes on with a run: cuts torn last rows and keeps every whole one.
    ///
    /// # Errors
    /// [`RunError::Occupied`] if plan or set-up differ, naming what; else as [`crate::Run::load`].
    pub fn resume(
        path: &Path,
        environment: &RunEnvironment,
        plan: &RunPlan,
    ) -> Result<Self, RunError> {
        let folder = Self::open(path)?;
        let differs = |message: String| RunError::Occupied {
            path: path.to_owned(),
            message,
        };
        if let Some(what) = folder.environment.difference(environment) {
            return Err(differs(format!("cannot resume with {what}")));
        }
        if folder.plan != *plan {
            let message = "its plan differs; resume with the same scenes and options";
            return Err(differs(message.to_owned()));
        }
        for file in [MEASUREMENTS, CASES, NOTES] {
            cut_torn_row(&path.join(file))?;
        }
        Ok(folder)
    }

    /// Opens a run to append to, such as from another process of the same run.
    ///
    /// # Errors
    /// [`RunError::NoRun`] if there is none; [`RunError::Schema`], [`RunError::Malformed`].
    pub fn open(path: &Path) -> Result<Self, RunError> {
        check_schema(path)?;
        let plan: RunPlan = read_json(&path.join(PLAN))?;
        Ok(Self {
            path: path.to_owned(),
            conditions: plan.conditions(),
            plan,
            environment: read_json(&path.join(ENVIRONMENT))?,
        })
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What the run set out to measure.
    #[must_use]
    pub fn plan(&self) -> &RunPlan {
        &self.plan
    }

    /// Where and with what it is made.
    #[must_use]
    pub fn environment(&self) -> &RunEnvironment {
        &self.environment
    }

    fn case_columns(&self) -> Vec<String> {
        let fixed = CASE_COLUMNS.iter().map(ToString::to_string);
        fixed.chain(self.conditions.iter().cloned()).collect()
    }

    /// Appends a verified case, once.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn append_case(
        &self,
        case: &PlannedCase,
        status: Status,
        reason: &str,
    ) -> Result<(), RunError> {
        let record = self.case_record(case, status, reason);
        let path = self.path.join(CASES);
        let text = encode(&path, |writer| writer.write_record(&record))?;
        append_bytes(&path, &text)
    }

    /// Puts a failure in the place of a verified case's row, so that the table keeps one row a case.
    ///
    /// The table is written anew and renamed: a kill leaves the old one or the new one whole.
    ///
    /// # Errors
    /// [`RunError::Io`]; as [`crate::Run::load`] where the table is not this run's.
    pub fn fail_case(&self, case: &PlannedCase, reason: &str) -> Result<(), RunError> {
        let path = self.path.join(CASES);
        let columns = self.case_columns();
        let rows = read_table(&path, &columns)?;
        let failed = self.case_record(case, Status::Failed, reason);
        let others = rows
            .iter()
            .filter(|row| row.get(0) != failed.first().map(String::as_str));
        let text = encode(&path, |writer| {
            writer.write_record(&columns)?;
            others
                .into_iter()
                .try_for_each(|row| writer.write_record(row))?;
            writer.write_record(&failed)
        })?;
        write_whole(&path, &text)
    }

    fn case_record(&self, case: &PlannedCase, status: Status, reason: &str) -> Vec<String> {
        let timed = case.samples > 0 && status != Status::Skipped && status != Status::Failed;
        let fixed = [
            case.id.key(),
            case.id.study.clone(),
            status.name().to_owned(),
            reason.to_owned(),
            timed.to_string(),
            self.environment.commit.clone(),
        ];
        let conditions = self
            .conditions
            .iter()
            .map(|key| case.id.condition_named(key).to_owned());
        fixed.into_iter().chain(conditions).collect()
    }

    /// Appends measured values.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn append_measurements(&self, rows: &[Measurement]) -> Result<(), RunError> {
        self.append(MEASUREMENTS, rows)
    }

    /// Appends texts.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn append_notes(&self, rows: &[Note]) -> Result<(), RunError> {
        self.append(NOTES, rows)
    }

    fn append<T: Serialize>(&self, file: &str, rows: &[T]) -> Result<(), RunError> {
        let path = self.path.join(file);
        let text = encode(&path, |writer| {
            rows.iter().try_for_each(|row| writer.serialize(row))
        })?;
        append_bytes(&path, &text)
    }
}

/// Cuts what a killed process left of a table's last row.
pub(crate) fn cut_torn_row(path: &Path) -> Result<(), RunError> {
    let mut text = read_text(path, "")?;
    let whole = whole_rows_len(&text);
    if whole < text.len() {
        text.truncate(whole);
        write_whole(path, text.as_bytes())?;
    }
    Ok(())
}

pub(crate) fn cell(
    path: &Path,
    row: u64,
    column: &str,
    found: &str,
    expected: impl Into<String>,
) -> RunError {
    RunError::Cell {
        path: path.to_owned(),
        row,
        column: column.to_owned(),
        found: found.to_owned(),
        expected: expected.into(),
    }
}

/// The folder's files are of the schema that this program writes.
pub(crate) fn check_schema(path: &Path) -> Result<(), RunError> {
    if !path.join(SCHEMA_FILE).exists() {
        return Err(RunError::NoRun {
            folder: path.to_owned(),
        });
    }
    for file in [SCHEMA_FILE, ENVIRONMENT] {
        let file = path.join(file);
        let value: serde_json::Value = read_json(&file)?;
        let found = &value["schema"];
        if found.as_u64() != Some(u64::from(SCHEMA)) {
            return Err(RunError::Schema {
                path: file,
                found: found.to_string(),
                expected: SCHEMA,
            });
        }
    }
    Ok(())
}

/// A table: its rows by column, the header checked against `columns`.
pub(crate) fn read_table(
    path: &Path,
    columns: &[String],
) -> Result<Vec<csv::StringRecord>, RunError> {
    let mut rows = Vec::new();
    each_row(path, columns, |_, row| {
        rows.push(row.clone());
        Ok(())
    })?;
    Ok(rows)
}

/// Goes through a table without keeping its rows, which take many times as much as what they say.
///
/// - `read`: gets a row's number as people count them, the header being 1
pub(crate) fn each_row(
    path: &Path,
    columns: &[String],
    mut read: impl FnMut(u64, &csv::StringRecord) -> Result<(), RunError>,
) -> Result<(), RunError> {
    let mut text = read_text(path, &columns.join(", "))?;
    text.truncate(whole_rows_len(&text));
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let no_table = |error: csv::Error| malformed(path, error);
    let header = reader.headers().map_err(no_table)?.clone();
    for position in 0..header.len().max(columns.len()) {
        let found = header.get(position).unwrap_or_default();
        let expected = columns.get(position).map_or("", String::as_str);
        if found != expected {
            return Err(RunError::Column {
                path: path.to_owned(),
                position: position + 1,
                found: found.to_owned(),
                expected: expected.to_owned(),
            });
        }
    }
    let mut record = csv::StringRecord::new();
    for row in 2.. {
        if !reader.read_record(&mut record).map_err(no_table)? {
            break;
        }
        read(row, &record)?;
    }
    Ok(())
}

pub(crate) fn io(path: &Path, source: std::io::Error) -> RunError {
    RunError::Io {
        path: path.to_owned(),
        source,
    }
}

pub(crate) fn malformed(path: &Path, message: impl ToString) -> RunError {
    RunError::Malformed {
        path: path.to_owned(),
        message: message.to_string(),
    }
}

/// - `columns`: of a table, for the message where there is none; empty for other files
fn read_text(path: &Path, columns: &str) -> Result<String, RunError> {
    std::fs::read_to_string(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound if !columns.is_empty() => RunError::MissingTable {
            path: path.to_owned(),
            expected: columns.to_owned(),
        },
        _ => io(path, error),
    })
}

pub(crate) fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, RunError> {
    serde_json::from_str(&read_text(path, "")?).map_err(|error| malformed(path, error))
}

pub(crate) fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), RunError> {
    let text = serde_json::to_string_pretty(value).map_err(|error| malformed(path, error))?;
    write_whole(path, (text + "\n").as_bytes())
}

/// Writes beside the file and renames, so that a kill in between leaves the old file whole.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), RunError> {
    let mut temporary = path.as_os_str().to_owned();
    temporary.push(".new");
    let temporary = PathBuf::from(temporary);
    std::fs::write(&temporary, bytes)
        .and_then(|()| std::fs::rename(&temporary, path))
        .map_err(|source| io(path, source))
}

pub(crate) fn append_bytes(path: &Path, bytes: &[u8]) -> Result<(), RunError> {
    if bytes.is_empty() {
        return Ok(());
    }
    OpenOptions::new()
        .append(true)
        .open(path)
        .and_then(|mut file| file.write_all(bytes))
        .map_err(|source| io(path, source))
}

pub(crate) fn encode(
    path: &Path,
    rows: impl FnOnce(&mut csv::Writer<Vec<u8>>) -> csv::Result<()>,
) -> Result<Vec<u8>, RunError> {
    let mut writer = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(Vec::new());
    rows(&mut writer).map_err(|error| malformed(path, error))?;
    writer.into_inner().map_err(|error| malformed(path, error))
}

/// Bytes of `text` up to the end of its last finished row. A line end inside quotes, as in a
/// reason of two lines, ends no row.
pub(crate) fn whole_rows_len(text: &str) -> usize {
    let mut quoted = false;
    let mut end = 0;
    for (index, byte) in text.bytes().enumerate() {
        match byte {
            b'"' => quoted = !quoted,
            b'\n' if !quoted => end = index + 1,
            _ => {}
        }
    }
    end
}
