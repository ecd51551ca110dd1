// SPDX-License-Identifier: MIT OR Apache-2.0
//! A fill program as a graphics API draws it: volumes in a state, triangles over the screen.
//!
//! Commands say what a step is for; here they are sorted by what is drawn, so that every backend
//! walks the same three kinds and a pipeline's state has one name.

use crate::{
    CoverShape, DepthRule, FaceSet, FillCommand, FillPass, FillProgram, StencilRule, StencilTest,
    VolumeList,
};
use std::ops::Range;
use terrafill_variant::FirstPass;

/// Bytes of a pixel of the accumulation target, one 32-bit float.
pub const NUMBER_BYTES: u64 = 4;

/// What volumes are drawn for: all that the state of their pipelines depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum VolumeState {
    /// Into the stencil, in a pass with or without a colour target, which is left alone.
    Mark {
        /// Which fragments do what.
        rule: StencilRule,
        /// The pass has a colour target.
        has_colour: bool,
        /// What fragments do beside, in a pass without one.
        first_pass: FirstPass,
    },
    /// Into the colour target where the stencil says so.
    Colour {
        /// What the stencil must say.
        test: StencilTest,
        /// Only what is nearer than the surface.
        is_before_surface: bool,
        /// Faces drawn.
        faces: FaceSet,
    },
    /// Their numbers into the accumulation target.
    Accumulate {
        /// Which fragments count.
        depth: DepthRule,
        /// Faces drawn.
        faces: FaceSet,
    },
    /// Into nothing, whatever the depth, so that a query counts every fragment.
    Count {
        /// Faces drawn.
        faces: FaceSet,
    },
}

impl VolumeState {
    /// Faces drawn; the others are culled.
    #[must_use]
    pub fn faces(self) -> FaceSet {
        match self {
            Self::Mark { rule, .. } => rule.faces,
            Self::Colour { faces, .. } | Self::Accumulate { faces, .. } | Self::Count { faces } => {
                faces
            }
        }
    }
}

/// Volumes drawn in one state. Their order changes nothing but what covers what in
/// [`VolumeState::Colour`], where it is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VolumeDraw<'a> {
    /// What for.
    pub state: VolumeState,
    /// Leaves out bottom caps.
    pub without_bottom: bool,
    /// Cuts each volume to its rectangle.
    pub scissor: bool,
    /// Indices into the list.
    pub volumes: &'a [usize],
}

/// For each volume, in this order, one triangle over the screen in its colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CoverDraw<'a> {
    /// What the stencil must say.
    pub test: StencilTest,
    /// Cuts each triangle to its volume's rectangle.
    pub scissor: bool,
    /// Indices into the list.
    pub volumes: &'a [usize],
}

impl CoverDraw<'_> {
    /// Which rectangles of merged covers these are. They lie in the order of the steps.
    ///
    /// - `drawn`: how many are drawn so far
    pub fn merged(&self, list: &VolumeList, drawn: &mut u32) -> Range<u32> {
        let counts = self.volumes.iter();
        let counts = counts.map(|&volume| list.cover_rects(volume, self.scissor).count());
        let count = u32::try_from(counts.sum::<usize>()).unwrap_or(u32::MAX);
        let first = *drawn;
        *drawn = first.saturating_add(count);
        first..*drawn
    }
}

/// One step of a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FillStep<'a> {
    /// Volumes.
    Volumes(VolumeDraw<'a>),
    /// Triangles over the screen.
    Cover(CoverDraw<'a>),
    /// One triangle over the screen that looks up the colours of accumulated numbers.
    Resolve,
}

impl FillPass {
    /// Its commands, in order, as they are drawn.
    pub fn steps(&self) -> impl Iterator<Item = FillStep<'_>> {
        let step = |command| step_of(command, self);
        self.commands.iter().map(step)
    }
}

impl FillProgram {
    /// The volumes of the stencil or accumulation work once more, drawn to be counted.
    pub fn counted(&self) -> impl Iterator<Item = VolumeDraw<'_>> {
        let steps = self.passes.iter().flat_map(FillPass::steps);
        steps.filter_map(|step| match step {
            FillStep::Volumes(draw) if !matches!(draw.state, VolumeState::Colour { .. }) => {
                Some(VolumeDraw {
                    state: VolumeState::Count {
                        faces: draw.state.faces(),
                    },
                    ..draw
                })
            }
            _ => None,
        })
    }

    /// Whether numbers are accumulated.
    #[must_use]
    pub fn accumulates(&self) -> bool {
        self.passes.iter().any(FillPass::accumulates)
    }
}

fn step_of<'a>(command: &'a FillCommand, pass: &FillPass) -> FillStep<'a> {
    match command {
        FillCommand::Volumes {
            rule,
            without_bottom,
            scissor,
            volumes,
        } => FillStep::Volumes(VolumeDraw {
            state: VolumeState::Mark {
                rule: *rule,
                has_colour: pass.has_colour,
                first_pass: pass.first_pass,
            },
            without_bottom: *without_bottom,
            scissor: *scissor,
            volumes,
        }),
        FillCommand::Accumulate {
            depth,
            faces,
            without_bottom,
            scissor,
            volumes,
        } => FillStep::Volumes(VolumeDraw {
            state: VolumeState::Accumulate {
                depth: *depth,
                faces: *faces,
            },
            without_bottom: *without_bottom,
            scissor: *scissor,
            volumes,
        }),
        FillCommand::Cover {
            test,
            shape:
                CoverShape::Volume {
                    faces,
                    without_bottom,
                },
            volumes,
        } => FillStep::Volumes(VolumeDraw {
            state: VolumeState::Colour {
                test: *test,
                is_before_surface: false,
                faces: *faces,
            },
            without_bottom: *without_bottom,
            scissor: false,
            volumes,
        }),
        FillCommand::Cover {
            test,
            shape: CoverShape::Flat,
            volumes,
        } => FillStep::Volumes(VolumeDraw {
            state: VolumeState::Colour {
                test: *test,
                is_before_surface: true,
                faces: FaceSet::Front,
            },
            without_bottom: true,
            scissor: false,
            volumes,
        }),
        FillCommand::Cover {
            test,
            shape,
            volumes,
        } => FillStep::Cover(CoverDraw {
            test: *test,
            scissor: *shape == CoverShape::Rectangle,
            volumes,
        }),
        FillCommand::Resolve => FillStep::Resolve,
    }
}
