// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fills by volumes: what every Vulkan backend does alike, whatever its volumes are made of.
//!
//! The backend owns the meshes and draws volumes ([`Volumes`]); this owns the constants of the view,
//! the fill program and covers, records the passes, and measures. Depth stays as the surface left
//! it: it is attached read-only throughout. Covers of a textured fill read it there, and stand in
//! passes that leave the stencil alone as well.

use crate::covers::Covers;
use crate::textured::{Purpose, TexturedFill, probed};
use crate::{
    BindGroup, Buffer, BufferUse, FillRecorder, FillReport, Gpu, Measured, PassRecorder, Probe,
    SharedTargets, VolumePass,
};
use std::sync::Arc;
use terrafill_fill::{
    Capabilities, Counters, CpuStopwatch, DeviceError, FillInput, FillPass, FillProgram, FillStep,
    Frame, FrameTimes, Picture, Switches, ViewId, VolumeDraw, WorkDone,
};

/// Volumes of a backend, as the passes of a fill draw them.
pub trait Volumes {
    /// Makes the pipelines of `draw` unless they are there.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`], [`DeviceError::Shader`].
    fn ensure(&mut self, gpu: &Arc<Gpu>, draw: &VolumeDraw<'_>) -> Result<(), DeviceError>;

    /// Draws volumes by the pipelines that [`Volumes::ensure`] made.
    fn draw<'a>(&'a self, pass: &mut VolumePass<'a, '_, '_>, draw: &VolumeDraw<'_>);
}

/// A fill on the targets.
#[derive(Debug)]
pub struct VolumeFill {
    targets: SharedTargets,
    capabilities: Capabilities,
    covers: Covers,
    /// Of a textured fill; its covers stand where the plain ones would.
    textured: Option<TexturedFill>,
    /// Revision of the meshes that the backend holds.
    meshes: Option<u64>,
    view: Option<View>,
    /// Asked of the device for the frame that comes next.
    work: WorkDone,
}

/// Constants of the regions of a view, and the order to draw them in.
#[derive(Debug)]
struct View {
    id: ViewId,
    view_constants: Arc<Buffer>,
    constants: Arc<Buffer>,
    /// What `constants` holds.
    written: Vec<u8>,
    bindings: BindGroup,
    program: FillProgram,
}

