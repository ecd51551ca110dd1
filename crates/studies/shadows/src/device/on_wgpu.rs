// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes on wgpu: from buffers, from a vertex shader that finds the silhouette, or from a compute shader.

use crate::source::{Computed, EyeMesh, SHADER, VolumeSource};
use std::collections::HashMap;
use std::ops::Range;
use terrafill_fill::{DeviceError, VolumeDraw, VolumeList, VolumeState};
use terrafill_gpu::{Gpu, HandedOn, VolumeFill, VolumePass, VolumeShader, Volumes};

const BOUNDED_SHADER: &str = "casters/bounded.wgsl";
const PULLED_SHADER: &str = "casters/pulled.wgsl";
const CORNERS_SHADER: &str = "casters/corners.wgsl";
const COMPUTE_SHADER: &str = "casters/silhouettes.wgsl";
/// Pieces of a group of invocations of that one.
const GROUP: usize = 64;
/// Words of an indirect draw's arguments.
const ARGUMENTS: usize = 5;

/// What the vertex stage reads, on wgpu.
enum Feed {
    Buffers {
        vertices: wgpu::Buffer,
        indices: wgpu::Buffer,
    },
    /// The same, cut to ranges of depth by the fragment shader.
    Bounded(Box<Bounded>),
    Pulled(wgpu::BindGroup),
    Computed(Box<Finder>),
}

/// What a fragment shader tests depth by.
struct Bounded {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    layout: wgpu::BindGroupLayout,
    /// The group points at them.
    ranges: Option<wgpu::Buffer>,
    bound: Option<wgpu::BindGroup>,
}

fn bounded_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty,
        count: None,
    };
    let depth = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Depth,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let ranges = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: true },
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let descriptor = wgpu::BindGroupLayoutDescriptor {
        label: Some("depth and ranges"),
        entries: &[
            entry(0, wgpu::ShaderStages::FRAGMENT, depth),
            entry(1, wgpu::ShaderStages::VERTEX, ranges),
        ],
    };
    gpu.device.create_bind_group_layout(&descriptor)
}

/// What a compute shader finds silhouettes by.
struct Finder {
    pipeline: wgpu::ComputePipeline,
    bound: wgpu::BindGroup,
    vertices: wgpu::Buffer,
    /// Triangles, caster by caster.
    indices: wgpu::Buffer,
    /// Arguments of indirect draws, and what they are before anything is found.
    draws: wgpu::Buffer,
    none: wgpu::Buffer,
    groups: u32,
}

impl Finder {
    fn new(fill: &VolumeFill, own: &Computed) -> Result<Self, DeviceError> {
        let gpu = fill.gpu();
        let of_piece = own.indices_of_piece();
        let pieces = own.mesh.pieces.len();
        let word = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        let (mut owners, mut none) = (Vec::new(), Vec::new());
        for (caster, range) in (0_u32..).zip(&own.mesh.ranges) {
            owners.extend(range.clone().map(|_| caster));
            none.extend([0, 1, range.start * word(of_piece), 0, 0]);
        }
        let shape = [word(pieces), own.far, u32::from(own.is_closed), 0];
        let (storage, copied) = (wgpu::BufferUsages::STORAGE, wgpu::BufferUsages::COPY_SRC);
        let upload = |label, bytes: &[u8], usage| gpu.upload(label, bytes, usage);
        let read = upload(
            "caster pieces",
            bytemuck::cast_slice(&own.mesh.pieces),
            storage,
        )?;
        let owners = upload("casters of pieces", bytemuck::cast_slice(&owners), storage)?;
        let lit = upload("facing bits", bytemuck::cast_slice(&own.mesh.lit), storage)?;
        let shape = upload(
            "shape",
            bytemuck::cast_slice(&shape),
            wgpu::BufferUsages::UNIFORM,
        )?;
        let vertices = bytemuck::cast_slice(&own.vertices);
        let vertices = upload("shadow vertices", vertices, wgpu::BufferUsages::VERTEX)?;
        let none = upload("no indices", bytemuck::cast_slice(&none), copied)?;
        let room = |label, size: u64, usage| {
            gpu.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: storage | usage,
                mapped_at_creation: false,
            })
        };
        let drawn = wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_DST;
        let draws = room("draws of casters", none.size(), drawn);
        // A caster without pieces draws nothing, and a binding of 0 bytes is not allowed.
        let bytes = (4 * of_piece * pieces.max(1)) as u64;
        let indices = room("found indices", bytes, wgpu::BufferUsages::INDEX);
        let kinds =
            [true, true, true].map(|read_only| wgpu::BufferBindingType::Storage { read_only });
        let written =
            [false, false].map(|read_only| wgpu::BufferBindingType::Storage { read_only });
        let kinds = [&kinds[..], &[wgpu::BufferBindingType::Uniform], &written].concat();
        let layout = gpu.buffer_layout("silhouettes", wgpu::ShaderStages::COMPUTE, &kinds);
        let buffers = [&read, &owners, &lit, &shape, &draws, &indices];
        let bound = gpu.bind_buffers("silhouettes", &layout, &buffers);
        let pipeline = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("silhouettes"),
            layout: Some(&gpu.pipeline_layout("silhouettes", &[Some(&layout)])),
            module: &gpu.shader(COMPUTE_SHADER)?,
            entry_point: Some("find"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Ok(Self {
            pipeline,
            bound,
            vertices,
            indices,
            draws,
            none,
            groups: word(pieces.div_ceil(GROUP)),
        })
    }
}

