// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipelines of the stencil, accumulation and colour passes.

use crate::{FLAG_BYTES, Layout, VertexVariant};
use std::collections::HashMap;
use terrafill_frame::{
    BackendError, CoverShape, DepthRule, FaceSet, FillCommand, PositionFormat, StencilOperation,
    StencilRule, StencilTest,
};
use terrafill_gpu::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, Gpu};

/// Which part of a volume a pipeline draws. Doubled walls may be strips, and a strip's restart value
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
    Colour {
        test: StencilTest,
        faces: FaceSet,
        blends: bool,
    },
    /// Its number into the accumulation target.
    Add { depth: DepthRule, faces: FaceSet },
    /// Into nothing, whatever the depth, so that every fragment is counted.
    Count { faces: FaceSet },
}

/// Format of the accumulation target: integers to 2²⁴ are exact in it.
pub(crate) const NUMBER_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

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
    covers: HashMap<(StencilTest, bool), wgpu::RenderPipeline>,
    resolve: Option<wgpu::RenderPipeline>,
    pub(crate) number_bindings: wgpu::BindGroupLayout,
    pub(crate) frame_bindings: wgpu::BindGroupLayout,
    pub(crate) geometry_bindings: wgpu::BindGroupLayout,
}

fn buffer_entry(binding: u32, ty: wgpu::BufferBindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
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
            Layout::Pulled => &[Some(&frame_bindings), Some(&geometry_bindings)],
            _ => &[Some(&frame_bindings)],
        };
        let number_bindings = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("accumulated numbers"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: false },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                count: None,
            }],
        });
        let pipeline_layout = |groups: &[Option<&wgpu::BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("vertex"),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let volume_shader = gpu.shader(match variant.layout {
            Layout::Pulled => "vertex/pulled.wgsl",
            _ => "vertex/doubled.wgsl",
        })?;
        Ok(Self {
            variant,
            volume_shader,
            volume_layout: pipeline_layout(groups),
            volumes: HashMap::new(),
            cover_shader: gpu.shader("vertex/cover.wgsl")?,
            cover_layout: pipeline_layout(&[Some(&frame_bindings)]),
            covers: HashMap::new(),
            resolve: None,
            number_bindings,
            frame_bindings,
            geometry_bindings,
        })
    }

    /// Makes the pipelines of a step unless they are there. `short` tells which index width a
    /// planned region has; with `blends`, covers are blended over what lies under them.
    ///
    /// # Errors
    /// [`BackendError::Unsupported`], [`BackendError::Shader`].
    pub(crate) fn ensure(
        &mut self,
        gpu: &Gpu,
        command: &FillCommand,
        has_colour: bool,
        blends: bool,
        short: impl Fn(&usize) -> bool,
    ) -> Result<(), BackendError> {
        let (state, regions) = match command {
            FillCommand::Resolve => return self.ensure_resolve(gpu),
            FillCommand::Accumulate {
                depth,
                faces,
                regions,
                ..
            } => {
                check_blendable(gpu)?;
                let (depth, faces) = (*depth, *faces);
                (State::Add { depth, faces }, regions)
            }
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
                    blends,
                },
                regions,
            ),
            FillCommand::Cover { test, .. } => {
                if !self.covers.contains_key(&(*test, blends)) {
                    let pipeline = self.cover_pipeline(gpu, *test, blends);
                    self.covers.insert((*test, blends), pipeline);
                }
                return Ok(());
            }
        };
        self.ensure_volumes(gpu, state, regions, short);
        Ok(())
    }

    /// Makes the pipelines that draw `regions` in one state unless they are there.
    pub(crate) fn ensure_volumes(
        &mut self,
        gpu: &Gpu,
        state: State,
        regions: &[usize],
        short: impl Fn(&usize) -> bool,
    ) {
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
    pub(crate) fn cover(&self, test: StencilTest, blends: bool) -> Option<&wgpu::RenderPipeline> {
        self.covers.get(&(test, blends))
    }

    /// As [`Pipelines::volume`].
    pub(crate) fn resolve(&self) -> Option<&wgpu::RenderPipeline> {
        self.resolve.as_ref()
    }

    fn strip_format(&self, part: Part) -> Option<wgpu::IndexFormat> {
        match part {
            Part::Walls { short_indices } if self.variant.has_strips() => Some(if short_indices {
                wgpu::IndexFormat::Uint16
            } else {
                wgpu::IndexFormat::Uint32
            }),
            _ => None,
        }
    }

    fn volume_pipeline(&self, gpu: &Gpu, key: PipelineKey) -> wgpu::RenderPipeline {
        let PipelineKey { part, state } = key;
        let attributes = wgpu::vertex_attr_array![0 => Sint32x3, 1 => Uint32];
        let buffer = |stride: usize, attributes| {
            Some(wgpu::VertexBufferLayout {
                array_stride: stride as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes,
            })
        };
        let stride = 4 * self.variant.vertex_words();
        let flags = wgpu::vertex_attr_array![1 => Uint32];
        let buffers = match self.variant.layout {
            Layout::Pulled => vec![],
            Layout::Separate => vec![buffer(stride, &attributes[..1]), buffer(FLAG_BYTES, &flags)],
            Layout::Doubled | Layout::PerTriangle => vec![buffer(stride, &attributes)],
        };
        let strip_index_format = self.strip_format(part);
        let (purpose, faces, fragment) = match state {
            State::Mark { rule, has_colour } => {
                let unwritten = target(COLOUR_FORMAT, None, wgpu::ColorWrites::empty());
                let fragment = has_colour.then_some(("no_colour", unwritten));
                (Purpose::Plain, rule.faces, fragment)
            }
            State::Colour { faces, blends, .. } => {
                let blend = blends.then_some(wgpu::BlendState::ALPHA_BLENDING);
                let written = target(COLOUR_FORMAT, blend, wgpu::ColorWrites::ALL);
                (Purpose::Coloured, faces, Some(("region_colour", written)))
            }
            State::Add { depth, faces } => {
                let added = target(NUMBER_FORMAT, Some(ADDED), wgpu::ColorWrites::ALL);
                let entry_point = match depth {
                    DepthRule::Fail => "number_behind",
                    DepthRule::Pass => "number_before",
                };
                (Purpose::Numbered, faces, Some((entry_point, added)))
            }
            State::Count { faces } => {
                let unwritten = target(COLOUR_FORMAT, None, wgpu::ColorWrites::empty());
                (Purpose::Plain, faces, Some(("counted", unwritten)))
            }
        };
        let targets = [fragment.as_ref().map(|(_, target)| target.clone())];
        let entry_point = entry_point(self.variant.layout.is_doubled(), part, purpose);
        let local_f32 = self.variant.positions == PositionFormat::LocalF32;
        let constants = [("POSITIONS_ARE_LOCAL_F32", f64::from(u8::from(local_f32)))];
        gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("volume"),
            layout: Some(&self.volume_layout),
            vertex: wgpu::VertexState {
                module: &self.volume_shader,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &constants,
                    ..Default::default()
                },
                buffers: &buffers,
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
                State::Add { depth, .. } => add_state(depth),
                State::Count { .. } => unchanged(wgpu::CompareFunction::Always),
            }),
            multisample: Default::default(),
            fragment: fragment
                .as_ref()
                .map(|(entry_point, _)| wgpu::FragmentState {
                    module: &self.volume_shader,
                    entry_point: Some(entry_point),
                    compilation_options: Default::default(),
                    targets: &targets,
                }),
            multiview_mask: None,
            cache: None,
        })
    }

    fn ensure_resolve(&mut self, gpu: &Gpu) -> Result<(), BackendError> {
        if self.resolve.is_some() {
            return Ok(());
        }
        let shader = gpu.shader("vertex/resolve.wgsl")?;
        let groups = [Some(&self.frame_bindings), Some(&self.number_bindings)];
        let layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("resolve"),
                bind_group_layouts: &groups,
                immediate_size: 0,
            });
        let written = Some(target(COLOUR_FORMAT, None, wgpu::ColorWrites::ALL));
        let always = unchanged(wgpu::CompareFunction::Always);
        self.resolve = Some(full_screen(
            gpu, "resolve", &layout, &shader, always, written,
        ));
        Ok(())
    }

    fn cover_pipeline(&self, gpu: &Gpu, test: StencilTest, blends: bool) -> wgpu::RenderPipeline {
        let blend = blends.then_some(wgpu::BlendState::ALPHA_BLENDING);
        let written = Some(target(COLOUR_FORMAT, blend, wgpu::ColorWrites::ALL));
        let (layout, shader) = (&self.cover_layout, &self.cover_shader);
        full_screen(gpu, "cover", layout, shader, colour_state(test), written)
    }
}

