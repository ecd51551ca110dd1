// SPDX-License-Identifier: MIT OR Apache-2.0
//! Layers on wgpu: their pictures as textures, and colours in `f32` so that what is not finite is seen.

use super::layers::Lights;
use super::texels::{Pictures, Texels};
use super::way::{Layer, Shading};
use crate::made::device::SpiralConstants;
use crate::made::spiral::Spiral;
use crate::made::stored::{DrawnRange, StoredSpiral};
use crate::projection::{K, Projection};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;
use terrafill_contract::{DeviceError, ViewConstants};
use terrafill_core::nearest_f32;
use terrafill_globe_views::{
    Canvas, Eye, Stages, texture, uniform, vertices, view_constants, write_layers,
};
use terrafill_gpu::Gpu;
use terrafill_scene::ImageSize;

const TARGET: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
const LAYERS: usize = 4;

/// As `vertex_main` of `globes/layers.wgsl` reads it.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct LayerVertex {
    pub(crate) clip: [f32; 4],
    pub(crate) to_eye: [f32; 3],
    pub(crate) normal: [f32; 3],
}

/// Twin of `LayerConstants`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct LayerConstants {
    sun: [f32; 3],
    padding: f32,
    clouds: [[f32; 4]; 3],
}

impl LayerConstants {
    fn new(lights: &Lights) -> Self {
        let row = |i: usize| {
            let row = lights.clouds.row(i).as_vec3();
            [row.x, row.y, row.z, 0.0]
        };
        Self {
            sun: lights.sun.as_vec3().to_array(),
            padding: 0.0,
            clouds: [row(0), row(1), row(2)],
        }
    }
}

/// Twin of `MapConstants`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct MapConstants {
    cosine: f32,
    sine: f32,
    latitude: f32,
    reach: f32,
}

impl MapConstants {
    fn new(eye: &Eye) -> Self {
        let focus = eye.pose.eye;
        let (sine, cosine) = focus.longitude_rad.sin_cos();
        let [cosine, sine, latitude, reach] =
            [cosine, sine, focus.latitude_rad, K].map(nearest_f32);
        Self {
            cosine,
            sine,
            latitude,
            reach,
        }
    }
}

/// Pictures of the layers on the device: cubes with bumps by tangents and with bent normals, and pictures by angles.
pub(crate) struct LayerTextures {
    cubes: [Vec<wgpu::Texture>; 2],
    maps: Vec<wgpu::Texture>,
}

impl LayerTextures {
    pub(crate) fn new(gpu: &Gpu, pictures: &Pictures) -> Self {
        let filled = |shading| {
            let texels = pictures.read_by(shading).into_iter();
            texels.map(|texels| filled(gpu, texels)).collect()
        };
        let base = Shading::default();
        Self {
            cubes: [false, true].map(|is_object_space| {
                filled(Shading {
                    is_object_space,
                    ..base
                })
            }),
            maps: filled(Shading {
                by_angles: true,
                ..base
            }),
        }
    }

    /// A layer as a cube, bumps by tangents, and as a picture by angles.
    pub(crate) fn views(
        &self,
        layer: Layer,
        dimensions: [wgpu::TextureViewDimension; 2],
    ) -> [wgpu::TextureView; 2] {
        let [cubes, _] = &self.cubes;
        let [cube, map] = dimensions.map(viewed);
        let at = layer as usize;
        [
            cubes[at].create_view(&cube),
            self.maps[at].create_view(&map),
        ]
    }
}

fn viewed(dimension: wgpu::TextureViewDimension) -> wgpu::TextureViewDescriptor<'static> {
    wgpu::TextureViewDescriptor {
        dimension: Some(dimension),
        ..Default::default()
    }
}

/// Filters between texels, and goes round in longitude.
pub(crate) fn sampler(gpu: &Gpu) -> wgpu::Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("layers"),
        address_mode_u: wgpu::AddressMode::Repeat,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    })
}

fn filled(gpu: &Gpu, texels: &Texels) -> wgpu::Texture {
    let [width, height] = texels.size;
    let layers = if texels.is_cube { 6 } else { 1 };
    let size = [width, height, layers];
    let texture = texture(gpu, "layer", size, wgpu::TextureFormat::Rgba8Unorm);
    write_layers(gpu, &texture, 0, texels.texels.as_flattened());
    texture
}

