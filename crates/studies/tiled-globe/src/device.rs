// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tiles over a grid on wgpu.

use super::mesh::{MapMesh, origin};
use super::options::{Drawing, Options, Seam};
use super::tile_set::{Content, TileSet};
use super::truth::{MAX_LEVEL, Tile};
use bytemuck::{Pod, Zeroable};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::num::NonZeroU32;
use std::sync::Arc;
use terrafill_contract::{DeviceError, ViewConstants};
use terrafill_globe_views::{
    Canvas, Eye, Stages, uniform, vertices, view_constants, write_layers, written,
};
use terrafill_gpu::Gpu;
use terrafill_maps::{CAP_SPAN, TILE_TEXELS, max_latitude_rad};
use terrafill_scene::ImageSize;

const MAP: &str = "globes/map.wgsl";
const BINDLESS: &str = "globes/map_bindless.wgsl";

/// Twin of `MapConstants` in `globes/map.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct MapConstants {
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
        reason = "rounding to what the GPU reads is the purpose; a texel's number is below 2^31"
    )]
    pub(crate) fn new(eye: &Eye, options: &Options, tiles: usize, level: Option<u32>) -> Self {
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
            texel_scale: (TAU * eye.body.equatorial_radius_m() * eye.focal_px() / TILE_TEXELS)
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

/// Targets, and pipelines that were made for them.
pub(crate) struct MapTargets {
    canvas: Canvas,
    /// Of the view, the map and its tiles.
    layout: wgpu::BindGroupLayout,
    pipelines: BTreeMap<(Drawing, bool), wgpu::RenderPipeline>,
    /// The last set of addresses in layers: cases of a view mostly have the same tiles, and so the same texture.
    layered: Option<TileSet>,
}

/// One way, ready to draw.
pub(crate) struct MapScene {
    pipeline: wgpu::RenderPipeline,
    bind_group: wgpu::BindGroup,
    view: wgpu::Buffer,
    map: wgpu::Buffer,
    /// Keys of the tiles, sorted.
    tiles: wgpu::Buffer,
    vertices: wgpu::Buffer,
    count: u32,
    /// Where the texels are bound.
    group: u32,
    /// One a draw: of all tiles, or of one.
    pub(crate) texels: Vec<wgpu::BindGroup>,
    pub(crate) set: TileSet,
    level: Option<u32>,
}

/// Comes after all tiles, and is none.
const NO_TILE: [u32; 4] = [u32::MAX; 4];

/// As the shader searches them.
pub(crate) fn keys<'t>(tiles: impl IntoIterator<Item = &'t Tile>) -> Vec<[u32; 4]> {
    tiles.into_iter().map(|tile| tile.key()).collect()
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

/// What the shader reads texels by.
///
/// - `count`: of tiles
fn texel_entries(
    drawing: Drawing,
    content: &Content,
    count: usize,
) -> Vec<wgpu::BindGroupLayoutEntry> {
    let is_picture = matches!(content, Content::Colours(_));
    let sample_type = if !is_picture {
        wgpu::TextureSampleType::Uint
    } else {
        wgpu::TextureSampleType::Float { filterable: false }
    };
    let view_dimension = match drawing {
        Drawing::Array | Drawing::Slots => wgpu::TextureViewDimension::D2Array,
        Drawing::DrawEach | Drawing::Atlas | Drawing::Bindless => wgpu::TextureViewDimension::D2,
    };
    let count = match drawing {
        Drawing::Bindless => NonZeroU32::new(u32::try_from(count).unwrap_or(u32::MAX)),
        Drawing::Array | Drawing::Atlas | Drawing::DrawEach | Drawing::Slots => None,
    };
    let mut entries = vec![wgpu::BindGroupLayoutEntry {
        binding: u32::from(is_picture),
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type,
            view_dimension,
            multisampled: false,
        },
        count,
    }];
    if drawing == Drawing::DrawEach {
        entries.push(buffer_entry(1, wgpu::BufferBindingType::Uniform));
    }
    entries
}

impl MapTargets {
    /// - `format`: of the texels that are shown
    pub(crate) fn new(gpu: &Arc<Gpu>, size: ImageSize, format: wgpu::TextureFormat) -> Self {
        let uniform = wgpu::BufferBindingType::Uniform;
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let stages = wgpu::ShaderStages::VERTEX_FRAGMENT;
        Self {
            canvas: Canvas::new(gpu, size, format),
            layout: gpu.buffer_layout("map", stages, &[uniform, uniform, storage]),
            pipelines: BTreeMap::new(),
            layered: None,
        }
    }