/// One triangle over the screen.
fn full_screen(
    gpu: &Gpu,
    label: &str,
    layout: &wgpu::PipelineLayout,
    shader: &wgpu::ShaderModule,
    depth_stencil: wgpu::DepthStencilState,
    target: Option<wgpu::ColorTargetState>,
) -> wgpu::RenderPipeline {
    gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: shader,
            entry_point: Some("vertex_main"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: Some(depth_stencil),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: shader,
            entry_point: Some("fragment_main"),
            compilation_options: Default::default(),
            targets: &[target],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// What the vertex stage hands on.
#[derive(Debug, Clone, Copy)]
enum Purpose {
    Plain,
    Coloured,
    Numbered,
}

fn entry_point(is_doubled: bool, part: Part, purpose: Purpose) -> &'static str {
    match (is_doubled, part, purpose) {
        (true, _, Purpose::Plain) => "vertex_main",
        (true, _, Purpose::Coloured) => "coloured_main",
        (true, _, Purpose::Numbered) => "numbered_main",
        (false, Part::Caps, Purpose::Plain) => "caps_main",
        (false, Part::Caps, Purpose::Coloured) => "coloured_caps",
        (false, Part::Caps, Purpose::Numbered) => "numbered_caps",
        (false, Part::Walls { .. }, Purpose::Plain) => "walls_main",
        (false, Part::Walls { .. }, Purpose::Coloured) => "coloured_walls",
        (false, Part::Walls { .. }, Purpose::Numbered) => "numbered_walls",
    }
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

fn check_blendable(gpu: &Gpu) -> Result<(), BackendError> {
    let needed = wgpu::Features::FLOAT32_BLENDABLE;
    if gpu.device.features().contains(needed) {
        return Ok(());
    }
    Err(BackendError::Unsupported {
        capability: "blending into 32-bit floats".to_owned(),
        adapter: gpu.facts.name.clone(),
    })
}

/// Depth and stencil tested but left as they are.
fn unchanged(compare: wgpu::CompareFunction) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH_STENCIL_FORMAT,
        depth_write_enabled: Some(false),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState {
            write_mask: 0,
            ..Default::default()
        },
        bias: Default::default(),
    }
}

/// Fragments behind the surface are those that the reversed depth test, `Greater`, fails.
fn add_state(depth: DepthRule) -> wgpu::DepthStencilState {
    unchanged(match depth {
        DepthRule::Fail => wgpu::CompareFunction::LessEqual,
        DepthRule::Pass => wgpu::CompareFunction::Greater,
    })
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
