// SPDX-License-Identifier: MIT OR Apache-2.0
//! Buffers of a scene and of a view: what the compute pass reads, and what it makes.

use crate::culling::{CullRegion, DrawArguments, Horizon, LEFT_OUT};
use crate::expansion::{Capacity, ExpansionPlan, OutputSlice, PlacingPlan, WorkGroup};
use crate::layout::{MeshSlice, SceneGeometry};
use crate::pipeline::Pipelines;
use crate::{ComputeBytes, ComputeVariant, Expansion, GpuCulling, Transform};
use terrafill_contract::{DeviceError, Feature, FillInput, MemoryUse};
use terrafill_gpu::{Gpu, VolumeFill, read_buffer};
use terrafill_plan::PlannedRegion;
use terrafill_stencil::{
    DrawnOfMeshes, DrawnParts, HeldMeshes, Holding, IndexBytes, LaidOut, RegionVolumes,
    VolumeBackend, VolumeConstants, VolumePlace, WallIndices,
};
use terrafill_variant::Switches;

/// Shadow volumes made by a compute pass.
pub type ComputeBackend = VolumeBackend<ComputeVolumes>;

/// Volumes of a scene, and what makes and draws them.
#[derive(Debug)]
pub struct ComputeVolumes {
    variant: ComputeVariant,
    capacity: Capacity,
    pub(crate) pipelines: Pipelines,
    pub(crate) scene: Option<SceneBuffers>,
    /// Meshes as they were laid out, part by part or not, where views bring them.
    laid_out: LaidOut<bool, SceneGeometry>,
    pub(crate) view: ViewBuffers,
    /// Draws of this frame whose size the device decided: indices into the list of their arguments.
    pub(crate) decided_draws: Vec<usize>,
    /// What the view draws of meshes of which it leaves parts out.
    pub(crate) drawn_parts: DrawnOfMeshes,
}

/// Meshes of every region of a scene, in view or not.
#[derive(Debug)]
pub(crate) struct SceneBuffers {
    meshes: Vec<MeshSlice>,
    positions: wgpu::Buffer,
    indices: wgpu::Buffer,
    /// What that holds.
    index_words: Vec<u32>,
    /// Both of them.
    pub(crate) bind_group: wgpu::BindGroup,
    bytes: ComputeBytes,
    /// Of which meshes [`Expansion::Cached`] makes bottom caps.
    bottoms: HeldMeshes,
    /// [`Expansion::Cached`]: all volumes, by mesh.
    pub(crate) expanded: Option<Expanded>,
}

impl SceneBuffers {
    /// Writes the changed meshes, unless one of them does not fit.
    fn rewrite(&mut self, gpu: &Gpu, input: &FillInput, changed: &[usize], by_part: bool) -> bool {
        let mut rewritten = Vec::with_capacity(changed.len());
        for &mesh in changed {
            let mesh_alone = std::slice::from_ref(&input.scene.meshes[mesh]);
            let geometry = SceneGeometry::in_parts(mesh_alone, by_part);
            let Some(slice) = self.meshes[mesh].replaced_by(&geometry.meshes[0]) else {
                return false;
            };
            rewritten.push((mesh, slice, geometry));
        }
        for (mesh, slice, geometry) in rewritten {
            let first_byte = 12 * u64::from(slice.place.first_vertex);
            let positions = bytemuck::cast_slice(&geometry.positions);
            gpu.write_buffer(&self.positions, first_byte, positions);
            let first_word = slice.first_index_word();
            let held = &mut self.index_words[first_word..][..geometry.indices.len()];
            // Where triangles stay as they are, so do their indices.
            if held != geometry.indices {
                held.copy_from_slice(&geometry.indices);
                let indices = bytemuck::cast_slice(&geometry.indices);
                gpu.write_buffer(&self.indices, 4 * first_word as u64, indices);
            }
            self.meshes[mesh] = slice;
        }
        true
    }
}

/// What is made for a view.
#[derive(Debug, Default)]
pub(crate) struct ViewBuffers {
    /// [`Expansion::PerFrame`]: volumes in the plan, by their place in it.
    pub(crate) expanded: Option<Expanded>,
    pub(crate) culling: Option<Culling>,
    /// [`Transform::ComputeStage`]: corners of the regions in the plan.
    pub(crate) placed: Option<Placed>,
}

