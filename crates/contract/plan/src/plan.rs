// SPDX-License-Identifier: MIT OR Apache-2.0
//! The frame plan: what one frame of one scene needs and, by name and reason, what it leaves out.
//!
//! All culls are exact: a region is left out only when no pixel can show it. Every test looks at
//! the corners of a box that holds the region's whole closed volume, so it errs towards drawing.
//!
//! - *Frustum*: all corners outside one plane of the view frustum, which the box then is too.
//! - *Too small*: the box's projection reaches the centre of no pixel.
//! - *Horizon*: all corners in the shadow that the body casts from the eye. The shadow (the cone
//!   of tangents behind the plane of the horizon circle) is convex, so it holds the whole box. The
//!   body here is the largest ellipsoid inside the surface *as drawn*, not the true one. Under
//!   z-fail this is exact only for whole closed volumes (a ray through the planet may enter by one
//!   piece and leave by another). Whole volumes are all that is planned here.
//!
//! Where the image shows sky only, no region is seen: rectangles end at that of the ground.
//!
//! A far level leaves out work instead of regions: a region whose whole volume, terrain and sagging caps
//! included, is lower than the stated pixels is drawn as a flat mesh, its top cap and walls, where they are
//! nearer than the surface. Every point of the mesh is then fewer pixels than that from the point of the
//! surface below it. Only regions wholly before the body's horizon are drawn so: one behind it would look
//! over it by as much.
//!
//! Boundary levels of detail are no cull: they move boundaries, by no more than the stated pixels.

use crate::LevelTable;
use crate::boundary_pieces::SeenPiece;
use crate::ground_rect::ground_rect;
use crate::left_out::LeftOutReason;
use crate::level::DrawnRegion;
use crate::near_plane::{NearPlane, NearRectangle, ViewVolume};
use crate::parts::{MeshParts, SeenParts, grown};
use crate::pixel_rect::{PixelRect, pixel};
use crate::scene_bounds::{RegionBounds, SceneBounds};
use glam::DVec3;
use std::borrow::Borrow;
use std::collections::BTreeMap;
use terrafill_core::{Ellipsoid, OrientedBox, RegionMesh, VolumeHeights};
use terrafill_scene::{Camera, ImageSize};
use terrafill_surface::HeightRange;

/// Caps are moved away from the terrain by at least this many pixels at the eye's distance, so
/// that rounding of depth (2⁻²⁴ of the distance) can never lift terrain through a cap: 1/64 of a
/// pixel at 60° and 1,024 rows is 2⁻¹⁶ of the distance, 256 times that rounding.
pub const CAP_CLEARANCE_PX: f64 = 1.0 / 64.0;

/// Height below which no land lies and above which none does, metres, where nothing closer is known: the
/// Earth's deepest trench is 11 km deep, its highest mountain 9 km high.
pub const GLOBAL_HEIGHT_M: f64 = 12_000.0;

/// Between which heights a region's volume must reach.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WallHeights {
    /// Those of the surface as drawn over the region.
    #[default]
    Region,
    /// Those and [`GLOBAL_HEIGHT_M`] both ways.
    Global,
}

/// Which parts of large regions are left out; see [`crate::MeshParts`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PartCulling {
    /// None.
    #[default]
    Off,
    /// Those outside the view frustum.
    Frustum,
    /// Those, and those hidden by the body: where fragments in front of the surface count.
    All,
}

