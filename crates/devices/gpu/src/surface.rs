// SPDX-License-Identifier: MIT OR Apache-2.0
//! Surfaces that are triangles, drawn through wgpu.

use crate::Gpu;
use crate::attachments::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT};
use crate::picture::{bind_picture, picture_layout, upload_picture};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{DeviceError, SurfaceLook, count_u32};
use terrafill_scene::MipChain;
use terrafill_surface::SurfaceFrame;

/// Draws the triangles of any surface. Group 0 holds the view's constants, group 1 a picture where there is one.
#[derive(Debug)]
pub(crate) struct TriangleRenderer {
    gpu: Arc<Gpu>,
    view_layout: wgpu::BindGroupLayout,
    look: SurfaceLook,
    /// Of the looks so far.
    pipelines: HashMap<SurfaceLook, wgpu::RenderPipeline>,
    picture: Option<(Arc<MipChain>, wgpu::BindGroup)>,
    uploaded: Option<Uploaded>,
}

#[derive(Debug)]
struct Uploaded {
    vertices: wgpu::Buffer,
    vertex_bytes: usize,
    indices: wgpu::Buffer,
    /// Of the indices, what the view may show.
    drawn: Vec<Range<u32>>,
    /// What the indices are of.
    triangles: Arc<[[u32; 3]]>,
}

impl Uploaded {
    /// Whether only places differ, as those of a surface do that another view sees.
    fn has_room_for(&self, frame: &SurfaceFrame) -> bool {
        Arc::ptr_eq(&self.triangles, &frame.triangles)
            && self.vertex_bytes == size_of_val(&*frame.vertices_rte)
    }
}

impl TriangleRenderer {
    /// - `layout`: of group 0
    pub(crate) fn new(gpu: &Arc<Gpu>, layout: &wgpu::BindGroupLayout) -> Self {
        Self {
            gpu: Arc::clone(gpu),
            view_layout: layout.clone(),
            look: SurfaceLook::default(),
            pipelines: HashMap::new(),
            picture: None,
            uploaded: None,
        }
    }

    /// Whether back faces are drawn in frames that are prepared from now on.
    pub(crate) fn set_faces(&mut self, draws_back_faces: bool) {
        self.look.draws_back_faces = draws_back_faces;
    }

    /// Holds `picture` and no other.
    fn set_picture(&mut self, picture: Option<&Arc<MipChain>>) -> Result<(), DeviceError> {
        self.look.has_picture = picture.is_some();
        let held = self.picture.take();
        let Some(picture) = picture else {
            return Ok(());
        };
        self.picture = match held {
            Some(held) if Arc::ptr_eq(&held.0, picture) => Some(held),
            _ => {
                let image = upload_picture(&self.gpu, picture)?;
                let layout = picture_layout(&self.gpu);
                let group = bind_picture(&self.gpu, &layout, &image, SurfaceLook::PICTURE_ADDRESS);
                Some((Arc::clone(picture), group))
            }
        };
        Ok(())
    }

    /// Of the look that is wanted now.
    fn pipeline(&self) -> Result<wgpu::RenderPipeline, DeviceError> {
        let cull_mode = (!self.look.draws_back_faces).then_some(wgpu::Face::Back);
        let own = self.look.has_picture.then(|| picture_layout(&self.gpu));
        let groups = [Some(&self.view_layout), own.as_ref()];
        let groups = &groups[..1 + usize::from(own.is_some())];
        pipeline(&self.gpu, self.look.shader(), groups, cull_mode)
    }

    /// Uploads a frame in place of the one before, and a picture of the whole body that is not there yet.
    pub(crate) fn prepare(
        &mut self,
        frame: &SurfaceFrame,
        picture: Option<&Arc<MipChain>>,
    ) -> Result<(), DeviceError> {
        self.set_picture(picture)?;
        if !self.pipelines.contains_key(&self.look) {
            let pipeline = self.pipeline()?;
            self.pipelines.insert(self.look, pipeline);
        }
        let vertices: &[u8] = bytemuck::cast_slice(&frame.vertices_rte);
        let drawn = frame.index_ranges(self.look.draws_back_faces);
        let held = self.uploaded.as_mut();
        if let Some(held) = held.filter(|held| held.has_room_for(frame)) {
            held.drawn = drawn;
            self.gpu.write_buffer(&held.vertices, 0, vertices);
            return Ok(());
        }
        let indices = frame.triangles.as_flattened();
        count_u32("surface indices", indices.len())?;
        let (vertex, index) = (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX);
        let upload = |label, bytes, usage| self.gpu.upload(label, bytes, usage);
        self.uploaded = Some(Uploaded {
            vertices: upload("surface vertices", vertices, vertex)?,
            indices: upload("surface indices", bytemuck::cast_slice(indices), index)?,
            drawn,
            vertex_bytes: vertices.len(),
            triangles: Arc::clone(&frame.triangles),
        });
        Ok(())
    }

    /// Draws the frame that was prepared last; nothing before there is one.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        let pipeline = self.pipelines.get(&self.look);
        let (Some(uploaded), Some(pipeline)) = (&self.uploaded, pipeline) else {
            return;
        };
        pass.set_pipeline(pipeline);
        if let Some((_, group)) = &self.picture {
            pass.set_bind_group(1, group, &[]);
        }
        pass.set_vertex_buffer(0, uploaded.vertices.slice(..));
        pass.set_index_buffer(uploaded.indices.slice(..), wgpu::IndexFormat::Uint32);
        for range in &uploaded.drawn {
            pass.draw_indexed(range.clone(), 0, 0..1);
        }
    }
}

/// - `groups`: layouts of what the shader at `path` is bound to
fn pipeline(
    gpu: &Gpu,
    path: &str,
    groups: &[Option<&wgpu::BindGroupLayout>],
    cull_mode: Option<wgpu::Face>,
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
