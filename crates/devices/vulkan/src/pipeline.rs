// SPDX-License-Identifier: MIT OR Apache-2.0
//! Graphics pipelines of the surface and the fill.
//!
//! Depth and stencil states are those of the frame's program, so a rule means here what it means in
//! the wgpu backends; viewport and scissor are dynamic, and depth bounds where they are tested.

use crate::fixtures::Fixtures;
use crate::owned::Owned;
use crate::shader_modules::ModuleKey;
use crate::{Gpu, VertexStage};
use ash::vk;
use std::ffi::CString;
use std::sync::Arc;
use terrafill_contract::{DeviceError, SurfaceLook};
use terrafill_shaders::{HandsOn, SpirvStage};
use terrafill_stencil::{
    CoverInstance, DepthRule, FaceEffect, FaceSet, StencilRule, StencilTest, VolumeState,
};

/// A geometry shader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct GeometryStage {
    /// GLSL, relative to `shaders/`.
    pub path: &'static str,
    /// What it hands on besides the position.
    pub hands_on: HandsOn,
    /// Makes bottom caps.
    pub draws_bottom: bool,
    /// Makes the walls that are turned over, and nothing else: front and back are exchanged.
    pub is_turned: bool,
}

/// A fragment shader, or none for passes without colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Fragments {
    /// Depth and stencil only.
    None,
    /// WGSL module and entry point.
    Shader {
        /// Relative to `shaders/`.
        path: &'static str,
        /// Its entry point.
        entry_point: &'static str,
    },
}

/// What a vertex is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum VertexFormat {
    /// Nothing: the shader has its number.
    Number,
    /// Three `f32`, 12 bytes.
    Metres,
    /// Three `i32`, 12 bytes.
    Fixed,
    /// Three `i32` and a `u32`, 16 bytes.
    FixedAndFlag,
    /// A `u32`, 4 bytes.
    Word,
    /// A [`terrafill_stencil::CoverInstance`] for each instance, and the vertex's number.
    Cover,
}

/// How vertices become primitives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Topology {
    /// One each.
    Points,
    /// Three each.
    Triangles,
    /// Strips of triangles that the largest index ends.
    Strips,
    /// Strips of lines that the largest index ends.
    LineStrips,
    /// Six each: corners, and between them those of the neighbours.
    TrianglesWithAdjacency,
    /// Strips of triangles that the largest index ends: after each corner one of a neighbour.
    StripsWithAdjacency,
    /// Four each: two ends, before and behind them those of what is next to the line.
    LinesWithAdjacency,
    /// So many each, for stages that divide patches.
    Patches(u32),
}

impl Topology {
    /// As Vulkan names it, and whether the largest index ends a primitive and begins another.
    fn vulkan(self) -> (vk::PrimitiveTopology, bool) {
        use vk::PrimitiveTopology as Named;
        match self {
            Self::Points => (Named::POINT_LIST, false),
            Self::Triangles => (Named::TRIANGLE_LIST, false),
            Self::Strips => (Named::TRIANGLE_STRIP, true),
            Self::LineStrips => (Named::LINE_STRIP, true),
            Self::TrianglesWithAdjacency => (Named::TRIANGLE_LIST_WITH_ADJACENCY, false),
            Self::StripsWithAdjacency => (Named::TRIANGLE_STRIP_WITH_ADJACENCY, true),
            Self::LinesWithAdjacency => (Named::LINE_LIST_WITH_ADJACENCY, false),
            Self::Patches(_) => (Named::PATCH_LIST, false),
        }
    }
}

/// What a pipeline draws into, and when.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PipelineState {
    /// The surface: nearest depth wins. With a picture, set 1 is that picture with its sampler.
    Surface(SurfaceLook),
    /// Volumes, or a triangle over the screen in their stead.
    Volumes(VolumeState),
    /// Into the colour target, by a shader that reads the accumulated numbers.
    Resolve,
}

impl From<VolumeState> for PipelineState {
    fn from(state: VolumeState) -> Self {
        Self::Volumes(state)
    }
}

