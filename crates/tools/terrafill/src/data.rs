// SPDX-License-Identifier: MIT OR Apache-2.0
//! `data`: the sets that scenes need, and how they get here.

use crate::arguments::{DataArguments, DataVerb};
use crate::outcome::{Failure, Outcome, print, print_json};
use crate::progress::Said;
use std::path::{Path, PathBuf};
use terrafill_data::{Catalogue, DataSet, Listing, Mirror, Plan, grouped, ready_scenes};
use terrafill_scene::{
    DATA_DIR_VARIABLE, DEFAULT_DATA_DIR, data_dir, joined_data_dirs, shipped_scene_needs,
    split_data_dirs,
};
use terrafill_study::Progress as _;

pub(crate) fn run(arguments: &DataArguments) -> Result<Outcome, Failure> {
    match &arguments.verb {
        DataVerb::List { json, data } => list(*json, data.as_deref()),
        DataVerb::Get { names, to, from } => get(names, to.as_deref(), from.as_ref()),
    }
}

/// The data folder, which need not be there yet; of several the first.
fn folder(given: Option<&Path>) -> PathBuf {
    let data = data_dir(given).unwrap_or_else(|| DEFAULT_DATA_DIR.into());
    split_data_dirs(&data).swap_remove(0)
}

/// The data folders of every verb that opens scenes, as one path.
///
/// - `given`: the first that has a file wins
pub(crate) fn data_dirs(given: &[PathBuf]) -> Result<Option<PathBuf>, Failure> {
    let joined = joined_data_dirs(given).map_err(|error| {
        let found: Vec<String> = given.iter().map(|path| path.display().to_string()).collect();
        let found = found.join(", ");
        Failure::bad_input(format!("--data: found {found}, allowed: one folder, or several whose names can be told apart: {error}"))
    })?;
    Ok(data_dir(joined.as_deref()))
}

fn list(json: bool, data: Option<&Path>) -> Result<Outcome, Failure> {
    let catalogue = Catalogue::shipped().map_err(Failure::bad_input)?;
    let needs = shipped_scene_needs().map_err(Failure::bad_input)?;
    let listing = Listing::new(&catalogue, &folder(data), &needs);
    if json {
        print_json(&listing)?;
    } else {
        print(listing.text())?;
    }
    Ok(Outcome::Done)
}

fn get(names: &[String], to: Option<&Path>, from: Option<&Mirror>) -> Result<Outcome, Failure> {
    let catalogue = Catalogue::shipped().map_err(Failure::bad_input)?;
    let folder = folder(to);
    let mut sets: Vec<&DataSet> = all(names.iter().map(|name| catalogue.find(name)))?;
    let mut seen = Vec::new();
    sets.retain(|set| {
        !seen.contains(&&set.name) && {
            seen.push(&set.name);
            true
        }
    });
    let plans = all(sets.iter().map(|set| Plan::new(set, &folder, from)))?;
    print(announcement(&plans, &folder))?;
    let mut problems = Vec::new();
    for plan in &plans {
        let name = &plan.set().name;
        let mut said = Said::titled(name.clone());
        let bytes = |bytes: u64| usize::try_from(bytes).unwrap_or(usize::MAX);
        let all = bytes(plan.set().bytes);
        let done = plan.carry_out(&mut |arrived| said.step(bytes(arrived), all, "bytes"));
        drop(said);
        match done {
            Ok(()) => {
                let paths = plan.paths();
                let paths: Vec<String> = paths.iter().map(|it| it.display().to_string()).collect();
                print(format!("{name}: {}\n", paths.join(", ")))?;
            }
            Err(error) => problems.push(format!("{name}: {error}")),
        }
    }
    if !problems.is_empty() {
        return Err(Failure::bad_input(problems.join("\n")));
    }
    let needs = shipped_scene_needs().map_err(Failure::bad_input)?;
    let ready = ready_scenes(&sets, &folder, &needs);
    if !ready.is_empty() {
        print(format!(
            "scenes that have all their data: {}\n",
            ready.join(", ")
        ))?;
    }
    let found = data_dir(None).map(|data| split_data_dirs(&data));
    if !found.is_some_and(|found| found.contains(&folder)) {
        let folder = folder.display();
        print(format!(
            "other verbs find it by --data {folder}, or {DATA_DIR_VARIABLE}={folder}\n"
        ))?;
    }
    Ok(Outcome::Done)
}

/// Everything, or a line for each problem.
fn all<T, E: std::fmt::Display>(
    results: impl Iterator<Item = Result<T, E>>,
) -> Result<Vec<T>, Failure> {
    let mut right = Vec::new();
    let mut problems = Vec::new();
    for result in results {
        match result {
            Ok(value) => right.push(value),
            Err(error) => problems.push(error.to_string()),
        }
    }
    if problems.is_empty() {
        return Ok(right);
    }
    Err(Failure::bad_input(problems.join("\n")))
}

/// What it will take, before anything is done.
fn announcement(plans: &[Plan<'_>], folder: &Path) -> String {
    let mut text = String::new();
    for plan in plans {
        let name = &plan.set().name;
        text += &match plan.fetch_bytes() {
            0 => format!("{name}: nothing to fetch\n"),
            bytes => format!("{name}: {} bytes from {}\n", grouped(bytes), plan.url()),
        };
    }
    let fetch: u64 = plans.iter().map(Plan::fetch_bytes).sum();
    let write: u64 = plans.iter().map(Plan::write_bytes).sum();
    text += &format!(
        "to fetch {} bytes, to write {} bytes into {}\n",
        grouped(fetch),
        grouped(write),
        folder.display()
    );
    text
}
