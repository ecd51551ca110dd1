// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes written down vertex by vertex, for tests of what is made of a mesh. The backends' unit tests
//! include this file by its path.

use std::f64::consts::TAU;
use terrafill_core::{Ellipsoid, Extent, Geodetic, RegionMesh};

/// `count` places on a circle of `radius_deg` about 10° east, 50° north, counter-clockwise.
pub(crate) fn circle_deg(count: u32, radius_deg: f64) -> Vec<[f64; 2]> {
    let place = |i: u32| {
        let angle = f64::from(i) / f64::from(count) * TAU;
        [
            10.0 + radius_deg * angle.cos(),
            50.0 + radius_deg * angle.sin(),
        ]
    };
    (0..count).map(place).collect()
}

/// A mesh of these vertices on WGS 84; loops after the first are holes. Its area, deviation and sagitta
/// are made up.
pub(crate) fn mesh(
    vertices_deg: Vec<[f64; 2]>,
    triangles: Vec<[u32; 3]>,
    boundary_loops: Vec<Vec<u32>>,
) -> RegionMesh {
    let on_ellipsoid = |[longitude, latitude]: &[f64; 2]| {
        Ellipsoid::WGS84.geodetic_to_ecef(Geodetic::from_degrees(*longitude, *latitude, 0.0))
    };
    RegionMesh {
        region_index: 0,
        name: "by hand".to_owned(),
        vertices_ecef: vertices_deg.iter().map(on_ellipsoid).collect(),
        vertices_deg,
        triangles,
        holes: boundary_loops.len().saturating_sub(1),
        boundary_loops,
        area_m2: 1.0,
        extent: Extent {
            west_deg: 9.0,
            south_deg: 49.0,
            east_deg: 11.0,
            north_deg: 51.0,
        },
        boundary_deviation_m: 0.0,
        cap_sagitta_m: 1000.0,
        warnings: Vec::new(),
    }
}