/// What a pass draws into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PassTarget {
    Stencil,
    Colour,
    Numbers,
    /// As `Colour`, shaders reading depth.
    Textured,
    Probe,
}

impl PipelineState {
    pub(crate) fn target(self) -> PassTarget {
        match self {
            Self::Volumes(
                VolumeState::Mark {
                    has_colour: false, ..
                }
                | VolumeState::Count { .. },
            ) => PassTarget::Stencil,
            Self::Volumes(VolumeState::Accumulate { .. }) => PassTarget::Numbers,
            Self::Volumes(_) | Self::Surface(_) | Self::Resolve => PassTarget::Colour,
        }
    }

    fn faces(self) -> FaceSet {
        match self {
            Self::Surface(look) if !look.draws_back_faces => FaceSet::Front,
            Self::Volumes(state) => state.faces(),
            Self::Resolve | Self::Surface(_) => FaceSet::Both,
        }
    }
}

/// All that makes a pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PipelineDescriptor {
    /// Vertex shader.
    pub vertex: VertexStage,
    /// Geometry shader.
    pub geometry: Option<GeometryStage>,
    /// Fragment shader.
    pub fragments: Fragments,
    /// Vertices.
    pub format: VertexFormat,
    /// Primitives.
    pub topology: Topology,
    /// Tests and targets.
    pub state: PipelineState,
    /// The surface's depth must lie within bounds set for each draw.
    pub depth_bounds: bool,
}

impl PipelineDescriptor {
    /// Triangles by `vertex_main` and `fragment_main` of one WGSL file.
    #[must_use]
    pub fn of_shader(path: &'static str, format: VertexFormat, state: PipelineState) -> Self {
        Self {
            vertex: VertexStage {
                path,
                entry_point: "vertex_main",
                bends_footprints: false,
            },
            geometry: None,
            fragments: Fragments::Shader {
                path,
                entry_point: "fragment_main",
            },
            format,
            topology: Topology::Triangles,
            state,
            depth_bounds: false,
        }
    }

    /// The same of volumes, by the entry points that shaders of volumes have for each state.
    #[must_use]
    pub fn of_volumes(path: &'static str, format: VertexFormat, state: VolumeState) -> Self {
        let (vertex, fragment) = match state {
            VolumeState::Colour { .. } => ("coloured_main", Some("region_colour")),
            VolumeState::Accumulate { depth, .. } => match depth {
                DepthRule::Fail | DepthRule::Always => ("numbered_main", Some("number_behind")),
                DepthRule::Pass => ("numbered_main", Some("number_before")),
            },
            // As in wgpu, where a pass with a target wants a shader for it.
            VolumeState::Mark { has_colour, .. } => {
                ("vertex_main", has_colour.then_some("no_colour"))
            }
            VolumeState::Count { .. } => ("vertex_main", None),
        };
        let mut own = Self::of_shader(path, format, state.into());
        own.vertex.entry_point = vertex;
        own.fragments = fragment.map_or(Fragments::None, |entry_point| Fragments::Shader {
            path,
            entry_point,
        });
        own
    }
}

/// A pipeline.
#[derive(Debug)]
pub struct Pipeline {
    pub(crate) owned: OwnedPipeline,
    pub(crate) descriptor: PipelineDescriptor,
}

impl Pipeline {
    /// Makes a pipeline.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device lacks geometry shaders or depth bounds and the
    /// pipeline needs them, [`DeviceError::Shader`], [`DeviceError::OutOfMemory`].
    pub fn new(gpu: &Arc<Gpu>, descriptor: PipelineDescriptor) -> Result<Self, DeviceError> {
        let features = gpu.facts.features;
        let needs = |is_needed: bool, is_there, what| gpu.require(!is_needed || is_there, what);
        let makes_primitives = descriptor.geometry.is_some();
        needs(makes_primitives, features.geometry_shader, "geometryShader")?;
        needs(
            descriptor.depth_bounds,
            features.depth_bounds,
            "depthBounds",
        )?;
        let accumulates = descriptor.state.target() == PassTarget::Numbers;
        needs(
            accumulates,
            features.blends_float,
            "blending into R32_SFLOAT",
        )?;
        Ok(Self {
            owned: create(gpu, &descriptor)?,
            descriptor,
        })
    }

