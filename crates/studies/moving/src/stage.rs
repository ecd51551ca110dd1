// SPDX-License-Identifier: MIT OR Apache-2.0
//! The scene that sensors move over, and how it goes from one frame to the next.

use crate::sensors::Sensors;
use std::collections::BTreeMap;
use terrafill_contract::{CpuStopwatch, FillBackend, FillInput, PreparedScene};
use terrafill_core::{MeshOptions, Region, RegionMesh};
use terrafill_plan::{LazyMesh, PlanOptions, RegionSet};
use terrafill_scene::{ImageSize, Overlap, Scene, View};
use terrafill_study::Failure;
use terrafill_surface::{SurfaceKind, open_surface};

/// The eye from the apex, what is left of it, and the difference of the two, along three axes. Each is
/// rounded to f32 and no longer than the way from the eye to the far side of the body.
const SUBTRACTION_F32: f64 = 3.0 * 1.733 / (1 << 24) as f64;

terrafill_results::named! {
    /// How a scene is brought up to date.
    all pub(crate) enum Upkeep {
        /// Strips with the same vertices and triangles, rewritten where they lie.
        Rewrite = "rewrite",
        /// Discs that never change: the vertex stage bends them by a few numbers a cone.
        Bend = "bend",
        /// The same strips, and everything is uploaded again.
        Reload = "reload",
        /// The general mesher, whose numbers of vertices change with the shape.
        Remesh = "remesh",
    }
}

/// What a step from one frame to the next took.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct StepCost {
    pub(crate) mesh_cpu_ms: f64,
    pub(crate) plan_cpu_ms: f64,
    pub(crate) update_cpu_ms: f64,
    pub(crate) upload_bytes: u64,
    /// Regions whose geometry was uploaded.
    pub(crate) regions: usize,
}

/// Countries, and sensors over them.
#[derive(Debug)]
pub(crate) struct Stage {
    pub(crate) sensors: Sensors,
    /// Regions that lie still, which come first.
    still: Vec<Region>,
    mesh: MeshOptions,
    /// At frame 0.
    start: FillInput,
}

impl Stage {
    /// - `base`: what lies still; sensors cover it
    pub(crate) fn new(
        base: &Scene,
        surfaces: &[&dyn SurfaceKind],
        view: &View,
        size: ImageSize,
        sensors: Sensors,
    ) -> Result<Self, Failure> {
        let surface = open_surface(surfaces, base)?;
        let still = base.regions.to_vec();
        let scene = Scene {
            overlap: Overlap::Ordered,
            ..base.clone()
        };
        let meshed = RegionMesh::build_all(&still, &base.body, base.edge_rule, &base.mesh);
        let mut meshes = meshed.map_err(|errors| Failure::broken(&errors[0]))?;
        meshes.extend(sensors.strips(0, still.len(), base.edge_rule)?);
        let mut prepared = PreparedScene::new(&scene, meshes.into(), surface);
        prepared.regions = all_regions(&still, &sensors, 0)?.into();
        Ok(Self {
            start: FillInput::new(&prepared, view, size, PlanOptions::default())?,
            mesh: base.mesh,
            still,
            sensors,
        })
    }

    /// The first frame, by this way of keeping up to date.
    pub(crate) fn start(&self, upkeep: Upkeep) -> Result<FillInput, Failure> {
        let scene = match upkeep {
            Upkeep::Rewrite | Upkeep::Reload => return Ok(self.start.clone()),
            Upkeep::Bend => {
                let first = self.still.len();
                let mut meshes = self.start.scene.meshes[..first].to_vec();
                meshes.extend(self.sensors.discs(first).into_iter().map(LazyMesh::from));
                let discs = PreparedScene {
                    meshes: meshes.into(),
                    ..self.start.scene.clone()
                };
                discs.with_footprints(self.sensors.bent(0, first)?)
            }
            Upkeep::Remesh => self.start.scene.with_changed(self.meshes(0, upkeep)?),
        };
        let scene = scene.map_err(Failure::broken)?;
        Ok(self.start.remeshed(&scene, PlanOptions::default()))
    }

