// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which triangles of a surface a view may show: block by block.
//!
//! A block that looks away from the eye, or lies outside the image, gives no fragment. Of a whole planet seen from
//! orbit that is more than half, and near the ground nearly all.

use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;
use terrafill_scene::{Camera, ImageSize};

/// Sine of the angle by which all triangles of a block must look away. The GPU decides which way a triangle looks by
/// corners rounded to a fraction of a pixel, so that one seen edge-on may look either way there.
const AWAY: f64 = 0.01;
/// By how much the image is wider on each side, share of its half: corners are rounded to `f32`.
const MARGIN: f64 = 1e-3;

/// Triangles that follow one another, and what bounds them.
#[derive(Debug, Clone)]
struct Block {
    /// Of the surface's triangles.
    triangles: Range<u32>,
    center_ecef: DVec3,
    /// No corner is farther from the centre, metres.
    radius_m: f64,
    /// Unit vector, and the angle to it that no triangle's normal exceeds.
    axis: DVec3,
    spread_rad: f64,
    /// The centre is no farther above any triangle's plane, metres; below 0 where it lies below all of them.
    above_m: f64,
}

impl Block {
    /// - `corners`: of its triangles, counter-clockwise seen from outside
    fn new(triangles: Range<u32>, corners: &[[DVec3; 3]]) -> Self {
        let places = || corners.iter().flatten().copied();
        let center_ecef = places().sum::<DVec3>() / places().count().max(1) as f64;
        let normals: Vec<DVec3> = corners
            .iter()
            .map(|[a, b, c]| (*b - *a).cross(*c - *a).normalize_or_zero())
            .collect();
        let axis = normals.iter().sum::<DVec3>().normalize_or_zero();
        let spread_rad = normals.iter().map(|normal| normal.angle_between(axis));
        let above_m = normals
            .iter()
            .zip(corners)
            .map(|(normal, corners)| normal.dot(center_ecef - corners[0]));
        Self {
            triangles,
            center_ecef,
            radius_m: places()
                .map(|place| place.distance(center_ecef))
                .fold(0.0, f64::max),
            axis,
            // What has no area looks nowhere, and its angle is no number.
            spread_rad: spread_rad.fold(0.0, |most: f64, own| {
                if own.is_nan() {
                    f64::INFINITY
                } else {
                    most.max(own)
                }
            }),
            above_m: above_m.fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// Whether `n · (eye − v) < 0` for every triangle's normal `n` and corner `v`. The left side is
    /// `n · (eye − centre)`, which is most for the normal nearest to that direction, and `n · (centre − v)`.
    fn looks_away(&self, eye_ecef: DVec3) -> bool {
        let to_eye = eye_ecef - self.center_ecef;
        let distance_m = to_eye.length();
        let nearest_rad = (to_eye.angle_between(self.axis) - self.spread_rad).max(0.0);
        distance_m * nearest_rad.cos() + self.above_m < -AWAY * (distance_m + self.radius_m)
    }
}

/// The blocks of a surface's triangles, all of them or none.
#[derive(Debug, Clone, Default)]
pub struct SurfaceBlocks(Vec<Block>);

impl SurfaceBlocks {
    /// - `ranges`: of the triangles of each block, one after the other
    /// - cost: O(triangles)
    #[must_use]
    pub fn new(
        ranges: impl IntoIterator<Item = Range<u32>>,
        triangles: &[[u32; 3]],
        vertices_ecef: &[DVec3],
    ) -> Self {
        let block = |range: Range<u32>| {
            let own = &triangles[range.start as usize..range.end as usize];
            let corners: Vec<[DVec3; 3]> = own
                .iter()
                .map(|triangle| triangle.map(|vertex| vertices_ecef[vertex as usize]))
                .collect();
            Block::new(range, &corners)
        };
        Self(ranges.into_iter().map(block).collect())
    }

    /// Ranges of the triangles that the view may show, those that follow one another as one; `None` where there are
    /// no blocks, so that all may be shown.
    ///
    /// - cost: O(blocks)
    #[must_use]
    pub fn shown(&self, camera: &Camera, size: ImageSize) -> Option<Arc<[Range<u32>]>> {
        if self.0.is_empty() {
            return None;
        }
        let planes = camera.side_planes_ecef(size, MARGIN);
        let is_outside = |block: &Block| {
            let from_eye = block.center_ecef - camera.eye_ecef;
            let is_beyond = |plane: &DVec3| plane.dot(from_eye) < -block.radius_m;
            planes.iter().any(is_beyond)
        };
        let mut shown: Vec<Range<u32>> = Vec::new();
        for block in &self.0 {
            if is_outside(block) || block.looks_away(camera.eye_ecef) {
                continue;
            }
            match shown.last_mut() {
                Some(last) if last.end == block.triangles.start => last.end = block.triangles.end,
                _ => shown.push(block.triangles.clone()),
            }
        }
        Some(shown.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SurfaceMesh;
    use terrafill_core::{Ellipsoid, Geodetic};
    use terrafill_scene::CameraPose;

    const SIZE: ImageSize = ImageSize::new(300, 200);

    /// Of these triangles, those that look to the eye and have a corner in the image.
    fn certainly_seen(mesh: &SurfaceMesh, camera: &Camera, among: Range<u32>) -> usize {
        let own = &mesh.triangles[among.start as usize..among.end as usize];
        let is_seen = |triangle: &&[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| mesh.vertices_ecef[vertex as usize]);
            let looks_here = (b - a).cross(c - a).dot(camera.eye_ecef - a) > 0.0;
            let is_inside = |corner| {
                let [x, y] = camera.project_px(SIZE, corner)?;
                Some((0.0..=300.0).contains(&x) && (0.0..=200.0).contains(&y))
            };
            looks_here && [a, b, c].into_iter().any(|at| is_inside(at) == Some(true))
        };
        own.iter().filter(is_seen).count()
    }

    fn camera(body: &Ellipsoid, turn: u32) -> Camera {
        // Places, heights and directions that have nothing to do with one another.
        let share = |step: f64| (f64::from(turn) * step).fract();
        let height_m = 10.0_f64.powf(2.5 + 5.0 * share(0.618));
        Camera::new(
            body,
            &CameraPose {
                eye: Geodetic::from_degrees(
                    360.0 * share(0.7548) - 180.0,
                    180.0 * share(0.5698) - 90.0,
                    height_m,
                ),
                heading_rad: 6.0 * share(0.4142),
                pitch_rad: -1.57 + 1.5 * share(0.7320),
                fov_y_rad: 0.2 + share(0.2360),
                near_m: 1e-3 * height_m,
            },
        )
    }

    /// How many triangles 200 cameras see that are not among those shown, and the share shown.
    fn lost(mesh: &SurfaceMesh, blocks: &SurfaceBlocks) -> (usize, f64) {
        let (mut lost, mut kept) = (0, 0);
        for turn in 0..200 {
            let camera = camera(&mesh.body, turn);
            let shown = blocks.shown(&camera, SIZE).expect("has blocks");
            let whole = 0..u32::try_from(mesh.triangles.len()).expect("few");
            let among: usize = shown
                .iter()
                .map(|range| certainly_seen(mesh, &camera, range.clone()))
                .sum();
            lost += certainly_seen(mesh, &camera, whole) - among;
            kept += shown.iter().map(|range| range.len()).sum::<usize>();
        }
        (lost, kept as f64 / (200 * mesh.triangles.len()) as f64)
    }

    #[test]
    fn what_a_view_shows_is_drawn_and_little_else() {
        for body in [Ellipsoid::WGS84, Ellipsoid::SATURN_LIKE] {
            let rugged = |row: u32, column: u32| f64::from((row * 31 + column * 17) % 7) * 1e4;
            for mesh in [
                SurfaceMesh::ellipsoid(&body, 60),
                SurfaceMesh::grid(&body, 60, rugged),
            ] {
                let (found, share) = lost(&mesh, &mesh.blocks);
                assert_eq!(found, 0);
                assert!(share < 0.3, "{share}");
            }
        }
    }

    #[test]
    fn a_block_that_is_bounded_wrongly_loses_triangles() {
        let mesh = SurfaceMesh::ellipsoid(&Ellipsoid::WGS84, 60);
        let wrong: [fn(&mut Block); 3] = [
            |block| block.radius_m *= 0.3,
            |block| block.axis = -block.axis,
            |block| block.above_m -= block.radius_m,
        ];
        for change in wrong {
            let mut blocks = mesh.blocks.clone();
            blocks.0.iter_mut().for_each(change);
            assert!(lost(&mesh, &blocks).0 > 0);
        }
    }

    #[test]
    fn what_has_no_area_is_never_taken_for_looking_away() {
        let corner = DVec3::new(1.0, 0.0, 0.0);
        let block = Block::new(0..1, &[[corner; 3]]);
        assert!(!block.looks_away(DVec3::ZERO) && !block.looks_away(2.0 * corner));
        // Negative control: with an area it does.
        let corners = [corner, corner + DVec3::Y, corner + DVec3::Z];
        let block = Block::new(0..1, &[corners]);
        assert!(block.looks_away(DVec3::ZERO) && !block.looks_away(2.0 * corner));
    }
}
