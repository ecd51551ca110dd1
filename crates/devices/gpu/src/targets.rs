// SPDX-License-Identifier: MIT OR Apache-2.0
//! The render targets of every wgpu backend: one pair of targets and the surface drawn into them.
//!
//! Backends share one set of targets, so that "after the same surface, into the same formats" holds by
//! construction. A fill reads depth and never writes it, so one surface pass serves any number of
//! fills of the same view.

use crate::attachments::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, target};
use crate::readback::read_texture;
use crate::surface::{WgpuSurface, draw};
use crate::{Gpu, PassTimer, TimedPass};
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_contract::{
    DeviceError, Picture, SurfaceTriangles, SurfaceView, ViewConstants, ViewId, check_target_size,
};
use terrafill_scene::ImageSize;

/// Targets shared by the backends of one run.
pub type SharedTargets = Rc<RefCell<RenderTargets>>;

/// Targets, surface and timer on one device.
#[derive(Debug)]
pub struct RenderTargets {
    gpu: Arc<Gpu>,
    size: ImageSize,
    colour: wgpu::Texture,
    depth_stencil: wgpu::Texture,
    timer: Option<PassTimer>,
    view_constants: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
    surface: SurfaceTriangles<WgpuSurface>,
    /// The view whose surface is uploaded.
    prepared: Option<ViewId>,
    /// That surface is in the targets.
    is_drawn: bool,
}

impl RenderTargets {
    /// Targets of the given size.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device has no textures that large.
    pub fn new(gpu: &Arc<Gpu>, size: ImageSize) -> Result<Self, DeviceError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        check_target_size(size, limit, &gpu.facts.name)?;
        let uniform = wgpu::BufferBindingType::Uniform;
        let layout = gpu.buffer_layout("surface", wgpu::ShaderStages::VERTEX_FRAGMENT, &[uniform]);
        let bytes = size_of::<ViewConstants>() as u64;
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let view_constants = gpu.unwritten("view constants", bytes, usage);
        let bind_group = gpu.bind_buffers("surface", &layout, &[&view_constants]);
        let copied = wgpu::TextureUsages::COPY_SRC;
        Ok(Self {
            gpu: Arc::clone(gpu),
            size,
            colour: target(gpu, size, "colour", COLOUR_FORMAT, copied),
            depth_stencil: target(
                gpu,
                size,
                "depth and stencil",
                DEPTH_STENCIL_FORMAT,
                copied | wgpu::TextureUsages::TEXTURE_BINDING,
            ),
            timer: PassTimer::new(gpu),
            view_constants,
            bind_group,
            surface: SurfaceTriangles::new(WgpuSurface {
                gpu: Arc::clone(gpu),
                view_layout: layout,
            }),
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

    /// GPU clock, where there is one.
    #[must_use]
    pub fn timer(&self) -> Option<&PassTimer> {
        self.timer.as_ref()
    }

    /// GPU time of a pass that was drawn last and waited for, milliseconds, where the device keeps time.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn pass_ms(&self, pass: TimedPass) -> Result<Option<f64>, DeviceError> {
        let timed = self.timer.as_ref().map(|of| of.pass_ms(&self.gpu, pass));
        Ok(timed.transpose()?.flatten())
    }

    /// Constants of the view that was prepared last.
    #[must_use]
    pub fn view_constants(&self) -> &wgpu::Buffer {
        &self.view_constants
    }

    /// Colour target.
    #[must_use]
    pub fn colour_view(&self) -> wgpu::TextureView {
        self.colour.create_view(&Default::default())
    }

    /// Depth and stencil as an attachment.
    #[must_use]
    pub fn depth_stencil_view(&self) -> wgpu::TextureView {
        self.depth_stencil.create_view(&Default::default())
    }

    /// Depth for sampling.
    #[must_use]
    pub fn depth_view(&self) -> wgpu::TextureView {
        self.depth_stencil
            .create_view(&wgpu::TextureViewDescriptor {
                aspect: wgpu::TextureAspect::DepthOnly,
                ..Default::default()
            })
    }

    /// Uploads the view and its surface, unless they are there already.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when the view's size is not the targets'.
    pub fn prepare<'a>(&mut self, view: impl Into<SurfaceView<'a>>) -> Result<(), DeviceError> {
        let view = view.into();
        view.check_size(self.size)?;
        if self.prepared == Some(view.id) {
            return Ok(());
        }
        self.is_drawn = false;
        self.prepared = None;
        let constants = ViewConstants::new(&view);
        self.gpu
            .write_buffer(&self.view_constants, 0, bytemuck::bytes_of(&constants));
        self.surface.prepare(&view)?;
        self.prepared = Some(view.id);
        Ok(())
    }

    /// Copies depth, and the stencil with it, into a texture of this size.
    pub(crate) fn copy_depth(&self, encoder: &mut wgpu::CommandEncoder, to: &wgpu::Texture) {
        encoder.copy_texture_to_texture(
            self.depth_stencil.as_image_copy(),
            to.as_image_copy(),
            self.depth_stencil.size(),
        );
    }

    /// Whether the targets hold the surface of this view.
    #[must_use]
    pub fn holds(&self, view: ViewId) -> bool {
        self.is_drawn && self.prepared == Some(view)
    }

    /// Clears the targets, draws the surface, waits, and gives the pass's GPU time.
    ///
    /// # Errors
    /// [`DeviceError::Missing`] before a view is prepared, [`DeviceError::DeviceLost`].
    pub fn draw_surface(&mut self) -> Result<Option<f64>, DeviceError> {
        if self.prepared.is_none() {
            return Err(DeviceError::Missing("view of a surface"));
        }
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let around = self.timer.as_ref().map(|t| t.around(TimedPass::Surface));
        let mut pass = self.begin_cleared(&mut encoder, "surface", around);
        pass.set_bind_group(0, &self.bind_group, &[]);
        if let Some(surface) = self.surface.draws() {
            draw(&mut pass, &surface);
        }
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()?;
        self.is_drawn = true;
        self.direct_ms()
    }

    /// Reads the targets back.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn read(&self) -> Result<Picture, DeviceError> {
        let depth = read_texture(
            &self.gpu,
            &self.depth_stencil,
            wgpu::TextureAspect::DepthOnly,
        )?;
        Ok(Picture {
            size: self.size,
            rgba: read_texture(&self.gpu, &self.colour, wgpu::TextureAspect::All)?,
            depth: bytemuck::pod_collect_to_vec(&depth),
        })
    }
}
