// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rust twins of the constants in `shaders/shared/`; tests hold the layouts together.

use crate::{FixedPoint, PositionFormat, two_float};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use terrafill_contract::{Colours, FillInput};
use terrafill_core::{ConeEdge, VolumeHeights, nearest_f32};
use terrafill_plan::PlannedRegion;

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
    /// Where the volume's [`FootprintConstants`] begin in the same buffer, in units of 16 bytes; 0 where
    /// it has none. With them the origin is the cone's apex, and the remainder the whole eye from there.
    pub footprint: u32,
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

impl VolumePlace {
    /// The same volume so many elements farther on.
    #[must_use]
    pub fn moved(self, vertices: u32, triangle_indices: u32, loop_indices: u32) -> Self {
        Self {
            first_vertex: self.first_vertex + vertices,
            first_triangle_index: self.first_triangle_index + triangle_indices,
            first_loop_index: self.first_loop_index + loop_indices,
            ..self
        }
    }
}

impl VolumeConstants {
    /// Constants of one volume.
    ///
    /// - `heights`: of its caps
    #[must_use]
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
            scale_m: nearest_f32(fixed.unit_m * f64::from(eye.shift).exp2()),
            origin_ecef_m: fixed.origin_ecef.as_vec3().to_array(),
            unit_m: nearest_f32(fixed.unit_m),
            top_m: nearest_f32(heights.top_m),
            bottom_m: nearest_f32(heights.bottom_m),
            first_vertex: place.first_vertex,
            first_triangle_index: place.first_triangle_index,
            first_loop_index: place.first_loop_index,
            triangle_count: place.triangle_count,
            index_bits: if place.has_short_indices { 16 } else { 32 },
            footprint: 0,
            colour,
        }
    }

    /// The same for a volume that a cone's edge bends.
    ///
    /// - `first`: of its [`FootprintConstants`], in units of 16 bytes
    fn bent(self, eye_ecef: DVec3, edge: &ConeEdge, first: u32) -> Self {
        Self {
            eye_remainder_m: (eye_ecef - edge.apex_ecef).as_vec3().to_array(),
            origin_ecef_m: edge.apex_ecef.as_vec3().to_array(),
            footprint: first,
            ..self
        }
    }

    /// Bytes of the constants of all that `input` plans, in its order, and of the footprints of those
    /// that have one behind them; `place_of` tells where a mesh lies. One element of zeros where
    /// nothing is planned: a storage binding may not be empty.
    #[must_use]
    pub fn bytes_of_all(
        input: &FillInput,
        positions: PositionFormat,
        colours: Colours,
        place_of: impl Fn(usize) -> VolumePlace,
    ) -> Vec<u8> {
        let eye = input.camera.eye_ecef;
        let mut footprints: Vec<FootprintConstants> = Vec::new();
        let behind = input.plan.regions.len() * size_of::<Self>();
        let of_region = |planned: &PlannedRegion| {
            let (place, colour) = (place_of(planned.mesh), colours.of(planned.region));
            let constants = Self::new(eye, &place, planned.heights, positions, colour);
            let Some(moving) = input.scene.footprints.get(&planned.mesh) else {
                return constants;
            };
            let first = (behind + size_of_val(footprints.as_slice())) / 16;
            footprints.push(FootprintConstants::new(&moving.edge, &place.fixed));
            let first = u32::try_from(first).unwrap_or(u32::MAX);
            constants.bent(eye, &moving.edge, first)
        };
        let constants: Vec<Self> = input.plan.regions.iter().map(of_region).collect();
        if constants.is_empty() {
            return vec![0; size_of::<Self>()];
        }
        let mut bytes = bytemuck::cast_slice(&constants).to_vec();
        bytes.extend_from_slice(bytemuck::cast_slice(&footprints));
        bytes
    }

    /// Bytes of the constants that `input` asks for, without what only fills a binding.
    #[must_use]
    pub fn byte_count(input: &FillInput) -> u64 {
        let planned = input.plan.regions.iter();
        let moving = planned.filter(|planned| input.scene.footprints.contains_key(&planned.mesh));
        let footprints = moving.count() * size_of::<FootprintConstants>();
        (input.plan.regions.len() * size_of::<Self>() + footprints) as u64
    }
}

/// Twin of `CIRCLE_UNIT` in `shared/region.wgsl`.
const CIRCLE_UNIT: f64 = 1.0 / (1_u32 << 30) as f64;

/// Twin of `Footprint` in `shared/footprint.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct FootprintConstants {
    /// [`ConeEdge::axis`], and [`ConeEdge::power`].
    pub axis_and_power: [f32; 4],
    /// [`ConeEdge::right`], and 1 / equatorial radius, per metre.
    pub right_and_inverse_a: [f32; 4],
    /// [`ConeEdge::forward`], and 1 / polar radius, per metre.
    pub forward_and_inverse_b: [f32; 4],
    /// [`ConeEdge::scaled_apex`], and 0.
    pub scaled_apex: [f32; 4],
}