/// Which parts of planning are switched on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanOptions {
    /// Leave out regions outside the view frustum.
    pub frustum_culling: bool,
    /// Leave out regions hidden by the body.
    pub horizon_culling: bool,
    /// Leave out regions too small to reach the centre of any pixel.
    pub too_small_culling: bool,
    /// Draw boundaries at the coarsest level that moves none of them by more than this many pixels;
    /// `None` draws them as written.
    pub boundary_lod_px: Option<f64>,
    /// Draw regions whose volumes are lower than this many pixels as flat meshes; `None` draws volumes.
    pub far_level_px: Option<f64>,
    /// How far volumes reach.
    pub wall_heights: WallHeights,
    /// Which parts of large regions are left out.
    pub part_culling: PartCulling,
    /// Leave out what of the image shows sky only.
    pub sky_culling: bool,
    /// Draw no volume where all ground in view is certainly one region's; for regions that do not overlap.
    pub interior: bool,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self {
            frustum_culling: true,
            horizon_culling: true,
            too_small_culling: true,
            boundary_lod_px: None,
            far_level_px: None,
            wall_heights: WallHeights::Region,
            part_culling: PartCulling::Off,
            sky_culling: false,
            interior: false,
        }
    }
}

/// A region that is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannedRegion {
    /// Index into the scene's regions: whose colour and id it is.
    pub region: usize,
    /// Index into the scene's meshes: what is drawn for it.
    pub mesh: usize,
    /// Where this view puts the caps.
    pub heights: VolumeHeights,
    /// No pixel of the region lies outside.
    pub screen_rect: PixelRect,
    /// Where the near rectangle lies, seen from the region's volume.
    pub near_rectangle: NearRectangle,
    /// What of it is drawn.
    pub drawn_as: DrawnAs,
}

/// What is drawn of a region.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DrawnAs {
    /// Its volume.
    #[default]
    Volume,
    /// Its top cap and walls: its volume is lower than [`PlanOptions::far_level_px`].
    FlatMesh,
    /// All ground in view, which is its own ([`PlanOptions::interior`]).
    Ground,
}

/// A region that is not drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LeftOutRegion {
    /// Index into the scene's meshes; that of the region at level 0.
    pub mesh: usize,
    /// Why.
    pub reason: LeftOutReason,
}

/// Rings that levels of detail leave out of drawn regions.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SmallRings {
    /// How many.
    pub rings: usize,
    /// All of them together cover no more pixels.
    pub area_px: f64,
}

/// What a frame draws and what it leaves out.
#[derive(Debug, Clone, Default)]
pub struct FramePlan {
    /// In scene order, so that later regions win where they overlap.
    pub regions: Vec<PlannedRegion>,
    /// In scene order.
    pub left_out: Vec<LeftOutRegion>,
    /// Islands and lakes of drawn regions that their levels leave out.
    pub small_rings: SmallRings,
    /// Of meshes that are drawn in parts what is seen of them; all of those that are not here.
    pub seen_parts: BTreeMap<usize, SeenParts>,
    /// No pixel outside shows the surface; the whole image where there is `None`.
    pub ground: Option<PixelRect>,
    /// Pixels of sky left out.
    pub sky_px: u64,
    /// What it was planned by.
    pub options: PlanOptions,
}

/// What a frame is planned for.
#[derive(Debug, Clone, Copy)]
pub struct PlanView<'a> {
    /// What the regions lie on.
    pub body: &'a Ellipsoid,
    /// The eye.
    pub camera: &'a Camera,
    /// The image.
    pub size: ImageSize,
    /// Heights between which the surface lies as drawn.
    pub terrain: HeightRange,
}

/// A mesh whose vertices are where they will be drawn.
#[derive(Debug, Clone, Copy)]
pub struct PlacedMesh<'a> {
    /// All of it.
    pub mesh: &'a RegionMesh,
    /// Its parts, if they are known and several.
    pub parts: Option<&'a MeshParts>,
}

