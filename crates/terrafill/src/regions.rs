// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files of regions, read and meshed: every problem of a file at once.

use crate::Failure;
use crate::arguments::Repair;
use std::path::Path;
use terrafill_core::{EdgeRule, Ellipsoid, MeshError, MeshOptions, Region, RegionMesh};
use terrafill_scene::{RegionLoadError, load_regions};

/// Regions as the file has them, and their meshes, made with its crossings repaired if asked for.
///
/// A file in which anything is wrong gives nothing but the list of what is, so that no one takes
/// the rest of a map for the map.
pub(crate) fn read_and_mesh(
    path: &Path,
    repair: Option<Repair>,
    body: &Ellipsoid,
    rule: EdgeRule,
    options: &MeshOptions,
) -> Result<(Vec<Region>, Vec<RegionMesh>), Failure> {
    options.check().map_err(wrong_option)?;
    let (regions, mut problems) = match load_regions(path) {
        Ok(regions) => (regions, Vec::new()),
        Err(RegionLoadError::Invalid(error)) => {
            let lines = error.to_string();
            (error.readable, vec![lines])
        }
        Err(error) => return Err(Failure::bad_input(error)),
    };
    let meshes = match repair {
        None => RegionMesh::build_all(&regions, body, rule, options),
        Some(Repair::EvenOdd) => {
            let mut repaired = regions.clone();
            for region in &mut repaired {
                region.split_at_crossings(rule);
            }
            RegionMesh::build_all(&repaired, body, rule, options)
        }
    };
    let meshes = meshes.unwrap_or_else(|errors| {
        problems.extend(errors.iter().map(|error| describe(path, repair, error)));
        Vec::new()
    });
    if problems.is_empty() {
        Ok((regions, meshes))
    } else {
        Err(Failure::bad_input(problems.join("\n")))
    }
}

fn describe(path: &Path, repair: Option<Repair>, error: &MeshError) -> String {
    let remedy = match (error, repair) {
        (MeshError::SelfCrossing { .. }, None) => "; --repair even-odd fills by that rule",
        _ => "",
    };
    format!("{}: {error}{remedy}", path.display())
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
