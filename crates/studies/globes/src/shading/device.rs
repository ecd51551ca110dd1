// SPDX-License-Identifier: MIT OR Apache-2.0
//! Layers on wgpu: pictures baked from the functions, and colours in `f32` so that what is not finite is seen.

use super::layers::{Lights, base, bump, cloud, night};
use crate::canvas::{self, Canvas, Stages, on_cube, texture, write_layers};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use terrafill_contract::DeviceError;
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

/// What the pipeline is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Shading {
    pub(crate) removed: u32,
    pub(crate) by_angles: bool,
    pub(crate) fault: u32,
}

/// Pictures of the layers, both ways.
pub(crate) struct Pictures {
    cubes: Vec<wgpu::Texture>,
    maps: Vec<wgpu::Texture>,
}

/// Direction of a texel of a cube's face.
fn face_direction(face: u32, at: [f64; 2]) -> DVec3 {
    on_cube(face, at.map(|at| 2.0 * at - 1.0)).normalize()
}

fn map_direction([u, v]: [f64; 2]) -> DVec3 {
    let (sin, cos) = (TAU * (u - 0.5)).sin_cos();
    let (up, across) = (PI * (0.5 - v)).sin_cos();
    DVec3::new(across * cos, across * sin, up)
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "a share of 255 after clamping"
)]
fn texel(layer: usize, direction: DVec3) -> [u8; 4] {
    let values = match layer {
        0 => base(direction),
        1 => {
            let [along, east, north] = bump(direction).map(|share| 0.5 * share + 0.5);
            [along, east, north, 1.0]
        }
        2 => {
            let white = cloud(direction);
            [white, white, white, 1.0]
        }
        _ => {
            let [r, g, b] = night(direction);
            [r, g, b, 1.0]
        }
    };
    values.map(|value| (255.0 * value.clamp(0.0, 1.0)).round() as u8)
}

/// Texels of a picture in rows.
fn baked(
    layer: usize,
    [width, height]: [u32; 2],
    direction: impl Fn([f64; 2]) -> DVec3 + Sync,
) -> Vec<u8> {
    let texels: Vec<[u8; 4]> = (0..width * height)
        .into_par_iter()
        .map(|at| {
            let place = [
                (f64::from(at % width) + 0.5) / f64::from(width),
                (f64::from(at / width) + 0.5) / f64::from(height),
            ];
            texel(layer, direction(place))
        })
        .collect();
    texels.into_flattened()
}

impl Pictures {
    /// - `face`: texels along a side of a cube's face; pictures by angles have four times as many across, which is as
    ///   dense along the equator
    pub(crate) fn new(gpu: &Gpu, face: u32) -> Self {
        let cubes = (0..LAYERS).map(|layer| {
            let texels: Vec<u8> = (0..6)
                .flat_map(|number| baked(layer, [face; 2], |at| face_direction(number, at)))
                .collect();
            filled(gpu, [face, face, 6], &texels)
        });
        let size = [4 * face, 2 * face];
        let maps = (0..LAYERS).map(|layer| {
            let texels = baked(layer, size, map_direction);
            filled(gpu, [size[0], size[1], 1], &texels)
        });
        Self {
            cubes: cubes.collect(),
            maps: maps.collect(),
        }
    }
}

fn filled(gpu: &Gpu, size: [u32; 3], texels: &[u8]) -> wgpu::Texture {
    let texture = texture(gpu, "layer", size, wgpu::TextureFormat::Rgba8Unorm);
    write_layers(gpu, &texture, 0, texels);
    texture
}

/// Targets of one size, and what all pipelines share.
pub(crate) struct LayerTargets {
    canvas: Canvas,
    layout: wgpu::PipelineLayout,
    bound: [wgpu::BindGroup; 2],
}

/// A way to shade, and the vertices that it draws.
pub(crate) struct LayerScene {
    pipeline: wgpu::RenderPipeline,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
}

