// SPDX-License-Identifier: MIT OR Apache-2.0
//! The graphics interfaces that draw surfaces, and what the study needs of each.

use terrafill_fill::{Api, DeviceError, Devices, Picture, SurfaceView};
use terrafill_gpu::RayCast;
use terrafill_scene::ImageSize;

/// Targets that a surface is drawn into.
pub(crate) trait Drawing {
    /// Uploads a view of a surface.
    fn upload(&mut self, view: SurfaceView<'_>) -> Result<(), DeviceError>;

    /// Draws it, waits, and gives the GPU's time.
    fn draw(&mut self) -> Result<Option<f64>, DeviceError>;

    /// Colour and depth.
    fn read(&self) -> Result<Picture, DeviceError>;
}

impl Drawing for terrafill_gpu::RenderTargets {
    fn upload(&mut self, view: SurfaceView<'_>) -> Result<(), DeviceError> {
        self.prepare(view)
    }

    fn draw(&mut self) -> Result<Option<f64>, DeviceError> {
        self.draw_surface()
    }

    fn read(&self) -> Result<Picture, DeviceError> {
        self.read()
    }
}

impl Drawing for terrafill_vulkan::RenderTargets {
    fn upload(&mut self, view: SurfaceView<'_>) -> Result<(), DeviceError> {
        self.prepare(view)
    }

    fn draw(&mut self) -> Result<Option<f64>, DeviceError> {
        self.draw_surface()
    }

    fn read(&self) -> Result<Picture, DeviceError> {
        self.read()
    }
}

/// The body met by a ray for each pixel. Of what it is given it reads the camera alone.
struct ByRays {
    targets: terrafill_gpu::RenderTargets,
    rays: RayCast,
}

impl Drawing for ByRays {
    fn upload(&mut self, view: SurfaceView<'_>) -> Result<(), DeviceError> {
        self.rays.prepare(&self.targets, view.body, view.camera);
        Ok(())
    }

    fn draw(&mut self) -> Result<Option<f64>, DeviceError> {
        self.rays.draw(&self.targets)
    }

    fn read(&self) -> Result<Picture, DeviceError> {
        self.targets.read()
    }
}

pub(crate) type Opened = Result<Box<dyn Drawing>, DeviceError>;

/// An interface and how targets are made on it.
#[derive(Clone, Copy)]
pub(crate) struct Interface {
    pub(crate) api: Api,
    pub(crate) open: fn(&Devices, ImageSize) -> Opened,
}

pub(crate) const WGPU: Interface = Interface {
    api: terrafill_gpu::API,
    open: |devices, size| {
        let gpu = terrafill_gpu::shared_gpu(devices)?;
        Ok(Box::new(terrafill_gpu::RenderTargets::new(&gpu, size)?))
    },
};

pub(crate) const VULKAN: Interface = Interface {
    api: terrafill_vulkan::API,
    open: |devices, size| {
        let gpu = terrafill_vulkan::shared_gpu(devices)?;
        Ok(Box::new(terrafill_vulkan::RenderTargets::new(&gpu, size)?))
    },
};

pub(crate) const RAYS: Interface = Interface {
    api: terrafill_gpu::API,
    open: |devices, size| {
        let gpu = terrafill_gpu::shared_gpu(devices)?;
        let targets = terrafill_gpu::RenderTargets::new(&gpu, size)?;
        let rays = RayCast::new(&targets)?;
        Ok(Box::new(ByRays { targets, rays }))
    },
};
