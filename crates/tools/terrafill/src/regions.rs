// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files of regions, read and meshed: every problem of a file at once.

use crate::arguments::Repair;
use crate::input::{is_standard, read_standard_input, shown};
use crate::outcome::{Failure, complain};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::Path;
use terrafill_core::{
    EdgeRule, Ellipsoid, MeshError, MeshOptions, Reading, Region, RegionFile, RegionFileError,
    RegionMesh, printable, read_region_file,
};
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
    /// About the file as a whole, such as how many features have no area.
    pub(crate) warnings: Vec<String>,
}

/// Reads and meshes a file, or standard input for `-`, its crossings repaired if asked for.
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
    let (read, mut problems) = read(path, reading)?;
    let RegionFile {
        mut regions,
        warnings,
    } = read;
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
                warnings,
            })
        }
        _ => {
            let lines: Vec<String> = problems.into_iter().map(|p| p.message).collect();
            Err(Failure::bad_input(lines.join("\n")))
        }
    }
}

/// The features that can be read, and what is wrong with the others.
fn read(path: &Path, reading: Reading) -> Result<(RegionFile, Vec<FeatureProblem>), Failure> {
    let read = if is_standard(path) {
        let bytes = read_standard_input()?;
        read_region_file(&bytes, &shown(path), reading).map_err(RegionLoadError::Invalid)
    } else {
        load_regions(path, reading)
    };
    match read {
        Ok(read) => Ok((read, Vec::new())),
        Err(RegionLoadError::Invalid(error)) => {
            let problems = error.problems.iter().map(|problem| FeatureProblem {
                feature: problem.feature,
                ring: problem.ring,
                vertex: problem.vertex,
                message: format!("{}: {problem}", shown(path)),
            });
            let problems = problems.collect();
            let RegionFileError {
                readable: regions,
                warnings,
                ..
            } = error;
            Ok((RegionFile { regions, warnings }, problems))
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
        message: format!("{}: {error}{remedy}", shown(path)),
    }
}

/// Says on standard error what was left out, a line each.
pub(crate) fn report_skipped(skipped: &[FeatureProblem]) {
    for problem in skipped {
        complain(format!("skipped: {}", problem.message));
    }
}

/// Says on standard error what is remarkable about the file as a whole.
pub(crate) fn report_warnings(path: &Path, warnings: &[String]) {
    for warning in warnings {
        complain(format!("warning: {}: {}", shown(path), printable(warning)));
    }
}

/// Says on standard error what a repair filled and which sides of rings round a pole were taken, a
/// line each; standard output is a table.
pub(crate) fn report_repairs(meshes: &[RegionMesh]) {
    for mesh in meshes {
        let number = format!("feature {}", mesh.region_index);
        let label = if mesh.name.is_empty() || mesh.name == number {
            number
        } else {
            format!("{number} ({})", printable(&mesh.name))
        };
        let is_repair = |text: &&String| text.ends_with("filled by the even-odd rule");
        for repair in mesh.warnings.iter().filter(is_repair) {
            complain(format!("repaired: {label}: {repair}"));
        }
        // It names its feature and ring itself.
        let is_side = |text: &&String| text.contains("goes round a pole");
        for side in mesh.warnings.iter().filter(is_side) {
            complain(format!("warning: {}", printable(side)));
        }
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
