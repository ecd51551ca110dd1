// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipelines of the compute, stencil and colour passes.

use crate::{ComputeVariant, Expansion, GpuCulling, Transform};
use std::collections::HashMap;
use terrafill_frame::{
    BackendError, CoverShape, DepthRule, FaceSet, FillCommand, StencilOperation, StencilRule,
    StencilTest,
};
use terrafill_gpu::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, Gpu};

/// What a volume is drawn for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum State {
    /// Into the stencil, in a pass with or without a colour target.
    Mark { rule: StencilRule, has_colour: bool },
    /// Into nothing, to count fragments.
    Count { faces: FaceSet },
    /// Into the target of numbers.
    Number { depth: DepthRule, faces: FaceSet },
    /// Into the colour target where the stencil says so.
    Colour { test: StencilTest, faces: FaceSet },
}

/// Holds sums of regions' numbers exactly.
pub(crate) const NUMBER_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// What each bind group holds, by its number.
#[derive(Debug)]
pub(crate) struct Bindings {
    /// 0: view and regions.
    pub(crate) frame: wgpu::BindGroupLayout,
    /// 1: positions and indices of the scene.
    pub(crate) geometry: wgpu::BindGroupLayout,
    /// 2: work and expanded indices.
    pub(crate) expansion: wgpu::BindGroupLayout,
    /// 3: draws, and what decides on them.
    pub(crate) culling: wgpu::BindGroupLayout,
    /// 1, where numbers become colours: the target of numbers.
    pub(crate) numbers: wgpu::BindGroupLayout,
}

const READ: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: true };
const WRITTEN: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: false };

impl Bindings {
    fn new(device: &wgpu::Device) -> Self {
        let group = |label, visibility, types: &[wgpu::BufferBindingType]| {
            let entries: Vec<_> = (0..)
                .zip(types)
                .map(|(binding, &ty)| wgpu::BindGroupLayoutEntry {
                    binding,
                    visibility,
                    ty: wgpu::BindingType::Buffer {
                        ty,
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                    count: None,
                })
                .collect();
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries: &entries,
            })
        };
        let compute = wgpu::ShaderStages::COMPUTE;
        let vertex = wgpu::ShaderStages::VERTEX;
        let all = compute | vertex | wgpu::ShaderStages::FRAGMENT;
        let uniform = wgpu::BufferBindingType::Uniform;
        let numbers = wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        };
        Self {
            numbers: device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("numbers"),
                entries: &[numbers],
            }),
            frame: group("view and regions", all, &[uniform, READ]),
            geometry: group("meshes", compute | vertex, &[READ, READ]),
            expansion: group("expansion", compute, &[READ, WRITTEN]),
            culling: group("culling", compute, &[WRITTEN, READ, uniform, WRITTEN]),
        }
    }
}

/// Pipelines of one variant on one device. Those that draw are made when first asked for.
#[derive(Debug)]
pub(crate) struct Pipelines {
    pub(crate) bindings: Bindings,
    pub(crate) expand: wgpu::ComputePipeline,
    pub(crate) cull: Option<wgpu::ComputePipeline>,
    pub(crate) place: Option<wgpu::ComputePipeline>,
    transform: Transform,
    volume_shader: wgpu::ShaderModule,
    volume_layout: wgpu::PipelineLayout,
    volumes: HashMap<State, wgpu::RenderPipeline>,
    cover_shader: wgpu::ShaderModule,
    cover_layout: wgpu::PipelineLayout,
    covers: HashMap<StencilTest, wgpu::RenderPipeline>,
    resolve: Option<wgpu::RenderPipeline>,
}

fn layout(
    device: &wgpu::Device,
    groups: &[Option<&wgpu::BindGroupLayout>],
) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("compute"),
        bind_group_layouts: groups,
        immediate_size: 0,
    })
}

fn expand_pipeline(
    gpu: &Gpu,
    bindings: &Bindings,
    variant: ComputeVariant,
) -> Result<wgpu::ComputePipeline, BackendError> {
    let Bindings {
        frame,
        geometry,
        expansion,
        culling,
        ..
    } = bindings;
    let all = [Some(frame), Some(geometry), Some(expansion), Some(culling)];
    let (entry_point, groups) = match (variant.expansion, variant.culling) {
        // No view is known yet.
        (Expansion::Cached, _) => ("expand_all", &[None, all[1], all[2]] as &[_]),
        (Expansion::PerFrame, GpuCulling::Off) => ("expand_all", &all[..3]),
        (Expansion::PerFrame, GpuCulling::Regions) => ("expand_drawn", &all[..]),
        (Expansion::PerFrame, GpuCulling::Triangles) => ("expand_visible", &all[..]),
    };
    let descriptor = wgpu::ComputePipelineDescriptor {
        label: Some("expand"),
        layout: Some(&layout(&gpu.device, groups)),
        module: &gpu.shader("compute/expand.wgsl")?,
        entry_point: Some(entry_point),
        compilation_options: Default::default(),
        cache: None,
    };
    Ok(gpu.create_compute_pipeline(&descriptor))
}

