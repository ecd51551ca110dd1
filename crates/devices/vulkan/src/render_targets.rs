// SPDX-License-Identifier: MIT OR Apache-2.0
//! The targets that all backends on Vulkan share: one pair of targets and the surface drawn into
//! them, by the same shader and in the same formats as the wgpu targets'.
//!
//! A fill reads depth and never writes it, so one surface pass serves any number of fills of the
//! same view.

use crate::fixtures::DEPTH_READ_ONLY;
use crate::queries::{Queries, QueryKind, Span, span_ms};
use crate::readback::{Readable, read_images};
use crate::surface::{VulkanSurface, draw};
use crate::targets::{Numbers, Targets};
use crate::{
    BindGroup, Buffer, BufferUse, DepthBindings, DepthCopy, FillRecorder, Gpu, PassStatistics,
    Probe,
};
use ash::vk;
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_contract::{
    DeviceError, FrameTimes, Picture, SKY, SurfaceTriangles, SurfaceView, ViewConstants, ViewId,
    check_target_size,
};
use terrafill_scene::ImageSize;

/// Targets shared by the backends of one run.
pub type SharedTargets = Rc<RefCell<RenderTargets>>;

/// What is measured of a fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measured {
    /// Nothing.
    Nothing,
    /// GPU times.
    Times,
    /// Pipeline statistics.
    Statistics,
    /// Samples that pass depth and stencil test.
    Samples,
}

/// What was measured; absent where the device cannot, or it was not asked for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FillReport {
    /// GPU times of the fill: passes apart where there are two of them.
    pub times: FrameTimes,
    /// Pipeline statistics.
    pub statistics: Option<PassStatistics>,
    /// Samples that passed the depth and stencil test.
    pub samples: Option<u64>,
}

/// Targets, surface and clock on one device.
#[derive(Debug)]
pub struct RenderTargets {
    gpu: Arc<Gpu>,
    size: ImageSize,
    pub(crate) targets: Targets,
    pub(crate) stamps: Option<Queries>,
    surface: SurfaceTriangles<VulkanSurface>,
    prepared: Option<PreparedView>,
    /// The surface of what is prepared is in the targets, and these are in their layouts.
    is_drawn: bool,
}

/// A view whose surface is uploaded.
#[derive(Debug)]
struct PreparedView {
    id: ViewId,
    constants: Arc<Buffer>,
    bindings: BindGroup,
}

/// Stamps: three of a fill, two of the surface.
const STAMPS: u32 = 5;

pub(crate) const SURFACE_STAMPS: u32 = 3;

impl RenderTargets {
    /// Targets of the given size.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device has no targets that large.
    pub fn new(gpu: &Arc<Gpu>, size: ImageSize) -> Result<Self, DeviceError> {
        let limits = &gpu.limits;
        let limit = limits
            .max_image_dimension2_d
            .min(limits.max_framebuffer_width)
            .min(limits.max_framebuffer_height)
            .min(limits.max_viewport_dimensions[0])
            .min(limits.max_viewport_dimensions[1]);
        check_target_size(size, limit, &gpu.facts.name)?;
        Ok(Self {
            gpu: Arc::clone(gpu),
            size,
            targets: Targets::new(gpu, size)?,
            stamps: Queries::new(gpu, QueryKind::Timestamps, STAMPS)?,
            surface: SurfaceTriangles::new(VulkanSurface(Arc::clone(gpu))),
            prepared: None,
            is_drawn: false,
        })
    }

    /// The same, shared.
    ///
    /// # Errors
    /// As [`RenderTargets::new`].
    pub fn shared(gpu: &Arc<Gpu>, size: ImageSize) -> Result<SharedTargets, DeviceError> {
        Ok(Rc::new(RefCell::new(Self::new(gpu, size)?)))
    }

    /// The device.
    #[must_use]
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// Size of the targets.
    #[must_use]
    pub fn size(&self) -> ImageSize {
        self.size
    }

    /// Constants of the view that was prepared last.
    #[must_use]
    pub fn view_constants(&self) -> Option<&Arc<Buffer>> {
        self.prepared.as_ref().map(|prepared| &prepared.constants)
    }

    /// A target of accumulated numbers beside these.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device cannot blend into it,
    /// [`DeviceError::OutOfMemory`].
    pub fn numbers(&self) -> Result<Numbers, DeviceError> {
        let blends = self.gpu.facts.features.blends_float;
        self.gpu.require(blends, "blending into R32_SFLOAT")?;
        Numbers::new(&self.targets)
    }

