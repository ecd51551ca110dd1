// SPDX-License-Identifier: MIT OR Apache-2.0
//! The device and the render targets that all techniques on wgpu share.

use crate::{Gpu, GpuOptions, RenderTargets, SharedTargets};
use std::sync::Arc;
use terrafill_fill::{Api, DeviceError, Devices, Targets};

/// wgpu.
pub const API: Api = Api { name: "wgpu" };

/// The device of a run, opened when it is first asked for.
///
/// # Errors
/// As [`Gpu::open`].
pub fn shared_gpu(devices: &Devices) -> Result<Arc<Gpu>, DeviceError> {
    devices.get(|adapter| {
        Gpu::open(&GpuOptions {
            adapter: adapter.map(str::to_owned),
            loss: devices.loss().clone(),
            ..GpuOptions::default()
        })
    })
}

/// The targets on it, made when they are first asked for.
///
/// # Errors
/// As [`shared_gpu`] and [`RenderTargets::new`].
pub fn shared_targets(targets: &Targets) -> Result<SharedTargets, DeviceError> {
    targets.get(|| RenderTargets::shared(&shared_gpu(targets.devices())?, targets.size()))
}
