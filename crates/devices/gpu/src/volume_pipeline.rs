// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipelines of a fill: what is tested, what is written, whatever the volumes are made of.
//!
//! Reversed depth: what is nearer is greater. No pipeline here writes depth.

use crate::render_pipeline::{described, tested};
use crate::{COLOUR_FORMAT, Gpu};
use terrafill_contract::DeviceError;
use terrafill_stencil::{DepthRule, FaceEffect, FaceSet, StencilRule, StencilTest, VolumeState};
use terrafill_variant::FirstPass;

/// Format of the accumulation target: integers to 2²⁴ are exact in it.
pub(crate) const NUMBER_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// What a backend's volumes are drawn by, apart from the state that the fill asks for.
#[derive(Debug)]
pub struct VolumeShader<'a> {
    /// Vertex and fragment shaders. Of the latter: `no_colour`, `region_colour`, `costly`,
    /// `counted`, `number_behind`, `number_before`.
    pub module: &'a wgpu::ShaderModule,
    /// Bindings; group 0 holds the view and the volumes' constants.
    pub layout: &'a wgpu::PipelineLayout,
    /// Entry point of the vertex stage.
    pub vertex_entry: &'a str,
    /// Overrides of the vertex stage.
    pub constants: &'a [(&'a str, f64)],
    /// Vertex buffers.
    pub buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    /// Strips with indices of this width; `None`: lists.
    pub strip_index_format: Option<wgpu::IndexFormat>,
    /// The winding of faces that are seen from outside.
    pub front_face: wgpu::FrontFace,
    /// `no_colour` discards fragments, so it is run where there is no colour target as well.
    pub discards: bool,
}

/// What the vertex stage of a volume hands on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HandedOn {
    /// The position only.
    Nothing,
    /// The volume's colour.
    Colour,
    /// The volume's number.
    Number,
}

impl HandedOn {
    /// What the fragments of a state need.
    #[must_use]
    pub fn of(state: VolumeState) -> Self {
        match state {
            VolumeState::Mark {
                first_pass: FirstPass::Colour,
                ..
            }
            | VolumeState::Colour { .. } => Self::Colour,
            VolumeState::Mark { .. } | VolumeState::Count { .. } => Self::Nothing,
            VolumeState::Accumulate { .. } => Self::Number,
        }
    }
}

impl VolumeShader<'_> {
    /// The pipeline that draws volumes in `state`; with `blends`, colours are blended over what lies
    /// under them.
    #[must_use]
    pub fn pipeline(&self, gpu: &Gpu, state: VolumeState, blends: bool) -> wgpu::RenderPipeline {
        let unwritten = unwritten_target();
        let (fragment_entry, target, depth_stencil) = match state {
            VolumeState::Mark {
                rule,
                has_colour,
                first_pass,
            } => {
                let (entry, target) = match first_pass {
                    FirstPass::Stencil => ("no_colour", has_colour.then_some(unwritten)),
                    FirstPass::Colour => ("region_colour", Some(colour_target(false))),
                    FirstPass::Program => ("costly", Some(unwritten)),
                    FirstPass::ProgramColour => ("costly", Some(colour_target(false))),
                };
                (entry, target, mark_state(rule))
            }
            VolumeState::Count { .. } => (
                "counted",
                Some(unwritten),
                unchanged(wgpu::CompareFunction::Always),
            ),
            VolumeState::Colour {
                test,
                is_before_surface,
                ..
            } => (
                "region_colour",
                Some(colour_target(blends)),
                wgpu::DepthStencilState {
                    depth_compare: Some(if is_before_surface {
                        wgpu::CompareFunction::Greater
                    } else {
                        wgpu::CompareFunction::Always
                    }),
                    ..colour_state(test)
                },
            ),
            VolumeState::Accumulate { depth, .. } => {
                let entry = match depth {
                    DepthRule::Fail | DepthRule::Always => "number_behind",
                    DepthRule::Pass => "number_before",
                };
                let added = target(NUMBER_FORMAT, Some(ADDED), wgpu::ColorWrites::ALL);
                (entry, Some(added), accumulate_state(depth))
            }
        };
        let targets = [target.clone()];
        let targets = if target.is_some() { &targets[..] } else { &[] };
        let mut described = described("volume", self.layout, self.module, targets);
        described.vertex.entry_point = Some(self.vertex_entry);
        described.vertex.compilation_options.constants = self.constants;
        described.vertex.buffers = self.buffers;
        if self.strip_index_format.is_some() {
            described.primitive.topology = wgpu::PrimitiveTopology::TriangleStrip;
        }
        described.primitive.strip_index_format = self.strip_index_format;
        described.primitive.front_face = self.front_face;
        described.primitive.cull_mode = match state.faces() {
            FaceSet::Both => None,
            FaceSet::Front => Some(wgpu::Face::Back),
            FaceSet::Back => Some(wgpu::Face::Front),
        };
        described.depth_stencil = Some(depth_stencil);
        match &mut described.fragment {
            Some(fragment) if target.is_some() || self.discards => {
                fragment.entry_point = Some(fragment_entry);
            }
            fragment => *fragment = None,
        }
        gpu.create_render_pipeline(&described)
    }
}

