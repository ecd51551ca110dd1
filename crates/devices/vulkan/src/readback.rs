// SPDX-License-Identifier: MIT OR Apache-2.0
//! Reading images back to the CPU, rows tightly packed, layer by layer.

use crate::image::Image;
use crate::memory::barrier;
use crate::{Buffer, Gpu};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

/// One aspect of an image, in the layout in which passes leave it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Readable<'a> {
    pub(crate) image: &'a Image,
    pub(crate) aspect: vk::ImageAspectFlags,
    pub(crate) texel_bytes: u64,
    pub(crate) layout: vk::ImageLayout,
}

/// The bytes of each image, by one submission.
///
/// # Safety
/// The images are the device's, in the layouts said, into which they are put back, and can be copied from.
pub(crate) unsafe fn read_images<const N: usize>(
    gpu: &Arc<Gpu>,
    images: [Readable<'_>; N],
) -> Result<[Vec<u8>; N], DeviceError> {
    let mut copies = Vec::with_capacity(N);
    for of in images {
        let size = of.image.bytes(of.texel_bytes);
        copies.push((of, Buffer::for_reading(gpu, "read-back", size)?));
    }
    // SAFETY: images and buffers live until the submission is done; the rest is the caller's promise.
    unsafe {
        gpu.submit(|device, commands| {
            for (of, buffer) in &copies {
                copy_out(device, commands, of, buffer);
            }
            let_host_read(device, commands);
        })?;
    }
    let mut read = [const { Vec::new() }; N];
    for (bytes, (_, buffer)) in read.iter_mut().zip(&copies) {
        *bytes = buffer.read()?;
    }
    Ok(read)
}

/// Copies one aspect of an image, and puts its layout back.
///
/// # Safety
/// Image and buffer live until the submission is done, the image is in its layout, and the buffer is large
/// enough.
unsafe fn copy_out(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    of: &Readable<'_>,
    buffer: &Buffer,
) {
    let Readable { image, layout, .. } = *of;
    let region = vk::BufferImageCopy::default()
        .image_subresource(
            vk::ImageSubresourceLayers::default()
                .aspect_mask(of.aspect)
                .layer_count(image.kind.layers()),
        )
        .image_extent(image.kind.extent.into());
    let source = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
    // SAFETY: the caller's promise.
    unsafe {
        image.change_layout(device, commands, layout, source);
        device.cmd_copy_image_to_buffer(commands, image.raw, source, buffer.raw, &[region]);
        image.change_layout(device, commands, source, layout);
    }
}

/// # Safety
/// Recording is under way, outside of a pass.
pub(crate) unsafe fn let_host_read(device: &ash::Device, commands: vk::CommandBuffer) {
    let copies = (
        vk::PipelineStageFlags::TRANSFER,
        vk::AccessFlags::TRANSFER_WRITE,
    );
    let host = (vk::PipelineStageFlags::HOST, vk::AccessFlags::HOST_READ);
    // SAFETY: the caller's promise.
    unsafe { barrier(device, commands, copies, host) };
}