    /// Room for a copy of their depth.
    ///
    /// # Errors
    /// [`DeviceError::OutOfMemory`].
    pub fn depth_copy(&self) -> Result<DepthCopy, DeviceError> {
        DepthCopy::new(&self.gpu, &self.targets)
    }

    /// The depth that the surface leaves and regions' constants, for textured covers on these targets.
    ///
    /// - `regions`: constants of one region after the other, `stride` bytes each,
    ///   a multiple of [`DepthBindings::alignment`]
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device's shaders cannot read depth, or the buffer does
    /// not fit; [`DeviceError::OutOfMemory`].
    pub fn bind_depth(
        &self,
        regions: &Arc<Buffer>,
        stride: usize,
    ) -> Result<DepthBindings, DeviceError> {
        DepthBindings::new(&self.targets, &self.gpu, regions, stride)
    }

    /// Targets of a textured fill's probe.
    ///
    /// # Errors
    /// [`DeviceError::OutOfMemory`].
    pub fn probe(&self) -> Result<Probe, DeviceError> {
        Probe::new(&self.targets, &self.gpu)
    }

    /// Uploads the view and its surface, unless they are there already.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when the view's size is not the targets'.
    pub fn prepare<'a>(&mut self, view: impl Into<SurfaceView<'a>>) -> Result<(), DeviceError> {
        let view = view.into();
        view.check_size(self.size)?;
        if self.is_prepared(view.id) {
            return Ok(());
        }
        self.is_drawn = false;
        self.prepared = None;
        let constants = Arc::new(Buffer::upload(
            &self.gpu,
            "view constants",
            bytemuck::bytes_of(&ViewConstants::new(&view)),
            BufferUse::Uniform,
        )?);
        self.surface.prepare(&view)?;
        self.prepared = Some(PreparedView {
            id: view.id,
            bindings: BindGroup::new(&self.gpu, &constants, None)?,
            constants,
        });
        Ok(())
    }

    fn is_prepared(&self, view: ViewId) -> bool {
        self.prepared
            .as_ref()
            .is_some_and(|prepared| prepared.id == view)
    }

    /// Whether the targets hold the surface of this view.
    #[must_use]
    pub fn holds(&self, view: ViewId) -> bool {
        self.is_drawn && self.is_prepared(view)
    }

    /// Clears the targets, draws the surface, waits, and gives the pass's GPU time.
    ///
    /// # Errors
    /// [`DeviceError::Missing`] before a view is prepared, [`DeviceError::DeviceLost`].
    pub fn draw_surface(&mut self) -> Result<Option<f64>, DeviceError> {
        let Some(prepared) = &self.prepared else {
            return Err(DeviceError::Missing("view of a surface"));
        };
        let span = Span::new(self.stamps.as_ref(), SURFACE_STAMPS);
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: bindings were made for this pass on this device; they and the surface live until the
        // submission is done.
        unsafe {
            self.gpu.submit(|device, commands| {
                span.begin(commands);
                self.begin_surface(commands);
                device.cmd_bind_descriptor_sets(
                    commands,
                    graphics,
                    self.gpu.fixtures.pipeline_layout,
                    0,
                    &[prepared.bindings.set.raw],
                    &[],
                );
                if let Some(surface) = self.surface.draws() {
                    draw(&self.gpu, commands, &surface);
                }
                device.cmd_end_render_pass(commands);
                span.end(commands);
            })?;
        }
        self.is_drawn = true;
        Span::new(self.stamps.as_ref(), SURFACE_STAMPS).ms()
    }

    /// Begins the pass that clears the targets and draws into all of them.
    ///
    /// # Safety
    /// Recording is under way on this device, outside of a pass.
    pub(crate) unsafe fn begin_surface(&self, commands: vk::CommandBuffer) {
        let clears = [
            vk::ClearValue {
                color: vk::ClearColorValue { float32: SKY },
            },
            vk::ClearValue {
                depth_stencil: vk::ClearDepthStencilValue::default(),
            },
        ];
        let begin = vk::RenderPassBeginInfo::default()
            .render_pass(self.gpu.fixtures.surface)
            .framebuffer(self.targets.framebuffer(true))
            .render_area(self.targets.area())
            .clear_values(&clears);
        let device = &self.gpu.device;
        // SAFETY: the caller's promise; the framebuffer is of this pass.
        unsafe {
            device.cmd_begin_render_pass(commands, &begin, vk::SubpassContents::INLINE);
            device.cmd_set_viewport(commands, 0, &[self.targets.viewport()]);
            device.cmd_set_scissor(commands, 0, &[self.targets.area()]);
        }
    }

    /// Records a fill of at most `passes` passes on top of the surface, submits it and waits.
    /// `record` must not upload, draw a surface or fill: the queue is taken while it runs.
    ///
    /// # Errors
    /// [`DeviceError::Missing`] when there is no surface in the targets; the first draw's error
    /// that could not be recorded; [`DeviceError::DeviceLost`].
    pub fn fill<'a>(
        &'a self,
        passes: usize,
        measured: Measured,
        record: impl FnOnce(&mut FillRecorder<'a>),
    ) -> Result<FillReport, DeviceError> {
        if !self.is_drawn {
            return Err(DeviceError::Missing("surface in the render targets"));
        }
        let count = u32::try_from(passes).unwrap_or(u32::MAX);
        let queries = match measured {
            Measured::Statistics => Queries::new(&self.gpu, QueryKind::Statistics, count)?,
            Measured::Samples => Queries::new(&self.gpu, QueryKind::Samples, count)?,
            Measured::Nothing | Measured::Times => None,
        };
        let stamps = self.stamps.as_ref().filter(|_| measured == Measured::Times);
        let mut recorder = FillRecorder::new(&self.gpu, &self.targets, queries.as_ref(), stamps);
        // SAFETY: the recorder records what fits only; it borrows what draws use for `'a`, which
        // outlives this call, and the queries live until the end of it.
        unsafe {
            self.gpu.submit(|_, commands| {
                recorder.begin(commands);
                record(&mut recorder);
                recorder.end();
            })?;
        }
        let drawn = recorder.finish()?;
        let mut report = FillReport::default();
        if let Some(stamps) = stamps.filter(|_| drawn > 0) {
            report.times = self.fill_times(stamps, drawn)?;
        }
        if let Some(queries) = &queries {
            // Queries that were never begun would be waited for in vain.
            let counted = drawn.min(queries.count);
            if queries.kind == QueryKind::Statistics {
                report.statistics = Some(queries.read_statistics(counted)?);
            } else {
                report.samples = Some(queries.read(0, counted)?.iter().sum());
            }
        }
        Ok(report)
    }

    fn fill_times(&self, stamps: &Queries, passes: u32) -> Result<FrameTimes, DeviceError> {
        let ticks = stamps.read(0, SURFACE_STAMPS)?;
        let span = |from: usize, to: usize| {
            span_ms(ticks[from], ticks[to], self.gpu.timestamp_period_ns())
        };
        Ok(FrameTimes {
            stencil_gpu_ms: span(0, 1).filter(|_| passes == 2),
            colour_gpu_ms: span(1, 2).filter(|_| passes == 2),
            fill_gpu_ms: span(0, 2),
            ..FrameTimes::default()
        })
    }

    /// Something else than a prepared view's surface is in the targets.
    pub(crate) fn set_drawn(&mut self) {
        self.prepared = None;
        self.is_drawn = true;
    }

    /// Reads the targets back.
    ///
    /// # Errors
    /// [`DeviceError::Missing`] when nothing was drawn yet, [`DeviceError::DeviceLost`].
    pub fn read(&self) -> Result<Picture, DeviceError> {
        if !self.is_drawn {
            return Err(DeviceError::Missing("surface in the render targets"));
        }
        let colour = Readable {
            image: &self.targets.colour,
            aspect: vk::ImageAspectFlags::COLOR,
            texel_bytes: 4,
            layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
        };
        let depth = Readable {
            image: &self.targets.depth_stencil,
            aspect: vk::ImageAspectFlags::DEPTH,
            layout: DEPTH_READ_ONLY,
            ..colour
        };
        // SAFETY: a pass has left both in these layouts, with as many bytes a texel.
        let [rgba, depth] = unsafe { read_images(&self.gpu, [colour, depth]) }?;
        Ok(Picture {
            size: self.size,
            rgba,
            depth: bytemuck::pod_collect_to_vec(&depth),
        })
    }
}
