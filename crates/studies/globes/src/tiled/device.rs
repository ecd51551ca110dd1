// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tiles and grid on wgpu. A texel's value is the number of its tile, from 1, times 65,536, plus its row times
//! 256, plus its column.

use super::mesh::{MapMesh, MapVertex, origin};
use super::options::{Drawing, Options, Seam};
use super::truth::{MAX_LEVEL, Texel, Tile, Truth, finest, focal_px};
use crate::canvas::{Canvas, view_constants, written};
use crate::list::Eye;
use bytemuck::{Pod, Zeroable};
use std::f64::consts::TAU;
use std::sync::Arc;
use terrafill_fill::{DeviceError, ViewConstants};
use terrafill_gpu::Gpu;
use terrafill_maps::{CAP_SPAN, TILE_TEXELS, max_latitude_rad};
use terrafill_scene::ImageSize;

const SIDE: u32 = 256;
const TARGET: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// What the shader writes where there is no tile.
const MISSING: u32 = u32::MAX;
/// Numbers of tiles, which 16 bits hold with 0 and all ones left out.
const MAX_TILES: usize = 65_534;

/// Twin of `MapConstants` in `globes/map.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct MapConstants {
    origin_u: f32,
    texel_scale: f32,
    end_sine: f32,
    cap_span: f32,
    seam: u32,
    by_fragment: u32,
    level: u32,
    tiles: u32,
    origins: [[u32; 4]; 24],
}

impl MapConstants {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "rounding to what the GPU reads is the purpose; a texel's number is below 2^31"
    )]
    fn new(eye: &Eye, options: &Options, tiles: usize, level: Option<u32>) -> Self {
        let origin = origin(&eye.body, &eye.camera);
        let mut origins = [[0; 4]; 24];
        for (level, place) in (0..=MAX_LEVEL).zip(&mut origins) {
            let side = TILE_TEXELS * f64::from(level).exp2();
            let [x, y] = [origin.u * side, origin.mercator_v * side];
            let rest = [x - x.floor(), y - y.floor()].map(|rest| (rest as f32).to_bits());
            // The eye may stand over a cap, where V' is beyond the map; two's complement keeps it.
            *place = [
                x.floor() as i32 as u32,
                y.floor() as i32 as u32,
                rest[0],
                rest[1],
            ];
        }
        Self {
            origin_u: origin.u as f32,
            texel_scale: (TAU * eye.body.equatorial_radius_m() * focal_px(eye) / TILE_TEXELS)
                as f32,
            end_sine: max_latitude_rad().sin() as f32,
            cap_span: CAP_SPAN as f32,
            seam: match options.seam {
                Seam::None | Seam::Split(_) => 0,
                Seam::Derivative => 1,
                Seam::Rotated => 2,
                Seam::Local => 3,
            },
            by_fragment: u32::from(options.by_fragment),
            level: level.unwrap_or(255),
            tiles: tiles as u32,
            origins,
        }
    }
}

/// What a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shown {
    /// No surface, or, where tiles are drawn one by one, none that has a tile.
    Nothing,
    /// A surface without a tile.
    Missing,
    Texel(Texel),
}

/// Tiles in one array.
pub(crate) struct TileSet {
    pub(crate) tiles: Vec<Tile>,
    texture: wgpu::Texture,
}

impl TileSet {
    pub(crate) const BYTES_PER_TILE: u64 = 4 * (SIDE * SIDE) as u64;

    /// # Errors
    /// [`DeviceError::OverCapacity`] for more tiles than the device has layers.
    pub(crate) fn new(gpu: &Gpu, tiles: Vec<Tile>) -> Result<Self, DeviceError> {
        let allowed = gpu.device.limits().max_texture_array_layers;
        let allowed = (allowed as usize).min(MAX_TILES);
        if tiles.len() > allowed {
            return Err(DeviceError::OverCapacity {
                what: "tiles of the map in one array".to_owned(),
                found: tiles.len() as u64,
                allowed: allowed as u64,
            });
        }
        let layers = u32::try_from(tiles.len()).unwrap_or(u32::MAX);
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("tiles of the map"),
            size: wgpu::Extent3d {
                width: SIDE,
                height: SIDE,
                depth_or_array_layers: layers,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R32Uint,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for layer in 0..layers {
            let texels: Vec<u32> = (0..SIDE * SIDE)
                .map(|texel| (layer + 1) << 16 | texel)
                .collect();
            gpu.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &texture,
                    mip_level: 0,
                    origin: wgpu::Origin3d {
                        x: 0,
                        y: 0,
                        z: layer,
                    },
                    aspect: wgpu::TextureAspect::All,
                },
                bytemuck::cast_slice(&texels),
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(4 * SIDE),
                    rows_per_image: None,
                },
                wgpu::Extent3d {
                    width: SIDE,
                    height: SIDE,
                    depth_or_array_layers: 1,
                },
            );
        }
        Ok(Self { tiles, texture })
    }

    /// What a value says.
    fn shown(&self, value: u32) -> Shown {
        match value {
            0 => Shown::Nothing,
            MISSING => Shown::Missing,
            value => {
                let tile = self.tiles.get((value >> 16) as usize - 1);
                tile.map_or(Shown::Missing, |&tile| {
                    Shown::Texel(Texel {
                        tile,
                        x: value & 255,
                        y: value >> 8 & 255,
                    })
                })
            }
        }
    }
}

