// SPDX-License-Identifier: MIT OR Apache-2.0
//! Surfaces that are triangles, drawn through wgpu.

use crate::Gpu;
use crate::attachments::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT};
use std::sync::Arc;
use terrafill_fill::{DeviceError, count_u32};
use terrafill_surface::{SurfaceFrame, SurfaceRenderer};

/// Draws the triangles of any surface. Group 0 holds the view's constants.
#[derive(Debug)]
pub(crate) struct TriangleRenderer {
    gpu: Arc<Gpu>,
    pipeline: wgpu::RenderPipeline,
    uploaded: Option<Uploaded>,
}

#[derive(Debug)]
struct Uploaded {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
}

impl TriangleRenderer {
    /// - `layout`: of group 0
    pub(crate) fn new(gpu: &Arc<Gpu>, layout: &wgpu::BindGroupLayout) -> Result<Self, DeviceError> {
        Ok(Self {
            pipeline: pipeline(gpu, layout)?,
            gpu: Arc::clone(gpu),
            uploaded: None,
        })
    }
}

impl SurfaceRenderer for TriangleRenderer {
    type Pass<'p> = wgpu::RenderPass<'p>;
    type Error = DeviceError;

    fn prepare(&mut self, frame: &SurfaceFrame) -> Result<(), DeviceError> {
        let indices = frame.triangles.as_flattened();
        let vertices = bytemuck::cast_slice(&frame.vertices_rte);
        let (vertex, index) = (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX);
        let upload = |label, bytes, usage| self.gpu.upload(label, bytes, usage);
        self.uploaded = Some(Uploaded {
            vertices: upload("surface vertices", vertices, vertex)?,
            indices: upload("surface indices", bytemuck::cast_slice(indices), index)?,
            index_count: count_u32("surface indices", indices.len())?,
        });
        Ok(())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        let Some(uploaded) = &self.uploaded else {
            return;
        };
        pass.set_pipeline(&self.pipeline);
        pass.set_vertex_buffer(0, uploaded.vertices.slice(..));
        pass.set_index_buffer(uploaded.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..uploaded.index_count, 0, 0..1);
    }
}

fn pipeline(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
) -> Result<wgpu::RenderPipeline, DeviceError> {
    let shader = gpu.shader("surface/surface.wgsl")?;
    let layout = gpu
        .device
        .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("surface"),
            bind_group_layouts: &[Some(layout)],
            immediate_size: 0,
        });
    Ok(gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("surface"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &shader,
            entry_point: Some("vertex_main"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 12,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3],
            })],
        },
        primitive: wgpu::PrimitiveState {
            cull_mode: Some(wgpu::Face::Back),
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
            module: &shader,
            entry_point: Some("fragment_main"),
            compilation_options: Default::default(),
            targets: &[Some(COLOUR_FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    }))
}
