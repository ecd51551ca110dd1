// SPDX-License-Identifier: MIT OR Apache-2.0
//! Opening a way on an interface.

use crate::draws::Draws;
use crate::grid::{Grid, GridCamera};
use crate::on_vulkan::OnVulkan;
use crate::on_wgpu::OnWgpu;
use crate::way::{Interface, Submission};
use terrafill_contract::{DeviceError, Devices};
use terrafill_scene::ImageSize;

/// Makes everything that a way needs.
pub(crate) fn open(
    devices: &Devices,
    interface: Interface,
    way: Submission,
    grid: &Grid,
    view: &GridCamera,
    size: ImageSize,
) -> Result<Box<dyn Draws>, DeviceError> {
    Ok(match interface {
        Interface::Wgpu => {
            let gpu = terrafill_gpu::shared_gpu(devices)?;
            Box::new(OnWgpu::new(&gpu, way, grid, view, size)?)
        }
        Interface::Vulkan => {
            let gpu = terrafill_vulkan::shared_gpu(devices)?;
            Box::new(OnVulkan::new(&gpu, way, grid, view, size)?)
        }
    })
}