impl FramePlan {
    /// Plans a frame.
    ///
    /// - `meshes`: bounds of every mesh of the scene
    /// - `levels`: which of them is which
    /// - `placed`: a mesh of the scene; of those for which there is `None` bounds decide alone
    #[must_use]
    pub fn new<'m>(
        view: PlanView<'_>,
        meshes: &SceneBounds,
        levels: &LevelTable,
        placed: impl Fn(usize) -> Option<PlacedMesh<'m>>,
        options: PlanOptions,
    ) -> Self {
        let planner = Planner::new(view, options);
        let mut plan = Self {
            options,
            ground: planner.ground,
            sky_px: planner.ground.map_or(0, |ground| {
                PixelRect::full(view.size).area() - ground.area()
            }),
            ..Self::default()
        };
        let regions = 0..levels.region_count(meshes.count());
        meshes.expect(regions.clone());
        for region in regions {
            plan.place(region, planner.examine(region, region, &meshes[region]));
        }
        if let Some(pixels) = options.boundary_lod_px {
            plan.pick_levels(&planner, meshes, levels, pixels);
        }
        if let Some(pixels) = options.far_level_px {
            for planned in &mut plan.regions {
                if planner.is_far(planned, &meshes[planned.mesh], pixels) {
                    planned.drawn_as = DrawnAs::FlatMesh;
                }
            }
        }
        plan.settle_near_plane(view, &placed);
        if options.part_culling != PartCulling::Off {
            plan.cull_parts(&planner, &placed);
        }
        if options.interior {
            plan.settle_interior(view, &placed);
        }
        plan
    }

    /// Draws every region at the coarsest level that moves its boundary by no more than `pixels`.
    fn pick_levels(
        &mut self,
        planner: &Planner<'_>,
        meshes: &SceneBounds,
        levels: &LevelTable,
        pixels: f64,
    ) {
        let whole = |planned: &PlannedRegion| {
            let around = planner.with_clearance(&meshes[planned.mesh]);
            DrawnRegion::new(planned.region, planner.see(&around))
        };
        let drawn: Vec<DrawnRegion> = self.regions.iter().map(whole).collect();
        let look = |region: usize| {
            let VolumeHeights { top_m, bottom_m } = meshes[region].heights;
            // No vertex moves farther from the ellipsoid than that.
            let reach_m = top_m.abs().max(bottom_m.abs()) + planner.clearance_m;
            let Some(pieces) = levels.boundaries.get(region) else {
                return vec![planner.see(&planner.with_clearance(&meshes[region]))];
            };
            let pieces = pieces.iter();
            pieces
                .map(|piece| planner.see(&grown(piece, reach_m)))
                .collect()
        };
        let picked = levels.pick(&drawn, pixels, look);
        meshes.expect(picked.iter().copied());
        for (drawn, &mesh) in drawn.iter().zip(&picked) {
            let (left_out, area_px) = levels.left_out(drawn, mesh);
            self.small_rings.rings += left_out.rings;
            self.small_rings.area_px += area_px;
        }
        for (planned, mesh) in std::mem::take(&mut self.regions).into_iter().zip(picked) {
            let region = planned.region;
            let examined = if mesh == planned.mesh {
                Ok(planned)
            } else {
                planner.examine(region, mesh, &meshes[mesh])
            };
            self.place(region, examined);
        }
        self.left_out.sort_by_key(|region| region.mesh);
    }

    pub(crate) fn place(&mut self, region: usize, examined: Result<PlannedRegion, LeftOutReason>) {
        match examined {
            Ok(planned) => self.regions.push(planned),
            Err(reason) => self.left_out.push(LeftOutRegion {
                mesh: region,
                reason,
            }),
        }
    }

    /// Boundary vertices of the drawn regions as written, and how many of them their levels leave
    /// out.
    #[must_use]
    pub fn boundary_left_out(&self, meshes: &[impl Borrow<RegionMesh>]) -> (usize, usize) {
        let sum = |mesh_of: fn(&PlannedRegion) -> usize| -> usize {
            let counts = self.regions.iter().map(|planned| {
                let mesh = meshes[mesh_of(planned)].borrow();
                mesh.boundary_edge_count()
            });
            counts.sum()
        };
        let as_written = sum(|planned| planned.region);
        (
            as_written.saturating_sub(sum(|planned| planned.mesh)),
            as_written,
        )
    }

    /// One phrase per reason with count and up to three names, and one on boundary detail: the
    /// `left_out` column.
    #[must_use]
    pub fn left_out_summary(&self, meshes: &[impl Borrow<RegionMesh>]) -> String {
        let mut phrases = Vec::new();
        for reason in LeftOutReason::ALL {
            let names: Vec<&str> = self
                .left_out
                .iter()
                .filter(|region| region.reason == reason)
                .map(|region| meshes[region.mesh].borrow().name.as_str())
                .collect();
            if names.is_empty() {
                continue;
            }
            let shown = names[..names.len().min(3)].join(", ");
            let more = if names.len() > 3 { ", …" } else { "" };
            phrases.push(format!(
                "{} regions {} ({shown}{more})",
                names.len(),
                reason.name()
            ));
        }
        let (left_out, of) = self.boundary_left_out(meshes);
        if let (Some(pixels), 1..) = (self.options.boundary_lod_px, left_out) {
            phrases.push(format!(
                "boundary detail below {pixels} px: {left_out} of {of} vertices"
            ));
        }
        let SmallRings { rings, area_px } = self.small_rings;
        if rings > 0 {
            phrases.push(format!(
                "{rings} islands and lakes below a quarter pixel or out of view, of {area_px:.2} px in \
                 all at most"
            ));
        }
        phrases.extend(self.parts_left_out());
        if self.sky_px > 0 {
            phrases.push(format!("{} px of sky", self.sky_px));
        }
        let flat = self
            .regions
            .iter()
            .filter(|planned| planned.drawn_as == DrawnAs::FlatMesh)
            .count();
        if let (Some(pixels), 1..) = (self.options.far_level_px, flat) {
            phrases.push(format!(
                "bottom caps and stencil of {flat} of {} regions, whose volumes are lower than \
                 {pixels} px",
                self.regions.len()
            ));
        }
        let mut whole = self.regions.iter();
        if let Some(region) = whole.find(|planned| planned.drawn_as == DrawnAs::Ground) {
            let name = &meshes[region.mesh].borrow().name;
            phrases.push(format!(
                "volume and stencil of {name}, which has all ground in view"
            ));
        }
        phrases.join("; ")
    }

    /// Asks the volumes themselves where only their boxes were known to meet the near rectangle.
    ///
    /// - cost: nothing for regions whose boxes the near rectangle does not meet. For any other O(parts), and
    ///   O(triangles) of the parts that it meets; without parts O(triangles).
    fn settle_near_plane<'m>(
        &mut self,
        view: PlanView<'_>,
        placed: impl Fn(usize) -> Option<PlacedMesh<'m>>,
    ) {
        for planned in &mut self.regions {
            if planned.near_rectangle == NearRectangle::Cut
                && let Some(PlacedMesh { mesh, parts }) = placed(planned.mesh)
            {
                let volume = ViewVolume::new(view.body, view.camera, mesh, planned.heights, parts);
                planned.near_rectangle = volume.near_rectangle(view.camera, view.size);
            }
        }
    }
}

