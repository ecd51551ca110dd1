// SPDX-License-Identifier: MIT OR Apache-2.0
//! Grids on Vulkan itself, which has every stage.

use crate::draws::{Counted, Draws, Times};
use crate::grid::{Grid, GridCamera, GridConstants};
use crate::way::{
    ARGUMENT_BYTES, MESH_CELLS, PATCH_CELLS, Source, Submission, emitted_by_point, geometry_shader,
    patch_indices, points, strip_ranges, strips,
};
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError, Picture};
use terrafill_scene::ImageSize;
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

fn wgsl(path: &'static str, entry_point: &'static str) -> Shader {
    Shader::Wgsl { path, entry_point }
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

/// What the first stage reads.
enum Feed {
    Nothing,
    /// Vertices or points in device memory.
    Stored(Buffer),
    /// Written by the CPU before each frame.
    Sent(Buffer, Vec<u8>),
}

/// What is drawn of it.
enum Call {
    Ranges(Vec<Range<u32>>),
    Patches(Buffer, u32),
    Indirect(Arc<Buffer>, ComputePipeline, u32),
    Groups(u32),
}

/// A grid by one way.
pub(crate) struct OnVulkan {
    targets: RenderTargets,
    pipeline: DrawPipeline,
    feed: Feed,
    call: Call,
}

impl OnVulkan {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        way: Submission,
        grid: &Grid,
        view: &GridCamera,
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let constants = GridConstants::new(grid, view);
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
        let all = grid.cells * grid.cells;
        let (feed, call) = match way {
            Submission::SentPoints => (sent(gpu, bytemuck::cast_slice(&points(grid)))?, whole(all)),
            Submission::SentStrips => (
                sent(gpu, bytemuck::cast_slice(&strips(grid)))?,
                Call::Ranges(strip_ranges(grid)),
            ),
            Submission::FetchedPoints => (numbers(gpu, all, Source::Stored)?, whole(all)),
            Submission::Geometry { cells, source, .. } => {
                let points = all / (cells * cells);
                (numbers(gpu, points, source)?, whole(points))
            }
            Submission::NoBuffer => (Feed::Nothing, whole(6 * all)),
            Submission::IndexedPatch => {
                let indices = patch_indices();
                let bytes = bytemuck::cast_slice(&indices);
                let indices = Buffer::upload(gpu, "patch", bytes, BufferUse::Index)?;
                let patches = all / (PATCH_CELLS * PATCH_CELLS);
                (Feed::Nothing, Call::Patches(indices, patches))
            }
            Submission::ComputeIndirect => {
                let compute = ComputePipeline::new(gpu, &resources, wgsl(EXPAND, "compute_main"))?;
                let arguments = arguments.ok_or(DeviceError::Missing("buffer of arguments"))?;
                let groups = side.div_ceil(8);
                (Feed::Nothing, Call::Indirect(arguments, compute, groups))
            }
            Submission::Mesh => (Feed::Nothing, Call::Groups(grid.cells / MESH_CELLS)),
        };
        Ok(Self {
            targets: RenderTargets::new(gpu, size)?,
            pipeline,
            feed,
            call,
        })
    }

    fn frame(&mut self, measured: Measured) -> Result<DirectReport, DeviceError> {
        let vertices = match &self.feed {
            Feed::Nothing => None,
            Feed::Stored(buffer) => Some(buffer),
            Feed::Sent(buffer, bytes) => {
                buffer.stream(bytes)?;
                Some(buffer)
            }
        };
        let mut dispatch = None;
        let call = match &self.call {
            Call::Ranges(ranges) => DrawCall::Vertices(ranges),
            Call::Patches(indices, instances) => DrawCall::Indexed {
                indices,
                width: IndexWidth::Short,
                count: 6 * PATCH_CELLS * PATCH_CELLS,
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
            vertices,
            call,
        };
        self.targets.draw_directly(dispatch, &draw, measured)
    }
}

fn whole(vertices: u32) -> Call {
    Call::Ranges(std::iter::once(0..vertices).collect())
}

fn sent(gpu: &Arc<Gpu>, bytes: &[u8]) -> Result<Feed, DeviceError> {
    let size = bytes.len() as u64;
    let buffer = Buffer::streamed(gpu, "sent vertices", size, BufferUse::Vertex)?;
    Ok(Feed::Sent(buffer, bytes.to_vec()))
}

/// Numbers of points, one after the other.
fn numbers(gpu: &Arc<Gpu>, points: u32, source: Source) -> Result<Feed, DeviceError> {
    let numbers: Vec<u32> = (0..points).collect();
    let bytes = bytemuck::cast_slice(&numbers);
    match source {
        Source::Sent => sent(gpu, bytes),
        Source::Stored => {
            let buffer = Buffer::upload(gpu, "points", bytes, BufferUse::Vertex)?;
            Ok(Feed::Stored(buffer))
        }
    }
}

/// Shaders of a way.
fn stages(way: Submission, adapter: &str) -> Result<(PrimitiveStages, Shader), DeviceError> {
    let vertices = |entry_point, format, topology| PrimitiveStages::Vertices {
        vertex: wgsl(GRID, entry_point),
        geometry: None,
        format,
        topology,
    };
    let (metres, word, none) = (
        VertexFormat::Metres,
        VertexFormat::Word,
        VertexFormat::Number,
    );
    let fragment = wgsl(GRID, "fragment_main");
    Ok(match way {
        Submission::SentPoints => (vertices("sent_point", metres, Topology::Points), fragment),
        Submission::SentStrips => (vertices("sent_strip", metres, Topology::Strips), fragment),
        Submission::FetchedPoints => (vertices("fetched_point", word, Topology::Points), fragment),
        Submission::NoBuffer => (vertices("no_buffer", none, Topology::Triangles), fragment),
        Submission::ComputeIndirect => (
            vertices("placed_before", none, Topology::Triangles),
            fragment,
        ),
        Submission::Geometry { cells, strips, .. } => {
            let name = geometry_shader(cells, strips).ok_or_else(|| {
                let what = format!("a geometry shader of {cells} × {cells} cells");
                DeviceError::unsupported(&what, adapter)
            })?;
            let stages = PrimitiveStages::Vertices {
                vertex: wgsl(GRID, "numbered_point"),
                geometry: Some(GeometryOutput {
                    name,
                    vertices: emitted_by_point(cells, strips),
                    components: COMPONENTS,
                }),
                format: word,
                topology: Topology::Points,
            };
            (stages, fragment)
        }
        Submission::IndexedPatch => {
            let stages = PrimitiveStages::Vertices {
                vertex: wgsl(PATCH, "vertex_main"),
                geometry: None,
                format: none,
                topology: Topology::Triangles,
            };
            (stages, wgsl(PATCH, "fragment_main"))
        }
        Submission::Mesh => (
            PrimitiveStages::Mesh {
                task: None,
                mesh: "native/grid.mesh.spv",
            },
            Shader::Compiled("native/grid.frag.spv"),
        ),
    })
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
