// SPDX-License-Identifier: MIT OR Apache-2.0
//! Textures that passes draw into, their formats, and how passes attach them.

use crate::Gpu;
use terrafill_scene::ImageSize;

/// Colour target: ids and colours are exact in it.
pub const COLOUR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Reversed depth needs float: on a 24-bit depth buffer it gains nothing.
pub const DEPTH_STENCIL_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32FloatStencil8;

/// A texture of one level that is drawn into, and whatever `usage` says beside.
pub(crate) fn target(
    gpu: &Gpu,
    size: ImageSize,
    label: &str,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | usage;
    gpu.texture(label, [size.width, size.height, 1], 1, format, usage)
}

/// Depth as it is, and the stencil to be written, or, without a way to load it, to be left as it is too.
#[must_use]
pub fn read_only_depth(
    view: &wgpu::TextureView,
    stencil: Option<wgpu::LoadOp<u32>>,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: None,
        stencil_ops: stencil.map(|load| wgpu::Operations {
            load,
            store: wgpu::StoreOp::Store,
        }),
    }
}

/// A colour target, written.
#[must_use]
pub fn attached(
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load,
            store: wgpu::StoreOp::Store,
        },
    }
}