    /// Kept, but for arrays of textures, whose layouts say how many there are.
    fn pipeline(
        &mut self,
        drawing: Drawing,
        content: &Content,
        texels: &wgpu::BindGroupLayout,
    ) -> Result<wgpu::RenderPipeline, DeviceError> {
        let is_picture = matches!(content, Content::Colours(_));
        let key = (drawing, is_picture);
        if let Some(known) = self.pipelines.get(&key) {
            return Ok(known.clone());
        }
        let gpu = &self.canvas.gpu;
        let (path, entry_point, layouts) = match (drawing, is_picture) {
            (Drawing::Array, false) => (MAP, "whole_map", vec![Some(texels)]),
            (Drawing::Array, true) => (MAP, "whole_picture", vec![Some(texels)]),
            (Drawing::Slots, false) => (MAP, "nearest_map", vec![Some(texels)]),
            (Drawing::Slots, true) => (MAP, "nearest_picture", vec![Some(texels)]),
            (Drawing::Atlas, _) => (MAP, "atlas_map", vec![None, None, Some(texels)]),
            (Drawing::DrawEach, _) => (MAP, "one_tile", vec![None, Some(texels)]),
            (Drawing::Bindless, _) => (BINDLESS, "every_tile", vec![Some(texels)]),
        };
        let mut all = vec![Some(&self.layout), None];
        all.extend(layouts);
        let layout = gpu.pipeline_layout(entry_point, &all);
        let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x2, 2 => Float32];
        let stages = Stages {
            module: &gpu.shader(path)?,
            entry_points: ["vertex_main", entry_point],
            constants: &[],
            buffers: &[vertices(&attributes)],
        };
        let pipeline = self.canvas.pipeline(entry_point, &layout, &stages);
        if drawing != Drawing::Bindless {
            self.pipelines.insert(key, pipeline.clone());
        }
        Ok(pipeline)
    }

    /// Makes tiles and constants; vertices follow by [`MapTargets::send`].
    ///
    /// - `level`: of the whole frame, where it has one
    ///
    /// # Errors
    /// As [`TileSet::new`].
    pub(crate) fn scene(
        &mut self,
        options: &Options,
        level: Option<u32>,
        (tiles, content): (Vec<Tile>, Content),
    ) -> Result<MapScene, DeviceError> {
        let keys = keys(&tiles);
        let is_layered = matches!(options.drawing, Drawing::Array | Drawing::DrawEach);
        let is_shared = is_layered && content == Content::Addresses;
        let known = self
            .layered
            .take_if(|known| is_shared && known.tiles == tiles);
        let set = match known {
            Some(known) => known,
            None => TileSet::new(&self.canvas.gpu, tiles, &content, options.drawing)?,
        };
        if is_shared {
            self.layered = Some(set.clone());
        }
        self.scene_of(options, level, &content, (set, &keys))
    }

    /// Slots for tiles that come and go, of which none is there yet.
    ///
    /// # Errors
    /// As [`TileSet::new`].
    pub(crate) fn slots(
        &mut self,
        options: &Options,
        count: u32,
        content: &Content,
    ) -> Result<MapScene, DeviceError> {
        let set = TileSet::empty(&self.canvas.gpu, count, content)?;
        self.scene_of(
            options,
            None,
            content,
            (set, &vec![NO_TILE; count as usize]),
        )
    }

    fn scene_of(
        &mut self,
        options: &Options,
        level: Option<u32>,
        content: &Content,
        (set, keys): (TileSet, &[[u32; 4]]),
    ) -> Result<MapScene, DeviceError> {
        let gpu = Arc::clone(&self.canvas.gpu);
        let entries = texel_entries(options.drawing, content, keys.len());
        let layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("texels"),
                entries: &entries,
            });
        let pipeline = self.pipeline(options.drawing, content, &layout)?;
        let view = uniform::<ViewConstants>(&gpu, "view constants");
        let map = uniform::<MapConstants>(&gpu, "map constants");
        let bytes = bytemuck::cast_slice(keys);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let list = gpu.upload("tiles", bytes, usage)?;
        let bind_group = gpu.bind_buffers("map", &self.layout, &[&view, &map, &list]);
        Ok(MapScene {
            pipeline,
            bind_group,
            view,
            map,
            tiles: list,
            vertices: vertex_buffer(&gpu, 4),
            count: 0,
            group: match options.drawing {
                Drawing::Atlas => 4,
                Drawing::DrawEach => 3,
                Drawing::Array | Drawing::Bindless | Drawing::Slots => 2,
            },
            texels: texels(&gpu, &layout, &set, (options.drawing, entries[0].binding))?,
            set,
            level,
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
        if bytes.len() as u64 > scene.vertices.size() {
            scene.vertices = vertex_buffer(gpu, bytes.len() as u64);
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

    /// Bytes that were written at the device's queue so far, by whoever wrote them.
    pub(crate) fn written_bytes(&self) -> u64 {
        self.canvas.gpu.work_done().upload_bytes
    }

    /// Hands a frame's tiles to the device, no more than the scene has; bytes that were sent.
    pub(crate) fn send_tiles<'t>(
        &self,
        scene: &MapScene,
        tiles: impl IntoIterator<Item = &'t Tile>,
    ) -> u64 {
        let keys = keys(tiles);
        let most = scene.set.tiles.len().min(keys.len());
        let bytes: &[u8] = bytemuck::cast_slice(&keys[..most]);
        self.canvas.gpu.write_buffer(&scene.tiles, 0, bytes);
        bytes.len() as u64
    }

    /// Hands over which tiles are in which slots; bytes that were sent.
    ///
    /// - `held`: sorted by tile
    pub(crate) fn send_slots(
        &self,
        scene: &MapScene,
        held: impl Iterator<Item = (Tile, usize)>,
    ) -> u64 {
        let key = |(tile, slot): (Tile, usize)| {
            let [level, row, column, _] = tile.key();
            [level, row, column, u32::try_from(slot).unwrap_or(u32::MAX)]
        };
        let mut keys: Vec<[u32; 4]> = held.map(key).collect();
        let all = scene.set.textures[0].depth_or_array_layers();
        keys.resize(all as usize, NO_TILE);
        let bytes: &[u8] = bytemuck::cast_slice(&keys);
        self.canvas.gpu.write_buffer(&scene.tiles, 0, bytes);
        bytes.len() as u64
    }

    /// Hands over a tile's texels; bytes that were sent.
    pub(crate) fn send_texels(&self, scene: &MapScene, slot: usize, texels: &[u8]) -> u64 {
        let slot = u32::try_from(slot).unwrap_or(u32::MAX);
        write_layers(&self.canvas.gpu, &scene.set.textures[0], slot, texels);
        texels.len() as u64
    }

    /// Draws, waits, and gives the GPU's time.
    pub(crate) fn draw(&self, scene: &MapScene) -> Result<Option<f64>, DeviceError> {
        let mut encoder = self.canvas.frame();
        self.canvas.record(&mut encoder, |pass| {
            pass.set_pipeline(&scene.pipeline);
            pass.set_bind_group(0, &scene.bind_group, &[]);
            pass.set_vertex_buffer(0, scene.vertices.slice(..));
            for texels in &scene.texels {
                pass.set_bind_group(scene.group, texels, &[]);
                pass.draw(0..scene.count, 0..1);
            }
        });
        self.canvas.finish(encoder)
    }

    /// Addresses of the texels that pixels show ([`shown`](super::tile_set::shown)), where tiles hold them.
    pub(crate) fn addresses(&self) -> Result<Vec<u32>, DeviceError> {
        self.canvas.read()
    }

    /// Colours in rows; 0 where no surface is.
    pub(crate) fn colours(&self) -> Result<Vec<[u8; 4]>, DeviceError> {
        self.canvas.read()
    }
}

fn entry(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}

/// Bind groups of a draw's texels, one or one for each tile.
fn texels(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    set: &TileSet,
    (drawing, binding): (Drawing, u32),
) -> Result<Vec<wgpu::BindGroup>, DeviceError> {
    let bind = |entries: &[wgpu::BindGroupEntry<'_>]| {
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("texels"),
            layout,
            entries,
        })
    };
    match drawing {
        Drawing::Array | Drawing::Slots => {
            let all = set.view(0, None);
            let resource = wgpu::BindingResource::TextureView(&all);
            Ok(vec![bind(&[entry(binding, resource)])])
        }
        Drawing::Atlas => {
            let all = set.view(0, Some(0));
            let resource = wgpu::BindingResource::TextureView(&all);
            Ok(vec![bind(&[entry(binding, resource)])])
        }
        Drawing::Bindless => {
            let views: Vec<wgpu::TextureView> = (0..set.textures.len())
                .map(|number| set.view(number, Some(0)))
                .collect();
            let views: Vec<&wgpu::TextureView> = views.iter().collect();
            let resource = wgpu::BindingResource::TextureViewArray(&views);
            Ok(vec![bind(&[entry(binding, resource)])])
        }
        Drawing::DrawEach => {
            let one = |(layer, tile): (u32, &Tile)| {
                let view = set.view(0, Some(layer));
                let key = tile.key();
                let bytes = bytemuck::bytes_of(&key);
                let key = gpu.upload("tile", bytes, wgpu::BufferUsages::UNIFORM)?;
                let resource = wgpu::BindingResource::TextureView(&view);
                Ok(bind(&[
                    entry(binding, resource),
                    entry(1, key.as_entire_binding()),
                ]))
            };
            (0..).zip(&set.tiles).map(one).collect()
        }
    }
}

fn vertex_buffer(gpu: &Gpu, size: u64) -> wgpu::Buffer {
    written(gpu, "map vertices", size, wgpu::BufferUsages::VERTEX)
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
