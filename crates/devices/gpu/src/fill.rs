// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fills by volumes: what every wgpu backend does alike, whatever its volumes are made of.
//!
//! The backend owns the meshes and draws volumes ([`Volumes`]); this owns the constants of the view,
//! the fill program, covers and the accumulation target, records the passes, and measures. Depth
//! stays as the surface left it: it is attached read-only throughout. Covers of a textured fill read it
//! there, and stand in passes that leave the stencil alone as well.

use crate::attachments::{attached, read_only_depth};
use crate::covers::{Covers, Numbers};
use crate::statistics::Statistics;
use crate::textured::{BoundCover, CoverPurpose, Probe, Textured};
use crate::volume_pipeline::check_blendable;
use crate::{API, Gpu, RenderTargets, SharedTargets, TimedPass, VolumePass};
use std::sync::Arc;
use terrafill_fill::{
    Capabilities, Counters, CpuStopwatch, DeviceError, FillInput, FillPass, FillProgram, FillStep,
    Frame, FrameTimes, Picture, Switches, ViewId, VolumeDraw, VolumeState, WorkDone,
};

/// Volumes of a backend, as the passes of a fill draw them.
pub trait Volumes {
    /// Makes the pipelines of `draw` unless they are there. `blends` is set for colours only.
    fn ensure(&mut self, gpu: &Gpu, input: &FillInput, draw: &VolumeDraw<'_>, blends: bool);

    /// Whether [`Volumes::make`] has something to do.
    fn are_made_per_frame(&self) -> bool {
        false
    }

    /// Makes the volumes of a frame, in a compute pass with these stamps.
    ///
    /// - `constants`: group 0, view and regions
    fn make(
        &mut self,
        _encoder: &mut wgpu::CommandEncoder,
        _input: &FillInput,
        _constants: &wgpu::BindGroup,
        _stamps: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
    }

    /// Binds what all draws of a pass share; group 0, view and regions, is bound.
    fn bind(&self, pass: &mut wgpu::RenderPass<'_>);

    /// Draws volumes by the pipelines that [`Volumes::ensure`] made; the stencil reference is set.
    fn draw(&mut self, pass: &mut VolumePass<'_>, draw: &VolumeDraw<'_>, blends: bool);
}

/// A fill on the targets.
#[derive(Debug)]
pub struct VolumeFill {
    targets: SharedTargets,
    capabilities: Capabilities,
    frame_layout: wgpu::BindGroupLayout,
    covers: Covers,
    /// Of a textured fill; its covers stand where the plain ones would.
    textured: Option<Textured>,
    /// Revision of the meshes that the backend has uploaded.
    meshes: Option<u64>,
    view: Option<View>,
    /// Asked of the device for the frame that comes next.
    work: WorkDone,
}

/// Constants of the regions of a view, and the order to draw them in.
#[derive(Debug)]
struct View {
    id: ViewId,
    constants: wgpu::Buffer,
    /// What `constants` holds.
    written: Vec<u8>,
    bind_group: wgpu::BindGroup,
    program: FillProgram,
    /// Where the program accumulates numbers, if it does.
    numbers: Option<Numbers>,
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
    /// Textured covers write where their texels came from instead of colours.
    probe: Option<&'a Probe>,
}

impl VolumeFill {
    /// A fill on `targets` by the backend of this name.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] for what wgpu has no way to ask for, [`DeviceError::Shader`].
    pub fn new(
        targets: &SharedTargets,
        backend: &'static str,
        switches: &Switches,
    ) -> Result<Self, DeviceError> {
        // Whatever the device has; silence would look like a test that changes nothing.
        if switches.depth_bounds {
            return Err(DeviceError::unsupported("a depth-bounds test", API.name));
        }
        let gpu = Arc::clone(targets.borrow().gpu());
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let frame_layout = gpu.buffer_layout(
            "view and regions",
            wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE,
            &[wgpu::BufferBindingType::Uniform, storage],
        );
        Ok(Self {
            targets: SharedTargets::clone(targets),
            capabilities: Capabilities {
                backend,
                adapter: gpu.facts.title(),
                gpu_timestamps: gpu.facts.features.timestamps,
                pipeline_statistics: gpu.facts.features.pipeline_statistics,
            },
            covers: Covers::new(&gpu, &frame_layout)?,
            textured: Textured::new(&gpu, &frame_layout, switches),
            frame_layout,
            meshes: None,
            view: None,
            work: WorkDone::default(),
        })
    }

    /// What the device can do.
    #[must_use]
    pub fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    /// Where it draws.
    #[must_use]
    pub fn targets(&self) -> &SharedTargets {
        &self.targets
    }

    /// The device.
    #[must_use]
    pub fn gpu(&self) -> Arc<Gpu> {
        Arc::clone(self.targets.borrow().gpu())
    }

    /// Layout of group 0: view and regions.
    #[must_use]
    pub fn frame_layout(&self) -> &wgpu::BindGroupLayout {
        &self.frame_layout
    }

    /// Whether the backend has uploaded the meshes of `input`.
    #[must_use]
    pub fn holds_meshes(&self, input: &FillInput) -> bool {
        self.meshes == Some(input.scene.meshes.revision())
    }

    /// The backend has uploaded the meshes of `input`.
    pub fn hold_meshes(&mut self, input: &FillInput) {
        self.meshes = Some(input.scene.meshes.revision());
    }

    /// The meshes of `input` that differ from those uploaded, ascending, if `changed` names them.
    ///
    /// # Errors
    /// [`DeviceError::NotPrepared`], [`DeviceError::ChangedRegions`].
    pub fn check_update<'a>(
        &self,
        input: &'a FillInput,
        changed: &[usize],
    ) -> Result<&'a [usize], DeviceError> {
        input.check_update(self.capabilities.backend, self.meshes, changed)
    }

