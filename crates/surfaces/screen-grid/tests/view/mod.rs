// SPDX-License-Identifier: MIT OR Apache-2.0
//! A view of a grid, met by a ray through each pixel, in `f64`.

use glam::DVec3;
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_scene::{Camera, CameraPose, ImageSize};
use terrafill_screen_grid::{GridOptions, Limb, Rays, ScreenMesh};

/// The sphere that the expectations are computed on.
pub(crate) fn sphere() -> Ellipsoid {
    Ellipsoid::new("sphere", 6_378_137.0, 6_378_137.0).expect("a body")
}

/// Longitude, latitude, height, heading, pitch, in degrees and metres; 60° of view.
pub(crate) fn camera(
    body: &Ellipsoid,
    [longitude, latitude, height_m, heading, pitch]: [f64; 5],
) -> Camera {
    Camera::new(
        body,
        &CameraPose {
            eye: Geodetic::from_degrees(longitude, latitude, height_m),
            heading_rad: heading.to_radians(),
            pitch_rad: pitch.to_radians(),
            fov_y_rad: 60_f64.to_radians(),
            near_m: height_m * 1e-6,
        },
    )
}

pub(crate) fn square(side: u32) -> ImageSize {
    ImageSize::new(side, side)
}

pub(crate) fn grid(cells: u32) -> GridOptions {
    GridOptions {
        cells,
        limb: Limb::Snap,
        rays: Rays::F64,
    }
}

/// Where the ray of a direction meets the body, from the eye; exact but for rounding.
pub(crate) fn true_hit(body: &Ellipsoid, eye: DVec3, direction: DVec3) -> Option<DVec3> {
    let (d, c) = (direction / body.radii_m(), eye / body.radii_m());
    let (dd, b, k) = (d.dot(d), d.dot(c), c.dot(c) - 1.0);
    let under_root = b * b - dd * k;
    (b < 0.0 && under_root >= 0.0).then(|| direction * (k / (under_root.sqrt() - b)))
}

/// What a pixel shows of a mesh: the triangle, and weights of its corners.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen {
    pub(crate) triangle: usize,
    pub(crate) weights: [f64; 3],
    pub(crate) depth: f64,
}

/// Weights of a triangle's corners where a ray from the eye meets its plane, and the depth there.
pub(crate) fn weights(corners: [DVec3; 3], direction: DVec3) -> ([f64; 3], f64) {
    let [a, b, c] = corners;
    let sides = [b.cross(c), c.cross(a), a.cross(b)].map(|side| side.dot(direction));
    let sum: f64 = sides.iter().sum();
    let weights = sides.map(|side| side / sum);
    let at = a * weights[0] + b * weights[1] + c * weights[2];
    (weights, at.dot(direction) / direction.length_squared())
}

pub(crate) fn corners(mesh: &ScreenMesh, triangle: usize) -> [DVec3; 3] {
    mesh.triangles[triangle].map(|i| mesh.vertices_rte[i as usize])
}

/// The nearest triangle at each pixel's centre, row by row.
#[allow(clippy::cast_possible_truncation, reason = "pixels of a picture")]
pub(crate) fn seen(camera: &Camera, size: ImageSize, mesh: &ScreenMesh) -> Vec<Option<Seen>> {
    let mut pixels: Vec<Option<Seen>> = vec![None; size.pixel_count()];
    for triangle in 0..mesh.triangles.len() {
        let corners = corners(mesh, triangle);
        let places = corners.map(|corner| camera.project_px(size, camera.eye_ecef + corner));
        let [Some(p), Some(q), Some(r)] = places else {
            continue;
        };
        let span = |axis: usize, end: u32| {
            let all = [p[axis], q[axis], r[axis]];
            let low = all.into_iter().fold(f64::INFINITY, f64::min).floor() - 1.0;
            let high = all.into_iter().fold(f64::NEG_INFINITY, f64::max).ceil() + 1.0;
            low.clamp(0.0, f64::from(end)) as u32..high.clamp(0.0, f64::from(end)) as u32
        };
        for row in span(1, size.height) {
            for column in span(0, size.width) {
                let direction = camera.pixel_direction_ecef(size, column, row);
                let (weights, depth) = weights(corners, direction);
                let pixel = &mut pixels[(row * size.width + column) as usize];
                // Neighbours round a shared edge differently.
                let is_met = weights.iter().all(|&weight| weight >= -1e-12);
                if is_met && pixel.is_none_or(|seen| depth < seen.depth) {
                    *pixel = Some(Seen {
                        triangle,
                        weights,
                        depth,
                    });
                }
            }
        }
    }
    pixels
}

/// Column and row of a pixel by its number.
pub(crate) fn pixel(size: ImageSize, i: usize) -> [u32; 2] {
    let i = u32::try_from(i).expect("a small picture");
    [i % size.width, i / size.width]
}

/// Median, 99th percentile and maximum.
#[allow(clippy::cast_possible_truncation, reason = "a place in a list")]
pub(crate) fn spread(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[((values.len() - 1) as f64 * share) as usize];
    [at(0.5), at(0.99), at(1.0)]
}