/// A buffer that the compute pass fills, and what it takes to fill it.
#[derive(Debug)]
pub(crate) struct Filled {
    pub(crate) buffer: wgpu::Buffer,
    work: wgpu::Buffer,
    /// Both of them.
    pub(crate) bind_group: wgpu::BindGroup,
    dispatch_size: [u32; 2],
    output_bytes: u64,
    work_bytes: u64,
}

impl Filled {
    pub(crate) fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>) {
        let [columns, rows] = self.dispatch_size;
        pass.dispatch_workgroups(columns, rows, 1);
    }

    /// What it takes to fill it.
    fn work_held(&self) -> Holding {
        Holding::constants(Feature::Expansion, self.work_bytes, self.work.size())
    }
}

impl Expanded {
    /// The list by what its indices are.
    fn holdings(&self) -> [Holding; 3] {
        let bytes = |count: fn(&OutputSlice) -> u32| {
            let counts = self.outputs.iter().map(|output| u64::from(count(output)));
            4 * counts.sum::<u64>()
        };
        let indices = IndexBytes {
            top_caps: bytes(|output| output.top_count),
            bottom_caps: bytes(|output| output.bottom_count),
            walls: bytes(|output| output.upper_count - output.top_count),
            spared: bytes(|output| output.top_count - output.bottom_count),
        };
        indices.holdings(&[self.indices.buffer.size()])
    }
}

/// A list of volumes.
#[derive(Debug)]
pub(crate) struct Expanded {
    pub(crate) indices: Filled,
    outputs: Vec<OutputSlice>,
}

/// Corners in clip space.
#[derive(Debug)]
pub(crate) struct Placed {
    pub(crate) corners: Filled,
    /// Of the plan's regions, in its order.
    first_corners: Vec<u32>,
}

/// What the device decides draws by, and the draws.
#[derive(Debug)]
pub(crate) struct Culling {
    pub(crate) draws: wgpu::Buffer,
    pub(crate) bind_group: wgpu::BindGroup,
    states: wgpu::Buffer,
    /// Of the plan's regions, in its order.
    meshes: Vec<usize>,
    bytes: u64,
    /// Of a list of boxes without one.
    padding_bytes: u64,
}

impl Placed {
    fn base_vertex(&self, planned: usize) -> i32 {
        i32::try_from(self.first_corners[planned]).unwrap_or(i32::MAX)
    }
}

