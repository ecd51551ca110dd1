// SPDX-License-Identifier: MIT OR Apache-2.0
//! The backend: buffers of a scene, constants of a view, and the passes of a frame.

use crate::culling::{CullRegion, DrawArguments, Horizon, LEFT_OUT};
use crate::expansion::{Capacity, ExpansionPlan, OutputSlice, PlacingPlan};
use crate::layout::{MeshSlice, SceneGeometry};
use crate::pass::{Recorder, counted};
use crate::pipeline::{NUMBER_FORMAT, Pipelines, State};
use crate::statistics::Statistics;
use crate::{ComputeBytes, ComputeVariant, Expansion, GpuCulling, Transform};
use std::sync::Arc;
use terrafill_core::RegionMesh;
use terrafill_frame::{
    Backend, BackendError, Capabilities, Counters, FillPass, FillProgram, Frame, FrameInput,
    FrameTimes, MAX_REGIONS, MemoryUse, Picture, RegionConstants, TimedBackend, VolumeBackend,
    id_rgba, ids_of, palette_rgba,
};
use terrafill_gpu::{CpuStopwatch, Gpu, SharedStage, Stage, TimedPass, WorkDone, read_buffer};
use terrafill_scene::{ImageSize, PlannedRegion};

/// Shadow volumes made by a compute pass.
#[derive(Debug)]
pub struct ComputeBackend {
    stage: SharedStage,
    variant: ComputeVariant,
    capacity: Capacity,
    capabilities: Capabilities,
    pub(crate) pipelines: Pipelines,
    scene: Option<SceneBuffers>,
    view: Option<ViewBuffers>,
    /// Asked of the device since the last frame that was counted.
    work: WorkDone,
}

/// Meshes of every region of a scene, in view or not.
#[derive(Debug)]
pub(crate) struct SceneBuffers {
    source: Arc<[RegionMesh]>,
    meshes: Vec<MeshSlice>,
    positions: wgpu::Buffer,
    indices: wgpu::Buffer,
    /// Both of them.
    pub(crate) bind_group: wgpu::BindGroup,
    bytes: ComputeBytes,
    /// [`Expansion::Cached`]: all volumes, by mesh.
    pub(crate) expanded: Option<Expanded>,
}

/// A list of volumes, and what it takes to make it.
#[derive(Debug)]
pub(crate) struct Expanded {
    pub(crate) indices: wgpu::Buffer,
    pub(crate) outputs: Vec<OutputSlice>,
    work: wgpu::Buffer,
    pub(crate) bind_group: wgpu::BindGroup,
    pub(crate) dispatch_size: [u32; 2],
    output_bytes: u64,
    work_bytes: u64,
}

/// Corners in clip space, and what it takes to put them there.
#[derive(Debug)]
pub(crate) struct Placed {
    pub(crate) corners: wgpu::Buffer,
    /// Of the plan's regions, in its order.
    first_corners: Vec<u32>,
    work: wgpu::Buffer,
    pub(crate) bind_group: wgpu::BindGroup,
    pub(crate) dispatch_size: [u32; 2],
    output_bytes: u64,
    work_bytes: u64,
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
}

fn read_vec<T: bytemuck::Pod>(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<T>, BackendError> {
    Ok(bytemuck::pod_collect_to_vec(&read_buffer(gpu, buffer)?))
}

/// Constants of the regions of a view, what is made for it, and the order to draw in.
#[derive(Debug)]
pub(crate) struct ViewBuffers {
    source: Arc<[[f32; 3]]>,
    constants: wgpu::Buffer,
    constant_bytes: u64,
    pub(crate) bind_group: wgpu::BindGroup,
    pub(crate) program: FillProgram,
    /// [`Expansion::PerFrame`]: volumes in the plan, by their place in it.
    pub(crate) expanded: Option<Expanded>,
    pub(crate) culling: Option<Culling>,
    /// [`Transform::ComputeStage`]: corners of the regions in the plan.
    pub(crate) placed: Option<Placed>,
    /// Where volumes add their numbers, if the program does so.
    pub(crate) numbers: Option<Numbers>,
}

/// A target of numbers, drawn into and read.
#[derive(Debug)]
pub(crate) struct Numbers {
    pub(crate) target: wgpu::TextureView,
    pub(crate) bind_group: wgpu::BindGroup,
}

impl Numbers {
    fn new(gpu: &Gpu, size: ImageSize, layout: &wgpu::BindGroupLayout) -> Self {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("numbers"),
            size: wgpu::Extent3d {
                width: size.width,
                height: size.height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: NUMBER_FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let target = texture.create_view(&Default::default());
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("numbers"),
            layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&target),
            }],
        });
        Self { target, bind_group }
    }
}