/// Buffers and pipelines on wgpu.
pub(super) struct OnWgpu {
    shader: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    feed: Feed,
    /// Of each caster: its indices, or its vertices that the shader makes up.
    ranges: Vec<Range<u32>>,
    pipelines: HashMap<VolumeState, wgpu::RenderPipeline>,
}

impl OnWgpu {
    /// - `is_bounded`: a fragment shader tests depth in the copy that the executor makes
    pub(super) fn new(
        fill: &VolumeFill,
        source: VolumeSource,
        is_bounded: bool,
    ) -> Result<Self, DeviceError> {
        let gpu = fill.gpu();
        let frame = Some(fill.frame_layout());
        let (shader, layout, feed, ranges) = match source {
            VolumeSource::Volumes(volumes) => {
                let (vertex, index) = (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX);
                let vertices = bytemuck::cast_slice(&volumes.vertices);
                let indices = bytemuck::cast_slice(&volumes.indices);
                let vertices = gpu.upload("shadow vertices", vertices, vertex)?;
                let indices = gpu.upload("shadow indices", indices, index)?;
                match is_bounded {
                    true => {
                        let own = bounded_layout(&gpu);
                        let layout = gpu.pipeline_layout("bounded shadows", &[frame, Some(&own)]);
                        let feed = Feed::Bounded(Box::new(Bounded {
                            vertices,
                            indices,
                            layout: own,
                            ranges: None,
                            bound: None,
                        }));
                        (BOUNDED_SHADER, layout, feed, volumes.ranges)
                    }
                    false => {
                        let layout = gpu.pipeline_layout("shadows", &[frame]);
                        let feed = Feed::Buffers { vertices, indices };
                        (SHADER, layout, feed, volumes.ranges)
                    }
                }
            }
            VolumeSource::Pulled(mesh) => pulled(&gpu, frame, PULLED_SHADER, mesh)?,
            VolumeSource::Corners(mesh) => pulled(&gpu, frame, CORNERS_SHADER, mesh)?,
            VolumeSource::Computed(own) => {
                let feed = Feed::Computed(Box::new(Finder::new(fill, &own)?));
                let layout = gpu.pipeline_layout("shadows", &[frame]);
                (SHADER, layout, feed, own.mesh.ranges)
            }
            VolumeSource::Adjacent(_) => {
                return Err(DeviceError::unsupported(
                    "geometry shaders",
                    terrafill_gpu::API.name,
                ));
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

/// What a vertex shader pulls, and who does.
type Pulled = (&'static str, wgpu::PipelineLayout, Feed, Vec<Range<u32>>);

fn pulled(
    gpu: &Gpu,
    frame: Option<&wgpu::BindGroupLayout>,
    shader: &'static str,
    mesh: EyeMesh,
) -> Result<Pulled, DeviceError> {
    let upload = |label, bytes: &[u8]| gpu.upload(label, bytes, wgpu::BufferUsages::STORAGE);
    let mut buffers = vec![
        upload("caster places", bytemuck::cast_slice(&mesh.places))?,
        upload("caster pieces", bytemuck::cast_slice(&mesh.pieces))?,
    ];
    if !mesh.lit.is_empty() {
        buffers.push(upload("facing bits", bytemuck::cast_slice(&mesh.lit))?);
    }
    let storage = wgpu::BufferBindingType::Storage { read_only: true };
    let kinds = vec![storage; buffers.len()];
    let own = gpu.buffer_layout("casters", wgpu::ShaderStages::VERTEX, &kinds);
    let buffers: Vec<&wgpu::Buffer> = buffers.iter().collect();
    let bound = gpu.bind_buffers("casters", &own, &buffers);
    let layout = gpu.pipeline_layout("pulled shadows", &[frame, Some(&own)]);
    let corners = |pieces: Range<u32>| 3 * pieces.start..3 * pieces.end;
    let ranges = mesh.ranges.into_iter().map(corners).collect();
    Ok((shader, layout, Feed::Pulled(bound), ranges))
}

impl Volumes for OnWgpu {
    fn make(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        _list: &VolumeList,
        _constants: &wgpu::BindGroup,
    ) {
        if let Feed::Computed(finder) = &self.feed {
            let (none, draws) = (&finder.none, &finder.draws);
            encoder.copy_buffer_to_buffer(none, 0, draws, 0, none.size());
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("silhouettes"),
                ..Default::default()
            });
            pass.set_pipeline(&finder.pipeline);
            pass.set_bind_group(0, &finder.bound, &[]);
            pass.dispatch_workgroups(finder.groups, 1, 1);
        }
    }

    fn read_depth(
        &mut self,
        gpu: &Gpu,
        list: &VolumeList,
        copy: &wgpu::TextureView,
    ) -> Result<(), DeviceError> {
        let Feed::Bounded(own) = &mut self.feed else {
            return Ok(());
        };
        let ranges = list.volumes.iter();
        let ranges = ranges.map(|volume| [volume.depth.low, volume.depth.high]);
        let mut ranges: Vec<[f32; 2]> = ranges.collect();
        // A binding of 0 bytes is not allowed.
        ranges.resize(ranges.len().max(1), [0.0; 2]);
        let bytes = bytemuck::cast_slice(&ranges);
        let ranges = gpu.upload("ranges of depth", bytes, wgpu::BufferUsages::STORAGE)?;
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("depth and ranges"),
            layout: &own.layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(copy),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: ranges.as_entire_binding(),
                },
            ],
        });
        (own.bound, own.ranges) = (Some(group), Some(ranges));
        Ok(())
    }

    fn ensure(&mut self, gpu: &Gpu, _list: &VolumeList, draw: &VolumeDraw<'_>, blends: bool) {
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
                Feed::Buffers { .. } | Feed::Bounded(_) | Feed::Computed(_) => &vertices,
                Feed::Pulled(_) => &[],
            },
            strip_index_format: None,
            front_face: wgpu::FrontFace::Ccw,
            discards: matches!(self.feed, Feed::Bounded(_)),
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
            Feed::Bounded(own) => {
                pass.set_vertex_buffer(0, own.vertices.slice(..));
                pass.set_index_buffer(own.indices.slice(..), wgpu::IndexFormat::Uint32);
                if let Some(bound) = &own.bound {
                    pass.set_bind_group(1, bound, &[]);
                }
            }
            Feed::Pulled(bound) => pass.set_bind_group(1, bound, &[]),
            Feed::Computed(finder) => {
                pass.set_vertex_buffer(0, finder.vertices.slice(..));
                pass.set_index_buffer(finder.indices.slice(..), wgpu::IndexFormat::Uint32);
            }
        }
    }

    fn draw(&mut self, pass: &mut VolumePass<'_>, draw: &VolumeDraw<'_>, _blends: bool) {
        let Some(pipeline) = self.pipelines.get(&draw.state) else {
            return;
        };
        pass.raw.set_pipeline(pipeline);
        for &volume in draw.volumes {
            let caster = pass.list.volumes[volume].geometry;
            let range = self.ranges[caster].clone();
            pass.cut(volume, draw.scissor);
            match &self.feed {
                Feed::Buffers { .. } | Feed::Bounded(_) => pass.draw_indexed(range, 0, volume),
                Feed::Pulled(_) => pass.draw(range, volume),
                Feed::Computed(finder) => {
                    let offset = size_of::<u32>() * ARGUMENTS * caster;
                    pass.draw_as_decided(&finder.draws, offset as u64);
                }
            }
        }
    }
}
