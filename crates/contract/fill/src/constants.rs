// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rust twins of the constants in `shaders/shared/`; tests hold the layouts together.

use crate::{Colours, FillInput, FixedPoint, PositionFormat, SurfaceView, two_float};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use terrafill_core::VolumeHeights;
use terrafill_scene::PlannedRegion;

/// Twin of `ViewConstants` in `shared/view.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct ViewConstants {
    /// Columns of the rotation, each padded to 16 bytes.
    pub view_from_ecef: [[f32; 4]; 3],
    /// Eye, ECEF metres, rounded: the high part of two floats.
    pub eye_ecef: [f32; 3],
    /// Near plane, metres.
    pub near_m: f32,
    /// `(1, 1, a²/b²)`.
    pub normal_scale: [f32; 3],
    /// `1 / (tan(fov/2) · aspect)`.
    pub clip_scale_x: f32,
    /// `1 / tan(fov/2)`.
    pub clip_scale_y: f32,
    /// Height of a pixel at distance 1, `2 tan(fov/2) / rows`.
    pub pixel_per_distance: f32,
    /// Uniform blocks are multiples of 16 bytes.
    pub padding: [f32; 2],
}

impl ViewConstants {
    /// Constants of a view's camera and body.
    #[must_use]
    #[allow(
        clippy::cast_possible_truncation,
        reason = "rounding to what the GPU reads is the purpose"
    )]
    pub fn new(view: &SurfaceView<'_>) -> Self {
        let camera = view.camera;
        let column = |i: usize| {
            let c = camera.view_from_ecef.col(i).as_vec3();
            [c.x, c.y, c.z, 0.0]
        };
        let body = view.body;
        let flattening_squared = (body.equatorial_radius_m() / body.polar_radius_m()).powi(2);
        let clip_scale_y = camera.tan_half_fov().recip();
        Self {
            view_from_ecef: [column(0), column(1), column(2)],
            eye_ecef: camera.eye_ecef.as_vec3().to_array(),
            near_m: camera.near_m as f32,
            normal_scale: [1.0, 1.0, flattening_squared as f32],
            clip_scale_x: (clip_scale_y / view.size.aspect()) as f32,
            clip_scale_y: clip_scale_y as f32,
            pixel_per_distance: (2.0 * camera.tan_half_fov() / f64::from(view.size.height)) as f32,
            padding: [0.0; 2],
        }
    }
}

/// Twin of `VolumeConstants` in `shared/region.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct VolumeConstants {
    /// Eye from the volume's origin, in units of `scale_m`.
    pub eye: [i32; 3],
    /// Bits dropped from stored positions.
    pub shift: u32,
    /// What is left of the eye below one unit of `scale_m`, metres. For local f32 the whole eye from
    /// the volume's origin, for f32 ECEF and two floats what the view's eye rounded away.
    pub eye_remainder_m: [f32; 3],
    /// `unit_m · 2^shift`.
    pub scale_m: f32,
    /// The volume's origin, ECEF metres, rounded; only normals are made from it.
    pub origin_ecef_m: [f32; 3],
    /// Length of one step of a stored position, metres.
    pub unit_m: f32,
    /// Height of the top cap above the ellipsoid, metres.
    pub top_m: f32,
    /// Height of the bottom cap above the ellipsoid, metres.
    pub bottom_m: f32,
    /// First vertex of the volume, in vertices.
    pub first_vertex: u32,
    /// First index of its triangles, in indices.
    pub first_triangle_index: u32,
    /// First entry of its loops, in indices.
    pub first_loop_index: u32,
    /// Cap triangles.
    pub triangle_count: u32,
    /// 16 or 32.
    pub index_bits: u32,
    /// To the next multiple of 16 bytes.
    pub padding: u32,
    /// What the colour pass writes.
    pub colour: [f32; 4],
}

/// Where a mesh lies in a scene's buffers, as far as shaders need to know.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumePlace {
    /// What its positions count from, and in.
    pub fixed: FixedPoint,
    /// In stored vertices.
    pub first_vertex: u32,
    /// In indices of its width.
    pub first_triangle_index: u32,
    /// As above.
    pub first_loop_index: u32,
    /// Cap triangles.
    pub triangle_count: u32,
    /// Indices have 16 bits.
    pub has_short_indices: bool,
}

impl VolumeConstants {
    /// Constants of one volume.
    ///
    /// - `heights`: of its caps
    #[must_use]
    #[allow(
        clippy::cast_possible_truncation,
        reason = "rounding to what the GPU reads is the purpose"
    )]
    pub fn new(
        eye_ecef: DVec3,
        place: &VolumePlace,
        heights: VolumeHeights,
        positions: PositionFormat,
        colour: [f32; 4],
    ) -> Self {
        let fixed = place.fixed;
        let eye = fixed.eye(eye_ecef);
        let remainder_m = match positions {
            PositionFormat::Fixed => eye.remainder_m,
            PositionFormat::LocalF32 => eye_ecef - fixed.origin_ecef,
            // The view has the eye in f32; this is what that rounded away.
            PositionFormat::EcefF32 | PositionFormat::TwoFloat => two_float(eye_ecef)[1].as_dvec3(),
        };
        Self {
            eye: eye.eye.to_array(),
            shift: eye.shift,
            eye_remainder_m: remainder_m.as_vec3().to_array(),
            scale_m: (fixed.unit_m * f64::from(eye.shift).exp2()) as f32,
            origin_ecef_m: fixed.origin_ecef.as_vec3().to_array(),
            unit_m: fixed.unit_m as f32,
            top_m: heights.top_m as f32,
            bottom_m: heights.bottom_m as f32,
            first_vertex: place.first_vertex,
            first_triangle_index: place.first_triangle_index,
            first_loop_index: place.first_loop_index,
            triangle_count: place.triangle_count,
            index_bits: if place.has_short_indices { 16 } else { 32 },
            padding: 0,
            colour,
        }
    }

    /// Bytes of the constants of all that `input` plans, in its order; `place_of` tells where a mesh
    /// lies. One element of zeros where nothing is planned: a storage binding may not be empty.
    #[must_use]
    pub fn bytes_of_all(
        input: &FillInput,
        positions: PositionFormat,
        colours: Colours,
        place_of: impl Fn(usize) -> VolumePlace,
    ) -> Vec<u8> {
        let eye = input.camera.eye_ecef;
        let of_region = |planned: &PlannedRegion| {
            let (place, colour) = (place_of(planned.mesh), colours.of(planned.region));
            Self::new(eye, &place, planned.heights, positions, colour)
        };
        let constants: Vec<Self> = input.plan.regions.iter().map(of_region).collect();
        if constants.is_empty() {
            return vec![0; size_of::<Self>()];
        }
        bytemuck::cast_slice(&constants).to_vec()
    }

    /// Bytes of the constants that `input` asks for, without what only fills a binding.
    #[must_use]
    pub fn byte_count(input: &FillInput) -> u64 {
        (input.plan.regions.len() * size_of::<Self>()) as u64
    }
}
