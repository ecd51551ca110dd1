// SPDX-License-Identifier: MIT OR Apache-2.0
//! Grids on Vulkan itself, which has every stage.

use crate::draws::{Counted, Draws, Times, count};
use crate::way::{
    ARGUMENT_BYTES, MESH_CELLS, MESH_SHADERS, PATCH_CELLS, Submission, emitted_by_point,
    geometry_shader, patch_indices,
};
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError, Picture};
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::{Grid, GridConstants};
use terrafill_stencil::{RouteTexelFormat, RouteTexels};
use terrafill_vulkan::{
    Buffer, BufferUse, ComputePipeline, DirectDraw, DirectReport, Dispatch, DrawCall, DrawPipeline,
    GeometryOutput, Gpu, IndexWidth, Measured, PrimitiveStages, RenderTargets, Resource, Resources,
    SampledImage, Shader, Topology, VertexFormat,
};

const GRID: &str = "pipelines/grid.wgsl";
const PATCH: &str = "pipelines/patch.wgsl";
const EXPAND: &str = "pipelines/expand.wgsl";
/// Of a vertex: a position, and a number, whose location counts as a whole of four.
const COMPONENTS: u32 = 8;

pub(crate) fn wgsl(path: &'static str, entry_point: &'static str) -> Shader {
    Shader::Wgsl { path, entry_point }
}

/// Stages of vertices that have nothing but numbers.
pub(crate) fn numbered(
    vertex: Shader,
    geometry: Option<GeometryOutput>,
    topology: Topology,
) -> PrimitiveStages {
    PrimitiveStages::Vertices {
        vertex,
        geometry,
        format: VertexFormat::Number,
        topology,
    }
}

/// A uniform block.
pub(crate) fn uniform(gpu: &Arc<Gpu>, label: &str, bytes: &[u8]) -> Result<Resource, DeviceError> {
    let buffer = Buffer::upload(gpu, label, bytes, BufferUse::Uniform)?;
    Ok(Resource::Uniform(Arc::new(buffer)))
}

/// Heights of a grid.
pub(crate) fn heights(gpu: &Arc<Gpu>, grid: &Grid) -> Result<Arc<SampledImage>, DeviceError> {
    let texels = RouteTexels {
        format: RouteTexelFormat::R32Float,
        is_filtered: false,
        size: [grid.cells + 1; 2],
        is_cube: false,
        bytes: bytemuck::cast_slice(&grid.heights).to_vec(),
    };
    Ok(Arc::new(SampledImage::route(gpu, &texels)?))
}

/// What is drawn.
pub(crate) enum Call {
    Ranges(Vec<Range<u32>>),
    /// Behind a dispatch that places vertices.
    Placed(Vec<Range<u32>>, ComputePipeline, u32),
    Patches(Buffer, u32),
    /// All indices, so many, of so many instances.
    Indexed(Buffer, u32, u32),
    Indirect(Arc<Buffer>, ComputePipeline, u32),
    Groups(u32),
}

impl Call {
    /// Triangles by their corners' indices.
    pub(crate) fn indexed(
        gpu: &Arc<Gpu>,
        triangles: &[[u32; 3]],
        instances: u32,
    ) -> Result<Self, DeviceError> {
        let bytes = bytemuck::cast_slice(triangles);
        let indices = Buffer::upload(gpu, "indices", bytes, BufferUse::Index)?;
        Ok(Self::Indexed(indices, 3 * count(triangles), instances))
    }
}

/// A grid by one way.
pub(crate) struct OnVulkan {
    targets: RenderTargets,
    pipeline: DrawPipeline,
    /// Vertices or points, where the first stage reads any.
    vertices: Option<Buffer>,
    /// Written into `vertices` before each frame.
    sent: Option<Vec<u8>>,
    call: Call,
}