    pub(crate) fn reads_numbers(&self) -> bool {
        self.descriptor.state == PipelineState::Resolve
    }
}

/// A pipeline of a device.
pub(crate) type OwnedPipeline = Owned<vk::Pipeline>;

/// What a call made; one pipeline was asked for.
///
/// # Safety
/// It was made on this device, and nobody else has it.
unsafe fn counted(
    gpu: &Arc<Gpu>,
    made: Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)>,
) -> Result<OwnedPipeline, DeviceError> {
    let first = made.map(|pipelines| pipelines.first().copied().unwrap_or_default());
    // SAFETY: the caller's promise; submissions are waited for.
    let owned = unsafe { Owned::new(gpu, "pipeline", first.map_err(|(_, error)| error)) }?;
    gpu.work.count_pipeline();
    Ok(owned)
}

/// # Safety
/// What the structure points at is of this device, and the stages' interfaces fit each other.
pub(crate) unsafe fn graphics(
    gpu: &Arc<Gpu>,
    info: &vk::GraphicsPipelineCreateInfo<'_>,
) -> Result<OwnedPipeline, DeviceError> {
    let (none, infos) = (vk::PipelineCache::null(), std::slice::from_ref(info));
    // SAFETY: the caller's promise.
    unsafe { counted(gpu, gpu.device.create_graphics_pipelines(none, infos, None)) }
}

/// # Safety
/// What the structure points at is of this device, and the shader finds what it reads.
pub(crate) unsafe fn compute(
    gpu: &Arc<Gpu>,
    info: &vk::ComputePipelineCreateInfo<'_>,
) -> Result<OwnedPipeline, DeviceError> {
    let (none, infos) = (vk::PipelineCache::null(), std::slice::from_ref(info));
    // SAFETY: the caller's promise.
    unsafe { counted(gpu, gpu.device.create_compute_pipelines(none, infos, None)) }
}

/// A shader of a pipeline.
pub(crate) struct ShaderStage {
    flag: vk::ShaderStageFlags,
    module: vk::ShaderModule,
    entry_point: CString,
}

impl ShaderStage {
    pub(crate) fn new(
        gpu: &Gpu,
        flag: vk::ShaderStageFlags,
        key: ModuleKey,
        entry_point: &str,
    ) -> Result<Self, DeviceError> {
        let module = gpu.shader_modules.get(&gpu.device, key)?;
        Self::of_module(flag, module, entry_point)
    }

    pub(crate) fn of_module(
        flag: vk::ShaderStageFlags,
        module: vk::ShaderModule,
        entry_point: &str,
    ) -> Result<Self, DeviceError> {
        let name = CString::new(entry_point).map_err(|error| DeviceError::Shader {
            name: entry_point.to_owned(),
            message: error.to_string(),
        })?;
        Ok(Self {
            flag,
            module,
            entry_point: name,
        })
    }

    pub(crate) fn info(&self) -> vk::PipelineShaderStageCreateInfo<'_> {
        vk::PipelineShaderStageCreateInfo::default()
            .stage(self.flag)
            .module(self.module)
            .name(&self.entry_point)
    }
}

