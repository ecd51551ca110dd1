// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files of regions, read and meshed: every problem of a file at once.

use crate::input::{is_standard, read_standard_input, shown};
use crate::outcome::{Failure, complain};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use terrafill_core::{
    EdgeRule, Ellipsoid, MeshError, MeshOptions, Reading, Region, RegionFile, RegionFileError,
    RegionMesh, RegionWarning, Repair, Unwrap, WarningSubject, printable, read_region_file,
};
use terrafill_scene::{RegionLoadError, load_regions};

/// What to do about features that are wrong.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leniency {
    /// Make this of crossing rings instead of refusing them.
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
    let reading = reading.of_edges(rule);
    let (read, mut problems) = read(path, reading)?;
    let RegionFile {
        mut regions,
        warnings,
    } = read;
    let mesh = |regions: &[Region]| match leniency.repair {
        None => RegionMesh::build_all(regions, body, rule, options),
        Some(repair) => {
            let mut repaired = regions.to_vec();
            for region in &mut repaired {
                region.repair(repair, rule);
            }
            RegionMesh::build_all(&repaired, body, rule, options)
        }
    };
    let mut meshes = mesh(&regions);
    if let Err(errors) = &meshes {
        let remedies = Remedies {
            path,
            reading,
            repair: leniency.repair,
            regions: &regions,
            mesh: &|region: &Region| RegionMesh::build(region, body, rule, options).ok(),
            rule,
        };
        problems.extend(remedies.describe_all(errors));
        if leniency.skip_invalid {
            let wrong: BTreeSet<usize> = errors.iter().filter_map(MeshError::feature).collect();
            regions.retain(|region| !wrong.contains(&region.index));
            meshes = mesh(&regions);
        }
    }
    match meshes {
        Ok(meshes) if problems.is_empty() || (leniency.skip_invalid && !meshes.is_empty()) => {
            for region in &mut regions {
                region.repaired = leniency.repair;
            }
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

/// Regions of which every switch is tried before one is named: each is meshed once more for each.
const MAX_TRIED: usize = 8;

/// Finds the switches that mend the regions that cannot be meshed.
struct Remedies<'a> {
    path: &'a Path,
    reading: Reading,
    repair: Option<Repair>,
    regions: &'a [Region],
    mesh: &'a dyn Fn(&Region) -> Option<RegionMesh>,
    rule: EdgeRule,
}

impl Remedies<'_> {
    fn describe_all(&self, errors: &[MeshError]) -> Vec<FeatureProblem> {
        let mut known: BTreeMap<usize, String> = BTreeMap::new();
        let described = errors.iter().map(|error| {
            let remedy = match error.feature() {
                Some(feature) if known.len() < MAX_TRIED || known.contains_key(&feature) => known
                    .entry(feature)
                    .or_insert_with(|| self.remedy(feature, error))
                    .clone(),
                _ => String::new(),
            };
            let place = error.place();
            FeatureProblem {
                feature: error.feature(),
                ring: place.map(|place| place.ring),
                vertex: place.map(|place| place.vertex),
                message: format!("{}: {error}{remedy}", shown(self.path)),
            }
        });
        described.collect()
    }

    /// The switches that mend a region, and the area that each of them makes of it.
    fn remedy(&self, feature: usize, error: &MeshError) -> String {
        let is_of_rings = match error {
            MeshError::SelfCrossing { .. }
            | MeshError::Overlap { .. }
            | MeshError::MoreCrossings { .. } => self.repair.is_none(),
            MeshError::NoArea { .. } => false,
            _ => return String::new(),
        };
        let of_feature = self.regions.iter().find(|region| region.index == feature);
        let Some(region) = of_feature else {
            return String::new();
        };
        if let Some(area_m2) = self.shorter_area_m2(region) {
            return format!("; --unwrap shortest takes the shorter way: {area_m2:.3e} m²");
        }
        if !is_of_rings {
            return String::new();
        }
        let tried = Repair::ALL.into_iter().filter_map(|repair| {
            let mut repaired = region.clone();
            repaired.repair(repair, self.rule);
            let mesh = (self.mesh)(&repaired)?;
            Some((repair, mesh.area_m2))
        });
        let mut makes: Vec<(Repair, f64)> = Vec::new();
        for (repair, area_m2) in tried {
            let is_same = |(_, known): &(Repair, f64)| (known - area_m2).abs() <= 1e-9 * area_m2;
            if !makes.iter().any(is_same) {
                makes.push((repair, area_m2));
            }
        }
        let makes = makes.iter().map(|(repair, area_m2)| {
            format!("--repair {} makes it {area_m2:.3e} m²", repair.name())
        });
        let makes: Vec<String> = makes.collect();
        if makes.is_empty() {
            String::new()
        } else {
            format!("; {}", makes.join(", "))
        }
    }

    /// Area of a region whose edges over more than 180° go the shorter way, if that can be meshed.
    fn shorter_area_m2(&self, region: &Region) -> Option<f64> {
        let may_be_shorter = region.long_edge_count() > 0
            && self.rule == EdgeRule::Planar
            && self.reading.unwrap != Unwrap::Shortest
            && !is_standard(self.path);
        let reading = Reading {
            unwrap: Unwrap::Shortest,
            ..self.reading
        };
        let (read, _) = may_be_shorter.then(|| read(self.path, reading).ok())??;
        let shorter = read.regions.iter();
        let mut shorter = shorter.filter(|shorter| shorter.index == region.index);
        Some((self.mesh)(shorter.next()?)?.area_m2)
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

/// Says on standard error what `mesh` says below each region of repairs and other things, a line each.
///
/// - `subjects`: of the warnings, which
pub(crate) fn report_regions(meshes: &[RegionMesh], subjects: &[WarningSubject]) {
    for mesh in meshes {
        let number = format!("feature {}", mesh.region_index);
        let label = if mesh.name.is_empty() || mesh.name == number {
            number
        } else {
            format!("{number} ({})", printable(&mesh.name))
        };
        let is_shown = |warning: &&RegionWarning| subjects.contains(&warning.subject);
        for RegionWarning { subject, text } in mesh.warnings.iter().filter(is_shown) {
            let kind = match subject {
                WarningSubject::Repair => "repaired",
                _ => "warning",
            };
            complain(format!("{kind}: {label}: {}", printable(text)));
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