impl LayerTargets {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        size: ImageSize,
        pictures: &Pictures,
        lights: &Lights,
    ) -> Result<Self, DeviceError> {
        let constants = LayerConstants::new(lights);
        let bytes = bytemuck::bytes_of(&constants);
        let constants = gpu.upload("layer constants", bytes, wgpu::BufferUsages::UNIFORM)?;
        let fragment = wgpu::ShaderStages::FRAGMENT;
        let uniform = gpu.buffer_layout("layers", fragment, &[wgpu::BufferBindingType::Uniform]);
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
            let descriptor = wgpu::TextureViewDescriptor {
                dimension: Some(dimension),
                ..Default::default()
            };
            let views = textures.iter();
            let views = views.map(|texture| texture.create_view(&descriptor));
            views.collect::<Vec<_>>()
        };
        let cubes = views(&pictures.cubes, wgpu::TextureViewDimension::Cube);
        let maps = views(&pictures.maps, wgpu::TextureViewDimension::D2);
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("layers"),
            address_mode_u: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let views = cubes.iter().chain(&maps);
        let views = views.map(wgpu::BindingResource::TextureView);
        let sampler = wgpu::BindingResource::Sampler(&sampler);
        let bound_pictures = gpu.bind("layers", &pictures_layout, views.chain([sampler]));
        Ok(Self {
            layout: gpu.pipeline_layout("layers", &[Some(&uniform), Some(&pictures_layout)]),
            bound: [
                gpu.bind_buffers("layers", &uniform, &[&constants]),
                bound_pictures,
            ],
            canvas: Canvas::new(gpu, size, TARGET),
        })
    }

    pub(crate) fn scene(
        &self,
        shading: Shading,
        vertices: &[LayerVertex],
        triangles: &[[u32; 3]],
    ) -> Result<LayerScene, DeviceError> {
        let gpu = &self.canvas.gpu;
        let module = gpu.shader("globes/layers.wgsl")?;
        let constants = [
            ("REMOVED", f64::from(shading.removed)),
            ("BY_ANGLES", f64::from(u8::from(shading.by_angles))),
            ("FAULT", f64::from(shading.fault)),
        ];
        let attributes = wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x3, 2 => Float32x3];
        let stages = Stages {
            module: &module,
            entry_points: ["vertex_main", "fragment_main"],
            constants: &constants,
            buffers: &[canvas::vertices(&attributes)],
        };
        let pipeline = self.canvas.pipeline("layers", &self.layout, &stages);
        let (vertices, indices) = (bytemuck::cast_slice(vertices), triangles.as_flattened());
        Ok(LayerScene {
            pipeline,
            vertices: gpu.upload("layer vertices", vertices, wgpu::BufferUsages::VERTEX)?,
            indices: gpu.upload(
                "layer indices",
                bytemuck::cast_slice(indices),
                wgpu::BufferUsages::INDEX,
            )?,
            count: u32::try_from(indices.len()).unwrap_or(u32::MAX),
        })
    }

    /// Sends the vertices anew.
    pub(crate) fn send(&self, scene: &LayerScene, vertices: &[LayerVertex]) {
        self.canvas
            .gpu
            .write_buffer(&scene.vertices, 0, bytemuck::cast_slice(vertices));
    }

    pub(crate) fn draw(&self, scene: &LayerScene) -> Result<Option<f64>, DeviceError> {
        let mut encoder = self.canvas.frame();
        self.canvas.record(&mut encoder, |pass| {
            pass.set_pipeline(&scene.pipeline);
            for (at, bound) in (0..).zip(&self.bound) {
                pass.set_bind_group(at, bound, &[]);
            }
            pass.set_vertex_buffer(0, scene.vertices.slice(..));
            pass.set_index_buffer(scene.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..scene.count, 0, 0..1);
        });
        self.canvas.finish(encoder)
    }

    /// Colours in rows; alpha is 1 where a surface is shown.
    pub(crate) fn read(&self) -> Result<Vec<[f32; 4]>, DeviceError> {
        self.canvas.read()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_and_pictures_hold_the_directions_that_look_them_up() {
        // Middles of faces, as WebGPU numbers them, and the corner that three share.
        let axes = [
            DVec3::X,
            -DVec3::X,
            DVec3::Y,
            -DVec3::Y,
            DVec3::Z,
            -DVec3::Z,
        ];
        for (face, axis) in (0..).zip(axes) {
            assert!((face_direction(face, [0.5; 2]) - axis).length() < 1e-12);
        }
        let corner = DVec3::ONE.normalize();
        for (face, at) in [(0, [0.0, 0.0]), (2, [1.0, 1.0]), (4, [1.0, 0.0])] {
            assert!(
                (face_direction(face, at) - corner).length() < 1e-12,
                "{face}"
            );
        }
        assert!((map_direction([0.5, 0.5]) - DVec3::X).length() < 1e-12);
        assert!((map_direction([0.75, 0.5]) - DVec3::Y).length() < 1e-12);
        assert!((map_direction([0.1, 0.0]) - DVec3::Z).length() < 1e-12);
    }

    #[test]
    fn constants_lie_as_the_shader_reads_them() {
        let layout = terrafill_shaders::struct_layout("globes/layers.wgsl", "LayerConstants");
        let members = layout.expect("a struct").members;
        let offsets: Vec<u32> = members.iter().map(|member| member.1).collect();
        assert_eq!(offsets, [0, 12, 16, 32, 48]);
        assert_eq!(std::mem::offset_of!(LayerConstants, clouds), 16);
    }

    #[test]
    fn the_papers_undeclared_variable_does_not_compile() {
        let source = terrafill_shaders::compose("globes/layers.wgsl").expect("the shader");
        assert!(terrafill_shaders::validate("layers", &source).is_ok());
        // The paper's listing multiplies the highlight by texcolor.a, which nothing declares.
        let faulty = source.replace("* base.a", "* texcolor.a");
        assert_ne!(faulty, source);
        let error = terrafill_shaders::validate("layers", &faulty).expect_err("undeclared");
        assert!(error.to_string().contains("texcolor"), "{error}");
    }
}
