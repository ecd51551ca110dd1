// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files of regions, read and meshed: every problem of a file at once.

use crate::arguments::Repair;
use crate::outcome::Failure;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::Path;
use terrafill_core::{EdgeRule, Ellipsoid, MeshError, MeshOptions, Reading, Region, RegionMesh};
use terrafill_scene::{RegionLoadError, load_regions};

/// What to do about features that are wrong.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leniency {
    /// Fill crossing rings by this rule instead of refusing them.
    pub(crate) repair: Option<Repair>,
    /// Go on with the features that are right.
    pub(crate) skip_invalid: bool,
}

/// A feature's problem and its place in the file.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct FeatureProblem {
    pub(crate) feature: Option<usize>,
    pub(crate) ring: Option<usize>,
    pub(crate) vertex: Option<usize>,
    /// The whole line: file, place, value found and value allowed.
    pub(crate) message: String,
}

/// Regions as the file has them, and their meshes, in the same order.
pub(crate) struct Meshed {
    pub(crate) regions: Vec<Region>,
    pub(crate) meshes: Vec<RegionMesh>,
    /// Features that were left out, by `--skip-invalid` only.
    pub(crate) skipped: Vec<FeatureProblem>,
}

/// Reads and meshes a file, its crossings repaired if asked for.
///
/// A file in which anything is wrong gives nothing but the list of what is, so that no one takes
/// the rest of a map for the map; unless that was asked for.
pub(crate) fn read_and_mesh(
    path: &Path,
    reading: Reading,
    leniency: Leniency,
    body: &Ellipsoid,
    rule: EdgeRule,
    options: &MeshOptions,
) -> Result<Meshed, Failure> {
    options.check().map_err(wrong_option)?;
    let (mut regions, mut problems) = read(path, reading)?;
    let mesh = |regions: &[Region]| match leniency.repair {
        None => RegionMesh::build_all(regions, body, rule, options),
        Some(Repair::EvenOdd) => {
            let mut repaired = regions.to_vec();
            for region in &mut repaired {
                region.split_at_crossings(rule);
            }
            RegionMesh::build_all(&repaired, body, rule, options)
        }
    };
    let mut meshes = mesh(&regions);
    if let Err(errors) = &meshes {
        problems.extend(errors.iter().map(|e| describe(path, leniency.repair, e)));
        if leniency.skip_invalid {
            let wrong: BTreeSet<usize> = errors.iter().filter_map(MeshError::feature).collect();
            regions.retain(|region| !wrong.contains(&region.index));
            meshes = mesh(&regions);
        }
    }
    match meshes {
        Ok(meshes) if problems.is_empty() || (leniency.skip_invalid && !meshes.is_empty()) => {
            Ok(Meshed {
                regions,
                meshes,
                skipped: problems,
            })
        }
        _ => {
            let lines: Vec<String> = problems.into_iter().map(|p| p.message).collect();
            Err(Failure::bad_input(lines.join("\n")))
        }
    }
}

/// The features that can be read, and what is wrong with the others.
fn read(path: &Path, reading: Reading) -> Result<(Vec<Region>, Vec<FeatureProblem>), Failure> {
    match load_regions(path, reading) {
        Ok(regions) => Ok((regions, Vec::new())),
        Err(RegionLoadError::Invalid(error)) => {
            let problems = error.problems.iter().map(|problem| FeatureProblem {
                feature: problem.feature,
                ring: problem.ring,
                vertex: problem.vertex,
                message: format!("{}: {problem}", path.display()),
            });
            Ok((error.readable.clone(), problems.collect()))
        }
        Err(error) => Err(Failure::bad_input(error)),
    }
}

fn describe(path: &Path, repair: Option<Repair>, error: &MeshError) -> FeatureProblem {
    let remedy = match (error, repair) {
        (MeshError::SelfCrossing { .. } | MeshError::Overlap { .. }, None) => {
            "; --repair even-odd fills by that rule"
        }
        (MeshError::NoArea { long_edges, .. }, _) if *long_edges > 0 => {
            "; --unwrap shortest or --edges great-ellipse takes the shorter way"
        }
        _ => "",
    };
    let place = error.place();
    FeatureProblem {
        feature: error.feature(),
        ring: place.map(|place| place.ring),
        vertex: place.map(|place| place.vertex),
        message: format!("{}: {error}{remedy}", path.display()),
    }
}

/// Says on standard error what was left out, a line each.
pub(crate) fn report_skipped(skipped: &[FeatureProblem]) {
    for problem in skipped {
        eprintln!("skipped: {}", problem.message);
    }
}

/// The option by its name on the command line.
fn wrong_option(error: MeshError) -> Failure {
    match error {
        MeshError::Option {
            option,
            found,
            allowed,
        } => {
            let option = option.replace('_', "-");
            Failure::bad_input(format!("--{option}: found {found}, allowed: {allowed}"))
        }
        other => Failure::bad_input(other),
    }
}
