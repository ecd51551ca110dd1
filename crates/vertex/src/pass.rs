// SPDX-License-Identifier: MIT OR Apache-2.0
//! Records a fill program's passes on wgpu.
//!
//! Depth stays as the surface left it: it is attached read-only throughout.

use crate::Layout;
use crate::backend::{SceneBuffers, VertexBackend, ViewBuffers};
use crate::pipeline::{Part, PipelineKey, State, parts};
use crate::statistics::Statistics;
use terrafill_frame::{Counters, CoverShape, FillCommand, FillPass, FrameInput};
use terrafill_gpu::{Stage, TimedPass};
use terrafill_scene::PixelRect;

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
    /// All passes.
    pub(crate) fn fill(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let passes = &self.view.program.passes;
        let (colour, depth_stencil) = (self.stage.colour_view(), self.stage.depth_stencil_view());
        for (index, steps) in passes.iter().enumerate() {
            let colour_target = steps.has_colour.then(|| kept_colour(&colour));
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(if steps.has_colour {
                    "colour"
                } else {
                    "stencil"
                }),
                color_attachments: if steps.has_colour {
                    std::slice::from_ref(&colour_target)
                } else {
                    &[]
                },
                depth_stencil_attachment: Some(read_only_depth(
                    &depth_stencil,
                    if steps.clears_stencil {
                        wgpu::LoadOp::Clear(0)
                    } else {
                        wgpu::LoadOp::Load
                    },
                )),
                timestamp_writes: self.stamps(index, passes.len()),
                ..Default::default()
            });
            let query = self.begin_statistics(&mut pass, index);
            pass.set_bind_group(0, &self.view.bind_group, &[]);
            if self.backend.variant.layout == Layout::Doubled {
                pass.set_vertex_buffer(0, self.scene.vertices.slice(..));
            }
            self.steps(&mut pass, steps);
            if query.is_some() {
                pass.end_pipeline_statistics_query();
            }
        }
    }

    /// One pass is stamped as colour; of several, the first as stencil and the last as colour.
    fn stamps(&self, index: usize, count: usize) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let timer = self.stage.timer().filter(|_| self.timed)?;
        let slot = match index {
            _ if index + 1 == count => TimedPass::Colour,
            0 => TimedPass::Stencil,
            _ => return None,
        };
        Some(timer.around(slot))
    }

    fn begin_statistics(&self, pass: &mut wgpu::RenderPass<'_>, index: usize) -> Option<u32> {
        let statistics = self.statistics?;
        let index = u32::try_from(index).ok()?;
        pass.begin_pipeline_statistics_query(&statistics.queries, index);
        Some(index)
    }

    fn steps(&mut self, pass: &mut wgpu::RenderPass<'_>, steps: &FillPass) {
        let full = PixelRect::full(self.input.size);
        let mut scissor = full;
        let mut cut = |pass: &mut wgpu::RenderPass<'_>, rect: PixelRect| {
            if rect != scissor {
                pass.set_scissor_rect(rect.left, rect.top, rect.width(), rect.height());
                scissor = rect;
            }
        };
        for command in &steps.commands {
            match command {
                FillCommand::Volumes {
                    rule,
                    without_bottom,
                    scissor,
                    regions,
                } => {
                    let state = State::Mark {
                        rule: *rule,
                        has_colour: steps.has_colour,
                    };
                    let rect_of = |planned: usize| {
                        if *scissor {
                            self.input.plan.regions[planned].screen_rect
                        } else {
                            full
                        }
                    };
                    self.volumes(pass, regions, state, *without_bottom, |pass, planned| {
                        cut(pass, rect_of(planned));
                    });
                }
                FillCommand::Cover {
                    test,
                    shape: CoverShape::Volume { faces },
                    regions,
                } => {
                    let state = State::Colour {
                        test: *test,
                        faces: *faces,
                    };
                    self.volumes(pass, regions, state, false, |pass, _| cut(pass, full));
                }
                FillCommand::Cover {
                    test,
                    shape,
                    regions,
                } => {
                    if let Some(pipeline) = self.backend.pipelines.cover(*test) {
                        pass.set_pipeline(pipeline);
                    }
                    pass.set_stencil_reference(u32::from(test.reference));
                    for &planned in regions {
                        let rect = match shape {
                            CoverShape::Rectangle => self.input.plan.regions[planned].screen_rect,
                            _ => full,
                        };
                        cut(pass, rect);
                        pass.draw(0..3, instance(planned));
                        self.counters.draws += 1;
                        self.counters.vertices += 3;
                    }
                }
            }
        }
    }

    /// Caps of all `regions`, then walls of all, so that pipelines change seldom. `before` runs
    /// before each region's draw.
    fn volumes(
        &mut self,
        pass: &mut wgpu::RenderPass<'_>,
        regions: &[usize],
        state: State,
        without_bottom: bool,
        mut before: impl FnMut(&mut wgpu::RenderPass<'_>, usize),
    ) {
        for short_indices in [true, false] {
            for part in parts(short_indices) {
                let mut is_bound = false;
                for &planned in regions {
                    let mesh = self.input.plan.regions[planned].mesh;
                    if self.scene.regions[mesh].short_indices != short_indices {
                        continue;
                    }
                    if !is_bound {
                        self.bind_part(pass, PipelineKey { part, state }, short_indices);
                        is_bound = true;
                    }
                    before(pass, planned);
                    self.draw_part(pass, part, planned, without_bottom);
                }
            }
        }
    }

    fn bind_part(&self, pass: &mut wgpu::RenderPass<'_>, key: PipelineKey, short_indices: bool) {
        if let Some(pipeline) = self.backend.pipelines.volume(key) {
            pass.set_pipeline(pipeline);
        }
        if let State::Colour { test, .. } = key.state {
            pass.set_stencil_reference(u32::from(test.reference));
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
        without_bottom: bool,
    ) {
        let slice = &self.scene.regions[self.input.plan.regions[planned].mesh];
        let instance = instance(planned);
        let caps = if without_bottom { 3 } else { 6 } * slice.triangle_count;
        let vertices = if self.scene.pulled.is_some() {
            let count = match part {
                Part::Caps => caps,
                // Entry e needs entry e + 1; the last one is a separator.
                Part::Walls { .. } => 6 * slice.loop_index_count.saturating_sub(1),
            };
            pass.draw(0..count, instance);
            count
        } else {
            let (first, count) = match part {
                Part::Caps => (slice.first_triangle_index, caps),
                Part::Walls { .. } => (slice.first_loop_index, slice.loop_index_count),
            };
            let base_vertex = i32::try_from(slice.first_vertex).unwrap_or(i32::MAX);
            pass.draw_indexed(first..first + count, base_vertex, instance);
            count
        };
        self.counters.draws += 1;
        self.counters.vertices += u64::from(vertices);
    }
}

/// The instance number is the index of the region's constants.
fn instance(planned: usize) -> std::ops::Range<u32> {
    let first = u32::try_from(planned).unwrap_or(u32::MAX - 1);
    first..first + 1
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