fn place_pipeline(gpu: &Gpu, bindings: &Bindings) -> Result<wgpu::ComputePipeline, BackendError> {
    let groups = [
        Some(&bindings.frame),
        Some(&bindings.geometry),
        Some(&bindings.expansion),
    ];
    let descriptor = wgpu::ComputePipelineDescriptor {
        label: Some("place"),
        layout: Some(&layout(&gpu.device, &groups)),
        module: &gpu.shader("compute/expand.wgsl")?,
        entry_point: Some("place_corners"),
        compilation_options: Default::default(),
        cache: None,
    };
    Ok(gpu.create_compute_pipeline(&descriptor))
}

fn cull_pipeline(
    gpu: &Gpu,
    bindings: &Bindings,
    culling: GpuCulling,
) -> Result<wgpu::ComputePipeline, BackendError> {
    // Two groups more than it reads: pipelines of one pass whose layouts differ before a group
    // disturb that group (Vulkan 1.3, "Pipeline Layout Compatibility"), and wgpu does not bind it
    // again where a layout has a gap.
    let groups = [
        Some(&bindings.frame),
        Some(&bindings.geometry),
        Some(&bindings.expansion),
        Some(&bindings.culling),
    ];
    let tests_pieces = culling == GpuCulling::Triangles;
    let descriptor = wgpu::ComputePipelineDescriptor {
        label: Some("cull"),
        layout: Some(&layout(&gpu.device, &groups)),
        module: &gpu.shader("compute/cull.wgsl")?,
        entry_point: Some("cull_main"),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &[("TESTS_PIECES", f64::from(u8::from(tests_pieces)))],
            ..Default::default()
        },
        cache: None,
    };
    Ok(gpu.create_compute_pipeline(&descriptor))
}

impl Pipelines {
    pub(crate) fn new(gpu: &Gpu, variant: ComputeVariant) -> Result<Self, BackendError> {
        let device = &gpu.device;
        let bindings = Bindings::new(device);
        let cull = match variant.culling {
            GpuCulling::Off => None,
            culling => Some(cull_pipeline(gpu, &bindings, culling)?),
        };
        let place = match variant.transform {
            Transform::VertexStage => None,
            Transform::ComputeStage => Some(place_pipeline(gpu, &bindings)?),
        };
        Ok(Self {
            place,
            transform: variant.transform,
            expand: expand_pipeline(gpu, &bindings, variant)?,
            cull,
            volume_shader: gpu.shader("compute/fill.wgsl")?,
            volume_layout: layout(device, &[Some(&bindings.frame), Some(&bindings.geometry)]),
            volumes: HashMap::new(),
            cover_shader: gpu.shader("vertex/cover.wgsl")?,
            cover_layout: layout(device, &[Some(&bindings.frame)]),
            covers: HashMap::new(),
            resolve: None,
            bindings,
        })
    }

    /// Makes the pipeline of a step unless it is there.
    ///
    /// # Errors
    /// [`BackendError::Shader`], [`BackendError::Unsupported`].
    pub(crate) fn ensure(
        &mut self,
        gpu: &Gpu,
        command: &FillCommand,
        has_colour: bool,
    ) -> Result<(), BackendError> {
        let state = match command {
            FillCommand::Volumes { rule, .. } => State::Mark {
                rule: *rule,
                has_colour,
            },
            FillCommand::Accumulate { depth, faces, .. } => {
                check_blending(gpu)?;
                State::Number {
                    depth: *depth,
                    faces: *faces,
                }
            }
            FillCommand::Cover {
                test,
                shape: CoverShape::Volume { faces },
                ..
            } => State::Colour {
                test: *test,
                faces: *faces,
            },
            FillCommand::Cover { test, .. } => {
                if !self.covers.contains_key(test) {
                    let pipeline = self.cover_pipeline(gpu, *test);
                    self.covers.insert(*test, pipeline);
                }
                return Ok(());
            }
            FillCommand::Resolve => {
                if self.resolve.is_none() {
                    self.resolve = Some(self.resolve_pipeline(gpu)?);
                }
                return Ok(());
            }
        };
        self.ensure_volumes(gpu, state);
        Ok(())
    }

    /// Makes the pipeline that draws volumes so unless it is there.
    pub(crate) fn ensure_volumes(&mut self, gpu: &Gpu, state: State) {
        if !self.volumes.contains_key(&state) {
            let pipeline = self.volume_pipeline(gpu, state);
            self.volumes.insert(state, pipeline);
        }
    }

    /// A pipeline that [`Pipelines::ensure`] made.
    pub(crate) fn volume(&self, state: State) -> Option<&wgpu::RenderPipeline> {
        self.volumes.get(&state)
    }

    /// As [`Pipelines::volume`].
    pub(crate) fn cover(&self, test: StencilTest) -> Option<&wgpu::RenderPipeline> {
        self.covers.get(&test)
    }