impl ViewBuffers {
    /// Whether a frame has a compute pass.
    pub(crate) fn computes(&self) -> bool {
        self.expanded.is_some() || self.culling.is_some() || self.placed.is_some()
    }

    /// What is added to the indices of a planned region.
    pub(crate) fn base_vertex(&self, planned: usize) -> i32 {
        base_vertex(self.placed.as_ref(), planned)
    }

    /// Places of the planned regions' volumes, where they are made every frame.
    pub(crate) fn outputs(&self) -> &[OutputSlice] {
        self.expanded
            .as_ref()
            .map_or(&[], |expanded| &expanded.outputs)
    }
}

fn base_vertex(placed: Option<&Placed>, planned: usize) -> i32 {
    let first = placed.map_or(0, |placed| placed.first_corners[planned]);
    i32::try_from(first).unwrap_or(i32::MAX)
}

/// What the colour pass writes for region `index`.
type ColourOf = fn(usize) -> [f32; 4];

fn bind(
    gpu: &Gpu,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(label),
        layout,
        entries: &entries,
    })
}

/// Bytes of a storage binding, which may not be empty.
fn storage_bytes<T: bytemuck::Pod>(elements: &[T]) -> Vec<u8> {
    if elements.is_empty() {
        vec![0; size_of::<T>()]
    } else {
        bytemuck::cast_slice(elements).to_vec()
    }
}

impl ComputeBackend {
    /// A backend on `stage`.
    ///
    /// # Errors
    /// [`BackendError::Shader`], [`BackendError::Switch`], [`BackendError::Unsupported`].
    pub fn new(stage: &SharedStage, variant: ComputeVariant) -> Result<Self, BackendError> {
        let capacity = Capacity::of(&stage.borrow().gpu().device.limits());
        Self::with_capacity(stage, variant, capacity)
    }

    /// The same, holding itself to `capacity`, which may be less than the device's.
    ///
    /// # Errors
    /// As [`ComputeBackend::new`].
    pub fn with_capacity(
        stage: &SharedStage,
        variant: ComputeVariant,
        capacity: Capacity,
    ) -> Result<Self, BackendError> {
        variant.check()?;
        let gpu = Arc::clone(stage.borrow().gpu());
        // A draw finds its region by the instance number, which indirect draws may not have
        // otherwise.
        let first_instance = wgpu::Features::INDIRECT_FIRST_INSTANCE;
        if variant.culling != GpuCulling::Off && !gpu.device.features().contains(first_instance) {
            return Err(BackendError::Unsupported {
                capability: "a first instance in indirect draws".to_owned(),
                adapter: gpu.facts.name.clone(),
            });
        }
        Ok(Self {
            stage: SharedStage::clone(stage),
            variant,
            capacity,
            capabilities: Capabilities {
                backend: "compute",
                adapter: format!("{} ({})", gpu.facts.name, gpu.facts.driver_info),
                gpu_timestamps: gpu.facts.timestamps,
                pipeline_statistics: gpu.facts.pipeline_statistics,
            },
            pipelines: Pipelines::new(&gpu, variant)?,
            scene: None,
            view: None,
            work: WorkDone::default(),
        })
    }

    /// The switches.
    #[must_use]
    pub fn variant(&self) -> ComputeVariant {
        self.variant
    }

    /// Bytes as allocated for the input that was prepared last: of the whole scene what is read,
    /// and of what is written the whole scene when cached, otherwise the regions in the plan.
    #[must_use]
    pub fn bytes(&self) -> ComputeBytes {
        let scene = self.scene.as_ref();
        ComputeBytes {
            output_index_bytes: self.expanded().map_or(0, |e| e.output_bytes),
            output_vertex_bytes: self.placed().map_or(0, |placed| placed.output_bytes),
            ..scene.map_or(ComputeBytes::default(), |scene| scene.bytes)
        }
    }