/// Whether numbers can be accumulated.
///
/// # Errors
/// [`DeviceError::Unsupported`].
pub(crate) fn check_blendable(gpu: &Gpu) -> Result<(), DeviceError> {
    let needed = wgpu::Features::FLOAT32_BLENDABLE;
    gpu.require(needed, "blending into 32-bit floats")
}

/// The colour target, written or blended into.
pub(crate) fn colour_target(blends: bool) -> wgpu::ColorTargetState {
    let blend = blends.then_some(wgpu::BlendState::ALPHA_BLENDING);
    target(COLOUR_FORMAT, blend, wgpu::ColorWrites::ALL)
}

/// Of fragments that write nothing.
pub(crate) fn unwritten_target() -> wgpu::ColorTargetState {
    target(COLOUR_FORMAT, None, wgpu::ColorWrites::empty())
}

fn target(
    format: wgpu::TextureFormat,
    blend: Option<wgpu::BlendState>,
    write_mask: wgpu::ColorWrites,
) -> wgpu::ColorTargetState {
    wgpu::ColorTargetState {
        format,
        blend,
        write_mask,
    }
}

/// Source and target added.
const ADDED: wgpu::BlendState = {
    let added = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState {
        color: added,
        alpha: added,
    }
};

/// Depth tested, and the stencil not; both left as they are.
pub(crate) fn unchanged(compare: wgpu::CompareFunction) -> wgpu::DepthStencilState {
    tested(compare, wgpu::StencilState::default())
}

/// Fragments behind the surface are those that the depth test, `Greater`, fails: exactly the others,
/// equal depths included.
fn accumulate_state(depth: DepthRule) -> wgpu::DepthStencilState {
    unchanged(match depth {
        DepthRule::Fail => wgpu::CompareFunction::LessEqual,
        DepthRule::Pass => wgpu::CompareFunction::Greater,
        DepthRule::Always => wgpu::CompareFunction::Always,
    })
}

/// Counting behind the surface is right wherever the eye is and whatever the near plane cuts
/// (Carmack, 2000; Everitt and Kilgard, 2002); counting in front of it (Heidmann, 1991) touches
/// fewer fragments where the surface is close.
fn mark_state(rule: StencilRule) -> wgpu::DepthStencilState {
    let keep = wgpu::StencilOperation::Keep;
    let face = |operation| {
        let (depth_fail_op, pass_op) = match rule.depth {
            DepthRule::Fail => (operation, keep),
            DepthRule::Pass => (keep, operation),
            DepthRule::Always => (operation, operation),
        };
        wgpu::StencilFaceState {
            compare: wgpu::CompareFunction::Always,
            fail_op: keep,
            depth_fail_op,
            pass_op,
        }
    };
    let operation = |effect| match effect {
        FaceEffect::Invert => wgpu::StencilOperation::Invert,
        FaceEffect::Add => wgpu::StencilOperation::IncrementWrap,
        FaceEffect::Take => wgpu::StencilOperation::DecrementWrap,
    };
    let (front, back, mask) = rule.effects();
    let stencil = wgpu::StencilState {
        front: face(operation(front)),
        back: face(operation(back)),
        read_mask: 0,
        write_mask: u32::from(mask),
    };
    tested(wgpu::CompareFunction::Greater, stencil)
}

/// Whatever the depth, or wherever there is a surface, where the stencil says so.
pub(crate) fn colour_state(test: StencilTest) -> wgpu::DepthStencilState {
    let keep = wgpu::StencilOperation::Keep;
    let face = wgpu::StencilFaceState {
        compare: if test.is_equal {
            wgpu::CompareFunction::Equal
        } else {
            wgpu::CompareFunction::NotEqual
        },
        fail_op: keep,
        depth_fail_op: keep,
        pass_op: if test.zeroes {
            wgpu::StencilOperation::Zero
        } else {
            keep
        },
    };
    let stencil = wgpu::StencilState {
        front: face,
        back: face,
        read_mask: u32::from(test.read_mask),
        write_mask: if test.zeroes { 0xff } else { 0 },
    };
    // At depth 0 a cover is as far as the sky.
    let depth = if test.skips_sky {
        wgpu::CompareFunction::Less
    } else {
        wgpu::CompareFunction::Always
    };
    tested(depth, stencil)
}
