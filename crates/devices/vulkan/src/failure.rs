// SPDX-License-Identifier: MIT OR Apache-2.0
//! From Vulkan's result codes to typed errors.

use ash::vk;
use terrafill_contract::DeviceError;

/// The error of a call that was made for `what` and might have needed `bytes`.
pub(crate) fn failure(result: vk::Result, what: &str, bytes: u64) -> DeviceError {
    match result {
        vk::Result::ERROR_OUT_OF_HOST_MEMORY
        | vk::Result::ERROR_OUT_OF_DEVICE_MEMORY
        | vk::Result::ERROR_OUT_OF_POOL_MEMORY
        | vk::Result::ERROR_TOO_MANY_OBJECTS => DeviceError::OutOfMemory {
            what: what.to_owned(),
            bytes,
        },
        other => DeviceError::DeviceLost(format!("{what}: {other}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_and_everything_else_are_told_apart() {
        let memory = failure(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY, "vertices", 12);
        assert_eq!(memory.to_string(), "out of memory: vertices needs 12 bytes");
        let lost = failure(vk::Result::ERROR_DEVICE_LOST, "waiting", 0);
        assert!(matches!(&lost, DeviceError::DeviceLost(words) if words.contains("waiting")));
    }
}
