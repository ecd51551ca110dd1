// SPDX-License-Identifier: MIT OR Apache-2.0
//! The backend: buffers of a scene, constants of a view, and the passes of a frame.

use crate::layout::{RegionSlice, SceneGeometry};
use crate::pass::{Recorder, counted};
use crate::pipeline::{NUMBER_FORMAT, Pipelines, State};
use crate::statistics::Statistics;
use crate::{Layout, VertexVariant};
use std::sync::Arc;
use terrafill_core::RegionMesh;
use terrafill_frame::{
    Backend, BackendError, Capabilities, Counters, FillPass, FillProgram, Frame, FrameInput,
    FrameTimes, MAX_REGIONS, MemoryUse, Picture, PositionFormat, RegionConstants, TimedBackend,
    VolumeBackend, id_rgba, ids_of, palette_rgba,
};
use terrafill_gpu::{CpuStopwatch, Gpu, SharedStage, Stage, TimedPass, WorkDone};
use terrafill_scene::{ImageSize, PlannedRegion};

/// Shadow volumes extruded in the vertex shader.
#[derive(Debug)]
pub struct VertexBackend {
    stage: SharedStage,
    pub(crate) variant: VertexVariant,
    capabilities: Capabilities,
    pub(crate) pipelines: Pipelines,
    scene: Option<SceneBuffers>,
    view: Option<ViewBuffers>,
    /// Made and written for the fill since the last frame.
    work: WorkDone,
}

/// Geometry of every region of a scene, in view or not.
#[derive(Debug)]
pub(crate) struct SceneBuffers {
    source: Arc<[RegionMesh]>,
    pub(crate) regions: Vec<RegionSlice>,
    pub(crate) vertices: wgpu::Buffer,
    /// Layout `separate`: the flags that all regions share.
    pub(crate) flags: Option<wgpu::Buffer>,
    pub(crate) short_indices: wgpu::Buffer,
    pub(crate) long_indices: wgpu::Buffer,
    /// Layout `pulled`: the vertices with the short and with the long indices.
    pub(crate) pulled: Option<[wgpu::BindGroup; 2]>,
    vertex_bytes: u64,
    index_bytes: u64,
}

/// Constants of the regions of a view, and the order to draw them in.
#[derive(Debug)]
pub(crate) struct ViewBuffers {
    source: Arc<[[f32; 3]]>,
    constants: wgpu::Buffer,
    /// What `constants` holds.
    written: Vec<u8>,
    pub(crate) bind_group: wgpu::BindGroup,
    pub(crate) program: FillProgram,
    /// Where the program accumulates numbers, if it does.
    pub(crate) numbers: Option<Numbers>,
}

/// The target of `colour=id-accumulation`.
#[derive(Debug)]
pub(crate) struct Numbers {
    size: ImageSize,
    pub(crate) view: wgpu::TextureView,
    pub(crate) bind_group: wgpu::BindGroup,
}

/// What the colour pass writes for a region.
#[derive(Debug, Clone, Copy)]
enum Colours {
    /// Its id.
    Ids,
    /// Its colour for people.
    Palette { opacity: f32 },
}

impl Colours {
    fn of(self, region: usize) -> [f32; 4] {
        match self {
            Self::Ids => id_rgba(region),
            Self::Palette { opacity } => {
                let [red, green, blue, alpha] = palette_rgba(region);
                [red, green, blue, alpha * opacity]
            }
        }
    }
}

