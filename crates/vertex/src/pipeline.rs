// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipelines of the stencil and colour passes.

use crate::{Layout, VertexVariant};
use std::collections::HashMap;
use terrafill_frame::{
    BackendError, CoverShape, DepthRule, FaceSet, FillCommand, PositionFormat, StencilOperation,
    StencilRule, StencilTest,
};
use terrafill_gpu::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, Gpu};

/// Which part of a volume a pipeline draws. Doubled walls are strips, and a strip's restart value
/// belongs to the pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Part {
    Caps,
    Walls { short_indices: bool },
}

/// The parts of volumes whose indices have this width.
pub(crate) fn parts(short_indices: bool) -> [Part; 2] {
    [Part::Caps, Part::Walls { short_indices }]
}

/// What a volume is drawn for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum State {
    /// Into the stencil, in a pass with or without a colour target.
    Mark { rule: StencilRule, has_colour: bool },
    /// Into the colour target where the stencil says so.
    Colour { test: StencilTest, faces: FaceSet },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct PipelineKey {
    pub(crate) part: Part,
    pub(crate) state: State,
}

/// Pipelines of one variant on one device, made when first asked for.
#[derive(Debug)]
pub(crate) struct Pipelines {
    variant: VertexVariant,
    volume_shader: wgpu::ShaderModule,
    volume_layout: wgpu::PipelineLayout,
    volumes: HashMap<PipelineKey, wgpu::RenderPipeline>,
    cover_shader: wgpu::ShaderModule,
    cover_layout: wgpu::PipelineLayout,
    covers: HashMap<StencilTest, wgpu::RenderPipeline>,
    pub(crate) frame_bindings: wgpu::BindGroupLayout,
    pub(crate) geometry_bindings: wgpu::BindGroupLayout,
}

fn buffer_entry(binding: u32, ty: wgpu::BufferBindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX,
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}

