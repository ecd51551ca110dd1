// SPDX-License-Identifier: MIT OR Apache-2.0
//! A pipeline of the caller's own that draws over cleared targets: nearest depth wins, both faces kept.

use crate::attachments::{COLOUR_FORMAT, attached};
use crate::render_pipeline::{described, nearest, vertex_layout};
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
            .map(|attributes| vertex_layout(attributes))
            .collect();
        let targets = [Some(COLOUR_FORMAT.into())];
        let mut described = described(direct.path, &layout, &module, &targets);
        described.vertex.entry_point = Some(direct.entry_point);
        described.vertex.buffers = &buffers;
        described.primitive.topology = direct.topology;
        described.depth_stencil = Some(nearest());
        Ok(self.create_render_pipeline(&described))
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
        let ends = self
            .timer()
            .map(|of| of.writes(None, Some(TimedPass::Surface)));
        self.begin_cleared(&mut frame.encoder, "direct", ends)
    }

    /// A pass that clears the targets and draws into all of them.
    pub(crate) fn begin_cleared<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        label: &str,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) -> wgpu::RenderPass<'a> {
        let (colour, depth_stencil) = (self.colour_view(), self.depth_stencil_view());
        let [r, g, b, a] = SKY.map(f64::from);
        let sky = wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a });
        let store = wgpu::StoreOp::Store;
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(attached(&colour, sky))],
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
            timestamp_writes,
            ..Default::default()
        })
    }

    /// GPU time of the last such frame that was waited for, milliseconds, where the device keeps time: its copies,
    /// dispatches and pass. What a queue writes before them is outside of it.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn direct_ms(&self) -> Result<Option<f64>, DeviceError> {
        self.pass_ms(TimedPass::Surface)
    }
}
