// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes on wgpu: from buffers, from a vertex shader that finds the silhouette, or from a compute shader.

use crate::source::{Computed, EyeMesh, EyeVolumes, HandedOver, SHADER, VolumeSource};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::DeviceError;
use terrafill_gpu::{Gpu, HandedOn, VolumeFill, VolumePass, VolumeShader, WgpuVolumes};
use terrafill_stencil::{VolumeDraw, VolumeList, VolumeState};

const BOUNDED_SHADER: &str = "casters/bounded.wgsl";
const PULLED_SHADER: &str = "casters/pulled.wgsl";
const CORNERS_SHADER: &str = "casters/corners.wgsl";
const COMPUTE_SHADER: &str = "casters/silhouettes.wgsl";
/// Pieces of a group of invocations of that one.
const GROUP: usize = 64;
/// Words of an indirect draw's arguments.
const ARGUMENTS: usize = 5;

/// Of what a fragment shader tests depth by.
fn bounded_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
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
    let types = [
        (wgpu::ShaderStages::FRAGMENT, depth),
        (wgpu::ShaderStages::VERTEX, ranges),
    ];
    gpu.mixed_layout("depth and ranges", types)
}

/// What a compute shader finds silhouettes by.
struct Finder {
    pipeline: wgpu::ComputePipeline,
    bound: wgpu::BindGroup,
    /// Arguments of indirect draws, and what they are before anything is found.
    draws: wgpu::Buffer,
    none: wgpu::Buffer,
    groups: u32,
}

impl Finder {
    /// With vertices, and indices of triangles, caster by caster.
    fn new(fill: &VolumeFill, own: &Computed) -> Result<(Self, [wgpu::Buffer; 2]), DeviceError> {
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
        let pieces_bytes = bytemuck::cast_slice(&own.mesh.pieces);
        let read = upload("caster pieces", pieces_bytes, storage)?;
        let owners = upload("casters of pieces", bytemuck::cast_slice(&owners), storage)?;
        let lit = upload("facing bits", bytemuck::cast_slice(&own.mesh.lit), storage)?;
        let usage = wgpu::BufferUsages::UNIFORM;
        let shape = upload("shape", bytemuck::cast_slice(&shape), usage)?;
        let vertices = bytemuck::cast_slice(&own.vertices);
        let vertices = upload("shadow vertices", vertices, wgpu::BufferUsages::VERTEX)?;
        let none = upload("no indices", bytemuck::cast_slice(&none), copied)?;
        let room = |label, size: u64, usage| gpu.unwritten(label, size, storage | usage);
        let drawn = wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_DST;
        let draws = room("draws of casters", none.size(), drawn);
        // A caster without pieces draws nothing, and a binding of 0 bytes is not allowed.
        let bytes = (4 * of_piece * pieces.max(1)) as u64;
        let indices = room("found indices", bytes, wgpu::BufferUsages::INDEX);
        let kind = |read_only| wgpu::BufferBindingType::Storage { read_only };
        let (held, written) = (kind(true), kind(false));
        let uniform = wgpu::BufferBindingType::Uniform;
        let kinds = [held, held, held, uniform, written, written];
        let layout = gpu.buffer_layout("silhouettes", wgpu::ShaderStages::COMPUTE, &kinds);
        let buffers = [&read, &owners, &lit, &shape, &draws, &indices];
        let bound = gpu.bind_buffers("silhouettes", &layout, &buffers);
        let module = gpu.shader(COMPUTE_SHADER)?;
        let groups = [Some(&layout)];
        let finder = Self {
            pipeline: gpu.compute_pipeline("silhouettes", &module, "find", &groups, &[]),
            bound,
            draws,
            none,
            groups: word(pieces.div_ceil(GROUP)),
        };
        Ok((finder, [vertices, indices]))
    }
}