/// What a frame's regions are held against.
pub(crate) struct Planner<'a> {
    camera: &'a Camera,
    size: ImageSize,
    /// [`Camera::side_planes_ecef`].
    side_planes_ecef: [DVec3; 5],
    horizon: Horizon,
    clearance_m: f64,
    /// How much farther volumes reach up and down than the terrain needs.
    beyond_m: [f64; 2],
    near_plane: NearPlane,
    /// [`FramePlan::ground`].
    ground: Option<PixelRect>,
    options: PlanOptions,
}

impl<'a> Planner<'a> {
    fn new(view: PlanView<'a>, options: PlanOptions) -> Self {
        let PlanView { camera, size, .. } = view;
        Self {
            camera,
            size,
            side_planes_ecef: camera.side_planes_ecef(size, 0.0),
            horizon: Horizon::new(view.body, camera.eye_ecef, view.terrain.lowest_m),
            clearance_m: cap_clearance_m(view),
            beyond_m: match options.wall_heights {
                WallHeights::Region => [0.0; 2],
                WallHeights::Global => [-view.terrain.highest_m, view.terrain.lowest_m]
                    .map(|margin_m| (GLOBAL_HEIGHT_M + margin_m).max(0.0)),
            },
            near_plane: NearPlane::new(camera, size),
            ground: options
                .sky_culling
                .then(|| ground_rect(view.body, camera, size, view.terrain.highest_m)),
            options,
        }
    }