    /// How far vertices that the device computes in f32 may be off at `frame`, in metres and in pixels of
    /// this view: the footprint's bound, and what subtracting the eye in f32 rounds away.
    pub(crate) fn bound(&self, frame: u32) -> Result<[f64; 2], Failure> {
        let bent = self.sensors.bent(frame, self.still.len())?;
        let (camera, body) = (&self.start.camera, &self.start.scene.body);
        let eye_m = camera.eye_ecef.length();
        let farthest_m = eye_m + body.equatorial_radius_m();
        let bound_m = self.sensors.rounding_bound_m(&bent) + SUBTRACTION_F32 * farthest_m;
        // Nothing on the ground is nearer.
        let nearest_m = eye_m - body.equatorial_radius_m();
        let rows = f64::from(self.start.size.height);
        let pixel_m = nearest_m * 2.0 * camera.tan_half_fov() / rows;
        Ok([bound_m, bound_m / pixel_m])
    }

    /// What the reference draws at `frame`.
    pub(crate) fn as_rings(&self, frame: u32) -> Result<FillInput, Failure> {
        let mut input = self.start.clone();
        input.scene.regions = all_regions(&self.still, &self.sensors, frame)?.into();
        Ok(input)
    }

    fn meshes(&self, frame: u32, upkeep: Upkeep) -> Result<Vec<(usize, RegionMesh)>, Failure> {
        let (body, rule) = (&self.start.scene.body, self.start.scene.edge_rule);
        let first = self.still.len();
        let meshes = match upkeep {
            Upkeep::Rewrite | Upkeep::Reload => self.sensors.strips(frame, first, rule)?,
            Upkeep::Bend => Vec::new(),
            Upkeep::Remesh => {
                let regions = self.sensors.regions(frame, first)?;
                let meshed = regions
                    .iter()
                    .map(|region| RegionMesh::build(region, body, rule, &self.mesh));
                meshed.collect::<Result<_, _>>().map_err(Failure::broken)?
            }
        };
        Ok((first..).zip(meshes).collect())
    }

    /// Meshes the sensors at `frame`, plans the frame and hands it to `backend`, which holds `before`.
    pub(crate) fn step(
        &self,
        backend: &mut dyn FillBackend,
        before: &FillInput,
        frame: u32,
        upkeep: Upkeep,
    ) -> Result<(FillInput, StepCost), Failure> {
        let plan = PlanOptions::default();
        let mut cost = StepCost::default();
        let watch = CpuStopwatch::start();
        let changed = self.meshes(frame, upkeep)?;
        let bent = match upkeep {
            Upkeep::Bend => self.sensors.bent(frame, self.still.len())?,
            _ => BTreeMap::new(),
        };
        cost.mesh_cpu_ms = watch.cpu_ms();
        let places: Vec<usize> = changed.iter().map(|(place, _)| *place).collect();
        let watch = CpuStopwatch::start();
        let scene = match upkeep {
            Upkeep::Rewrite | Upkeep::Remesh => before.scene.with_changed(changed),
            Upkeep::Bend => before.scene.with_footprints(bent),
            Upkeep::Reload => {
                let mut meshes = before.scene.meshes.to_vec();
                for (place, mesh) in changed {
                    meshes[place] = mesh.into();
                }
                Ok(before.scene.with_meshes(RegionSet::from(meshes)))
            }
        };
        let scene = scene.map_err(Failure::broken)?;
        let input = before.remeshed(&scene, plan);
        cost.plan_cpu_ms = watch.cpu_ms();
        let watch = CpuStopwatch::start();
        match upkeep {
            Upkeep::Rewrite | Upkeep::Remesh => {
                let uploaded = backend.update(&input, &places)?;
                (cost.upload_bytes, cost.regions) = (uploaded.bytes, uploaded.regions.len());
            }
            // The meshes are those that it holds, so only constants are handed over.
            Upkeep::Bend => cost.upload_bytes = backend.prepare(&input)?.upload_bytes,
            Upkeep::Reload => {
                cost.upload_bytes = backend.prepare(&input)?.upload_bytes;
                cost.regions = input.scene.meshes.len();
            }
        }
        cost.update_cpu_ms = watch.cpu_ms();
        Ok((input, cost))
    }
}

fn all_regions(still: &[Region], sensors: &Sensors, frame: u32) -> Result<Vec<Region>, Failure> {
    let mut regions = still.to_vec();
    regions.extend(sensors.regions(frame, still.len())?);
    Ok(regions)
}
