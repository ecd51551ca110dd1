// SPDX-License-Identifier: MIT OR Apache-2.0
//! Surfaces that are triangles, drawn through Vulkan by the same shader as through wgpu.

use crate::{
    Buffer, BufferUse, Fragments, Gpu, ImageBindings, Pipeline, PipelineDescriptor, PipelineState,
    SampledImage, Topology, VertexFormat, VertexStage,
};
use ash::vk;
use std::sync::Arc;
use terrafill_fill::{AddressMode, DeviceError, count_u32};
use terrafill_scene::MipChain;
use terrafill_surface::{SurfaceFrame, SurfaceRenderer};

fn descriptor(has_picture: bool) -> PipelineDescriptor {
    let path = match has_picture {
        true => "surface/picture.wgsl",
        false => "surface/surface.wgsl",
    };
    PipelineDescriptor {
        vertex: VertexStage {
            path,
            entry_point: "vertex_main",
            bends_footprints: false,
        },
        geometry: None,
        fragments: Fragments::Shader {
            path,
            entry_point: "fragment_main",
        },
        format: VertexFormat::Metres,
        topology: Topology::Triangles,
        state: PipelineState::Surface { has_picture },
        depth_bounds: false,
    }
}

/// The picture meets itself at ±180°.
const PICTURE_ADDRESS: [AddressMode; 2] = [AddressMode::Repeat, AddressMode::ClampToEdge];

/// Draws the triangles of any surface. Set 0 holds the view's constants, set 1 a picture where there is one.
#[derive(Debug)]
pub(crate) struct TriangleRenderer {
    gpu: Arc<Gpu>,
    /// In one colour.
    plain: Option<Pipeline>,
    coloured: Option<Coloured>,
    uploaded: Option<Uploaded>,
}

/// What it takes to draw with a picture.
#[derive(Debug)]
struct Coloured {
    picture: Arc<MipChain>,
    bindings: ImageBindings,
    pipeline: Pipeline,
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
    pub(crate) fn new(gpu: &Arc<Gpu>) -> Self {
        Self {
            gpu: Arc::clone(gpu),
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
                self.plain = Some(Pipeline::new(&self.gpu, descriptor(false))?);
            }
            return Ok(());
        };
        self.plain = None;
        let held = self.coloured.as_ref();
        if held.is_some_and(|held| Arc::ptr_eq(&held.picture, picture)) {
            return Ok(());
        }
        let image = Arc::new(SampledImage::picture(&self.gpu, picture)?);
        let bindings = ImageBindings::picture(&image, PICTURE_ADDRESS)?;
        let pipeline = match self.coloured.take() {
            Some(held) => held.pipeline,
            None => Pipeline::new(&self.gpu, descriptor(true))?,
        };
        self.coloured = Some(Coloured {
            picture: Arc::clone(picture),
            bindings,
            pipeline,
        });
        Ok(())
    }
}

impl SurfaceRenderer for TriangleRenderer {
    type Pass<'p> = SurfacePass<'p>;
    type Error = DeviceError;

    fn prepare(
        &mut self,
        frame: &SurfaceFrame,
        picture: Option<&Arc<MipChain>>,
    ) -> Result<(), DeviceError> {
        self.set_picture(picture)?;
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
        let coloured = self.coloured.as_ref();
        let pipeline = coloured.map(|coloured| &coloured.pipeline);
        let (Some(uploaded), Some(pipeline)) = (&self.uploaded, pipeline.or(self.plain.as_ref()))
        else {
            return;
        };
        let SurfacePass { device, commands } = *pass;
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: the pass is being recorded, as its maker promised; pipeline, set and buffers were made for
        // it on this device; the indices are all there.
        unsafe {
            device.cmd_bind_pipeline(commands, graphics, pipeline.raw);
            if let Some(coloured) = coloured {
                let layout = self.gpu.fixtures.picture_layout;
                let sets = [coloured.bindings.set()];
                device.cmd_bind_descriptor_sets(commands, graphics, layout, 1, &sets, &[]);
            }
            device.cmd_bind_vertex_buffers(commands, 0, &[uploaded.vertices.raw], &[0]);
            let width = vk::IndexType::UINT32;
            device.cmd_bind_index_buffer(commands, uploaded.indices.raw, 0, width);
            device.cmd_draw_indexed(commands, uploaded.index_count, 1, 0, 0, 0);
        }
    }
}
