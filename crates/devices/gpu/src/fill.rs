// SPDX-License-Identifier: MIT OR Apache-2.0
//! The stencil-program executor on wgpu: the same for everything that is drawn by closed volumes.
//!
//! The volumes are drawn by whoever made them ([`WgpuVolumes`]); this owns the constants of a list, the
//! program, covers and the accumulation target, records the passes, and measures. Depth stays as the
//! surface left it: it is attached read-only throughout. Covers of a textured fill read it there, and
//! stand in passes that leave the stencil alone as well.

use crate::attachments::{attached, read_only_depth};
use crate::covers::Covers;
use crate::loaded::{Held, Loaded};
use crate::statistics::{Statistics, whole_image};
use crate::textured::{BoundCover, Probe, TexturedFill};
use crate::volume_pipeline::check_blendable;
use crate::{Gpu, RenderTargets, SharedTargets, TimedPass, VolumePass};
use std::cell::RefCell;
use std::sync::Arc;
use terrafill_contract::{
    Counters, CpuStopwatch, DeviceError, FrameTimes, SurfaceTargets, ViewId, WorkDone,
};
use terrafill_scene::{ImageSize, MipChain};
use terrafill_stencil::{
    CoverPurpose, FillProgram, FillStep, Holding, Probed, StencilExecutor, StencilTest,
    StencilWork, TexturedPlan, VolumeDraw, VolumeList, VolumeState,
};
use terrafill_variant::{FirstPass, Switches};

