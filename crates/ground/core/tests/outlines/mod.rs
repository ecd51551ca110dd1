// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions from files of the data folder, and whether meshes are sound.

use terrafill_core::{EdgeRule, Ellipsoid, Region, RegionMesh, parse_regions};
use terrafill_fixtures::{check_extruded, data};

/// How an edge may run.
pub(crate) const RULES: [EdgeRule; 2] = [EdgeRule::Planar, EdgeRule::GreatEllipse];

/// That a mesh and the volume raised from it are what they must be.
#[track_caller]
pub(crate) fn assert_sound(mesh: &RegionMesh, body: &Ellipsoid) {
    let place = (mesh.region_index, &mesh.name);
    assert_eq!(mesh.check_invariants(body), Ok(()), "{place:?}");
    assert_eq!(check_extruded(mesh, body).err(), None, "{place:?}");
}

/// Bytes of an outline file of the data folder.
pub(crate) fn outline(name: &str) -> Vec<u8> {
    data::bytes(&format!("vectors/{name}"))
}

/// The file's regions, split where their rings cross themselves.
pub(crate) fn repaired(name: &str, rule: EdgeRule) -> Vec<Region> {
    let mut regions = parse_regions(&outline(name), name).expect("valid");
    for region in &mut regions {
        region.split_at_crossings(rule);
    }
    regions
}
