// SPDX-License-Identifier: MIT OR Apache-2.0
//! Balls drawn from the buffer that their step wrote: all by one draw, or by a draw each as in the published text.

use crate::terrain::{PointConstants, ball_view};
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{DeviceError, Picture};
use terrafill_gpu::DirectPipeline;
use terrafill_scene::ImageSize;
use terrafill_vulkan::{
    Buffer, BufferUse, DirectDraw, DrawCall, DrawPipeline, Measured, PrimitiveStages, Resource,
    Resources, Shader, Topology, VertexFormat,
};

const POINTS: &str = "balls/points.wgsl";

terrafill_results::named! {
    /// How balls are drawn.
    all pub(crate) enum DrawCalls {
        /// Not at all.
        Nothing = "none",
        /// All by one draw.
        All = "one-draw",
        /// By a draw each: the published text draws one point by a call.
        Each = "draw-each",
    }
}

impl DrawCalls {
    /// Ranges of balls, a draw each.
    pub(crate) fn ranges(self, balls: u32) -> Vec<Range<u32>> {
        match self {
            Self::Nothing => Vec::new(),
            Self::All => std::iter::once(0..balls).collect(),
            Self::Each => (0..balls).map(|ball| ball..ball + 1).collect(),
        }
    }
}

/// Draws balls and waits.
pub(crate) trait DrawsBalls {
    /// - `state`: which of the two buffers holds them
    /// - returns: GPU time, milliseconds, where the device keeps it
    fn draw(&mut self, state: usize, ranges: &[Range<u32>]) -> Result<Option<f64>, DeviceError>;

    fn read(&self) -> Result<Picture, DeviceError>;
}

/// On Vulkan itself.
pub(crate) struct VulkanPoints {
    targets: terrafill_vulkan::RenderTargets,
    /// From either state.
    pipelines: [DrawPipeline; 2],
}

impl VulkanPoints {
    pub(crate) fn new(
        gpu: &Arc<terrafill_vulkan::Gpu>,
        states: &[Arc<Buffer>; 2],
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let constants = PointConstants::new(&ball_view());
        let bytes = bytemuck::bytes_of(&constants);
        let constants = Arc::new(Buffer::upload(
            gpu,
            "view of balls",
            bytes,
            BufferUse::Uniform,
        )?);
        let wgsl = |entry_point| Shader::Wgsl {
            path: POINTS,
            entry_point,
        };
        let pipeline = |state: &Arc<Buffer>| {
            let resources = vec![
                Resource::Uniform(Arc::clone(&constants)),
                Resource::Storage(Arc::clone(state)),
            ];
            let stages = PrimitiveStages::Vertices {
                vertex: wgsl("vertex_main"),
                geometry: None,
                format: VertexFormat::Number,
                topology: Topology::Points,
            };
            let resources = Resources::new(gpu, resources)?;
            DrawPipeline::new(gpu, &resources, stages, wgsl("fragment_main"))
        };
        Ok(Self {
            targets: terrafill_vulkan::RenderTargets::new(gpu, size)?,
            pipelines: [pipeline(&states[0])?, pipeline(&states[1])?],
        })
    }
}

impl DrawsBalls for VulkanPoints {
    fn draw(&mut self, state: usize, ranges: &[Range<u32>]) -> Result<Option<f64>, DeviceError> {
        let draw = DirectDraw {
            pipeline: &self.pipelines[state],
            vertices: None,
            call: DrawCall::Vertices(ranges),
        };
        Ok(self
            .targets
            .draw_directly(None, &draw, Measured::Times)?
            .gpu_ms)
    }

    fn read(&self) -> Result<Picture, DeviceError> {
        self.targets.read()
    }
}

/// On wgpu.
pub(crate) struct WgpuPoints {
    gpu: Arc<terrafill_gpu::Gpu>,
    targets: terrafill_gpu::RenderTargets,
    pipeline: wgpu::RenderPipeline,
    /// Of either state.
    bound: [wgpu::BindGroup; 2],
}

impl WgpuPoints {
    pub(crate) fn new(
        gpu: &Arc<terrafill_gpu::Gpu>,
        states: &[wgpu::Buffer; 2],
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let constants = PointConstants::new(&ball_view());
        let bytes = bytemuck::bytes_of(&constants);
        let constants = gpu.upload("view of balls", bytes, wgpu::BufferUsages::UNIFORM)?;
        let types = [
            wgpu::BufferBindingType::Uniform,
            wgpu::BufferBindingType::Storage { read_only: true },
        ];
        let layout = gpu.buffer_layout("points", wgpu::ShaderStages::VERTEX, &types);
        let bound = states
            .each_ref()
            .map(|state| gpu.bind_buffers("points", &layout, &[&constants, state]));
        let pipeline = gpu.direct_pipeline(&DirectPipeline {
            path: POINTS,
            entry_point: "vertex_main",
            topology: wgpu::PrimitiveTopology::PointList,
            format: None,
            layout: &layout,
        })?;
        Ok(Self {
            gpu: Arc::clone(gpu),
            targets: terrafill_gpu::RenderTargets::new(gpu, size)?,
            pipeline,
            bound,
        })
    }
}

impl DrawsBalls for WgpuPoints {
    fn draw(&mut self, state: usize, ranges: &[Range<u32>]) -> Result<Option<f64>, DeviceError> {
        let mut frame = self.targets.direct_frame();
        let mut pass = self.targets.cleared_pass(&mut frame);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bound[state], &[]);
        for range in ranges {
            pass.draw(range.clone(), 0..1);
        }
        drop(pass);
        self.gpu.queue.submit([frame.encoder.finish()]);
        self.gpu.wait()?;
        self.targets.direct_ms()
    }

    fn read(&self) -> Result<Picture, DeviceError> {
        self.targets.read()
    }
}