    /// Why a part of a region that is drawn is left out, or its rectangle.
    ///
    /// - `counts_in_front`: fragments in front of the surface count, so that what the body hides changes
    ///   nothing
    pub(crate) fn look_at_part(
        &self,
        corners: &[DVec3; 8],
        counts_in_front: bool,
    ) -> Result<PixelRect, LeftOutReason> {
        let (_, rect, off_screen) = self.on_screen(corners);
        if off_screen {
            Err(LeftOutReason::OutsideFrustum)
        } else if rect.area() == 0 || counts_in_front && self.horizon.hides_all(corners) {
            Err(LeftOutReason::BeyondHorizon)
        } else {
            Ok(rect)
        }
    }

    /// Where corners project to, the pixels of ground that their hull may touch, and whether it touches none at all.
    fn on_screen(&self, corners: &[DVec3; 8]) -> (Option<Footprint>, PixelRect, bool) {
        let (camera, size) = (self.camera, self.size);
        let footprint = Footprint::new(camera, size, corners);
        let rect = footprint.map_or(PixelRect::full(size), |f| f.rect(size));
        let off_screen = rect.area() == 0 || self.is_outside(corners);
        let rect = self.ground.map_or(rect, |ground| rect.within(ground));
        (footprint, rect, off_screen)
    }

    /// Whether all corners lie outside one side plane, or behind the eye.
    fn is_outside(&self, corners: &[DVec3; 8]) -> bool {
        let from_eye = corners.map(|corner| corner - self.camera.eye_ecef);
        let is_outside = |plane: &DVec3| from_eye.iter().all(|corner| corner.dot(*plane) < 0.0);
        self.side_planes_ecef.iter().any(is_outside)
    }

    /// # Errors
    /// Why the region is left out when drawn by this mesh.
    fn examine(
        &self,
        region: usize,
        mesh: usize,
        bounds: &RegionBounds,
    ) -> Result<PlannedRegion, LeftOutReason> {
        let options = &self.options;
        let [up_m, down_m] = self.beyond_m.map(|beyond_m| beyond_m + self.clearance_m);
        let grown = bounds.grown(up_m, down_m);
        let corners = grown.bounds.corners_ecef();
        let (footprint, screen_rect, off_screen) = self.on_screen(&corners);
        if options.frustum_culling && off_screen {
            Err(LeftOutReason::OutsideFrustum)
        } else if options.horizon_culling && self.horizon.hides_all(&corners)
            || options.sky_culling && screen_rect.area() == 0
        {
            Err(LeftOutReason::BeyondHorizon)
        } else if options.too_small_culling && footprint.is_some_and(Footprint::is_too_small) {
            Err(LeftOutReason::TooSmall)
        } else {
            Ok(PlannedRegion {
                region,
                mesh,
                heights: grown.heights,
                screen_rect,
                near_rectangle: NearRectangle::by_bounds(self.near_plane.meets_box(&grown.bounds)),
                drawn_as: DrawnAs::Volume,
            })
        }
    }

