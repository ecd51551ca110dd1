// SPDX-License-Identifier: MIT OR Apache-2.0
//! Reading the targets back to the CPU, rows tightly packed.

use crate::fixtures::DEPTH_READ_ONLY;
use crate::memory::Image;
use crate::targets::Targets;
use crate::{Buffer, Gpu};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

pub(crate) const DEPTH_AND_STENCIL: vk::ImageAspectFlags = vk::ImageAspectFlags::from_raw(
    vk::ImageAspectFlags::DEPTH.as_raw() | vk::ImageAspectFlags::STENCIL.as_raw(),
);

/// Colour and depth of targets that a pass has left in their layouts, four bytes a pixel each.
pub(crate) fn read_targets(
    gpu: &Arc<Gpu>,
    targets: &Targets,
) -> Result<(Vec<u8>, Vec<u8>), DeviceError> {
    let extent = targets.area().extent;
    let size = u64::from(extent.width) * u64::from(extent.height) * 4;
    let colour = Buffer::for_reading(gpu, "colour read-back", size)?;
    let depth = Buffer::for_reading(gpu, "depth read-back", size)?;
    let images = [
        (
            targets.colour(),
            vk::ImageAspectFlags::COLOR,
            vk::ImageAspectFlags::COLOR,
            vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
            &colour,
        ),
        (
            targets.depth_stencil().raw,
            DEPTH_AND_STENCIL,
            vk::ImageAspectFlags::DEPTH,
            DEPTH_READ_ONLY,
            &depth,
        ),
    ];
    // SAFETY: images and buffers live until the submission is done; the layouts are those that
    // passes leave, and are put back.
    unsafe {
        gpu.submit(|device, commands| {
            for (image, aspects, copied, layout, buffer) in images {
                copy_out(
                    device,
                    commands,
                    extent,
                    image,
                    (aspects, copied),
                    layout,
                    buffer,
                );
            }
            let_host_read(device, commands);
        })?;
    }
    Ok((colour.read()?, depth.read()?))
}

/// What the covers' probe wrote into one of its targets, row 0 at the top.
pub(crate) fn read_probed(
    gpu: &Arc<Gpu>,
    extent: vk::Extent2D,
    image: &Image,
) -> Result<Vec<[f32; 4]>, DeviceError> {
    let size = u64::from(extent.width) * u64::from(extent.height) * 16;
    let buffer = Buffer::for_reading(gpu, "probe read-back", size)?;
    let layout = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
    let aspects = vk::ImageAspectFlags::COLOR;
    // SAFETY: image and buffer live until the submission is done; the layout is the one that the
    // probe's passes leave.
    unsafe {
        gpu.submit(|device, commands| {
            copy_out(
                device,
                commands,
                extent,
                image.raw,
                (aspects, aspects),
                layout,
                &buffer,
            );
            let_host_read(device, commands);
        })?;
    }
    Ok(bytemuck::pod_collect_to_vec(&buffer.read()?))
}

/// Copies one aspect of an image that has these, and puts its layout back.
///
/// # Safety
/// Image and buffer live until the submission is done, the image is in `layout`, and the buffer is
/// large enough.
unsafe fn copy_out(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    extent: vk::Extent2D,
    image: vk::Image,
    (aspects, copied): (vk::ImageAspectFlags, vk::ImageAspectFlags),
    layout: vk::ImageLayout,
    buffer: &Buffer,
) {
    let region = vk::BufferImageCopy::default()
        .image_subresource(
            vk::ImageSubresourceLayers::default()
                .aspect_mask(copied)
                .layer_count(1),
        )
        .image_extent(extent.into());
    let source = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
    // SAFETY: the caller's promise.
    unsafe {
        change_layout(device, commands, image, aspects, layout, source);
        device.cmd_copy_image_to_buffer(commands, image, source, buffer.raw, &[region]);
        change_layout(device, commands, image, aspects, source, layout);
    }
}

/// # Safety
/// Recording is under way, outside of a pass.
pub(crate) unsafe fn let_host_read(device: &ash::Device, commands: vk::CommandBuffer) {
    let for_host = [vk::MemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
        .dst_access_mask(vk::AccessFlags::HOST_READ)];
    // SAFETY: the caller's promise.
    unsafe {
        device.cmd_pipeline_barrier(
            commands,
            vk::PipelineStageFlags::TRANSFER,
            vk::PipelineStageFlags::HOST,
            vk::DependencyFlags::empty(),
            &for_host,
            &[],
            &[],
        );
    }
}

/// # Safety
/// The image lives until the submission is done and is in layout `from`.
pub(crate) unsafe fn change_layout(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    image: vk::Image,
    aspects: vk::ImageAspectFlags,
    from: vk::ImageLayout,
    to: vk::ImageLayout,
) {
    let barrier = vk::ImageMemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
        .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)
        .old_layout(from)
        .new_layout(to)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image)
        .subresource_range(
            vk::ImageSubresourceRange::default()
                .aspect_mask(aspects)
                .level_count(1)
                .layer_count(1),
        );
    // SAFETY: the caller's promise. Everything waits for everything: fills are over by then, and the
    // copy itself, which the study `readback` times, has nothing to run beside.
    unsafe {
        device.cmd_pipeline_barrier(
            commands,
            vk::PipelineStageFlags::ALL_COMMANDS,
            vk::PipelineStageFlags::ALL_COMMANDS,
            vk::DependencyFlags::empty(),
            &[],
            &[],
            &[barrier],
        );
    }
}
