// SPDX-License-Identifier: MIT OR Apache-2.0
//! Surfaces that are triangles, drawn through Vulkan by the same shader as through wgpu.

use crate::{
    Buffer, BufferUse, Fragments, Gpu, Pipeline, PipelineDescriptor, PipelineState, Topology,
    VertexFormat, VertexStage,
};
use ash::vk;
use std::sync::Arc;
use terrafill_fill::{DeviceError, count_u32};
use terrafill_surface::{SurfaceFrame, SurfaceRenderer};

const SURFACE: PipelineDescriptor = PipelineDescriptor {
    vertex: VertexStage {
        path: "surface/surface.wgsl",
        entry_point: "vertex_main",
        bends_footprints: false,
    },
    geometry: None,
    fragments: Fragments::Shader {
        path: "surface/surface.wgsl",
        entry_point: "fragment_main",
    },
    format: VertexFormat::Metres,
    topology: Topology::Triangles,
    state: PipelineState::Surface,
    depth_bounds: false,
};

/// Draws the triangles of any surface.
#[derive(Debug)]
pub(crate) struct TriangleRenderer {
    gpu: Arc<Gpu>,
    pipeline: Pipeline,
    /// Of views that ask for it.
    both_faces: Option<Pipeline>,
    uploaded: Option<Uploaded>,
    draws_back_faces: bool,
}

#[derive(Debug)]
struct Uploaded {
    vertices: Buffer,
    indices: Buffer,
    index_count: u32,
}

/// A surface pass that is being recorded.
pub(crate) struct SurfacePass<'p> {
    device: &'p ash::Device,
    commands: vk::CommandBuffer,
}

impl<'p> SurfacePass<'p> {
    /// # Safety
    /// Until the pass is dropped, `commands` must be recording the surface's render pass on `device`,
    /// with viewport, scissor and the view's constants set. What is drawn must live until the
    /// submission is done.
    pub(crate) unsafe fn new(device: &'p ash::Device, commands: vk::CommandBuffer) -> Self {
        Self { device, commands }
    }
}

impl TriangleRenderer {
    pub(crate) fn new(gpu: &Arc<Gpu>) -> Result<Self, DeviceError> {
        Ok(Self {
            pipeline: Pipeline::new(gpu, SURFACE)?,
            both_faces: None,
            gpu: Arc::clone(gpu),
            uploaded: None,
            draws_back_faces: false,
        })
    }

    /// Whether back faces are drawn from now on.
    pub(crate) fn set_faces(&mut self, draws_back_faces: bool) -> Result<(), DeviceError> {
        self.draws_back_faces = draws_back_faces;
        if draws_back_faces && self.both_faces.is_none() {
            let descriptor = PipelineDescriptor {
                state: PipelineState::SurfaceOfBothFaces,
                ..SURFACE
            };
            self.both_faces = Some(Pipeline::new(&self.gpu, descriptor)?);
        }
        Ok(())
    }
}

impl SurfaceRenderer for TriangleRenderer {
    type Pass<'p> = SurfacePass<'p>;
    type Error = DeviceError;

    fn prepare(&mut self, frame: &SurfaceFrame) -> Result<(), DeviceError> {
        let indices = frame.triangles.as_flattened();
        let vertices = bytemuck::cast_slice(&frame.vertices_rte);
        let upload = |label, bytes, use_for| Buffer::upload(&self.gpu, label, bytes, use_for);
        self.uploaded = Some(Uploaded {
            vertices: upload("surface vertices", vertices, BufferUse::Vertex)?,
            indices: upload(
                "surface indices",
                bytemuck::cast_slice(indices),
                BufferUse::Index,
            )?,
            index_count: count_u32("surface indices", indices.len())?,
        });
        Ok(())
    }

    fn draw(&self, pass: &mut SurfacePass<'_>) {
        let Some(uploaded) = &self.uploaded else {
            return;
        };
        let SurfacePass { device, commands } = *pass;
        let both = self.both_faces.as_ref().filter(|_| self.draws_back_faces);
        let pipeline = both.unwrap_or(&self.pipeline);
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: the pass is being recorded, as its maker promised; pipeline and buffers were made for
        // it on this device; the indices are all there.
        unsafe {
            device.cmd_bind_pipeline(commands, graphics, pipeline.raw);
            device.cmd_bind_vertex_buffers(commands, 0, &[uploaded.vertices.raw], &[0]);
            let width = vk::IndexType::UINT32;
            device.cmd_bind_index_buffer(commands, uploaded.indices.raw, 0, width);
            device.cmd_draw_indexed(commands, uploaded.index_count, 1, 0, 0, 0);
        }
    }
}