impl Pipelines {
    pub(crate) fn new(gpu: &Gpu, variant: VertexVariant) -> Result<Self, BackendError> {
        let device = &gpu.device;
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let frame_bindings = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("view and regions"),
            entries: &[
                buffer_entry(0, wgpu::BufferBindingType::Uniform),
                buffer_entry(1, storage),
            ],
        });
        let geometry_bindings = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("pulled geometry"),
            entries: &[buffer_entry(0, storage), buffer_entry(1, storage)],
        });
        let groups: &[Option<&wgpu::BindGroupLayout>] = match variant.layout {
            Layout::Doubled => &[Some(&frame_bindings)],
            Layout::Pulled => &[Some(&frame_bindings), Some(&geometry_bindings)],
        };
        let pipeline_layout = |groups: &[Option<&wgpu::BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("vertex"),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let volume_shader = gpu.shader(match variant.layout {
            Layout::Doubled => "vertex/doubled.wgsl",
            Layout::Pulled => "vertex/pulled.wgsl",
        })?;
        Ok(Self {
            variant,
            volume_shader,
            volume_layout: pipeline_layout(groups),
            volumes: HashMap::new(),
            cover_shader: gpu.shader("vertex/cover.wgsl")?,
            cover_layout: pipeline_layout(&[Some(&frame_bindings)]),
            covers: HashMap::new(),
            frame_bindings,
            geometry_bindings,
        })
    }

    /// Makes the pipelines of a step unless they are there. `short` tells which index width a
    /// planned region has.
    pub(crate) fn ensure(
        &mut self,
        gpu: &Gpu,
        command: &FillCommand,
        has_colour: bool,
        short: impl Fn(&usize) -> bool,
    ) {
        let (state, regions) = match command {
            FillCommand::Volumes { rule, regions, .. } => (
                State::Mark {
                    rule: *rule,
                    has_colour,
                },
                regions,
            ),
            FillCommand::Cover {
                test,
                shape: CoverShape::Volume { faces },
                regions,
            } => (
                State::Colour {
                    test: *test,
                    faces: *faces,
                },
                regions,
            ),
            FillCommand::Cover { test, .. } => {
                if !self.covers.contains_key(test) {
                    let pipeline = self.cover_pipeline(gpu, *test);
                    self.covers.insert(*test, pipeline);
                }
                return;
            }
        };
        for short_indices in [true, false] {
            if !regions
                .iter()
                .any(|planned| short(planned) == short_indices)
            {
                continue;
            }
            for part in parts(short_indices) {
                let key = PipelineKey { part, state };
                if !self.volumes.contains_key(&key) {
                    let pipeline = self.volume_pipeline(gpu, key);
                    self.volumes.insert(key, pipeline);
                }
            }
        }
    }

    /// A pipeline that [`Pipelines::ensure`] made.
    pub(crate) fn volume(&self, key: PipelineKey) -> Option<&wgpu::RenderPipeline> {
        self.volumes.get(&key)
    }

    /// As [`Pipelines::volume`].
    pub(crate) fn cover(&self, test: StencilTest) -> Option<&wgpu::RenderPipeline> {
        self.covers.get(&test)
    }

    fn volume_pipeline(&self, gpu: &Gpu, key: PipelineKey) -> wgpu::RenderPipeline {
        let PipelineKey { part, state } = key;
        let attributes = wgpu::vertex_attr_array![0 => Sint32x3, 1 => Uint32];
        let doubled = [Some(wgpu::VertexBufferLayout {
            array_stride: 16,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &attributes,
        })];
        let is_doubled = self.variant.layout == Layout::Doubled;
        let is_coloured = matches!(state, State::Colour { .. });
        let entry_point = match (is_doubled, part, is_coloured) {
            (true, _, false) => "vertex_main",
            (false, Part::Caps, false) => "caps_main",
            (false, Part::Walls { .. }, false) => "walls_main",
            (true, _, true) => "coloured_main",
            (false, Part::Caps, true) => "coloured_caps",
            (false, Part::Walls { .. }, true) => "coloured_walls",
        };
        let faces = match state {
            State::Mark { rule, .. } => rule.faces,
            State::Colour { faces, .. } => faces,
        };
        let (has_target, fragment_entry, write_mask) = match state {
            State::Mark { has_colour, .. } => (has_colour, "no_colour", wgpu::ColorWrites::empty()),
            State::Colour { .. } => (true, "region_colour", wgpu::ColorWrites::ALL),
        };
        let strip_index_format = match (is_doubled, part) {
            (
                true,
                Part::Walls {
                    short_indices: true,
                },
            ) => Some(wgpu::IndexFormat::Uint16),
            (
                true,
                Part::Walls {
                    short_indices: false,
                },
            ) => Some(wgpu::IndexFormat::Uint32),
            _ => None,
        };
        let local_f32 = self.variant.positions == PositionFormat::LocalF32;
        let constants = [("POSITIONS_ARE_LOCAL_F32", f64::from(u8::from(local_f32)))];
        gpu.device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("volume"),
                layout: Some(&self.volume_layout),
                vertex: wgpu::VertexState {
                    module: &self.volume_shader,
                    entry_point: Some(entry_point),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &constants,
                        ..Default::default()
                    },
                    buffers: if is_doubled { &doubled } else { &[] },
                },
                primitive: wgpu::PrimitiveState {
                    topology: if strip_index_format.is_some() {
                        wgpu::PrimitiveTopology::TriangleStrip
                    } else {
                        wgpu::PrimitiveTopology::TriangleList
                    },
                    strip_index_format,
                    cull_mode: match faces {
                        FaceSet::Both => None,
                        FaceSet::Front => Some(wgpu::Face::Back),
                        FaceSet::Back => Some(wgpu::Face::Front),
                    },
                    ..Default::default()
                },
                depth_stencil: Some(match state {
                    State::Mark { rule, .. } => mark_state(rule),
                    State::Colour { test, .. } => colour_state(test),
                }),
                multisample: Default::default(),
                fragment: has_target.then_some(wgpu::FragmentState {
                    module: &self.volume_shader,
                    entry_point: Some(fragment_entry),
                    compilation_options: Default::default(),
                    targets: &[Some(wgpu::ColorTargetState {
                        format: COLOUR_FORMAT,
                        blend: None,
                        write_mask,
                    })],
                }),
                multiview_mask: None,
                cache: None,
            })
    }

    fn cover_pipeline(&self, gpu: &Gpu, test: StencilTest) -> wgpu::RenderPipeline {
        gpu.device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("cover"),
                layout: Some(&self.cover_layout),
                vertex: wgpu::VertexState {
                    module: &self.cover_shader,
                    entry_point: Some("vertex_main"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil: Some(colour_state(test)),
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &self.cover_shader,
                    entry_point: Some("fragment_main"),
                    compilation_options: Default::default(),
                    targets: &[Some(COLOUR_FORMAT.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
    }
}

/// Counting behind the surface is right wherever the eye is and whatever the near plane cuts
/// (Carmack, 2000; Everitt and Kilgard, 2002); counting in front of it (Heidmann, 1991) touches
/// fewer fragments where the surface is close.
fn mark_state(rule: StencilRule) -> wgpu::DepthStencilState {
    let keep = wgpu::StencilOperation::Keep;
    let face = |operation| match rule.depth {
        DepthRule::Fail => wgpu::StencilFaceState {
            compare: wgpu::CompareFunction::Always,
            fail_op: keep,
            depth_fail_op: operation,
            pass_op: keep,
        },
        DepthRule::Pass => wgpu::StencilFaceState {
            compare: wgpu::CompareFunction::Always,
            fail_op: keep,
            depth_fail_op: keep,
            pass_op: operation,
        },
    };
    let (add, take) = (
        wgpu::StencilOperation::IncrementWrap,
        wgpu::StencilOperation::DecrementWrap,
    );
    let invert = wgpu::StencilOperation::Invert;
    let (front, back, write_mask) = match (rule.operation, rule.depth) {
        (StencilOperation::Invert { mask }, _) => (invert, invert, u32::from(mask)),
        (StencilOperation::Count, DepthRule::Fail) => (take, add, 0xff),
        (StencilOperation::Count, DepthRule::Pass) => (add, take, 0xff),
    };
    wgpu::DepthStencilState {
        format: DEPTH_STENCIL_FORMAT,
        depth_write_enabled: Some(false),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: wgpu::StencilState {
            front: face(front),
            back: face(back),
            read_mask: 0xff,
            write_mask,
        },
        bias: Default::default(),
    }
}

fn colour_state(test: StencilTest) -> wgpu::DepthStencilState {
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
    wgpu::DepthStencilState {
        format: DEPTH_STENCIL_FORMAT,
        depth_write_enabled: Some(false),
        depth_compare: Some(wgpu::CompareFunction::Always),
        stencil: wgpu::StencilState {
            front: face,
            back: face,
            read_mask: u32::from(test.read_mask),
            write_mask: if test.zeroes { 0xff } else { 0 },
        },
        bias: Default::default(),
    }
}
