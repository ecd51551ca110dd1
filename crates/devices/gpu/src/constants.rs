// SPDX-License-Identifier: MIT OR Apache-2.0
//! Holds the constants of `terrafill-stencil` against what the shaders read.

#[cfg(test)]
mod tests {
    use std::mem::{offset_of, size_of};
    use terrafill_contract::ViewConstants;
    use terrafill_shaders::{RouteText, TexturedParts, TexturedPlacement, struct_layout};
    use terrafill_stencil::{FootprintConstants, TexturedRegion, VolumeConstants};

    /// Offsets by name of the Rust struct, to be found again in the shader's.
    macro_rules! offsets {
        ($ty:ty: $($field:ident),* $(,)?) => {
            vec![$((stringify!($field).to_owned(), offset_of!($ty, $field))),*]
        };
    }

    fn shader_offsets(path: &str, name: &str) -> (Vec<(String, usize)>, usize) {
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
    fn view_constants_lie_as_the_shader_reads_them() {
        let rust = offsets!(ViewConstants: view_from_ecef, eye_ecef, near_m, normal_scale,
            clip_scale_x, clip_scale_y, pixel_per_distance);
        for path in [
            "surface/surface.wgsl",
            "vertex/doubled.wgsl",
            "vertex/cover.wgsl",
        ] {
            let (shader, stride) = shader_offsets(path, "ViewConstants");
            assert_eq!(rust, shader);
            assert_eq!(size_of::<ViewConstants>(), stride);
        }
    }

    #[test]
    fn region_constants_lie_as_the_shader_reads_them() {
        let rust = offsets!(VolumeConstants: eye, shift, eye_remainder_m, scale_m, origin_ecef_m,
            unit_m, top_m, bottom_m, first_vertex, first_triangle_index, first_loop_index,
            triangle_count, index_bits, footprint, colour);
        for path in [
            "vertex/doubled.wgsl",
            "vertex/pulled.wgsl",
            "vertex/cover.wgsl",
        ] {
            let (shader, stride) = shader_offsets(path, "VolumeConstants");
            assert_eq!(rust, shader);
            assert_eq!(size_of::<VolumeConstants>(), stride);
        }
    }

    #[test]
    fn footprints_lie_as_the_shader_reads_them() {
        let rust = offsets!(FootprintConstants: axis_and_power, right_and_inverse_a,
            forward_and_inverse_b, scaled_apex);
        let (shader, stride) = shader_offsets("vertex/doubled.wgsl", "Footprint");
        assert_eq!(rust, shader);
        assert_eq!(size_of::<FootprintConstants>(), stride);
        // Negative control: another order is noticed.
        let swapped = offsets!(FootprintConstants: right_and_inverse_a, axis_and_power,
            forward_and_inverse_b, scaled_apex);
        assert_ne!(swapped, shader);
    }

    #[test]
    fn textured_regions_lie_as_the_shader_reads_them() {
        let parts = TexturedParts {
            position: RouteText {
                wgsl: "struct PositionConstants { c0: vec4f }\n\
                       fn fragment_offset(pixel: vec2f, depth: f32, c: PositionConstants) -> vec3f {\n\
                       return vec3f(depth); }"
                    .to_owned(),
                constants: 0,
            },
            route: RouteText {
                wgsl: "struct RouteConstants { c0: vec4f, c1: vec4f }\n\
                       fn route_angles(d: vec3f, c: RouteConstants) -> vec2f { return c.c1.xy; }"
                    .to_owned(),
                constants: 2,
            },
            placement: TexturedPlacement::Affine,
        };
        let layout = parts.region_layout().expect("valid");
        let names = layout.members.iter();
        let shader: Vec<_> = names
            .map(|(name, offset, _)| (name.clone(), *offset as usize))
            .collect();
        let rust = offsets!(TexturedRegion: anchor_m, id, eye_m, alpha, right,
            equatorial_radius_m, down, eccentricity_squared, u, fade_end_m, v, fade_per_m,
            texel_per_m);
        assert_eq!(rust, shader[..rust.len()]);
        let fixed = size_of::<TexturedRegion>();
        assert_eq!(shader[rust.len()], ("position".to_owned(), fixed));
        assert_eq!(shader[rust.len() + 1], ("route".to_owned(), fixed + 16));
        assert_eq!(layout.stride as usize, fixed + 16 * (1 + 2));
        assert_eq!(TexturedRegion::VECTORS * 16, fixed);
    }

    #[test]
    fn a_moved_field_is_noticed() {
        let (shader, _) = shader_offsets("vertex/doubled.wgsl", "VolumeConstants");
        let mut swapped = shader.clone();
        swapped.swap(8, 9);
        assert_ne!(swapped, shader);
        let rust = offsets!(VolumeConstants: bottom_m, top_m);
        assert_ne!(rust[0].1, shader[8].1);
    }
}
