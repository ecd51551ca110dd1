// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a device was asked to make and to take: buffers, pipelines, writes of the CPU.
//!
//! A frame in a steady state asks for none of these. Everything that a fill or the surface needs is
//! made through [`Gpu`], which counts; what only measuring needs, such as queries and read-back, is
//! made on the device itself and not counted.

use crate::Gpu;
use std::ops::{Add, Sub};
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts since a device was opened, or over a span.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WorkDone {
    /// Buffers made.
    pub buffer_creations: u64,
    /// Pipelines made.
    pub pipeline_creations: u64,
    /// Writes of the CPU into buffers.
    pub uploads: u64,
    /// Bytes written by them.
    pub upload_bytes: u64,
}

impl Sub for WorkDone {
    type Output = Self;

    fn sub(self, earlier: Self) -> Self {
        Self {
            buffer_creations: self.buffer_creations - earlier.buffer_creations,
            pipeline_creations: self.pipeline_creations - earlier.pipeline_creations,
            uploads: self.uploads - earlier.uploads,
            upload_bytes: self.upload_bytes - earlier.upload_bytes,
        }
    }
}

impl Add for WorkDone {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            buffer_creations: self.buffer_creations + other.buffer_creations,
            pipeline_creations: self.pipeline_creations + other.pipeline_creations,
            uploads: self.uploads + other.uploads,
            upload_bytes: self.upload_bytes + other.upload_bytes,
        }
    }
}

/// The counters behind [`WorkDone`].
#[derive(Debug, Default)]
pub(crate) struct WorkCounters {
    buffer_creations: AtomicU64,
    pipeline_creations: AtomicU64,
    uploads: AtomicU64,
    upload_bytes: AtomicU64,
}

fn add(counter: &AtomicU64, count: u64) {
    counter.fetch_add(count, Ordering::Relaxed);
}

impl Gpu {
    /// What was made and written so far.
    #[must_use]
    pub fn work_done(&self) -> WorkDone {
        let read = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        WorkDone {
            buffer_creations: read(&self.work.buffer_creations),
            pipeline_creations: read(&self.work.pipeline_creations),
            uploads: read(&self.work.uploads),
            upload_bytes: read(&self.work.upload_bytes),
        }
    }

    /// Makes a buffer.
    #[must_use]
    pub fn create_buffer(&self, descriptor: &wgpu::BufferDescriptor<'_>) -> wgpu::Buffer {
        add(&self.work.buffer_creations, 1);
        self.device.create_buffer(descriptor)
    }

    /// Counts bytes that a buffer got while it was mapped at its creation.
    pub(crate) fn count_upload(&self, bytes: u64) {
        if bytes > 0 {
            add(&self.work.uploads, 1);
            add(&self.work.upload_bytes, bytes);
        }
    }

    /// Writes into a buffer.
    pub fn write_buffer(&self, buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]) {
        self.count_upload(bytes.len() as u64);
        self.queue.write_buffer(buffer, offset, bytes);
    }

    /// Makes a render pipeline.
    #[must_use]
    pub fn create_render_pipeline(
        &self,
        descriptor: &wgpu::RenderPipelineDescriptor<'_>,
    ) -> wgpu::RenderPipeline {
        add(&self.work.pipeline_creations, 1);
        self.device.create_render_pipeline(descriptor)
    }

    /// Makes a compute pipeline.
    #[must_use]
    pub fn create_compute_pipeline(
        &self,
        descriptor: &wgpu::ComputePipelineDescriptor<'_>,
    ) -> wgpu::ComputePipeline {
        add(&self.work.pipeline_creations, 1);
        self.device.create_compute_pipeline(descriptor)
    }
}
