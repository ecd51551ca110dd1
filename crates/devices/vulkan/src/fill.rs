// SPDX-License-Identifier: MIT OR Apache-2.0
//! The stencil-program executor on Vulkan: the same for everything that is drawn by closed volumes.
//!
//! The volumes are drawn by whoever made them ([`VulkanVolumes`]); this owns the constants of a list, the
//! program and covers, records the passes, and measures. Depth stays as the surface left it: it is
//! attached read-only throughout. Covers of a textured fill read it there, and stand in passes that
//! leave the stencil alone as well.

use crate::covers::{CoverList, Covers};
use crate::textured::{TexturedFill, probed};
use crate::{
    BindGroup, Buffer, BufferUse, DepthCopy, FillRecorder, FillReport, Gpu, Measured, Numbers,
    PassRecorder, Probe, SharedTargets, VolumePass,
};
use std::cell::RefCell;
use std::sync::Arc;
use terrafill_contract::{
    Counters, CpuStopwatch, DeviceError, Feature, FrameTimes, SurfaceTargets, ViewId, WorkDone,
};
use terrafill_scene::MipChain;
use terrafill_stencil::{
    CoverPurpose, FillPass, FillProgram, FillStep, Holding, Probed, StencilExecutor, StencilTest,
    StencilWork, TexturedPlan, VolumeDraw, VolumeList,
};
use terrafill_variant::{FirstPass, Switches};

/// Volumes as the passes of a stencil program draw them.
pub trait VulkanVolumes {
    /// Makes the pipelines of `draw` unless they are there.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`], [`DeviceError::Shader`].
    fn ensure(&mut self, gpu: &Arc<Gpu>, draw: &VolumeDraw<'_>) -> Result<(), DeviceError>;

    /// Makes ready what merged draws of `program` read; nothing where each volume has draws of its own.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`], [`DeviceError::OutOfMemory`].
    fn merge(
        &mut self,
        _gpu: &Arc<Gpu>,
        _list: &VolumeList,
        _program: &FillProgram,
    ) -> Result<(), DeviceError> {
        Ok(())
    }

    /// Draws volumes by the pipelines that [`VulkanVolumes::ensure`] made.
    fn draw<'a>(&'a self, pass: &mut VolumePass<'a, '_, '_>, draw: &VolumeDraw<'_>);
}

/// Runs stencil programs on the targets.
#[derive(Debug)]
pub struct VolumeFill {
    targets: SharedTargets,
    covers: Covers,
    /// Plain covers of one step are one draw.
    merges_covers: bool,
    /// Covers show the picture, if one is held.
    draws_texture: bool,
    /// Every frame copies depth.
    copies_depth: bool,
    /// Where to, once a program is there.
    depth_copy: Option<DepthCopy>,
    /// Covers of a textured fill, which stand where the plain ones would.
    textured: Option<TexturedFill>,
    loaded: Option<Loaded>,
}

/// A program, and what the device holds for it.
#[derive(Debug)]
struct Loaded {
    work: StencilWork,
    view_constants: Arc<Buffer>,
    constants: Arc<Buffer>,
    bindings: BindGroup,
    /// Plain covers, if they are merged.
    covers: Option<CoverList>,
    /// Where the program accumulates numbers, if it does.
    numbers: Option<Numbers>,
}

impl Loaded {
    fn steps(&self) -> impl Iterator<Item = FillStep<'_>> {
        self.work.program.passes.iter().flat_map(FillPass::steps)
    }
}

const NO_PROGRAM: DeviceError = DeviceError::Missing("stencil program");

impl<V: VulkanVolumes> StencilExecutor<V> for VolumeFill {
    type Targets = SharedTargets;

