// SPDX-License-Identifier: MIT OR Apache-2.0
//! The backend: buffers of a scene, constants of a view, and the passes of a frame.

use crate::Layout;
use crate::layout::{RegionSlice, SceneGeometry};
use crate::pass::Recorder;
use crate::pipeline::Pipelines;
use crate::statistics::Statistics;
use std::sync::Arc;
use terrafill_core::RegionMesh;
use terrafill_frame::{
    Backend, BackendError, Capabilities, Counters, FillProgram, Frame, FrameInput, FrameTimes,
    MAX_REGIONS, MemoryUse, Picture, PositionFormat, RegionConstants, Switches, TimedBackend,
    VolumeBackend, id_rgba, ids_of, palette_rgba,
};
use terrafill_gpu::{CpuStopwatch, SharedStage, Stage, TimedPass};
use terrafill_scene::PlannedRegion;

/// A variant: how geometry is stored, and the switches of the fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct VertexVariant {
    /// Where duplicated vertices come from.
    pub layout: Layout,
    /// How positions are stored.
    pub positions: PositionFormat,
    /// What the fill does.
    pub switches: Switches,
}

impl VertexVariant {
    /// Layout first, then what differs from the default, `key=value`, in alphabetical order.
    #[must_use]
    pub fn name(&self) -> String {
        let mut names = self.switches.names();
        if self.positions == PositionFormat::LocalF32 {
            names.push("positions=local-f32".to_owned());
        }
        names.sort_unstable();
        names.insert(0, self.layout.name().to_owned());
        names.join(",")
    }
}

/// Shadow volumes extruded in the vertex shader.
#[derive(Debug)]
pub struct VertexBackend {
    stage: SharedStage,
    pub(crate) variant: VertexVariant,
    capabilities: Capabilities,
    pub(crate) pipelines: Pipelines,
    scene: Option<SceneBuffers>,
    view: Option<ViewBuffers>,
}

/// Geometry of every region of a scene, in view or not.
#[derive(Debug)]
pub(crate) struct SceneBuffers {
    source: Arc<[RegionMesh]>,
    pub(crate) regions: Vec<RegionSlice>,
    pub(crate) vertices: wgpu::Buffer,
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
    constant_bytes: u64,
    pub(crate) bind_group: wgpu::BindGroup,
    pub(crate) program: FillProgram,
}

/// What the colour pass writes for region `index`.
type ColourOf = fn(usize) -> [f32; 4];