    fn expanded(&self) -> Option<&Expanded> {
        let of_view = self.view.as_ref().and_then(|view| view.expanded.as_ref());
        of_view.or(self.scene.as_ref()?.expanded.as_ref())
    }

    fn placed(&self) -> Option<&Placed> {
        self.view.as_ref()?.placed.as_ref()
    }

    fn draw_and_read(&mut self, input: &FrameInput) -> Result<(Picture, Counters), BackendError> {
        self.check_prepared(input)?;
        let mut stage = self.stage.borrow_mut();
        stage.prepare(input)?;
        stage.draw_surface()?;
        let gpu = Arc::clone(stage.gpu());
        let statistics = Statistics::new(&gpu, self.pass_count());
        let before = gpu.work_done();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let (mut counters, indirect_draws) =
            self.record(&mut encoder, &stage, input, statistics.as_ref(), false)?;
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let done = gpu.work_done() - before;
        self.work = self.work + done;
        counters.buffer_creations = self.work.buffer_creations;
        counters.pipeline_creations = self.work.pipeline_creations;
        counters.uploads = self.work.uploads;
        counters.upload_bytes = done.upload_bytes;
        self.work = WorkDone::default();
        counters.vertices += self.drawn_by_device(&gpu, &indirect_draws)?;
        if let Some(statistics) = &statistics {
            statistics.read_into(&gpu, &mut counters)?;
        }
        Ok((stage.read()?, counters))
    }

