// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipelines of any stages that draw into the colour and depth targets as the surface does, both faces
//! kept, and compute pipelines beside them.

use crate::pipeline::{
    Assembly, OwnedPipeline, PipelineState, ShaderStage, compute, depth_stencil,
};
use crate::shader_modules::ModuleKey;
use crate::{Gpu, Resources, Topology, VertexFormat};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::{DeviceError, SurfaceLook};
use terrafill_shaders::SpirvStage;

/// Where a shader comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shader {
    /// A WGSL module.
    Wgsl {
        /// Relative to `shaders/`.
        path: &'static str,
        /// Its entry point.
        entry_point: &'static str,
    },
    /// SPIR-V that was compiled beforehand, by its name ([`terrafill_shaders::compiled_spirv`]).
    Compiled(&'static str),
}

impl Shader {
    fn key(self, stage: SpirvStage) -> ModuleKey {
        match self {
            Self::Wgsl { path, entry_point } => ModuleKey::Wgsl(stage, path, entry_point),
            Self::Compiled(name) => ModuleKey::Compiled(name),
        }
    }

    fn entry_point(self) -> &'static str {
        match self {
            Self::Wgsl { entry_point, .. } => entry_point,
            Self::Compiled(_) => "main",
        }
    }
}

/// A compiled geometry shader and what one invocation of it may emit: drivers have limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GeometryOutput {
    /// Name of its SPIR-V.
    pub name: &'static str,
    /// Vertices.
    pub vertices: u32,
    /// Scalars of a vertex: four of its position, and what it hands on.
    pub components: u32,
}

/// What makes primitives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PrimitiveStages {
    /// A vertex shader, and a geometry shader where there is one.
    Vertices {
        /// WGSL.
        vertex: Shader,
        /// Makes other primitives of each.
        geometry: Option<GeometryOutput>,
        /// What a vertex is made of.
        format: VertexFormat,
        /// How they become primitives.
        topology: Topology,
    },
    /// A vertex shader of numbered corners, one a patch, and compiled shaders that divide patches.
    Divided {
        /// WGSL.
        vertex: Shader,
        /// How often a patch is divided, by the name of its SPIR-V.
        control: &'static str,
        /// Places each vertex of what that gave.
        evaluation: &'static str,
    },
    /// Compiled mesh shaders, by their names.
    Mesh {
        /// Starts workgroups of the other, where there is one.
        task: Option<&'static str>,
        /// Makes primitives.
        mesh: &'static str,
    },
}

/// A pipeline with the resources that its shaders find.
#[derive(Debug)]
pub struct DrawPipeline {
    pub(crate) owned: OwnedPipeline,
    pub(crate) resources: Arc<Resources>,
    stages: PrimitiveStages,
}

impl DrawPipeline {
    /// Makes a pipeline: nearest depth wins.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device lacks a stage, [`DeviceError::OverCapacity`] when
    /// a geometry shader emits more than it allows, [`DeviceError::Shader`],
    /// [`DeviceError::OutOfMemory`].
    pub fn new(
        gpu: &Arc<Gpu>,
        resources: &Arc<Resources>,
        stages: PrimitiveStages,
        fragment: Shader,
    ) -> Result<Self, DeviceError> {
        gpu.require(resources.is_on(gpu), "resources of another device")?;
        let mut shaders = Vec::new();
        let (format, topology) = match stages {
            PrimitiveStages::Vertices {
                vertex,
                geometry,
                format,
                topology,
            } => {
                let stage = match (topology, geometry) {
                    (Topology::Points, None) => SpirvStage::PointVertex,
                    _ => SpirvStage::Vertex,
                };
                shaders.push((vk::ShaderStageFlags::VERTEX, vertex, stage));
                if let Some(output) = geometry {
                    check_output(gpu, output)?;
                    let shader = Shader::Compiled(output.name);
                    shaders.push((vk::ShaderStageFlags::GEOMETRY, shader, stage));
                }
                (format, topology)
            }
            PrimitiveStages::Divided {
                vertex,
                control,
                evaluation,
            } => {
                gpu.require(gpu.facts.features.tessellation, "tessellationShader")?;
                shaders.extend([
                    (vk::ShaderStageFlags::VERTEX, vertex, SpirvStage::Vertex),
                    (
                        vk::ShaderStageFlags::TESSELLATION_CONTROL,
                        Shader::Compiled(control),
                        SpirvStage::Vertex,
                    ),
                    (
                        vk::ShaderStageFlags::TESSELLATION_EVALUATION,
                        Shader::Compiled(evaluation),
                        SpirvStage::Vertex,
                    ),
                ]);
                (VertexFormat::Number, Topology::Patches(1))
            }
            PrimitiveStages::Mesh { task, mesh } => {
                gpu.require(gpu.mesh.is_some(), "VK_EXT_mesh_shader")?;
                if let Some(task) = task {
                    gpu.require(gpu.facts.features.task_shader, "taskShader")?;
                    let shader = Shader::Compiled(task);
                    shaders.push((vk::ShaderStageFlags::TASK_EXT, shader, SpirvStage::Vertex));
                }
                let shader = Shader::Compiled(mesh);
                shaders.push((vk::ShaderStageFlags::MESH_EXT, shader, SpirvStage::Vertex));
                (VertexFormat::Number, Topology::Triangles)
            }
        };
        shaders.push((
            vk::ShaderStageFlags::FRAGMENT,
            fragment,
            SpirvStage::Fragment,
        ));
        let stages_made: Vec<ShaderStage> = shaders
            .into_iter()
            .map(|(flag, shader, stage)| {
                ShaderStage::new(gpu, flag, shader.key(stage), shader.entry_point())
            })
            .collect::<Result<_, _>>()?;
        let blends = [vk::PipelineColorBlendAttachmentState::default()
            .color_write_mask(vk::ColorComponentFlags::RGBA)];
        let depth = depth_stencil(PipelineState::Surface(SurfaceLook::default()));
        let assembly = Assembly {
            stages: &stages_made,
            format,
            topology,
            blends: &blends,
            ..Assembly::new(resources.layout(), gpu.fixtures.surface, depth)
        };
        Ok(Self {
            owned: assembly.create(gpu)?,
            resources: Arc::clone(resources),
            stages,
        })
    }