    /// The backend is about to write over the meshes: until it holds others, nothing is prepared.
    pub fn forget_meshes(&mut self) {
        self.meshes = None;
    }

    /// Whether this is what was prepared.
    ///
    /// # Errors
    /// [`DeviceError::NotPrepared`].
    pub fn check_prepared(&self, input: &FillInput) -> Result<(), DeviceError> {
        let view_id = self.view.as_ref().map(|view| view.id);
        input.check_prepared(self.capabilities.backend, self.meshes, view_id)
    }

    /// What the device was asked for since `before` is for the frame that comes next; gives the
    /// bytes handed over.
    pub fn count_work_since(&mut self, before: WorkDone) -> u64 {
        let done = self.gpu().work_done() - before;
        self.work = self.work + done;
        done.upload_bytes
    }

    /// Bytes of the accumulation target, if there is one.
    #[must_use]
    pub fn target_bytes(&self) -> u64 {
        let numbers = self.view.as_ref().and_then(|view| view.numbers.as_ref());
        numbers.map_or(0, Numbers::bytes)
    }

    /// Bytes of a textured fill's pictures and tables.
    #[must_use]
    pub fn texture_bytes(&self) -> u64 {
        let textured = self.textured.as_ref();
        textured.map_or(0, |textured| textured.covers.texture_bytes())
    }

    /// Bytes of a textured fill's constants.
    #[must_use]
    pub fn textured_bytes(&self) -> u64 {
        let textured = self.textured.as_ref();
        textured.map_or(0, |textured| textured.covers.constant_bytes())
    }

    /// Buffers that hold constants of the view.
    #[must_use]
    pub fn constant_buffers(&self) -> u64 {
        1 + u64::from(self.textured.is_some())
    }

    /// What a row should say of the view that was uploaded last.
    #[must_use]
    pub fn note(&self) -> Option<String> {
        let plan = self.textured.as_ref().and_then(Textured::plan);
        plan.map(|plan| plan.note())
    }

    /// Brings program and constants up to date; nothing is made or written where they are already.
    ///
    /// - `constants`: of the regions in the plan, not empty
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when the device has no buffers that large;
    /// [`DeviceError::Switch`] for a textured fill of a scene without a picture.
    pub fn upload_view(
        &mut self,
        input: &FillInput,
        program: FillProgram,
        constants: Vec<u8>,
    ) -> Result<(), DeviceError> {
        let targets = self.targets.borrow();
        let gpu = targets.gpu();
        if let Some(textured) = &mut self.textured {
            textured.upload(&targets, input)?;
        }
        let before = self.view.take();
        let (there, numbers) = match before {
            Some(view) => (
                Some((view.constants, view.written, view.bind_group)),
                view.numbers,
            ),
            None => (None, None),
        };
        let numbers = program.accumulates().then(|| {
            numbers
                .filter(|numbers| numbers.size == input.size)
                .unwrap_or_else(|| Numbers::new(gpu, &self.covers, input.size))
        });
        let fits = there.filter(|(_, written, _)| written.len() == constants.len());
        let (buffer, bind_group) = match fits {
            Some((buffer, written, bind_group)) => {
                if written != constants {
                    gpu.write_buffer(&buffer, 0, &constants);
                }
                (buffer, bind_group)
            }
            None => {
                let usage = wgpu::BufferUsages::STORAGE;
                let buffer = targets.upload("region constants", &constants, usage)?;
                let buffers = [targets.view_constants(), &buffer];
                let label = "view and regions";
                let bind_group = gpu.bind_buffers(label, &self.frame_layout, &buffers);
                (buffer, bind_group)
            }
        };
        self.view = Some(View {
            id: input.view_id,
            constants: buffer,
            written: constants,
            bind_group,
            program,
            numbers,
        });
        Ok(())
    }