/// Targets and pipelines.
pub(crate) struct MapTargets {
    canvas: Canvas,
    layouts: [wgpu::BindGroupLayout; 4],
    whole_map: wgpu::RenderPipeline,
    one_tile: wgpu::RenderPipeline,
}

/// One way, ready to draw.
pub(crate) struct MapScene {
    bind_groups: [wgpu::BindGroup; 2],
    view: wgpu::Buffer,
    map: wgpu::Buffer,
    vertices: wgpu::Buffer,
    capacity: u64,
    count: u32,
    /// Of all tiles, or one a draw.
    texels: Vec<wgpu::BindGroup>,
    drawing: Drawing,
    pub(crate) set: TileSet,
    level: Option<u32>,
}

fn buffer_entry(binding: u32, ty: wgpu::BufferBindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}

fn texture_entry(view_dimension: wgpu::TextureViewDimension) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding: 0,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Uint,
            view_dimension,
            multisampled: false,
        },
        count: None,
    }
}

impl MapTargets {
    pub(crate) fn new(gpu: &Arc<Gpu>, size: ImageSize) -> Result<Self, DeviceError> {
        let uniform = wgpu::BufferBindingType::Uniform;
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let layouts = [
            vec![buffer_entry(0, uniform)],
            vec![buffer_entry(0, uniform), buffer_entry(1, storage)],
            vec![texture_entry(wgpu::TextureViewDimension::D2Array)],
            vec![
                texture_entry(wgpu::TextureViewDimension::D2),
                buffer_entry(1, uniform),
            ],
        ]
        .map(|entries| {
            gpu.device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                    label: Some("map"),
                    entries: &entries,
                })
        });
        let [view, map, array, tile] = &layouts;
        let whole = gpu.pipeline_layout("whole map", &[Some(view), Some(map), Some(array)]);
        let one = gpu.pipeline_layout("one tile", &[Some(view), Some(map), None, Some(tile)]);
        let canvas = Canvas::new(gpu, size, TARGET);
        Ok(Self {
            whole_map: pipeline(&canvas, &whole, "whole_map")?,
            one_tile: pipeline(&canvas, &one, "one_tile")?,
            canvas,
            layouts,
        })
    }

    /// Makes tiles and constants; vertices follow by [`MapTargets::send`].
    pub(crate) fn scene(
        &self,
        options: &Options,
        truths: &[Option<Truth>],
        tiles: Vec<Tile>,
    ) -> Result<MapScene, DeviceError> {
        let gpu = &self.canvas.gpu;
        let keys: Vec<[u32; 4]> = tiles.iter().map(|tile| tile.key()).collect();
        let set = TileSet::new(gpu, tiles)?;
        let uniform = wgpu::BufferUsages::UNIFORM;
        let view = written(
            gpu,
            "view constants",
            size_of::<ViewConstants>() as u64,
            uniform,
        );
        let map = written(
            gpu,
            "map constants",
            size_of::<MapConstants>() as u64,
            uniform,
        );
        let bytes = bytemuck::cast_slice(&keys);
        let list = gpu.upload("tiles", bytes, wgpu::BufferUsages::STORAGE)?;
        let [view_layout, map_layout, array_layout, tile_layout] = &self.layouts;
        let bind_groups = [
            gpu.bind_buffers("view", view_layout, &[&view]),
            gpu.bind_buffers("map", map_layout, &[&map, &list]),
        ];
        let bind = |layout, entries: &[wgpu::BindGroupEntry<'_>]| {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("texels"),
                layout,
                entries,
            })
        };
        let mut texels = Vec::new();
        match options.drawing {
            Drawing::Array => {
                let all = set.texture.create_view(&wgpu::TextureViewDescriptor {
                    dimension: Some(wgpu::TextureViewDimension::D2Array),
                    ..Default::default()
                });
                let resource = wgpu::BindingResource::TextureView(&all);
                texels.push(bind(
                    array_layout,
                    &[wgpu::BindGroupEntry {
                        binding: 0,
                        resource,
                    }],
                ));
            }
            Drawing::DrawEach => {
                for (layer, key) in (0..).zip(&keys) {
                    let one = set.texture.create_view(&wgpu::TextureViewDescriptor {
                        dimension: Some(wgpu::TextureViewDimension::D2),
                        base_array_layer: layer,
                        array_layer_count: Some(1),
                        ..Default::default()
                    });
                    let bytes = bytemuck::bytes_of(key);
                    let key = gpu.upload("tile", bytes, wgpu::BufferUsages::UNIFORM)?;
                    let entries = [
                        wgpu::BindGroupEntry {
                            binding: 0,
                            resource: wgpu::BindingResource::TextureView(&one),
                        },
                        wgpu::BindGroupEntry {
                            binding: 1,
                            resource: key.as_entire_binding(),
                        },
                    ];
                    texels.push(bind(tile_layout, &entries));
                }
            }
        }
        Ok(MapScene {
            bind_groups,
            view,
            map,
            vertices: vertex_buffer(gpu, 4),
            capacity: 4,
            count: 0,
            texels,
            drawing: options.drawing,
            set,
            level: options.one_level.then(|| finest(truths)),
        })
    }

    /// Hands a frame's vertices and constants to the device; bytes that were sent.
    pub(crate) fn send(
        &self,
        scene: &mut MapScene,
        eye: &Eye,
        options: &Options,
        mesh: &MapMesh,
    ) -> u64 {
        let gpu = &self.canvas.gpu;
        let view = view_constants(eye);
        let map = MapConstants::new(eye, options, scene.set.tiles.len(), scene.level);
        let bytes: &[u8] = bytemuck::cast_slice(&mesh.vertices);
        let needed = bytes.len() as u64;
        if needed > scene.capacity {
            scene.vertices = vertex_buffer(gpu, needed);
            scene.capacity = needed;
        }
        let all: [(&wgpu::Buffer, &[u8]); 3] = [
            (&scene.view, bytemuck::bytes_of(&view)),
            (&scene.map, bytemuck::bytes_of(&map)),
            (&scene.vertices, bytes),
        ];
        for (buffer, bytes) in all {
            gpu.write_buffer(buffer, 0, bytes);
        }
        scene.count = u32::try_from(mesh.vertices.len()).unwrap_or(u32::MAX);
        all.iter().map(|(_, bytes)| bytes.len() as u64).sum()
    }

    /// Draws, waits, and gives the GPU's time.
    pub(crate) fn draw(&self, scene: &MapScene) -> Result<Option<f64>, DeviceError> {
        let gpu = &self.canvas.gpu;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let (pipeline, group) = match scene.drawing {
            Drawing::Array => (&self.whole_map, 2),
            Drawing::DrawEach => (&self.one_tile, 3),
        };
        self.canvas.record(&mut encoder, |pass| {
            pass.set_pipeline(pipeline);
            for (at, bound) in (0..).zip(&scene.bind_groups) {
                pass.set_bind_group(at, bound, &[]);
            }
            pass.set_vertex_buffer(0, scene.vertices.slice(..));
            for texels in &scene.texels {
                pass.set_bind_group(group, texels, &[]);
                pass.draw(0..scene.count, 0..1);
            }
        });
        self.canvas.finish(encoder)
    }

    /// Draws of a frame.
    pub(crate) fn draws(scene: &MapScene) -> usize {
        scene.texels.len()
    }

    /// What each pixel shows.
    pub(crate) fn read(&self, scene: &MapScene) -> Result<Vec<Shown>, DeviceError> {
        let values: Vec<u32> = self.canvas.read()?;
        Ok(values
            .into_iter()
            .map(|value| scene.set.shown(value))
            .collect())
    }
}