    fn new(targets: &SharedTargets, switches: &Switches) -> Result<Self, DeviceError> {
        let gpu = Arc::clone(targets.borrow().gpu());
        let reads_depth = switches.texture.is_some() || switches.loads_texture;
        let can_read = !reads_depth || gpu.facts.features.samples_depth;
        gpu.require(can_read, "reading depth in shaders")?;
        let is_plain = switches.first_pass == FirstPass::Stencil;
        gpu.require(is_plain, "fragment programs in the first pass")?;
        Ok(Self {
            targets: SharedTargets::clone(targets),
            draws_texture: switches.texture.is_some(),
            copies_depth: switches.copies_depth,
            depth_copy: None,
            covers: Covers::new(switches.merges_draws),
            merges_covers: switches.merges_draws && switches.texture.is_none(),
            textured: None,
            loaded: None,
        })
    }

    fn adapter(&self) -> String {
        self.gpu().facts.title()
    }

    fn work_done(&self) -> WorkDone {
        self.gpu().work_done()
    }

    fn targets(&self) -> &RefCell<dyn SurfaceTargets> {
        &*self.targets
    }

    fn holds_surface(&self, view: ViewId) -> bool {
        self.targets.borrow().holds(view)
    }

    fn load(&mut self, work: StencilWork) -> Result<(), DeviceError> {
        let mut before = self.loaded.take();
        if work.blends {
            let what = "blending colours of stencil programs";
            return Err(DeviceError::unsupported(what, crate::API.name));
        }
        let targets = self.targets.borrow();
        if self.copies_depth && self.depth_copy.is_none() {
            self.depth_copy = Some(targets.depth_copy()?);
        }
        let numbers = if work.program.accumulates() {
            match before.as_mut().and_then(|held| held.numbers.take()) {
                None => Some(targets.numbers()?),
                held => held,
            }
        } else {
            None
        };
        let gpu = targets.gpu();
        let instances = self
            .merges_covers
            .then(|| work.program.cover_instances(&work.list));
        let covers = match instances.filter(|instances| !instances.is_empty()) {
            Some(instances) => {
                let held = before.as_mut().and_then(|held| held.covers.take());
                Some(CoverList::new(gpu, &instances, held)?)
            }
            None => None,
        };
        let view_constants = targets.view_constants();
        let view_constants = view_constants.ok_or(DeviceError::Missing("view of a surface"))?;
        let constants = match &before {
            Some(held) if held.constants.size() >= work.constants.len() as u64 => {
                held.constants
                    .rewrite_changed(&held.work.constants, &work.constants)?;
                Arc::clone(&held.constants)
            }
            _ => {
                let label = "volume constants";
                let bytes = &work.constants;
                Arc::new(Buffer::upload(gpu, label, bytes, BufferUse::Storage)?)
            }
        };
        let is_bound = |held: &Loaded| {
            Arc::ptr_eq(&held.constants, &constants)
                && Arc::ptr_eq(&held.view_constants, view_constants)
        };
        let bindings = match before {
            Some(held) if is_bound(&held) => held.bindings,
            _ => BindGroup::new(gpu, view_constants, Some(&constants))?,
        };
        self.loaded = Some(Loaded {
            work,
            view_constants: Arc::clone(view_constants),
            constants,
            bindings,
            covers,
            numbers,
        });
        Ok(())
    }

    fn set_picture(&mut self, picture: &MipChain, copies: usize) -> Result<(), DeviceError> {
        let gpu = self.gpu();
        let textured = self.textured.get_or_insert_default();
        textured.upload_image(&gpu, picture, copies)
    }

    fn set_covers(&mut self, plan: &TexturedPlan) -> Result<(), DeviceError> {
        let textured = self.textured.as_mut();
        let textured = textured.ok_or(DeviceError::Missing("picture"))?;
        textured.set_view(&self.targets.borrow(), plan)
    }

