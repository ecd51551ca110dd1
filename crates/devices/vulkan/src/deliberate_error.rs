// SPDX-License-Identifier: MIT OR Apache-2.0
//! A mistake made on purpose, to see that the validation layer is there and heard.

use crate::Gpu;
use ash::vk;

/// Creates a buffer of 0 bytes, which the specification forbids
/// (`VUID-VkBufferCreateInfo-size-00912`), and destroys it again.
pub fn make_deliberate_error(gpu: &Gpu) {
    let info = vk::BufferCreateInfo::default()
        .size(0)
        .usage(vk::BufferUsageFlags::TRANSFER_SRC);
    // SAFETY: the device outlives the call; the buffer is never used and destroyed at once. A size
    // of 0 is invalid usage on purpose; drivers return a buffer or an error for it.
    unsafe {
        if let Ok(buffer) = gpu.device.create_buffer(&info, None) {
            gpu.device.destroy_buffer(buffer, None);
        }
    }
}
