// SPDX-License-Identifier: MIT OR Apache-2.0
//! Texels of tiles on wgpu. One that holds its address has the number of its tile, from 1, times 65,536, plus its row
//! times 256, plus its column.

use super::options::Drawing;
use super::truth::{Texel, Tile};
use std::borrow::Cow;
use std::ops::Range;
use terrafill_contract::DeviceError;
use terrafill_globe_views::{texture, write_layers};
use terrafill_gpu::Gpu;

/// Texels along a side of a tile.
pub(crate) const SIDE: u32 = 256;
/// What the shader writes where there is no tile.
const MISSING: u32 = u32::MAX;
/// Numbers of tiles, which 16 bits hold with 0 and all ones left out.
const MAX_TILES: u64 = 65_534;

/// Formats of texels that hold their address, and of those that hold colours.
pub(crate) const ADDRESSES: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
pub(crate) const COLOURS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// What a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shown {
    /// No surface, or, where tiles are drawn one by one, none that has a tile.
    Nothing,
    /// A surface without a tile.
    Missing,
    Texel(Texel),
}

/// What tiles show.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Content {
    /// Their texels' own addresses.
    Addresses,
    /// Colours in sRGB bytes with alpha, 256 × 256 of each tile.
    Colours(Vec<Vec<u8>>),
}

/// Tiles, and their texels: in layers of one texture, or each in its own. A clone has the same textures.
#[derive(Clone)]
pub(crate) struct TileSet {
    pub(crate) tiles: Vec<Tile>,
    pub(crate) textures: Vec<wgpu::Texture>,
}

/// Refuses more tiles than the device has room for.
fn check_capacity(gpu: &Gpu, drawing: Drawing, found: usize) -> Result<(), DeviceError> {
    let limits = gpu.device.limits();
    let (what, allowed) = match drawing {
        Drawing::Array | Drawing::DrawEach | Drawing::Slots => (
            "tiles of the map in one array",
            limits.max_texture_array_layers,
        ),
        Drawing::Atlas => {
            let along = u64::from(limits.max_texture_dimension_2d / SIDE);
            let most = (along * along).min(MAX_TILES);
            return DeviceError::check_capacity("tiles of the map in an atlas", found as u64, most);
        }
        Drawing::Bindless => {
            let needed = wgpu::Features::TEXTURE_BINDING_ARRAY
                | wgpu::Features::SAMPLED_TEXTURE_AND_STORAGE_BUFFER_ARRAY_NON_UNIFORM_INDEXING;
            gpu.require(needed, "freely indexed arrays of textures")?;
            (
                "tiles of the map in an array of textures",
                limits
                    .max_binding_array_elements_per_shader_stage
                    .min(limits.max_sampled_textures_per_shader_stage),
            )
        }
    };
    DeviceError::check_capacity(what, found as u64, u64::from(allowed).min(MAX_TILES))
}

impl Content {
    fn format(&self) -> wgpu::TextureFormat {
        match self {
            Self::Addresses => ADDRESSES,
            Self::Colours(_) => COLOURS,
        }
    }

    /// Texels of a tile.
    fn texels(&self, tile: u32) -> Cow<'_, [u8]> {
        match self {
            Self::Addresses => {
                let addresses = (0..SIDE * SIDE).map(|texel| address(tile, texel));
                let addresses: Vec<u32> = addresses.collect();
                bytemuck::pod_collect_to_vec(&addresses).into()
            }
            Self::Colours(tiles) => tiles[tile as usize].as_slice().into(),
        }
    }
}

/// Tiles along a side of an atlas.
fn atlas_side(tiles: u32) -> u32 {
    let along = tiles.isqrt();
    along + u32::from(along * along < tiles)
}

/// One picture with all tiles, row by row.
fn of_atlas(gpu: &Gpu, content: &Content, count: u32) -> wgpu::Texture {
    let along = atlas_side(count);
    let texture = texture(
        gpu,
        "atlas of the map",
        [SIDE * along, SIDE * along, 1],
        content.format(),
    );
    for tile in 0..count {
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d {
                    x: SIDE * (tile % along),
                    y: SIDE * (tile / along),
                    z: 0,
                },
                ..texture.as_image_copy()
            },
            &content.texels(tile),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * SIDE),
                rows_per_image: Some(SIDE),
            },
            wgpu::Extent3d {
                width: SIDE,
                height: SIDE,
                depth_or_array_layers: 1,
            },
        );
    }
    texture
}

/// - `layers`: whose number each tile has
fn of_layers(gpu: &Gpu, content: &Content, layers: Range<u32>) -> wgpu::Texture {
    let size = [SIDE, SIDE, layers.end - layers.start];
    let texture = texture(gpu, "tiles of the map", size, content.format());
    for (z, layer) in (0..).zip(layers) {
        write_layers(gpu, &texture, z, &content.texels(layer));
    }
    texture
}

impl TileSet {
    pub(crate) const BYTES_PER_TILE: u64 = 4 * (SIDE * SIDE) as u64;

    /// # Errors
    /// [`DeviceError::OverCapacity`] for more tiles than the device has room for, and
    /// [`DeviceError::Unsupported`] where it has no arrays of textures.
    pub(crate) fn new(
        gpu: &Gpu,
        tiles: Vec<Tile>,
        content: &Content,
        drawing: Drawing,
    ) -> Result<Self, DeviceError> {
        check_capacity(gpu, drawing, tiles.len())?;
        let count = u32::try_from(tiles.len()).unwrap_or(u32::MAX);
        let textures = match drawing {
            Drawing::Array | Drawing::DrawEach | Drawing::Slots => {
                vec![of_layers(gpu, content, 0..count)]
            }
            Drawing::Atlas => vec![of_atlas(gpu, content, count)],
            Drawing::Bindless => (0..count)
                .map(|tile| of_layers(gpu, content, tile..tile + 1))
                .collect(),
        };
        Ok(Self { tiles, textures })
    }

    /// Layers that tiles come into later.
    ///
    /// # Errors
    /// As [`TileSet::new`].
    pub(crate) fn empty(gpu: &Gpu, count: u32, content: &Content) -> Result<Self, DeviceError> {
        check_capacity(gpu, Drawing::Slots, count as usize)?;
        let size = [SIDE, SIDE, count];
        Ok(Self {
            tiles: Vec::new(),
            textures: vec![texture(gpu, "slots of tiles", size, content.format())],
        })
    }

    /// A view of one texture's layers, of all or of a single one.
    pub(crate) fn view(&self, number: usize, layer: Option<u32>) -> wgpu::TextureView {
        self.textures[number].create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(match layer {
                None => wgpu::TextureViewDimension::D2Array,
                Some(_) => wgpu::TextureViewDimension::D2,
            }),
            base_array_layer: layer.unwrap_or(0),
            array_layer_count: layer.map(|_| 1),
            ..Default::default()
        })
    }
}

/// What a value says of these tiles.
pub(crate) fn shown(tiles: &[Tile], value: u32) -> Shown {
    match value {
        0 => Shown::Nothing,
        MISSING => Shown::Missing,
        value => {
            let number = (value >> 16).checked_sub(1);
            let tile = number.and_then(|number| tiles.get(number as usize));
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

/// What a tile's texel holds that has its own address.
pub(crate) fn address(tile: u32, texel: u32) -> u32 {
    (tile + 1) << 16 | texel
}