/// Volumes as the passes of a stencil program draw them.
pub trait WgpuVolumes {
    /// Makes the pipelines of `draw` unless they are there. `blends` is set for colours only.
    fn ensure(&mut self, gpu: &Gpu, list: &VolumeList, draw: &VolumeDraw<'_>, blends: bool);

    /// Hands over the copy of depth that every frame makes, where the switches ask for one.
    ///
    /// # Errors
    /// [`DeviceError::OutOfMemory`].
    fn read_depth(
        &mut self,
        _gpu: &Gpu,
        _list: &VolumeList,
        _copy: &wgpu::TextureView,
    ) -> Result<(), DeviceError> {
        Ok(())
    }

    /// Makes the volumes of a frame, in a compute pass.
    ///
    /// - `constants`: group 0, view and volumes' constants
    fn make(
        &mut self,
        _encoder: &mut wgpu::CommandEncoder,
        _list: &VolumeList,
        _constants: &wgpu::BindGroup,
    ) {
    }

    /// Makes ready what draws of many volumes need, once for a program and after [`WgpuVolumes::ensure`].
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`], [`DeviceError::OutOfMemory`].
    fn merge(
        &mut self,
        _gpu: &Gpu,
        _list: &VolumeList,
        _program: &FillProgram,
    ) -> Result<(), DeviceError> {
        Ok(())
    }

    /// Whether [`WgpuVolumes::stream`] has something to do.
    fn are_streamed(&self) -> bool {
        false
    }

    /// Hands over what every frame hands over anew, before it is submitted.
    fn stream(&mut self, _gpu: &Gpu, _list: &VolumeList) {}

    /// Binds what all draws of a pass share; group 0, view and volumes' constants, is bound.
    fn bind(&self, pass: &mut wgpu::RenderPass<'_>);

    /// Draws volumes by the pipelines that [`WgpuVolumes::ensure`] made; the stencil reference is set.
    fn draw(&mut self, pass: &mut VolumePass<'_>, draw: &VolumeDraw<'_>, blends: bool);
}

/// Runs stencil programs on the targets.
#[derive(Debug)]
pub struct VolumeFill {
    pub(crate) targets: SharedTargets,
    /// Shaders bend discs into footprints.
    bends_footprints: bool,
    /// Covers show the picture, if one is held.
    draws_texture: bool,
    /// Every frame copies depth.
    copies_depth: bool,
    /// Plain covers of one step are one draw.
    merges_covers: bool,
    frame_layout: wgpu::BindGroupLayout,
    covers: Covers,
    /// Covers of a textured fill, which stand where the plain ones would.
    textured: Option<TexturedFill>,
    loaded: Option<Loaded>,
}

/// How a program is recorded.
#[derive(Debug, Clone, Copy, Default)]
struct Recording<'a> {
    /// GPU stamps surround it.
    timed: bool,
    /// Queries surround its passes.
    statistics: Option<&'a Statistics>,
    /// Textured covers write where their texels came from instead of colours.
    probe: Option<&'a Probe>,
}

const NO_PROGRAM: DeviceError = DeviceError::Missing("stencil program");

impl<V: WgpuVolumes> StencilExecutor<V> for VolumeFill {
    type Targets = SharedTargets;

    fn new(targets: &SharedTargets, switches: &Switches) -> Result<Self, DeviceError> {
        let gpu = Arc::clone(targets.borrow().gpu());
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let frame_layout = gpu.buffer_layout(
            "view and volumes",
            wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE,
            &[wgpu::BufferBindingType::Uniform, storage, storage],
        );
        Ok(Self {
            bends_footprints: switches.bends_footprints,
            draws_texture: switches.texture.is_some(),
            copies_depth: switches.copies_depth,
            targets: SharedTargets::clone(targets),
            merges_covers: switches.merges_draws && switches.texture.is_none(),
            covers: Covers::new(&gpu, &frame_layout, switches.merges_draws),
            textured: None,
            frame_layout,
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
        let before = self.loaded.take();
        let targets = self.targets.borrow();
        let on = Held {
            targets: &targets,
            frame_layout: &self.frame_layout,
            covers: &self.covers,
            merges_covers: self.merges_covers,
            copies_depth: self.copies_depth,
        };
        let loaded = Loaded::new(&on, work, before)?;
        drop(targets);
        self.loaded = Some(loaded);
        Ok(())
    }

    fn set_picture(&mut self, picture: &MipChain, copies: usize) -> Result<(), DeviceError> {
        let gpu = self.gpu();
        let layout = &self.frame_layout;
        let textured = self
            .textured
            .get_or_insert_with(|| TexturedFill::new(&gpu, layout));
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
        let StencilWork {
            list,
            program,
            blends,
            ..
        } = &loaded.work;
        if let Some(copy) = &loaded.depth_copy {
            let view = copy.create_view(&wgpu::TextureViewDescriptor {
                aspect: wgpu::TextureAspect::DepthOnly,
                ..Default::default()
            });
            volumes.read_depth(&gpu, list, &view)?;
        }
        for step in loaded.steps() {
            match step {
                FillStep::Volumes(draw) => {
                    if matches!(draw.state, VolumeState::Accumulate { .. }) {
                        check_blendable(&gpu)?;
                    }
                    volumes.ensure(&gpu, list, &draw, *blends && is_coloured(&draw));
                }
                FillStep::Cover(cover) => {
                    if let Some(textured) = &mut self.textured {
                        let test = StencilTest {
                            zeroes: false,
                            ..cover.test
                        };
                        textured.ensure(&gpu, test, CoverPurpose::Colour, cover.volumes);
                    }
                    if !self.draws_texture {
                        self.covers.ensure_cover(&gpu, cover.test, *blends)?;
                    }
                }
                FillStep::Resolve => self.covers.ensure_resolve(&gpu)?,
            }
        }
        volumes.merge(&gpu, list, program)
    }

    fn draw(&mut self, volumes: &mut V) -> Result<Counters, DeviceError> {
        let targets = self.targets.borrow();
        let gpu = targets.gpu();
        let loaded = self.loaded.as_ref();
        let passes = loaded.map_or(0, |loaded| loaded.work.program.passes.len());
        let statistics = Statistics::new(gpu, passes);
        let recording = Recording {
            statistics: statistics.as_ref(),
            ..Recording::default()
        };
        let mut counters = self.run(&targets, volumes, recording)?;
        if let Some(statistics) = &statistics {
            statistics.read_into(gpu, &mut counters)?;
        }
        Ok(counters)
    }

    fn time(&mut self, volumes: &mut V) -> Result<FrameTimes, DeviceError> {
        let targets = self.targets.borrow();
        let watch = CpuStopwatch::start();
        let recording = Recording {
            timed: true,
            ..Recording::default()
        };
        self.run(&targets, volumes, recording)?;
        let mut times = FrameTimes {
            fill_cpu_ms: watch.cpu_ms(),
            fill_wall_ms: watch.wall_ms(),
            ..FrameTimes::default()
        };
        self.read_stamps(&targets, &mut times)?;
        Ok(times)
    }

    fn probe(&mut self, volumes: &mut V) -> Result<Vec<Option<Probed>>, DeviceError> {
        let gpu = self.gpu();
        let loaded = self.loaded.as_ref().ok_or(NO_PROGRAM)?;
        let textured = self.textured.as_mut();
        let textured = textured.ok_or(DeviceError::Missing("picture"))?;
        for step in loaded.steps() {
            if let FillStep::Cover(cover) = step {
                textured.ensure(&gpu, cover.test, CoverPurpose::Probe, cover.volumes);
            }
        }
        let probe = Probe::new(&gpu, loaded.work.list.size);
        let recording = Recording {
            probe: Some(&probe),
            ..Recording::default()
        };
        self.run(&self.targets.borrow(), volumes, recording)?;
        probe.read(&gpu)
    }

    fn count_fragments(&mut self, volumes: &mut V) -> Result<Option<u64>, DeviceError> {
        let loaded = self.loaded.as_ref().ok_or(NO_PROGRAM)?;
        let StencilWork { list, program, .. } = &loaded.work;
        if program.passes.is_empty() {
            return Ok(Some(0));
        }
        let targets = self.targets.borrow();
        let gpu = targets.gpu();
        let Some(statistics) = Statistics::new(gpu, 2) else {
            return Ok(None);
        };
        let whole_image = whole_image(gpu)?;
        for draw in program.counted() {
            volumes.ensure(gpu, list, &draw, false);
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
        raw.set_bind_group(0, &loaded.bind_group, &[]);
        volumes.bind(&mut raw);
        let mut unused = Counters::default();
        let mut pass = VolumePass::new(raw, list, &mut unused);
        for draw in program.counted() {
            volumes.draw(&mut pass, &draw, false);
        }
        pass.raw.end_pipeline_statistics_query();
        statistics.begin(&mut pass.raw, 1);
        pass.raw.set_pipeline(&whole_image);
        let ImageSize { width, height } = list.size;
        pass.raw.set_scissor_rect(0, 0, width, height);
        pass.raw.draw(0..3, 0..1);
        pass.raw.end_pipeline_statistics_query();
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        Ok(counted_fragments(&statistics.fragments(gpu)?))
    }

    fn holdings(&self) -> Vec<Holding> {
        let mut all: Vec<Holding> = self.covers.holdings().collect();
        all.extend(self.textured.iter().flat_map(TexturedFill::holdings));
        all.extend(self.loaded.iter().flat_map(Loaded::holdings));
        all
    }
}

impl VolumeFill {
    /// The device.
    #[must_use]
    pub fn gpu(&self) -> Arc<Gpu> {
        Arc::clone(self.targets.borrow().gpu())
    }

    /// A shader of volumes, as the switches ask for it.
    ///
    /// # Errors
    /// [`DeviceError::Shader`].
    pub fn shader(&self, path: &str) -> Result<wgpu::ShaderModule, DeviceError> {
        self.gpu().volume_shader(path, self.bends_footprints)
    }

    /// Layout of group 0: the view, the volumes' constants, and their footprints.
    #[must_use]
    pub fn frame_layout(&self) -> &wgpu::BindGroupLayout {
        &self.frame_layout
    }

    fn read_stamps(
        &self,
        targets: &RenderTargets,
        times: &mut FrameTimes,
    ) -> Result<(), DeviceError> {
        let (Some(timer), Some(loaded)) = (targets.timer(), &self.loaded) else {
            return Ok(());
        };
        let gpu = targets.gpu();
        match loaded.work.program.passes.len() {
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
        Ok(())
    }

    /// Records the program, submits it and waits.
    fn run(
        &self,
        targets: &RenderTargets,
        volumes: &mut impl WgpuVolumes,
        recording: Recording<'_>,
    ) -> Result<Counters, DeviceError> {
        let mut counters = Counters::default();
        let loaded = self.loaded.as_ref().ok_or(NO_PROGRAM)?;
        let list = &loaded.work.list;
        let gpu = targets.gpu();
        let passes = &loaded.work.program.passes;
        let begin = begin_stamp(targets, recording, passes.len());
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        if !passes.is_empty() {
            volumes.make(&mut encoder, list, &loaded.bind_group);
            if let Some(copy) = &loaded.depth_copy {
                targets.copy_depth(&mut encoder, copy);
            }
        }
        let (colour, depth_stencil) = (targets.colour_view(), targets.depth_stencil_view());
        let probe_views = recording.probe.map(Probe::views);
        let purpose = match recording.probe {
            Some(_) => CoverPurpose::Probe,
            None => CoverPurpose::Colour,
        };
        let mut zero = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        let mut covered = 0;
        for (index, steps) in passes.iter().enumerate() {
            let is_textured = steps.has_colour && self.draws_texture && self.textured.is_some();
            let attachments = match (&loaded.numbers, &probe_views) {
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
                _ if steps.first_pass != FirstPass::Stencil => {
                    let unread = loaded.unread.as_ref();
                    let unread = unread.map(|view| attached(view, wgpu::LoadOp::Load));
                    vec![unread]
                }
                _ => Vec::new(),
            };
            let stencil = if is_textured || !steps.touches_stencil() {
                // Depth is sampled in a textured pass, which nothing of its texture may be written in.
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
                timestamp_writes: stamps(targets, recording, index, passes.len()),
                ..Default::default()
            });
            if let Some(statistics) = recording.statistics {
                statistics.begin(&mut raw, index);
            }
            raw.set_bind_group(0, &loaded.bind_group, &[]);
            volumes.bind(&mut raw);
            if let Some(covers) = &loaded.covers {
                covers.bind(&mut raw);
            }
            let mut pass = VolumePass::new(raw, list, &mut counters);
            let mut bound = BoundCover::default();
            for step in steps.steps() {
                match (step, &self.textured) {
                    (FillStep::Cover(cover), Some(textured)) if is_textured => {
                        let test = cover.test;
                        pass.raw.set_stencil_reference(u32::from(test.reference));
                        for &volume in cover.volumes {
                            if textured.bind(&mut pass.raw, test, purpose, volume, &mut bound) {
                                pass.cut(volume, cover.scissor);
                                pass.draw(0..3, volume);
                            }
                        }
                    }
                    (step, _) => self.step(&mut pass, volumes, loaded, &step, &mut covered),
                }
            }
            if recording.statistics.is_some() {
                pass.raw.end_pipeline_statistics_query();
            }
        }
        let mut commands: Vec<wgpu::CommandBuffer> = begin.into_iter().collect();
        if volumes.are_streamed() {
            // A queue's writes come before the commands of the next submission: the stamp goes ahead of them alone.
            gpu.queue.submit(commands.drain(..));
            volumes.stream(gpu, list);
        }
        commands.push(encoder.finish());
        gpu.queue.submit(commands);
        gpu.wait()?;
        Ok(counters)
    }

    /// - `covered`: how many merged covers are drawn so far
    fn step(
        &self,
        pass: &mut VolumePass<'_>,
        volumes: &mut impl WgpuVolumes,
        loaded: &Loaded,
        step: &FillStep<'_>,
        covered: &mut u32,
    ) {
        let blends = loaded.work.blends;
        match step {
            FillStep::Volumes(draw) => {
                if let VolumeState::Colour { test, .. } = draw.state {
                    pass.raw.set_stencil_reference(u32::from(test.reference));
                }
                pass.at_sky(false);
                volumes.draw(pass, draw, blends && is_coloured(draw));
            }
            FillStep::Cover(cover) if loaded.covers.is_some() => {
                let merged = cover.merged(&loaded.work.list, covered);
                self.covers.draw_merged(pass, cover.test, blends, merged);
            }
            FillStep::Cover(cover) => self.covers.draw_covers(pass, *cover, blends),
            FillStep::Resolve => {
                if let Some(numbers) = &loaded.numbers {
                    self.covers.draw_resolve(pass, numbers);
                }
            }
        }
    }
}

/// Fragments of the first query, of volumes; the second is of the whole image.
///
/// A device may leave out fragments that write nothing: runs on an NVIDIA H200 had 0 everywhere. Then it counts none of
/// the whole image either, and its 0 says nothing.
fn counted_fragments(of: &[u64]) -> Option<u64> {
    match *of {
        [volumes, whole_image] if whole_image > 0 => Some(volumes),
        _ => None,
    }
}

fn is_coloured(draw: &VolumeDraw<'_>) -> bool {
    matches!(draw.state, VolumeState::Colour { .. })
}

/// Slot that begins with the frame.
fn first_slot(passes: usize) -> TimedPass {
    match passes {
        1 => TimedPass::Colour,
        _ => TimedPass::Stencil,
    }
}

/// The last pass is stamped as colour; of several, the first as stencil. The first begins with the frame.
fn stamps<'a>(
    targets: &'a RenderTargets,
    recording: Recording<'_>,
    index: usize,
    passes: usize,
) -> Option<wgpu::RenderPassTimestampWrites<'a>> {
    let timer = targets.timer().filter(|_| recording.timed)?;
    match index {
        0 => Some(timer.writes(None, Some(first_slot(passes)))),
        _ if index + 1 == passes => Some(timer.around(TimedPass::Colour)),
        _ => None,
    }
}

/// The stamp before everything that a frame does on the device.
fn begin_stamp(
    targets: &RenderTargets,
    recording: Recording<'_>,
    passes: usize,
) -> Option<wgpu::CommandBuffer> {
    let timer = targets.timer().filter(|_| recording.timed && passes > 0)?;
    let mut encoder = targets
        .gpu()
        .device
        .create_command_encoder(&Default::default());
    timer.begin(&mut encoder, first_slot(passes));
    Some(encoder.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_that_counts_nothing_of_the_whole_image_has_counted_no_fragments() {
        assert_eq!(counted_fragments(&[0, 0]), None);
        // Negative control: volumes that no pixel shows, on a device that counts.
        assert_eq!(counted_fragments(&[0, 4_096]), Some(0));
        assert_eq!(counted_fragments(&[77, 4_096]), Some(77));
    }
}
