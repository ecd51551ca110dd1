// SPDX-License-Identifier: MIT OR Apache-2.0
//! A run's folder: appended row by row and flushed, so that killing a run loses at most the case in
//! hand; read back leniently at its torn end, strictly everywhere else.

use super::{
    CaseKey, GrowthRow, LadderRung, MemoryRow, PrecisionKey, PrecisionPlan, PrecisionRow,
    PrecisionTime, RunEnvironment, RunPlan, Sample, Summary,
};
use serde::{Serialize, de::DeserializeOwned};
use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// File of the numerical suite's plan.
const PRECISION_PLAN: &str = "precision.json";

/// What can be wrong with a run's folder.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The folder or a file in it cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A row does not fit the schema.
    #[error("{path}, row {row}: {message}")]
    Row {
        /// Which file.
        path: PathBuf,
        /// Row number, header is 1.
        row: u64,
        /// What is wrong.
        message: String,
    },
    /// A JSON file does not fit the schema.
    #[error("{path}: {message}")]
    Json {
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

/// A folder with a run in it.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
}

impl RunFolder {
    /// Starts a run in a new or empty folder.
    ///
    /// # Errors
    /// [`RunError::Occupied`] if the folder holds a run; [`RunError::Io`].
    pub fn create(
        path: &Path,
        environment: &RunEnvironment,
        plan: &RunPlan,
    ) -> Result<Self, RunError> {
        let run = Self {
            path: path.to_owned(),
        };
        if run.plan_path().exists() {
            return Err(RunError::Occupied {
                path: path.to_owned(),
                message: "give another --out, or --resume to go on with it".to_owned(),
            });
        }
        std::fs::create_dir_all(path.join("images")).map_err(|source| run.io("images", source))?;
        run.write_json("environment.json", environment)?;
        run.write_json("plan.json", plan)?;
        Ok(run)
    }

    /// Opens an existing run.
    ///
    /// # Errors
    /// [`RunError::Io`] if there is none.
    pub fn open(path: &Path) -> Result<Self, RunError> {
        let run = Self {
            path: path.to_owned(),
        };
        File::open(run.plan_path()).map_err(|source| run.io("plan.json", source))?;
        Ok(run)
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What the run set out to measure.
    ///
    /// # Errors
    /// [`RunError::Io`], [`RunError::Json`].
    pub fn plan(&self) -> Result<RunPlan, RunError> {
        self.read_json("plan.json")
    }

    /// Where it was made.
    ///
    /// # Errors
    /// [`RunError::Io`], [`RunError::Json`].
    pub fn environment(&self) -> Result<RunEnvironment, RunError> {
        self.read_json("environment.json")
    }

    /// Every timed frame. A last line without its line end is dropped: the run was killed there.
    /// When a frame of a case stands twice, the last one counts.
    ///
    /// # Errors
    /// [`RunError::Row`] for any other malformed row.
    pub fn samples(&self) -> Result<Vec<Sample>, RunError> {
        let rows: Vec<Sample> = self.read_rows("samples.csv")?;
        Ok(keep_last(rows, |row| (row.key(), row.frame)))
    }

    /// Every finished case; when a case stands twice, the last one counts.
    ///
    /// # Errors
    /// As [`RunFolder::samples`].
    pub fn summaries(&self) -> Result<Vec<Summary>, RunError> {
        Ok(keep_last(self.read_rows("summary.csv")?, Summary::key))
    }

    /// Every mesh build that was measured for growth; empty where none was. When one stands twice, the
    /// last one counts.
    ///
    /// # Errors
    /// As [`RunFolder::samples`].
    pub fn growth(&self) -> Result<Vec<GrowthRow>, RunError> {
        let rows: Vec<GrowthRow> = self.read_rows("growth.csv")?;
        Ok(keep_last(rows, |row| {
            (row.shape.clone(), row.outline_vertices, row.repetition)
        }))
    }

    /// Planned cases without a summary row.
    ///
    /// # Errors
    /// As [`RunFolder::samples`].
    pub fn missing(&self) -> Result<Vec<CaseKey>, RunError> {
        let done: BTreeSet<CaseKey> = self.summaries()?.iter().map(Summary::key).collect();
        let mut cases = self.plan()?.cases;
        cases.retain(|case| !done.contains(case));
        Ok(cases)
    }

    /// Prepares a killed run for going on: cuts torn last lines and keeps every whole row, so that
    /// nothing that was measured is measured again.
    ///
    /// # Errors
    /// [`RunError::Occupied`] if the folder's plan differs; else as [`RunFolder::samples`].
    pub fn resume(path: &Path, plan: &RunPlan) -> Result<Self, RunError> {
        let run = Self::open(path)?;
        if run.plan()? != *plan {
            return Err(RunError::Occupied {
                path: path.to_owned(),
                message: "its plan differs; resume with the same scenes and options".to_owned(),
            });
        }
        let (summaries, samples) = (run.summaries()?, run.samples()?);
        run.rewrite("growth.csv", &run.growth()?)?;
        run.rewrite("summary.csv", &summaries)?;
        run.rewrite("samples.csv", &samples)?;
        run.rewrite("memory.csv", &run.memory()?)?;
        run.rewrite("precision.csv", &run.precision()?)?;
        run.rewrite("precision_times.csv", &run.precision_times()?)?;
        Ok(run)
    }

    /// Appends samples and flushes them to the disk.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn append_samples(&self, rows: &[Sample]) -> Result<(), RunError> {
        self.append("samples.csv", rows)
    }

