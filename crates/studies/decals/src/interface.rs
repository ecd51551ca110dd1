// SPDX-License-Identifier: MIT OR Apache-2.0
//! Interfaces on which data is opened.

use crate::divided::Divided;
use crate::draws::Draws;
use crate::on_vulkan::{self, OnVulkan};
use crate::on_wgpu::{self, OnWgpu};
use std::sync::Arc;
use terrafill_contract::{DeviceError, Devices};
use terrafill_vulkan::SampledImage;

terrafill_results::named! {
    /// An interface that draws.
    all pub(crate) enum Interface {
        Wgpu = terrafill_gpu::API.name,
        Vulkan = terrafill_vulkan::API.name,
    }
}

/// Textures of addresses on each interface, made when data is first opened there.
#[derive(Default)]
pub(crate) struct Addressed {
    wgpu: Option<wgpu::Texture>,
    vulkan: Option<Arc<SampledImage>>,
}

impl Interface {
    pub(crate) fn open(
        self,
        devices: &Devices,
        divided: &Divided,
        addressed: &mut Addressed,
    ) -> Result<Box<dyn Draws>, DeviceError> {
        Ok(match self {
            Self::Wgpu => {
                let gpu = terrafill_gpu::shared_gpu(devices)?;
                let made = &mut addressed.wgpu;
                let texture = made.get_or_insert_with(|| on_wgpu::addressed(&gpu));
                Box::new(OnWgpu::new(&gpu, divided, texture)?)
            }
            Self::Vulkan => {
                let gpu = terrafill_vulkan::shared_gpu(devices)?;
                let texture = match &addressed.vulkan {
                    Some(made) => Arc::clone(made),
                    None => on_vulkan::addressed(&gpu)?,
                };
                addressed.vulkan = Some(Arc::clone(&texture));
                Box::new(OnVulkan::new(&gpu, divided, texture)?)
            }
        })
    }
}
