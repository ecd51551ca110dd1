// SPDX-License-Identifier: MIT OR Apache-2.0
//! Layers on wgpu: their pictures as textures, and colours in `f32` so that what is not finite is seen.

use super::layers::Lights;
use super::texels::{Pictures, Texels};
use crate::canvas::{self, Canvas, Stages, texture, uniform, write_layers};
use bytemuck::{Pod, Zeroable};
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
    /// Bumps are normals along ECEF axes, in place of shares of normal, tangent and binormal.
    pub(crate) is_object_space: bool,
    pub(crate) fault: u32,
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
}

fn filled(gpu: &Gpu, texels: &Texels) -> wgpu::Texture {
    let [width, height] = texels.size;
    let layers = if texels.is_cube { 6 } else { 1 };
    let size = [width, height, layers];
    let texture = texture(gpu, "layer", size, wgpu::TextureFormat::Rgba8Unorm);
    write_layers(gpu, &texture, 0, texels.texels.as_flattened());
    texture
}

/// Targets of one size, and what all pipelines share.
pub(crate) struct LayerTargets {
    canvas: Canvas,
    layout: wgpu::PipelineLayout,
    uniform: wgpu::BindGroupLayout,
    /// Bumps by tangents, and bent normals.
    pictures: [wgpu::BindGroup; 2],
}

/// A way to shade, and the vertices that it draws.
pub(crate) struct LayerScene {
    pipeline: wgpu::RenderPipeline,
    constants: wgpu::Buffer,
    lights: wgpu::BindGroup,
    is_object_space: bool,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
}

impl LayerTargets {
    pub(crate) fn new(gpu: &Arc<Gpu>, size: ImageSize, textures: &LayerTextures) -> Self {
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
        let maps = views(&textures.maps, wgpu::TextureViewDimension::D2);
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("layers"),
            address_mode_u: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let pictures = textures.cubes.each_ref().map(|cubes| {
            let cubes = views(cubes, wgpu::TextureViewDimension::Cube);
            let views = cubes.iter().chain(&maps);
            let views = views.map(wgpu::BindingResource::TextureView);
            let sampler = wgpu::BindingResource::Sampler(&sampler);
            gpu.bind("layers", &pictures_layout, views.chain([sampler]))
        });
        Self {
            layout: gpu.pipeline_layout("layers", &[Some(&uniform), Some(&pictures_layout)]),
            uniform,
            pictures,
            canvas: Canvas::new(gpu, size, TARGET),
        }
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
            ("OBJECT_SPACE", f64::from(u8::from(shading.is_object_space))),
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
        let constants = uniform::<LayerConstants>(gpu, "layer constants");
        Ok(LayerScene {
            pipeline,
            lights: gpu.bind_buffers("layers", &self.uniform, &[&constants]),
            constants,
            is_object_space: shading.is_object_space,
            vertices: gpu.upload("layer vertices", vertices, wgpu::BufferUsages::VERTEX)?,
            indices: gpu.upload(
                "layer indices",
                bytemuck::cast_slice(indices),
                wgpu::BufferUsages::INDEX,
            )?,
            count: u32::try_from(indices.len()).unwrap_or(u32::MAX),
        })
    }

    /// Sends the vertices anew, and where sun and clouds are; bytes that were sent.
    pub(crate) fn send(
        &self,
        scene: &LayerScene,
        lights: &Lights,
        vertices: &[LayerVertex],
    ) -> usize {
        let constants = LayerConstants::new(lights);
        let gpu = &self.canvas.gpu;
        gpu.write_buffer(&scene.vertices, 0, bytemuck::cast_slice(vertices));
        gpu.write_buffer(&scene.constants, 0, bytemuck::bytes_of(&constants));
        size_of_val(vertices) + size_of_val(&constants)
    }

    pub(crate) fn draw(&self, scene: &LayerScene) -> Result<Option<f64>, DeviceError> {
        let mut encoder = self.canvas.frame();
        self.canvas.record(&mut encoder, |pass| {
            pass.set_pipeline(&scene.pipeline);
            let pictures = &self.pictures[usize::from(scene.is_object_space)];
            for (at, bound) in (0..).zip([&scene.lights, pictures]) {
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
