// SPDX-License-Identifier: MIT OR Apache-2.0
//! The spiral on wgpu, its vertices from wherever they come.

use super::spiral::{Law, Lookup, Relief, Source, Spiral};
use super::stored::{DrawnRange, StoredSpiral};
use bytemuck::{Pod, Zeroable};
use std::f64::consts::TAU;
use std::sync::Arc;
use terrafill_contract::{DeviceError, ViewConstants};
use terrafill_core::nearest_f32;
use terrafill_globe_views::{
    Canvas, Eye, Stages, texture, uniform, vertices, view_constants, write_layers, written,
};
use terrafill_gpu::{Gpu, read_buffer};
use terrafill_scene::ImageSize;

const TARGET: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// Bytes of a vertex.
const VERTEX_BYTES: u64 = 12;
const FACES: u32 = 6;

/// Twin of `SpiralConstants` in `shared/spiral.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct SpiralConstants {
    east: [f32; 3],
    inner: f32,
    north: [f32; 3],
    outer: f32,
    up: [f32; 3],
    turns: f32,
    focus: [f32; 3],
    per_turn: u32,
    count: u32,
    law: u32,
    first: u32,
    padding: u32,
}

impl SpiralConstants {
    pub(crate) fn new(spiral: &Spiral) -> Self {
        let [east, north, up] = spiral.axes.map(|axis| axis.as_vec3().to_array());
        Self {
            east,
            inner: nearest_f32(spiral.inner),
            north,
            outer: nearest_f32(spiral.outer),
            up,
            turns: nearest_f32(spiral.turns),
            focus: spiral.focus.as_vec3().to_array(),
            per_turn: spiral.per_turn,
            count: spiral.count(),
            law: match spiral.law {
                Law::Exponential => 0,
                Law::Quadratic => 1,
                Law::Published => 2,
            },
            first: spiral.first,
            padding: 0,
        }
    }
}

/// Twin of `Relief` in `globes/spiral.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct ReliefConstants {
    per_metre: [f32; 3],
    base_m: f32,
    up: [f32; 3],
    radius_m: f32,
    normal: [f32; 3],
    side: u32,
    ground: [f32; 3],
    face: u32,
    on_face: [f32; 2],
    within: [f32; 2],
    cell: [u32; 2],
    padding: [u32; 2],
}

impl ReliefConstants {
    fn new(spiral: &Spiral, relief: &Relief) -> Self {
        let up = spiral.axes[2] / spiral.radii;
        let below = relief.heights.on_face(up);
        Self {
            per_metre: spiral.radii.recip().as_vec3().to_array(),
            base_m: nearest_f32(relief.base_m),
            up: up.as_vec3().to_array(),
            radius_m: nearest_f32(spiral.radii.x),
            normal: relief.normal.as_vec3().to_array(),
            side: relief.heights.side,
            ground: relief.ground.as_vec3().to_array(),
            face: below.face,
            on_face: below.place.map(nearest_f32),
            within: below.within.map(nearest_f32),
            cell: below.cell,
            padding: [0; 2],
        }
    }
}

/// Targets, and layouts of what shaders read.
pub(crate) struct MadeTargets {
    canvas: Canvas,
    view_layout: wgpu::BindGroupLayout,
    /// Constants, directions, terrain and stored vertices, and for the compute shader the buffer that it writes.
    layouts: [wgpu::BindGroupLayout; 2],
    stored: StoredSpiral,
    /// Its vertices and indices.
    stored_buffers: [wgpu::Buffer; 2],
}

/// How vertices are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Making {
    pub(crate) source: Source,
    pub(crate) lookup: Option<Lookup>,
    pub(crate) has_series: bool,
    /// From those that are stored: always by the source of that name, and by the compute shader that it is held to.
    pub(crate) is_stored: bool,
}

/// A spiral, ready to draw.
pub(crate) struct MadeScene {
    source: Source,
    pipeline: wgpu::RenderPipeline,
    compute: Option<wgpu::ComputePipeline>,
    view: wgpu::Buffer,
    bound_view: wgpu::BindGroup,
    constants: wgpu::Buffer,
    relief: wgpu::Buffer,
    bound: [wgpu::BindGroup; 2],
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
    vertex_count: u32,
    /// Of the stored buffers, where they are drawn.
    range: Option<DrawnRange>,
}