impl VolumeFill {
    /// A fill on `targets` by the backend of this name.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device lacks `depthBounds` or depth that shaders can
    /// read, and the switches need it.
    pub fn new(
        targets: &SharedTargets,
        backend: &'static str,
        switches: &Switches,
    ) -> Result<Self, DeviceError> {
        let gpu = Arc::clone(targets.borrow().gpu());
        let features = gpu.facts.features;
        let lacks = |capability: &str| DeviceError::unsupported(capability, &gpu.facts.name);
        if switches.texture.is_some() && !features.samples_depth {
            return Err(lacks("reading depth in shaders"));
        }
        if switches.depth_bounds && !features.depth_bounds {
            return Err(lacks("depthBounds"));
        }
        Ok(Self {
            targets: SharedTargets::clone(targets),
            capabilities: Capabilities {
                backend,
                adapter: gpu.facts.title(),
                gpu_timestamps: features.timestamps,
                pipeline_statistics: features.pipeline_statistics,
            },
            covers: Covers::default(),
            textured: TexturedFill::new(switches),
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

    /// Bytes of the accumulation target, if the program draws into it.
    #[must_use]
    pub fn target_bytes(&self) -> u64 {
        let targets = self.targets.borrow();
        let view = self.view.as_ref();
        view.map_or(0, |view| targets.number_bytes(&view.program))
    }

    /// Bytes of a textured fill's pictures and tables.
    #[must_use]
    pub fn texture_bytes(&self) -> u64 {
        self.textured
            .as_ref()
            .map_or(0, TexturedFill::texture_bytes)
    }

    /// Bytes of a textured fill's constants.
    #[must_use]
    pub fn textured_bytes(&self) -> u64 {
        self.textured
            .as_ref()
            .map_or(0, TexturedFill::constant_bytes)
    }

    /// Buffers that hold constants of the view.
    #[must_use]
    pub fn constant_buffers(&self) -> u64 {
        1 + u64::from(self.textured.is_some())
    }

    /// What a row should say of the view that was uploaded last.
    #[must_use]
    pub fn note(&self) -> Option<String> {
        let plan = self.textured.as_ref().and_then(TexturedFill::plan);
        plan.map(|plan| plan.note())
    }

    /// Brings program and constants up to date; nothing is made or written where they are already.
    ///
    /// - `constants`: of the regions in the plan, not empty
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`], [`DeviceError::OutOfMemory`]; [`DeviceError::Switch`] for a
    /// textured fill of a scene without a picture.
    pub fn upload_view(
        &mut self,
        input: &FillInput,
        program: FillProgram,
        constants: Vec<u8>,
    ) -> Result<(), DeviceError> {
        if program.accumulates() {
            self.targets.borrow_mut().ensure_numbers()?;
        }
        let targets = self.targets.borrow();
        let gpu = targets.gpu();
        if let Some(textured) = &mut self.textured {
            textured.upload(&targets, input)?;
        }
        let Some(view_constants) = targets.view_constants() else {
            return self.check_prepared(input);
        };
        let buffer = match &self.view {
            Some(view) if view.written.len() == constants.len() => {
                if view.written != constants {
                    view.constants.rewrite(&constants)?;
                }
                Arc::clone(&view.constants)
            }
            _ => {
                let label = "region constants";
                Arc::new(Buffer::upload(gpu, label, &constants, BufferUse::Storage)?)
            }
        };
        let is_bound = |view: &View| {
            Arc::ptr_eq(&view.constants, &buffer)
                && Arc::ptr_eq(&view.view_constants, view_constants)
        };
        let bindings = match self.view.take() {
            Some(view) if is_bound(&view) => view.bindings,
            _ => BindGroup::new(gpu, view_constants, Some(&buffer))?,
        };
        self.view = Some(View {
            id: input.view_id,
            view_constants: Arc::clone(view_constants),
            constants: buffer,
            written: constants,
            bindings,
            program,
        });
        Ok(())
    }

    /// Makes the pipelines of the program unless they are there.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`], [`DeviceError::Shader`].
    pub fn ensure_pipelines(
        &mut self,
        volumes: &mut impl Volumes,
        input: &FillInput,
    ) -> Result<(), DeviceError> {
        let gpu = self.gpu();
        let Some(view) = &self.view else {
            return self.check_prepared(input);
        };
        for step in view.program.passes.iter().flat_map(FillPass::steps) {
            match step {
                FillStep::Volumes(draw) => volumes.ensure(&gpu, &draw)?,
                FillStep::Cover { test, regions, .. } => match &mut self.textured {
                    Some(textured) => textured.ensure(&gpu, test, Purpose::Colour, regions)?,
                    None => self.covers.ensure_cover(&gpu, test)?,
                },
                FillStep::Resolve => self.covers.ensure_resolve(&gpu)?,
            }
        }
        Ok(())
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

    /// Draws the surface and the fill, and reads the targets back.
    ///
    /// # Errors
    /// [`DeviceError::NotPrepared`], [`DeviceError::DeviceLost`].
    pub fn draw_and_read(
        &mut self,
        volumes: &impl Volumes,
        input: &FillInput,
    ) -> Result<(Picture, Counters), DeviceError> {
        self.check_prepared(input)?;
        let gpu = self.gpu();
        self.draw_surface(input)?;
        let before = gpu.work_done();
        let (report, mut counters) = self.measure(volumes, input, Measured::Statistics)?;
        let prepared = std::mem::take(&mut self.work);
        WorkDone::write_into(&mut counters, prepared, gpu.work_done() - before);
        if let Some(statistics) = report.statistics {
            counters.vertex_shader_invocations = Some(statistics.vertex_shader_invocations);
            counters.geometry_shader_primitives = statistics.geometry_shader_primitives;
            counters.clipper_invocations = Some(statistics.clipper_invocations);
            counters.clipper_primitives_out = Some(statistics.clipper_primitives_out);
            counters.fragment_shader_invocations = Some(statistics.fragment_shader_invocations);
        }
        let picture = self.targets.borrow().read()?;
        Ok((picture, counters))
    }

    /// What came out: the ids that are in the picture; of a textured fill, ids and places in the
    /// picture by drawing it once more with covers that write those, by the same functions.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn frame(
        &mut self,
        volumes: &impl Volumes,
        input: &FillInput,
        picture: &Picture,
        counters: Counters,
    ) -> Result<Frame, DeviceError> {
        let plain = Frame::from_picture(picture, counters);
        let gpu = self.gpu();
        let (Some(textured), Some(view)) = (&mut self.textured, &self.view) else {
            return Ok(plain);
        };
        for step in view.program.passes.iter().flat_map(FillPass::steps) {
            if let FillStep::Cover { test, regions, .. } = step {
                textured.ensure(&gpu, test, Purpose::Probe, regions)?;
            }
        }
        let probe = self.targets.borrow().probe()?;
        self.fill(volumes, input, Measured::Nothing, Some(&probe))?;
        let found = probed(&probe, input.size.pixel_count())?;
        let plan = self.textured.as_ref().and_then(TexturedFill::plan);
        // What was drawn was planned.
        Ok(match plan {
            Some(plan) => plan.frame(input, plain, &found),
            None => plain,
        })
    }

    /// How many fragments the volumes of the stencil work have, by an extra pass that is never timed
    /// and draws without any test; `None` where the device cannot count them.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn count_fragments(
        &mut self,
        volumes: &mut impl Volumes,
        input: &FillInput,
    ) -> Result<Option<u64>, DeviceError> {
        let gpu = self.gpu();
        let Some(view) = &self.view else {
            return Ok(None);
        };
        if view.program.counted().next().is_none() {
            return Ok(Some(0));
        }
        for draw in view.program.counted() {
            volumes.ensure(&gpu, &draw)?;
        }
        let volumes = &*volumes;
        let targets = self.targets.borrow();
        let mut unused = Counters::default();
        let report = targets.fill(1, Measured::Samples, |recorder| {
            recorder.pass(false, false, |recorder| {
                let mut pass = VolumePass::new(recorder, input, &view.bindings, &mut unused);
                for draw in view.program.counted() {
                    volumes.draw(&mut pass, &draw);
                }
            });
        })?;
        Ok(report.samples)
    }

    /// Fills on top of the surface that the targets hold already, and waits for it.
    ///
    /// # Errors
    /// [`DeviceError::NotPrepared`], [`DeviceError::DeviceLost`].
    pub fn time_frame(
        &self,
        volumes: &impl Volumes,
        input: &FillInput,
    ) -> Result<FrameTimes, DeviceError> {
        self.check_prepared(input)?;
        // Another backend of the targets may have drawn another view since.
        if !self.targets.borrow().holds(input) {
            return Err(input.not_prepared(self.capabilities.backend));
        }
        let watch = CpuStopwatch::start();
        let (report, _) = self.measure(volumes, input, Measured::Times)?;
        Ok(FrameTimes {
            surface_gpu_ms: None,
            stencil_gpu_ms: report.times.stencil_ms,
            colour_gpu_ms: report.times.colour_ms,
            fill_gpu_ms: report.times.fill_ms,
            fill_cpu_ms: watch.cpu_ms(),
            fill_wall_ms: watch.wall_ms(),
        })
    }

    /// Fills on top of the surface that the targets hold already, and waits for it.
    ///
    /// # Errors
    /// [`DeviceError::NotPrepared`] when the targets hold no surface, [`DeviceError::DeviceLost`].
    pub fn measure(
        &self,
        volumes: &impl Volumes,
        input: &FillInput,
        measured: Measured,
    ) -> Result<(FillReport, Counters), DeviceError> {
        self.fill(volumes, input, measured, None)
    }

    /// - `probe`: textured covers write where their texels came from into this instead of colours
    fn fill(
        &self,
        volumes: &impl Volumes,
        input: &FillInput,
        measured: Measured,
        probe: Option<&Probe>,
    ) -> Result<(FillReport, Counters), DeviceError> {
        let mut counters = Counters::default();
        let Some(view) = &self.view else {
            self.check_prepared(input)?;
            return Ok((FillReport::default(), counters));
        };
        let targets = self.targets.borrow();
        let recording = Recording {
            fill: self,
            view,
            input,
            probe,
        };
        let report = targets.fill(view.program.passes.len(), measured, |recorder| {
            recording.record(recorder, volumes, &mut counters);
        })?;
        Ok((report, counters))
    }
}

/// What one fill is recorded from.
struct Recording<'a> {
    fill: &'a VolumeFill,
    view: &'a View,
    input: &'a FillInput,
    probe: Option<&'a Probe>,
}