    /// Appends a finished case and flushes it to the disk.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn append_summary(&self, row: &Summary) -> Result<(), RunError> {
        self.append("summary.csv", std::slice::from_ref(row))
    }

    /// Appends a measured mesh build and flushes it to the disk.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn append_growth(&self, row: &GrowthRow) -> Result<(), RunError> {
        self.append("growth.csv", std::slice::from_ref(row))
    }

    /// Writes the ladders of the run, in place of older ones; nothing where there are none.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn write_ladder(&self, rungs: &[LadderRung]) -> Result<(), RunError> {
        self.rewrite("ladder.csv", rungs)
    }

    /// The rungs of the run's ladders, in order.
    ///
    /// # Errors
    /// As [`RunFolder::samples`].
    pub fn ladder(&self) -> Result<Vec<LadderRung>, RunError> {
        self.read_rows("ladder.csv")
    }

    /// Appends bytes of layouts and flushes them to the disk.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn append_memory(&self, rows: &[MemoryRow]) -> Result<(), RunError> {
        if rows.is_empty() {
            return Ok(());
        }
        self.append("memory.csv", rows)
    }

    /// Bytes of every layout; when a layout of a scene stands twice with as many regions, the last
    /// one counts.
    ///
    /// # Errors
    /// As [`RunFolder::samples`].
    pub fn memory(&self) -> Result<Vec<MemoryRow>, RunError> {
        Ok(keep_last(
            self.read_rows("memory.csv")?,
            |row: &MemoryRow| {
                let of = (row.scene.clone(), row.backend.clone());
                (of, row.layout.clone(), row.regions)
            },
        ))
    }

    /// Writes what the numerical suite is about to measure.
    ///
    /// # Errors
    /// [`RunError::Occupied`] where the folder holds another such plan; [`RunError::Io`].
    pub fn write_precision_plan(&self, plan: &PrecisionPlan) -> Result<(), RunError> {
        match self.precision_plan()? {
            Some(found) if found == *plan => Ok(()),
            Some(_) => Err(RunError::Occupied {
                path: self.path.join(PRECISION_PLAN),
                message: "its plan of the numerical suite differs".to_owned(),
            }),
            None => self.write_json(PRECISION_PLAN, plan),
        }
    }

    /// What the numerical suite set out to measure; `None` for a run without it.
    ///
    /// # Errors
    /// [`RunError::Io`], [`RunError::Json`].
    pub fn precision_plan(&self) -> Result<Option<PrecisionPlan>, RunError> {
        if !self.path.join(PRECISION_PLAN).exists() {
            return Ok(None);
        }
        self.read_json(PRECISION_PLAN).map(Some)
    }

    /// Appends rows of the numerical suite and flushes them to the disk.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn append_precision(&self, rows: &[PrecisionRow]) -> Result<(), RunError> {
        if rows.is_empty() {
            return Ok(());
        }
        self.append("precision.csv", rows)
    }

    /// Rows of the numerical suite; when one stands twice, the last one counts.
    ///
    /// # Errors
    /// As [`RunFolder::samples`].
    pub fn precision(&self) -> Result<Vec<PrecisionRow>, RunError> {
        let rows = self.read_rows("precision.csv")?;
        Ok(keep_last(rows, PrecisionRow::key))
    }

    /// Appends timed passes of the numerical suite and flushes them to the disk.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn append_precision_times(&self, rows: &[PrecisionTime]) -> Result<(), RunError> {
        if rows.is_empty() {
            return Ok(());
        }
        self.append("precision_times.csv", rows)
    }

    /// Timed passes of the numerical suite; when one stands twice, the last one counts.
    ///
    /// # Errors
    /// As [`RunFolder::samples`].
    pub fn precision_times(&self) -> Result<Vec<PrecisionTime>, RunError> {
        let rows: Vec<PrecisionTime> = self.read_rows("precision_times.csv")?;
        Ok(keep_last(rows, |row| {
            (row.part, row.route.clone(), row.round)
        }))
    }

    /// Planned rows of the numerical suite that are not there.
    ///
    /// # Errors
    /// As [`RunFolder::samples`].
    pub fn precision_missing(&self) -> Result<Vec<PrecisionKey>, RunError> {
        let Some(plan) = self.precision_plan()? else {
            return Ok(Vec::new());
        };
        let done: BTreeSet<PrecisionKey> =
            self.precision()?.iter().map(PrecisionRow::key).collect();
        Ok(plan.keys().filter(|key| !done.contains(key)).collect())
    }

    fn plan_path(&self) -> PathBuf {
        self.path.join("plan.json")
    }

    fn io(&self, file: &str, source: std::io::Error) -> RunError {
        RunError::Io {
            path: self.path.join(file),
            source,
        }
    }

    fn read_json<T: DeserializeOwned>(&self, file: &str) -> Result<T, RunError> {
        let text = std::fs::read_to_string(self.path.join(file)).map_err(|e| self.io(file, e))?;
        serde_json::from_str(&text).map_err(|error| RunError::Json {
            path: self.path.join(file),
            message: error.to_string(),
        })
    }

    fn write_json<T: Serialize>(&self, file: &str, value: &T) -> Result<(), RunError> {
        let text = serde_json::to_string_pretty(value).map_err(|error| RunError::Json {
            path: self.path.join(file),
            message: error.to_string(),
        })?;
        std::fs::write(self.path.join(file), text + "\n").map_err(|e| self.io(file, e))
    }

    fn read_rows<T: DeserializeOwned>(&self, file: &str) -> Result<Vec<T>, RunError> {
        let path = self.path.join(file);
        let mut text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(self.io(file, error)),
        };
        text.truncate(whole_rows_len(&text));
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let at_row = |row: u64, message: String| RunError::Row {
            path: path.clone(),
            row,
            message,
        };
        let header = reader
            .headers()
            .map_err(|error| at_row(1, error.to_string()))?
            .clone();
        let mut rows = Vec::new();
        for (record, row) in reader.records().zip(2..) {
            let record = record.map_err(|error| at_row(row, error.to_string()))?;
            let value = record.deserialize(Some(&header));
            rows.push(value.map_err(|error| at_row(row, cell_message(&error, &header, &record)))?);
        }
        Ok(rows)
    }

    fn append<T: Serialize>(&self, file: &str, rows: &[T]) -> Result<(), RunError> {
        let path = self.path.join(file);
        let is_new = std::fs::metadata(&path).map_or(true, |meta| meta.len() == 0);
        let text = self.encode(file, rows, is_new)?;
        let mut out = OpenOptions::new()
            .create(true)
            .append(true)
            .open(&path)
            .map_err(|e| self.io(file, e))?;
        out.write_all(&text)
            .and_then(|()| out.sync_data())
            .map_err(|e| self.io(file, e))
    }

    /// Writes beside the file and renames, so that a kill in between leaves the old file whole.
    fn rewrite<T: Serialize>(&self, file: &str, rows: &[T]) -> Result<(), RunError> {
        if rows.is_empty() && !self.path.join(file).exists() {
            return Ok(());
        }
        let text = self.encode(file, rows, true)?;
        let temporary = self.path.join(format!("{file}.new"));
        std::fs::write(&temporary, text)
            .and_then(|()| std::fs::rename(&temporary, self.path.join(file)))
            .map_err(|e| self.io(file, e))
    }

    fn encode<T: Serialize>(
        &self,
        file: &str,
        rows: &[T],
        with_header: bool,
    ) -> Result<Vec<u8>, RunError> {
        let mut writer = csv::WriterBuilder::new()
            .has_headers(with_header)
            .from_writer(Vec::new());
        for (index, row) in rows.iter().enumerate() {
            writer.serialize(row).map_err(|error| RunError::Row {
                path: self.path.join(file),
                row: index as u64,
                message: error.to_string(),
            })?;
        }
        writer.into_inner().map_err(|error| RunError::Row {
            path: self.path.join(file),
            row: rows.len() as u64,
            message: error.to_string(),
        })
    }
}

