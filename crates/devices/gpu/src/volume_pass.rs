// SPDX-License-Identifier: MIT OR Apache-2.0
//! One pass of a fill while it is recorded: draws are counted, scissors set where they change.

use std::ops::Range;
use terrafill_fill::{Counters, FillInput};
use terrafill_scene::PixelRect;

/// A pass and what was drawn in it.
#[derive(Debug)]
pub struct VolumePass<'a> {
    /// For bindings and pipelines; draws go through the others.
    pub raw: wgpu::RenderPass<'a>,
    /// What is drawn.
    pub input: &'a FillInput,
    counters: &'a mut Counters,
    scissor: PixelRect,
}

impl<'a> VolumePass<'a> {
    pub(crate) fn new(
        raw: wgpu::RenderPass<'a>,
        input: &'a FillInput,
        counters: &'a mut Counters,
    ) -> Self {
        Self {
            raw,
            input,
            counters,
            scissor: PixelRect::full(input.size),
        }
    }

    /// Cuts the following draws to the rectangle of a planned region, or with `scissor` off to the
    /// image.
    pub fn cut(&mut self, planned: usize, scissor: bool) {
        let rect = self.input.rect(planned, scissor);
        if rect != self.scissor {
            let (width, height) = (rect.width(), rect.height());
            self.raw
                .set_scissor_rect(rect.left, rect.top, width, height);
            self.scissor = rect;
        }
    }

    /// Draws vertices that the shader makes up, of a planned region.
    pub fn draw(&mut self, vertices: Range<u32>, planned: usize) {
        self.count(&vertices, 1);
        self.raw.draw(vertices, instance(planned));
    }

    /// Draws `corners` vertices that the shader makes up for each of `instances`, of a planned region.
    /// Instance numbers say which instance it is, so vertex numbers say which region: the first one
    /// is `corners` times its index.
    pub fn draw_instances(&mut self, corners: u32, instances: Range<u32>, planned: usize) {
        let first = corners * instance(planned).start;
        let vertices = first..first + corners;
        self.count(&vertices, instances.len());
        self.raw.draw(vertices, instances);
    }

    /// Draws indices, each plus `base_vertex`, of a planned region.
    pub fn draw_indexed(&mut self, indices: Range<u32>, base_vertex: i32, planned: usize) {
        self.count(&indices, 1);
        self.raw
            .draw_indexed(indices, base_vertex, instance(planned));
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

/// The instance number is the index of the region's constants.
fn instance(planned: usize) -> Range<u32> {
    let first = u32::try_from(planned).unwrap_or(u32::MAX - 1);
    first..first + 1
}
