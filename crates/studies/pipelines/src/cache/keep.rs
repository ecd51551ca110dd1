// SPDX-License-Identifier: MIT OR Apache-2.0
//! What may keep the blocks, and how a texel of them is found.

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
    /// A texture a block, bound in turn.
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
    pub(crate) const ALL: [Self; 10] = [
        Self::Array,
        Self::ArraySampled,
        Self::ArrayByWorld,
        Self::Atlas,
        Self::AtlasSampled,
        Self::Rebound,
        Self::Volume,
        Self::VolumeSampled,
        Self::Bindless,
        Self::Buffer,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Array => "array",
            Self::ArraySampled => "array-sampled",
            Self::ArrayByWorld => "array-by-world",
            Self::Atlas => "atlas",
            Self::AtlasSampled => "atlas-sampled",
            Self::Rebound => "rebound",
            Self::Volume => "volume",
            Self::VolumeSampled => "volume-sampled",
            Self::Bindless => "bindless",
            Self::Buffer => "buffer",
        }
    }

    /// WGSL and its entry point.
    pub(crate) fn shader(self) -> (&'static str, &'static str) {
        match self {
            Self::Array => ("pipelines/cache_array.wgsl", "loaded"),
            Self::ArraySampled => ("pipelines/cache_array.wgsl", "sampled"),
            Self::ArrayByWorld => ("pipelines/cache_array.wgsl", "by_world"),
            Self::Atlas => ("pipelines/cache_atlas.wgsl", "loaded"),
            Self::AtlasSampled => ("pipelines/cache_atlas.wgsl", "sampled"),
            Self::Rebound => ("pipelines/cache_block.wgsl", "loaded"),
            Self::Volume => ("pipelines/cache_volume.wgsl", "loaded"),
            Self::VolumeSampled => ("pipelines/cache_volume.wgsl", "sampled"),
            Self::Bindless => ("pipelines/cache_bindless.wgsl", "loaded"),
            Self::Buffer => ("pipelines/cache_buffer.wgsl", "loaded"),
        }
    }

    /// Whether places pass through a rounding that may choose another texel, which is what is asked of them.
    pub(crate) fn rounds(self) -> bool {
        matches!(
            self,
            Self::ArraySampled | Self::ArrayByWorld | Self::AtlasSampled | Self::VolumeSampled
        )
    }
}