    /// Whether the region's volume is lower than `pixels` and wholly before the horizon, so that its top cap
    /// and walls may stand for it.
    ///
    /// - `bounds`: of the mesh that is drawn
    fn is_far(&self, planned: &PlannedRegion, bounds: &RegionBounds, pixels: f64) -> bool {
        let height_m = planned.heights.top_m - planned.heights.bottom_m;
        let [up_m, down_m] = self.beyond_m.map(|beyond_m| beyond_m + self.clearance_m);
        let corners = bounds.grown(up_m, down_m).bounds.corners_ecef();
        planned.near_rectangle == NearRectangle::Outside
            && height_m <= pixels * self.pixel_m(&self.with_clearance(bounds))
            && self.horizon.has_all_before(&corners)
    }

    fn see(&self, around: &OrientedBox) -> SeenPiece {
        SeenPiece {
            pixel_m: self.pixel_m(around),
            outside_m: self.outside_m(around),
        }
    }

    /// The box around a volume whose caps are as far from the terrain as the view's rounding asks.
    fn with_clearance(&self, bounds: &RegionBounds) -> OrientedBox {
        bounds.grown(self.clearance_m, self.clearance_m).bounds
    }

    /// How far a box is from what the image shows, metres: at least that far, and 0 where it may reach it.
    fn outside_m(&self, around: &OrientedBox) -> f64 {
        let corners = around.corners_ecef();
        let corners = corners.map(|at| at - self.camera.eye_ecef);
        let beyond = |normal: &DVec3| {
            let distances = corners.iter().map(|corner| -corner.dot(*normal));
            distances.fold(f64::INFINITY, f64::min)
        };
        self.side_planes_ecef.iter().map(beyond).fold(0.0, f64::max)
    }

    /// What a pixel is worth where it is worth least, metres: a displacement of this length of
    /// anything in the box moves its picture by no more than a pixel. 0 where the box reaches the eye.
    ///
    /// At distance r, depth z along the viewing axis, and an angle off it with tangent t, a
    /// displacement δ across the ray moves the picture on the image plane at distance 1 by up to
    /// `(1 + t²) δ / r = √(1 + t²) δ / z`. Both forms are held against the box: its nearest point
    /// or its nearest depth, and the corner of its footprint farthest from the image's centre.
    /// Across the ray is where a displacement shows most, so nothing is gained from its direction.
    fn pixel_m(&self, around: &OrientedBox) -> f64 {
        let (camera, size) = (self.camera, self.size);
        let corners = around.corners_ecef();
        let depth = |corner: &DVec3| -(camera.view_from_ecef * (*corner - camera.eye_ecef)).z;
        let depth_m = corners.iter().map(depth).fold(f64::INFINITY, f64::min);
        let (distance_m, _) = around.distances_m(camera.eye_ecef);
        let footprint = Footprint::new(camera, size, &corners);
        let seen = footprint.map_or(PixelRect::full(size), |f| f.rect(size));
        let farthest = |low: u32, high: u32, count: u32| {
            let from_centre = |at: u32| (2.0 * f64::from(at) / f64::from(count) - 1.0).abs();
            camera.tan_half_fov() * from_centre(low).max(from_centre(high))
        };
        let x = farthest(seen.left, seen.right, size.width) * size.aspect();
        let y = farthest(seen.top, seen.bottom, size.height);
        let stretch = 1.0 + x * x + y * y;
        let by_distance = camera.pixel_size_m(size, distance_m) / stretch;
        let by_depth = camera.pixel_size_m(size, depth_m.max(0.0)) / stretch.sqrt();
        by_distance.max(by_depth)
    }
}

