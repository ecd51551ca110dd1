// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadow volumes on devices, through the executors of stencil programs that fill regions too.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;
use std::sync::Arc;
use terrafill_fill::{
    Counters, DeviceError, Devices, FrameTimes, Picture, StencilExecutor, StencilWork, SurfaceView,
    Switches, VolumeDraw, VolumeList, VolumeState,
};
use terrafill_gpu::{HandedOn, VolumeShader};
use terrafill_vulkan::{
    Buffer, BufferUse, Fragments, Geometry, IndexWidth, Pipeline, PipelineDescriptor, Topology,
    VertexFormat, VertexStage,
};

const SHADER: &str = "casters/volume.wgsl";
const PULLED_SHADER: &str = "casters/pulled.wgsl";
/// Of a piece that is a triangle of the light cap.
pub(crate) const IS_CAP: u32 = 1 << 31;

/// Volumes as one eye sees them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct EyeVolumes {
    /// Bits of `f32`: x, y, z from the eye, m, and w.
    pub(crate) vertices: Vec<[u32; 4]>,
    /// Of triangles, counter-clockwise seen from outside.
    pub(crate) indices: Vec<u32>,
    /// Of each volume, by [`terrafill_fill::Volume::geometry`]: its range of indices.
    pub(crate) ranges: Vec<Range<u32>>,
}

/// Casters as one eye sees them, from which a vertex shader pulls their volumes.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct EyeMesh {
    /// x, y, z from the eye, m, and 1; the last one: the direction away from the light, and 0.
    pub(crate) places: Vec<[f32; 4]>,
    /// Triangles and edges, as `casters/pulled.wgsl` reads them.
    pub(crate) pieces: Vec<[u32; 4]>,
    /// A bit a triangle.
    pub(crate) lit: Vec<u32>,
    /// Of each caster, by [`terrafill_fill::Volume::geometry`]: its range of pieces.
    pub(crate) ranges: Vec<Range<u32>>,
}

/// What a device makes volumes of.
#[derive(Debug)]
pub(crate) enum VolumeSource {
    Volumes(EyeVolumes),
    Pulled(EyeMesh),
}

impl VolumeSource {
    /// All that the device holds, and what of it another sun changes.
    pub(crate) fn bytes(&self) -> [u64; 2] {
        match self {
            // Sides begin elsewhere: everything.
            Self::Volumes(volumes) => {
                let bytes = size_of_val(&*volumes.vertices) + size_of_val(&*volumes.indices);
                [bytes as u64; 2]
            }
            Self::Pulled(mesh) => {
                let fixed = size_of_val(&*mesh.places) + size_of_val(&*mesh.pieces);
                // The bits and the direction.
                let light = size_of_val(&*mesh.lit);
                [(fixed + light) as u64, (light + 16) as u64]
            }
        }
    }
}

/// An interface that draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Interface {
    Wgpu,
    Vulkan,
}

impl Interface {
    pub(crate) const ALL: [Self; 2] = [Self::Wgpu, Self::Vulkan];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Wgpu => terrafill_gpu::API.name,
            Self::Vulkan => terrafill_vulkan::API.name,
        }
    }

    /// What is seen, and the program over its volumes, ready to be drawn into targets of its own.
    pub(crate) fn open(
        self,
        devices: &Devices,
        switches: &Switches,
        view: SurfaceView<'_>,
        source: VolumeSource,
        work: StencilWork,
    ) -> Result<Box<dyn Draws>, DeviceError> {
        match self {
            Self::Wgpu => {
                let gpu = terrafill_gpu::shared_gpu(devices)?;
                let targets = terrafill_gpu::RenderTargets::shared(&gpu, view.size)?;
                let make = |fill: &terrafill_gpu::VolumeFill| OnWgpu::new(fill, source);
                loaded(&targets, switches, make, view, work)
            }
            Self::Vulkan => {
                let VolumeSource::Volumes(volumes) = source else {
                    let what = "storage buffers that vertex shaders pull from";
                    return Err(DeviceError::unsupported(what, "the executor on Vulkan"));
                };
                let gpu = terrafill_vulkan::shared_gpu(devices)?;
                let targets = terrafill_vulkan::RenderTargets::shared(&gpu, view.size)?;
                let make = |_: &terrafill_vulkan::VolumeFill| OnVulkan::new(&gpu, volumes);
                loaded(&targets, switches, make, view, work)
            }
        }
    }
}

