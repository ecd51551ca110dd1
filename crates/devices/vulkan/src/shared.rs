// SPDX-License-Identifier: MIT OR Apache-2.0
//! The device and the render targets that all techniques on Vulkan itself share.

use crate::{Gpu, RenderTargets, SharedTargets};
use std::sync::Arc;
use terrafill_contract::{
    Api, DeviceError, Devices, Picture, SurfaceInterface, SurfaceTargets, SurfaceView, Targets,
};

/// Vulkan itself.
pub const API: Api = Api { name: "vulkan" };

/// Surfaces alone, on the device of a run.
pub const SURFACES: SurfaceInterface = SurfaceInterface {
    api: API,
    open: |devices, size| Ok(Box::new(RenderTargets::new(&shared_gpu(devices)?, size)?)),
};

impl SurfaceTargets for RenderTargets {
    fn prepare(&mut self, view: SurfaceView<'_>) -> Result<(), DeviceError> {
        self.prepare(view)
    }

    fn draw_surface(&mut self) -> Result<Option<f64>, DeviceError> {
        self.draw_surface()
    }

    fn read(&self) -> Result<Picture, DeviceError> {
        self.read()
    }
}

/// The device of a run, opened when it is first asked for.
///
/// # Errors
/// As [`Gpu::open`].
pub fn shared_gpu(devices: &Devices) -> Result<Arc<Gpu>, DeviceError> {
    devices.open(Gpu::open)
}

/// The targets on it, made when they are first asked for.
///
/// # Errors
/// As [`shared_gpu`] and [`RenderTargets::new`].
pub fn shared_targets(targets: &Targets) -> Result<SharedTargets, DeviceError> {
    targets.get(|| RenderTargets::shared(&shared_gpu(targets.devices())?, targets.size()))
}