/// What is drawn of a view.
#[derive(Clone, Copy)]
pub(crate) enum Geometry<'a> {
    /// Vertices that the CPU projected, sent for each frame.
    Sent(&'a [LayerVertex]),
    /// A range of the static buffer, projected by the vertex stage.
    Stored(&'a Spiral),
}

/// Targets of one size, and what all pipelines share.
pub(crate) struct LayerTargets {
    canvas: Canvas,
    layout: wgpu::PipelineLayout,
    view_layout: wgpu::BindGroupLayout,
    constants_layout: wgpu::BindGroupLayout,
    stored: StoredSpiral,
    /// Its vertices and indices.
    stored_buffers: [wgpu::Buffer; 2],
    /// Bumps by tangents, and bent normals.
    pictures: [wgpu::BindGroup; 2],
}

/// A way to shade, and the vertices that it draws.
pub(crate) struct LayerScene {
    pipeline: wgpu::RenderPipeline,
    /// Of the view, of layers, of the spiral, of the map.
    constants: [wgpu::Buffer; 4],
    bound: [wgpu::BindGroup; 2],
    is_object_space: bool,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
    range: Option<DrawnRange>,
}

impl LayerTargets {
    /// - `per_turn`: vertices of a turn of the static buffer
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        size: ImageSize,
        textures: &LayerTextures,
        per_turn: u32,
    ) -> Result<Self, DeviceError> {
        let uniform = wgpu::BufferBindingType::Uniform;
        let view_layout = gpu.buffer_layout("view", wgpu::ShaderStages::VERTEX, &[uniform]);
        let constants_layout =
            gpu.buffer_layout("layers", wgpu::ShaderStages::VERTEX_FRAGMENT, &[uniform; 3]);
        let stored = StoredSpiral::new(per_turn);
        let bytes = bytemuck::cast_slice(&stored.vertices);
        let stored_vertices = gpu.upload("stored spiral", bytes, wgpu::BufferUsages::VERTEX)?;
        let bytes = bytemuck::cast_slice(&stored.indices);
        let usage = wgpu::BufferUsages::INDEX;
        let stored_indices = gpu.upload("triangles of the stored spiral", bytes, usage)?;
        let picture = |view_dimension| wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension,
            multisampled: false,
        };
        let mut types = vec![picture(wgpu::TextureViewDimension::Cube); LAYERS];
        types.extend(vec![picture(wgpu::TextureViewDimension::D2); LAYERS]);
        types.push(wgpu::BindingType::Sampler(
            wgpu::SamplerBindingType::Filtering,
        ));
        let pictures_layout = gpu.fragment_layout("layers", &types);
        let views = |textures: &[wgpu::Texture], dimension| {
            let descriptor = viewed(dimension);
            let views = textures.iter();
            let views = views.map(|texture| texture.create_view(&descriptor));
            views.collect::<Vec<_>>()
        };
        let maps = views(&textures.maps, wgpu::TextureViewDimension::D2);
        let sampler = sampler(gpu);
        let pictures = textures.cubes.each_ref().map(|cubes| {
            let cubes = views(cubes, wgpu::TextureViewDimension::Cube);
            let views = cubes.iter().chain(&maps);
            let views = views.map(wgpu::BindingResource::TextureView);
            let sampler = wgpu::BindingResource::Sampler(&sampler);
            gpu.bind("layers", &pictures_layout, views.chain([sampler]))
        });
        let groups = [&view_layout, &pictures_layout, &constants_layout].map(Some);
        Ok(Self {
            layout: gpu.pipeline_layout("layers", &groups),
            view_layout,
            constants_layout,
            stored,
            stored_buffers: [stored_vertices, stored_indices],
            pictures,
            canvas: Canvas::new(gpu, size, TARGET),
        })
    }

    pub(crate) fn scene(
        &self,
        (shading, projection): (Shading, Projection),
        geometry: Geometry<'_>,
        triangles: &[[u32; 3]],
    ) -> Result<LayerScene, DeviceError> {
        let gpu = &self.canvas.gpu;
        let module = gpu.shader("globes/layers.wgsl")?;
        let constants = [
            ("REMOVED", f64::from(shading.removed)),
            ("BY_ANGLES", f64::from(u8::from(shading.by_angles))),
            ("OBJECT_SPACE", f64::from(u8::from(shading.is_object_space))),
            ("BUMP_SCALE", f64::from(shading.bump_scale)),
            ("FAULT", f64::from(shading.fault)),
            ("SERIES", 1.0),
            ("PROJECTION", of_shader(projection)),
        ];
        let sent = wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x3, 2 => Float32x3];
        let stored = wgpu::vertex_attr_array![0 => Float32x3];
        let (entry_point, attributes) = match geometry {
            Geometry::Sent(_) => ("vertex_main", &sent[..]),
            Geometry::Stored(_) => ("stored_main", &stored[..]),
        };
        let stages = Stages {
            module: &module,
            entry_points: [entry_point, "fragment_main"],
            constants: &constants,
            buffers: &[vertices(attributes)],
        };
        let pipeline = self.canvas.pipeline("layers", &self.layout, &stages);
        let indices = triangles.as_flattened();
        let constants = [
            uniform::<ViewConstants>(gpu, "view constants"),
            uniform::<LayerConstants>(gpu, "layer constants"),
            uniform::<SpiralConstants>(gpu, "spiral"),
            uniform::<MapConstants>(gpu, "map constants"),
        ];
        let [view, of_layers @ ..] = &constants;
        let [stored_vertices, stored_indices] = &self.stored_buffers;
        let (vertices, indices_buffer) = match geometry {
            Geometry::Sent(vertices) => {
                let vertices = bytemuck::cast_slice(vertices);
                let bytes = bytemuck::cast_slice(indices);
                (
                    gpu.upload("layer vertices", vertices, wgpu::BufferUsages::VERTEX)?,
                    gpu.upload("layer indices", bytes, wgpu::BufferUsages::INDEX)?,
                )
            }
            Geometry::Stored(_) => (stored_vertices.clone(), stored_indices.clone()),
        };
        Ok(LayerScene {
            pipeline,
            bound: [
                gpu.bind_buffers("view", &self.view_layout, &[view]),
                gpu.bind_buffers("layers", &self.constants_layout, &of_layers.each_ref()),
            ],
            constants,
            is_object_space: shading.is_object_space,
            vertices,
            indices: indices_buffer,
            range: None,
            count: u32::try_from(indices.len()).unwrap_or(u32::MAX),
        })
    }

    /// Sends what a frame needs anew: where eye, sun and clouds are, and vertices unless they are stored; bytes that
    /// were sent.
    pub(crate) fn send(
        &self,
        scene: &mut LayerScene,
        (eye, lights): (&Eye, &Lights),
        geometry: Geometry<'_>,
    ) -> usize {
        let (vertices, spiral) = match geometry {
            Geometry::Sent(vertices) => (vertices, None),
            Geometry::Stored(spiral) => (&[][..], Some(spiral)),
        };
        scene.range = spiral.map(|spiral| self.stored.range(spiral));
        let view = spiral.map(|_| view_constants(eye));
        let layers = LayerConstants::new(lights);
        let map = spiral.map(|_| MapConstants::new(eye));
        let spiral = spiral.map(SpiralConstants::new);
        let [of_view, of_layers, of_spiral, of_map] = &scene.constants;
        let all: [(&wgpu::Buffer, &[u8]); 5] = [
            (&scene.vertices, bytemuck::cast_slice(vertices)),
            (of_view, bytemuck::cast_slice(view.as_slice())),
            (of_layers, bytemuck::bytes_of(&layers)),
            (of_spiral, bytemuck::cast_slice(spiral.as_slice())),
            (of_map, bytemuck::cast_slice(map.as_slice())),
        ];
        for (buffer, bytes) in all.iter().filter(|(_, bytes)| !bytes.is_empty()) {
            self.canvas.gpu.write_buffer(buffer, 0, bytes);
        }
        all.iter().map(|(_, bytes)| bytes.len()).sum()
    }

    pub(crate) fn draw(&self, scene: &LayerScene) -> Result<Option<f64>, DeviceError> {
        let mut encoder = self.canvas.frame();
        self.canvas.record(&mut encoder, |pass| {
            pass.set_pipeline(&scene.pipeline);
            let pictures = &self.pictures[usize::from(scene.is_object_space)];
            let [view, layers] = &scene.bound;
            for (at, bound) in (0..).zip([view, pictures, layers]) {
                pass.set_bind_group(at, bound, &[]);
            }
            pass.set_vertex_buffer(0, scene.vertices.slice(..));
            pass.set_index_buffer(scene.indices.slice(..), wgpu::IndexFormat::Uint32);
            match &scene.range {
                Some(range) => {
                    pass.draw_indexed(range.fan.clone(), range.base_vertex, 0..1);
                    pass.draw_indexed(range.turns.clone(), 0, 0..1);
                }
                None => pass.draw_indexed(0..scene.count, 0, 0..1),
            }
        });
        self.canvas.finish(encoder)
    }

    /// Colours in rows; alpha is 1 where a surface is shown.
    pub(crate) fn read(&self) -> Result<Vec<[f32; 4]>, DeviceError> {
        self.canvas.read()
    }
}

