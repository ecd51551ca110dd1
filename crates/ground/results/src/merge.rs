// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shards of one run, measured apart, as one folder.

use crate::folder::{RunError, RunFolder, io};
use crate::{
    Budget, Metric, MetricRow, Note, Run, RunInput, RunPlan, Shard, append_clocks,
    append_durations, append_inputs, read_clocks, read_durations, read_inputs, repeated_cases,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Why shards are not one run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// A folder cannot be read, or the merged one not be written.
    #[error(transparent)]
    Run(#[from] RunError),
    /// No folder was given.
    #[error("no run to merge, allowed: one folder for each shard")]
    Nothing,
    /// A run that is no shard.
    #[error("{path}: a whole run, allowed: shards made with --shard m/n")]
    NoShard {
        /// Its folder.
        path: PathBuf,
    },
    /// Shards of runs that were not made in one way.
    #[error("{path}: {message}")]
    Different {
        /// The folder that differs from the first.
        path: PathBuf,
        /// In what.
        message: String,
    },
    /// A shard was given twice.
    #[error("shard {index}/{count}: found in {first} and in {second}, allowed: once")]
    Twice {
        /// Which.
        index: usize,
        /// Of how many.
        count: usize,
        /// One folder.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
    /// Shards that were not given.
    #[error("shards {missing} of {count} are missing, expected a folder for each")]
    Missing {
        /// Their numbers.
        missing: String,
        /// Of how many.
        count: usize,
    },
    /// The merged folder's metrics are not those of this program.
    #[error("{path}: metric {name:?} is not one that this program declares")]
    UnknownMetric {
        /// The folder.
        path: PathBuf,
        /// Its name.
        name: String,
    },
}

/// Joins `parts`, which are all the shards of one run, into the new folder `out`.
///
/// - `metrics`: declarations of everything that the studies measure
///
/// # Errors
/// [`MergeError`]; nothing is written then.
pub fn merge(parts: &[PathBuf], out: &Path, metrics: &[Metric]) -> Result<(), MergeError> {
    let runs: Vec<Run> = parts
        .iter()
        .map(|part| Run::load(part))
        .collect::<Result<_, _>>()?;
    let shards = in_order(&runs)?;
    let first = shards[0];
    for run in &runs {
        let unknown = |row: &&MetricRow| !metrics.iter().any(|metric| metric.name == row.name);
        if let Some(row) = run.metrics.iter().find(unknown) {
            return Err(MergeError::UnknownMetric {
                path: run.path.clone(),
                name: row.name.clone(),
            });
        }
    }
    let mut skipped = first.plan.skipped.clone();
    for run in &shards {
        for left_out in &run.plan.skipped {
            if !skipped.contains(left_out) {
                skipped.push(left_out.clone());
            }
        }
    }
    let plan = RunPlan {
        cases: shards
            .iter()
            .flat_map(|run| run.plan.cases.clone())
            .collect(),
        skipped,
        shard: None,
        ..first.plan.clone()
    };
    if let Some(twice) = repeated_cases(&plan).first() {
        return Err(MergeError::Different {
            path: first.path.clone(),
            message: format!("case {twice:?} is in more than one shard, allowed: one"),
        });
    }
    let mut environment = first.environment.clone();
    let is_of_shards =
        |option: &str| option.starts_with("shard=") || option.starts_with("shard-by=");
    environment.options.retain(|option| !is_of_shards(option));
    let folder = RunFolder::create(out, environment, plan, metrics)?;
    let budget = Budget::read(&first.path)?;
    if budget != Budget::default() {
        budget.write(out)?;
    }
    let mut known: Vec<RunInput> = Vec::new();
    for run in &shards {
        copy_rows(run, &folder)?;
        copy_images(&run.path, out)?;
        let durations = read_durations(&run.path)?;
        if !durations.is_empty() {
            append_durations(out, &durations)?;
        }
        let inputs = read_inputs(&run.path)?.into_iter();
        let inputs: Vec<RunInput> = inputs.filter(|input| !known.contains(input)).collect();
        append_inputs(out, &inputs)?;
        known.extend(inputs);
        let clocks = read_clocks(&run.path)?;
        if !clocks.is_empty() {
            append_clocks(out, &clocks)?;
        }
    }
    Ok(())
}

/// The runs by their shards' numbers, or why they are not all the shards of one run.
fn in_order(runs: &[Run]) -> Result<Vec<&Run>, MergeError> {
    let first = runs.first().ok_or(MergeError::Nothing)?;
    let mut by_index: BTreeMap<usize, &Run> = BTreeMap::new();
    let shard = |run: &Run| {
        run.plan.shard.ok_or_else(|| MergeError::NoShard {
            path: run.path.clone(),
        })
    };
    let count = shard(first)?.count;
    for run in runs {
        let Shard { index, count: of } = shard(run)?;
        let different = |message: String| MergeError::Different {
            path: run.path.clone(),
            message,
        };
        if of != count {
            return Err(different(format!(
                "shard {index}/{of}, expected one of {count}"
            )));
        }
        let mut now = run.environment.clone();
        let mut then = first.environment.clone();
        for environment in [&mut now, &mut then] {
            environment
                .options
                .retain(|option| !option.starts_with("shard="));
        }
        if let Some(what) = then.difference(&now) {
            return Err(different(format!("not the same run: {what}")));
        }
        let is_alike = |a: &RunPlan, b: &RunPlan| {
            (a.processes, a.warm_up, a.seed) == (b.processes, b.warm_up, b.seed)
        };
        if !is_alike(&run.plan, &first.plan) {
            return Err(different(
                "its processes, warm-up or seed differ".to_owned(),
            ));
        }
        if let Some(other) = by_index.insert(index, run) {
            return Err(MergeError::Twice {
                index,
                count,
                first: other.path.clone(),
                second: run.path.clone(),
            });
        }
    }
    let missing: Vec<String> = (1..=count)
        .filter(|index| !by_index.contains_key(index))
        .map(|index| index.to_string())
        .collect();
    if missing.is_empty() {
        Ok(by_index.into_values().collect())
    } else {
        Err(MergeError::Missing {
            missing: missing.join(", "),
            count,
        })
    }
}

fn copy_rows(run: &Run, folder: &RunFolder) -> Result<(), RunError> {
    for case in &run.cases {
        let key = case.id().key();
        folder.append_measurements(&case.measurements())?;
        let notes: Vec<Note> = case
            .notes()
            .iter()
            .map(|(note, text)| Note {
                case: key.clone(),
                note: note.clone(),
                text: text.clone(),
            })
            .collect();
        folder.append_notes(&notes)?;
        folder.append_features(&key, case.features())?;
        if let Some(status) = case.status() {
            folder.append_case(&case.planned, status, &case.reason)?;
        }
    }
    Ok(())
}

fn copy_images(from: &Path, to: &Path) -> Result<(), RunError> {
    let images = from.join("images");
    // What carries folders between machines often leaves empty ones behind.
    if !images.exists() {
        return Ok(());
    }
    for entry in std::fs::read_dir(&images).map_err(|source| io(&images, source))? {
        let path = entry.map_err(|source| io(&images, source))?.path();
        if let Some(name) = path.file_name() {
            let copied = std::fs::copy(&path, to.join("images").join(name));
            copied.map_err(|source| io(&path, source))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Measurement;
    use crate::{CaseId, Kind, Outcome, PlannedCase, RunEnvironment, SCHEMA, Status};

    const METRICS: [Metric; 1] = [Metric::less("cost_ms", "ms", Kind::Time, "Cost.")];

    /// A shard with one case of one sample.
    fn shard(path: &Path, index: usize, count: usize, seed: u64) -> PathBuf {
        let path = path.join(format!("{index}-of-{count}-{seed}"));
        let condition = if index == 1 { "colour" } else { "shape" };
        let plan = RunPlan {
            cases: vec![PlannedCase {
                id: CaseId::new("s", format!("case-{index}"), [(condition, "x".to_owned())]),
                samples: 1,
                may_be_wrong: false,
            }],
            processes: 1,
            seed,
            shard: Some(Shard { index, count }),
            ..RunPlan::default()
        };
        let environment = RunEnvironment {
            schema: SCHEMA,
            options: vec!["quick=true".to_owned(), format!("shard={index}/{count}")],
            ..RunEnvironment::default()
        };
        let folder = RunFolder::create(&path, environment, plan, &METRICS).expect("new");
        let case = &folder.plan().cases[0].clone();
        folder.append_case(case, Status::Ok, "").expect("written");
        folder
            .append_measurements(&[Measurement {
                case: case.id.key(),
                metric: "cost_ms".to_owned(),
                process: 0,
                sample: 1,
                value: index as f64,
            }])
            .expect("written");
        std::fs::write(path.join(format!("images/{index}.png")), "x").expect("written");
        path
    }

    #[test]
    fn shards_become_one_run() {
        let place = tempfile::tempdir().expect("a folder");
        let parts = [2, 1].map(|index| shard(place.path(), index, 2, 0));
        let out = place.path().join("merged");
        merge(&parts, &out, &METRICS).expect("all shards");
        let run = Run::load(&out).expect("a run");
        assert_eq!(run.cases.len(), 2);
        for (case, value) in run.cases.iter().zip([1.0, 2.0]) {
            assert_eq!(case.outcome, Outcome::Ok);
            assert_eq!(case.value("cost_ms"), Some(value));
        }
        assert_eq!(run.plan.shard, None);
        assert!(out.join("images/1.png").exists() && out.join("images/2.png").exists());
    }

    #[test]
    fn missing_doubled_and_other_shards_are_refused() {
        let place = tempfile::tempdir().expect("a folder");
        let one = shard(place.path(), 1, 2, 0);
        let two = shard(place.path(), 2, 2, 0);
        let third = shard(place.path(), 2, 3, 0);
        let seeded = shard(place.path(), 2, 2, 9);
        let out = place.path().join("merged");
        let refused = |parts: &[&PathBuf]| {
            let parts: Vec<PathBuf> = parts.iter().copied().cloned().collect();
            let error = merge(&parts, &out, &METRICS).expect_err("refused");
            assert!(!out.exists(), "nothing is written");
            error.to_string()
        };
        assert!(refused(&[&two]).contains("shards 1 of 2 are missing"));
        assert!(refused(&[&one, &one]).contains("shard 1/2: found in"));
        assert!(refused(&[&one, &third]).contains("shard 2/3, expected one of 2"));
        assert!(refused(&[&one, &seeded]).contains("seed"));
        // Shared among the shards in another way, and a case that both have.
        let edited = |name: &str, files: &[&str], from: &str, to: &str| {
            let path = shard(&place.path().join(name), 2, 2, 0);
            for file in files.iter().map(|file| path.join(file)) {
                let text = std::fs::read_to_string(&file).expect("readable");
                assert!(text.contains(from), "{text}");
                std::fs::write(&file, text.replace(from, to)).expect("written");
            }
            path
        };
        let (from, to) = ("\"shard=2/2\"", "\"shard=2/2\", \"shard-by=hash\"");
        let otherwise = edited("otherwise", &["environment.json"], from, to);
        assert!(refused(&[&one, &otherwise]).contains("shard-by=hash"));
        let files = ["plan.json", "cases.csv", "measurements.csv"];
        let doubled = edited("doubled", &files, "case-2", "case-1");
        assert!(refused(&[&one, &doubled]).contains("\"s/case-1\" is in more than one shard"));
        assert!(refused(&[]).contains("no run to merge"));
        let parts = [one.clone(), two];
        assert!(matches!(
            merge(&parts, &out, &[]),
            Err(MergeError::UnknownMetric { .. })
        ));
        std::fs::remove_dir_all(parts[1].join("images")).expect("there");
        merge(&parts, &out, &METRICS).expect("all shards");
        assert!(matches!(
            merge(&[out], &one, &METRICS),
            Err(MergeError::NoShard { .. })
        ));
    }
}
