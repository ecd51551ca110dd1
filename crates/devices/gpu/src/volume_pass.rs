// SPDX-License-Identifier: MIT OR Apache-2.0
//! One pass of a stencil program while it is recorded: draws are counted, scissors set where they change.

use std::ops::Range;
use terrafill_contract::Counters;
use terrafill_plan::PixelRect;
use terrafill_stencil::VolumeList;

/// A pass and what was drawn in it.
#[derive(Debug)]
pub struct VolumePass<'a> {
    /// For bindings and pipelines; draws go through the others.
    pub raw: wgpu::RenderPass<'a>,
    /// What is drawn.
    pub list: &'a VolumeList,
    counters: &'a mut Counters,
    scissor: PixelRect,
    is_at_sky: bool,
}

impl<'a> VolumePass<'a> {
    pub(crate) fn new(
        raw: wgpu::RenderPass<'a>,
        list: &'a VolumeList,
        counters: &'a mut Counters,
    ) -> Self {
        Self {
            raw,
            list,
            counters,
            scissor: PixelRect::full(list.size),
            is_at_sky: false,
        }
    }

    /// Cuts the following draws to the rectangle of a volume, or with `scissor` off to the image.
    pub fn cut(&mut self, volume: usize, scissor: bool) {
        let rect = self.list.rect(volume, scissor);
        if rect != self.scissor {
            let (width, height) = (rect.width(), rect.height());
            self.raw
                .set_scissor_rect(rect.left, rect.top, width, height);
            self.scissor = rect;
        }
    }

    /// Gives all fragments of the following draws the sky's depth, 0, or with `is_at_sky` off their own.
    pub(crate) fn at_sky(&mut self, is_at_sky: bool) {
        if is_at_sky != self.is_at_sky {
            let size = PixelRect::full(self.list.size);
            let [width, height] = [size.width(), size.height()].map(|pixels| pixels as f32);
            let nearest = if is_at_sky { 0.0 } else { 1.0 };
            self.raw.set_viewport(0.0, 0.0, width, height, 0.0, nearest);
            self.is_at_sky = is_at_sky;
        }
    }

    /// Draws vertices that the shader makes up, of a volume.
    pub fn draw(&mut self, vertices: Range<u32>, volume: usize) {
        self.count(&vertices, 1);
        self.raw.draw(vertices, instance(volume));
    }

    /// Draws `corners` vertices that the shader makes up for each of `instances`, of a volume.
    /// Instance numbers say which instance it is, so vertex numbers say which volume: the first one
    /// is `corners` times its index.
    pub fn draw_instances(&mut self, corners: u32, instances: Range<u32>, volume: usize) {
        let first = corners * instance(volume).start;
        let vertices = first..first + corners;
        self.count(&vertices, instances.len());
        self.raw.draw(vertices, instances);
    }

    /// Draws `corners` vertices that the shader makes up for each of `covers`, which bring what tells them
    /// apart along.
    pub(crate) fn draw_covers(&mut self, corners: u32, covers: Range<u32>) {
        let vertices = 0..corners;
        self.count(&vertices, covers.len());
        self.raw.draw(vertices, covers);
    }

    /// Draws indices, each plus `base_vertex`, of a volume.
    pub fn draw_indexed(&mut self, indices: Range<u32>, base_vertex: i32, volume: usize) {
        self.count(&indices, 1);
        self.raw
            .draw_indexed(indices, base_vertex, instance(volume));
    }

    /// Draws what the arguments at `offset` say; how many vertices that is, only the device knows.
    pub fn draw_as_decided(&mut self, arguments: &wgpu::Buffer, offset: u64) {
        self.counters.draws += 1;
        self.raw.draw_indexed_indirect(arguments, offset);
    }

    fn count(&mut self, vertices: &Range<u32>, instances: usize) {
        self.counters.draws += 1;
        self.counters.vertices += (vertices.len() * instances) as u64;
    }
}

/// Of indices of 16 or of 32 bits.
#[must_use]
pub fn index_format(is_short: bool) -> wgpu::IndexFormat {
    if is_short {
        wgpu::IndexFormat::Uint16
    } else {
        wgpu::IndexFormat::Uint32
    }
}

/// The instance number is the index of the volume's constants.
fn instance(volume: usize) -> Range<u32> {
    let first = u32::try_from(volume).unwrap_or(u32::MAX - 1);
    first..first + 1
}
