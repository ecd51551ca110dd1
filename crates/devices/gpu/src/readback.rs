// SPDX-License-Identifier: MIT OR Apache-2.0
//! Reading textures and buffers back to the CPU.

use crate::Gpu;
use terrafill_contract::DeviceError;

/// Copies one aspect of a texture with `COPY_SRC` usage into tightly packed rows, layer by layer.
///
/// # Errors
/// [`DeviceError::DeviceLost`].
pub fn read_texture(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    aspect: wgpu::TextureAspect,
) -> Result<Vec<u8>, DeviceError> {
    let size = texture.size();
    let texel_bytes = texture.format().block_copy_size(Some(aspect)).unwrap_or(4);
    let row_bytes = size.width * texel_bytes;
    let padded_row_bytes = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("texture read-back"),
        size: u64::from(padded_row_bytes)
            * u64::from(size.height)
            * u64::from(size.depth_or_array_layers),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d::ZERO,
            aspect,
        },
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded_row_bytes),
                rows_per_image: Some(size.height),
            },
        },
        size,
    );
    gpu.queue.submit([encoder.finish()]);
    map_whole(gpu, &buffer, |padded| {
        let rows: Vec<&[u8]> = padded
            .chunks(padded_row_bytes as usize)
            .map(|row| &row[..row_bytes as usize])
            .collect();
        rows.concat()
    })
}

/// Copies a buffer with `COPY_SRC` usage to the CPU.
///
/// # Errors
/// [`DeviceError::DeviceLost`].
pub fn read_buffer(gpu: &Gpu, source: &wgpu::Buffer) -> Result<Vec<u8>, DeviceError> {
    read_buffer_start(gpu, source, source.size())
}

/// Its first `size` bytes.
pub(crate) fn read_buffer_start(
    gpu: &Gpu,
    source: &wgpu::Buffer,
    size: u64,
) -> Result<Vec<u8>, DeviceError> {
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("buffer read-back"),
        size,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(source, 0, &buffer, 0, size);
    gpu.queue.submit([encoder.finish()]);
    map_whole(gpu, &buffer, <[u8]>::to_vec)
}

fn map_whole<T>(
    gpu: &Gpu,
    buffer: &wgpu::Buffer,
    read: impl FnOnce(&[u8]) -> T,
) -> Result<T, DeviceError> {
    let lost = |message: String| DeviceError::DeviceLost(message);
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver lives until it has its answer; if it is gone, nobody waits for one.
        let _ = sender.send(result);
    });
    gpu.wait()?;
    receiver
        .recv()
        .map_err(|error| lost(error.to_string()))?
        .map_err(|error| lost(error.to_string()))?;
    let view = buffer
        .get_mapped_range(..)
        .map_err(|error| lost(error.to_string()))?;
    Ok(read(&view))
}