    /// The backend no longer has what the view needs: nothing is prepared any more.
    pub fn forget_view(&mut self) {
        self.view = None;
    }

    /// Makes the pipelines of the program unless they are there.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`], [`DeviceError::Shader`].
    pub fn ensure_pipelines(
        &mut self,
        volumes: &mut impl Volumes,
        input: &FillInput,
        blends: bool,
    ) -> Result<(), DeviceError> {
        let gpu = self.gpu();
        let Some(view) = &self.view else {
            return self.check_prepared(input);
        };
        for step in view.program.passes.iter().flat_map(FillPass::steps) {
            match step {
                FillStep::Volumes(draw) => {
                    if matches!(draw.state, VolumeState::Accumulate { .. }) {
                        check_blendable(&gpu)?;
                    }
                    volumes.ensure(&gpu, input, &draw, blends && is_coloured(&draw));
                }
                FillStep::Cover { test, regions, .. } => match &mut self.textured {
                    Some(textured) => {
                        let purpose = CoverPurpose::Colour;
                        textured.covers.ensure(&gpu, test, purpose, regions);
                    }
                    None => self.covers.ensure_cover(&gpu, test, blends),
                },
                FillStep::Resolve => self.covers.ensure_resolve(&gpu)?,
            }
        }
        Ok(())
    }

    /// Draws the surface and the fill, and reads the targets back.
    ///
    /// # Errors
    /// [`DeviceError::NotPrepared`], [`DeviceError::DeviceLost`].
    pub fn draw_and_read(
        &mut self,
        volumes: &mut impl Volumes,
        input: &FillInput,
        blends: bool,
    ) -> Result<(Picture, Counters), DeviceError> {
        self.check_prepared(input)?;
        let mut targets = self.targets.borrow_mut();
        targets.prepare(input)?;
        targets.draw_surface()?;
        let gpu = Arc::clone(targets.gpu());
        let passes = self
            .view
            .as_ref()
            .map_or(0, |view| view.program.passes.len());
        let statistics = Statistics::new(&gpu, passes);
        let before = gpu.work_done();
        let recording = Recording {
            statistics: statistics.as_ref(),
            blends,
            ..Recording::default()
        };
        let mut counters = self.fill(&targets, volumes, input, recording)?;
        let prepared = std::mem::take(&mut self.work);
        WorkDone::write_into(&mut counters, prepared, gpu.work_done() - before);
        if let Some(statistics) = &statistics {
            statistics.read_into(&gpu, &mut counters)?;
        }
        Ok((targets.read()?, counters))
    }

    /// Draws the surface and gives its GPU time, where there is a clock.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`], [`DeviceError::DeviceLost`].
    pub fn draw_surface(&self, input: &FillInput) -> Result<Option<f64>, DeviceError> {
        let mut targets = self.targets.borrow_mut();
        targets.prepare(input)?;
        targets.draw_surface()
    }