    fn ensure(&mut self, volumes: &mut V) -> Result<(), DeviceError> {
        let gpu = self.gpu();
        let loaded = self.loaded.as_ref().ok_or(NO_PROGRAM)?;
        volumes.merge(&gpu, &loaded.work.list, &loaded.work.program)?;
        for step in loaded.steps() {
            match step {
                FillStep::Volumes(draw) => volumes.ensure(&gpu, &draw)?,
                FillStep::Cover(cover) => {
                    if let Some(textured) = &mut self.textured {
                        // Textured covers write no stencil.
                        let test = StencilTest {
                            zeroes: false,
                            ..cover.test
                        };
                        textured.ensure(&gpu, test, CoverPurpose::Colour, cover.volumes)?;
                    }
                    if !self.draws_texture {
                        self.covers.ensure_cover(&gpu, cover.test)?;
                    }
                }
                FillStep::Resolve => self.covers.ensure_resolve(&gpu)?,
            }
        }
        Ok(())
    }

    fn draw(&mut self, volumes: &mut V) -> Result<Counters, DeviceError> {
        let (report, mut counters) = self.measure(volumes, Measured::Statistics)?;
        if let Some(statistics) = report.statistics {
            counters.vertex_shader_invocations = Some(statistics.vertex_shader_invocations);
            // Without a geometry shader there is nothing to count.
            let ran = statistics
                .geometry_shader_invocations
                .is_some_and(|count| count > 0);
            counters.geometry_shader_primitives =
                statistics.geometry_shader_primitives.filter(|_| ran);
            counters.clipper_invocations = Some(statistics.clipper_invocations);
            counters.clipper_primitives_out = Some(statistics.clipper_primitives_out);
            counters.fragment_shader_invocations = Some(statistics.fragment_shader_invocations);
        }
        Ok(counters)
    }

    fn time(&mut self, volumes: &mut V) -> Result<FrameTimes, DeviceError> {
        let watch = CpuStopwatch::start();
        let (report, _) = self.measure(volumes, Measured::Times)?;
        Ok(FrameTimes {
            fill_cpu_ms: watch.cpu_ms(),
            fill_wall_ms: watch.wall_ms(),
            ..report.times
        })
    }

    fn probe(&mut self, volumes: &mut V) -> Result<Vec<Option<Probed>>, DeviceError> {
        let gpu = self.gpu();
        let loaded = self.loaded.as_ref().ok_or(NO_PROGRAM)?;
        let textured = self.textured.as_mut();
        let textured = textured.ok_or(DeviceError::Missing("picture"))?;
        for step in loaded.steps() {
            if let FillStep::Cover(cover) = step {
                textured.ensure(&gpu, cover.test, CoverPurpose::Probe, cover.volumes)?;
            }
        }
        let pixels = loaded.work.list.size.pixel_count();
        let probe = self.targets.borrow().probe()?;
        self.run(volumes, Measured::Nothing, Some(&probe))?;
        probed(&probe, pixels)
    }

    fn count_fragments(&mut self, volumes: &mut V) -> Result<Option<u64>, DeviceError> {
        let gpu = self.gpu();
        let loaded = self.loaded.as_ref().ok_or(NO_PROGRAM)?;
        let StencilWork { list, program, .. } = &loaded.work;
        if program.passes.is_empty() {
            return Ok(Some(0));
        }
        for draw in program.counted() {
            volumes.ensure(&gpu, &draw)?;
        }
        let volumes = &*volumes;
        let targets = self.targets.borrow();
        let mut unused = Counters::default();
        let report = targets.fill(1, Measured::Samples, |recorder| {
            recorder.pass(false, false, |recorder| {
                let mut pass = VolumePass::new(recorder, list, &loaded.bindings, &mut unused);
                for draw in program.counted() {
                    volumes.draw(&mut pass, &draw);
                }
            });
        })?;
        Ok(report.samples)
    }

    fn holdings(&self) -> Vec<Holding> {
        let mut all: Vec<Holding> = self.covers.holdings().collect();
        all.extend(self.textured.iter().flat_map(TexturedFill::holdings));
        if let Some(loaded) = &self.loaded {
            all.push(loaded.work.constants_held(loaded.constants.size()));
            all.extend(loaded.covers.iter().map(CoverList::holding));
            let numbers = loaded.numbers.as_ref().map_or(0, Numbers::bytes);
            all.push(Holding::target(Feature::NumberTarget, numbers));
        }
        let copy = self.depth_copy.as_ref().map_or(0, DepthCopy::bytes);
        all.push(Holding::target(Feature::DepthCopy, copy));
        all
    }
}

