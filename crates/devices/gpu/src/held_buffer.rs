// SPDX-License-Identifier: MIT OR Apache-2.0
//! A buffer that is written only where its bytes change.

use crate::Gpu;
use terrafill_contract::DeviceError;

/// A buffer and what it holds.
#[derive(Debug, Default)]
pub struct HeldBuffer {
    bytes: Vec<u8>,
    buffer: Option<wgpu::Buffer>,
}

impl HeldBuffer {
    /// Makes the buffer hold `bytes`. True where it is a new one, which has to be bound again.
    ///
    /// # Errors
    /// As [`Gpu::upload`].
    pub fn hold(
        &mut self,
        gpu: &Gpu,
        label: &str,
        bytes: Vec<u8>,
        usage: wgpu::BufferUsages,
    ) -> Result<bool, DeviceError> {
        match &self.buffer {
            Some(_) if self.bytes == bytes => return Ok(false),
            Some(buffer) if self.bytes.len() == bytes.len() => {
                gpu.write_buffer(buffer, 0, &bytes);
                self.bytes = bytes;
                return Ok(false);
            }
            _ => {}
        }
        self.buffer = Some(gpu.upload(label, &bytes, usage)?);
        self.bytes = bytes;
        Ok(true)
    }

    /// `None` before anything is held.
    #[must_use]
    pub fn buffer(&self) -> Option<&wgpu::Buffer> {
        self.buffer.as_ref()
    }

    /// Bytes held.
    #[must_use]
    pub fn size(&self) -> u64 {
        self.bytes.len() as u64
    }
}
