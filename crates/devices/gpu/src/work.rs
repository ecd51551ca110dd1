// SPDX-License-Identifier: MIT OR Apache-2.0
//! Buffers, pipelines and writes that are counted.
//!
//! Everything that a fill or the surface needs is made through [`Gpu`], which counts; what only
//! measuring needs, such as queries and read-back, is made on the device itself and not counted.

use crate::Gpu;
use terrafill_fill::WorkDone;

impl Gpu {
    /// What was made and written so far.
    #[must_use]
    pub fn work_done(&self) -> WorkDone {
        self.work.done()
    }

    /// Makes a buffer.
    #[must_use]
    pub fn create_buffer(&self, descriptor: &wgpu::BufferDescriptor<'_>) -> wgpu::Buffer {
        self.work.count_buffer();
        self.device.create_buffer(descriptor)
    }

    /// Writes into a buffer.
    pub fn write_buffer(&self, buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]) {
        self.work.count_upload(bytes.len() as u64);
        self.queue.write_buffer(buffer, offset, bytes);
    }

    /// Makes a render pipeline.
    #[must_use]
    pub fn create_render_pipeline(
        &self,
        descriptor: &wgpu::RenderPipelineDescriptor<'_>,
    ) -> wgpu::RenderPipeline {
        self.work.count_pipeline();
        self.device.create_render_pipeline(descriptor)
    }

    /// Makes a compute pipeline.
    #[must_use]
    pub fn create_compute_pipeline(
        &self,
        descriptor: &wgpu::ComputePipelineDescriptor<'_>,
    ) -> wgpu::ComputePipeline {
        self.work.count_pipeline();
        self.device.create_compute_pipeline(descriptor)
    }
}