fn create(gpu: &Arc<Gpu>, descriptor: &PipelineDescriptor) -> Result<OwnedPipeline, DeviceError> {
    let vertex = ModuleKey::Vertex(descriptor.vertex);
    let name = descriptor.vertex.entry_point;
    let mut stages = vec![ShaderStage::new(
        gpu,
        vk::ShaderStageFlags::VERTEX,
        vertex,
        name,
    )?];
    if let Some(geometry) = &descriptor.geometry {
        let key = ModuleKey::Geometry(geometry.path, geometry.hands_on);
        let flag = vk::ShaderStageFlags::GEOMETRY;
        stages.push(ShaderStage::new(gpu, flag, key, "main")?);
    }
    if let Fragments::Shader { path, entry_point } = descriptor.fragments {
        let key = ModuleKey::Wgsl(SpirvStage::Fragment, path, entry_point);
        let flag = vk::ShaderStageFlags::FRAGMENT;
        stages.push(ShaderStage::new(gpu, flag, key, entry_point)?);
    }
    let is_turned = descriptor.geometry.is_some_and(|stage| stage.is_turned);
    // `DRAWS_BOTTOM` and `TURNED`; a `bool` constant takes 4 bytes in SPIR-V.
    let draws_bottom = descriptor.geometry.is_none_or(|stage| stage.draws_bottom);
    let write_mask = match descriptor.state {
        PipelineState::Volumes(VolumeState::Mark { .. } | VolumeState::Count { .. }) => {
            vk::ColorComponentFlags::empty()
        }
        _ => vk::ColorComponentFlags::RGBA,
    };
    let target = descriptor.state.target();
    let blends = [vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(write_mask)
        .blend_enable(target == PassTarget::Numbers)
        .src_color_blend_factor(vk::BlendFactor::ONE)
        .dst_color_blend_factor(vk::BlendFactor::ONE)
        .color_blend_op(vk::BlendOp::ADD)];
    let has_colour = target != PassTarget::Stencil;
    let layout = match descriptor.state {
        PipelineState::Surface(look) if look.has_picture => gpu.fixtures.picture_layout,
        _ => gpu.fixtures.pipeline_layout,
    };
    let render_pass = render_pass(&gpu.fixtures, descriptor.state);
    Assembly {
        stages: &stages,
        geometry_constants: &[draws_bottom, is_turned].map(u32::from),
        format: descriptor.format,
        topology: descriptor.topology,
        faces: descriptor.state.faces(),
        is_turned,
        depth_bounds: descriptor.depth_bounds,
        blends: if has_colour { &blends } else { &[] },
        ..Assembly::new(layout, render_pass, depth_stencil(descriptor.state))
    }
    .create(gpu)
}

/// All that makes a pipeline, its shaders made.
pub(crate) struct Assembly<'a> {
    pub(crate) stages: &'a [ShaderStage],
    /// By number, of the geometry shader.
    pub(crate) geometry_constants: &'a [u32],
    pub(crate) format: VertexFormat,
    pub(crate) topology: Topology,
    pub(crate) faces: FaceSet,
    /// Front faces are clockwise.
    pub(crate) is_turned: bool,
    pub(crate) depth_stencil: vk::PipelineDepthStencilStateCreateInfo<'a>,
    pub(crate) depth_bounds: bool,
    /// One for each colour target.
    pub(crate) blends: &'a [vk::PipelineColorBlendAttachmentState],
    pub(crate) layout: vk::PipelineLayout,
    pub(crate) render_pass: vk::RenderPass,
}