impl VertexBackend {
    /// A backend on `stage`.
    ///
    /// # Errors
    /// [`BackendError::Shader`].
    pub fn new(stage: &SharedStage, variant: VertexVariant) -> Result<Self, BackendError> {
        let gpu = Arc::clone(stage.borrow().gpu());
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
        })
    }

    /// The switches.
    #[must_use]
    pub fn variant(&self) -> VertexVariant {
        self.variant
    }

    fn draw_and_read(&mut self, input: &FrameInput) -> Result<(Picture, Counters), BackendError> {
        self.check_prepared(input)?;
        let mut stage = self.stage.borrow_mut();
        stage.prepare(input)?;
        stage.draw_surface()?;
        let statistics = Statistics::new(stage.gpu(), self.pass_count());
        let mut encoder = stage
            .gpu()
            .device
            .create_command_encoder(&Default::default());
        let mut counters = self.record(&mut encoder, &stage, input, statistics.as_ref(), false)?;
        stage.gpu().queue.submit([encoder.finish()]);
        stage.gpu().wait()?;
        if let Some(statistics) = &statistics {
            statistics.read_into(stage.gpu(), &mut counters)?;
        }
        Ok((stage.read()?, counters))
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
        let VertexVariant {
            layout, positions, ..
        } = self.variant;
        let geometry = SceneGeometry::build(layout, positions, &input.scene.meshes);
        let bytes = geometry.bytes();
        let stage = self.stage.borrow();
        let (vertex_usage, index_usage) = match layout {
            Layout::Doubled => (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX),
            Layout::Pulled => (wgpu::BufferUsages::STORAGE, wgpu::BufferUsages::STORAGE),
        };
        let upload = |label, bytes, usage| stage.upload(label, bytes, usage);
        let vertices = upload(
            "volume vertices",
            bytemuck::cast_slice(&geometry.vertices),
            vertex_usage,
        )?;
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
            short_indices,
            long_indices,
            pulled,
            vertex_bytes: bytes.vertex_bytes,
            index_bytes: bytes.index_bytes,
        });
        Ok(())
    }

    fn upload_view(&mut self, input: &FrameInput, colour_of: ColourOf) -> Result<(), BackendError> {
        let Some(scene) = &self.scene else {
            return self.check_prepared(input);
        };
        let switches = &self.variant.switches;
        let program = FillProgram::new(&input.plan, switches, input.scene.overlap)?;
        let constants: Vec<RegionConstants> = input
            .plan
            .regions
            .iter()
            .map(|planned| self.region_constants(input, scene, planned, colour_of))
            .collect();
        let stage = self.stage.borrow();
        let bytes: &[u8] = bytemuck::cast_slice(&constants);
        let buffer = stage.upload(
            "region constants",
            // A storage binding may not be empty.
            if bytes.is_empty() { &EMPTY } else { bytes },
            wgpu::BufferUsages::STORAGE,
        )?;
        let bind_group = stage
            .gpu()
            .device
            .create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("view and regions"),
                layout: &self.pipelines.frame_bindings,
                entries: &[
                    wgpu::BindGroupEntry {
                        binding: 0,
                        resource: stage.view_constants().as_entire_binding(),
                    },
                    wgpu::BindGroupEntry {
                        binding: 1,
                        resource: buffer.as_entire_binding(),
                    },
                ],
            });
        drop(stage);
        self.view = Some(ViewBuffers {
            source: Arc::clone(&input.surface_rte),
            constants: buffer,
            constant_bytes: bytes.len() as u64,
            bind_group,
            program,
        });
        Ok(())
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
        colour_of: ColourOf,
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
            colour: colour_of(planned.region),
        }
    }

    /// Passes that a frame takes; each may have its own statistics query.
    fn pass_count(&self) -> usize {
        self.view
            .as_ref()
            .map_or(0, |view| view.program.passes.len())
    }

    fn ensure_pipelines(&mut self, input: &FrameInput) {
        let (Some(scene), Some(view)) = (&self.scene, &self.view) else {
            return;
        };
        let gpu = Arc::clone(self.stage.borrow().gpu());
        for pass in &view.program.passes {
            for command in &pass.commands {
                let short = |planned: &usize| {
                    scene.regions[input.plan.regions[*planned].mesh].short_indices
                };
                self.pipelines.ensure(&gpu, command, pass.has_colour, short);
            }
        }
    }

    /// Records the fill. With `timed`, GPU stamps surround it; with `statistics`, queries do.
    fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stage: &Stage,
        input: &FrameInput,
        statistics: Option<&Statistics>,
        timed: bool,
    ) -> Result<Counters, BackendError> {
        let (Some(scene), Some(view)) = (&self.scene, &self.view) else {
            self.check_prepared(input)?;
            return Ok(Counters::default());
        };
        let mut recorder = Recorder {
            backend: self,
            scene,
            view,
            stage,
            input,
            timed,
            statistics,
            counters: Counters::default(),
        };
        recorder.fill(encoder);
        Ok(recorder.counters)
    }
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
        let is_uploaded = self
            .scene
            .as_ref()
            .is_some_and(|scene| Arc::ptr_eq(&scene.source, &input.scene.meshes));
        let mut upload_bytes = 0;
        if !is_uploaded {
            self.upload_scene(input)?;
            upload_bytes += self
                .scene
                .as_ref()
                .map_or(0, |scene| scene.vertex_bytes + scene.index_bytes);
        }
        self.upload_view(input, id_rgba)?;
        self.ensure_pipelines(input);
        let (Some(scene), Some(view)) = (&self.scene, &self.view) else {
            return Ok(MemoryUse::default());
        };
        upload_bytes += view.constant_bytes;
        let used = [
            &scene.vertices,
            &scene.short_indices,
            &scene.long_indices,
            &view.constants,
        ];
        Ok(MemoryUse {
            vertex_bytes: scene.vertex_bytes,
            index_bytes: scene.index_bytes,
            constant_bytes: view.constant_bytes,
            buffers: used.len() as u64,
            upload_bytes,
        })
    }

    fn render(&mut self, input: &FrameInput) -> Result<Frame, BackendError> {
        let (picture, counters) = self.draw_and_read(input)?;
        Ok(Frame {
            size: input.size,
            ids: ids_of(&picture),
            surface: picture.depth.iter().map(|&depth| depth > 0.0).collect(),
            non_finite: picture.depth.iter().filter(|d| !d.is_finite()).count() as u64,
            counters: Some(counters),
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
        self.record(&mut encoder, &stage, input, None, true)?;
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
        self.upload_view(input, palette_rgba)?;
        let picture = self.draw_and_read(input).map(|(picture, _)| picture);
        self.upload_view(input, id_rgba)?;
        picture
    }
}
