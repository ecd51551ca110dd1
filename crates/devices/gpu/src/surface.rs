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
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    /// Of views that ask for it.
    both_faces: Option<wgpu::RenderPipeline>,
    uploaded: Option<Uploaded>,
    draws_back_faces: bool,
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
            pipeline: pipeline(gpu, layout, Some(wgpu::Face::Back))?,
            both_faces: None,
            layout: layout.clone(),
            gpu: Arc::clone(gpu),
            uploaded: None,
            draws_back_faces: false,
        })
    }

    /// Whether back faces are drawn from now on.
    pub(crate) fn set_faces(&mut self, draws_back_faces: bool) -> Result<(), DeviceError> {
        self.draws_back_faces = draws_back_faces;
        if draws_back_faces && self.both_faces.is_none() {
            self.both_faces = Some(pipeline(&self.gpu, &self.layout, None)?);
        }
        Ok(())
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
        let both = self.both_faces.as_ref().filter(|_| self.draws_back_faces);
        pass.set_pipeline(both.unwrap_or(&self.pipeline));
        pass.set_vertex_buffer(0, uploaded.vertices.slice(..));
        pass.set_index_buffer(uploaded.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..uploaded.index_count, 0, 0..1);
    }
}

fn pipeline(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    cull_mode: Option<wgpu::Face>,
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
            cull_mode,
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