    /// What came out: the ids that are in the picture; of a textured fill, ids and places in the
    /// picture by drawing it once more with covers that write those, by the same functions.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn frame(
        &mut self,
        volumes: &mut impl Volumes,
        input: &FillInput,
        picture: &Picture,
        counters: Counters,
    ) -> Result<Frame, DeviceError> {
        let plain = Frame::from_picture(picture, counters);
        let (Some(textured), Some(view)) = (&mut self.textured, &self.view) else {
            return Ok(plain);
        };
        let gpu = Arc::clone(self.targets.borrow().gpu());
        for step in view.program.passes.iter().flat_map(FillPass::steps) {
            if let FillStep::Cover { test, regions, .. } = step {
                let purpose = CoverPurpose::Probe;
                textured.covers.ensure(&gpu, test, purpose, regions);
            }
        }
        let probe = Probe::new(&gpu, input.size);
        let recording = Recording {
            probe: Some(&probe),
            ..Recording::default()
        };
        self.fill(&self.targets.borrow(), volumes, input, recording)?;
        let probed = probe.read(&gpu)?;
        let plan = self.textured.as_ref().and_then(Textured::plan);
        // What was drawn was planned.
        Ok(match plan {
            Some(plan) => plan.frame(input, plain, &probed),
            None => plain,
        })
    }

    /// How many fragments the volumes of the stencil work have, by an extra pass that is never timed
    /// and draws into nothing, so that the query counts every fragment of theirs and not only those
    /// that the depth test lets through; `None` where the device cannot count them. Volumes that are
    /// made per frame are those that the frame before has made.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn count_fragments(
        &mut self,
        volumes: &mut impl Volumes,
        input: &FillInput,
    ) -> Result<Option<u64>, DeviceError> {
        let Some(view) = &self.view else {
            return Ok(None);
        };
        if view.program.passes.is_empty() {
            return Ok(Some(0));
        }
        let targets = self.targets.borrow();
        let gpu = targets.gpu();
        let Some(statistics) = Statistics::new(gpu, 1) else {
            return Ok(None);
        };
        for draw in view.program.counted() {
            volumes.ensure(gpu, input, &draw, false);
        }
        let (colour, depth_stencil) = (targets.colour_view(), targets.depth_stencil_view());
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut raw = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("fragment count"),
            color_attachments: &[Some(attached(&colour, wgpu::LoadOp::Load))],
            depth_stencil_attachment: Some(read_only_depth(
                &depth_stencil,
                Some(wgpu::LoadOp::Load),
            )),
            ..Default::default()
        });
        statistics.begin(&mut raw, 0);
        raw.set_bind_group(0, &view.bind_group, &[]);
        volumes.bind(&mut raw);
        let mut unused = Counters::default();
        let mut pass = VolumePass::new(raw, input, &mut unused);
        for draw in view.program.counted() {
            volumes.draw(&mut pass, &draw, false);
        }
        pass.raw.end_pipeline_statistics_query();
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let mut counted = Counters::default();
        statistics.read_into(gpu, &mut counted)?;
        Ok(counted.fragment_shader_invocations)
    }

    /// Fills on top of the surface that the targets hold already, and waits for it.
    ///
    /// # Errors
    /// [`DeviceError::NotPrepared`], [`DeviceError::DeviceLost`].
    pub fn time_frame(
        &self,
        volumes: &mut impl Volumes,
        input: &FillInput,
    ) -> Result<FrameTimes, DeviceError> {
        self.check_prepared(input)?;
        let targets = self.targets.borrow();
        let watch = CpuStopwatch::start();
        let recording = Recording {
            timed: true,
            ..Recording::default()
        };
        self.fill(&targets, volumes, input, recording)?;
        let mut times = FrameTimes {
            fill_cpu_ms: watch.cpu_ms(),
            fill_wall_ms: watch.wall_ms(),
            ..FrameTimes::default()
        };
        self.read_stamps(&targets, volumes.are_made_per_frame(), &mut times)?;
        Ok(times)
    }

    fn read_stamps(
        &self,
        targets: &RenderTargets,
        makes_volumes: bool,
        times: &mut FrameTimes,
    ) -> Result<(), DeviceError> {
        let (Some(timer), Some(view)) = (targets.timer(), &self.view) else {
            return Ok(());
        };
        let gpu = targets.gpu();
        match (view.program.passes.len(), makes_volumes) {
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

    /// Records the frame, submits it and waits.
    fn fill(
        &self,
        targets: &RenderTargets,
        volumes: &mut impl Volumes,
        input: &FillInput,
        recording: Recording<'_>,
    ) -> Result<Counters, DeviceError> {
        let mut counters = Counters::default();
        let Some(view) = &self.view else {
            self.check_prepared(input)?;
            return Ok(counters);
        };
        let gpu = targets.gpu();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let passes = &view.program.passes;
        let makes_volumes = volumes.are_made_per_frame();
        if makes_volumes && !passes.is_empty() {
            let stamps = compute_stamps(targets, recording, passes.len());
            volumes.make(&mut encoder, input, &view.bind_group, stamps);
        }
        let (colour, depth_stencil) = (targets.colour_view(), targets.depth_stencil_view());
        let probe_views = recording.probe.map(Probe::views);
        let mut zero = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        for (index, steps) in passes.iter().enumerate() {
            let is_textured = steps.has_colour && self.textured.is_some();
            let attachments = match (&view.numbers, &probe_views) {
                (Some(numbers), _) if steps.accumulates() => {
                    let zero = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
                    vec![Some(attached(&numbers.view, zero))]
                }
                (_, Some(views)) if is_textured => {
                    // The first pass clears, the others add.
                    let load = std::mem::replace(&mut zero, wgpu::LoadOp::Load);
                    views
                        .iter()
                        .map(|view| Some(attached(view, load)))
                        .collect()
                }
                _ if steps.has_colour => vec![Some(attached(&colour, wgpu::LoadOp::Load))],
                _ => Vec::new(),
            };
            let stencil = if is_textured {
                // Depth is sampled in this pass, which nothing of the texture may be written in.
                None
            } else if steps.clears_stencil {
                Some(wgpu::LoadOp::Clear(0))
            } else {
                Some(wgpu::LoadOp::Load)
            };
            let mut raw = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(if steps.has_colour {
                    "colour"
                } else {
                    "stencil"
                }),
                color_attachments: &attachments,
                depth_stencil_attachment: Some(read_only_depth(&depth_stencil, stencil)),
                timestamp_writes: stamps(targets, recording, index, passes.len(), makes_volumes),
                ..Default::default()
            });
            if let Some(statistics) = recording.statistics {
                statistics.begin(&mut raw, index);
            }
            raw.set_bind_group(0, &view.bind_group, &[]);
            volumes.bind(&mut raw);
            let mut pass = VolumePass::new(raw, input, &mut counters);
            let mut bound = BoundCover::default();
            for step in steps.steps() {
                match (&step, &self.textured) {
                    (FillStep::Cover { .. }, Some(textured)) => {
                        let purpose = match recording.probe {
                            Some(_) => CoverPurpose::Probe,
                            None => CoverPurpose::Colour,
                        };
                        draw_textured(&mut pass, textured, &step, purpose, &mut bound);
                    }
                    _ => self.step(&mut pass, volumes, view, &step, recording.blends),
                }
            }
            if recording.statistics.is_some() {
                pass.raw.end_pipeline_statistics_query();
            }
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        Ok(counters)
    }

    fn step(
        &self,
        pass: &mut VolumePass<'_>,
        volumes: &mut impl Volumes,
        view: &View,
        step: &FillStep<'_>,
        blends: bool,
    ) {
        match step {
            FillStep::Volumes(draw) => {
                if let VolumeState::Colour { test, .. } = draw.state {
                    pass.raw.set_stencil_reference(u32::from(test.reference));
                }
                volumes.draw(pass, draw, blends && is_coloured(draw));
            }
            FillStep::Cover {
                test,
                scissor,
                regions,
            } => self
                .covers
                .draw_covers(pass, *test, blends, *scissor, regions),
            FillStep::Resolve => {
                if let Some(numbers) = &view.numbers {
                    self.covers.draw_resolve(pass, numbers);
                }
            }
        }
    }
}