    /// How many fragments the volumes of the stencil work have, by an extra pass that is never
    /// timed; `None` where the device cannot count them.
    fn count_fragments(&mut self, input: &FrameInput) -> Result<Option<u64>, BackendError> {
        let gpu = Arc::clone(self.stage.borrow().gpu());
        let Some(view) = &self.view else {
            return Ok(None);
        };
        if view.program.passes.is_empty() {
            return Ok(Some(0));
        }
        let Some(statistics) = Statistics::new(&gpu, 1) else {
            return Ok(None);
        };
        for (faces, ..) in counted(&view.program) {
            self.pipelines.ensure_volumes(&gpu, State::Count { faces });
        }
        let stage = self.stage.borrow();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        if let Some(mut recorder) = self.recorder(&stage, input, Some(&statistics), false) {
            recorder.count_fragments(&mut encoder);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let mut counted = Counters::default();
        statistics.read_into(&gpu, &mut counted)?;
        Ok(counted.fragment_shader_invocations)
    }

    /// Vertices of draws whose size only the device knows.
    fn drawn_by_device(&self, gpu: &Gpu, draws: &[usize]) -> Result<u64, BackendError> {
        let Some(culling) = self.culling() else {
            return Ok(0);
        };
        let arguments: Vec<DrawArguments> = read_vec(gpu, &culling.draws)?;
        let vertices = |&draw: &usize| u64::from(arguments[draw].index_count);
        Ok(draws.iter().map(vertices).sum())
    }

    fn culling(&self) -> Option<&Culling> {
        self.view.as_ref()?.culling.as_ref()
    }

    /// Regions of the plan that the device left out of the last frame, as indices into the scene's
    /// meshes. None without culling on the device.
    ///
    /// # Errors
    /// [`BackendError::DeviceLost`].
    pub fn regions_left_out(&self) -> Result<Vec<usize>, BackendError> {
        let Some(culling) = self.culling() else {
            return Ok(Vec::new());
        };
        let states: Vec<u32> = read_vec(self.stage.borrow().gpu(), &culling.states)?;
        let planned = culling.meshes.iter().zip(states);
        Ok(planned
            .filter(|&(_, state)| state == LEFT_OUT)
            .map(|(&mesh, _)| mesh)
            .collect())
    }

    fn check_prepared(&self, input: &FrameInput) -> Result<(), BackendError> {
        let is_same_view = self
            .view
            .as_ref()
            .is_some_and(|view| Arc::ptr_eq(&view.source, &input.surface_rte));
        let is_same_scene = self
            .scene
            .as_ref()
            .is_some_and(|scene| Arc::ptr_eq(&scene.source, &input.scene.meshes));
        if is_same_view && is_same_scene {
            return Ok(());
        }
        Err(BackendError::NotPrepared {
            backend: "compute",
            scene: input.scene.name.clone(),
            view: input.view.clone(),
        })
    }

    fn upload_scene(&mut self, input: &FrameInput) -> Result<(), BackendError> {
        let geometry = SceneGeometry::build(&input.scene.meshes);
        let bytes = geometry.bytes();
        let capacity = self.capacity;
        capacity.check_bytes("positions", bytes.input_vertex_bytes)?;
        capacity.check_bytes("mesh indices", bytes.input_index_bytes)?;
        let stage = self.stage.borrow();
        let storage = wgpu::BufferUsages::STORAGE;
        let positions: &[u8] = bytemuck::cast_slice(&geometry.positions);
        let positions = stage.upload("positions", positions, storage)?;
        let indices: &[u8] = bytemuck::cast_slice(&geometry.indices);
        let indices = stage.upload("mesh indices", indices, storage)?;
        let layout = &self.pipelines.bindings.geometry;
        let bind_group = bind(stage.gpu(), "meshes", layout, &[&positions, &indices]);
        let expanded = match self.variant.expansion {
            Expansion::PerFrame => None,
            Expansion::Cached => {
                let meshes = input.scene.meshes.iter().zip(&geometry.meshes);
                let expanded = self.make_room(&stage, &ExpansionPlan::new(meshes)?)?;
                self.expand_once(stage.gpu(), &bind_group, &expanded);
                Some(expanded)
            }
        };
        drop(stage);
        self.scene = Some(SceneBuffers {
            source: Arc::clone(&input.scene.meshes),
            meshes: geometry.meshes,
            positions,
            indices,
            bind_group,
            bytes,
            expanded,
        });
        Ok(())
    }

    /// A list of exactly the size that `plan` fills, not filled yet.
    fn make_room(&self, stage: &Stage, plan: &ExpansionPlan) -> Result<Expanded, BackendError> {
        let (output_bytes, work_bytes) = (plan.output_bytes(), size_of_val(&*plan.work) as u64);
        self.capacity
            .check_bytes("expanded volumes", output_bytes)?;
        self.capacity.check_bytes("expansion work", work_bytes)?;
        let dispatch_size = self.capacity.dispatch_size(plan.work.len())?;
        let gpu = stage.gpu();
        let indices = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: Some("expanded volumes"),
            // A buffer of 0 bytes is not allowed; an empty plan draws nothing.
            size: output_bytes.max(wgpu::COPY_BUFFER_ALIGNMENT),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDEX,
            mapped_at_creation: false,
        });
        let work = storage_bytes(&plan.work);
        let work = stage.upload("expansion work", &work, wgpu::BufferUsages::STORAGE)?;
        let layout = &self.pipelines.bindings.expansion;
        Ok(Expanded {
            bind_group: bind(gpu, "expansion", layout, &[&work, &indices]),
            indices,
            outputs: plan.outputs.clone(),
            work,
            dispatch_size,
            output_bytes,
            work_bytes,
        })
    }

    /// Room for the corners of the regions in the plan.
    fn make_placed(&self, stage: &Stage, input: &FrameInput) -> Result<Placed, BackendError> {
        let planned = input.plan.regions.iter();
        let plan = PlacingPlan::new(planned.map(|planned| &input.scene.meshes[planned.mesh]))?;
        let (output_bytes, work_bytes) = (plan.output_bytes(), size_of_val(&*plan.work) as u64);
        self.capacity
            .check_bytes("corners in clip space", output_bytes)?;
        self.capacity.check_bytes("placing work", work_bytes)?;
        let dispatch_size = self.capacity.dispatch_size(plan.work.len())?;
        let gpu = stage.gpu();
        let corners = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: Some("corners in clip space"),
            // As above; 16 bytes are one corner.
            size: output_bytes.max(16),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::VERTEX,
            mapped_at_creation: false,
        });
        let work = storage_bytes(&plan.work);
        let work = stage.upload("placing work", &work, wgpu::BufferUsages::STORAGE)?;
        let layout = &self.pipelines.bindings.expansion;
        Ok(Placed {
            bind_group: bind(gpu, "placing", layout, &[&work, &corners]),
            corners,
            first_corners: plan.first_corners,
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
        pass.set_bind_group(2, &expanded.bind_group, &[]);
        let [columns, rows] = expanded.dispatch_size;
        pass.dispatch_workgroups(columns, rows, 1);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
    }

    fn upload_view(&mut self, input: &FrameInput, colour_of: ColourOf) -> Result<(), BackendError> {
        let Some(scene) = &self.scene else {
            return self.check_prepared(input);
        };
        let planned = &input.plan.regions;
        let program = FillProgram::new(&input.plan, &self.variant.switches, input.scene.overlap)?;
        let stage = self.stage.borrow();
        let expanded = match self.variant.expansion {
            Expansion::Cached => None,
            Expansion::PerFrame => {
                let mesh = |region: &PlannedRegion| {
                    (&input.scene.meshes[region.mesh], &scene.meshes[region.mesh])
                };
                let plan = ExpansionPlan::new(planned.iter().map(mesh))?;
                Some(self.make_room(&stage, &plan)?)
            }
        };
        let placed = match self.variant.transform {
            Transform::VertexStage => None,
            Transform::ComputeStage => Some(self.make_placed(&stage, input)?),
        };
        let culling = match self.variant.culling {
            GpuCulling::Off => None,
            _ => {
                let base_vertex = |planned| base_vertex(placed.as_ref(), planned);
                let output = |index: usize, mesh: usize| match (&scene.expanded, &expanded) {
                    (Some(cached), _) => Some(cached.outputs[mesh]),
                    (None, expanded) => expanded.as_ref().map(|e| e.outputs[index]),
                };
                let region = |(index, planned): (usize, &PlannedRegion)| {
                    let output = output(index, planned.mesh)?;
                    Some(CullRegion::new(input, planned, output, base_vertex(index)))
                };
                let regions = planned.iter().enumerate().filter_map(region).collect();
                Some(self.upload_culling(&stage, input, regions)?)
            }
        };
        let constants: Vec<RegionConstants> = planned
            .iter()
            .map(|planned| region_constants(input, scene, planned, colour_of))
            .collect();
        let constant_bytes = size_of_val(&*constants) as u64;
        self.capacity
            .check_bytes("region constants", constant_bytes)?;
        let constants = storage_bytes(&constants);
        let storage = wgpu::BufferUsages::STORAGE;
        let constants = stage.upload("region constants", &constants, storage)?;
        let buffers = [stage.view_constants(), &constants];
        let bindings = &self.pipelines.bindings;
        let bind_group = bind(stage.gpu(), "view and regions", &bindings.frame, &buffers);
        let numbers = program
            .passes
            .iter()
            .any(FillPass::accumulates)
            .then(|| Numbers::new(stage.gpu(), input.size, &bindings.numbers));
        drop(stage);
        self.view = Some(ViewBuffers {
            source: Arc::clone(&input.surface_rte),
            constants,
            constant_bytes,
            bind_group,
            program,
            expanded,
            culling,
            placed,
            numbers,
        });
        Ok(())
    }

    fn upload_culling(
        &self,
        stage: &Stage,
        input: &FrameInput,
        regions: Vec<CullRegion>,
    ) -> Result<Culling, BackendError> {
        let planned = &input.plan.regions;
        let draw_bytes = 2 * (size_of::<DrawArguments>() * planned.len().max(1)) as u64;
        let region_bytes = size_of_val(&*regions) as u64;
        self.capacity.check_bytes("draw arguments", draw_bytes)?;
        self.capacity.check_bytes("region boxes", region_bytes)?;
        let horizon = Horizon::new(input);
        let horizon_bytes = size_of_val(&horizon) as u64;
        let uniform = wgpu::BufferUsages::UNIFORM;
        let horizon = stage.upload("horizon", bytemuck::bytes_of(&horizon), uniform)?;
        let regions = storage_bytes(&regions);
        let regions = stage.upload("region boxes", &regions, wgpu::BufferUsages::STORAGE)?;
        let gpu = stage.gpu();
        let draws = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: Some("draw arguments"),
            size: draw_bytes,
            usage: wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::INDIRECT
                | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let state_bytes = 4 * planned.len().max(1) as u64;
        let states = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: Some("region states"),
            size: state_bytes,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let layout = &self.pipelines.bindings.culling;
        let buffers = [&draws, &regions, &horizon, &states];
        Ok(Culling {
            bind_group: bind(gpu, "culling", layout, &buffers),
            draws,
            states,
            meshes: planned.iter().map(|planned| planned.mesh).collect(),
            bytes: draw_bytes + region_bytes + horizon_bytes + state_bytes,
        })
    }

    /// Passes that draw; each may have its own statistics query.
    fn pass_count(&self) -> usize {
        self.view
            .as_ref()
            .map_or(0, |view| view.program.passes.len())
    }

    fn ensure_pipelines(&mut self) -> Result<(), BackendError> {
        let Some(view) = &self.view else {
            return Ok(());
        };
        let gpu = Arc::clone(self.stage.borrow().gpu());
        for pass in &view.program.passes {
            for command in &pass.commands {
                self.pipelines.ensure(&gpu, command, pass.has_colour)?;
            }
        }
        Ok(())
    }

    /// Records a frame. With `timed`, GPU stamps surround it; with `statistics`, queries do.
    /// Gives what it counted, and the draws whose size the device decides.
    fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stage: &Stage,
        input: &FrameInput,
        statistics: Option<&Statistics>,
        timed: bool,
    ) -> Result<(Counters, Vec<usize>), BackendError> {
        let Some(mut recorder) = self.recorder(stage, input, statistics, timed) else {
            self.check_prepared(input)?;
            return Ok(Default::default());
        };
        recorder.frame(encoder);
        Ok((recorder.counters, recorder.indirect_draws))
    }

    fn recorder<'a>(
        &'a self,
        stage: &'a Stage,
        input: &'a FrameInput,
        statistics: Option<&'a Statistics>,
        timed: bool,
    ) -> Option<Recorder<'a>> {
        Some(Recorder {
            backend: self,
            scene: self.scene.as_ref()?,
            view: self.view.as_ref()?,
            stage,
            input,
            timed,
            statistics,
            counters: Counters::default(),
            indirect_draws: Vec::new(),
        })
    }

    /// Uploads what is not there yet, and gives how many bytes that took.
    fn bring_up_to_date(&mut self, input: &FrameInput) -> Result<u64, BackendError> {
        let gpu = Arc::clone(self.stage.borrow().gpu());
        let before = gpu.work_done();
        let is_uploaded = self
            .scene
            .as_ref()
            .is_some_and(|scene| Arc::ptr_eq(&scene.source, &input.scene.meshes));
        if !is_uploaded {
            self.upload_scene(input)?;
        }
        self.upload_view(input, id_rgba)?;
        self.ensure_pipelines()?;
        let done = gpu.work_done() - before;
        self.work = self.work + done;
        Ok(done.upload_bytes)
    }

    fn gpu_times(&self, stage: &Stage, times: &mut FrameTimes) -> Result<(), BackendError> {
        let (Some(timer), Some(view)) = (stage.timer(), &self.view) else {
            return Ok(());
        };
        let gpu = stage.gpu();
        match (self.pass_count(), view.computes()) {
            // Nothing in view: no pass was recorded.
            (0, _) => {}
            (1, false) => {
                let stamps = timer.read(gpu, TimedPass::Colour, TimedPass::Colour)?;
                times.fill_gpu_ms = stamps.pass_ms(TimedPass::Colour);
            }
            (passes, _) => {
                let stamps = timer.read(gpu, TimedPass::Stencil, TimedPass::Colour)?;
                times.fill_gpu_ms = stamps.span_ms(TimedPass::Stencil, TimedPass::Colour);
                if passes == 2 {
                    times.stencil_gpu_ms = stamps.pass_ms(TimedPass::Stencil);
                    times.colour_gpu_ms = stamps.pass_ms(TimedPass::Colour);
                }
            }
        }
        Ok(())
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "rounding to what the GPU reads is the purpose"
)]
fn region_constants(
    input: &FrameInput,
    scene: &SceneBuffers,
    planned: &PlannedRegion,
    colour_of: ColourOf,
) -> RegionConstants {
    let slice = &scene.meshes[planned.mesh];
    let fixed = slice.fixed;
    let eye = fixed.eye(input.camera.eye_ecef);
    RegionConstants {
        eye: eye.eye.to_array(),
        shift: eye.shift,
        eye_remainder_m: eye.remainder_m.as_vec3().to_array(),
        scale_m: (fixed.unit_m * f64::from(eye.shift).exp2()) as f32,
        origin_ecef_m: fixed.origin_ecef.as_vec3().to_array(),
        unit_m: fixed.unit_m as f32,
        top_m: planned.heights.top_m as f32,
        bottom_m: planned.heights.bottom_m as f32,
        first_vertex: slice.first_vertex,
        first_triangle_index: slice.first_triangle_index,
        first_loop_index: slice.first_loop_index,
        triangle_count: slice.triangle_count,
        index_bits: if slice.has_short_indices { 16 } else { 32 },
        padding: 0,
        colour: colour_of(planned.region),
    }
}