impl VertexBackend {
    /// A backend on `stage`.
    ///
    /// # Errors
    /// [`BackendError::Switch`] when the layout lacks what was chosen for it;
    /// [`BackendError::Unsupported`] for what wgpu has no way to ask for; [`BackendError::Shader`].
    pub fn new(stage: &SharedStage, variant: VertexVariant) -> Result<Self, BackendError> {
        variant.check_layout()?;
        let gpu = Arc::clone(stage.borrow().gpu());
        if variant.switches.depth_bounds {
            return Err(BackendError::Unsupported {
                capability: "a depth-bounds test".to_owned(),
                adapter: "wgpu".to_owned(),
            });
        }
        Ok(Self {
            stage: SharedStage::clone(stage),
            variant,
            capabilities: Capabilities {
                backend: "vertex",
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
    pub fn variant(&self) -> VertexVariant {
        self.variant
    }

    fn gpu(&self) -> Arc<Gpu> {
        Arc::clone(self.stage.borrow().gpu())
    }

    /// Draws the surface and the fill, and reads the targets back.
    fn draw_and_read(
        &mut self,
        input: &FrameInput,
        blends: bool,
    ) -> Result<(Picture, Counters), BackendError> {
        self.check_prepared(input)?;
        let mut stage = self.stage.borrow_mut();
        stage.prepare(input)?;
        stage.draw_surface()?;
        let gpu = Arc::clone(stage.gpu());
        let statistics = Statistics::new(&gpu, self.pass_count());
        let before = gpu.work_done();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let recording = Recording {
            statistics: statistics.as_ref(),
            blends,
            ..Recording::default()
        };
        let mut counters = self.record(&mut encoder, &stage, input, recording)?;
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        self.work = self.work + (gpu.work_done() - before);
        counters.buffer_creations = self.work.buffer_creations;
        counters.pipeline_creations = self.work.pipeline_creations;
        counters.uploads = self.work.uploads;
        counters.upload_bytes = (gpu.work_done() - before).upload_bytes;
        self.work = WorkDone::default();
        if let Some(statistics) = &statistics {
            statistics.read_into(&gpu, &mut counters)?;
        }
        Ok((stage.read()?, counters))
    }

    /// How many fragments the volumes of the stencil work have, by an extra pass that is never
    /// timed; `None` where the device cannot count them.
    fn count_fragments(&mut self, input: &FrameInput) -> Result<Option<u64>, BackendError> {
        let gpu = self.gpu();
        let (Some(scene), Some(view)) = (&self.scene, &self.view) else {
            return Ok(None);
        };
        if view.program.passes.is_empty() {
            return Ok(Some(0));
        }
        let Some(statistics) = Statistics::new(&gpu, 1) else {
            return Ok(None);
        };
        let short =
            |planned: &usize| scene.regions[input.plan.regions[*planned].mesh].short_indices;
        for (faces, _, _, regions) in counted(&view.program) {
            let state = State::Count { faces };
            self.pipelines.ensure_volumes(&gpu, state, regions, short);
        }
        let stage = self.stage.borrow();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let recording = Recording {
            statistics: Some(&statistics),
            ..Recording::default()
        };
        if let Some(mut recorder) = self.recorder(&stage, input, recording) {
            recorder.count_fragments(&mut encoder);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let mut counted = Counters::default();
        statistics.read_into(&gpu, &mut counted)?;
        Ok(counted.fragment_shader_invocations)
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
            backend: "vertex",
            scene: input.scene.name.clone(),
            view: input.view.clone(),
        })
    }

    fn upload_scene(&mut self, input: &FrameInput) -> Result<(), BackendError> {
        let layout = self.variant.layout;
        let geometry = SceneGeometry::build(&self.variant, &input.scene.meshes);
        let bytes = geometry.bytes();
        let stage = self.stage.borrow();
        let (vertex_usage, index_usage) = match layout {
            Layout::Pulled => (wgpu::BufferUsages::STORAGE, wgpu::BufferUsages::STORAGE),
            _ => (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX),
        };
        let upload = |label, bytes, usage| stage.upload(label, bytes, usage);
        let vertices = upload(
            "volume vertices",
            bytemuck::cast_slice(&geometry.vertices),
            vertex_usage,
        )?;
        let flags = match layout {
            Layout::Separate => Some(upload(
                "shared flags",
                geometry.flags.as_flattened(),
                vertex_usage,
            )?),
            _ => None,
        };
        let short = bytemuck::cast_slice(&geometry.short_indices);
        let short_indices = upload("16-bit indices", short, index_usage)?;
        let long = bytemuck::cast_slice(&geometry.long_indices);
        let long_indices = upload("32-bit indices", long, index_usage)?;
        let bind = |indices: &wgpu::Buffer| {
            let descriptor = wgpu::BindGroupDescriptor {
                label: Some("pulled geometry"),
                layout: &self.pipelines.geometry_bindings,
                entries: &[
                    wgpu::BindGroupEntry {
                        binding: 0,
                        resource: vertices.as_entire_binding(),
                    },
                    wgpu::BindGroupEntry {
                        binding: 1,
                        resource: indices.as_entire_binding(),
                    },
                ],
            };
            stage.gpu().device.create_bind_group(&descriptor)
        };
        let pulled =
            (layout == Layout::Pulled).then(|| [bind(&short_indices), bind(&long_indices)]);
        drop(stage);
        self.scene = Some(SceneBuffers {
            source: Arc::clone(&input.scene.meshes),
            regions: geometry.regions,
            vertices,
            flags,
            short_indices,
            long_indices,
            pulled,
            vertex_bytes: bytes.vertex_bytes,
            index_bytes: bytes.index_bytes,
        });
        Ok(())
    }

    /// Brings program and constants up to date; nothing is made or written where they are already.
    fn upload_view(&mut self, input: &FrameInput, colours: Colours) -> Result<(), BackendError> {
        let Some(scene) = &self.scene else {
            return self.check_prepared(input);
        };
        let switches = &self.variant.switches;
        let program = FillProgram::new(&input.plan, switches, input.scene.overlap)?;
        let constants: Vec<RegionConstants> = input
            .plan
            .regions
            .iter()
            .map(|planned| self.region_constants(input, scene, planned, colours))
            .collect();
        let bytes: &[u8] = match bytemuck::cast_slice(&constants) {
            // A storage binding may not be empty.
            [] => &EMPTY,
            bytes => bytes,
        };
        let numbers = self.numbers(input, &program);
        let stage = self.stage.borrow();
        let view = match self.view.take() {
            Some(view) if view.written.len() == bytes.len() => {
                if view.written != bytes {
                    stage.gpu().write_buffer(&view.constants, 0, bytes);
                }
                ViewBuffers {
                    source: Arc::clone(&input.surface_rte),
                    written: bytes.to_vec(),
                    program,
                    numbers,
                    ..view
                }
            }
            _ => {
                let usage = wgpu::BufferUsages::STORAGE;
                let buffer = stage.upload("region constants", bytes, usage)?;
                ViewBuffers {
                    source: Arc::clone(&input.surface_rte),
                    bind_group: self.frame_bind_group(&stage, &buffer),
                    constants: buffer,
                    written: bytes.to_vec(),
                    program,
                    numbers,
                }
            }
        };
        drop(stage);
        self.view = Some(view);
        Ok(())
    }

    fn frame_bind_group(&self, stage: &Stage, constants: &wgpu::Buffer) -> wgpu::BindGroup {
        let device = &stage.gpu().device;
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("view and regions"),
            layout: &self.pipelines.frame_bindings,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: stage.view_constants().as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: constants.as_entire_binding(),
                },
            ],
        })
    }

    /// The accumulation target of `program`, the one there is if it fits; `None` when the program
    /// accumulates nothing.
    fn numbers(&mut self, input: &FrameInput, program: &FillProgram) -> Option<Numbers> {
        let there = self.view.as_mut().and_then(|view| view.numbers.take());
        if !program.passes.iter().any(FillPass::accumulates) {
            return None;
        }
        if let Some(numbers) = there
            && numbers.size == input.size
        {
            return Some(numbers);
        }
        let device = &self.gpu().device;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("accumulated numbers"),
            size: wgpu::Extent3d {
                width: input.size.width,
                height: input.size.height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: NUMBER_FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = texture.create_view(&Default::default());
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("accumulated numbers"),
            layout: &self.pipelines.number_bindings,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&view),
            }],
        });
        Some(Numbers {
            size: input.size,
            view,
            bind_group,
        })
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "rounding to what the GPU reads is the purpose"
    )]
    fn region_constants(
        &self,
        input: &FrameInput,
        scene: &SceneBuffers,
        planned: &PlannedRegion,
        colours: Colours,
    ) -> RegionConstants {
        let slice = &scene.regions[planned.mesh];
        let fixed = slice.fixed;
        let eye = fixed.eye(input.camera.eye_ecef);
        let remainder_m = match self.variant.positions {
            PositionFormat::Fixed => eye.remainder_m,
            PositionFormat::LocalF32 => input.camera.eye_ecef - fixed.origin_ecef,
        };
        RegionConstants {
            eye: eye.eye.to_array(),
            shift: eye.shift,
            eye_remainder_m: remainder_m.as_vec3().to_array(),
            scale_m: (fixed.unit_m * f64::from(eye.shift).exp2()) as f32,
            origin_ecef_m: fixed.origin_ecef.as_vec3().to_array(),
            unit_m: fixed.unit_m as f32,
            top_m: planned.heights.top_m as f32,
            bottom_m: planned.heights.bottom_m as f32,
            first_vertex: slice.first_vertex,
            first_triangle_index: slice.first_triangle_index,
            first_loop_index: slice.first_loop_index,
            triangle_count: slice.triangle_count,
            index_bits: if slice.short_indices { 16 } else { 32 },
            padding: 0,
            colour: colours.of(planned.region),
        }
    }

    /// Passes that a frame takes; each may have its own statistics query.
    fn pass_count(&self) -> usize {
        self.view
            .as_ref()
            .map_or(0, |view| view.program.passes.len())
    }

    fn ensure_pipelines(&mut self, input: &FrameInput, blends: bool) -> Result<(), BackendError> {
        let gpu = self.gpu();
        let (Some(scene), Some(view)) = (&self.scene, &self.view) else {
            return self.check_prepared(input);
        };
        for pass in &view.program.passes {
            for command in &pass.commands {
                let short = |planned: &usize| {
                    scene.regions[input.plan.regions[*planned].mesh].short_indices
                };
                self.pipelines
                    .ensure(&gpu, command, pass.has_colour, blends, short)?;
            }
        }
        Ok(())
    }

    fn recorder<'a>(
        &'a self,
        stage: &'a Stage,
        input: &'a FrameInput,
        recording: Recording<'a>,
    ) -> Option<Recorder<'a>> {
        let (scene, view) = self.scene.as_ref().zip(self.view.as_ref())?;
        Some(Recorder {
            backend: self,
            scene,
            view,
            stage,
            input,
            timed: recording.timed,
            statistics: recording.statistics,
            blends: recording.blends,
            counters: Counters::default(),
        })
    }

    /// Records the fill.
    fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stage: &Stage,
        input: &FrameInput,
        recording: Recording<'_>,
    ) -> Result<Counters, BackendError> {
        let Some(mut recorder) = self.recorder(stage, input, recording) else {
            self.check_prepared(input)?;
            return Ok(Counters::default());
        };
        recorder.fill(encoder);
        Ok(recorder.counters)
    }

    /// Brings geometry, constants and pipelines up to date, and gives the bytes handed over.
    fn bring_up_to_date(&mut self, input: &FrameInput) -> Result<u64, BackendError> {
        let gpu = self.gpu();
        let before = gpu.work_done();
        let is_uploaded = self
            .scene
            .as_ref()
            .is_some_and(|scene| Arc::ptr_eq(&scene.source, &input.scene.meshes));
        if !is_uploaded {
            self.upload_scene(input)?;
        }
        self.upload_view(input, Colours::Ids)?;
        self.ensure_pipelines(input, false)?;
        let done = gpu.work_done() - before;
        self.work = self.work + done;
        Ok(done.upload_bytes)
    }
}

