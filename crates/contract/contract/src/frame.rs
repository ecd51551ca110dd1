// SPDX-License-Identifier: MIT OR Apache-2.0
//! What comes out: the picture as region ids, what it cost in memory and work, and how long it took.

use crate::{NO_REGION, Picture, TextureCoordinates, ids_of};
use std::ops::Add;
use terrafill_scene::ImageSize;

/// A drawn frame.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Size of `ids`.
    pub size: ImageSize,
    /// Id per pixel, row 0 at the top.
    pub ids: Vec<u32>,
    /// Where the surface is: false where the pixel shows the sky.
    pub surface: Vec<bool>,
    /// Distances or positions that came out as NaN or ±∞ where the surface is.
    pub non_finite: u64,
    /// Work done; `None` for the reference, which draws nothing.
    pub counters: Option<Counters>,
    /// Where the texels came from; `None` of a plain fill.
    pub texture: Option<TextureCoordinates>,
}

impl Frame {
    /// What a picture drawn in [`crate::Colours::Ids`] shows.
    #[must_use]
    pub fn from_picture(picture: &Picture, counters: Counters) -> Self {
        let depths = picture.depth.iter();
        Self {
            size: picture.size,
            ids: ids_of(picture),
            surface: depths.clone().map(|&depth| depth > 0.0).collect(),
            non_finite: depths.filter(|depth| !depth.is_finite()).count() as u64,
            counters: Some(counters),
            texture: None,
        }
    }

    /// The same frame with the places its texels came from.
    #[must_use]
    pub fn textured(self, texture: TextureCoordinates) -> Self {
        Self {
            texture: Some(texture),
            ..self
        }
    }

    /// Pixels that belong to a region.
    #[must_use]
    pub fn filled_px(&self) -> u64 {
        self.ids.iter().filter(|&&id| id != NO_REGION).count() as u64
    }
}

/// Work of one frame's fill. Exact, so two runs on one driver must agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Draw calls.
    pub draws: u64,
    /// Vertices asked for: the sum of the draws' index or vertex counts.
    pub vertices: u64,
    /// Bytes uploaded for this frame after `prepare`.
    pub upload_bytes: u64,
    /// Pipeline statistics of the stencil pass, where the device counts them.
    pub vertex_shader_invocations: Option<u64>,
    /// Primitives that geometry shaders made, where there are such shaders.
    pub geometry_shader_primitives: Option<u64>,
    /// Primitives that reached clipping.
    pub clipper_invocations: Option<u64>,
    /// Primitives that left it.
    pub clipper_primitives_out: Option<u64>,
    /// Fragment shader invocations of the colour pass.
    pub fragment_shader_invocations: Option<u64>,
    /// Fragments of volumes that the stencil pass rasterises, whether or not the depth test lets
    /// them touch the stencil: counted in an extra frame that is never timed.
    pub stencil_fragments: Option<u64>,
    /// Buffers made for this frame's fill, by `prepare` or later; 0 in a steady state. What only
    /// measuring needs (queries, read-back) and what all backends share (the surface) is left out.
    pub buffer_creations: u64,
    /// Pipelines made for this frame's fill, as above.
    pub pipeline_creations: u64,
    /// Writes of the CPU into buffers for this frame's fill, as above.
    pub uploads: u64,
}

/// Bytes of one or more regions in one layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GeometryBytes {
    /// Positions and flags.
    pub vertex_bytes: u64,
    /// Indices.
    pub index_bytes: u64,
}

impl GeometryBytes {
    /// Both.
    #[must_use]
    pub fn total(self) -> u64 {
        self.vertex_bytes + self.index_bytes
    }
}

impl Add for GeometryBytes {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            vertex_bytes: self.vertex_bytes + other.vertex_bytes,
            index_bytes: self.index_bytes + other.index_bytes,
        }
    }
}

impl std::iter::Sum for GeometryBytes {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), Add::add)
    }
}

