// SPDX-License-Identifier: MIT OR Apache-2.0
//! Surfaces that are triangles, drawn through wgpu.

use crate::Gpu;
use crate::attachments::COLOUR_FORMAT;
use crate::picture::{bind_picture, picture_layout, upload_picture};
use crate::render_pipeline::{described, nearest, vertex_layout};
use std::sync::Arc;
use terrafill_contract::{DeviceError, SurfaceDevice, SurfaceDraw, SurfaceLook};
use terrafill_scene::MipChain;

/// Group 0 holds the view's constants, group 1 a picture where there is one.
#[derive(Debug)]
pub(crate) struct WgpuSurface {
    pub(crate) gpu: Arc<Gpu>,
    /// Of group 0.
    pub(crate) view_layout: wgpu::BindGroupLayout,
}

impl SurfaceDevice for WgpuSurface {
    type Buffer = wgpu::Buffer;
    type Pipeline = wgpu::RenderPipeline;
    type Picture = wgpu::BindGroup;

    fn pipeline(&self, look: SurfaceLook) -> Result<wgpu::RenderPipeline, DeviceError> {
        let own = look.has_picture.then(|| picture_layout(&self.gpu));
        let groups = [Some(&self.view_layout), own.as_ref()];
        let groups = &groups[..1 + usize::from(own.is_some())];
        let shader = self.gpu.shader(look.shader())?;
        let layout = self.gpu.pipeline_layout("surface", groups);
        let targets = [Some(COLOUR_FORMAT.into())];
        let attributes = wgpu::vertex_attr_array![0 => Float32x3];
        let vertices = [vertex_layout(&attributes)];
        let mut described = described("surface", &layout, &shader, &targets);
        described.vertex.buffers = &vertices;
        described.primitive.cull_mode = (!look.draws_back_faces).then_some(wgpu::Face::Back);
        described.depth_stencil = Some(nearest());
        Ok(self.gpu.create_render_pipeline(&described))
    }

    fn picture(&self, picture: &MipChain) -> Result<wgpu::BindGroup, DeviceError> {
        let image = upload_picture(&self.gpu, picture)?;
        let (layout, address) = (picture_layout(&self.gpu), SurfaceLook::PICTURE_ADDRESS);
        Ok(bind_picture(&self.gpu, &layout, &image, address))
    }

    fn upload(&self, bytes: &[u8], are_indices: bool) -> Result<wgpu::Buffer, DeviceError> {
        let (label, usage) = if are_indices {
            ("surface indices", wgpu::BufferUsages::INDEX)
        } else {
            ("surface vertices", wgpu::BufferUsages::VERTEX)
        };
        self.gpu.upload(label, bytes, usage)
    }

    fn rewrite(&self, buffer: &wgpu::Buffer, bytes: &[u8]) -> Result<(), DeviceError> {
        self.gpu.write_buffer(buffer, 0, bytes);
        Ok(())
    }
}

/// Draws a surface; group 0 is bound.
pub(crate) fn draw(pass: &mut wgpu::RenderPass<'_>, surface: &SurfaceDraw<'_, WgpuSurface>) {
    pass.set_pipeline(surface.pipeline);
    if let Some(group) = surface.picture {
        pass.set_bind_group(1, group, &[]);
    }
    pass.set_vertex_buffer(0, surface.vertices.slice(..));
    pass.set_index_buffer(surface.indices.slice(..), wgpu::IndexFormat::Uint32);
    for range in surface.ranges {
        pass.draw_indexed(range.clone(), 0, 0..1);
    }
}
