// SPDX-License-Identifier: MIT OR Apache-2.0
//! Records a fill program's passes on Vulkan.

use crate::backend::{NativeVariant, Pipelines, SceneBuffers, ViewBuffers};
use crate::depth_range;
use crate::technique::{Part, Technique, cover_pipeline};
use terrafill_frame::{Counters, CoverShape, FaceSet, FillCommand, FillProgram, FrameInput};
use terrafill_scene::PixelRect;
use terrafill_vulkan::{
    BindGroup, DrawState, FillRecorder, Geometry, IndexWidth, PassRecorder, Pipeline,
    PipelineDescriptor, PipelineState,
};

/// One step of a pass, its states made those of pipelines. Regions are indices into the plan's.
#[derive(Debug, Clone)]
pub(crate) enum Step {
    Volumes {
        state: PipelineState,
        without_bottom: bool,
        scissor: bool,
        regions: Vec<usize>,
    },
    Cover {
        pipeline: PipelineDescriptor,
        cuts_to_regions: bool,
        regions: Vec<usize>,
    },
}

/// One pass.
#[derive(Debug, Clone)]
pub(crate) struct Steps {
    pub(crate) clears_stencil: bool,
    pub(crate) has_colour: bool,
    pub(crate) accumulates: bool,
    pub(crate) steps: Vec<Step>,
}

/// A program's passes.
pub(crate) fn steps_of(program: &FillProgram) -> Vec<Steps> {
    program
        .passes
        .iter()
        .map(|pass| Steps {
            clears_stencil: pass.clears_stencil,
            has_colour: pass.has_colour,
            accumulates: pass.accumulates(),
            steps: pass
                .commands
                .iter()
                .map(|command| step_of(command, pass.has_colour))
                .collect(),
        })
        .collect()
}

fn step_of(command: &FillCommand, has_colour: bool) -> Step {
    match command {
        FillCommand::Volumes {
            rule,
            without_bottom,
            scissor,
            regions,
        } => Step::Volumes {
            state: PipelineState::Mark {
                rule: *rule,
                has_colour,
            },
            without_bottom: *without_bottom,
            scissor: *scissor,
            regions: regions.clone(),
        },
        FillCommand::Cover {
            test,
            shape: CoverShape::Volume { faces },
            regions,
        } => Step::Volumes {
            state: PipelineState::Colour {
                test: *test,
                faces: *faces,
            },
            without_bottom: false,
            scissor: false,
            regions: regions.clone(),
        },
        FillCommand::Cover {
            test,
            shape,
            regions,
        } => Step::Cover {
            pipeline: cover_pipeline(PipelineState::Colour {
                test: *test,
                faces: FaceSet::Both,
            }),
            cuts_to_regions: *shape == CoverShape::Rectangle,
            regions: regions.clone(),
        },
        FillCommand::Accumulate {
            depth,
            faces,
            without_bottom,
            scissor,
            regions,
        } => Step::Volumes {
            state: PipelineState::Accumulate {
                depth: *depth,
                faces: *faces,
            },
            without_bottom: *without_bottom,
            scissor: *scissor,
            regions: regions.clone(),
        },
        FillCommand::Resolve => Step::Cover {
            pipeline: cover_pipeline(PipelineState::Resolve),
            cuts_to_regions: false,
            regions: vec![0],
        },
    }
}

/// Widths of indices, short ones first.
const WIDTHS: [IndexWidth; 2] = [IndexWidth::Short, IndexWidth::Long];

/// The pipelines that draw volumes in one state.
pub(crate) fn volume_pipelines(
    variant: NativeVariant,
    state: PipelineState,
    without_bottom: bool,
) -> impl Iterator<Item = (Part, PipelineDescriptor)> {
    let technique = variant.technique;
    technique.parts().iter().map(move |&part| {
        let depth_bounds = variant.switches.depth_bounds;
        let pipeline = technique.volume_pipeline(part, state, without_bottom, depth_bounds);
        (part, pipeline)
    })
}

/// What is drawn from, for one view of one scene.
#[derive(Clone, Copy)]
pub(crate) struct Drawing<'a> {
    pub(crate) variant: NativeVariant,
    pub(crate) pipelines: &'a Pipelines,
    pub(crate) scene: &'a SceneBuffers,
    pub(crate) view: &'a ViewBuffers,
    pub(crate) input: &'a FrameInput,
}

impl<'a> Drawing<'a> {
    /// All passes.
    pub(crate) fn fill(&self, recorder: &mut FillRecorder<'a>, counters: &mut Counters) {
        for pass in &self.view.passes {
            let mut steps = |recorder: &mut PassRecorder<'a, '_>| {
                for step in &pass.steps {
                    self.step(recorder, step, counters);
                }
            };
            if pass.accumulates {
                recorder.accumulate(|recorder| steps(recorder));
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
            for step in self.view.passes.iter().flat_map(|pass| &pass.steps) {
                if let Some(step) = counting(step) {
                    self.step(recorder, &step, &mut Counters::default());
                }
            }
        });
    }

    fn step(&self, pass: &mut PassRecorder<'a, '_>, step: &Step, counters: &mut Counters) {
        let full = PixelRect::full(self.input.size);
        let rect = |planned: usize| self.input.plan.regions[planned].screen_rect;
        match step {
            Step::Volumes {
                state,
                without_bottom,
                scissor,
                regions,
            } => {
                for width in WIDTHS {
                    for (part, key) in volume_pipelines(self.variant, *state, *without_bottom) {
                        let Some(pipeline) = self.pipelines.get(&key) else {
                            continue;
                        };
                        let drawn = regions.iter().copied();
                        for planned in drawn.filter(|&planned| self.width(planned) == width) {
                            pass.scissor(if *scissor { rect(planned) } else { full });
                            if key.depth_bounds {
                                let range =
                                    depth_range(self.input, &self.input.plan.regions[planned]);
                                pass.depth_bounds(range.low, range.high);
                            }
                            let without = *without_bottom && part == Part::Caps;
                            self.part(pass, pipeline, part, planned, without, counters);
                        }
                    }
                }
            }
            Step::Cover {
                pipeline,
                cuts_to_regions,
                regions,
            } => {
                let Some(pipeline) = self.pipelines.get(pipeline) else {
                    return;
                };
                let state = self.state(pipeline, None);
                for &planned in regions {
                    pass.scissor(if *cuts_to_regions {
                        rect(planned)
                    } else {
                        full
                    });
                    pass.draw(&state, 3, instance(planned));
                    counters.draws += 1;
                    counters.vertices += 3;
                }
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
            Part::Caps if without_bottom && self.variant.technique == Technique::VsControl => {
                (slice.first_index, slice.index_count / 2)
            }
            Part::Caps | Part::Whole => (slice.first_index, slice.index_count),
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

/// The same volumes, drawn to be counted; `None` for steps that do not mark.
pub(crate) fn counting(step: &Step) -> Option<Step> {
    let Step::Volumes {
        state,
        without_bottom,
        scissor,
        regions,
    } = step
    else {
        return None;
    };
    let faces = match state {
        PipelineState::Mark { rule, .. } => rule.faces,
        PipelineState::Accumulate { faces, .. } => *faces,
        _ => return None,
    };
    Some(Step::Volumes {
        state: PipelineState::Count { faces },
        without_bottom: *without_bottom,
        scissor: *scissor,
        regions: regions.clone(),
    })
}

/// The instance number is the index of the region's constants.
fn instance(planned: usize) -> u32 {
    u32::try_from(planned).unwrap_or(u32::MAX)
}
