// SPDX-License-Identifier: MIT OR Apache-2.0
//! Targets on wgpu of any format, the one pass over them, and their read-back.

use crate::view::Eye;
use bytemuck::Pod;
use std::sync::Arc;
use terrafill_contract::{DeviceError, ViewConstants};
use terrafill_gpu::{Gpu, PassTimer, TimedPass, read_texture};
use terrafill_scene::ImageSize;
use terrafill_surface::{HeightRange, SurfaceFrame};

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Colour of some format, depth, and the GPU's clock where there is one.
pub struct Canvas {
    /// Device and queue that all of it is on.
    pub gpu: Arc<Gpu>,
    format: wgpu::TextureFormat,
    colour: wgpu::Texture,
    depth: wgpu::Texture,
    timer: Option<PassTimer>,
}

/// What a pipeline runs, and what its vertices are read from.
pub struct Stages<'a> {
    /// Holds both stages.
    pub module: &'a wgpu::ShaderModule,
    /// Of the vertex stage and of the fragment stage.
    pub entry_points: [&'a str; 2],
    /// Overrides of the module, by name.
    pub constants: &'a [(&'a str, f64)],
    /// By slot.
    pub buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
}

/// A buffer of vertices without gaps between them.
pub fn vertices(attributes: &[wgpu::VertexAttribute]) -> Option<wgpu::VertexBufferLayout<'_>> {
    Some(wgpu::VertexBufferLayout {
        array_stride: attributes.iter().map(|one| one.format.size()).sum(),
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes,
    })
}

impl Canvas {
    /// - `size`: of both targets, pixels
    /// - `format`: of the colour
    #[must_use]
    pub fn new(gpu: &Arc<Gpu>, size: ImageSize, format: wgpu::TextureFormat) -> Self {
        let target = |label, format, usage| {
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | usage;
            gpu.texture(label, [size.width, size.height, 1], 1, format, usage)
        };
        let read = wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::TEXTURE_BINDING;
        Self {
            gpu: Arc::clone(gpu),
            format,
            colour: target("canvas", format, read),
            depth: target("canvas' depth", DEPTH, wgpu::TextureUsages::empty()),
            timer: PassTimer::new(gpu),
        }
    }

    /// A pipeline that draws triangles into it, the nearest depth winning.
    pub fn pipeline(
        &self,
        label: &str,
        layout: &wgpu::PipelineLayout,
        stages: &Stages<'_>,
    ) -> wgpu::RenderPipeline {
        self.pipeline_of(Default::default(), label, layout, stages)
    }

    /// The same of whatever `topology` makes of vertices.
    pub fn pipeline_of(
        &self,
        topology: wgpu::PrimitiveTopology,
        label: &str,
        layout: &wgpu::PipelineLayout,
        stages: &Stages<'_>,
    ) -> wgpu::RenderPipeline {
        let options = || wgpu::PipelineCompilationOptions {
            constants: stages.constants,
            ..Default::default()
        };
        let [vertex, fragment] = stages.entry_points;
        self.gpu
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(label),
                layout: Some(layout),
                vertex: wgpu::VertexState {
                    module: stages.module,
                    entry_point: Some(vertex),
                    compilation_options: options(),
                    buffers: stages.buffers,
                },
                primitive: wgpu::PrimitiveState {
                    topology,
                    ..Default::default()
                },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(wgpu::CompareFunction::Greater),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: stages.module,
                    entry_point: Some(fragment),
                    compilation_options: options(),
                    targets: &[Some(self.format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
    }

    /// The colour target, for reading.
    pub fn view(&self) -> wgpu::TextureView {
        self.colour.create_view(&Default::default())
    }

    /// Commands of a frame, from before whose first its time is kept.
    pub fn frame(&self) -> wgpu::CommandEncoder {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        if let Some(timer) = &self.timer {
            timer.begin(&mut encoder, TimedPass::Surface);
        }
        encoder
    }

    /// Clears all to 0 and records a pass over it, which ends the time of [`Self::frame`].
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        draw: impl FnOnce(&mut wgpu::RenderPass<'_>),
    ) {
        let (colour, depth) = (self.view(), self.depth.create_view(&Default::default()));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("canvas"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &colour,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: self
                .timer
                .as_ref()
                .map(|t| t.writes(None, Some(TimedPass::Surface))),
            ..Default::default()
        });
        draw(&mut pass);
    }

    /// Submits what was recorded, waits, and gives the frame's time by the GPU, milliseconds.
    ///
    /// # Errors
    /// The device is lost.
    pub fn finish(&self, encoder: wgpu::CommandEncoder) -> Result<Option<f64>, DeviceError> {
        let gpu = &self.gpu;
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let timed = self.timer.as_ref();
        let timed = timed.map(|timer| timer.pass_ms(gpu, TimedPass::Surface));
        Ok(timed.transpose()?.flatten())
    }

    /// Texels of the colour target, row by row from the top.
    ///
    /// # Errors
    /// As [`Self::finish`].
    pub fn read<T: Pod>(&self) -> Result<Vec<T>, DeviceError> {
        let bytes = read_texture(&self.gpu, &self.colour, wgpu::TextureAspect::All)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }
}

/// A texture that shaders read and the CPU writes.
///
/// - `size`: width, height and layers
pub fn texture(
    gpu: &Gpu,
    label: &str,
    size: [u32; 3],
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    gpu.texture(label, size, 1, format, usage)
}

/// Writes whole layers of four bytes a texel, from number `z` on.
#[allow(clippy::cast_possible_truncation, reason = "a number of layers")]
pub fn write_layers(gpu: &Gpu, texture: &wgpu::Texture, z: u32, texels: &[u8]) {
    let (width, height) = (texture.width(), texture.height());
    let layers = texels.len() / (4 * width * height) as usize;
    gpu.write_texture(
        wgpu::TexelCopyTextureInfo {
            origin: wgpu::Origin3d { x: 0, y: 0, z },
            ..texture.as_image_copy()
        },
        texels,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * width),
            rows_per_image: Some(height),
        },
        wgpu::Extent3d {
            depth_or_array_layers: layers as u32,
            ..texture.size()
        },
    );
}

/// A buffer of so many bytes that the CPU writes now and then.
pub fn written(gpu: &Gpu, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.unwritten(label, size, usage | wgpu::BufferUsages::COPY_DST)
}

/// A buffer for constants of this type.
pub fn uniform<T>(gpu: &Gpu, label: &str) -> wgpu::Buffer {
    written(
        gpu,
        label,
        size_of::<T>() as u64,
        wgpu::BufferUsages::UNIFORM,
    )
}

/// A frame without triangles, where no more is wanted of it.
pub fn no_triangles() -> SurfaceFrame {
    SurfaceFrame {
        vertices_rte: Arc::default(),
        triangles: Arc::default(),
        heights: HeightRange {
            lowest_m: 0.0,
            highest_m: 0.0,
        },
        parts: Arc::default(),
        shown: None,
    }
}

/// Constants of a view without a surface.
pub fn view_constants(eye: &Eye) -> ViewConstants {
    ViewConstants::new(&eye.view(&no_triangles()))
}