/// [`CAP_CLEARANCE_PX`] in metres at the farthest distance at which anything can be seen: the horizon
/// and, over terrain, the summits behind it. From the point where a ray touches the sphere of the
/// lowest terrain, it reaches the highest terrain after `√((b + highest)² − (b + lowest)²)`.
fn cap_clearance_m(view: PlanView<'_>) -> f64 {
    let PlanView {
        camera, terrain, ..
    } = view;
    let to_center = camera.eye_ecef.length();
    let polar_m = view.body.polar_radius_m();
    let horizon_m = (to_center * to_center - polar_m.powi(2)).max(0.0).sqrt();
    let behind_m = if terrain.highest_m > 0.0 {
        let [low, high] = [terrain.lowest_m.min(0.0), terrain.highest_m].map(|h| polar_m + h);
        (high * high - low * low).max(0.0).sqrt()
    } else {
        0.0
    };
    camera.pixel_size_m(view.size, horizon_m + behind_m) * CAP_CLEARANCE_PX
}

/// The shadow of the body from the eye, in the space where the body is the unit sphere.
struct Horizon {
    scale: DVec3,
    eye: DVec3,
    /// Squared distance from the eye to the horizon circle; negative when the eye is inside.
    tangent_squared: f64,
}

impl Horizon {
    /// `lowest_m`: lowest height of the surface as drawn.
    fn new(body: &Ellipsoid, eye_ecef: DVec3, lowest_m: f64) -> Self {
        let radii_m = body.radii_below_m(lowest_m);
        let scale = radii_m.max(DVec3::splat(f64::MIN_POSITIVE)).recip();
        let eye = eye_ecef * scale;
        Self {
            scale,
            eye,
            tangent_squared: eye.length_squared() - 1.0,
        }
    }

    /// Whether the whole hull of `corners` lies on the eye's side of the plane of the horizon circle: no
    /// place of the body there is hidden by the body.
    fn has_all_before(&self, corners: &[DVec3; 8]) -> bool {
        let is_before = |corner: &DVec3| (*corner * self.scale).dot(self.eye) > 1.0;
        self.tangent_squared > 0.0 && corners.iter().all(is_before)
    }

    /// Whether the whole hull of `corners` is hidden. Source of the test: Cozzi and Ring (2011),
    /// "3D Engine Design for Virtual Globes", §4 (horizon culling in scaled space).
    fn hides_all(&self, corners: &[DVec3; 8]) -> bool {
        self.tangent_squared > 0.0
            && corners.iter().all(|corner| {
                let to_corner = *corner * self.scale - self.eye;
                let along = -to_corner.dot(self.eye);
                along > self.tangent_squared
                    && along * along > self.tangent_squared * to_corner.length_squared()
            })
    }
}

/// The part of the image that a box projects to, pixels.
#[derive(Debug, Clone, Copy)]
struct Footprint {
    low: [f64; 2],
    high: [f64; 2],
}

/// Vertices are snapped to a grid of at least 1/256 pixel before pixels are looked for, and their
/// projection is rounded to `f32`; four such steps hold both.
const SNAPPING_PX: f64 = 4.0 / 256.0;

impl Footprint {
    /// `None` when a corner is not in front of the near plane.
    fn new(camera: &Camera, size: ImageSize, corners: &[DVec3; 8]) -> Option<Self> {
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for corner in corners {
            let pixel = camera.project_px(size, *corner)?;
            for axis in 0..2 {
                low[axis] = low[axis].min(pixel[axis]);
                high[axis] = high[axis].max(pixel[axis]);
            }
        }
        Some(Self { low, high })
    }

    /// Pixels that can be touched, grown by one for rounding.
    fn rect(self, size: ImageSize) -> PixelRect {
        PixelRect {
            left: pixel(self.low[0].floor() - 1.0, size.width),
            top: pixel(self.low[1].floor() - 1.0, size.height),
            right: pixel(self.high[0].ceil() + 1.0, size.width),
            bottom: pixel(self.high[1].ceil() + 1.0, size.height),
        }
    }

    /// Whether it lies between the centres of neighbouring columns or rows: no pixel is filled.
    fn is_too_small(self) -> bool {
        (0..2).any(|axis| {
            let first = (self.low[axis] - SNAPPING_PX - 0.5).ceil();
            first > self.high[axis] + SNAPPING_PX - 0.5
        })
    }
}
