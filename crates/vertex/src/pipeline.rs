// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipelines of the stencil and colour passes.

use crate::{ColourWay, Layout, PositionFormat, VertexVariant};
use std::collections::HashMap;
use terrafill_frame::BackendError;
use terrafill_gpu::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, Gpu};

/// Which part of a volume a pipeline draws. Doubled walls are strips, and a strip's restart value
/// belongs to the pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Part {
    Caps,
    Walls { short_indices: bool },
}

/// What a volume does to the stencil where it lies behind the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum StencilRule {
    /// Flip the bits of this number, both faces alike.
    Xor(u8),
    /// Back faces add one, front faces take one away, modulo 256.
    Count,
}

/// Pipelines of one variant on one device, made when first asked for.
#[derive(Debug)]
pub(crate) struct Pipelines {
    variant: VertexVariant,
    volume_shader: wgpu::ShaderModule,
    volume_layout: wgpu::PipelineLayout,
    volumes: HashMap<(Part, StencilRule), wgpu::RenderPipeline>,
    pub(crate) cover: wgpu::RenderPipeline,
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
        let cover = cover_pipeline(
            gpu,
            &pipeline_layout(&[Some(&frame_bindings)]),
            variant.colour,
        )?;
        Ok(Self {
            variant,
            volume_shader,
            volume_layout: pipeline_layout(groups),
            volumes: HashMap::new(),
            cover,
            frame_bindings,
            geometry_bindings,
        })
    }

    /// Makes the pipeline if it is not there yet.
    pub(crate) fn ensure(&mut self, gpu: &Gpu, part: Part, rule: StencilRule) {
        if !self.volumes.contains_key(&(part, rule)) {
            let pipeline = self.volume_pipeline(gpu, part, rule);
            self.volumes.insert((part, rule), pipeline);
        }
    }

    /// A pipeline that [`Pipelines::ensure`] made.
    pub(crate) fn volume(&self, part: Part, rule: StencilRule) -> Option<&wgpu::RenderPipeline> {
        self.volumes.get(&(part, rule))
    }

    fn volume_pipeline(&self, gpu: &Gpu, part: Part, rule: StencilRule) -> wgpu::RenderPipeline {
        let attributes = wgpu::vertex_attr_array![0 => Sint32x3, 1 => Uint32];
        let doubled = [Some(wgpu::VertexBufferLayout {
            array_stride: 16,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &attributes,
        })];
        let is_doubled = self.variant.layout == Layout::Doubled;
        let entry_point = match (is_doubled, part) {
            (true, _) => "vertex_main",
            (false, Part::Caps) => "caps_main",
            (false, Part::Walls { .. }) => "walls_main",
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
                    ..Default::default()
                },
                depth_stencil: Some(depth_fail_state(rule)),
                multisample: Default::default(),
                fragment: (rule == StencilRule::Count).then_some(wgpu::FragmentState {
                    module: &self.volume_shader,
                    entry_point: Some("no_colour"),
                    compilation_options: Default::default(),
                    targets: &[Some(wgpu::ColorTargetState {
                        format: COLOUR_FORMAT,
                        blend: None,
                        write_mask: wgpu::ColorWrites::empty(),
                    })],
                }),
                multiview_mask: None,
                cache: None,
            })
    }
}

/// Depth fail: only what lies behind the surface touches the stencil, so the eye may be inside a
/// volume and the near plane may cut it (Carmack, 2000; Everitt and Kilgard, 2002).
fn depth_fail_state(rule: StencilRule) -> wgpu::DepthStencilState {
    let face = |operation| wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::Always,
        fail_op: wgpu::StencilOperation::Keep,
        depth_fail_op: operation,
        pass_op: wgpu::StencilOperation::Keep,
    };
    let (front, back, write_mask) = match rule {
        StencilRule::Xor(number) => (
            wgpu::StencilOperation::Invert,
            wgpu::StencilOperation::Invert,
            u32::from(number),
        ),
        StencilRule::Count => (
            wgpu::StencilOperation::DecrementWrap,
            wgpu::StencilOperation::IncrementWrap,
            0xff,
        ),
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

fn cover_pipeline(
    gpu: &Gpu,
    layout: &wgpu::PipelineLayout,
    colour: ColourWay,
) -> Result<wgpu::RenderPipeline, BackendError> {
    let shader = gpu.shader("vertex/cover.wgsl")?;
    // XOR: the number is the stencil reference, and the pass leaves the stencil alone. One at a
    // time: anything but 0 is inside, and the cover clears it for the next region.
    let (compare, pass_op, write_mask) = match colour {
        ColourWay::Xor => (
            wgpu::CompareFunction::Equal,
            wgpu::StencilOperation::Keep,
            0,
        ),
        ColourWay::Rectangle => (
            wgpu::CompareFunction::NotEqual,
            wgpu::StencilOperation::Zero,
            0xff,
        ),
    };
    let face = wgpu::StencilFaceState {
        compare,
        fail_op: wgpu::StencilOperation::Keep,
        depth_fail_op: wgpu::StencilOperation::Keep,
        pass_op,
    };
    Ok(gpu
        .device
        .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("cover"),
            layout: Some(layout),
            vertex: wgpu::VertexState {
                module: &shader,
                entry_point: Some("vertex_main"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_STENCIL_FORMAT,
                depth_write_enabled: Some(false),
                depth_compare: Some(wgpu::CompareFunction::Always),
                stencil: wgpu::StencilState {
                    front: face,
                    back: face,
                    read_mask: 0xff,
                    write_mask,
                },
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &shader,
                entry_point: Some("fragment_main"),
                compilation_options: Default::default(),
                targets: &[Some(COLOUR_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        }))
}
