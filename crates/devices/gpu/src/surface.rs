// SPDX-License-Identifier: MIT OR Apache-2.0
//! Surfaces that are triangles, drawn through wgpu.

use crate::Gpu;
use crate::attachments::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT};
use crate::picture::{bind_picture, picture_layout, upload_picture};
use std::sync::Arc;
use terrafill_fill::{AddressMode, DeviceError, count_u32};
use terrafill_scene::MipChain;
use terrafill_surface::{SurfaceFrame, SurfaceRenderer};

/// Draws the triangles of any surface. Group 0 holds the view's constants, group 1 a picture where there is one.
#[derive(Debug)]
pub(crate) struct TriangleRenderer {
    gpu: Arc<Gpu>,
    view_layout: wgpu::BindGroupLayout,
    /// In one colour.
    plain: Option<wgpu::RenderPipeline>,
    coloured: Option<Coloured>,
    uploaded: Option<Uploaded>,
}

/// What it takes to draw with a picture.
#[derive(Debug)]
struct Coloured {
    picture: Arc<MipChain>,
    group: wgpu::BindGroup,
    pipeline: wgpu::RenderPipeline,
}

#[derive(Debug)]
struct Uploaded {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
}

impl TriangleRenderer {
    /// - `layout`: of group 0
    pub(crate) fn new(gpu: &Arc<Gpu>, layout: &wgpu::BindGroupLayout) -> Self {
        Self {
            gpu: Arc::clone(gpu),
            view_layout: layout.clone(),
            plain: None,
            coloured: None,
            uploaded: None,
        }
    }

    /// Makes what draws in one colour or with `picture`, and lets go of what does not.
    fn set_picture(&mut self, picture: Option<&Arc<MipChain>>) -> Result<(), DeviceError> {
        let Some(picture) = picture else {
            self.coloured = None;
            if self.plain.is_none() {
                let groups = [Some(&self.view_layout)];
                self.plain = Some(pipeline(&self.gpu, "surface/surface.wgsl", &groups)?);
            }
            return Ok(());
        };
        self.plain = None;
        let held = self.coloured.as_ref();
        if held.is_some_and(|held| Arc::ptr_eq(&held.picture, picture)) {
            return Ok(());
        }
        let layout = picture_layout(&self.gpu);
        let image = upload_picture(&self.gpu, picture)?;
        let group = bind_picture(&self.gpu, &layout, &image, PICTURE_ADDRESS);
        let pipeline = match self.coloured.take() {
            Some(held) => held.pipeline,
            None => {
                let groups = [Some(&self.view_layout), Some(&layout)];
                pipeline(&self.gpu, "surface/picture.wgsl", &groups)?
            }
        };
        self.coloured = Some(Coloured {
            picture: Arc::clone(picture),
            group,
            pipeline,
        });
        Ok(())
    }
}

/// The picture meets itself at ±180°.
const PICTURE_ADDRESS: [AddressMode; 2] = [AddressMode::Repeat, AddressMode::ClampToEdge];

impl SurfaceRenderer for TriangleRenderer {
    type Pass<'p> = wgpu::RenderPass<'p>;
    type Error = DeviceError;

    fn prepare(
        &mut self,
        frame: &SurfaceFrame,
        picture: Option<&Arc<MipChain>>,
    ) -> Result<(), DeviceError> {
        self.set_picture(picture)?;
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
        match (&self.coloured, &self.plain) {
            (Some(coloured), _) => {
                pass.set_pipeline(&coloured.pipeline);
                pass.set_bind_group(1, &coloured.group, &[]);
            }
            (None, Some(plain)) => pass.set_pipeline(plain),
            (None, None) => return,
        }
        pass.set_vertex_buffer(0, uploaded.vertices.slice(..));
        pass.set_index_buffer(uploaded.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..uploaded.index_count, 0, 0..1);
    }
}

/// - `groups`: layouts of what the shader at `path` is bound to
fn pipeline(
    gpu: &Gpu,
    path: &str,
    groups: &[Option<&wgpu::BindGroupLayout>],
) -> Result<wgpu::RenderPipeline, DeviceError> {
    let shader = gpu.shader(path)?;
    let layout = gpu
        .device
        .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("surface"),
            bind_group_layouts: groups,
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
