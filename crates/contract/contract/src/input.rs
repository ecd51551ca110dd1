// SPDX-License-Identifier: MIT OR Apache-2.0
//! What goes in: the same bytes for every backend.

use crate::picture::MAX_REGIONS;
use crate::{DeviceError, ViewId};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use terrafill_core::{EdgeRule, Ellipsoid, Extent, MovingFootprint, Region, RegionMesh};
use terrafill_plan::{
    FramePlan, LazyParts, LevelTable, LeveledMeshes, MeshParts, NoSuchRegion, PartCulling,
    PlacedMesh, PlanOptions, PlanView, RegionBounds, RegionSet, SceneBounds,
};
use terrafill_scene::{Camera, ImageSize, MipChain, Overlap, Scene, SceneTexture, View};
use terrafill_surface::{HeightRange, Surface, SurfaceError, SurfaceFrame};

/// A scene made ready to draw: regions meshed, surface opened. One per scene and mesh options; shared
/// by all its views.
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
    pub meshes: RegionSet,
    /// Which of `meshes` is which region at which level.
    pub levels: Arc<LevelTable>,
    /// Bounds of `meshes` over the surface, for all views; narrower in the input of a view that draws the
    /// surface between closer heights.
    pub bounds: SceneBounds,
    /// Meshes that the vertex stage bends: discs ([`FootprintMesher::disc`]) and the cones' edges that
    /// they are bent into, by their place among `meshes`. Mostly empty.
    ///
    /// [`FootprintMesher::disc`]: terrafill_core::FootprintMesher::disc
    pub footprints: Arc<BTreeMap<usize, MovingFootprint>>,
    /// Parts of large meshes, made when a plan first asks for them.
    pub parts: LazyParts,
    /// What lies under the fill.
    pub surface: Arc<dyn Surface>,
    /// What colours the surface; no fill looks at it.
    pub picture: Option<Arc<MipChain>>,
    /// What a textured fill shows; plain fills never look at it.
    pub texture: Option<Arc<SceneTexture>>,
}

impl PreparedScene {
    /// Parts of a mesh; `None` where it is so small that it is one part.
    #[must_use]
    pub fn parts_of(&self, mesh: usize) -> Option<&MeshParts> {
        self.parts.of(&self.body, &self.meshes, mesh)
    }

    /// Joins a scene with its meshes and surface.
    #[must_use]
    pub fn new(scene: &Scene, meshes: RegionSet, surface: Arc<dyn Surface>) -> Self {
        Self {
            name: scene.name.clone(),
            body: scene.body,
            edge_rule: scene.edge_rule,
            overlap: scene.overlap,
            regions: Arc::clone(&scene.regions),
            bounds: SceneBounds::new(&scene.body, &meshes, &surface, None),
            meshes,
            levels: Arc::default(),
            footprints: Arc::default(),
            parts: LazyParts::default(),
            surface,
            picture: scene.surface.picture.clone(),
            texture: scene.texture.clone(),
        }
    }

    /// Joins a scene with the meshes of all its levels and its surface.
    #[must_use]
    pub fn leveled(scene: &Scene, leveled: LeveledMeshes, surface: Arc<dyn Surface>) -> Self {
        Self {
            levels: Arc::new(leveled.table),
            ..Self::new(scene, leveled.meshes.into(), surface)
        }
    }

    /// The same scene with other meshes at some places, such as regions that moved. It must have no
    /// levels. [`PreparedScene::regions`], which only the reference reads, stay as they are.
    ///
    /// - cost: O(meshes); none is copied, and bounds are found anew at these places only
    ///
    /// # Errors
    /// [`NoSuchRegion`] for a place that it does not have.
    pub fn with_changed(
        &self,
        changed: impl IntoIterator<Item = (usize, RegionMesh)>,
    ) -> Result<Self, NoSuchRegion> {
        let meshes = self.meshes.with_changed(changed)?;
        let changed = meshes.changed_since(self.meshes.revision());
        let (body, surface) = (&self.body, &self.surface);
        let bounds = self
            .bounds
            .with_changed(body, &meshes, surface, changed.unwrap_or(&[]));
        Ok(Self {
            bounds,
            meshes,
            parts: LazyParts::default(),
            ..self.clone()
        })
    }

    /// The same scene with its footprints elsewhere: those of all that move. Bounds are made anew for
    /// these only; the meshes stay as they are, discs at these places.
    ///
    /// # Errors
    /// [`NoSuchRegion`] for a place that it does not have.
    pub fn with_footprints(
        &self,
        footprints: BTreeMap<usize, MovingFootprint>,
    ) -> Result<Self, NoSuchRegion> {
        let regions = self.meshes.len();
        if let Some((&found, _)) = footprints.range(regions..).next() {
            return Err(NoSuchRegion { found, regions });
        }
        let everywhere = self.surface.heights(&Extent::WHOLE);
        Ok(Self {
            bounds: bounds_with(&self.bounds, &self.body, &footprints, everywhere),
            footprints: footprints.into(),
            parts: LazyParts::default(),
            ..self.clone()
        })
    }

    /// The same scene with its regions meshed otherwise, at one level.
    #[must_use]
    pub fn with_meshes(&self, meshes: RegionSet) -> Self {
        Self {
            bounds: SceneBounds::new(&self.body, &meshes, &self.surface, None),
            meshes,
            levels: Arc::default(),
            parts: LazyParts::default(),
            ..self.clone()
        }
    }
}

/// Bounds with those of footprints between these heights.
fn bounds_with(
    bounds: &SceneBounds,
    body: &Ellipsoid,
    footprints: &BTreeMap<usize, MovingFootprint>,
    heights: HeightRange,
) -> SceneBounds {
    let of = |footprint| RegionBounds::of_footprint(body, footprint, heights);
    bounds.with(footprints.iter().map(|(&place, found)| (place, of(found))))
}