impl Backend for ComputeBackend {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn prepare(&mut self, input: &FrameInput) -> Result<MemoryUse, BackendError> {
        if input.scene.regions.len() > MAX_REGIONS {
            return Err(BackendError::OverCapacity {
                what: "regions".to_owned(),
                found: input.scene.regions.len() as u64,
                allowed: MAX_REGIONS as u64,
            });
        }
        self.stage.borrow_mut().prepare(input)?;
        let upload_bytes = self.bring_up_to_date(input)?;
        let (Some(scene), Some(view)) = (&self.scene, &self.view) else {
            return Ok(MemoryUse::default());
        };
        let (bytes, expanded) = (self.bytes(), self.expanded());
        let held = [&scene.positions, &scene.indices, &view.constants];
        let lists = expanded.map_or(0, |e| [&e.indices, &e.work].len())
            + self.placed().map_or(0, |p| [&p.corners, &p.work].len());
        Ok(MemoryUse {
            vertex_bytes: bytes.input_vertex_bytes + bytes.output_vertex_bytes,
            index_bytes: bytes.input_index_bytes + bytes.output_index_bytes,
            constant_bytes: view.constant_bytes
                + expanded.map_or(0, |expanded| expanded.work_bytes)
                + self.placed().map_or(0, |placed| placed.work_bytes)
                + self.culling().map_or(0, |culling| culling.bytes),
            // Culling: draws, boxes, horizon, states.
            buffers: (held.len() + lists + self.culling().map_or(0, |_| 4)) as u64,
            upload_bytes,
        })
    }