/// How a fill is recorded.
#[derive(Debug, Clone, Copy, Default)]
struct Recording<'a> {
    /// GPU stamps surround it.
    timed: bool,
    /// Queries surround its passes.
    statistics: Option<&'a Statistics>,
    /// Covers are blended over what lies under them.
    blends: bool,
}

/// One element of region constants, for a view that plans none.
static EMPTY: [u8; size_of::<RegionConstants>()] = [0; size_of::<RegionConstants>()];

impl Backend for VertexBackend {
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
        let used = [
            Some(&scene.vertices),
            scene.flags.as_ref(),
            Some(&scene.short_indices),
            Some(&scene.long_indices),
            Some(&view.constants),
        ];
        Ok(MemoryUse {
            vertex_bytes: scene.vertex_bytes,
            index_bytes: scene.index_bytes,
            constant_bytes: (input.plan.regions.len() * size_of::<RegionConstants>()) as u64,
            buffers: used.iter().flatten().count() as u64,
            upload_bytes,
        })
    }

    fn render(&mut self, input: &FrameInput) -> Result<Frame, BackendError> {
        let (picture, mut counters) = self.draw_and_read(input, false)?;
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

impl TimedBackend for VertexBackend {
    fn time_frame(&mut self, input: &FrameInput) -> Result<FrameTimes, BackendError> {
        self.check_prepared(input)?;
        let stage = self.stage.borrow();
        let gpu = stage.gpu();
        let watch = CpuStopwatch::start();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let recording = Recording {
            timed: true,
            ..Recording::default()
        };
        self.record(&mut encoder, &stage, input, recording)?;
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let mut times = FrameTimes {
            fill_cpu_ms: watch.cpu_ms(),
            fill_wall_ms: watch.wall_ms(),
            ..FrameTimes::default()
        };
        if let Some(timer) = stage.timer() {
            match self.pass_count() {
                // Nothing in view: no pass was recorded.
                0 => {}
                1 => {
                    let stamps = timer.read(gpu, TimedPass::Colour, TimedPass::Colour)?;
                    times.fill_gpu_ms = stamps.pass_ms(TimedPass::Colour);
                }
                passes => {
                    let stamps = timer.read(gpu, TimedPass::Stencil, TimedPass::Colour)?;
                    times.fill_gpu_ms = stamps.span_ms(TimedPass::Stencil, TimedPass::Colour);
                    if passes == 2 {
                        times.stencil_gpu_ms = stamps.pass_ms(TimedPass::Stencil);
                        times.colour_gpu_ms = stamps.pass_ms(TimedPass::Colour);
                    }
                }
            }
        }
        Ok(times)
    }
}

impl VolumeBackend for VertexBackend {
    fn variant_name(&self) -> String {
        self.variant.name()
    }

    fn tells_regions_apart(&self) -> bool {
        self.variant.switches.colour.tells_regions_apart()
    }

    fn picture(&mut self, input: &FrameInput) -> Result<Picture, BackendError> {
        self.variant.check(input.scene.overlap)?;
        let blends = self.variant.opacity_percent < 100;
        let opacity = f32::from(self.variant.opacity_percent) / 100.0;
        self.upload_view(input, Colours::Palette { opacity })?;
        self.ensure_pipelines(input, blends)?;
        let picture = self
            .draw_and_read(input, blends)
            .map(|(picture, _)| picture);
        self.upload_view(input, Colours::Ids)?;
        picture
    }
}