    /// As [`Pipelines::volume`].
    pub(crate) fn resolve(&self) -> Option<&wgpu::RenderPipeline> {
        self.resolve.as_ref()
    }

    fn volume_pipeline(&self, gpu: &Gpu, state: State) -> wgpu::RenderPipeline {
        let fragment_entry = match state {
            State::Mark { .. } => "no_colour",
            State::Count { .. } => "counted",
            State::Number { depth, .. } => match depth {
                DepthRule::Fail => "number_behind",
                DepthRule::Pass => "number_before",
            },
            State::Colour { .. } => "region_colour",
        };
        let is_placed = self.transform == Transform::ComputeStage;
        let vertex_entry = match (state, is_placed) {
            (State::Mark { .. } | State::Count { .. }, false) => "vertex_main",
            (State::Mark { .. } | State::Count { .. }, true) => "placed_main",
            (State::Number { .. }, false) => "numbered_main",
            (State::Number { .. }, true) => "placed_numbered",
            (State::Colour { .. }, false) => "coloured_main",
            (State::Colour { .. }, true) => "placed_coloured",
        };
        let corner = [Some(wgpu::VertexBufferLayout {
            array_stride: 16,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x4],
        })];
        let (faces, target, depth_stencil) = match state {
            State::Mark { rule, has_colour } => {
                let unwritten = wgpu::ColorTargetState {
                    format: COLOUR_FORMAT,
                    blend: None,
                    write_mask: wgpu::ColorWrites::empty(),
                };
                (
                    rule.faces,
                    has_colour.then_some(unwritten),
                    mark_state(rule),
                )
            }
            State::Count { faces } => {
                let always = without_stencil(wgpu::CompareFunction::Always);
                (faces, Some(unwritten()), always)
            }
            State::Number { depth, faces } => (faces, Some(added()), number_state(depth)),
            State::Colour { test, faces } => {
                (faces, Some(COLOUR_FORMAT.into()), colour_state(test))
            }
        };
        gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("volume"),
            layout: Some(&self.volume_layout),
            vertex: wgpu::VertexState {
                module: &self.volume_shader,
                entry_point: Some(vertex_entry),
                compilation_options: Default::default(),
                buffers: if is_placed { &corner } else { &[] },
            },
            primitive: wgpu::PrimitiveState {
                cull_mode: match faces {
                    FaceSet::Both => None,
                    FaceSet::Front => Some(wgpu::Face::Back),
                    FaceSet::Back => Some(wgpu::Face::Front),
                },
                ..Default::default()
            },
            depth_stencil: Some(depth_stencil),
            multisample: Default::default(),
            fragment: target.is_some().then_some(wgpu::FragmentState {
                module: &self.volume_shader,
                entry_point: Some(fragment_entry),
                compilation_options: Default::default(),
                targets: &[target],
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    fn cover_pipeline(&self, gpu: &Gpu, test: StencilTest) -> wgpu::RenderPipeline {
        gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
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

    fn resolve_pipeline(&self, gpu: &Gpu) -> Result<wgpu::RenderPipeline, BackendError> {
        let groups = [Some(&self.bindings.frame), Some(&self.bindings.numbers)];
        let shader = gpu.shader("vertex/resolve.wgsl")?;
        Ok(gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("resolve"),
            layout: Some(&layout(&gpu.device, &groups)),
            vertex: wgpu::VertexState {
                module: &shader,
                entry_point: Some("vertex_main"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: Some(without_stencil(wgpu::CompareFunction::Always)),
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
}

fn check_blending(gpu: &Gpu) -> Result<(), BackendError> {
    if gpu
        .device
        .features()
        .contains(wgpu::Features::FLOAT32_BLENDABLE)
    {
        return Ok(());
    }
    Err(BackendError::Unsupported {
        capability: "blending into 32-bit float targets".to_owned(),
        adapter: gpu.facts.name.clone(),
    })
}

/// The colour target, left alone.
fn unwritten() -> wgpu::ColorTargetState {
    wgpu::ColorTargetState {
        format: COLOUR_FORMAT,
        blend: None,
        write_mask: wgpu::ColorWrites::empty(),
    }
}

/// What a fragment writes is added to what is there.
fn added() -> wgpu::ColorTargetState {
    let add = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::ColorTargetState {
        format: NUMBER_FORMAT,
        blend: Some(wgpu::BlendState {
            color: add,
            alpha: add,
        }),
        write_mask: wgpu::ColorWrites::ALL,
    }
}

/// Fragments behind the surface, or those before it: exactly the others, equal depths included.
fn number_state(depth: DepthRule) -> wgpu::DepthStencilState {
    without_stencil(match depth {
        DepthRule::Fail => wgpu::CompareFunction::LessEqual,
        DepthRule::Pass => wgpu::CompareFunction::Greater,
    })
}

fn without_stencil(depth_compare: wgpu::CompareFunction) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH_STENCIL_FORMAT,
        depth_write_enabled: Some(false),
        depth_compare: Some(depth_compare),
        stencil: Default::default(),
        bias: Default::default(),
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