impl OnVulkan {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        way: Submission,
        grid: &Grid,
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let constants = GridConstants::new(grid);
        let side = grid.cells + 1;
        let mut resources = vec![
            uniform(gpu, "grid constants", bytemuck::bytes_of(&constants))?,
            Resource::Image(heights(gpu, grid)?),
        ];
        let mut arguments = None;
        if way == Submission::ComputeIndirect {
            let bytes = u64::from(side).pow(2) * 16;
            let kept = Buffer::unwritten(gpu, "clip positions", bytes, BufferUse::Storage)?;
            let written = BufferUse::Arguments;
            let buffer = Buffer::unwritten(gpu, "draw arguments", ARGUMENT_BYTES, written)?;
            let buffer = Arc::new(buffer);
            resources.push(Resource::Storage(Arc::new(kept)));
            resources.push(Resource::Storage(Arc::clone(&buffer)));
            arguments = Some(buffer);
        }
        let resources = Resources::new(gpu, resources)?;
        let (stages, fragment) = stages(way, &gpu.facts.name)?;
        let pipeline = DrawPipeline::new(gpu, &resources, stages, fragment)?;
        let bytes = way.vertices(grid);
        let vertices = if bytes.is_empty() {
            None
        } else if way.is_sent() {
            let size = bytes.len() as u64;
            let buffer = Buffer::streamed(gpu, "sent vertices", size, BufferUse::Vertex)?;
            Some(buffer)
        } else {
            Some(Buffer::upload(gpu, "points", &bytes, BufferUse::Vertex)?)
        };
        let call = match (way, arguments) {
            (_, Some(arguments)) => {
                let compute = ComputePipeline::new(gpu, &resources, wgsl(EXPAND, "compute_main"))?;
                Call::Indirect(arguments, compute, side.div_ceil(8))
            }
            (Submission::IndexedPatch, _) => {
                let indices = patch_indices();
                let bytes = bytemuck::cast_slice(&indices);
                let indices = Buffer::upload(gpu, "patch", bytes, BufferUse::Index)?;
                Call::Patches(indices, (grid.cells / PATCH_CELLS).pow(2))
            }
            (Submission::Mesh, _) => Call::Groups(grid.cells / MESH_CELLS),
            _ => Call::Ranges(way.ranges(grid)),
        };
        Ok(Self {
            targets: RenderTargets::new(gpu, size)?,
            pipeline,
            vertices,
            sent: way.is_sent().then_some(bytes),
            call,
        })
    }

    /// Whatever is drawn of vertices that are not sent.
    pub(crate) fn with(
        gpu: &Arc<Gpu>,
        pipeline: DrawPipeline,
        call: Call,
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        Ok(Self {
            targets: RenderTargets::new(gpu, size)?,
            pipeline,
            vertices: None,
            sent: None,
            call,
        })
    }

    fn frame(&mut self, measured: Measured) -> Result<DirectReport, DeviceError> {
        if let (Some(buffer), Some(bytes)) = (&self.vertices, &self.sent) {
            buffer.stream(bytes)?;
        }
        let mut dispatch = None;
        let call = match &self.call {
            Call::Ranges(ranges) => DrawCall::Vertices(ranges),
            Call::Placed(ranges, compute, groups) => {
                dispatch = Some(Dispatch {
                    pipeline: compute,
                    groups: [*groups, 1, 1],
                });
                DrawCall::Vertices(ranges)
            }
            Call::Patches(indices, instances) => DrawCall::Indexed {
                indices,
                width: IndexWidth::Short,
                count: 6 * PATCH_CELLS * PATCH_CELLS,
                instances: *instances,
            },
            Call::Indexed(indices, count, instances) => DrawCall::Indexed {
                indices,
                width: IndexWidth::Long,
                count: *count,
                instances: *instances,
            },
            Call::Indirect(arguments, compute, groups) => {
                dispatch = Some(Dispatch {
                    pipeline: compute,
                    groups: [*groups, *groups, 1],
                });
                DrawCall::Indirect(arguments)
            }
            Call::Groups(groups) => DrawCall::MeshGroups([*groups; 2]),
        };
        let draw = DirectDraw {
            pipeline: &self.pipeline,
            vertices: self.vertices.as_ref(),
            call,
        };
        self.targets.draw_directly(dispatch, &draw, measured)
    }
}

/// Shaders of a way.
fn stages(way: Submission, adapter: &str) -> Result<(PrimitiveStages, Shader), DeviceError> {
    let vertices = |entry_point, geometry, format, topology| PrimitiveStages::Vertices {
        vertex: wgsl(GRID, entry_point),
        geometry,
        format,
        topology,
    };
    let (metres, word) = (VertexFormat::Metres, VertexFormat::Word);
    let triangles = Topology::Triangles;
    let stages = match way {
        Submission::SentPoints => vertices("sent_point", None, metres, Topology::Points),
        Submission::SentStrips => vertices("sent_strip", None, metres, Topology::Strips),
        Submission::FetchedPoints => vertices("fetched_point", None, word, Topology::Points),
        Submission::NoBuffer => numbered(wgsl(GRID, "no_buffer"), None, triangles),
        Submission::ComputeIndirect => numbered(wgsl(GRID, "placed_before"), None, triangles),
        Submission::IndexedPatch => numbered(wgsl(PATCH, "vertex_main"), None, triangles),
        Submission::Geometry {
            cells,
            strips,
            declared,
            ..
        } => {
            let name = geometry_shader(cells, strips, declared).ok_or_else(|| {
                let what = format!("a geometry shader of {cells} × {cells} cells");
                DeviceError::unsupported(&what, adapter)
            })?;
            let output = GeometryOutput {
                name,
                vertices: declared.unwrap_or_else(|| emitted_by_point(cells, strips)),
                components: COMPONENTS,
            };
            vertices("numbered_point", Some(output), word, Topology::Points)
        }
        Submission::Mesh => PrimitiveStages::Mesh {
            task: None,
            mesh: MESH_SHADERS[0],
        },
    };
    let fragment = match way {
        Submission::IndexedPatch => wgsl(PATCH, "fragment_main"),
        Submission::Mesh => Shader::Compiled(MESH_SHADERS[1]),
        _ => wgsl(GRID, "fragment_main"),
    };
    Ok((stages, fragment))
}

impl Draws for OnVulkan {
    fn draw(&mut self) -> Result<(Picture, Counted), DeviceError> {
        let report = self.frame(Measured::Statistics)?;
        let picture = self.targets.read()?;
        Ok((picture, Counted::from(report.statistics)))
    }

    fn time(&mut self) -> Result<Times, DeviceError> {
        let watch = CpuStopwatch::start();
        let report = self.frame(Measured::Times)?;
        Ok(Times::since(&watch, report.gpu_ms))
    }
}