impl Assembly<'_> {
    /// Triangles of numbered vertices, both faces, without colour and as yet without a shader.
    pub(crate) fn new(
        layout: vk::PipelineLayout,
        render_pass: vk::RenderPass,
        depth_stencil: vk::PipelineDepthStencilStateCreateInfo<'static>,
    ) -> Self {
        Self {
            stages: &[],
            geometry_constants: &[],
            format: VertexFormat::Number,
            topology: Topology::Triangles,
            faces: FaceSet::Both,
            is_turned: false,
            depth_stencil,
            depth_bounds: false,
            blends: &[],
            layout,
            render_pass,
        }
    }

    pub(crate) fn create(&self, gpu: &Arc<Gpu>) -> Result<OwnedPipeline, DeviceError> {
        let entries: Vec<_> = (0..)
            .zip(self.geometry_constants)
            .map(|(constant_id, constant)| vk::SpecializationMapEntry {
                constant_id,
                offset: 4 * constant_id,
                size: size_of_val(constant),
            })
            .collect();
        let constants = vk::SpecializationInfo::default()
            .map_entries(&entries)
            .data(bytemuck::cast_slice(self.geometry_constants));
        let stages = self.stages.iter().map(|stage| match stage.flag {
            vk::ShaderStageFlags::GEOMETRY => stage.info().specialization_info(&constants),
            _ => stage.info(),
        });
        let stages: Vec<_> = stages.collect();
        let (bindings, attributes) = vertex_input(self.format);
        let input = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(&bindings)
            .vertex_attribute_descriptions(&attributes);
        let (topology, restarts) = self.topology.vulkan();
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(topology)
            .primitive_restart_enable(restarts);
        let corners = match self.topology {
            Topology::Patches(corners) => corners,
            _ => 0,
        };
        let patches =
            vk::PipelineTessellationStateCreateInfo::default().patch_control_points(corners);
        let viewport = vk::PipelineViewportStateCreateInfo::default()
            .viewport_count(1)
            .scissor_count(1);
        let rasterization = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(vk::PolygonMode::FILL)
            .cull_mode(match self.faces {
                FaceSet::Both => vk::CullModeFlags::NONE,
                FaceSet::Front => vk::CullModeFlags::BACK,
                FaceSet::Back => vk::CullModeFlags::FRONT,
            })
            // The viewport's negative height turns y up, as WGSL has it.
            .front_face(if self.is_turned {
                vk::FrontFace::CLOCKWISE
            } else {
                vk::FrontFace::COUNTER_CLOCKWISE
            })
            .line_width(1.0);
        let multisample = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let depth_stencil = self
            .depth_stencil
            .depth_bounds_test_enable(self.depth_bounds);
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(self.blends);
        let dynamic_states = [
            vk::DynamicState::VIEWPORT,
            vk::DynamicState::SCISSOR,
            vk::DynamicState::DEPTH_BOUNDS,
        ];
        let dynamic_count = if self.depth_bounds { 3 } else { 2 };
        let dynamic = vk::PipelineDynamicStateCreateInfo::default()
            .dynamic_states(&dynamic_states[..dynamic_count]);
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&rasterization)
            .multisample_state(&multisample)
            .depth_stencil_state(&depth_stencil)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(self.layout)
            .render_pass(self.render_pass)
            .subpass(0);
        let info = match corners {
            0 => info,
            _ => info.tessellation_state(&patches),
        };
        // SAFETY: the structures live through the call; the stages' interfaces fit each other, which
        // the tests with the validation layer on hold down.
        unsafe { graphics(gpu, &info) }
    }
}

/// Passes that differ in what they load are compatible.
fn render_pass(fixtures: &Fixtures, state: PipelineState) -> vk::RenderPass {
    match state {
        PipelineState::Surface(_) => fixtures.surface,
        PipelineState::Volumes(VolumeState::Accumulate { .. }) => fixtures.numbers,
        _ => fixtures.fill(false, state.target() == PassTarget::Colour),
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "the stride of an instance is a handful of bytes"
)]
fn vertex_input(
    format: VertexFormat,
) -> (
    Vec<vk::VertexInputBindingDescription>,
    Vec<vk::VertexInputAttributeDescription>,
) {
    let attribute = |location, format, offset| vk::VertexInputAttributeDescription {
        location,
        binding: 0,
        format,
        offset,
    };
    let position = |format| attribute(0, format, 0);
    let (stride, attributes) = match format {
        VertexFormat::Number => return (Vec::new(), Vec::new()),
        VertexFormat::Metres => (12, vec![position(vk::Format::R32G32B32_SFLOAT)]),
        VertexFormat::Word => (4, vec![position(vk::Format::R32_UINT)]),
        VertexFormat::Cover => (
            CoverInstance::STRIDE as u32,
            vec![
                position(vk::Format::R32G32B32A32_SFLOAT),
                attribute(1, vk::Format::R32_UINT, 16),
            ],
        ),
        VertexFormat::Fixed => (12, vec![position(vk::Format::R32G32B32_SINT)]),
        VertexFormat::FixedAndFlag => (
            16,
            vec![
                position(vk::Format::R32G32B32_SINT),
                attribute(1, vk::Format::R32_UINT, 12),
            ],
        ),
    };
    let binding = vk::VertexInputBindingDescription {
        binding: 0,
        stride,
        input_rate: match format {
            VertexFormat::Cover => vk::VertexInputRate::INSTANCE,
            _ => vk::VertexInputRate::VERTEX,
        },
    };
    (vec![binding], attributes)
}