    fn render(&mut self, input: &FrameInput) -> Result<Frame, BackendError> {
        let (picture, mut counters) = self.draw_and_read(input)?;
        counters.stencil_fragments = self.count_fragments(input)?;
        Ok(Frame {
            size: input.size,
            ids: ids_of(&picture),
            surface: picture.depth.iter().map(|&depth| depth > 0.0).collect(),
            non_finite: picture.depth.iter().filter(|d| !d.is_finite()).count() as u64,
            counters: Some(counters),
            texture: None,
        })
    }
}

impl TimedBackend for ComputeBackend {
    fn time_frame(&mut self, input: &FrameInput) -> Result<FrameTimes, BackendError> {
        self.check_prepared(input)?;
        let stage = self.stage.borrow();
        let gpu = stage.gpu();
        let watch = CpuStopwatch::start();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.record(&mut encoder, &stage, input, None, true)?;
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let mut times = FrameTimes {
            fill_cpu_ms: watch.cpu_ms(),
            fill_wall_ms: watch.wall_ms(),
            ..FrameTimes::default()
        };
        self.gpu_times(&stage, &mut times)?;
        Ok(times)
    }
}

impl VolumeBackend for ComputeBackend {
    fn variant_name(&self) -> String {
        self.variant.name()
    }

    fn tells_regions_apart(&self) -> bool {
        self.variant.switches.colour.tells_regions_apart()
    }

    fn picture(&mut self, input: &FrameInput) -> Result<Picture, BackendError> {
        self.upload_view(input, palette_rgba)?;
        let picture = self.draw_and_read(input).map(|(picture, _)| picture);
        self.upload_view(input, id_rgba)?;
        picture
    }
}
