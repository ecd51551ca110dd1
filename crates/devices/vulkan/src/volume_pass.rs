// SPDX-License-Identifier: MIT OR Apache-2.0
//! One pass of a stencil program while it is recorded: draws are counted, and cut to their volume's
//! rectangle.

use crate::{BindGroup, Buffer, CoverState, DrawState, Geometry, PassRecorder, Pipeline};
use std::ops::Range;
use terrafill_contract::Counters;
use terrafill_stencil::VolumeList;

/// A pass and what was drawn in it. Whatever is drawn with outlives `'a`, and thereby the fill.
pub struct VolumePass<'a, 'r, 'f> {
    recorder: &'r mut PassRecorder<'a, 'f>,
    /// What is drawn.
    pub list: &'a VolumeList,
    /// View and volumes' constants.
    bindings: &'a BindGroup,
    counters: &'r mut Counters,
}

impl<'a, 'r, 'f> VolumePass<'a, 'r, 'f> {
    pub(crate) fn new(
        recorder: &'r mut PassRecorder<'a, 'f>,
        list: &'a VolumeList,
        bindings: &'a BindGroup,
        counters: &'r mut Counters,
    ) -> Self {
        Self {
            recorder,
            list,
            bindings,
            counters,
        }
    }

    /// Cuts the following draws to the rectangle of a volume, or with `scissor` off to the image.
    pub fn cut(&mut self, volume: usize, scissor: bool) {
        self.recorder.scissor(self.list.rect(volume, scissor));
    }

    /// Gives all fragments of the following draws the sky's depth, 0, or with `is_at_sky` off their own.
    pub(crate) fn at_sky(&mut self, is_at_sky: bool) {
        self.recorder.at_sky(is_at_sky);
    }

    /// Drops fragments of the following draws where the surface's depth is outside `low..=high`;
    /// for pipelines that test depth bounds.
    pub fn depth_bounds(&mut self, low: f32, high: f32) {
        self.recorder.depth_bounds(low, high);
    }

    /// Draws vertices that the shader makes up, of a volume.
    pub fn draw(&mut self, pipeline: &'a Pipeline, vertices: u32, volume: usize) {
        self.count(vertices);
        let state = self.state(pipeline, None);
        self.recorder.draw(&state, vertices, instance(volume));
    }

    /// Draws indices, each plus `base_vertex`, of a volume.
    pub fn draw_indexed(
        &mut self,
        pipeline: &'a Pipeline,
        geometry: Geometry<'a>,
        indices: Range<u32>,
        base_vertex: i32,
        volume: usize,
    ) {
        let count = indices.end - indices.start;
        self.count(count);
        let state = self.state(pipeline, Some(geometry));
        let (first, instance) = (indices.start, instance(volume));
        self.recorder
            .draw_indexed(&state, first, count, base_vertex, instance);
    }

    /// Draws what commands say, by number, each of a volume.
    ///
    /// - `vertices`: of all of them
    pub fn draw_listed(
        &mut self,
        pipeline: &'a Pipeline,
        geometry: Geometry<'a>,
        list: &'a Buffer,
        (numbers, vertices): (Range<u32>, u64),
    ) {
        self.counters.draws += 1;
        self.counters.vertices += vertices;
        let state = self.state(pipeline, Some(geometry));
        self.recorder.draw_listed(&state, list, numbers);
    }

    /// Draws `corners` vertices for each of `covers`, which are read from `buffer`.
    pub(crate) fn draw_covers(
        &mut self,
        pipeline: &'a Pipeline,
        buffer: &'a Buffer,
        corners: u32,
        covers: Range<u32>,
    ) {
        self.count(corners * (covers.end - covers.start));
        let state = self.state(pipeline, None);
        self.recorder
            .draw_instances(&state, buffer, corners, covers);
    }

    /// Covers a volume with a picture.
    pub(crate) fn cover(&mut self, state: &CoverState<'a>, volume: usize) {
        self.count(3);
        self.recorder.cover(state, volume);
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

/// The instance number is the index of the volume's constants.
fn instance(volume: usize) -> u32 {
    u32::try_from(volume).unwrap_or(u32::MAX)
}
