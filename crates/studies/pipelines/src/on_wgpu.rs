// SPDX-License-Identifier: MIT OR Apache-2.0
//! Grids on wgpu, which has no geometry shaders. Its mesh shaders are experimental, where the device offers them.

use crate::draws::{Counted, Draws, Times};
use crate::way::{
    ARGUMENT_BYTES, MESH_CELLS, MESH_SHADERS, PATCH_CELLS, Submission, patch_indices,
};
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError, Picture};
use terrafill_gpu::{DirectPipeline, Gpu, RenderTargets};
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::{Grid, GridConstants};

/// What is drawn.
enum Call {
    Ranges(Vec<Range<u32>>),
    Patches(wgpu::Buffer, u32),
    Indirect {
        arguments: wgpu::Buffer,
        compute: wgpu::ComputePipeline,
        bound: wgpu::BindGroup,
        groups: u32,
    },
    /// Workgroups of a mesh shader, a side.
    Groups(u32),
}

/// A grid by one way.
pub(crate) struct OnWgpu {
    gpu: Arc<Gpu>,
    targets: RenderTargets,
    pipeline: wgpu::RenderPipeline,
    bound: wgpu::BindGroup,
    vertices: Option<wgpu::Buffer>,
    /// Written into `vertices` before each frame.
    sent: Option<Vec<u8>>,
    call: Call,
}

/// Shaders of a way, and how its vertices come; `None` for a mesh shader, which has none.
struct Stages {
    path: &'static str,
    entry_point: &'static str,
    topology: wgpu::PrimitiveTopology,
    format: Option<wgpu::VertexFormat>,
}

fn stages(way: Submission, gpu: &Gpu) -> Result<Option<Stages>, DeviceError> {
    let grid = |entry_point, topology, format| {
        Some(Stages {
            path: "pipelines/grid.wgsl",
            entry_point,
            topology,
            format,
        })
    };
    let points = wgpu::PrimitiveTopology::PointList;
    let triangles = wgpu::PrimitiveTopology::TriangleList;
    let strip = wgpu::PrimitiveTopology::TriangleStrip;
    let metres = Some(wgpu::VertexFormat::Float32x3);
    let word = Some(wgpu::VertexFormat::Uint32);
    match way {
        Submission::SentPoints => Ok(grid("sent_point", points, metres)),
        Submission::SentStrips => Ok(grid("sent_strip", strip, metres)),
        Submission::FetchedPoints => Ok(grid("fetched_point", points, word)),
        Submission::NoBuffer => Ok(grid("no_buffer", triangles, None)),
        Submission::ComputeIndirect => Ok(grid("placed_before", triangles, None)),
        Submission::IndexedPatch => {
            let what = "the number of a primitive in fragment shaders";
            gpu.require(wgpu::Features::PRIMITIVE_INDEX, what)?;
            Ok(Some(Stages {
                path: "pipelines/patch.wgsl",
                entry_point: "vertex_main",
                topology: triangles,
                format: None,
            }))
        }
        Submission::Geometry { .. } => Err(DeviceError::unsupported("geometry shaders", "WebGPU")),
        Submission::Mesh => Ok(None),
    }
}

fn buffer_type(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}

pub(crate) fn uniform_type() -> wgpu::BindingType {
    buffer_type(wgpu::BufferBindingType::Uniform)
}

pub(crate) fn storage_type(read_only: bool) -> wgpu::BindingType {
    buffer_type(wgpu::BufferBindingType::Storage { read_only })
}

/// Of floats that are loaded, not filtered.
pub(crate) fn texture_type(view_dimension: wgpu::TextureViewDimension) -> wgpu::BindingType {
    wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension,
        multisampled: false,
    }
}

