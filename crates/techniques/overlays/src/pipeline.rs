// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipelines that draw over the surface: depth is tested and never written.

use terrafill_gpu::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, Gpu};

/// What differs between them.
pub(crate) struct OverlayPipeline<'a> {
    pub(crate) label: &'a str,
    pub(crate) shader: &'a wgpu::ShaderModule,
    pub(crate) layout: &'a wgpu::PipelineLayout,
    pub(crate) entries: [&'a str; 2],
    pub(crate) buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    pub(crate) format: wgpu::TextureFormat,
    /// Reversed depth: what is nearer is greater. `None` for passes without depth.
    pub(crate) depth: Option<wgpu::CompareFunction>,
    pub(crate) cull_mode: Option<wgpu::Face>,
}

impl<'a> OverlayPipeline<'a> {
    /// Writes colours where the depth test lets it.
    pub(crate) fn coloured(
        label: &'a str,
        shader: &'a wgpu::ShaderModule,
        layout: &'a wgpu::PipelineLayout,
        entries: [&'a str; 2],
    ) -> Self {
        Self {
            label,
            shader,
            layout,
            entries,
            buffers: &[],
            format: COLOUR_FORMAT,
            depth: None,
            cull_mode: None,
        }
    }

    pub(crate) fn make(&self, gpu: &Gpu) -> wgpu::RenderPipeline {
        let depth_stencil = self.depth.map(|compare| wgpu::DepthStencilState {
            format: DEPTH_STENCIL_FORMAT,
            depth_write_enabled: Some(false),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        });
        gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.label),
            layout: Some(self.layout),
            vertex: wgpu::VertexState {
                module: self.shader,
                entry_point: Some(self.entries[0]),
                compilation_options: Default::default(),
                buffers: self.buffers,
            },
            primitive: wgpu::PrimitiveState {
                cull_mode: self.cull_mode,
                ..Default::default()
            },
            depth_stencil,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: self.shader,
                entry_point: Some(self.entries[1]),
                compilation_options: Default::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format: self.format,
                    blend: None,
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