impl VolumeFill {
    /// Whether covers show a picture.
    fn shows_texture(&self) -> bool {
        self.draws_texture && self.textured.is_some()
    }

    /// The device.
    #[must_use]
    pub fn gpu(&self) -> Arc<Gpu> {
        Arc::clone(self.targets.borrow().gpu())
    }

    /// Runs the program once on top of the surface, and waits for it.
    ///
    /// # Errors
    /// [`DeviceError::Missing`] when there is no program or no surface,
    /// [`DeviceError::DeviceLost`].
    pub fn measure(
        &self,
        volumes: &impl VulkanVolumes,
        measured: Measured,
    ) -> Result<(FillReport, Counters), DeviceError> {
        self.run(volumes, measured, None)
    }

    /// - `probe`: textured covers write where their texels came from into this instead of colours
    fn run(
        &self,
        volumes: &impl VulkanVolumes,
        measured: Measured,
        probe: Option<&Probe>,
    ) -> Result<(FillReport, Counters), DeviceError> {
        let mut counters = Counters::default();
        let loaded = self.loaded.as_ref().ok_or(NO_PROGRAM)?;
        let targets = self.targets.borrow();
        let recording = Recording {
            fill: self,
            loaded,
            probe,
        };
        let passes = loaded.work.program.passes.len();
        let report = targets.fill(passes, measured, |recorder| {
            recording.record(recorder, volumes, &mut counters);
        })?;
        Ok((report, counters))
    }
}

/// What one run is recorded from.
struct Recording<'a> {
    fill: &'a VolumeFill,
    loaded: &'a Loaded,
    probe: Option<&'a Probe>,
}

impl<'a> Recording<'a> {
    /// All passes.
    fn record<V: VulkanVolumes>(
        &self,
        recorder: &mut FillRecorder<'a>,
        volumes: &'a V,
        counters: &mut Counters,
    ) {
        let Loaded {
            work,
            bindings,
            numbers,
            ..
        } = self.loaded;
        if let Some(copy) = self
            .fill
            .depth_copy
            .as_ref()
            .filter(|_| !work.program.passes.is_empty())
        {
            recorder.copy_depth(copy);
        }
        let mut covered = 0;
        for pass in &work.program.passes {
            let steps = |recorder: &mut PassRecorder<'a, '_>| {
                let mut volume_pass = VolumePass::new(recorder, &work.list, bindings, counters);
                for step in pass.steps() {
                    self.step(&mut volume_pass, volumes, &step, &mut covered);
                }
            };
            if let (true, Some(numbers)) = (pass.accumulates(), numbers) {
                recorder.accumulate(numbers, steps);
            } else if pass.has_colour && self.fill.shows_texture() {
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

    /// - `covered`: how many merged covers are drawn so far
    fn step<V: VulkanVolumes>(
        &self,
        pass: &mut VolumePass<'a, '_, '_>,
        volumes: &'a V,
        step: &FillStep<'_>,
        covered: &mut u32,
    ) {
        let fill = self.fill;
        let textured = fill.textured.as_ref().filter(|_| fill.draws_texture);
        match step {
            FillStep::Volumes(draw) => {
                pass.at_sky(false);
                volumes.draw(pass, draw);
            }
            FillStep::Cover(cover) => match (textured, &self.loaded.covers) {
                (Some(textured), _) => {
                    let purpose = match self.probe {
                        Some(_) => CoverPurpose::Probe,
                        None => CoverPurpose::Colour,
                    };
                    textured.draw_covers(pass, *cover, purpose);
                }
                (None, Some(list)) => {
                    let merged = cover.merged(&self.loaded.work.list, covered);
                    fill.covers.draw_merged(pass, cover.test, list, merged);
                }
                (None, None) => fill.covers.draw_covers(pass, *cover),
            },
            FillStep::Resolve => fill.covers.draw_resolve(pass),
        }
    }
}