impl OnWgpu {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        way: Submission,
        grid: &Grid,
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let stages = stages(way, gpu)?;
        let constants = GridConstants::new(grid);
        let bytes = bytemuck::bytes_of(&constants);
        let constants = gpu.upload("grid constants", bytes, wgpu::BufferUsages::UNIFORM)?;
        let heights = heights(gpu, grid)?;
        let side = grid.cells + 1;
        let is_placed = way == Submission::ComputeIndirect;
        let storage = wgpu::BufferUsages::STORAGE;
        let kept_bytes = u64::from(side).pow(2) * 16;
        let kept = is_placed.then(|| gpu.unwritten("clip positions", kept_bytes, storage));
        // Only a device that offers mesh shaders allows their stage in a layout.
        let stage = match stages {
            Some(_) => wgpu::ShaderStages::VERTEX | wgpu::ShaderStages::COMPUTE,
            None => wgpu::ShaderStages::MESH,
        };
        // Fragments number triangles by the grid's cells.
        let all = stage | wgpu::ShaderStages::FRAGMENT;
        let base = [
            (all, uniform_type()),
            (stage, texture_type(wgpu::TextureViewDimension::D2)),
        ];
        let basic = [
            constants.as_entire_binding(),
            wgpu::BindingResource::TextureView(&heights),
        ];
        let own = (wgpu::ShaderStages::VERTEX, storage_type(true));
        let types = base.into_iter().chain(kept.as_ref().map(|_| own));
        let own = kept.as_ref().map(wgpu::Buffer::as_entire_binding);
        let (layout, bound) = bind(gpu, types, basic.clone().into_iter().chain(own));
        let pipeline = match stages {
            Some(stages) => gpu.direct_pipeline(&DirectPipeline {
                path: stages.path,
                entry_point: stages.entry_point,
                topology: stages.topology,
                format: stages.format,
                layout: &layout,
            })?,
            None => gpu.mesh_pipeline(MESH_SHADERS, &layout)?,
        };
        let bytes = way.vertices(grid);
        let vertices = if bytes.is_empty() {
            None
        } else {
            Some(gpu.upload("vertices", &bytes, wgpu::BufferUsages::VERTEX)?)
        };
        let call = match way {
            Submission::IndexedPatch => {
                let indices = patch_indices();
                let bytes = bytemuck::cast_slice(&indices);
                let indices = gpu.upload("patch", bytes, wgpu::BufferUsages::INDEX)?;
                Call::Patches(indices, (grid.cells / PATCH_CELLS).pow(2))
            }
            Submission::ComputeIndirect => {
                let usage = storage | wgpu::BufferUsages::INDIRECT;
                let arguments = gpu.unwritten("draw arguments", ARGUMENT_BYTES, usage);
                let kept = kept
                    .as_ref()
                    .ok_or(DeviceError::Missing("buffer of vertices"))?;
                let stage = wgpu::ShaderStages::COMPUTE;
                let types = base.into_iter().chain([(stage, storage_type(false)); 2]);
                let own = [kept, &arguments].map(wgpu::Buffer::as_entire_binding);
                let (layout, bound) = bind(gpu, types, basic.into_iter().chain(own));
                let path = "pipelines/expand.wgsl";
                let compute = compute_pipeline(gpu, path, "compute_main", &[Some(&layout)])?;
                Call::Indirect {
                    arguments,
                    compute,
                    bound,
                    groups: side.div_ceil(8),
                }
            }
            Submission::Mesh => Call::Groups(grid.cells / MESH_CELLS),
            _ => Call::Ranges(way.ranges(grid)),
        };
        Ok(Self {
            gpu: Arc::clone(gpu),
            targets: RenderTargets::new(gpu, size)?,
            pipeline,
            bound,
            vertices,
            sent: way.is_sent().then_some(bytes),
            call,
        })
    }

    fn frame(&mut self) -> Result<(), DeviceError> {
        if let (Some(buffer), Some(bytes)) = (&self.vertices, &self.sent) {
            self.gpu.write_buffer(buffer, 0, bytes);
        }
        let mut frame = self.targets.direct_frame();
        if let Call::Indirect {
            compute,
            bound,
            groups,
            ..
        } = &self.call
        {
            let mut pass = frame.encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(compute);
            pass.set_bind_group(0, bound, &[]);
            pass.dispatch_workgroups(*groups, *groups, 1);
        }
        let mut pass = self.targets.cleared_pass(&mut frame);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bound, &[]);
        if let Some(vertices) = &self.vertices {
            pass.set_vertex_buffer(0, vertices.slice(..));
        }
        match &self.call {
            Call::Ranges(ranges) => {
                for range in ranges {
                    pass.draw(range.clone(), 0..1);
                }
            }
            Call::Patches(indices, instances) => {
                pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint16);
                pass.draw_indexed(0..6 * PATCH_CELLS * PATCH_CELLS, 0, 0..*instances);
            }
            Call::Indirect { arguments, .. } => pass.draw_indirect(arguments, 0),
            Call::Groups(side) => pass.draw_mesh_tasks(*side, *side, 1),
        }
        drop(pass);
        self.gpu.queue.submit([frame.encoder.finish()]);
        self.gpu.wait()
    }
}

pub(crate) fn heights(gpu: &Gpu, grid: &Grid) -> Result<wgpu::TextureView, DeviceError> {
    let side = grid.cells + 1;
    let allowed = gpu.device.limits().max_texture_dimension_2d;
    DeviceError::check_capacity("texels along a side of the heights", side, allowed)?;
    let format = wgpu::TextureFormat::R32Float;
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    let texture = gpu.texture("heights", [side, side, 1], 1, format, usage);
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(4 * side),
        rows_per_image: None,
    };
    let texels = bytemuck::cast_slice(&grid.heights);
    gpu.queue
        .write_texture(texture.as_image_copy(), texels, layout, texture.size());
    Ok(texture.create_view(&Default::default()))
}

/// A layout of what stages read, and what they read of it, numbered in this order.
pub(crate) fn bind<'a>(
    gpu: &Gpu,
    types: impl IntoIterator<Item = (wgpu::ShaderStages, wgpu::BindingType)>,
    resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
) -> (wgpu::BindGroupLayout, wgpu::BindGroup) {
    let layout = gpu.mixed_layout("pipelines", types);
    let bound = gpu.bind("pipelines", &layout, resources);
    (layout, bound)
}

pub(crate) fn compute_pipeline(
    gpu: &Gpu,
    path: &'static str,
    entry_point: &'static str,
    layouts: &[Option<&wgpu::BindGroupLayout>],
) -> Result<wgpu::ComputePipeline, DeviceError> {
    let module = gpu.shader(path)?;
    Ok(gpu.compute_pipeline(path, &module, entry_point, layouts, &[]))
}

/// Triangles of vertices that have nothing but numbers.
pub(crate) fn draw_pipeline(
    gpu: &Gpu,
    path: &'static str,
    entry_point: &'static str,
    layout: &wgpu::BindGroupLayout,
) -> Result<wgpu::RenderPipeline, DeviceError> {
    gpu.direct_pipeline(&DirectPipeline {
        path,
        entry_point,
        topology: wgpu::PrimitiveTopology::TriangleList,
        format: None,
        layout,
    })
}

impl Draws for OnWgpu {
    fn draw(&mut self) -> Result<(Picture, Counted), DeviceError> {
        self.frame()?;
        Ok((self.targets.read()?, Counted::default()))
    }

    fn time(&mut self) -> Result<Times, DeviceError> {
        let watch = CpuStopwatch::start();
        self.frame()?;
        let times = Times::since(&watch, None);
        let gpu_ms = self.targets.direct_ms()?;
        Ok(Times { gpu_ms, ..times })
    }
}
