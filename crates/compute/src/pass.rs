// SPDX-License-Identifier: MIT OR Apache-2.0
//! Records a frame: the compute pass that makes volumes, then the fill program's passes.
//!
//! Depth stays as the surface left it: it is attached read-only throughout.

use crate::backend::{ComputeBackend, Expanded, SceneBuffers, ViewBuffers};
use crate::culling::DRAW_ARGUMENTS_BYTES;
use crate::expansion::{OutputSlice, WORKGROUP_SIZE};
use crate::pipeline::State;
use crate::statistics::Statistics;
use terrafill_frame::{
    Counters, CoverShape, FaceSet, FillCommand, FillPass, FillProgram, FrameInput,
};
use terrafill_gpu::{Stage, TimedPass};
use terrafill_scene::PixelRect;

/// Records the passes of one frame and counts what it records.
pub(crate) struct Recorder<'a> {
    pub(crate) backend: &'a ComputeBackend,
    pub(crate) scene: &'a SceneBuffers,
    pub(crate) view: &'a ViewBuffers,
    pub(crate) stage: &'a Stage,
    pub(crate) input: &'a FrameInput,
    pub(crate) timed: bool,
    pub(crate) statistics: Option<&'a Statistics>,
    pub(crate) counters: Counters,
    /// Draws whose size the device decided: indices into the list of their arguments.
    pub(crate) indirect_draws: Vec<usize>,
}