/// Draws one view.
pub(crate) trait Draws {
    /// What is seen and its shadows; counts.
    fn draw(&mut self) -> Result<(Counters, Picture), DeviceError>;

    /// The shadows alone.
    fn time(&mut self) -> Result<FrameTimes, DeviceError>;
}

struct Loaded<E, V> {
    executor: E,
    volumes: V,
}

impl<V, E: StencilExecutor<V>> Draws for Loaded<E, V> {
    fn draw(&mut self) -> Result<(Counters, Picture), DeviceError> {
        self.executor.draw_surface()?;
        let mut counters = self.executor.draw(&mut self.volumes)?;
        let picture = self.executor.read()?;
        counters.stencil_fragments = self.executor.count_fragments(&mut self.volumes)?;
        Ok((counters, picture))
    }

    fn time(&mut self) -> Result<FrameTimes, DeviceError> {
        self.executor.draw_surface()?;
        self.executor.time(&mut self.volumes)
    }
}

fn loaded<V: 'static, E: StencilExecutor<V> + 'static>(
    targets: &E::Targets,
    switches: &Switches,
    make: impl FnOnce(&E) -> Result<V, DeviceError>,
    view: SurfaceView<'_>,
    work: StencilWork,
) -> Result<Box<dyn Draws>, DeviceError> {
    let mut executor = E::new(targets, switches)?;
    let mut volumes = make(&executor)?;
    executor.set_view(view)?;
    executor.load(work)?;
    executor.ensure(&mut volumes)?;
    Ok(Box::new(Loaded { executor, volumes }))
}

/// What the vertex stage reads, on wgpu.
enum Feed {
    Buffers {
        vertices: wgpu::Buffer,
        indices: wgpu::Buffer,
    },
    Pulled(wgpu::BindGroup),
}

/// Buffers and pipelines on wgpu.
struct OnWgpu {
    shader: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    feed: Feed,
    /// Of each caster: its indices, or its vertices that the shader makes up.
    ranges: Vec<Range<u32>>,
    pipelines: HashMap<VolumeState, wgpu::RenderPipeline>,
}

impl OnWgpu {
    fn new(fill: &terrafill_gpu::VolumeFill, source: VolumeSource) -> Result<Self, DeviceError> {
        let gpu = fill.gpu();
        let frame = Some(fill.frame_layout());
        let (shader, layout, feed, ranges) = match source {
            VolumeSource::Volumes(volumes) => {
                let (vertex, index) = (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX);
                let vertices = bytemuck::cast_slice(&volumes.vertices);
                let indices = bytemuck::cast_slice(&volumes.indices);
                let feed = Feed::Buffers {
                    vertices: gpu.upload("shadow vertices", vertices, vertex)?,
                    indices: gpu.upload("shadow indices", indices, index)?,
                };
                let layout = gpu.pipeline_layout("shadows", &[frame]);
                (SHADER, layout, feed, volumes.ranges)
            }
            VolumeSource::Pulled(mesh) => {
                let storage = wgpu::BufferBindingType::Storage { read_only: true };
                let vertex = wgpu::ShaderStages::VERTEX;
                let own = gpu.buffer_layout("casters", vertex, &[storage; 3]);
                let upload =
                    |label, bytes: &[u8]| gpu.upload(label, bytes, wgpu::BufferUsages::STORAGE);
                let places = upload("caster places", bytemuck::cast_slice(&mesh.places))?;
                let pieces = upload("caster pieces", bytemuck::cast_slice(&mesh.pieces))?;
                let lit = upload("facing bits", bytemuck::cast_slice(&mesh.lit))?;
                let bound = gpu.bind_buffers("casters", &own, &[&places, &pieces, &lit]);
                let layout = gpu.pipeline_layout("pulled shadows", &[frame, Some(&own)]);
                let corners = |pieces: Range<u32>| 3 * pieces.start..3 * pieces.end;
                let ranges = mesh.ranges.into_iter().map(corners).collect();
                (PULLED_SHADER, layout, Feed::Pulled(bound), ranges)
            }
        };
        Ok(Self {
            shader: gpu.shader(shader)?,
            layout,
            feed,
            ranges,
            pipelines: HashMap::new(),
        })
    }
}

