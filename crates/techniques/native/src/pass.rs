// SPDX-License-Identifier: MIT OR Apache-2.0
//! Records a fill program's passes on Vulkan.

use crate::backend::{Pipelines, SceneBuffers, ViewBuffers};
use crate::extrusion::{Extrusion, Part, cover_pipeline};
use crate::textured::{Purpose, Textured};
use crate::{NativeVariant, depth_range};
use terrafill_fill::{
    Counters, FaceSet, FillStep, FrameInput, StencilTest, VolumeDraw, VolumeState,
};
use terrafill_vulkan::{
    BindGroup, DrawState, FillRecorder, Geometry, IndexWidth, PassRecorder, Pipeline,
    PipelineDescriptor, PipelineState, Probe,
};

/// Widths of indices, short ones first.
const WIDTHS: [IndexWidth; 2] = [IndexWidth::Short, IndexWidth::Long];

/// The pipelines that draw volumes in one state.
fn volume_pipelines(
    variant: NativeVariant,
    state: VolumeState,
    without_bottom: bool,
) -> impl Iterator<Item = (Part, PipelineDescriptor)> {
    let technique = variant.technique;
    technique.parts().iter().map(move |&part| {
        let (indices, depth_bounds) = (variant.indices(), variant.switches.depth_bounds);
        let pipeline =
            technique.volume_pipeline(part, indices, state, without_bottom, depth_bounds);
        (part, pipeline)
    })
}

/// The state of a triangle over the screen; `None` for volumes.
fn cover_state(step: &FillStep<'_>) -> Option<PipelineState> {
    match step {
        FillStep::Volumes(_) => None,
        FillStep::Cover { test, .. } => Some(PipelineState::Colour {
            test: *test,
            faces: FaceSet::Both,
        }),
        FillStep::Resolve => Some(PipelineState::Resolve),
    }
}

/// Every pipeline that a step is drawn with.
pub(crate) fn pipelines_of(variant: NativeVariant, step: &FillStep<'_>) -> Vec<PipelineDescriptor> {
    match step {
        FillStep::Volumes(draw) => volume_pipelines(variant, draw.state, draw.without_bottom)
            .map(|(_, pipeline)| pipeline)
            .collect(),
        _ => cover_state(step).map(cover_pipeline).into_iter().collect(),
    }
}

/// What is drawn from, for one view of one scene.
#[derive(Clone, Copy)]
pub(crate) struct Drawing<'a> {
    pub(crate) variant: NativeVariant,
    pub(crate) pipelines: &'a Pipelines,
    pub(crate) textured: Option<&'a Textured>,
    /// Textured covers write where their texels came from into this instead of colours.
    pub(crate) probe: Option<&'a Probe>,
    pub(crate) scene: &'a SceneBuffers,
    pub(crate) view: &'a ViewBuffers,
    pub(crate) input: &'a FrameInput,
}

impl<'a> Drawing<'a> {
    /// All passes.
    pub(crate) fn fill(&self, recorder: &mut FillRecorder<'a>, counters: &mut Counters) {
        for pass in &self.view.program.passes {
            let mut steps = |recorder: &mut PassRecorder<'a, '_>| {
                for step in pass.steps() {
                    self.step(recorder, &step, counters);
                }
            };
            if pass.accumulates() {
                recorder.accumulate(|recorder| steps(recorder));
            } else if pass.has_colour && self.textured.is_some() {
                // Depth is read in this pass, which holds covers only and writes no stencil.
                match self.probe {
                    Some(probe) => recorder.probe(probe, |recorder| steps(recorder)),
                    None => recorder.textured(|recorder| steps(recorder)),
                }
            } else {
                recorder.pass(pass.clears_stencil, pass.has_colour, |recorder| {
                    steps(recorder)
                });
            }
        }
    }

    /// The volumes of all steps that mark, in one pass that only counts their fragments.
    pub(crate) fn count_fragments(&self, recorder: &mut FillRecorder<'a>) {
        recorder.pass(false, false, |recorder| {
            for draw in self.view.program.counted() {
                self.volumes(recorder, &draw, &mut Counters::default());
            }
        });
    }