/// As the shader numbers it.
fn of_shader(projection: Projection) -> f64 {
    match projection {
        Projection::Globe => 0.0,
        Projection::Flat => 1.0,
        Projection::HyperbolicPolar => 2.0,
        Projection::HyperbolicCartesian => 3.0,
        Projection::Dome => 4.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_lie_as_the_shader_reads_them() {
        let layout = terrafill_shaders::struct_layout("globes/layers.wgsl", "LayerConstants");
        let members = layout.expect("a struct").members;
        let offsets: Vec<u32> = members.iter().map(|member| member.1).collect();
        assert_eq!(offsets, [0, 12, 16, 32, 48]);
        assert_eq!(std::mem::offset_of!(LayerConstants, clouds), 16);
        let layout = terrafill_shaders::struct_layout("globes/layers.wgsl", "MapConstants");
        let members = layout.expect("a struct").members;
        let offsets: Vec<u32> = members.iter().map(|member| member.1).collect();
        assert_eq!(offsets, [0, 4, 8, 12]);
        assert_eq!(std::mem::offset_of!(MapConstants, reach), 12);
    }

    #[test]
    fn the_papers_undeclared_variable_does_not_compile() {
        let source = terrafill_shaders::compose("globes/layers.wgsl").expect("the shader");
        assert!(terrafill_shaders::validate("globes/layers.wgsl", &source).is_ok());
        // The paper's listing multiplies the highlight by texcolor.a, which nothing declares.
        let faulty = source.replace("* base.a", "* texcolor.a");
        assert_ne!(faulty, source);
        let error =
            terrafill_shaders::validate("globes/layers.wgsl", &faulty).expect_err("undeclared");
        assert!(error.to_string().contains("texcolor"), "{error}");
    }
}
