// SPDX-License-Identifier: MIT OR Apache-2.0
//! Views in which all ground is one region's: its boundary is not in view, so that no volume needs to be counted.
//!
//! Take an ellipsoid below all ground, and let the sight of all four corners of the image meet it. Then all rays in
//! between do, and there is no sky in view. A way leads from any place of the ground in view
//! to any other: down the ray to the ellipsoid, over it along a line of the image, up the other ray. It lies in the view frustum, no
//! deeper than the ellipsoid and no higher than the ground. Where it leaves the region it meets a wall that reaches
//! that far. So where all walls lie outside the frustum, all ground in view is the region's or none is, and one place
//! tells which.

use crate::left_out::LeftOutReason;
use crate::parts::{MeshParts, edges_in};
use crate::pixel_rect::PixelRect;
use crate::plan::{DrawnAs, FramePlan, LeftOutRegion, PlacedMesh, PlanView, PlannedRegion};
use glam::DVec3;
use terrafill_core::{Ellipsoid, RegionMesh, VolumeHeights};

impl FramePlan {
    /// Says which region has all ground in view, if that is certain of one. All others are left out, as is a region
    /// around the image that has none of it. For regions that do not overlap.
    ///
    /// - cost: nothing where a corner shows the sky. Else, for regions around the image, O(parts), and O(edges) of
    ///   those near it; without parts O(edges). Then O(triangles) of one region
    pub(crate) fn settle_interior<'m>(
        &mut self,
        view: PlanView<'_>,
        placed: impl Fn(usize) -> Option<PlacedMesh<'m>>,
    ) {
        let whole = PixelRect::full(view.size);
        let is_around = |planned: &PlannedRegion| planned.screen_rect == whole;
        if !self.regions.iter().any(is_around) {
            return;
        }
        let Some(ground) = Ground::of(view) else {
            return;
        };
        let has_all = |planned: &PlannedRegion| {
            if !is_around(planned) {
                return None;
            }
            let PlacedMesh { mesh, parts } = placed(planned.mesh)?;
            let is_away = ground.leaves_walls_outside(view.body, mesh, parts, planned.heights);
            is_away.then(|| ground.is_in(mesh))
        };
        let found: Vec<Option<bool>> = self.regions.iter().map(has_all).collect();
        let owner = found.iter().position(|has_all| *has_all == Some(true));
        let planned = std::mem::take(&mut self.regions).into_iter().zip(found);
        for (place, (mut planned, has_all)) in planned.enumerate() {
            let has_none = match owner {
                Some(owner) => owner != place,
                None => has_all == Some(false),
            };
            if has_none {
                self.seen_parts.remove(&planned.mesh);
                self.left_out.push(LeftOutRegion {
                    mesh: planned.region,
                    reason: LeftOutReason::OutsideFrustum,
                });
                continue;
            }
            if owner.is_some() {
                self.seen_parts.remove(&planned.mesh);
                planned.drawn_as = DrawnAs::Ground;
            }
            self.regions.push(planned);
        }
        self.left_out.sort_by_key(|region| region.mesh);
    }
}

/// Ground that fills the image.
struct Ground {
    eye_ecef: DVec3,
    /// [`Camera::side_planes_ecef`].
    side_planes_ecef: [DVec3; 5],
    /// Least height above the body's ellipsoid of the one below all ground, metres.
    lowest_m: f64,
    /// A place of the ellipsoid below the middle of the image.
    middle_ecef: DVec3,
}

impl Ground {
    /// `None` where a corner of the image may show the sky.
    fn of(view: PlanView<'_>) -> Option<Self> {
        let PlanView { body, camera, .. } = view;
        // An ellipsoid below all ground: shrinking the axes by δ moves the surface by δ · b / a at least and δ at most.
        let flattening = body.equatorial_radius_m() / body.polar_radius_m();
        let shrink_m = (-view.terrain.lowest_m).max(0.0) * flattening;
        let axes_m = body.radii_m() - DVec3::splat(shrink_m);
        if axes_m.min_element() <= 0.0 {
            return None;
        }
        let eye = camera.eye_ecef / axes_m;
        let tangent_squared = eye.length_squared() - 1.0;
        // Where a ray meets it, in the space where it is the unit sphere.
        let hit = |place_px: [f64; 2]| {
            let ray = (camera.direction_ecef(view.size, place_px) / axes_m).normalize();
            let along = -eye.dot(ray);
            let discriminant = along * along - tangent_squared;
            let meets = tangent_squared > 0.0 && along > 0.0 && discriminant > 0.0;
            meets.then(|| eye + ray * (tangent_squared / (along + discriminant.sqrt())))
        };
        let [width, height] = [view.size.width, view.size.height].map(f64::from);
        let corners = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]];
        if !corners.into_iter().all(|corner| hit(corner).is_some()) {
            return None;
        }
        let middle = hit([0.5 * width, 0.5 * height])?;
        let below = body.ecef_to_geodetic(middle * axes_m);
        let middle_ecef = body.geodetic_to_ecef(terrafill_core::Geodetic {
            height_m: 0.0,
            ..below
        });
        Some(Self {
            eye_ecef: camera.eye_ecef,
            side_planes_ecef: camera.side_planes_ecef(view.size, 0.0),
            lowest_m: -shrink_m,
            middle_ecef,
        })
    }

    fn is_outside(&self, corners_ecef: &[DVec3]) -> bool {
        let is_beyond = |plane: &DVec3| {
            let mut corners = corners_ecef.iter();
            corners.all(|&corner| (corner - self.eye_ecef).dot(*plane) < 0.0)
        };
        self.side_planes_ecef.iter().any(is_beyond)
    }

    /// Whether no wall of `mesh` reaches into the view frustum.
    ///
    /// - `heights`: of its volume, which holds the ground
    fn leaves_walls_outside(
        &self,
        body: &Ellipsoid,
        mesh: &RegionMesh,
        parts: Option<&MeshParts>,
        heights: VolumeHeights,
    ) -> bool {
        let heights = VolumeHeights {
            bottom_m: heights.bottom_m.min(self.lowest_m),
            ..heights
        };
        let radii_m = body.radii_m();
        let per_axis = (radii_m * radii_m).recip();
        let post = |vertex: u32| {
            let vertex = mesh.vertices_ecef[vertex as usize];
            let up = (vertex * per_axis).normalize();
            [heights.bottom_m, heights.top_m].map(|height_m| vertex + up * height_m)
        };
        let is_away = |edge: [u32; 2]| self.is_outside(edge.map(post).as_flattened());
        let Some(parts) = parts else {
            return mesh.boundary_edges().all(is_away);
        };
        parts.boxes(heights).all(|(_, walls, around)| {
            walls.is_empty()
                || self.is_outside(&around.corners_ecef())
                || edges_in(mesh, walls).all(is_away)
        })
    }

    /// Whether the place below the image's middle is the region's, in whose facets' cones it then lies.
    fn is_in(&self, mesh: &RegionMesh) -> bool {
        mesh.triangles.iter().any(|facet| {
            let [a, b, c] = facet.map(|vertex| mesh.vertices_ecef[vertex as usize]);
            let place = self.middle_ecef;
            place.dot(a) > 0.0
                && [(a, b), (b, c), (c, a)]
                    .into_iter()
                    .all(|(from, to)| from.cross(to).dot(place) >= 0.0)
        })
    }
}
