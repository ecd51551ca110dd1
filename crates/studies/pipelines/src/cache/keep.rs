// SPDX-License-Identifier: MIT OR Apache-2.0
//! What may keep the blocks, and how a texel of them is found.

use super::queries::{Blocks, SIDE};
use crate::draws::Times;
use terrafill_contract::DeviceError;

/// What keeps blocks, and how it is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Keep {
    /// Layers of one array texture, texels loaded by their number.
    Array,
    /// The same through a sampler of nearest texels, as published.
    ArraySampled,
    /// The same with the layer computed from one number for the whole ground.
    ArrayByWorld,
    /// One texture with all blocks side by side.
    Atlas,
    /// The same through a sampler.
    AtlasSampled,
    /// A texture a block, bound for its own draw.
    Rebound,
    /// Slices of a volume texture.
    Volume,
    /// The same through a sampler.
    VolumeSampled,
    /// An array of textures, one a block.
    Bindless,
    /// One buffer.
    Buffer,
}

impl Keep {
    /// Those in which texels are looked up by compute.
    pub(crate) const LOOKED_UP: [Self; 9] = [
        Self::Array,
        Self::ArraySampled,
        Self::ArrayByWorld,
        Self::Atlas,
        Self::AtlasSampled,
        Self::Volume,
        Self::VolumeSampled,
        Self::Bindless,
        Self::Buffer,
    ];
    /// Those from which ground is drawn.
    pub(crate) const DRAWN: [Self; 5] = [
        Self::Array,
        Self::Atlas,
        Self::Volume,
        Self::Rebound,
        Self::Bindless,
    ];

    /// Its name, its WGSL with the entry point, and where the blocks lie.
    fn row(self) -> (&'static str, [&'static str; 2], Store) {
        const ARRAY: &str = "pipelines/cache_array.wgsl";
        const ATLAS: &str = "pipelines/cache_atlas.wgsl";
        const EACH: &str = "pipelines/blocks_each.wgsl";
        const VOLUME: &str = "pipelines/cache_volume.wgsl";
        const BINDLESS: &str = "pipelines/cache_bindless.wgsl";
        const BUFFER: &str = "pipelines/cache_buffer.wgsl";
        match self {
            Self::Array => ("array", [ARRAY, "loaded"], Store::Layers),
            Self::ArraySampled => ("array-sampled", [ARRAY, "sampled"], Store::Layers),
            Self::ArrayByWorld => ("array-by-world", [ARRAY, "by_world"], Store::Layers),
            Self::Atlas => ("atlas", [ATLAS, "loaded"], Store::SideBySide),
            Self::AtlasSampled => ("atlas-sampled", [ATLAS, "sampled"], Store::SideBySide),
            Self::Rebound => ("rebound", [EACH, "vertex_main"], Store::Each),
            Self::Volume => ("volume", [VOLUME, "loaded"], Store::Slices),
            Self::VolumeSampled => ("volume-sampled", [VOLUME, "sampled"], Store::Slices),
            Self::Bindless => ("bindless", [BINDLESS, "loaded"], Store::Each),
            Self::Buffer => ("buffer", [BUFFER, "loaded"], Store::Buffer),
        }
    }

    pub(crate) fn name(self) -> &'static str {
        self.row().0
    }

    /// WGSL and its entry point.
    pub(crate) fn shader(self) -> [&'static str; 2] {
        self.row().1
    }

    pub(crate) fn store(self) -> Store {
        self.row().2
    }

    /// Whether places pass through a rounding that may choose another texel, which is what is asked of them.
    pub(crate) fn rounds(self) -> bool {
        matches!(
            self,
            Self::ArraySampled | Self::ArrayByWorld | Self::AtlasSampled | Self::VolumeSampled
        )
    }
}

/// Where blocks lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Store {
    /// In the layers of one texture.
    Layers,
    /// In one texture beside each other.
    SideBySide,
    /// In the slices of a volume texture.
    Slices,
    /// In a texture each.
    Each,
    /// In one buffer.
    Buffer,
}

impl Store {
    /// Where a block begins in the texture that holds it.
    pub(crate) fn first_texel(self, block: u32, blocks: Blocks) -> [u32; 3] {
        match self {
            Self::SideBySide => {
                let [x, y] = [block % blocks.across, block / blocks.across];
                [SIDE * x, SIDE * y, 0]
            }
            Self::Layers | Self::Slices => [0, 0, block],
            Self::Each | Self::Buffer => [0; 3],
        }
    }
}

/// Blocks kept in one way.
pub(super) trait Keeps {
    /// Looks everything up and waits.
    fn look_up(&self) -> Result<Times, DeviceError>;

    /// Writes a block and waits until the device has it.
    fn update(&self, block: u32, texels: &[f32]) -> Result<Times, DeviceError>;

    /// What was found last.
    fn read(&self) -> Result<Vec<f32>, DeviceError>;
}
