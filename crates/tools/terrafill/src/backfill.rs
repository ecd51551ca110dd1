// SPDX-License-Identifier: MIT OR Apache-2.0
//! `history backfill`: builds and measures old commits that a history lacks.
//!
//! One commit after the other, since times are measured. A commit that cannot be built or measured is named,
//! and the others go on. What was stored stays, and a run that was broken off is gone on with: the same
//! command again does the rest.

use crate::arguments::BackfillArguments;
use crate::outcome::{Failure, Outcome, complain, print};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use terrafill_gate::Program;
use terrafill_history::{HistoryError, Record, Repository, Store, clean, quoted};
use terrafill_results::Run;

/// Options of `bench` that are this verb's own.
const OWN: [&str; 4] = ["--out", "--resume", "--shard", "--process"];

pub(crate) fn run(arguments: &BackfillArguments) -> Result<Outcome, Failure> {
    let own = |word: &&String| OWN.iter().any(|own| word.split('=').next() == Some(*own));
    if let Some(word) = arguments.bench.iter().find(own) {
        return Err(Failure::bad_input(format!(
            "{word}: found among the options of bench, allowed: all but {}",
            OWN.join(", ")
        )));
    }
    let Some((from, to)) = arguments.range.split_once("..") else {
        return Err(Failure::bad_input(format!(
            "{:?}: found no range, allowed: FROM..TO, such as v1.0..main",
            arguments.range
        )));
    };
    let to = if to.is_empty() { "HEAD" } else { to };
    let repository = Repository::at(Path::new("."));
    let repository = repository.ok_or_else(|| {
        Failure::bad_input("found no git repository here, needs the one that has the commits")
    })?;
    let commits = repository.between(&repository.commit(from)?, &repository.commit(to)?)?;
    let stored = stored(arguments)?;
    let mut counts = [0; 3];
    for (commit, subject) in &commits {
        let has_run = stored
            .iter()
            .any(|known| commit.starts_with(known.as_str()));
        if has_run {
            counts[1] += 1;
            print(format!("{commit}: is stored already: {subject}\n"))?;
            continue;
        }
        if arguments.dry_run {
            print(commands(arguments, commit, subject))?;
            continue;
        }
        match measure(arguments, commit) {
            Ok(run) => {
                store(arguments, &repository, run)?;
                counts[0] += 1;
                print(format!("{commit}: stored: {subject}\n"))?;
            }
            Err(message) => {
                counts[2] += 1;
                complain(format!("{commit} ({subject}): {message}"));
            }
        }
    }
    if arguments.dry_run {
        return Ok(Outcome::Done);
    }
    let [new, known, failed] = counts;
    print(format!(
        "backfilled: {new} stored, {known} were there already, {failed} failed\n"
    ))?;
    Ok(match (new + known, failed) {
        (_, 0) => Outcome::Done,
        (0, _) => Outcome::NothingMeasured,
        _ => Outcome::Inconclusive,
    })
}

/// Commits that have a run.
fn stored(arguments: &BackfillArguments) -> Result<Vec<String>, Failure> {
    let path = &arguments.store.store;
    if !path.exists() {
        return Ok(Vec::new());
    }
    let overview = Store::open(path)?.overview()?;
    if let Some(machine) = arguments
        .machine
        .filter(|of| !overview.machines.contains_key(of))
    {
        let known: Vec<String> = overview.machines.keys().map(i64::to_string).collect();
        let known = known.join(", ");
        let message = format!("--machine: found {machine}, allowed: {known}");
        return Err(Failure::bad_input(message));
    }
    let runs = overview.runs.iter().filter(|run| {
        run.counts()
            && arguments
                .machine
                .is_none_or(|machine| run.machine == machine)
    });
    Ok(runs.map(|run| clean(&run.commit).to_owned()).collect())
}

fn folder(arguments: &BackfillArguments, commit: &str) -> PathBuf {
    arguments.runs.join(commit)
}

/// Builds a commit and runs its bench.
fn measure(arguments: &BackfillArguments, commit: &str) -> Result<Record, String> {
    let program = Program::find(commit, &arguments.cache).map_err(|error| error.to_string())?;
    let folder = folder(arguments, commit);
    let mut bench = Command::new(&program.path);
    bench.arg("bench").args(&arguments.bench);
    bench.arg("--out").arg(&folder);
    if folder.exists() {
        bench.arg("--resume");
    }
    // Its report is of no use here, and what it complains of is.
    let ended = bench.stdin(Stdio::null()).stdout(Stdio::null()).status();
    let ended = ended.map_err(|error| format!("{}: {error}", program.path.display()))?;
    // 1: some case was wrong, which the history keeps.
    if !matches!(ended.code(), Some(0 | 1)) {
        return Err(format!("bench ended with {ended}"));
    }
    let run = Run::load(&folder).map_err(|error| error.to_string())?;
    let (record, _) = Record::of(&run).map_err(|error| error.to_string())?;
    if !commit.starts_with(&record.commit) {
        return Err(format!(
            "{}: found a run of commit {}, expected {commit}",
            folder.display(),
            record.commit
        ));
    }
    Ok(record)
}

fn store(
    arguments: &BackfillArguments,
    repository: &Repository,
    record: Record,
) -> Result<(), HistoryError> {
    let position = repository.position(&record.commit);
    Store::create_or_open(&arguments.store.store)?.add(&[(record, position)])?;
    Ok(())
}

/// What is done for a commit, to be read or typed.
fn commands(arguments: &BackfillArguments, commit: &str, subject: &str) -> String {
    let path = |path: &Path| quoted(&path.display().to_string());
    let BackfillArguments { cache, store, .. } = arguments;
    let (tree, target) = (path(&cache.join("tree")), path(&cache.join("target")));
    let binary = path(&cache.join("bin").join(commit).join("terrafill"));
    let run = path(&folder(arguments, commit));
    let bench: Vec<String> = arguments.bench.iter().map(|word| quoted(word)).collect();
    let bench = [&["bench".to_owned()][..], &bench].concat().join(" ");
    format!(
        "# {commit} {subject}\n\
         git worktree add --force --detach {tree} {commit}\n\
         cargo build --release --locked --package terrafill --manifest-path {tree}/Cargo.toml \
         --target-dir {target}\n\
         install -D {target}/release/terrafill {binary}\n\
         git worktree remove --force {tree}\n\
         {binary} {bench} --out {run}\n\
         terrafill history add {run} --store {}\n",
        path(&store.store)
    )
}
