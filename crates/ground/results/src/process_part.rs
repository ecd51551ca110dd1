// SPDX-License-Identifier: MIT OR Apache-2.0
//! A run that is measured by processes with a folder of their own each.
//!
//! How a process's memory is laid out decides by percents how fast it runs, and what it reads at its start
//! decides that. Processes that are compared therefore must not read what earlier ones measured. Each gets
//! the run as its first process verified it, without a measurement, and what it measures is added to the run
//! once it has ended.

use crate::folder::{
    CASES, ENVIRONMENT, MEASUREMENT_COLUMNS, MEASUREMENTS, METRICS, NOTES, PLAN, RunError,
    RunFolder, SCHEMA_FILE, encode, io, write_whole,
};
use crate::{Run, Status};
use std::path::{Path, PathBuf};

/// Files that a process needs to go on with a run. The plan comes last: a folder with a plan is whole.
const VERIFIED: [&str; 6] = [SCHEMA_FILE, ENVIRONMENT, METRICS, CASES, NOTES, PLAN];

/// A run as its first process verified it.
#[derive(Debug, Clone)]
pub struct VerifiedRun {
    path: PathBuf,
    files: Vec<(&'static str, Vec<u8>)>,
}

impl VerifiedRun {
    /// Keeps the run of this folder as it is now.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn read(path: &Path) -> Result<Self, RunError> {
        let read = |name: &'static str| {
            let file = path.join(name);
            let bytes = std::fs::read(&file).map_err(|source| io(&file, source))?;
            Ok((name, bytes))
        };
        Ok(Self {
            path: path.to_owned(),
            files: VERIFIED.into_iter().map(read).collect::<Result<_, _>>()?,
        })
    }

    /// Writes a folder for one further process, the same whatever others have measured.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn write_part(&self, part: &Path) -> Result<(), RunError> {
        let images = part.join("images");
        std::fs::create_dir_all(&images).map_err(|source| io(&images, source))?;
        let measurements = part.join(MEASUREMENTS);
        let header = encode(&measurements, |rows| rows.write_record(MEASUREMENT_COLUMNS))?;
        write_whole(&measurements, &header)?;
        for (name, bytes) in &self.files {
            write_whole(&part.join(name), bytes)?;
        }
        Ok(())
    }

    /// Adds what a process measured in its folder to the run. A case that failed there fails in the run.
    ///
    /// # Errors
    /// As [`Run::load`] of the part; [`RunError::Io`].
    pub fn add_part(&self, part: &Path) -> Result<(), RunError> {
        let run = RunFolder::open(&self.path)?;
        for case in &Run::load(part)?.cases {
            run.append_measurements(&case.measurements())?;
            // One that failed before the parts were made is not planned to be timed in any.
            if case.status() == Some(Status::Failed) && case.planned.samples > 0 {
                run.fail_case(&case.planned, &case.reason)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up::{MadeUpRun, case_id};
    use crate::{Measurement, PlannedCase};

    /// Bytes of all files of a folder: what a process that opens it reads.
    fn bytes(folder: &Path) -> u64 {
        let entries = std::fs::read_dir(folder).expect("a folder");
        let files = entries.map(|entry| entry.expect("an entry").metadata().expect("a file"));
        files
            .filter(|file| file.is_file())
            .map(|file| file.len())
            .sum()
    }

    fn rows(process: u32, samples: u32) -> Vec<Measurement> {
        let row = |sample| Measurement {
            case: "filling/a".to_owned(),
            metric: "fill_cpu_ms".to_owned(),
            process,
            sample,
            value: 1.5,
        };
        (1..=samples).map(row).collect()
    }

    fn verified(path: &Path) -> PlannedCase {
        let mut run = MadeUpRun::default();
        let case = run.case(case_id("filling", "a", &[("view", "globe")]));
        case.timed("fill_cpu_ms", &[1.0]).note("mask_hash", "f00");
        case.samples = 1;
        run.write(path).expect("a run").plan.cases.swap_remove(0)
    }

    #[test]
    fn what_a_process_reads_does_not_grow_with_what_others_measured() {
        let place = tempfile::tempdir().expect("a folder");
        let path = |name: &str| place.path().join(name);
        verified(&path("run"));
        let run = VerifiedRun::read(&path("run")).expect("read");
        run.write_part(&path("one")).expect("written");
        let shared = bytes(&path("run"));
        let part = RunFolder::open(&path("one")).expect("a run");
        part.append_measurements(&rows(1, 20_000)).expect("written");
        run.add_part(&path("one")).expect("added");
        run.write_part(&path("two")).expect("written");
        let own = bytes(&path("two"));
        assert!(own < shared, "{own}");
        // Negative control: one folder that all share grows with each process.
        let grown = bytes(&path("run"));
        assert!(grown > 100 * shared, "{shared} → {grown}");
        // A third one too, and nothing is lost.
        run.write_part(&path("three")).expect("written");
        assert_eq!(bytes(&path("three")), own);
        let all = Run::load(&path("run")).expect("read");
        let samples = all.cases[0].samples("fill_cpu_ms").expect("measured");
        assert_eq!((samples[&0].len(), samples[&1].len()), (1, 20_000));
        assert_eq!(all.cases[0].note("mask_hash"), "f00");
    }

    #[test]
    fn a_case_that_fails_in_a_part_fails_in_the_run() {
        let place = tempfile::tempdir().expect("a folder");
        let path = |name: &str| place.path().join(name);
        let case = verified(&path("run"));
        let run = VerifiedRun::read(&path("run")).expect("read");
        let status = || Run::load(&path("run")).expect("read").cases[0].status();
        run.write_part(&path("one")).expect("written");
        run.add_part(&path("one")).expect("added");
        assert_eq!(status(), Some(Status::Ok));
        let part = RunFolder::open(&path("one")).expect("a run");
        part.fail_case(&case, "lost").expect("written");
        run.add_part(&path("one")).expect("added");
        assert_eq!(status(), Some(Status::Failed));
        // The next process gets the run as it was verified.
        run.write_part(&path("two")).expect("written");
        let next = Run::load(&path("two")).expect("read");
        assert_eq!(next.cases[0].status(), Some(Status::Ok));
    }
}