/// Counting behind the surface is right wherever the eye is and whatever the near plane cuts
/// (Carmack, 2000; Everitt and Kilgard, 2002); counting in front of it (Heidmann, 1991) touches
/// fewer fragments where the surface is close.
pub(crate) fn depth_stencil(
    state: PipelineState,
) -> vk::PipelineDepthStencilStateCreateInfo<'static> {
    let base = vk::PipelineDepthStencilStateCreateInfo::default();
    let tested = base.depth_test_enable(true);
    let nearer = tested.depth_compare_op(vk::CompareOp::GREATER);
    match state {
        PipelineState::Surface(_) => nearer.depth_write_enable(true),
        PipelineState::Volumes(VolumeState::Mark { rule, .. }) => {
            let (front, back, mask) = rule.effects();
            nearer
                .stencil_test_enable(true)
                .front(mark_face(rule, front, mask))
                .back(mark_face(rule, back, mask))
        }
        PipelineState::Volumes(VolumeState::Count { .. }) | PipelineState::Resolve => base,
        PipelineState::Volumes(VolumeState::Accumulate { depth, .. }) => {
            tested.depth_compare_op(match depth {
                // The complement of `Greater`.
                DepthRule::Fail => vk::CompareOp::LESS_OR_EQUAL,
                DepthRule::Pass => vk::CompareOp::GREATER,
                DepthRule::Always => vk::CompareOp::ALWAYS,
            })
        }
        PipelineState::Volumes(VolumeState::Colour {
            test,
            is_before_surface,
            ..
        }) => {
            let coloured = stencil_test(test);
            if is_before_surface {
                let nearer = coloured.depth_compare_op(vk::CompareOp::GREATER);
                return nearer.depth_test_enable(true);
            }
            coloured
        }
    }
}

/// Whatever the depth, or wherever there is a surface, where the stencil says so.
pub(crate) fn stencil_test(test: StencilTest) -> vk::PipelineDepthStencilStateCreateInfo<'static> {
    let face = vk::StencilOpState {
        fail_op: vk::StencilOp::KEEP,
        pass_op: if test.zeroes {
            vk::StencilOp::ZERO
        } else {
            vk::StencilOp::KEEP
        },
        depth_fail_op: vk::StencilOp::KEEP,
        compare_op: if test.is_equal {
            vk::CompareOp::EQUAL
        } else {
            vk::CompareOp::NOT_EQUAL
        },
        compare_mask: u32::from(test.read_mask),
        write_mask: if test.zeroes { 0xff } else { 0 },
        reference: u32::from(test.reference),
    };
    // At depth 0 a cover is as far as the sky.
    let depth = if test.skips_sky {
        vk::CompareOp::LESS
    } else {
        vk::CompareOp::ALWAYS
    };
    vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(test.skips_sky)
        .depth_compare_op(depth)
        .stencil_test_enable(true)
        .front(face)
        .back(face)
}

fn mark_face(rule: StencilRule, effect: FaceEffect, mask: u8) -> vk::StencilOpState {
    let operation = match effect {
        FaceEffect::Invert => vk::StencilOp::INVERT,
        FaceEffect::Add => vk::StencilOp::INCREMENT_AND_WRAP,
        FaceEffect::Take => vk::StencilOp::DECREMENT_AND_WRAP,
    };
    let keep = vk::StencilOp::KEEP;
    let (pass_op, depth_fail_op) = match rule.depth {
        DepthRule::Fail => (keep, operation),
        DepthRule::Pass => (operation, keep),
        DepthRule::Always => (operation, operation),
    };
    vk::StencilOpState {
        fail_op: keep,
        pass_op,
        depth_fail_op,
        compare_op: vk::CompareOp::ALWAYS,
        compare_mask: 0,
        write_mask: u32::from(mask),
        reference: 0,
    }
}
