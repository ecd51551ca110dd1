// SPDX-License-Identifier: MIT OR Apache-2.0
//! The backend of fills in one pass over the surface that the targets hold, without volumes and without stencil.
//! Each says by [`Overlay`] what it draws.

use crate::{Gpu, RenderTargets, SharedTargets, TimedPass, attached, read_only_depth};
use std::fmt::Debug;
use terrafill_contract::{
    Colours, Counters, CpuStopwatch, DeviceError, FillBackend, FillInput, Frame, FrameTimes,
    MemoryUse, Picture, Uploaded, ViewId, WorkDone,
};

/// Something drawn over a surface in one pass.
pub trait Overlay: Sized + Debug {
    /// Name of the technique in rows.
    const TECHNIQUE: &'static str;
    /// Whether its fragments read depth themselves, so that none is attached.
    const READS_DEPTH: bool;

    /// Makes and uploads what `input` needs and is not there yet; a second call with the same input
    /// and colours makes and writes nothing.
    ///
    /// # Errors
    /// [`DeviceError`] when the device or the overlay cannot hold or draw it.
    fn load(
        &mut self,
        targets: &RenderTargets,
        input: &FillInput,
        colours: Colours,
    ) -> Result<(), DeviceError>;

    /// Records its draws and counts them.
    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, counters: &mut Counters);

    /// What it holds.
    fn memory(&self) -> MemoryUse;
}

/// Draws an overlay.
#[derive(Debug)]
pub struct OverlayBackend<O> {
    targets: SharedTargets,
    overlay: O,
    /// Revision of the meshes and the view that it was loaded for.
    loaded: Option<(u64, ViewId)>,
    /// What the device did since the last frame.
    work: WorkDone,
}

impl<O: Overlay> OverlayBackend<O> {
    /// Draws `overlay` into `targets`; nothing is loaded yet.
    #[must_use]
    pub fn new(targets: &SharedTargets, overlay: O) -> Self {
        Self {
            targets: SharedTargets::clone(targets),
            overlay,
            loaded: None,
            work: WorkDone::default(),
        }
    }

    /// What it draws, to be changed.
    #[must_use]
    pub fn overlay_mut(&mut self) -> &mut O {
        &mut self.overlay
    }

    fn check_prepared(&self, input: &FillInput) -> Result<(), DeviceError> {
        let (revision, view) = self.loaded.unzip();
        input.check_prepared(O::TECHNIQUE, revision, view)
    }

    fn load(&mut self, input: &FillInput, colours: Colours) -> Result<u64, DeviceError> {
        self.loaded = None;
        self.targets.borrow_mut().prepare(input)?;
        let targets = self.targets.borrow();
        let before = targets.gpu().work_done();
        self.overlay.load(&targets, input, colours)?;
        let done = targets.gpu().work_done() - before;
        self.work = self.work + done;
        self.loaded = Some((input.scene.meshes.revision(), input.view_id));
        Ok(done.upload_bytes)
    }

    fn draw_and_read(&mut self, input: &FillInput) -> Result<(Picture, Counters), DeviceError> {
        self.draw_surface(input)?;
        let targets = self.targets.borrow();
        let before = targets.gpu().work_done();
        let mut counters = self.run(&targets, false)?;
        let prepared = std::mem::take(&mut self.work);
        let drawing = targets.gpu().work_done() - before;
        WorkDone::write_into(&mut counters, prepared, drawing);
        Ok((targets.read()?, counters))
    }

    /// Draws the overlay once and waits.
    fn run(&self, targets: &RenderTargets, timed: bool) -> Result<Counters, DeviceError> {
        let gpu: &Gpu = targets.gpu();
        let mut counters = Counters::default();
        let (colour, depth_stencil) = (targets.colour_view(), targets.depth_stencil_view());
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let timer = targets.timer().filter(|_| timed);
        if let Some(timer) = timer {
            timer.begin(&mut encoder, TimedPass::Colour);
        }
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(O::TECHNIQUE),
            color_attachments: &[Some(attached(&colour, wgpu::LoadOp::Load))],
            // Neither depth nor stencil is written.
            depth_stencil_attachment: (!O::READS_DEPTH)
                .then(|| read_only_depth(&depth_stencil, None)),
            timestamp_writes: timer.map(|timer| timer.writes(None, Some(TimedPass::Colour))),
            ..Default::default()
        });
        self.overlay.draw(&mut pass, &mut counters);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        Ok(counters)
    }
}

impl<O: Overlay> FillBackend for OverlayBackend<O> {
    fn tells_regions_apart(&self) -> bool {
        true
    }

    fn prepare(&mut self, input: &FillInput) -> Result<MemoryUse, DeviceError> {
        input.check_region_count()?;
        let upload_bytes = self.load(input, Colours::Ids)?;
        Ok(MemoryUse {
            upload_bytes,
            ..self.overlay.memory()
        })
    }

    /// Uploads everything: an overlay has no place of its own for each region.
    fn update(&mut self, input: &FillInput, changed: &[usize]) -> Result<Uploaded, DeviceError> {
        input.check_region_count()?;
        let revision = self.loaded.map(|(revision, _)| revision);
        input.check_update(O::TECHNIQUE, revision, changed)?;
        Ok(Uploaded {
            bytes: self.load(input, Colours::Ids)?,
            regions: (0..input.scene.meshes.len()).collect(),
        })
    }

    fn render(&mut self, input: &FillInput) -> Result<Frame, DeviceError> {
        self.check_prepared(input)?;
        let (picture, counters) = self.draw_and_read(input)?;
        Ok(Frame::from_picture(&picture, counters))
    }

    fn picture(&mut self, input: &FillInput) -> Result<Picture, DeviceError> {
        self.check_prepared(input)?;
        self.load(input, Colours::Palette { opacity: 1.0 })?;
        let drawn = self.draw_and_read(input);
        self.load(input, Colours::Ids)?;
        drawn.map(|(picture, _)| picture)
    }

    fn draw_surface(&mut self, input: &FillInput) -> Result<Option<f64>, DeviceError> {
        let mut targets = self.targets.borrow_mut();
        targets.prepare(input)?;
        targets.draw_surface()
    }

    fn time_frame(&mut self, input: &FillInput) -> Result<FrameTimes, DeviceError> {
        self.check_prepared(input)?;
        let targets = self.targets.borrow();
        if !targets.holds(input.view_id) {
            return Err(input.not_prepared(O::TECHNIQUE));
        }
        let watch = CpuStopwatch::start();
        self.run(&targets, true)?;
        let (fill_cpu_ms, fill_wall_ms) = (watch.cpu_ms(), watch.wall_ms());
        Ok(FrameTimes {
            fill_gpu_ms: targets.pass_ms(TimedPass::Colour)?,
            fill_cpu_ms,
            fill_wall_ms,
            ..FrameTimes::default()
        })
    }
}