impl MadeTargets {
    pub(crate) fn new(gpu: &Arc<Gpu>, size: ImageSize, per_turn: u32) -> Result<Self, DeviceError> {
        let uniform = wgpu::BufferBindingType::Uniform;
        let buffer = |ty| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let storage = |read_only| buffer(wgpu::BufferBindingType::Storage { read_only });
        let heights = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        };
        let (vertex, compute) = (wgpu::ShaderStages::VERTEX, wgpu::ShaderStages::COMPUTE);
        let read = [
            buffer(uniform),
            storage(true),
            buffer(uniform),
            heights,
            storage(true),
        ];
        let all = [&read[..], &[storage(false)]].concat();
        let stored = StoredSpiral::new(per_turn);
        let usage = wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::STORAGE;
        let bytes = bytemuck::cast_slice(&stored.vertices);
        let stored_vertices = gpu.upload("stored spiral", bytes, usage)?;
        let bytes = bytemuck::cast_slice(&stored.indices);
        let usage = wgpu::BufferUsages::INDEX;
        let stored_indices = gpu.upload("triangles of the stored spiral", bytes, usage)?;
        Ok(Self {
            view_layout: gpu.buffer_layout("view", vertex, &[uniform]),
            layouts: [
                gpu.mixed_layout("spiral", read.map(|ty| (vertex, ty))),
                gpu.mixed_layout("spiral", all.into_iter().map(|ty| (compute, ty))),
            ],
            stored,
            stored_buffers: [stored_vertices, stored_indices],
            canvas: Canvas::new(gpu, size, TARGET),
        })
    }

    pub(crate) fn scene(&self, spiral: &Spiral, making: Making) -> Result<MadeScene, DeviceError> {
        let Making { source, lookup, .. } = making;
        let gpu = &self.canvas.gpu;
        let view = uniform::<ViewConstants>(gpu, "view constants");
        let constants = uniform::<SpiralConstants>(gpu, "spiral");
        let directions: Vec<[f32; 2]> = (0..spiral.per_turn)
            .map(|k| direction(k, spiral.per_turn))
            .collect();
        let bytes = bytemuck::cast_slice(&directions);
        let directions = gpu.upload("directions", bytes, wgpu::BufferUsages::STORAGE)?;
        let usage =
            wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let size = VERTEX_BYTES * u64::from(spiral.count());
        let made_vertices = written(gpu, "vertices of the spiral", size, usage);
        let triangles = spiral.triangles();
        let indices = triangles.as_flattened();
        let bytes = bytemuck::cast_slice(indices);
        let index_buffer =
            gpu.upload("triangles of the spiral", bytes, wgpu::BufferUsages::INDEX)?;
        let relief = uniform::<ReliefConstants>(gpu, "relief");
        let field = spiral.relief.as_ref().map(|relief| &relief.heights);
        let across = field.map_or(1, |heights| heights.side + 1);
        let format = wgpu::TextureFormat::R32Float;
        let heights = texture(gpu, "heights", [across, across, FACES], format);
        if let Some(field) = field {
            write_layers(gpu, &heights, 0, bytemuck::cast_slice(&field.samples));
        }
        let heights = heights.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let [read, made] = &self.layouts;
        let [stored_vertices, stored_indices] = &self.stored_buffers;
        let resources = || {
            [
                constants.as_entire_binding(),
                directions.as_entire_binding(),
                relief.as_entire_binding(),
                wgpu::BindingResource::TextureView(&heights),
                stored_vertices.as_entire_binding(),
            ]
        };
        let written = [made_vertices.as_entire_binding()];
        let bound = [
            gpu.bind("spiral", read, resources()),
            gpu.bind("spiral", made, resources().into_iter().chain(written)),
        ];
        let module = gpu.shader("globes/spiral.wgsl")?;
        let flag = |is_set| f64::from(u8::from(is_set));
        let overrides = [
            ("SERIES", flag(making.has_series)),
            ("STORED", flag(making.is_stored)),
            ("LOCAL", flag(lookup == Some(Lookup::Local))),
        ];
        let compute = (source == Source::Compute).then(|| {
            let entry_point = match lookup {
                Some(_) => "make_displaced_main",
                None => "make_main",
            };
            let groups = [None, Some(made)];
            gpu.compute_pipeline("spiral", &module, entry_point, &groups, &overrides)
        });
        let attributes = wgpu::vertex_attr_array![0 => Float32x3];
        let buffer = [vertices(&attributes)];
        let groups = [Some(&self.view_layout), Some(read)];
        let (entry_point, buffers, groups) = match source {
            Source::Number if lookup.is_some() => {
                ("making_displaced_main", &buffer[..0], &groups[..])
            }
            Source::Number => ("making_main", &buffer[..0], &groups[..]),
            Source::Static if lookup.is_some() => {
                ("stored_displaced_main", &buffer[..], &groups[..])
            }
            Source::Static => ("stored_main", &buffer[..], &groups[..]),
            Source::Sent | Source::Compute => ("read_main", &buffer[..], &groups[..1]),
        };
        let layout = gpu.pipeline_layout("spiral", groups);
        let stages = Stages {
            module: &module,
            entry_points: [entry_point, "fragment_main"],
            constants: &overrides,
            buffers,
        };
        let pipeline = self.canvas.pipeline("spiral", &layout, &stages);
        Ok(MadeScene {
            source,
            pipeline,
            compute,
            bound_view: gpu.bind_buffers("view", &self.view_layout, &[&view]),
            view,
            constants,
            relief,
            bound,
            vertices: match source {
                Source::Static => stored_vertices.clone(),
                Source::Sent | Source::Compute | Source::Number => made_vertices,
            },
            index_count: u32::try_from(indices.len()).unwrap_or(u32::MAX),
            indices: match source {
                Source::Static => stored_indices.clone(),
                Source::Sent | Source::Compute | Source::Number => index_buffer,
            },
            vertex_count: spiral.count(),
            range: None,
        })
    }

    /// Bytes of the stored buffers.
    pub(crate) fn stored_bytes(&self) -> u64 {
        self.stored.bytes()
    }

    /// Hands a view to the device; bytes that were sent.
    pub(crate) fn send(&self, scene: &mut MadeScene, eye: &Eye, spiral: &Spiral) -> u64 {
        let view = view_constants(eye);
        let constants = SpiralConstants::new(spiral);
        let vertices = match scene.source {
            Source::Sent => spiral.vertices(),
            Source::Compute | Source::Number | Source::Static => Vec::new(),
        };
        let is_stored = scene.source == Source::Static;
        scene.range = is_stored.then(|| self.stored.range(spiral));
        let relief = spiral.relief.as_ref();
        let relief = relief.filter(|_| scene.source != Source::Sent);
        let relief = relief.map(|relief| ReliefConstants::new(spiral, relief));
        let all: [(&wgpu::Buffer, &[u8]); 4] = [
            (&scene.view, bytemuck::bytes_of(&view)),
            (&scene.constants, bytemuck::bytes_of(&constants)),
            (&scene.relief, bytemuck::cast_slice(relief.as_slice())),
            (&scene.vertices, bytemuck::cast_slice(&vertices)),
        ];
        for (buffer, bytes) in all.iter().filter(|(_, bytes)| !bytes.is_empty()) {
            self.canvas.gpu.write_buffer(buffer, 0, bytes);
        }
        all.iter().map(|(_, bytes)| bytes.len() as u64).sum()
    }

    pub(crate) fn draw(&self, scene: &MadeScene) -> Result<Option<f64>, DeviceError> {
        let mut encoder = self.canvas.frame();
        if let Some(compute) = &scene.compute {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(compute);
            pass.set_bind_group(1, &scene.bound[1], &[]);
            pass.dispatch_workgroups(scene.vertex_count.div_ceil(64), 1, 1);
        }
        self.canvas.record(&mut encoder, |pass| {
            pass.set_pipeline(&scene.pipeline);
            pass.set_bind_group(0, &scene.bound_view, &[]);
            match scene.source {
                Source::Number => pass.set_bind_group(1, &scene.bound[0], &[]),
                Source::Sent | Source::Compute => {
                    pass.set_vertex_buffer(0, scene.vertices.slice(..));
                }
                Source::Static => {
                    pass.set_bind_group(1, &scene.bound[0], &[]);
                    pass.set_vertex_buffer(0, scene.vertices.slice(..));
                }
            }
            pass.set_index_buffer(scene.indices.slice(..), wgpu::IndexFormat::Uint32);
            match &scene.range {
                Some(range) => {
                    pass.draw_indexed(range.fan.clone(), range.base_vertex, 0..1);
                    pass.draw_indexed(range.turns.clone(), 0, 0..1);
                }
                None => pass.draw_indexed(0..scene.index_count, 0, 0..1),
            }
        });
        self.canvas.finish(encoder)
    }

    /// Vertices that the compute shader made.
    pub(crate) fn vertices(&self, scene: &MadeScene) -> Result<Vec<[f32; 3]>, DeviceError> {
        let bytes = read_buffer(&self.canvas.gpu, &scene.vertices)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    /// Bits of distances, row by row; 0 for the sky.
    pub(crate) fn read(&self) -> Result<Vec<u32>, DeviceError> {
        self.canvas.read()
    }
}

fn direction(k: u32, per_turn: u32) -> [f32; 2] {
    let (sin, cos) = (TAU * f64::from(k) / f64::from(per_turn)).sin_cos();
    [nearest_f32(sin), nearest_f32(cos)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_lie_as_the_shader_reads_them() {
        let layout = terrafill_shaders::struct_layout("globes/spiral.wgsl", "SpiralConstants");
        let layout = layout.expect("a struct");
        let offsets: Vec<u32> = layout.members.iter().map(|member| member.1).collect();
        assert_eq!(offsets, [0, 12, 16, 28, 32, 44, 48, 60, 64, 68, 72]);
        assert_eq!(layout.stride as usize, size_of::<SpiralConstants>());
        let layout = terrafill_shaders::struct_layout("globes/spiral.wgsl", "Relief");
        let layout = layout.expect("a struct");
        let offsets: Vec<u32> = layout.members.iter().map(|member| member.1).collect();
        assert_eq!(offsets, [0, 12, 16, 28, 32, 44, 48, 60, 64, 72, 80]);
        assert_eq!(layout.stride as usize, size_of::<ReliefConstants>());
    }
}