fn read_vec<T: bytemuck::Pod>(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<T>, DeviceError> {
    Ok(bytemuck::pod_collect_to_vec(&read_buffer(gpu, buffer)?))
}

/// Bytes of a storage binding, which may not be empty.
fn storage_bytes<T: bytemuck::Pod>(elements: &[T]) -> Vec<u8> {
    if elements.is_empty() {
        vec![0; size_of::<T>()]
    } else {
        bytemuck::cast_slice(elements).to_vec()
    }
}

impl RegionVolumes for ComputeVolumes {
    const TECHNIQUE: &'static str = "compute";
    type Executor = VolumeFill;
    type Variant = ComputeVariant;

    fn switches(variant: ComputeVariant) -> Result<Switches, DeviceError> {
        variant.check()?;
        Ok(variant.switches)
    }

    fn new(fill: &VolumeFill, variant: ComputeVariant) -> Result<Self, DeviceError> {
        let gpu = fill.gpu();
        // A draw finds its region by the instance number, which indirect draws may not have
        // otherwise.
        let first_instance = wgpu::Features::INDIRECT_FIRST_INSTANCE;
        if variant.culling != GpuCulling::Off {
            gpu.require(first_instance, "a first instance in indirect draws")?;
        }
        Ok(Self {
            variant,
            capacity: Capacity::of(&gpu.device.limits()),
            pipelines: Pipelines::new(fill, variant)?,
            scene: None,
            laid_out: LaidOut::default(),
            view: ViewBuffers::default(),
            decided_draws: Vec::new(),
            drawn_parts: DrawnOfMeshes::new(),
        })
    }

    fn places(&self) -> Option<impl Fn(usize) -> VolumePlace> {
        let scene = self.scene.as_ref()?;
        Some(|mesh: usize| scene.meshes[mesh].place)
    }

    /// What the compute pass reads besides positions is held for [`Feature::Expansion`], what it writes for
    /// the caps and walls that it is.
    fn holdings(&self) -> Vec<Holding> {
        let mut all = vec![Holding {
            pipelines: self.pipelines.of_compute(),
            ..Holding::of(Feature::Expansion)
        }];
        all.extend(self.pipelines.holdings());
        if let Some(scene) = &self.scene {
            let [vertices, indices] = [
                scene.bytes.input_vertex_bytes,
                scene.bytes.input_index_bytes,
            ];
            let positions = [scene.positions.size()];
            all.push(Holding::vertices(Feature::Positions, vertices, &positions));
            let read = [scene.indices.size()];
            all.push(Holding::indices(Feature::Expansion, indices, &read));
        }
        if let Some(placed) = &self.view.placed {
            let corners = &placed.corners;
            let (written, buffers) = (corners.output_bytes, [corners.buffer.size()]);
            all.push(Holding::vertices(Feature::Positions, written, &buffers));
            all.push(corners.work_held());
        }
        if let Some(expanded) = self.expanded() {
            all.extend(expanded.holdings());
            all.push(expanded.indices.work_held());
        }
        if let Some(culling) = &self.view.culling {
            let constants = MemoryUse {
                constant_bytes: culling.bytes,
                padding_bytes: culling.padding_bytes,
                // Draws, boxes, horizon, states.
                buffers: 4,
                ..MemoryUse::default()
            };
            all.push(Holding::memory(Feature::Expansion, constants));
        }
        all
    }

    fn stores_bottom_caps(&self) -> bool {
        self.variant.expansion == Expansion::Cached
    }

    fn vertices_by_device(&self, fill: &VolumeFill) -> Result<u64, DeviceError> {
        let Some(culling) = &self.view.culling else {
            return Ok(0);
        };
        let arguments: Vec<DrawArguments> = read_vec(&fill.gpu(), &culling.draws)?;
        let vertices = |&draw: &usize| u64::from(arguments[draw].index_count);
        Ok(self.decided_draws.iter().map(vertices).sum())
    }

    fn upload(
        &mut self,
        fill: &VolumeFill,
        input: &FillInput,
        bottoms: &HeldMeshes,
    ) -> Result<(), DeviceError> {
        let gpu = fill.gpu();
        let (meshes, by_part) = (&input.scene.meshes, self.variant.parts);
        let geometry = self.laid_out.all(
            meshes,
            |_| by_part,
            |places| SceneGeometry::in_parts(&meshes[places], by_part),
            SceneGeometry::append,
        );
        let bytes = geometry.bytes();
        let capacity = self.capacity;
        capacity.check_bytes("positions", bytes.input_vertex_bytes)?;
        capacity.check_bytes("mesh indices", bytes.input_index_bytes)?;
        let storage = wgpu::BufferUsages::STORAGE;
        let positions: &[u8] = bytemuck::cast_slice(&geometry.positions);
        let positions = gpu.upload("positions", positions, storage)?;
        let indices: &[u8] = bytemuck::cast_slice(&geometry.indices);
        let indices = gpu.upload("mesh indices", indices, storage)?;
        let layout = &self.pipelines.bindings.geometry;
        let bind_group = gpu.bind_buffers("meshes", layout, &[&positions, &indices]);
        let work = (geometry.meshes.as_slice(), bottoms);
        let expanded = self.expand_scene(&gpu, input, work, &bind_group)?;
        self.scene = Some(SceneBuffers {
            meshes: geometry.meshes,
            positions,
            indices,
            index_words: geometry.indices,
            bind_group,
            bytes,
            bottoms: bottoms.clone(),
            expanded,
        });
        Ok(())
    }

    /// Volumes that are kept are all made anew.
    fn rewrite(
        &mut self,
        fill: &VolumeFill,
        input: &FillInput,
        changed: &[usize],
    ) -> Result<bool, DeviceError> {
        let Some(mut scene) = self.scene.take() else {
            return Ok(false);
        };
        let gpu = fill.gpu();
        let is_rewritten = scene.rewrite(&gpu, input, changed, self.variant.parts);
        if is_rewritten {
            let work = (scene.meshes.as_slice(), &scene.bottoms);
            scene.expanded = self.expand_scene(&gpu, input, work, &scene.bind_group)?;
        }
        self.scene = Some(scene);
        Ok(is_rewritten)
    }

    fn upload_view(
        &mut self,
        fill: &VolumeFill,
        input: &FillInput,
        bottoms: &HeldMeshes,
    ) -> Result<(), DeviceError> {
        self.view = ViewBuffers::default();
        // Of a view that draws nothing, no compute pass would clear them.
        self.decided_draws.clear();
        self.drawn_parts = if self.variant.parts {
            DrawnParts::of_view(input, WallIndices::LIST)
        } else {
            DrawnOfMeshes::new()
        };
        let Some(scene) = &self.scene else {
            return Ok(());
        };
        let gpu = &fill.gpu();
        let planned = &input.plan.regions;
        let expanded = match self.variant.expansion {
            Expansion::Cached => None,
            Expansion::PerFrame => {
                let mesh = |region: &PlannedRegion| {
                    let mesh = region.mesh;
                    let slice = &scene.meshes[mesh];
                    (&*input.scene.meshes[mesh], slice, bottoms.has(mesh))
                };
                let plan = ExpansionPlan::new(planned.iter().map(mesh))?;
                Some(self.make_room(gpu, plan)?)
            }
        };
        let placed = match self.variant.transform {
            Transform::VertexStage => None,
            Transform::ComputeStage => Some(self.make_placed(gpu, input)?),
        };
        self.view.expanded = expanded;
        self.view.placed = placed;
        if self.variant.culling != GpuCulling::Off {
            let region = |(index, planned): (usize, &PlannedRegion)| {
                let output = self.output(index, planned.mesh)?;
                let base_vertex = self.base_vertex(index);
                Some(CullRegion::new(input, planned, output, base_vertex))
            };
            let regions = planned.iter().enumerate().filter_map(region).collect();
            self.view.culling = Some(self.upload_culling(gpu, input, regions)?);
        }
        let constant_bytes = VolumeConstants::byte_count(input);
        self.capacity
            .check_bytes("region constants", constant_bytes)
    }
}

impl ComputeVolumes {
    /// Holds itself to `capacity`, which may be less than the device's.
    pub fn set_capacity(&mut self, capacity: Capacity) {
        self.capacity = capacity;
    }

    /// The list of volumes, whoever made it.
    pub(crate) fn expanded(&self) -> Option<&Expanded> {
        let of_scene = self.scene.as_ref().and_then(|s| s.expanded.as_ref());
        self.view.expanded.as_ref().or(of_scene)
    }

    /// Where the volume of a planned region lies in it.
    pub(crate) fn output(&self, planned: usize, mesh: usize) -> Option<OutputSlice> {
        let cached = self.scene.as_ref().and_then(|s| s.expanded.as_ref());
        match (cached, &self.view.expanded) {
            (Some(cached), _) => Some(cached.outputs[mesh]),
            (None, expanded) => expanded.as_ref().map(|e| e.outputs[planned]),
        }
    }

    /// What is added to the indices of a planned region.
    pub(crate) fn base_vertex(&self, planned: usize) -> i32 {
        let placed = self.view.placed.as_ref();
        placed.map_or(0, |placed| placed.base_vertex(planned))
    }

    /// Bytes as allocated for the input that was prepared last: of the whole scene what is read,
    /// and of what is written the whole scene when cached, otherwise the regions in the plan.
    #[must_use]
    pub fn bytes(&self) -> ComputeBytes {
        let (scene, placed) = (self.scene.as_ref(), self.view.placed.as_ref());
        ComputeBytes {
            output_index_bytes: self.expanded().map_or(0, |e| e.indices.output_bytes),
            output_vertex_bytes: placed.map_or(0, |placed| placed.corners.output_bytes),
            ..scene.map_or(ComputeBytes::default(), |scene| scene.bytes)
        }
    }

    /// Regions of the plan that the device left out of the last frame, as indices into the scene's
    /// meshes. None without culling on the device.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn left_out(&self, fill: &VolumeFill) -> Result<Vec<usize>, DeviceError> {
        let Some(culling) = &self.view.culling else {
            return Ok(Vec::new());
        };
        let states: Vec<u32> = read_vec(&fill.gpu(), &culling.states)?;
        let planned = culling.meshes.iter().zip(states);
        Ok(planned
            .filter(|&(_, state)| state == LEFT_OUT)
            .map(|(&mesh, _)| mesh)
            .collect())
    }

    /// The volumes of the whole scene, where they are kept.
    fn expand_scene(
        &self,
        gpu: &Gpu,
        input: &FillInput,
        (slices, bottoms): (&[MeshSlice], &HeldMeshes),
        bind_group: &wgpu::BindGroup,
    ) -> Result<Option<Expanded>, DeviceError> {
        if self.variant.expansion == Expansion::PerFrame {
            return Ok(None);
        }
        let meshes = input.scene.meshes.iter().zip(slices).enumerate();
        let meshes = meshes.map(|(place, (mesh, slice))| (&**mesh, slice, bottoms.has(place)));
        let expanded = self.make_room(gpu, ExpansionPlan::new(meshes)?)?;
        self.expand_once(gpu, bind_group, &expanded);
        Ok(Some(expanded))
    }

    /// A list of exactly the size that `plan` fills, not filled yet.
    fn make_room(&self, gpu: &Gpu, plan: ExpansionPlan) -> Result<Expanded, DeviceError> {
        let labels = ["expanded volumes", "expansion work"];
        let (bytes, usage) = (plan.output_bytes(), wgpu::BufferUsages::INDEX);
        Ok(Expanded {
            indices: self.make_filled(gpu, labels, &plan.work, bytes, usage)?,
            outputs: plan.outputs,
        })
    }

    /// Room for the corners of the regions in the plan.
    fn make_placed(&self, gpu: &Gpu, input: &FillInput) -> Result<Placed, DeviceError> {
        let planned = input.plan.regions.iter();
        let plan = PlacingPlan::new(planned.map(|planned| &*input.scene.meshes[planned.mesh]))?;
        let labels = ["corners in clip space", "placing work"];
        let (bytes, usage) = (plan.output_bytes(), wgpu::BufferUsages::VERTEX);
        Ok(Placed {
            corners: self.make_filled(gpu, labels, &plan.work, bytes, usage)?,
            first_corners: plan.first_corners,
        })
    }

    /// - `labels`: of the buffer and of the work that fills it
    fn make_filled(
        &self,
        gpu: &Gpu,
        [label, work_label]: [&str; 2],
        work: &[WorkGroup],
        output_bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<Filled, DeviceError> {
        let work_bytes = size_of_val(work) as u64;
        self.capacity.check_bytes(label, output_bytes)?;
        self.capacity.check_bytes(work_label, work_bytes)?;
        let dispatch_size = self.capacity.dispatch_size(work.len())?;
        let storage = wgpu::BufferUsages::STORAGE;
        // A binding of 0 bytes is not allowed; an empty plan draws nothing. 16 are one corner.
        let buffer = gpu.unwritten(label, output_bytes.max(16), storage | usage);
        let work = gpu.upload(work_label, &storage_bytes(work), storage)?;
        let layout = &self.pipelines.bindings.expansion;
        Ok(Filled {
            bind_group: gpu.bind_buffers(label, layout, &[&work, &buffer]),
            buffer,
            work,
            dispatch_size,
            output_bytes,
            work_bytes,
        })
    }

    fn expand_once(&self, gpu: &Gpu, meshes: &wgpu::BindGroup, expanded: &Expanded) {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipelines.expand);
        pass.set_bind_group(1, meshes, &[]);
        pass.set_bind_group(2, &expanded.indices.bind_group, &[]);
        expanded.indices.dispatch(&mut pass);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
    }

    fn upload_culling(
        &self,
        gpu: &Gpu,
        input: &FillInput,
        regions: Vec<CullRegion>,
    ) -> Result<Culling, DeviceError> {
        let planned = &input.plan.regions;
        let draw_bytes = 2 * (size_of::<DrawArguments>() * planned.len().max(1)) as u64;
        let region_bytes = size_of_val(&*regions) as u64;
        self.capacity.check_bytes("draw arguments", draw_bytes)?;
        self.capacity.check_bytes("region boxes", region_bytes)?;
        let horizon = Horizon::new(input);
        let horizon_bytes = size_of_val(&horizon) as u64;
        let uniform = wgpu::BufferUsages::UNIFORM;
        let horizon = gpu.upload("horizon", bytemuck::bytes_of(&horizon), uniform)?;
        let regions = storage_bytes(&regions);
        let padding_bytes = regions.len() as u64 - region_bytes;
        let regions = gpu.upload("region boxes", &regions, wgpu::BufferUsages::STORAGE)?;
        let read_back = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let arguments = read_back | wgpu::BufferUsages::INDIRECT;
        let draws = gpu.unwritten("draw arguments", draw_bytes, arguments);
        let state_bytes = 4 * planned.len().max(1) as u64;
        let states = gpu.unwritten("region states", state_bytes, read_back);
        let layout = &self.pipelines.bindings.culling;
        let buffers = [&draws, &regions, &horizon, &states];
        Ok(Culling {
            bind_group: gpu.bind_buffers("culling", layout, &buffers),
            draws,
            states,
            meshes: planned.iter().map(|planned| planned.mesh).collect(),
            bytes: draw_bytes + region_bytes + horizon_bytes + state_bytes,
            padding_bytes,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute_bytes;
    use terrafill_contract::{FillBackend as _, PreparedScene};
    use terrafill_core::RegionMesh;
    use terrafill_gpu::{GpuOptions, RenderTargets, open_for_test};
    use terrafill_plan::{PlanOptions, RegionSet};
    use terrafill_scene::{ImageSize, Scene};
    use terrafill_surface::{EllipsoidKind, open_surface};

    #[test]
    fn a_view_that_does_not_fit_leaves_none_prepared() {
        let Some(gpu) = open_for_test(&GpuOptions::default()) else {
            return;
        };
        let scene = Scene::shipped("california", None).expect("it ships");
        let (body, rule) = (&scene.body, scene.edge_rule);
        let meshes = RegionMesh::build_all(&scene.regions, body, rule, &scene.mesh);
        let meshes: RegionSet = meshes.expect("it meshes").into();
        let surface = open_surface(&[&EllipsoidKind], &scene).expect("a surface");
        let prepared = PreparedScene::new(&scene, meshes.clone(), surface);
        let size = ImageSize::new(16, 16);
        let full = FillInput::new(&prepared, &scene.views[0], size, PlanOptions::default())
            .expect("a surface");
        let mut empty = full.clone();
        empty.plan.regions.clear();
        // The meshes fit, and their volumes do not.
        let bytes = compute_bytes(&meshes[0]);
        let limits = gpu.device.limits();
        let capacity = Capacity {
            storage_bytes: bytes.input_vertex_bytes.max(bytes.input_index_bytes),
            ..Capacity::of(&limits)
        };
        assert!(bytes.output_index_bytes > capacity.storage_bytes);
        let targets = RenderTargets::shared(&gpu, size).expect("a size every device has");
        let variant = ComputeVariant::default();
        let mut backend = ComputeBackend::new(&targets, variant).expect("valid shaders");
        backend.volumes_mut().set_capacity(capacity);
        backend.prepare(&empty).expect("nothing to expand");
        backend.render(&empty).expect("prepared");
        let error = backend.prepare(&full).expect_err("too large");
        assert!(error.to_string().contains("expanded volumes"), "{error}");
        let error = backend.render(&empty).expect_err("no longer prepared");
        assert!(matches!(error, DeviceError::NotPrepared { .. }), "{error}");
        // Negative control: what fits can be prepared again.
        backend.prepare(&empty).expect("as before");
        backend.render(&empty).expect("prepared");
    }
}