/// What is wrong with a row, with its column and the value found where one cell is to blame.
fn cell_message(
    error: &csv::Error,
    header: &csv::StringRecord,
    record: &csv::StringRecord,
) -> String {
    let csv::ErrorKind::Deserialize { err, .. } = error.kind() else {
        return error.to_string();
    };
    let index = err.field().and_then(|field| usize::try_from(field).ok());
    let cell = index.and_then(|index| Some((header.get(index)?, record.get(index)?)));
    match cell {
        Some((column, found)) => format!("column {column} holds {found:?}: {}", err.kind()),
        None => err.kind().to_string(),
    }
}

/// Bytes of `text` up to the end of its last finished row. A line end inside quotes, as in a
/// reason of two lines, ends no row.
fn whole_rows_len(text: &str) -> usize {
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

/// Drops every row that a later one of the same key replaces; the order of the kept ones stays.
fn keep_last<T, K: Ord>(rows: Vec<T>, key: impl Fn(&T) -> K) -> Vec<T> {
    let mut seen = BTreeSet::new();
    let mut kept: Vec<T> = rows
        .into_iter()
        .rev()
        .filter(|row| seen.insert(key(row)))
        .collect();
    kept.reverse();
    kept
}

impl Summary {
    /// The case that this row is about.
    #[must_use]
    pub fn key(&self) -> CaseKey {
        CaseKey {
            scene: self.scene.clone(),
            view: self.view.clone(),
            backend: self.backend.clone(),
            variant: self.variant.clone(),
        }
    }
}

impl Sample {
    /// The case that this row is about.
    #[must_use]
    pub fn key(&self) -> CaseKey {
        CaseKey {
            scene: self.scene.clone(),
            view: self.view.clone(),
            backend: self.backend.clone(),
            variant: self.variant.clone(),
        }
    }
}
