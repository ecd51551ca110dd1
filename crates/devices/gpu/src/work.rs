// SPDX-License-Identifier: MIT OR Apache-2.0
//! Buffers, pipelines and writes that are counted.
//!
//! Everything that a fill or the surface needs is made through [`Gpu`], which counts; what only
//! measuring needs, such as queries and read-back, is made on the device itself and not counted.

use crate::Gpu;
use terrafill_contract::{DeviceError, WorkDone};
use terrafill_stencil::changed_words;

impl Gpu {
    /// What was made and written so far.
    #[must_use]
    pub fn work_done(&self) -> WorkDone {
        self.work.done()
    }

    /// Makes a buffer.
    #[must_use]
    pub fn create_buffer(&self, descriptor: &wgpu::BufferDescriptor<'_>) -> wgpu::Buffer {
        self.work.count_buffer(descriptor.size);
        self.device.create_buffer(descriptor)
    }

    /// Makes a buffer that nothing is written into yet.
    #[must_use]
    pub fn unwritten(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    /// Makes a flat texture of so many layers and levels. Whoever makes it counts what a fill needs of it.
    #[must_use]
    pub fn texture(
        &self,
        label: &str,
        [width, height, depth_or_array_layers]: [u32; 3],
        mip_level_count: u32,
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers,
            },
            mip_level_count,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    }

    /// A new buffer with these bytes, padded with zeros to a multiple of 4.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when the device has no buffers that large.
    pub fn upload(
        &self,
        label: &str,
        bytes: &[u8],
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, DeviceError> {
        let size = (bytes.len() as u64).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
        let limits = self.device.limits();
        let allowed = if usage.contains(wgpu::BufferUsages::STORAGE) {
            limits
                .max_buffer_size
                .min(limits.max_storage_buffer_binding_size)
        } else {
            limits.max_buffer_size
        };
        DeviceError::check_capacity(&format!("bytes of {label}"), size, allowed)?;
        let buffer = self.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            // A buffer of 0 bytes is not allowed; an empty scene still draws its surface.
            size: size.max(wgpu::COPY_BUFFER_ALIGNMENT),
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: true,
        });
        buffer
            .get_mapped_range_mut(..)
            .map_err(|error| DeviceError::DeviceLost(error.to_string()))?
            .slice(..bytes.len())
            .copy_from_slice(bytes);
        buffer.unmap();
        self.work.count_upload(bytes.len() as u64);
        Ok(buffer)
    }

    /// Writes into a buffer.
    pub fn write_buffer(&self, buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]) {
        self.work.count_upload(bytes.len() as u64);
        self.queue.write_buffer(buffer, offset, bytes);
    }

    /// Writes into a texture.
    pub fn write_texture(
        &self,
        texture: wgpu::TexelCopyTextureInfo<'_>,
        bytes: &[u8],
        layout: wgpu::TexelCopyBufferLayout,
        size: wgpu::Extent3d,
    ) {
        self.work.count_upload(bytes.len() as u64);
        self.queue.write_texture(texture, bytes, layout, size);
    }

    /// Writes what a buffer has to hold over what it holds from its first byte on, where that differs.
    pub fn write_changed(&self, buffer: &wgpu::Buffer, before: &[u8], after: &[u8]) {
        if let Some(changed) = changed_words(before, after) {
            self.write_buffer(buffer, changed.start as u64, &after[changed]);
        }
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

    /// Makes a pipeline of mesh shaders.
    pub(crate) fn create_mesh_pipeline(
        &self,
        descriptor: &wgpu::MeshPipelineDescriptor<'_>,
    ) -> wgpu::RenderPipeline {
        self.work.count_pipeline();
        self.device.create_mesh_pipeline(descriptor)
    }

    /// Makes a compute pipeline and its layout.
    ///
    /// - `constants`: of the shader's overrides
    #[must_use]
    pub fn compute_pipeline(
        &self,
        label: &str,
        module: &wgpu::ShaderModule,
        entry_point: &str,
        groups: &[Option<&wgpu::BindGroupLayout>],
        constants: &[(&str, f64)],
    ) -> wgpu::ComputePipeline {
        self.work.count_pipeline();
        let descriptor = wgpu::ComputePipelineDescriptor {
            label: Some(label),
            layout: Some(&self.pipeline_layout(label, groups)),
            module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants,
                ..Default::default()
            },
            cache: None,
        };
        self.device.create_compute_pipeline(&descriptor)
    }
}
