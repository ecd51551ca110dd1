// SPDX-License-Identifier: MIT OR Apache-2.0
//! Surfaces that are triangles, drawn through Vulkan by the same shader as through wgpu.

use crate::{
    Buffer, BufferUse, Fragments, Gpu, ImageBindings, Pipeline, PipelineDescriptor, PipelineState,
    SampledImage, Topology, VertexFormat, VertexStage,
};
use ash::vk;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{DeviceError, SurfaceLook, count_u32};
use terrafill_scene::MipChain;
use terrafill_surface::SurfaceFrame;

fn descriptor(look: SurfaceLook) -> PipelineDescriptor {
    let path = look.shader();
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
        state: PipelineState::Surface(look),
        depth_bounds: false,
    }
}

/// Draws the triangles of any surface. Set 0 holds the view's constants, set 1 a picture where there is one.
#[derive(Debug)]
pub(crate) struct TriangleRenderer {
    gpu: Arc<Gpu>,
    look: SurfaceLook,
    /// Of the looks so far.
    pipelines: HashMap<SurfaceLook, Pipeline>,
    picture: Option<(Arc<MipChain>, ImageBindings)>,
    uploaded: Option<Uploaded>,
}

#[derive(Debug)]
struct Uploaded {
    vertices: Buffer,
    vertex_bytes: usize,
    indices: Buffer,
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
                let image = Arc::new(SampledImage::picture(&self.gpu, picture)?);
                let bindings = ImageBindings::picture(&image, SurfaceLook::PICTURE_ADDRESS)?;
                Some((Arc::clone(picture), bindings))
            }
        };
        Ok(())
    }

    /// Uploads a frame in place of the one before, and a picture of the whole body that is not there yet.
    pub(crate) fn prepare(
        &mut self,
        frame: &SurfaceFrame,
        picture: Option<&Arc<MipChain>>,
    ) -> Result<(), DeviceError> {
        self.set_picture(picture)?;
        if !self.pipelines.contains_key(&self.look) {
            let pipeline = Pipeline::new(&self.gpu, descriptor(self.look))?;
            self.pipelines.insert(self.look, pipeline);
        }
        let vertices: &[u8] = bytemuck::cast_slice(&frame.vertices_rte);
        let drawn = frame.index_ranges(self.look.draws_back_faces);
        let held = self.uploaded.as_mut();
        if let Some(held) = held.filter(|held| held.has_room_for(frame)) {
            held.drawn = drawn;
            return held.vertices.rewrite_parts(&[(0, vertices)]);
        }
        let indices = frame.triangles.as_flattened();
        count_u32("surface indices", indices.len())?;
        let upload = |label, bytes, use_for| Buffer::upload(&self.gpu, label, bytes, use_for);
        self.uploaded = Some(Uploaded {
            vertices: upload("surface vertices", vertices, BufferUse::Vertex)?,
            indices: upload(
                "surface indices",
                bytemuck::cast_slice(indices),
                BufferUse::Index,
            )?,
            drawn,
            vertex_bytes: vertices.len(),
            triangles: Arc::clone(&frame.triangles),
        });
        Ok(())
    }

    /// Draws the frame that was prepared last; nothing before there is one.
    pub(crate) fn draw(&self, pass: &mut SurfacePass<'_>) {
        let pipeline = self.pipelines.get(&self.look);
        let (Some(uploaded), Some(pipeline)) = (&self.uploaded, pipeline) else {
            return;
        };
        let SurfacePass { device, commands } = *pass;
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: the pass is being recorded, as its maker promised; pipeline, set and buffers were made for
        // it on this device; the indices are all there.
        unsafe {
            device.cmd_bind_pipeline(commands, graphics, pipeline.raw());
            if let Some((_, bindings)) = &self.picture {
                let layout = self.gpu.fixtures.picture_layout;
                let sets = [bindings.set()];
                device.cmd_bind_descriptor_sets(commands, graphics, layout, 1, &sets, &[]);
            }
            device.cmd_bind_vertex_buffers(commands, 0, &[uploaded.vertices.raw], &[0]);
            let width = vk::IndexType::UINT32;
            device.cmd_bind_index_buffer(commands, uploaded.indices.raw, 0, width);
            for range in &uploaded.drawn {
                let count = range.end - range.start;
                device.cmd_draw_indexed(commands, count, 1, range.start, 0, 0);
            }
        }
    }
}