impl Recorder<'_> {
    /// The whole frame.
    pub(crate) fn frame(&mut self, encoder: &mut wgpu::CommandEncoder) {
        if self.view.program.passes.is_empty() {
            return;
        }
        if self.view.computes() {
            self.volumes_made(encoder);
        }
        self.fill(encoder);
    }

    /// Decides what is drawn, then makes it.
    fn volumes_made(&self, encoder: &mut wgpu::CommandEncoder) {
        let passes = self.view.program.passes.len();
        let stamps = self.stage.timer().filter(|_| self.timed).map(|timer| {
            // With one pass to come the slot is free; otherwise the first pass ends it.
            let end = (passes == 1).then_some(TimedPass::Stencil);
            let writes = timer.writes(Some(TimedPass::Stencil), end);
            wgpu::ComputePassTimestampWrites {
                query_set: writes.query_set,
                beginning_of_pass_write_index: writes.beginning_of_pass_write_index,
                end_of_pass_write_index: writes.end_of_pass_write_index,
            }
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("expansion"),
            timestamp_writes: stamps,
        });
        let pipelines = &self.backend.pipelines;
        pass.set_bind_group(0, &self.view.bind_group, &[]);
        pass.set_bind_group(1, &self.scene.bind_group, &[]);
        if let (Some(placed), Some(pipeline)) = (&self.view.placed, &pipelines.place) {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(2, &placed.bind_group, &[]);
            let [columns, rows] = placed.dispatch_size;
            pass.dispatch_workgroups(columns, rows, 1);
        }
        if let Some(expanded) = self.expanded() {
            pass.set_bind_group(2, &expanded.bind_group, &[]);
        }
        if let (Some(culling), Some(pipeline)) = (&self.view.culling, &pipelines.cull) {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(3, &culling.bind_group, &[]);
            let regions = self.input.plan.regions.len().div_ceil(WORKGROUP_SIZE);
            pass.dispatch_workgroups(u32::try_from(regions).unwrap_or(u32::MAX), 1, 1);
        }
        if let Some(expanded) = &self.view.expanded {
            pass.set_pipeline(&pipelines.expand);
            let [columns, rows] = expanded.dispatch_size;
            pass.dispatch_workgroups(columns, rows, 1);
        }
    }

    fn fill(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let passes = &self.view.program.passes;
        let (colour, depth_stencil) = (self.stage.colour_view(), self.stage.depth_stencil_view());
        for (index, steps) in passes.iter().enumerate() {
            let numbers = self.view.numbers.as_ref();
            let numbers = numbers.filter(|_| steps.accumulates());
            let target = match numbers {
                Some(numbers) => Some(zeroed(&numbers.target)),
                None => steps.has_colour.then(|| kept_colour(&colour)),
            };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(if steps.has_colour {
                    "colour"
                } else {
                    "volumes"
                }),
                color_attachments: if target.is_some() {
                    std::slice::from_ref(&target)
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
    /// fragment of theirs and not only those that the depth test lets through. They are there: the
    /// frame before has made them.
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
            self.bind_volumes(&mut pass, State::Count { faces });
            for &planned in regions {
                let rect = if scissor {
                    self.input.plan.regions[planned].screen_rect
                } else {
                    full
                };
                pass.set_scissor_rect(rect.left, rect.top, rect.width(), rect.height());
                self.draw_volume(&mut pass, planned, without_bottom);
            }
        }
        if query.is_some() {
            pass.end_pipeline_statistics_query();
        }
    }

    fn bind_geometry(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_bind_group(0, &self.view.bind_group, &[]);
        pass.set_bind_group(1, &self.scene.bind_group, &[]);
        if let Some(placed) = &self.view.placed {
            pass.set_vertex_buffer(0, placed.corners.slice(..));
        }
        if let Some(expanded) = self.expanded() {
            pass.set_index_buffer(expanded.indices.slice(..), wgpu::IndexFormat::Uint32);
        }
    }

    /// The list of volumes, whoever made it.
    fn expanded(&self) -> Option<&Expanded> {
        self.view.expanded.as_ref().or(self.scene.expanded.as_ref())
    }

    fn output(&self, planned: usize) -> OutputSlice {
        match &self.scene.expanded {
            Some(cached) => cached.outputs[self.input.plan.regions[planned].mesh],
            None => self.view.outputs()[planned],
        }
    }

    /// The last pass is stamped as colour; of several, the first as stencil. A compute pass before
    /// them has begun that slot.
    fn stamps(&self, index: usize, count: usize) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let timer = self.stage.timer().filter(|_| self.timed)?;
        match index {
            _ if index + 1 == count => Some(timer.around(TimedPass::Colour)),
            0 if self.view.computes() => Some(timer.writes(None, Some(TimedPass::Stencil))),
            0 => Some(timer.around(TimedPass::Stencil)),
            _ => None,
        }
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
        let rect_of = |planned: usize| self.input.plan.regions[planned].screen_rect;
        for command in &steps.commands {
            match command {
                FillCommand::Volumes {
                    rule,
                    without_bottom,
                    scissor,
                    regions,
                } => {
                    self.bind_volumes(
                        pass,
                        State::Mark {
                            rule: *rule,
                            has_colour: steps.has_colour,
                        },
                    );
                    for &planned in regions {
                        cut(pass, if *scissor { rect_of(planned) } else { full });
                        self.draw_volume(pass, planned, *without_bottom);
                    }
                }
                FillCommand::Accumulate {
                    depth,
                    faces,
                    without_bottom,
                    scissor,
                    regions,
                } => {
                    self.bind_volumes(
                        pass,
                        State::Number {
                            depth: *depth,
                            faces: *faces,
                        },
                    );
                    for &planned in regions {
                        cut(pass, if *scissor { rect_of(planned) } else { full });
                        self.draw_volume(pass, planned, *without_bottom);
                    }
                }
                FillCommand::Resolve => {
                    cut(pass, full);
                    self.resolve(pass);
                }
                FillCommand::Cover {
                    test,
                    shape: CoverShape::Volume { faces },
                    regions,
                } => {
                    self.bind_volumes(
                        pass,
                        State::Colour {
                            test: *test,
                            faces: *faces,
                        },
                    );
                    cut(pass, full);
                    for &planned in regions {
                        self.draw_volume(pass, planned, false);
                    }
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
                        let is_rectangle = *shape == CoverShape::Rectangle;
                        cut(pass, if is_rectangle { rect_of(planned) } else { full });
                        pass.draw(0..3, instance(planned));
                        self.counters.draws += 1;
                        self.counters.vertices += 3;
                    }
                }
            }
        }
    }

    fn bind_volumes(&self, pass: &mut wgpu::RenderPass<'_>, state: State) {
        if let Some(pipeline) = self.backend.pipelines.volume(state) {
            pass.set_pipeline(pipeline);
        }
        if let State::Colour { test, .. } = state {
            pass.set_stencil_reference(u32::from(test.reference));
        }
    }

    fn resolve(&mut self, pass: &mut wgpu::RenderPass<'_>) {
        let (Some(pipeline), Some(numbers)) =
            (self.backend.pipelines.resolve(), &self.view.numbers)
        else {
            return;
        };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(1, &numbers.bind_group, &[]);
        pass.draw(0..3, 0..1);
        self.counters.draws += 1;
        self.counters.vertices += 3;
    }

    /// One draw a volume: its triangles lie in one piece. Where the device decided what is drawn,
    /// it is asked how much that is.
    fn draw_volume(
        &mut self,
        pass: &mut wgpu::RenderPass<'_>,
        planned: usize,
        without_bottom: bool,
    ) {
        self.counters.draws += 1;
        if let Some(culling) = &self.view.culling {
            let draw = 2 * planned + usize::from(without_bottom);
            pass.draw_indexed_indirect(&culling.draws, draw as u64 * DRAW_ARGUMENTS_BYTES);
            self.indirect_draws.push(draw);
            return;
        }
        let output = self.output(planned);
        let end = output.first_index + output.bottom_count + output.upper_count;
        let first = if without_bottom {
            output.first_index + output.bottom_count
        } else {
            output.first_index
        };
        pass.draw_indexed(
            first..end,
            self.view.base_vertex(planned),
            instance(planned),
        );
        self.counters.vertices += u64::from(end - first);
    }
}

/// What the stencil work of a program draws: faces, whether without bottom caps, whether cut to
/// rectangles, and which regions.
pub(crate) fn counted(
    program: &FillProgram,
) -> impl Iterator<Item = (FaceSet, bool, bool, &[usize])> {
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

/// A target whose sums start at 0.
fn zeroed(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
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