    fn step(&self, pass: &mut PassRecorder<'a, '_>, step: &FillStep<'_>, counters: &mut Counters) {
        if let (
            Some(textured),
            FillStep::Cover {
                test,
                scissor,
                regions,
            },
        ) = (self.textured, step)
        {
            self.textured_covers(pass, textured, *test, *scissor, regions, counters);
            return;
        }
        let pipeline = cover_state(step).map(cover_pipeline);
        let pipeline = pipeline.and_then(|key| self.pipelines.get(&key));
        match (step, pipeline) {
            (FillStep::Volumes(draw), _) => self.volumes(pass, draw, counters),
            (
                FillStep::Cover {
                    scissor, regions, ..
                },
                Some(pipeline),
            ) => self.covers(pass, pipeline, *scissor, regions, counters),
            (FillStep::Resolve, Some(pipeline)) => {
                self.covers(pass, pipeline, false, &[0], counters);
            }
            (FillStep::Cover { .. } | FillStep::Resolve, None) => {}
        }
    }

    fn volumes(
        &self,
        pass: &mut PassRecorder<'a, '_>,
        draw: &VolumeDraw<'_>,
        counters: &mut Counters,
    ) {
        for width in WIDTHS {
            for (part, key) in volume_pipelines(self.variant, draw.state, draw.without_bottom) {
                let Some(pipeline) = self.pipelines.get(&key) else {
                    continue;
                };
                let drawn = draw.regions.iter().copied();
                for planned in drawn.filter(|&planned| self.width(planned) == width) {
                    pass.scissor(self.input.rect(planned, draw.scissor));
                    if key.depth_bounds {
                        let range = depth_range(self.input, &self.input.plan.regions[planned]);
                        pass.depth_bounds(range.low, range.high);
                    }
                    let without = draw.without_bottom && part == Part::Caps;
                    self.part(pass, pipeline, part, planned, without, counters);
                }
            }
        }
    }

    /// A triangle over the screen for each region.
    fn covers(
        &self,
        pass: &mut PassRecorder<'a, '_>,
        pipeline: &'a Pipeline,
        scissor: bool,
        regions: &[usize],
        counters: &mut Counters,
    ) {
        let state = self.state(pipeline, None);
        for &planned in regions {
            pass.scissor(self.input.rect(planned, scissor));
            pass.draw(&state, 3, instance(planned));
            counters.draws += 1;
            counters.vertices += 3;
        }
    }

    /// The same with the picture.
    fn textured_covers(
        &self,
        pass: &mut PassRecorder<'a, '_>,
        textured: &'a Textured,
        test: StencilTest,
        scissor: bool,
        regions: &[usize],
        counters: &mut Counters,
    ) {
        let purpose = match self.probe {
            Some(_) => Purpose::Probe,
            None => Purpose::Colour,
        };
        for &planned in regions {
            if let Some(state) = textured.cover(&self.view.bindings, test, purpose, planned) {
                pass.scissor(self.input.rect(planned, scissor));
                pass.cover(&state, planned);
                counters.draws += 1;
                counters.vertices += 3;
            }
        }
    }

    fn width(&self, planned: usize) -> IndexWidth {
        let mesh = self.input.plan.regions[planned].mesh;
        if self.scene.regions[mesh].short_indices {
            IndexWidth::Short
        } else {
            IndexWidth::Long
        }
    }

    fn state(&self, pipeline: &'a Pipeline, geometry: Option<Geometry<'a>>) -> DrawState<'a> {
        let bindings: &'a BindGroup = &self.view.bindings;
        DrawState {
            pipeline,
            bindings,
            geometry,
        }
    }

    fn part(
        &self,
        pass: &mut PassRecorder<'a, '_>,
        pipeline: &'a Pipeline,
        part: Part,
        planned: usize,
        without_bottom: bool,
        counters: &mut Counters,
    ) {
        let slice = &self.scene.regions[self.input.plan.regions[planned].mesh];
        let (first, count) = match part {
            Part::Walls => (slice.first_wall_index, slice.wall_index_count),
            // The bottom's triangles are the second half; geometry shaders leave theirs out.
            Part::Caps if without_bottom && self.variant.technique == Extrusion::VsControl => {
                (slice.first_index, slice.index_count / 2)
            }
            Part::Caps | Part::Whole | Part::Turned => (slice.first_index, slice.index_count),
        };
        let width = self.width(planned);
        let geometry = Geometry {
            vertices: &self.scene.vertices,
            indices: match width {
                IndexWidth::Short => &self.scene.short_indices,
                IndexWidth::Long => &self.scene.long_indices,
            },
            width,
        };
        let state = self.state(pipeline, Some(geometry));
        let base_vertex = i32::try_from(slice.first_vertex).unwrap_or(i32::MAX);
        pass.draw_indexed(&state, first, count, base_vertex, instance(planned));
        counters.draws += 1;
        counters.vertices += u64::from(count);
    }
}

/// The instance number is the index of the region's constants.
fn instance(planned: usize) -> u32 {
    u32::try_from(planned).unwrap_or(u32::MAX)
}