impl terrafill_gpu::Volumes for OnWgpu {
    fn ensure(
        &mut self,
        gpu: &terrafill_gpu::Gpu,
        _list: &VolumeList,
        draw: &VolumeDraw<'_>,
        blends: bool,
    ) {
        debug_assert_eq!(HandedOn::of(draw.state), HandedOn::Nothing, "one colour");
        let attributes = wgpu::vertex_attr_array![0 => Sint32x3, 1 => Uint32];
        let vertices = [Some(wgpu::VertexBufferLayout {
            array_stride: 16,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &attributes,
        })];
        let shader = VolumeShader {
            module: &self.shader,
            layout: &self.layout,
            vertex_entry: "vertex_main",
            constants: &[],
            buffers: match self.feed {
                Feed::Buffers { .. } => &vertices,
                Feed::Pulled(_) => &[],
            },
            strip_index_format: None,
            front_face: wgpu::FrontFace::Ccw,
        };
        let pipeline = || shader.pipeline(gpu, draw.state, blends);
        self.pipelines.entry(draw.state).or_insert_with(pipeline);
    }

    fn bind(&self, pass: &mut wgpu::RenderPass<'_>) {
        match &self.feed {
            Feed::Buffers { vertices, indices } => {
                pass.set_vertex_buffer(0, vertices.slice(..));
                pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
            }
            Feed::Pulled(bound) => pass.set_bind_group(1, bound, &[]),
        }
    }

    fn draw(
        &mut self,
        pass: &mut terrafill_gpu::VolumePass<'_>,
        draw: &VolumeDraw<'_>,
        _blends: bool,
    ) {
        let Some(pipeline) = self.pipelines.get(&draw.state) else {
            return;
        };
        pass.raw.set_pipeline(pipeline);
        for &volume in draw.volumes {
            let range = self.ranges[pass.list.volumes[volume].geometry].clone();
            pass.cut(volume, draw.scissor);
            match self.feed {
                Feed::Buffers { .. } => pass.draw_indexed(range, 0, volume),
                Feed::Pulled(_) => pass.draw(range, volume),
            }
        }
    }
}

/// As [`OnWgpu`], on Vulkan.
struct OnVulkan {
    vertices: Buffer,
    indices: Buffer,
    ranges: Vec<Range<u32>>,
    pipelines: HashMap<VolumeState, Pipeline>,
}

impl OnVulkan {
    fn new(gpu: &Arc<terrafill_vulkan::Gpu>, volumes: EyeVolumes) -> Result<Self, DeviceError> {
        let upload = |label, bytes, use_for| Buffer::upload(gpu, label, bytes, use_for);
        let vertices = bytemuck::cast_slice(&volumes.vertices);
        let indices = bytemuck::cast_slice(&volumes.indices);
        Ok(Self {
            vertices: upload("shadow vertices", vertices, BufferUse::Vertex)?,
            indices: upload("shadow indices", indices, BufferUse::Index)?,
            ranges: volumes.ranges,
            pipelines: HashMap::new(),
        })
    }
}

fn descriptor(state: VolumeState) -> PipelineDescriptor {
    let fragments = match state {
        VolumeState::Mark {
            has_colour: true, ..
        } => Fragments::Shader {
            path: SHADER,
            entry_point: "no_colour",
        },
        _ => Fragments::None,
    };
    PipelineDescriptor {
        vertex: VertexStage {
            path: SHADER,
            entry_point: "vertex_main",
            bends_footprints: false,
        },
        geometry: None,
        fragments,
        format: VertexFormat::FixedAndFlag,
        topology: Topology::Triangles,
        state: state.into(),
        depth_bounds: false,
    }
}

impl terrafill_vulkan::Volumes for OnVulkan {
    fn ensure(
        &mut self,
        gpu: &Arc<terrafill_vulkan::Gpu>,
        draw: &VolumeDraw<'_>,
    ) -> Result<(), DeviceError> {
        if let Entry::Vacant(place) = self.pipelines.entry(draw.state) {
            place.insert(Pipeline::new(gpu, descriptor(draw.state))?);
        }
        Ok(())
    }

    fn draw<'a>(
        &'a self,
        pass: &mut terrafill_vulkan::VolumePass<'a, '_, '_>,
        draw: &VolumeDraw<'_>,
    ) {
        let Some(pipeline) = self.pipelines.get(&draw.state) else {
            return;
        };
        let geometry = Geometry {
            vertices: &self.vertices,
            indices: &self.indices,
            width: IndexWidth::Long,
        };
        for &volume in draw.volumes {
            let range = self.ranges[pass.list.volumes[volume].geometry].clone();
            pass.cut(volume, draw.scissor);
            pass.draw_indexed(pipeline, geometry, range, 0, volume);
        }
    }
}
