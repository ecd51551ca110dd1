// SPDX-License-Identifier: MIT OR Apache-2.0
//! Queries and where their results are copied to. Made on the device itself and not counted as a fill's: only
//! measuring needs them.

use crate::Gpu;
use crate::readback::read_buffer_start;
use std::ops::Range;
use terrafill_contract::DeviceError;

#[derive(Debug)]
pub(crate) struct Queries {
    pub(crate) set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// Of a result.
    bytes: u64,
}

impl Queries {
    /// - `words`: 64-bit numbers of a result
    pub(crate) fn new(gpu: &Gpu, label: &str, ty: wgpu::QueryType, count: u32, words: u64) -> Self {
        let bytes = 8 * words;
        Self {
            set: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some(label),
                ty,
                count,
            }),
            resolved: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: u64::from(count) * bytes,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            bytes,
        }
    }

    /// Results of these, which have all been written.
    pub(crate) fn read(&self, gpu: &Gpu, range: Range<u32>) -> Result<Vec<u64>, DeviceError> {
        let bytes = u64::from(range.end - range.start) * self.bytes;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.resolve_query_set(&self.set, range, &self.resolved, 0);
        gpu.queue.submit([encoder.finish()]);
        let bytes = read_buffer_start(gpu, &self.resolved, bytes)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }
}
