// SPDX-License-Identifier: MIT OR Apache-2.0
//! The passes of a frame: volumes into the stencil, then colours over each region's rectangle.
//!
//! Depth stays as the surface left it: it is attached read-only throughout.

use crate::Layout;
use crate::backend::{SceneBuffers, VertexBackend, ViewBuffers};
use crate::layout::RegionSlice;
use crate::pipeline::{Part, StencilRule};
use crate::statistics::Statistics;
use terrafill_frame::{Counters, FrameInput};
use terrafill_gpu::{Stage, TimedPass};

/// Records the passes of one frame and counts what it records.
pub(crate) struct Recorder<'a> {
    pub(crate) backend: &'a VertexBackend,
    pub(crate) scene: &'a SceneBuffers,
    pub(crate) view: &'a ViewBuffers,
    pub(crate) stage: &'a Stage,
    pub(crate) input: &'a FrameInput,
    pub(crate) timed: bool,
    pub(crate) statistics: Option<&'a Statistics>,
    pub(crate) counters: Counters,
}

impl Recorder<'_> {
    /// Numbers first, colours afterwards.
    pub(crate) fn xor(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let passes = &self.view.batches.passes;
        let last = passes.len().saturating_sub(1);
        for (index, classes) in passes.iter().enumerate() {
            let depth_stencil = self.stage.depth_stencil_view();
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("stencil"),
                color_attachments: &[],
                depth_stencil_attachment: Some(read_only_depth(
                    &depth_stencil,
                    wgpu::LoadOp::Clear(0),
                )),
                timestamp_writes: self.stamps(TimedPass::Stencil, index == 0),
                ..Default::default()
            });
            let query = self.begin_statistics(&mut pass, 2 * index);
            self.bind_frame(&mut pass);
            for (number, regions) in numbered(classes) {
                self.volumes(&mut pass, regions, StencilRule::Xor(number));
            }
            end_statistics(&mut pass, query);
            drop(pass);

            let colour = self.stage.colour_view();
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("colour"),
                color_attachments: &[Some(kept_colour(&colour))],
                depth_stencil_attachment: Some(read_only_depth(&depth_stencil, wgpu::LoadOp::Load)),
                timestamp_writes: self.stamps(TimedPass::Colour, index == last),
                ..Default::default()
            });
            let query = self.begin_statistics(&mut pass, 2 * index + 1);
            pass.set_pipeline(&self.backend.pipelines.cover);
            self.bind_frame(&mut pass);
            for (number, regions) in numbered(classes) {
                pass.set_stencil_reference(u32::from(number));
                for &planned in regions {
                    self.cover(&mut pass, planned);
                }
            }
            end_statistics(&mut pass, query);
        }
    }

    /// One region after the other.
    pub(crate) fn rectangles(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let (colour, depth_stencil) = (self.stage.colour_view(), self.stage.depth_stencil_view());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("stencil and colour"),
            color_attachments: &[Some(kept_colour(&colour))],
            depth_stencil_attachment: Some(read_only_depth(&depth_stencil, wgpu::LoadOp::Clear(0))),
            timestamp_writes: self.stamps(TimedPass::Colour, true),
            ..Default::default()
        });
        let query = self.begin_statistics(&mut pass, 0);
        self.bind_frame(&mut pass);
        for planned in 0..self.input.plan.regions.len() {
            let rect = self.input.plan.regions[planned].screen_rect;
            pass.set_scissor_rect(rect.left, rect.top, rect.width(), rect.height());
            self.volumes(&mut pass, &[planned], StencilRule::Count);
            pass.set_pipeline(&self.backend.pipelines.cover);
            self.cover(&mut pass, planned);
        }
        end_statistics(&mut pass, query);
    }

    fn stamps(&self, pass: TimedPass, wanted: bool) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let timer = self.stage.timer().filter(|_| self.timed && wanted)?;
        Some(timer.around(pass))
    }

    fn begin_statistics(&self, pass: &mut wgpu::RenderPass<'_>, index: usize) -> Option<u32> {
        let statistics = self.statistics?;
        let index = u32::try_from(index).ok()?;
        pass.begin_pipeline_statistics_query(&statistics.queries, index);
        Some(index)
    }

    fn bind_frame(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_bind_group(0, &self.view.bind_group, &[]);
        if self.backend.variant.layout == Layout::Doubled {
            pass.set_vertex_buffer(0, self.scene.vertices.slice(..));
        }
    }

    /// Caps of all `regions`, then walls of all, so that pipelines change seldom.
    fn volumes(&mut self, pass: &mut wgpu::RenderPass<'_>, regions: &[usize], rule: StencilRule) {
        for short_indices in [true, false] {
            for part in [Part::Caps, Part::Walls { short_indices }] {
                let mut is_bound = false;
                for &planned in regions {
                    let slice = self.scene.regions[self.input.plan.regions[planned].mesh];
                    if slice.short_indices != short_indices {
                        continue;
                    }
                    if !is_bound {
                        self.bind_part(pass, part, rule, short_indices);
                        is_bound = true;
                    }
                    self.draw_part(pass, part, planned, &slice);
                }
            }
        }
    }

    fn bind_part(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        part: Part,
        rule: StencilRule,
        short_indices: bool,
    ) {
        if let Some(pipeline) = self.backend.pipelines.volume(part, rule) {
            pass.set_pipeline(pipeline);
        }
        if let Some(pulled) = &self.scene.pulled {
            pass.set_bind_group(1, &pulled[usize::from(!short_indices)], &[]);
        } else if short_indices {
            let indices = self.scene.short_indices.slice(..);
            pass.set_index_buffer(indices, wgpu::IndexFormat::Uint16);
        } else {
            let indices = self.scene.long_indices.slice(..);
            pass.set_index_buffer(indices, wgpu::IndexFormat::Uint32);
        }
    }

    fn draw_part(
        &mut self,
        pass: &mut wgpu::RenderPass<'_>,
        part: Part,
        planned: usize,
        slice: &RegionSlice,
    ) {
        let instance = instance(planned);
        let vertices = if self.scene.pulled.is_some() {
            let count = match part {
                Part::Caps => 6 * slice.triangle_count,
                // Entry e needs entry e + 1; the last one is a separator.
                Part::Walls { .. } => 6 * slice.loop_index_count.saturating_sub(1),
            };
            pass.draw(0..count, instance);
            count
        } else {
            let (first, count) = match part {
                Part::Caps => (slice.first_triangle_index, 6 * slice.triangle_count),
                Part::Walls { .. } => (slice.first_loop_index, slice.loop_index_count),
            };
            let base_vertex = i32::try_from(slice.first_vertex).unwrap_or(i32::MAX);
            pass.draw_indexed(first..first + count, base_vertex, instance);
            count
        };
        self.counters.draws += 1;
        self.counters.vertices += u64::from(vertices);
    }

    fn cover(&mut self, pass: &mut wgpu::RenderPass<'_>, planned: usize) {
        let rect = self.input.plan.regions[planned].screen_rect;
        pass.set_scissor_rect(rect.left, rect.top, rect.width(), rect.height());
        pass.draw(0..3, instance(planned));
        self.counters.draws += 1;
        self.counters.vertices += 3;
    }
}

/// The instance number is the index of the region's constants.
fn instance(planned: usize) -> std::ops::Range<u32> {
    let first = u32::try_from(planned).unwrap_or(u32::MAX - 1);
    first..first + 1
}

fn end_statistics(pass: &mut wgpu::RenderPass<'_>, query: Option<u32>) {
    if query.is_some() {
        pass.end_pipeline_statistics_query();
    }
}

fn read_only_depth(
    view: &wgpu::TextureView,
    stencil: wgpu::LoadOp<u32>,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: None,
        stencil_ops: Some(wgpu::Operations {
            load: stencil,
            store: wgpu::StoreOp::Store,
        }),
    }
}

fn kept_colour(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: wgpu::LoadOp::Load,
            store: wgpu::StoreOp::Store,
        },
    }
}

/// A pass's classes with their numbers, from 1.
pub(crate) fn numbered(pass: &Vec<Vec<usize>>) -> impl Iterator<Item = (u8, &Vec<usize>)> {
    (1..=u8::MAX).zip(pass)
}
