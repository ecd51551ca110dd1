// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipelines of the compute pass, and those that draw volumes.

use crate::{ComputeVariant, Expansion, GpuCulling, Transform};
use std::collections::HashMap;
use terrafill_contract::DeviceError;
use terrafill_gpu::{Gpu, HandedOn, VolumeFill, VolumeShader, vertex_layout};
use terrafill_stencil::{Holding, VolumeState};

/// What each bind group holds, by its number; 0 holds view and regions.
#[derive(Debug)]
pub(crate) struct Bindings {
    /// 1: positions and indices of the scene.
    pub(crate) geometry: wgpu::BindGroupLayout,
    /// 2: work and expanded indices.
    pub(crate) expansion: wgpu::BindGroupLayout,
    /// 3: draws, and what decides on them.
    pub(crate) culling: wgpu::BindGroupLayout,
}

const READ: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: true };
const WRITTEN: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: false };

impl Bindings {
    fn new(gpu: &Gpu) -> Self {
        let compute = wgpu::ShaderStages::COMPUTE;
        let both = compute | wgpu::ShaderStages::VERTEX;
        let uniform = wgpu::BufferBindingType::Uniform;
        let culling = [WRITTEN, READ, uniform, WRITTEN];
        Self {
            geometry: gpu.buffer_layout("meshes", both, &[READ, READ]),
            expansion: gpu.buffer_layout("expansion", compute, &[READ, WRITTEN]),
            culling: gpu.buffer_layout("culling", compute, &culling),
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
    volumes: HashMap<VolumeState, wgpu::RenderPipeline>,
}

/// Layouts of the groups that an entry point of the compute pass may read, 0 first.
type Groups<'a> = [Option<&'a wgpu::BindGroupLayout>; 4];

fn compute_pipeline(
    fill: &VolumeFill,
    (path, entry_point): (&str, &str),
    groups: &[Option<&wgpu::BindGroupLayout>],
    constants: &[(&str, f64)],
) -> Result<wgpu::ComputePipeline, DeviceError> {
    let (gpu, module) = (fill.gpu(), fill.shader(path)?);
    Ok(gpu.compute_pipeline(entry_point, &module, entry_point, groups, constants))
}

fn expand_pipeline(
    fill: &VolumeFill,
    all: &Groups<'_>,
    variant: ComputeVariant,
) -> Result<wgpu::ComputePipeline, DeviceError> {
    let (entry_point, groups) = match (variant.expansion, variant.culling) {
        // No view is known yet.
        (Expansion::Cached, _) => ("expand_all", &[None, all[1], all[2]] as &[_]),
        (Expansion::PerFrame, GpuCulling::Off) => ("expand_all", &all[..3]),
        (Expansion::PerFrame, GpuCulling::Regions) => ("expand_drawn", &all[..]),
        (Expansion::PerFrame, GpuCulling::Triangles) => ("expand_visible", &all[..]),
    };
    compute_pipeline(fill, ("compute/expand.wgsl", entry_point), groups, &[])
}

fn cull_pipeline(
    fill: &VolumeFill,
    all: &Groups<'_>,
    culling: GpuCulling,
) -> Result<wgpu::ComputePipeline, DeviceError> {
    // Two groups more than it reads: pipelines of one pass whose layouts differ before a group
    // disturb that group (Vulkan 1.3, "Pipeline Layout Compatibility"), and wgpu does not bind it
    // again where a layout has a gap.
    let tests_pieces = f64::from(u8::from(culling == GpuCulling::Triangles));
    let constants = [("TESTS_PIECES", tests_pieces)];
    compute_pipeline(fill, ("compute/cull.wgsl", "cull_main"), all, &constants)
}

impl Pipelines {
    pub(crate) fn new(fill: &VolumeFill, variant: ComputeVariant) -> Result<Self, DeviceError> {
        let gpu = fill.gpu();
        let bindings = Bindings::new(&gpu);
        let groups: Groups<'_> = [
            Some(fill.frame_layout()),
            Some(&bindings.geometry),
            Some(&bindings.expansion),
            Some(&bindings.culling),
        ];
        let cull = match variant.culling {
            GpuCulling::Off => None,
            culling => Some(cull_pipeline(fill, &groups, culling)?),
        };
        let place = match variant.transform {
            Transform::VertexStage => None,
            Transform::ComputeStage => {
                let entry_point = ("compute/expand.wgsl", "place_corners");
                Some(compute_pipeline(fill, entry_point, &groups[..3], &[])?)
            }
        };
        Ok(Self {
            place,
            transform: variant.transform,
            expand: expand_pipeline(fill, &groups, variant)?,
            cull,
            volume_shader: fill.shader("compute/fill.wgsl")?,
            volume_layout: gpu.pipeline_layout("compute", &groups[..2]),
            volumes: HashMap::new(),
            bindings,
        })
    }

    /// Makes the pipeline of a state unless it is there.
    pub(crate) fn ensure(&mut self, gpu: &Gpu, state: VolumeState) {
        if !self.volumes.contains_key(&state) {
            let pipeline = self.volume_pipeline(gpu, state);
            self.volumes.insert(state, pipeline);
        }
    }

    /// Those of the compute pass.
    pub(crate) fn of_compute(&self) -> u64 {
        1 + u64::from(self.cull.is_some()) + u64::from(self.place.is_some())
    }

    /// What the others are for.
    pub(crate) fn holdings(&self) -> impl Iterator<Item = Holding> {
        Holding::pipelines(self.volumes.keys().copied().map(VolumeState::feature))
    }

    /// A pipeline that [`Pipelines::ensure`] made.
    pub(crate) fn volume(&self, state: VolumeState) -> Option<&wgpu::RenderPipeline> {
        self.volumes.get(&state)
    }

    fn volume_pipeline(&self, gpu: &Gpu, state: VolumeState) -> wgpu::RenderPipeline {
        let is_placed = self.transform == Transform::ComputeStage;
        let attributes = wgpu::vertex_attr_array![0 => Float32x4];
        let corner = [vertex_layout(&attributes)];
        let shader = VolumeShader {
            module: &self.volume_shader,
            layout: &self.volume_layout,
            vertex_entry: match (HandedOn::of(state), is_placed) {
                (HandedOn::Nothing, false) => "vertex_main",
                (HandedOn::Nothing, true) => "placed_main",
                (HandedOn::Number, false) => "numbered_main",
                (HandedOn::Number, true) => "placed_numbered",
                (HandedOn::Colour, false) => "coloured_main",
                (HandedOn::Colour, true) => "placed_coloured",
            },
            constants: &[],
            buffers: if is_placed { &corner } else { &[] },
            strip_index_format: None,
            front_face: wgpu::FrontFace::Ccw,
            discards: false,
        };
        shader.pipeline(gpu, state, false)
    }
}
