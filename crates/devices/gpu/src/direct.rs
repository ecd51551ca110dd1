// SPDX-License-Identifier: MIT OR Apache-2.0
//! A pipeline of the caller's own that draws over cleared targets: nearest depth wins, both faces kept.

use crate::attachments::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, attached};
use crate::{Gpu, RenderTargets, TimedPass};
use terrafill_contract::{DeviceError, SKY};

/// Shaders of a pipeline, and how its vertices come.
#[derive(Debug, Clone, Copy)]
pub struct DirectPipeline<'a> {
    /// WGSL, relative to `shaders/`; its fragments are `fragment_main`.
    pub path: &'a str,
    /// Of the vertices.
    pub entry_point: &'a str,
    /// How vertices become primitives.
    pub topology: wgpu::PrimitiveTopology,
    /// Of the one attribute, where vertices have one.
    pub format: Option<wgpu::VertexFormat>,
    /// Of group 0.
    pub layout: &'a wgpu::BindGroupLayout,
}

impl Gpu {
    /// Makes a pipeline that draws into [`RenderTargets`].
    ///
    /// # Errors
    /// [`DeviceError::Shader`].
    pub fn direct_pipeline(
        &self,
        direct: &DirectPipeline<'_>,
    ) -> Result<wgpu::RenderPipeline, DeviceError> {
        let label = Some(direct.path);
        let module = self.shader(direct.path)?;
        let layout = self.pipeline_layout(direct.path, &[Some(direct.layout)]);
        let attributes = direct.format.map(|format| {
            [wgpu::VertexAttribute {
                format,
                offset: 0,
                shader_location: 0,
            }]
        });
        let buffers: Vec<_> = attributes
            .iter()
            .map(|attributes| {
                Some(wgpu::VertexBufferLayout {
                    array_stride: attributes[0].format.size(),
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes,
                })
            })
            .collect();
        Ok(
            self.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label,
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(direct.entry_point),
                    compilation_options: Default::default(),
                    buffers: &buffers,
                },
                primitive: wgpu::PrimitiveState {
                    topology: direct.topology,
                    ..Default::default()
                },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH_STENCIL_FORMAT,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(wgpu::CompareFunction::Greater),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("fragment_main"),
                    compilation_options: Default::default(),
                    targets: &[Some(COLOUR_FORMAT.into())],
                }),
                multiview_mask: None,
                cache: None,
            }),
        )
    }
}

/// Commands of a frame. Where the device keeps time, that of the frame begins before the first of them.
#[derive(Debug)]
pub struct DirectFrame {
    /// To record the frame's copies and dispatches, and its pass.
    pub encoder: wgpu::CommandEncoder,
}

impl RenderTargets {
    /// Begins a frame whose last commands are those of [`Self::cleared_pass`].
    #[must_use]
    pub fn direct_frame(&self) -> DirectFrame {
        let mut encoder = self
            .gpu()
            .device
            .create_command_encoder(&Default::default());
        if let Some(timer) = self.timer() {
            timer.begin(&mut encoder, TimedPass::Surface);
        }
        DirectFrame { encoder }
    }

    /// A pass over cleared targets, which ends the frame's time.
    pub fn cleared_pass<'a>(&self, frame: &'a mut DirectFrame) -> wgpu::RenderPass<'a> {
        let (colour, depth_stencil) = (self.colour_view(), self.depth_stencil_view());
        let [r, g, b, a] = SKY.map(f64::from);
        let sky = wgpu::Color { r, g, b, a };
        let store = wgpu::StoreOp::Store;
        frame
            .encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("direct"),
                color_attachments: &[Some(attached(&colour, wgpu::LoadOp::Clear(sky)))],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth_stencil,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(0.0),
                        store,
                    }),
                    stencil_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(0),
                        store,
                    }),
                }),
                timestamp_writes: self
                    .timer()
                    .map(|timer| timer.writes(None, Some(TimedPass::Surface))),
                ..Default::default()
            })
    }

    /// GPU time of the last such frame that was waited for, milliseconds, where the device keeps time: its copies,
    /// dispatches and pass. What a queue writes before them is outside of it.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn direct_ms(&self) -> Result<Option<f64>, DeviceError> {
        match self.timer() {
            Some(timer) => {
                let stamps = timer.read(self.gpu(), TimedPass::Surface, TimedPass::Surface)?;
                Ok(stamps.pass_ms(TimedPass::Surface))
            }
            None => Ok(None),
        }
    }
}