fn draw_textured(
    pass: &mut VolumePass<'_>,
    textured: &Textured,
    step: &FillStep<'_>,
    purpose: CoverPurpose,
    bound: &mut BoundCover,
) {
    let FillStep::Cover {
        test,
        scissor,
        regions,
    } = *step
    else {
        return;
    };
    pass.raw.set_stencil_reference(u32::from(test.reference));
    for &planned in regions {
        if textured
            .covers
            .bind(&mut pass.raw, test, purpose, planned, bound)
        {
            pass.cut(planned, scissor);
            pass.draw(0..3, planned);
        }
    }
}

fn is_coloured(draw: &VolumeDraw<'_>) -> bool {
    matches!(draw.state, VolumeState::Colour { .. })
}

/// The last pass is stamped as colour; of several, the first as stencil. A compute pass before them
/// has begun that slot.
fn stamps<'a>(
    targets: &'a RenderTargets,
    recording: Recording<'_>,
    index: usize,
    count: usize,
    makes_volumes: bool,
) -> Option<wgpu::RenderPassTimestampWrites<'a>> {
    let timer = targets.timer().filter(|_| recording.timed)?;
    match index {
        _ if index + 1 == count => Some(timer.around(TimedPass::Colour)),
        0 if makes_volumes => Some(timer.writes(None, Some(TimedPass::Stencil))),
        0 => Some(timer.around(TimedPass::Stencil)),
        _ => None,
    }
}

fn compute_stamps<'a>(
    targets: &'a RenderTargets,
    recording: Recording<'_>,
    passes: usize,
) -> Option<wgpu::ComputePassTimestampWrites<'a>> {
    let timer = targets.timer().filter(|_| recording.timed)?;
    // With one pass to come the slot is free; otherwise the first pass ends it.
    let end = (passes == 1).then_some(TimedPass::Stencil);
    let writes = timer.writes(Some(TimedPass::Stencil), end);
    Some(wgpu::ComputePassTimestampWrites {
        query_set: writes.query_set,
        beginning_of_pass_write_index: writes.beginning_of_pass_write_index,
        end_of_pass_write_index: writes.end_of_pass_write_index,
    })
}