impl<'a> Recording<'a> {
    /// All passes.
    fn record<V: Volumes>(
        &self,
        recorder: &mut FillRecorder<'a>,
        volumes: &'a V,
        counters: &mut Counters,
    ) {
        for pass in &self.view.program.passes {
            let steps = |recorder: &mut PassRecorder<'a, '_>| {
                let bindings = &self.view.bindings;
                let mut volume_pass = VolumePass::new(recorder, self.input, bindings, counters);
                for step in pass.steps() {
                    self.step(&mut volume_pass, volumes, &step);
                }
            };
            if pass.accumulates() {
                recorder.accumulate(steps);
            } else if pass.has_colour && self.fill.textured.is_some() {
                // Depth is read in this pass, which holds covers only and writes no stencil.
                match self.probe {
                    Some(probe) => recorder.probe(probe, steps),
                    None => recorder.textured(steps),
                }
            } else {
                recorder.pass(pass.clears_stencil, pass.has_colour, steps);
            }
        }
    }

    fn step<V: Volumes>(
        &self,
        pass: &mut VolumePass<'a, '_, '_>,
        volumes: &'a V,
        step: &FillStep<'_>,
    ) {
        match (step, &self.fill.textured) {
            (FillStep::Volumes(draw), _) => volumes.draw(pass, draw),
            (
                FillStep::Cover {
                    test,
                    scissor,
                    regions,
                },
                Some(textured),
            ) => {
                let purpose = match self.probe {
                    Some(_) => Purpose::Probe,
                    None => Purpose::Colour,
                };
                textured.draw_covers(pass, *test, purpose, *scissor, regions);
            }
            (
                FillStep::Cover {
                    test,
                    scissor,
                    regions,
                },
                None,
            ) => self.fill.covers.draw_covers(pass, *test, *scissor, regions),
            (FillStep::Resolve, _) => self.fill.covers.draw_resolve(pass),
        }
    }
}
