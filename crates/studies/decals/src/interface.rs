// SPDX-License-Identifier: MIT OR Apache-2.0
//! Interfaces on which data is opened.

use crate::divided::Divided;
use crate::draws::Draws;
use crate::on_vulkan::OnVulkan;
use crate::on_wgpu::OnWgpu;
use terrafill_contract::{DeviceError, Devices};

terrafill_results::named! {
    /// An interface that draws.
    all pub(crate) enum Interface {
        Wgpu = terrafill_gpu::API.name,
        Vulkan = terrafill_vulkan::API.name,
    }
}

impl Interface {
    pub(crate) fn open(
        self,
        devices: &Devices,
        divided: &Divided,
    ) -> Result<Box<dyn Draws>, DeviceError> {
        Ok(match self {
            Self::Wgpu => Box::new(OnWgpu::new(&terrafill_gpu::shared_gpu(devices)?, divided)?),
            Self::Vulkan => Box::new(OnVulkan::new(
                &terrafill_vulkan::shared_gpu(devices)?,
                divided,
            )?),
        })
    }
}
