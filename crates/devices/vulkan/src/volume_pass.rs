// SPDX-License-Identifier: MIT OR Apache-2.0
//! One pass of a fill while it is recorded: draws are counted, and cut to their region's rectangle.

use crate::{BindGroup, CoverState, DrawState, Geometry, PassRecorder, Pipeline};
use std::ops::Range;
use terrafill_fill::{Counters, FillInput};

/// A pass and what was drawn in it. Whatever is drawn with outlives `'a`, and thereby the fill.
pub struct VolumePass<'a, 'r, 'f> {
    recorder: &'r mut PassRecorder<'a, 'f>,
    /// What is drawn.
    pub input: &'a FillInput,
    /// View and regions.
    bindings: &'a BindGroup,
    counters: &'r mut Counters,
}

impl<'a, 'r, 'f> VolumePass<'a, 'r, 'f> {
    pub(crate) fn new(
        recorder: &'r mut PassRecorder<'a, 'f>,
        input: &'a FillInput,
        bindings: &'a BindGroup,
        counters: &'r mut Counters,
    ) -> Self {
        Self {
            recorder,
            input,
            bindings,
            counters,
        }
    }

    /// Cuts the following draws to the rectangle of a planned region, or with `scissor` off to the
    /// image.
    pub fn cut(&mut self, planned: usize, scissor: bool) {
        self.recorder.scissor(self.input.rect(planned, scissor));
    }

    /// Drops fragments of the following draws where the surface's depth is outside `low..=high`;
    /// for pipelines that test depth bounds.
    pub fn depth_bounds(&mut self, low: f32, high: f32) {
        self.recorder.depth_bounds(low, high);
    }

    /// Draws vertices that the shader makes up, of a planned region.
    pub fn draw(&mut self, pipeline: &'a Pipeline, vertices: u32, planned: usize) {
        self.count(vertices);
        let state = self.state(pipeline, None);
        self.recorder.draw(&state, vertices, instance(planned));
    }

    /// Draws indices, each plus `base_vertex`, of a planned region.
    pub fn draw_indexed(
        &mut self,
        pipeline: &'a Pipeline,
        geometry: Geometry<'a>,
        indices: Range<u32>,
        base_vertex: i32,
        planned: usize,
    ) {
        let count = indices.end - indices.start;
        self.count(count);
        let state = self.state(pipeline, Some(geometry));
        let (first, instance) = (indices.start, instance(planned));
        self.recorder
            .draw_indexed(&state, first, count, base_vertex, instance);
    }

    /// Covers a planned region with a picture.
    pub(crate) fn cover(&mut self, state: &CoverState<'a>, planned: usize) {
        self.count(3);
        self.recorder.cover(state, planned);
    }

    pub(crate) fn bindings(&self) -> &'a BindGroup {
        self.bindings
    }

    fn state(&self, pipeline: &'a Pipeline, geometry: Option<Geometry<'a>>) -> DrawState<'a> {
        DrawState {
            pipeline,
            bindings: self.bindings,
            geometry,
        }
    }

    fn count(&mut self, vertices: u32) {
        self.counters.draws += 1;
        self.counters.vertices += u64::from(vertices);
    }
}

/// The instance number is the index of the region's constants.
fn instance(planned: usize) -> u32 {
    u32::try_from(planned).unwrap_or(u32::MAX)
}
