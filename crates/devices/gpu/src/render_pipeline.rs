// SPDX-License-Identifier: MIT OR Apache-2.0
//! What pipelines have in common, so that each says only what is its own.

use crate::attachments::DEPTH_STENCIL_FORMAT;

/// Triangles of numbered vertices by `vertex_main` and `fragment_main` of one shader, without depth.
#[must_use]
pub fn described<'a>(
    label: &'a str,
    layout: &'a wgpu::PipelineLayout,
    module: &'a wgpu::ShaderModule,
    targets: &'a [Option<wgpu::ColorTargetState>],
) -> wgpu::RenderPipelineDescriptor<'a> {
    wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("vertex_main"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("fragment_main"),
            compilation_options: Default::default(),
            targets,
        }),
        multiview_mask: None,
        cache: None,
    }
}

/// Depth written where it is nearer: reversed, so greater.
pub(crate) fn nearest() -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        depth_write_enabled: Some(true),
        ..tested(wgpu::CompareFunction::Greater, Default::default())
    }
}

/// A buffer of vertices without gaps in them or between them.
#[must_use]
pub fn vertex_layout(attributes: &[wgpu::VertexAttribute]) -> Option<wgpu::VertexBufferLayout<'_>> {
    Some(wgpu::VertexBufferLayout {
        array_stride: attributes.iter().map(|one| one.format.size()).sum(),
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes,
    })
}

/// Depth tested and left as it is.
#[must_use]
pub fn tested(
    compare: wgpu::CompareFunction,
    stencil: wgpu::StencilState,
) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH_STENCIL_FORMAT,
        depth_write_enabled: Some(false),
        depth_compare: Some(compare),
        stencil,
        bias: Default::default(),
    }
}