impl FootprintConstants {
    /// Of an edge, rounded.
    ///
    /// - `disc`: origin and unit of the stored disc. The shader takes positions in units of 2⁻³⁰ from 0, as
    ///   most discs have them; what another one has is brought into the constants.
    #[must_use]
    pub fn new(edge: &ConeEdge, disc: &FixedPoint) -> Self {
        let four = |vector: DVec3, w: f64| vector.extend(w).as_vec4().to_array();
        let middle = disc.origin_ecef;
        let axis = edge.axis + edge.right * middle.x + edge.forward * middle.y;
        let stretch = disc.unit_m / CIRCLE_UNIT;
        Self {
            axis_and_power: four(axis, edge.power),
            right_and_inverse_a: four(edge.right * stretch, edge.inverse_radii.x),
            forward_and_inverse_b: four(edge.forward * stretch, edge.inverse_radii.z),
            scaled_apex: four(edge.scaled_apex, 0.0),
        }
    }
}

/// The bytes in which constants differ, in whole words, from the first one to behind the last, or all where their
/// lengths do; `None` where nothing is to be written.
///
/// Regions that move stand behind one another, so that one write takes what changed of all of them.
#[must_use]
pub fn changed_words(before: &[u8], after: &[u8]) -> Option<std::ops::Range<usize>> {
    if before.len() != after.len() {
        return (!after.is_empty()).then_some(0..after.len());
    }
    let differs = |(before, after): (&u8, &u8)| before != after;
    let first = before.iter().zip(after).position(differs)?;
    let last = before.iter().zip(after).rposition(differs)?;
    Some(first / 4 * 4..(last / 4 * 4 + 4).min(after.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::{Ellipsoid, FootprintMesher, Geodetic, SensorCone};

    #[test]
    fn whatever_disc_is_stored_is_bent_into_the_same_edge() {
        let cone = SensorCone {
            apex: Geodetic::from_degrees(15.0, 35.0, 700_000.0),
            azimuth_rad: 2.0,
            elevation_rad: -1.3,
            half_angle_rad: 0.3,
        };
        // Of three vertices the middle of the bounds is none of the circle.
        for vertices in [3, 4, 5, 64, 101, 256] {
            let mesher = FootprintMesher::new(Ellipsoid::WGS84, vertices).expect("allowed");
            let edge = mesher.moving(&cone).expect("all round").edge;
            let disc = mesher.disc("disc", 0);
            let fixed = FixedPoint::for_mesh(&disc);
            let bent = |constants: &FootprintConstants| {
                let vector = |four: [f32; 4]| DVec3::from_array([0, 1, 2].map(|i| four[i].into()));
                let [axis, right, forward] = [
                    constants.axis_and_power,
                    constants.right_and_inverse_a,
                    constants.forward_and_inverse_b,
                ]
                .map(vector);
                let bent = ConeEdge {
                    axis,
                    right,
                    forward,
                    ..edge
                };
                let off = disc.vertices_ecef.iter().zip(mesher.steps());
                let off = off.map(|(&vertex, &[cos, sin])| {
                    let stored = fixed.quantize(vertex).as_dvec3() * CIRCLE_UNIT;
                    bent.hit(stored.x, stored.y).distance(edge.hit(cos, sin))
                });
                off.fold(0.0, f64::max)
            };
            let found_m = bent(&FootprintConstants::new(&edge, &fixed));
            assert!(found_m < 1.0, "{vertices}: {found_m}");
            // Negative control: taken for a disc about 0, one of an odd number of vertices is bent elsewhere.
            let plain = FixedPoint {
                origin_ecef: DVec3::ZERO,
                unit_m: CIRCLE_UNIT,
            };
            let found_m = bent(&FootprintConstants::new(&edge, &plain));
            assert_eq!(found_m > 1.0, vertices % 2 == 1, "{vertices}: {found_m}");
        }
    }

    #[test]
    fn changed_words_hold_every_byte_that_differs_and_no_word_more() {
        let before: Vec<u8> = (0..40).collect();
        let mut after = before.clone();
        assert_eq!(changed_words(&before, &after), None);
        after[9] += 1;
        assert_eq!(changed_words(&before, &after), Some(8..12));
        after[30] += 1;
        assert_eq!(changed_words(&before, &after), Some(8..32));
        // Negative control: with those alone written over them, the former are the latter.
        let mut written = before.clone();
        written[8..32].copy_from_slice(&after[8..32]);
        assert_eq!(written, after);
        after[39] += 1;
        assert_ne!(written, after);
        assert_eq!(changed_words(&before[..4], &after), Some(0..40));
        assert_eq!(changed_words(&before, &[]), None);
    }
}
