// SPDX-License-Identifier: MIT OR Apache-2.0
//! How each kind of handle is destroyed.

use ash::vk;

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
