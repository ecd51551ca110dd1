// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the device decides by which regions to draw.
//!
//! The CPU makes per-view constants in f64 and rounds them; the tests run in
//! `compute/cull.wgsl`.

use crate::expansion::OutputSlice;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use terrafill_contract::FillInput;
use terrafill_core::nearest_f32;
use terrafill_plan::PlannedRegion;

/// Twin of `CullRegion` in `compute/cull.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct CullRegion {
    center_m: [f32; 3],
    first_index: u32,
    half_edge_0_m: [f32; 3],
    bottom_count: u32,
    half_edge_1_m: [f32; 3],
    upper_count: u32,
    half_edge_2_m: [f32; 3],
    base_vertex: i32,
}

impl CullRegion {
    /// The box that holds a planned region's volume, and where its indices and corners begin.
    pub(crate) fn new(
        input: &FillInput,
        planned: &PlannedRegion,
        output: OutputSlice,
        base_vertex: i32,
    ) -> Self {
        let region = &input.scene.bounds[planned.mesh];
        // Every vertex of this view's volume is at most this far from one of the bounded volume.
        let grown_m = (planned.heights.top_m - region.heights.top_m)
            .max(region.heights.bottom_m - planned.heights.bottom_m)
            .max(0.0);
        let half = region.bounds.half_extents_m + DVec3::splat(grown_m);
        let axes = region.bounds.axes;
        let f32s = |v: DVec3| v.as_vec3().to_array();
        Self {
            center_m: f32s(region.bounds.center_ecef - input.camera.eye_ecef),
            first_index: output.first_index,
            half_edge_0_m: f32s(axes.x_axis * half.x),
            bottom_count: output.bottom_count,
            half_edge_1_m: f32s(axes.y_axis * half.y),
            upper_count: output.upper_count,
            half_edge_2_m: f32s(axes.z_axis * half.z),
            base_vertex,
        }
    }
}

/// Twin of `Horizon` in `compute/cull.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Horizon {
    eye: [f32; 3],
    tangent_squared: f32,
    scale: [f32; 3],
    padding: u32,
}

impl Horizon {
    /// The shadow of the largest ellipsoid certainly below the surface as drawn.
    pub(crate) fn new(input: &FillInput) -> Self {
        let radii = input.scene.body.radii_below_m(input.terrain().lowest_m);
        if radii.min_element() <= 0.0 {
            // Nothing solid is left to hide anything.
            return Self::zeroed();
        }
        let eye = input.camera.eye_ecef / radii;
        Self {
            eye: eye.as_vec3().to_array(),
            tangent_squared: nearest_f32(eye.length_squared() - 1.0),
            scale: radii.recip().as_vec3().to_array(),
            padding: 0,
        }
    }
}

/// Twin of `DrawArguments` in `shared/draw.wgsl`, and what wgpu reads for an indexed indirect draw.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct DrawArguments {
    pub(crate) index_count: u32,
    pub(crate) instance_count: u32,
    pub(crate) first_index: u32,
    pub(crate) base_vertex: i32,
    pub(crate) first_instance: u32,
}

/// State of a region that is not drawn. Twin of `LEFT_OUT` in `shared/draw.wgsl`.
pub(crate) const LEFT_OUT: u32 = 0;

/// Bytes from one draw's arguments to the next.
pub(crate) const DRAW_ARGUMENTS_BYTES: u64 = size_of::<DrawArguments>() as u64;

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;
    use terrafill_shaders::struct_layout;

    /// Offsets by name of the Rust struct, and its size.
    macro_rules! layout_of {
        ($ty:ty: $($field:ident),* $(,)?) => {
            (vec![$((stringify!($field).to_owned(), offset_of!($ty, $field))),*], size_of::<$ty>())
        };
    }

    fn shader(path: &str, name: &str) -> (Vec<(String, usize)>, usize) {
        let layout = struct_layout(path, name).expect("struct is in the shader");
        let members = layout.members.into_iter();
        (
            members
                .map(|(name, offset, _)| (name, offset as usize))
                .collect(),
            layout.stride as usize,
        )
    }

    #[test]
    fn constants_lie_as_the_shaders_read_them() {
        let region = layout_of!(CullRegion: center_m, first_index, half_edge_0_m, bottom_count,
            half_edge_1_m, upper_count, half_edge_2_m, base_vertex);
        assert_eq!(region, shader("compute/cull.wgsl", "CullRegion"));
        let horizon = layout_of!(Horizon: eye, tangent_squared, scale, padding);
        assert_eq!(horizon, shader("compute/cull.wgsl", "Horizon"));
        let draw = layout_of!(DrawArguments: index_count, instance_count, first_index,
            base_vertex, first_instance);
        for path in ["compute/cull.wgsl", "compute/expand.wgsl"] {
            assert_eq!(draw, shader(path, "DrawArguments"));
        }
        assert_eq!(draw.1, size_of::<wgpu::util::DrawIndexedIndirectArgs>());
    }

    #[test]
    fn a_moved_field_is_noticed() {
        let swapped = layout_of!(CullRegion: first_index, center_m, half_edge_0_m, bottom_count,
            half_edge_1_m, upper_count, half_edge_2_m, base_vertex);
        assert_ne!(swapped, shader("compute/cull.wgsl", "CullRegion"));
    }
}