/// Bytes a backend holds for a frame, by purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MemoryUse {
    /// Buffers with positions and flags.
    pub vertex_bytes: u64,
    /// Index buffers, or the index lists that a pulling shader reads.
    pub index_bytes: u64,
    /// Per-region constants of the view.
    pub constant_bytes: u64,
    /// Textures that the fill draws into besides those that all backends have.
    pub target_bytes: u64,
    /// Pictures of a textured fill with all their levels, and tables that its routes read.
    pub texture_bytes: u64,
    /// What buffers have beyond what is written into them: they come in multiples of 4 bytes, and a
    /// binding is never empty.
    pub padding_bytes: u64,
    /// How many buffers hold the geometry and the constants.
    pub buffers: u64,
    /// Bytes handed to the device by `prepare`.
    pub upload_bytes: u64,
}

impl From<GeometryBytes> for MemoryUse {
    fn from(bytes: GeometryBytes) -> Self {
        Self {
            vertex_bytes: bytes.vertex_bytes,
            index_bytes: bytes.index_bytes,
            ..Self::default()
        }
    }
}

impl Add for MemoryUse {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            vertex_bytes: self.vertex_bytes + other.vertex_bytes,
            index_bytes: self.index_bytes + other.index_bytes,
            constant_bytes: self.constant_bytes + other.constant_bytes,
            target_bytes: self.target_bytes + other.target_bytes,
            texture_bytes: self.texture_bytes + other.texture_bytes,
            padding_bytes: self.padding_bytes + other.padding_bytes,
            buffers: self.buffers + other.buffers,
            upload_bytes: self.upload_bytes + other.upload_bytes,
        }
    }
}

impl MemoryUse {
    /// What the geometry costs: positions, flags and indices.
    #[must_use]
    pub fn geometry_bytes(&self) -> u64 {
        self.vertex_bytes + self.index_bytes
    }

    /// Everything that is held: of all buffers and textures.
    #[must_use]
    pub fn held_bytes(&self) -> u64 {
        self.geometry_bytes()
            + self.constant_bytes
            + self.target_bytes
            + self.texture_bytes
            + self.padding_bytes
    }
}

/// Times of one frame. An absent value was not measured, and the text says why.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameTimes {
    /// Surface pass, GPU clock.
    pub surface_gpu_ms: Option<f64>,
    /// Stencil pass, GPU clock; absent when stencil and colour alternate region by region.
    pub stencil_gpu_ms: Option<f64>,
    /// Colour pass, GPU clock; absent as above.
    pub colour_gpu_ms: Option<f64>,
    /// The whole fill, GPU clock.
    pub fill_gpu_ms: Option<f64>,
    /// CPU time of the whole process from recording the fill until the device is done with it. On
    /// a software driver this contains the driver's worker threads, and is the steadier clock.
    pub fill_cpu_ms: f64,
    /// Wall clock over the same span.
    pub fill_wall_ms: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_says_where_the_surface_is_and_what_is_no_depth() {
        let picture = Picture {
            size: ImageSize::new(4, 1),
            rgba: [[0; 4], [5, 0, 0, 255], [9, 9, 9, 0], [1, 1, 0, 255]].concat(),
            depth: vec![0.0, 0.5, f32::NAN, f32::INFINITY],
        };
        let frame = Frame::from_picture(&picture, Counters::default());
        assert_eq!(frame.ids, [0, 5, 0, 257]);
        assert_eq!(frame.surface, [false, true, false, true]);
        assert_eq!((frame.non_finite, frame.filled_px()), (2, 2));
        assert_eq!(frame.counters, Some(Counters::default()));
    }

    #[test]
    fn bytes_add_up_each_with_its_own() {
        let bytes = |vertex_bytes, index_bytes| GeometryBytes {
            vertex_bytes,
            index_bytes,
        };
        let sum: GeometryBytes = [bytes(1, 10), bytes(2, 20)].into_iter().sum();
        assert_eq!((sum, sum.total()), (bytes(3, 30), 33));
        assert_ne!(sum, bytes(30, 3));
    }
}
