// SPDX-License-Identifier: MIT OR Apache-2.0
//! What devices draw shadows on: the casters, and the sea as rings about the foot of the eye.

use crate::positions::{Positions, count};
use crate::reference::SEA_RADIUS_M;
use crate::view::DeckCamera;
use glam::DVec3;
use std::iter::successors;
use terrafill_casters::Mesh;
use terrafill_surface::{HeightRange, SurfaceFrame};

/// Between meridians of the sea's patch, degrees.
const SECTOR_DEG: f64 = 1.0;
/// Radius of a ring of the patch over that of the one before. At 5 km a facet is 5 mm below the sphere, a
/// ten-thousandth of a pixel.
const RING_RATIO: f64 = 1.1;

/// Nearest that the sea is looked for, of the eye's height.
const NEAREST_SHARE: f64 = 1e-3;

/// Sea and casters from the eye.
pub fn surface(positions: Positions, view: &DeckCamera, mesh: &Mesh) -> SurfaceFrame {
    let (sea, sea_triangles) = sea(view);
    let all = mesh.vertices.iter().chain(&sea);
    let vertices = all.map(|place| positions.relative(*place, view.eye).to_array());
    let first = count(mesh.vertices.len());
    let of_sea = sea_triangles
        .into_iter()
        .map(|corners| corners.map(|corner| corner + first));
    SurfaceFrame {
        vertices_rte: vertices.collect(),
        triangles: mesh.triangles.iter().copied().chain(of_sea).collect(),
        heights: HeightRange {
            lowest_m: 0.0,
            highest_m: 0.0,
        },
        parts: [].into(),
        shown: None,
    }
}

/// The sea in sight, as rings about the foot of the eye, which itself is out of sight.
fn sea(view: &DeckCamera) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let centre = DVec3::NEG_Z * SEA_RADIUS_M;
    let up = (view.eye - centre).normalize();
    let height_m = (view.eye - centre).length() - SEA_RADIUS_M;
    let ahead = (view.forward - up * up.dot(view.forward)).normalize();
    let right = ahead.cross(up);
    let horizon_m = (2.0 * SEA_RADIUS_M * height_m).sqrt();
    let farther = |last: &f64| (*last < 1.2 * horizon_m).then_some(last * RING_RATIO);
    // The lower corners see nearest and, of a camera that looks down, farthest aside.
    let corner = view.towards(1.0, -1.0);
    let [along, aside] = [ahead, right].map(|axis| corner.dot(axis));
    let nearest_m = height_m * along / -corner.dot(up).min(-f64::EPSILON);
    let first_m = 0.5 * nearest_m.clamp(NEAREST_SHARE * height_m, height_m);
    let away_m: Vec<f64> = successors(Some(first_m), farther).collect();
    let half_deg = aside.atan2(along).to_degrees() + SECTOR_DEG;
    let next = |last: &f64| (*last < half_deg).then_some(last + SECTOR_DEG);
    let azimuths_deg: Vec<f64> = successors(Some(-half_deg), next).collect();
    let mut places = Vec::with_capacity(away_m.len() * azimuths_deg.len());
    for away in &away_m {
        let (sin, cos) = (away / SEA_RADIUS_M).sin_cos();
        for azimuth in &azimuths_deg {
            let (aside, along) = azimuth.to_radians().sin_cos();
            let direction = up * cos + (ahead * along + right * aside) * sin;
            places.push(centre + direction * SEA_RADIUS_M);
        }
    }
    let [columns, rings] = [azimuths_deg.len(), away_m.len()].map(count);
    let mut triangles = Vec::new();
    for ring in 1..rings {
        for column in 1..columns {
            let [near, far] = [ring - 1, ring].map(|ring| ring * columns + column);
            triangles.push([near - 1, near, far]);
            triangles.push([near - 1, far, far - 1]);
        }
    }
    (places, triangles)
}