    pub(crate) fn is_mesh(&self) -> bool {
        matches!(self.stages, PrimitiveStages::Mesh { .. })
    }

    pub(crate) fn needs_vertices(&self) -> bool {
        match self.stages {
            PrimitiveStages::Vertices { format, .. } => format != VertexFormat::Number,
            PrimitiveStages::Divided { .. } | PrimitiveStages::Mesh { .. } => false,
        }
    }
}

/// Refuses a device without geometry shaders, or whose limits are below this.
pub(crate) fn check_output(gpu: &Gpu, output: GeometryOutput) -> Result<(), DeviceError> {
    gpu.require(gpu.facts.features.geometry_shader, "geometryShader")?;
    let (limits, vertices) = (&gpu.limits, output.vertices);
    DeviceError::check_capacity(
        "vertices that a geometry shader emits",
        vertices,
        limits.max_geometry_output_vertices,
    )?;
    DeviceError::check_capacity(
        "components that a geometry shader emits",
        vertices * output.components,
        limits.max_geometry_total_output_components,
    )
}

/// A compute pipeline with the resources that its shader finds.
#[derive(Debug)]
pub struct ComputePipeline {
    /// Others may have the same with other resources.
    pub(crate) owned: Arc<OwnedPipeline>,
    pub(crate) resources: Arc<Resources>,
}

impl ComputePipeline {
    /// Makes a pipeline.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] for resources of another device, [`DeviceError::Shader`],
    /// [`DeviceError::OutOfMemory`].
    pub fn new(
        gpu: &Arc<Gpu>,
        resources: &Arc<Resources>,
        shader: Shader,
    ) -> Result<Self, DeviceError> {
        gpu.require(resources.is_on(gpu), "resources of another device")?;
        let key = shader.key(SpirvStage::Compute);
        let flag = vk::ShaderStageFlags::COMPUTE;
        let stage = ShaderStage::new(gpu, flag, key, shader.entry_point())?;
        let info = vk::ComputePipelineCreateInfo::default()
            .stage(stage.info())
            .layout(resources.layout());
        Ok(Self {
            // SAFETY: the structures live through the call; the shader was validated.
            owned: Arc::new(unsafe { compute(gpu, &info) }?),
            resources: Arc::clone(resources),
        })
    }

    /// The same pipeline with other resources of the same kinds.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] for resources of other kinds or of another device.
    pub fn rebound(&self, resources: &Arc<Resources>) -> Result<Self, DeviceError> {
        let is_like = self.resources.is_like(resources);
        let gpu = self.owned.gpu();
        gpu.require(is_like, "binding resources of other kinds")?;
        Ok(Self {
            owned: Arc::clone(&self.owned),
            resources: Arc::clone(resources),
        })
    }
}