/// Everything one frame is drawn from.
#[derive(Debug, Clone)]
pub struct FillInput {
    /// The scene.
    pub scene: PreparedScene,
    /// Name of the view.
    pub view: String,
    /// The eye.
    pub camera: Camera,
    /// The image.
    pub size: ImageSize,
    /// Identity of eye, image and surface as drawn.
    pub view_id: ViewId,
    /// The surface as every renderer sees it.
    pub surface: SurfaceFrame,
    /// What is drawn and what is left out.
    pub plan: FramePlan,
}

impl FillInput {
    /// What the view leaves out, of regions and surface: the `left_out` column.
    #[must_use]
    pub fn left_out_summary(&self) -> String {
        let of_regions = self.plan.left_out_summary(&self.scene.meshes);
        let of_surface = self.surface.left_out_summary();
        let phrases = [Some(of_regions), of_surface].into_iter().flatten();
        let some: Vec<String> = phrases.filter(|phrase| !phrase.is_empty()).collect();
        some.join("; ")
    }

    /// Plans a frame of `scene` seen by `view`.
    ///
    /// # Errors
    /// [`SurfaceError`] when the surface cannot be drawn in this view.
    pub fn new(
        scene: &PreparedScene,
        view: &View,
        size: ImageSize,
        options: PlanOptions,
    ) -> Result<Self, SurfaceError> {
        let camera = view.camera(&scene.body);
        let surface = scene.surface.frame(&camera, size)?;
        let scene = drawn_in(scene, &surface);
        Ok(Self {
            plan: plan(&scene, &camera, size, surface.heights, options),
            scene,
            view: view.name.clone(),
            camera,
            size,
            view_id: ViewId::unique(),
            surface,
        })
    }

    /// The same view of the same surface with regions meshed otherwise, such as with another
    /// boundary tolerance; what lies under the fill stays the same bytes.
    #[must_use]
    pub fn remeshed(&self, scene: &PreparedScene, options: PlanOptions) -> Self {
        let terrain = self.surface.heights;
        let scene = drawn_in(scene, &self.surface);
        Self {
            plan: plan(&scene, &self.camera, self.size, terrain, options),
            scene,
            ..self.clone()
        }
    }

    /// Heights between which the surface lies as drawn in this view.
    #[must_use]
    pub fn terrain(&self) -> HeightRange {
        self.surface.heights
    }

    /// Whether ids can tell the scene's regions apart.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`].
    pub fn check_region_count(&self) -> Result<(), DeviceError> {
        let found = self.scene.regions.len();
        DeviceError::check_capacity("regions", found as u64, MAX_REGIONS as u64)
    }

    /// Whether this is what `backend` was prepared for.
    ///
    /// - `revision`: of the meshes that it holds
    /// - `view_id`: of the view that it holds
    ///
    /// # Errors
    /// [`DeviceError::NotPrepared`].
    pub fn check_prepared(
        &self,
        backend: &'static str,
        revision: Option<u64>,
        view_id: Option<ViewId>,
    ) -> Result<(), DeviceError> {
        let has_meshes = revision == Some(self.scene.meshes.revision());
        if has_meshes && view_id == Some(self.view_id) {
            return Ok(());
        }
        Err(self.not_prepared(backend))
    }

    /// The meshes in which this differs from what `backend` holds, ascending, if `changed` names them.
    ///
    /// - `revision`: of the meshes that it holds
    /// - `changed`: indices into the meshes, in any order
    ///
    /// # Errors
    /// [`DeviceError::NotPrepared`] when it holds other meshes than those that this was made from,
    /// [`DeviceError::ChangedRegions`] when `changed` names others.
    pub fn check_update(
        &self,
        backend: &'static str,
        revision: Option<u64>,
        changed: &[usize],
    ) -> Result<&[usize], DeviceError> {
        let allowed = revision.and_then(|held| self.scene.meshes.changed_since(held));
        let allowed = allowed.ok_or_else(|| self.not_prepared(backend))?;
        let found: BTreeSet<usize> = changed.iter().copied().collect();
        if found.iter().eq(allowed) {
            return Ok(allowed);
        }
        Err(DeviceError::ChangedRegions {
            found: changed.to_vec(),
            allowed: allowed.to_vec(),
        })
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

/// The scene with the bounds of a view that draws the surface so.
fn drawn_in(scene: &PreparedScene, drawn: &SurfaceFrame) -> PreparedScene {
    let everywhere = scene.surface.heights(&Extent::WHOLE);
    if everywhere == drawn.heights && drawn.parts.is_empty() {
        return scene.clone();
    }
    let bounds = SceneBounds::new(&scene.body, &scene.meshes, &scene.surface, Some(drawn));
    PreparedScene {
        bounds: bounds_with(&bounds, &scene.body, &scene.footprints, drawn.heights),
        ..scene.clone()
    }
}

fn plan(
    scene: &PreparedScene,
    camera: &Camera,
    size: ImageSize,
    terrain: HeightRange,
    options: PlanOptions,
) -> FramePlan {
    let view = PlanView {
        body: &scene.body,
        camera,
        size,
        terrain,
    };
    let culls_parts = options.part_culling != PartCulling::Off;
    let placed = |mesh: usize| {
        let is_stored = !scene.footprints.contains_key(&mesh);
        is_stored.then(|| PlacedMesh {
            mesh: &scene.meshes[mesh],
            parts: culls_parts.then(|| scene.parts_of(mesh)).flatten(),
        })
    };
    let options = PlanOptions {
        interior: options.interior && scene.overlap == Overlap::Disjoint,
        ..options
    };
    FramePlan::new(view, &scene.bounds, &scene.levels, placed, options)
}
