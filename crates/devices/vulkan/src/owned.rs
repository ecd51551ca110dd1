// SPDX-License-Identifier: MIT OR Apache-2.0
//! Handles of a device, destroyed by whoever holds them.

use crate::Gpu;
use crate::failure::failure;
use ash::prelude::VkResult;
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

/// A handle that a device makes and destroys.
pub(crate) trait Handle: Copy + std::fmt::Debug {
    /// # Safety
    /// The handle is the device's or null, and nothing uses it any more.
    unsafe fn destroy(self, device: &ash::Device);
}

macro_rules! handles {
    ($($handle:ident: $destroy:ident),* $(,)?) => {$(
        impl Handle for vk::$handle {
            unsafe fn destroy(self, device: &ash::Device) {
                // SAFETY: the caller's promise.
                unsafe { device.$destroy(self, None) };
            }
        }
    )*};
}

handles! {
    Buffer: destroy_buffer,
    DescriptorPool: destroy_descriptor_pool,
    DescriptorSetLayout: destroy_descriptor_set_layout,
    DeviceMemory: free_memory,
    Framebuffer: destroy_framebuffer,
    Image: destroy_image,
    ImageView: destroy_image_view,
    Pipeline: destroy_pipeline,
    PipelineLayout: destroy_pipeline_layout,
    QueryPool: destroy_query_pool,
    RenderPass: destroy_render_pass,
    Sampler: destroy_sampler,
    ShaderModule: destroy_shader_module,
}

/// A handle of a device, destroyed with this.
#[derive(Debug)]
pub(crate) struct Owned<H: Handle> {
    gpu: Arc<Gpu>,
    pub(crate) raw: H,
}

impl<H: Handle> Owned<H> {
    /// Takes over what was made, or gives the error of making `what`.
    ///
    /// # Safety
    /// `made` is this device's, nobody else destroys it, and what uses it is waited for before this is
    /// dropped.
    pub(crate) unsafe fn new(
        gpu: &Arc<Gpu>,
        what: &str,
        made: VkResult<H>,
    ) -> Result<Self, DeviceError> {
        // SAFETY: the caller's promise.
        unsafe { Self::sized(gpu, what, 0, made) }
    }

    /// As [`Owned::new`], of what needs so many bytes.
    ///
    /// # Safety
    /// As [`Owned::new`].
    pub(crate) unsafe fn sized(
        gpu: &Arc<Gpu>,
        what: &str,
        bytes: u64,
        made: VkResult<H>,
    ) -> Result<Self, DeviceError> {
        Ok(Self {
            raw: made.map_err(|error| failure(error, what, bytes))?,
            gpu: Arc::clone(gpu),
        })
    }

    pub(crate) fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        Arc::ptr_eq(&self.gpu, gpu)
    }
}

impl<H: Handle> Drop for Owned<H> {
    fn drop(&mut self) {
        // SAFETY: of this device, and done with, as its maker promised.
        unsafe { self.raw.destroy(&self.gpu.device) };
    }
}
