// SPDX-License-Identifier: MIT OR Apache-2.0
//! A mistake made on purpose, to see that the validation layer is there and heard.

use crate::Gpu;

/// Creates a Vulkan buffer of 0 bytes, which the specification forbids
/// (`VUID-VkBufferCreateInfo-size-00912`), behind wgpu's back and destroys it again.
///
/// Returns false when the device is not a Vulkan one.
#[must_use]
pub fn make_deliberate_error(gpu: &Gpu) -> bool {
    #[allow(
        unsafe_code,
        reason = "wgpu refuses the error itself, so it must be made below wgpu"
    )]
    // SAFETY: the device outlives the call; the buffer is never used and destroyed at once. A
    // size of 0 is invalid usage on purpose; drivers return a buffer or an error for it.
    unsafe {
        let Some(device) = gpu.device.as_hal::<wgpu::hal::api::Vulkan>() else {
            return false;
        };
        let raw = device.raw_device();
        let info = ash::vk::BufferCreateInfo::default()
            .size(0)
            .usage(ash::vk::BufferUsageFlags::TRANSFER_SRC);
        if let Ok(buffer) = raw.create_buffer(&info, None) {
            raw.destroy_buffer(buffer, None);
        }
    }
    true
}