fn vertex_buffer(gpu: &Gpu, size: u64) -> wgpu::Buffer {
    written(gpu, "map vertices", size, wgpu::BufferUsages::VERTEX)
}

fn pipeline(
    canvas: &Canvas,
    layout: &wgpu::PipelineLayout,
    entry_point: &str,
) -> Result<wgpu::RenderPipeline, DeviceError> {
    let module = canvas.gpu.shader("globes/map.wgsl")?;
    let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x2, 2 => Float32];
    let vertex = wgpu::VertexState {
        module: &module,
        entry_point: Some("vertex_main"),
        compilation_options: Default::default(),
        buffers: &[Some(wgpu::VertexBufferLayout {
            array_stride: size_of::<MapVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &attributes,
        })],
    };
    let fragment = (&module, entry_point);
    Ok(canvas.pipeline(entry_point, layout, vertex, fragment, Default::default()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_lie_as_the_shader_reads_them() {
        let layout = terrafill_shaders::struct_layout("globes/map.wgsl", "MapConstants");
        let members = layout.expect("a struct").members;
        let offset = |name: &str| {
            let mut members = members.iter();
            members
                .find(|member| member.0 == name)
                .map(|member| member.1)
        };
        for (name, expected) in [
            ("origin_u", std::mem::offset_of!(MapConstants, origin_u)),
            ("cap_span", std::mem::offset_of!(MapConstants, cap_span)),
            ("tiles", std::mem::offset_of!(MapConstants, tiles)),
            ("origins", std::mem::offset_of!(MapConstants, origins)),
        ] {
            assert_eq!(offset(name), u32::try_from(expected).ok(), "{name}");
        }
    }
}
