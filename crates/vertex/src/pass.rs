// SPDX-License-Identifier: MIT OR Apache-2.0
//! Records a fill program's passes on wgpu.
//!
//! Depth stays as the surface left it: it is attached read-only throughout.

use crate::backend::{SceneBuffers, VertexBackend, ViewBuffers};
use crate::pipeline::{Part, PipelineKey, State, parts};
use crate::statistics::Statistics;
use terrafill_frame::{
    Counters, CoverShape, FaceSet, FillCommand, FillPass, FillProgram, FrameInput,
};
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
    /// Covers are blended over what lies under them.
    pub(crate) blends: bool,
    pub(crate) counters: Counters,
}

impl Recorder<'_> {
    /// All passes.
    pub(crate) fn fill(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let passes = &self.view.program.passes;
        let (colour, depth_stencil) = (self.stage.colour_view(), self.stage.depth_stencil_view());
        for (index, steps) in passes.iter().enumerate() {
            let colour_target = match &self.view.numbers {
                Some(numbers) if steps.accumulates() => Some(cleared_numbers(&numbers.view)),
                _ => steps.has_colour.then(|| kept_colour(&colour)),
            };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(if steps.has_colour {
                    "colour"
                } else {
                    "stencil"
                }),
                color_attachments: if colour_target.is_some() {
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
            self.bind_geometry(&mut pass);
            self.steps(&mut pass, steps);
            if query.is_some() {
                pass.end_pipeline_statistics_query();
            }
        }
    }

    /// The volumes that the stencil work draws, drawn into nothing, so that the query counts every
    /// fragment of theirs and not only those that the depth test lets through.
    pub(crate) fn count_fragments(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let (colour, depth_stencil) = (self.stage.colour_view(), self.stage.depth_stencil_view());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("fragment count"),
            color_attachments: &[Some(kept_colour(&colour))],
            depth_stencil_attachment: Some(read_only_depth(&depth_stencil, wgpu::LoadOp::Load)),
            ..Default::default()
        });
        let query = self.begin_statistics(&mut pass, 0);
        self.bind_geometry(&mut pass);
        let full = PixelRect::full(self.input.size);
        for (faces, without_bottom, scissor, regions) in counted(&self.view.program) {
            let rect_of = |planned: usize| {
                let rect = self.input.plan.regions[planned].screen_rect;
                if scissor { rect } else { full }
            };
            let state = State::Count { faces };
            self.volumes(
                &mut pass,
                regions,
                state,
                without_bottom,
                |pass, planned| {
                    let rect = rect_of(planned);
                    pass.set_scissor_rect(rect.left, rect.top, rect.width(), rect.height());
                },
            );
        }
        if query.is_some() {
            pass.end_pipeline_statistics_query();
        }
    }

    fn bind_geometry(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_bind_group(0, &self.view.bind_group, &[]);
        if self.scene.pulled.is_none() {
            pass.set_vertex_buffer(0, self.scene.vertices.slice(..));
        }
        if let Some(flags) = &self.scene.flags {
            pass.set_vertex_buffer(1, flags.slice(..));
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
                FillCommand::Accumulate {
                    depth,
                    faces,
                    without_bottom,
                    scissor,
                    regions,
                } => {
                    let state = State::Add {
                        depth: *depth,
                        faces: *faces,
                    };
                    self.volumes(pass, regions, state, *without_bottom, |pass, planned| {
                        let rect = self.input.plan.regions[planned].screen_rect;
                        cut(pass, if *scissor { rect } else { full });
                    });
                }
                FillCommand::Resolve => {
                    if let Some(pipeline) = self.backend.pipelines.resolve() {
                        pass.set_pipeline(pipeline);
                    }
                    if let Some(numbers) = &self.view.numbers {
                        pass.set_bind_group(1, &numbers.bind_group, &[]);
                    }
                    cut(pass, full);
                    pass.draw(0..3, 0..1);
                    self.counters.draws += 1;
                    self.counters.vertices += 3;
                }
                FillCommand::Cover {
                    test,
                    shape: CoverShape::Volume { faces },
                    regions,
                } => {
                    let state = State::Colour {
                        test: *test,
                        faces: *faces,
                        blends: self.blends,
                    };
                    self.volumes(pass, regions, state, false, |pass, _| cut(pass, full));
                }
                FillCommand::Cover {
                    test,
                    shape,
                    regions,
                } => {
                    if let Some(pipeline) = self.backend.pipelines.cover(*test, self.blends) {
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
            let base_vertex = if self.scene.flags.is_some() {
                // Every region starts at the first flag, so its positions must start there too.
                let stride = 4 * self.backend.variant.vertex_words() as u64;
                let first_byte = u64::from(slice.first_vertex) * stride;
                pass.set_vertex_buffer(0, self.scene.vertices.slice(first_byte..));
                0
            } else {
                i32::try_from(slice.first_vertex).unwrap_or(i32::MAX)
            };
            pass.draw_indexed(first..first + count, base_vertex, instance);
            count
        };
        self.counters.draws += 1;
        self.counters.vertices += u64::from(vertices);
    }
}

/// Faces, whether the bottom is left out, whether volumes are cut to their rectangles, and which.
pub(crate) type CountedVolumes<'a> = (FaceSet, bool, bool, &'a [usize]);

/// The volumes of a program's stencil or accumulation work.
pub(crate) fn counted(program: &FillProgram) -> impl Iterator<Item = CountedVolumes<'_>> {
    program.commands().filter_map(|command| match command {
        FillCommand::Volumes {
            rule,
            without_bottom,
            scissor,
            regions,
        } => Some((rule.faces, *without_bottom, *scissor, regions.as_slice())),
        FillCommand::Accumulate {
            faces,
            without_bottom,
            scissor,
            regions,
            ..
        } => Some((*faces, *without_bottom, *scissor, regions.as_slice())),
        FillCommand::Cover { .. } | FillCommand::Resolve => None,
    })
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

fn cleared_numbers(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
            store: wgpu::StoreOp::Store,
        },
    }
}