/// Buffers and pipelines on wgpu.
pub(super) struct OnWgpu {
    gpu: Arc<Gpu>,
    shader: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    /// Vertices and indices, unless a shader pulls them.
    buffers: Option<[wgpu::Buffer; 2]>,
    /// What a shader pulls, or tests depth by.
    bound: Option<wgpu::BindGroup>,
    /// Of the latter.
    depth_layout: Option<wgpu::BindGroupLayout>,
    finder: Option<Finder>,
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
        let mut own = Self {
            gpu: Arc::clone(&gpu),
            shader: gpu.shader(SHADER)?,
            layout: gpu.pipeline_layout("shadows", &[frame]),
            buffers: None,
            bound: None,
            depth_layout: None,
            finder: None,
            ranges: Vec::new(),
            pipelines: HashMap::new(),
        };
        match source {
            VolumeSource::Volumes(volumes) => {
                let (vertex, index) = (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX);
                let vertices = bytemuck::cast_slice(&volumes.vertices);
                let indices = bytemuck::cast_slice(&volumes.indices);
                own.buffers = Some([
                    gpu.upload("shadow vertices", vertices, vertex)?,
                    gpu.upload("shadow indices", indices, index)?,
                ]);
                own.ranges = volumes.ranges;
                if is_bounded {
                    let depth = bounded_layout(&gpu);
                    own.layout = gpu.pipeline_layout("bounded shadows", &[frame, Some(&depth)]);
                    own.shader = gpu.shader(BOUNDED_SHADER)?;
                    own.depth_layout = Some(depth);
                }
            }
            VolumeSource::Pulled(mesh) => own.pull(fill, mesh)?,
            VolumeSource::Computed(computed) => {
                let (finder, buffers) = Finder::new(fill, &computed)?;
                (own.finder, own.buffers) = (Some(finder), Some(buffers));
                own.ranges = computed.mesh.ranges;
            }
            VolumeSource::Adjacent(_) => {
                let api = terrafill_gpu::API.name;
                return Err(DeviceError::unsupported("geometry shaders", api));
            }
        }
        Ok(own)
    }

    /// A vertex shader pulls a mesh.
    fn pull(&mut self, fill: &VolumeFill, mesh: EyeMesh) -> Result<(), DeviceError> {
        let gpu = fill.gpu();
        let upload = |label, bytes: &[u8]| gpu.upload(label, bytes, wgpu::BufferUsages::STORAGE);
        let mut buffers = vec![
            upload("caster places", bytemuck::cast_slice(&mesh.places))?,
            upload("caster pieces", bytemuck::cast_slice(&mesh.pieces))?,
        ];
        let mut shader = CORNERS_SHADER;
        if !mesh.lit.is_empty() {
            buffers.push(upload("facing bits", bytemuck::cast_slice(&mesh.lit))?);
            shader = PULLED_SHADER;
        }
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let kinds = vec![storage; buffers.len()];
        let own = gpu.buffer_layout("casters", wgpu::ShaderStages::VERTEX, &kinds);
        let buffers: Vec<&wgpu::Buffer> = buffers.iter().collect();
        self.bound = Some(gpu.bind_buffers("casters", &own, &buffers));
        let groups = [Some(fill.frame_layout()), Some(&own)];
        self.layout = gpu.pipeline_layout("pulled shadows", &groups);
        self.shader = gpu.shader(shader)?;
        let corners = |pieces: Range<u32>| 3 * pieces.start..3 * pieces.end;
        self.ranges = mesh.ranges.into_iter().map(corners).collect();
        Ok(())
    }
}

impl HandedOver for OnWgpu {
    fn hand_over(&mut self, volumes: &EyeVolumes) -> Result<(), DeviceError> {
        let Some([vertices, indices]) = &self.buffers else {
            return Err(DeviceError::unsupported(
                "volumes of the CPU",
                "a shader that finds them",
            ));
        };
        self.gpu
            .write_buffer(vertices, 0, bytemuck::cast_slice(&volumes.vertices));
        self.gpu
            .write_buffer(indices, 0, bytemuck::cast_slice(&volumes.indices));
        Ok(())
    }
}

impl WgpuVolumes for OnWgpu {
    fn make(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        _list: &VolumeList,
        _constants: &wgpu::BindGroup,
    ) {
        if let Some(finder) = &self.finder {
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
        let Some(layout) = &self.depth_layout else {
            return Ok(());
        };
        let ranges = list.volumes.iter();
        let ranges = ranges.map(|volume| [volume.depth.low, volume.depth.high]);
        let mut ranges: Vec<[f32; 2]> = ranges.collect();
        // A binding of 0 bytes is not allowed.
        ranges.resize(ranges.len().max(1), [0.0; 2]);
        let bytes = bytemuck::cast_slice(&ranges);
        let ranges = gpu.upload("ranges of depth", bytes, wgpu::BufferUsages::STORAGE)?;
        let copy = wgpu::BindingResource::TextureView(copy);
        let resources = [copy, ranges.as_entire_binding()];
        self.bound = Some(gpu.bind("depth and ranges", layout, resources));
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
            buffers: match self.buffers {
                Some(_) => &vertices,
                None => &[],
            },
            strip_index_format: None,
            front_face: wgpu::FrontFace::Ccw,
            discards: self.depth_layout.is_some(),
        };
        let pipeline = || shader.pipeline(gpu, draw.state, blends);
        self.pipelines.entry(draw.state).or_insert_with(pipeline);
    }

    fn bind(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some([vertices, indices]) = &self.buffers {
            pass.set_vertex_buffer(0, vertices.slice(..));
            pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
        }
        if let Some(bound) = &self.bound {
            pass.set_bind_group(1, bound, &[]);
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
            match (&self.finder, &self.buffers) {
                (Some(finder), _) => {
                    let offset = size_of::<u32>() * ARGUMENTS * caster;
                    pass.draw_as_decided(&finder.draws, offset as u64);
                }
                (None, Some(_)) => pass.draw_indexed(range, 0, volume),
                (None, None) => pass.draw(range, volume),
            }
        }
    }
}
