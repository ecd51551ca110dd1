// SPDX-License-Identifier: MIT OR Apache-2.0
//! What goes in: the same bytes for every backend.

use crate::{DeviceError, MAX_REGIONS};
use std::sync::Arc;
use terrafill_core::{EdgeRule, Ellipsoid, Region, RegionMesh};
use terrafill_scene::{
    Camera, FramePlan, ImageSize, LevelTable, LeveledMeshes, Overlap, PixelRect, PlanOptions,
    RegionBounds, Scene, SceneTexture, SurfaceMesh, TerrainRange, View,
};

/// A scene made ready to draw: regions meshed, surface tessellated. One per scene and mesh
/// options; shared by all its views.
#[derive(Debug, Clone)]
pub struct PreparedScene {
    /// Name in reports.
    pub name: String,
    /// What everything lies on.
    pub body: Ellipsoid,
    /// What a ring edge is.
    pub edge_rule: EdgeRule,
    /// Whether regions may overlap.
    pub overlap: Overlap,
    /// As parsed: what the reference judges by.
    pub regions: Arc<[Region]>,
    /// As meshed: what volume backends draw. The first are `regions` in their order; what follows
    /// are coarser levels of them, see `levels`.
    pub meshes: Arc<[RegionMesh]>,
    /// Which of `meshes` is which region at which level.
    pub levels: Arc<LevelTable>,
    /// Bounds of `meshes` over the surface, made once for all views.
    pub bounds: Arc<[RegionBounds]>,
    /// What lies under the fill.
    pub surface: Arc<SurfaceMesh>,
    /// What a textured fill shows; plain fills never look at it.
    pub texture: Option<Arc<SceneTexture>>,
}

impl PreparedScene {
    /// Joins a scene with its meshes and surface.
    #[must_use]
    pub fn new(scene: &Scene, meshes: Arc<[RegionMesh]>, surface: Arc<SurfaceMesh>) -> Self {
        Self {
            name: scene.name.clone(),
            body: scene.body,
            edge_rule: scene.edge_rule,
            overlap: scene.overlap,
            regions: Arc::clone(&scene.regions),
            bounds: bounds(&scene.body, &meshes, &surface),
            meshes,
            levels: Arc::default(),
            surface,
            texture: scene.texture.clone(),
        }
    }

    /// Joins a scene with the meshes of all its levels and its surface.
    #[must_use]
    pub fn leveled(scene: &Scene, leveled: LeveledMeshes, surface: Arc<SurfaceMesh>) -> Self {
        Self {
            levels: Arc::new(leveled.table),
            ..Self::new(scene, leveled.meshes.into(), surface)
        }
    }

    /// The same scene with its regions meshed otherwise, at one level.
    #[must_use]
    pub fn with_meshes(&self, meshes: Arc<[RegionMesh]>) -> Self {
        Self {
            bounds: bounds(&self.body, &meshes, &self.surface),
            meshes,
            levels: Arc::default(),
            ..self.clone()
        }
    }

    /// Height range of the surface as drawn.
    #[must_use]
    pub fn terrain(&self) -> TerrainRange {
        terrain(&self.surface)
    }
}

fn terrain(surface: &SurfaceMesh) -> TerrainRange {
    TerrainRange {
        lowest_m: surface.lowest_m,
        highest_m: surface.highest_m,
    }
}

fn bounds(body: &Ellipsoid, meshes: &[RegionMesh], surface: &SurfaceMesh) -> Arc<[RegionBounds]> {
    let terrain = terrain(surface);
    meshes
        .iter()
        .map(|mesh| RegionBounds::new(body, mesh, terrain))
        .collect()
}

/// Everything one frame is drawn from.
#[derive(Debug, Clone)]
pub struct FrameInput {
    /// The scene.
    pub scene: PreparedScene,
    /// Name of the view.
    pub view: String,
    /// The eye.
    pub camera: Camera,
    /// The image.
    pub size: ImageSize,
    /// The surface's vertices as every renderer sees them: metres relative to the eye, ECEF axes.
    pub surface_rte: Arc<[[f32; 3]]>,
    /// What is drawn and what is left out.
    pub plan: FramePlan,
}

impl FrameInput {
    /// Plans a frame of `scene` seen by `view`.
    #[must_use]
    pub fn new(scene: &PreparedScene, view: &View, size: ImageSize, options: PlanOptions) -> Self {
        let camera = view.camera(&scene.body);
        let plan = plan(scene, &camera, size, options);
        Self {
            scene: scene.clone(),
            view: view.name.clone(),
            camera,
            size,
            surface_rte: scene.surface.relative_to_eye(camera.eye_ecef).into(),
            plan,
        }
    }

    /// The same view of the same surface with regions meshed otherwise, such as with another
    /// boundary tolerance; what lies under the fill stays the same bytes.
    #[must_use]
    pub fn remeshed(&self, scene: &PreparedScene, options: PlanOptions) -> Self {
        Self {
            scene: scene.clone(),
            view: self.view.clone(),
            camera: self.camera,
            size: self.size,
            surface_rte: Arc::clone(&self.surface_rte),
            plan: plan(scene, &self.camera, self.size, options),
        }
    }

    /// Where a planned region may be drawn: its screen rectangle with `scissor`, else everywhere.
    ///
    /// - `planned`: index into the plan's regions
    #[must_use]
    pub fn rect(&self, planned: usize, scissor: bool) -> PixelRect {
        if scissor {
            self.plan.regions[planned].screen_rect
        } else {
            PixelRect::full(self.size)
        }
    }

    /// Whether ids can tell the scene's regions apart.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`].
    pub fn check_region_count(&self) -> Result<(), DeviceError> {
        let (found, allowed) = (self.scene.regions.len(), MAX_REGIONS);
        if found <= allowed {
            return Ok(());
        }
        Err(DeviceError::OverCapacity {
            what: "regions".to_owned(),
            found: found as u64,
            allowed: allowed as u64,
        })
    }

    /// Whether this is what `backend` was prepared for.
    ///
    /// - `meshes`: those that it holds
    /// - `surface_rte`: that of the view that it holds
    ///
    /// # Errors
    /// [`DeviceError::NotPrepared`].
    pub fn check_prepared(
        &self,
        backend: &'static str,
        meshes: Option<&Arc<[RegionMesh]>>,
        surface_rte: Option<&Arc<[[f32; 3]]>>,
    ) -> Result<(), DeviceError> {
        let has_meshes = meshes.is_some_and(|held| Arc::ptr_eq(held, &self.scene.meshes));
        let has_view = surface_rte.is_some_and(|held| Arc::ptr_eq(held, &self.surface_rte));
        if has_meshes && has_view {
            return Ok(());
        }
        Err(self.not_prepared(backend))
    }

    /// `backend` was prepared for something else.
    #[must_use]
    pub fn not_prepared(&self, backend: &'static str) -> DeviceError {
        DeviceError::NotPrepared {
            backend,
            scene: self.scene.name.clone(),
            view: self.view.clone(),
        }
    }
}

fn plan(
    scene: &PreparedScene,
    camera: &Camera,
    size: ImageSize,
    options: PlanOptions,
) -> FramePlan {
    let mut plan = FramePlan::new(
        &scene.body,
        camera,
        size,
        scene.terrain(),
        &scene.bounds,
        &scene.levels,
        options,
    );
    plan.settle_near_plane(&scene.body, camera, size, &scene.meshes);
    plan
}
