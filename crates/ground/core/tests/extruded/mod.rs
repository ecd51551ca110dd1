// SPDX-License-Identifier: MIT OR Apache-2.0
//! The volume of a mesh between heights like the Earth's terrain, on a body of any size.

use terrafill_core::{Ellipsoid, RegionMesh, VolumeFault, VolumeHeights, VolumeReport};

/// From 12.8 km below to 9.6 km above on the Earth, the same share of the radius elsewhere.
pub(crate) fn heights(mesh: &RegionMesh, body: &Ellipsoid) -> VolumeHeights {
    let radius_m = body.equatorial_radius_m();
    mesh.volume_heights(-0.002 * radius_m, 0.0015 * radius_m)
}

/// Extrudes a mesh and checks the closed solid.
///
/// # Errors
/// The first fault found.
pub(crate) fn check_extruded(
    mesh: &RegionMesh,
    body: &Ellipsoid,
) -> Result<VolumeReport, VolumeFault> {
    mesh.check_volume_invariants(body, heights(mesh, body))
}
