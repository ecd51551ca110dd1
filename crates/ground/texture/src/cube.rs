// SPDX-License-Identifier: MIT OR Apache-2.0
//! A spherical texture: longitude and latitude looked up by direction in a cube map.
//!
//! Six faces of S × S texels with two 32-bit floats, longitude and latitude in radians of a surface
//! normal; one bilinear fetch in the place of all arithmetic. The route gives it the position with z
//! times a² / b², which on the body's surface is the direction of the normal, so the texture is the
//! same for every body and region. Directions are in meridian axes, so that the date line's texels,
//! where longitude jumps by 2π, lie opposite the region.
//!
//! A texel's place is Vulkan's (§16.5.4 "Cube Map Face Selection and Transformations"): the largest
//! coordinate selects the face, the two others divided by it run from −1 to 1. Filtering is seamless.
//! Weights have [`WEIGHT_BITS`] fractional bits, as `subTexelPrecisionBits` says for all common GPUs.

use crate::lookup::Sampler;
use crate::rounding::Bounded;
use std::fmt::Write as _;
use terrafill_core::nearest_f32;

/// Fractional bits of a bilinear weight.
pub(crate) const WEIGHT_BITS: i32 = 8;

/// A cube texture of longitude and latitude. Texels are computed on demand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CubeTexture {
    size: u32,
    /// Whether its sampler does not round weights to [`WEIGHT_BITS`].
    weighs_exactly: bool,
}

/// A face and the place on it, −1 to 1 along both axes.
struct FacePoint {
    face: usize,
    place: [f64; 2],
}

impl CubeTexture {
    /// Faces of `size` × `size` texels; at least 2.
    #[must_use]
    pub fn new(size: u32) -> Self {
        Self {
            size: size.max(2),
            weighs_exactly: false,
        }
    }

    /// The texture as this sampler reads it.
    #[must_use]
    pub fn on(self, sampler: &Sampler) -> Self {
        Self {
            weighs_exactly: sampler.weighs_exactly,
            ..self
        }
    }

    /// Texels along an edge.
    #[must_use]
    pub fn size(&self) -> u32 {
        self.size
    }

    /// One face row by row, two `f32` a texel, as it is uploaded: +x, −x, +y, −y, +z, −z.
    #[must_use]
    pub fn face(&self, face: usize) -> Vec<[f32; 2]> {
        let size = i64::from(self.size);
        (0..size)
            .flat_map(|t| (0..size).map(move |s| (s, t)))
            .map(|(s, t)| self.texel(face, [s, t]))
            .collect()
    }

    /// WGSL that declares the texture at `binding` of `group` and its sampler at the one after it.
    #[must_use]
    pub fn declarations(&self, group: u32, binding: u32) -> String {
        let mut text =
            format!("@group({group}) @binding({binding}) var route_cube: texture_cube<f32>;\n");
        let next = binding + 1;
        let _ = writeln!(
            text,
            "@group({group}) @binding({next}) var route_sampler: sampler;"
        );
        text
    }

    /// What the texture holds for a direction, exact.
    fn angles([x, y, z]: [f64; 3]) -> [f64; 2] {
        [y.atan2(x), z.atan2(x.hypot(y))]
    }

    /// Texel (s, t) of a face; one beyond an edge is that of the face that continues there.
    fn texel(&self, face: usize, [s, t]: [i64; 2]) -> [f32; 2] {
        let place = [self.place(s), self.place(t)];
        let inside = place.map(|p| p.clamp(-1.0, 1.0));
        let mut direction = direction(face, inside);
        let beyond = place[0].abs().max(place[1].abs());
        if beyond > 1.0 {
            // Half a texel round the edge: as far below the edge on the next face as beyond it here.
            let axis = face / 2;
            direction[axis] *= 2.0 - beyond;
        }
        Self::angles(direction).map(nearest_f32)
    }

    /// Place on the face of the centre of texel `index`.
    fn place(&self, index: i64) -> f64 {
        (2.0 * index as f64 + 1.0) / f64::from(self.size) - 1.0
    }

    /// Left upper texel and weights, in texels, of a place on a face.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "below the texture's size in magnitude"
    )]
    fn footprint(&self, place: [f64; 2]) -> ([i64; 2], [f64; 2]) {
        let texels = place.map(|p| 0.5 * (p + 1.0) * f64::from(self.size) - 0.5);
        let corner = texels.map(f64::floor);
        (
            corner.map(|c| c as i64),
            [texels[0] - corner[0], texels[1] - corner[1]],
        )
    }

    /// The four texels round a place: left upper, right upper, left lower, right lower.
    fn corners(&self, face: usize, [s, t]: [i64; 2]) -> [[f32; 2]; 4] {
        [[s, t], [s + 1, t], [s, t + 1], [s + 1, t + 1]].map(|texel| self.texel(face, texel))
    }

    /// What a sampler gives in a direction; NaN for none.
    #[must_use]
    pub(crate) fn sample(&self, direction: [f32; 3]) -> [f32; 2] {
        let Some(point) = face_point(direction.map(f64::from)) else {
            return [f32::NAN; 2];
        };
        // The sampler has the place in f32, and rounds the weights.
        let place = point.place.map(|p| f64::from(nearest_f32(p)));
        let (corner, weights) = self.footprint(place);
        let steps = f64::from(WEIGHT_BITS).exp2();
        let [u, v] = weights.map(|w| (w * steps).round() / steps);
        let texels = self.corners(point.face, corner);
        [0, 1].map(|channel| {
            let [a, b, c, d] = texels.map(|texel| f64::from(texel[channel]));
            nearest_f32((1.0 - v) * (a + u * (b - a)) + v * (c + u * (d - c)))
        })
    }

    /// By exact weights, with what rounded weights and the direction's error may change.
    #[must_use]
    pub(crate) fn bounded(&self, direction: [Bounded; 3]) -> [Bounded; 2] {
        let Some(point) = face_point(direction.map(|d| d.value)) else {
            return [Bounded::exact(f64::NAN); 2];
        };
        let (corner, [u, v]) = self.footprint(point.place);
        let texels = self.corners(point.face, corner);
        let major = direction[point.face / 2].value.abs();
        let worst = direction.iter().map(|d| d.bound).fold(0.0, f64::max);
        // Numerator and divisor move a place on the face by as much each; then it becomes f32.
        let moved_place = 2.0 * worst / major + 3.0 * f64::from(f32::EPSILON);
        let texels_per_place = 0.5 * f64::from(self.size);
        let moved_texels = texels_per_place * moved_place;
        let half_weight = 0.5 * (-f64::from(WEIGHT_BITS)).exp2();
        // What is to be expected: numerator and divisor independent, the place rounded once.
        let spread = direction.iter().map(|d| d.variance).sum::<f64>() / (major * major);
        let place_variance = spread + f64::from(f32::EPSILON).powi(2) / 12.0;
        let rounded_weight = if self.weighs_exactly {
            0.0
        } else {
            half_weight.powi(2) / 3.0
        };
        let weight_variance = rounded_weight + texels_per_place.powi(2) * place_variance;
        [0, 1].map(|channel| {
            let [a, b, c, d] = texels.map(|texel| f64::from(texel[channel]));
            let value = (1.0 - v) * (a + u * (b - a)) + v * (c + u * (d - c));
            let along = (b - a).abs().max((d - c).abs());
            let across = (c - a).abs().max((d - b).abs());
            let rounding = 2.0 * f64::from(f32::EPSILON) * value.abs();
            let weight = half_weight + moved_texels;
            let variance = (along.powi(2) + across.powi(2)) * weight_variance;
            Bounded {
                value,
                bound: (along + across) * weight + rounding,
                variance: variance + rounding.powi(2) / 12.0,
            }
        })
    }
}

/// Direction of a place on a face; its largest coordinate is ±1. Table of the Vulkan specification.
fn direction(face: usize, [s, t]: [f64; 2]) -> [f64; 3] {
    match face {
        0 => [1.0, -t, -s],
        1 => [-1.0, -t, s],
        2 => [s, 1.0, t],
        3 => [s, -1.0, -t],
        4 => [s, -t, 1.0],
        _ => [-s, -t, -1.0],
    }
}

/// Face and place of a direction; `None` for the zero vector and anything not finite.
fn face_point([x, y, z]: [f64; 3]) -> Option<FacePoint> {
    let largest = x.abs().max(y.abs()).max(z.abs());
    if !(largest > 0.0 && (x + y + z).is_finite()) {
        return None;
    }
    // Equal ones: z before y before x.
    let (face, s, t) = if z.abs() >= largest {
        if z > 0.0 { (4, x, -y) } else { (5, -x, -y) }
    } else if y.abs() >= largest {
        if y > 0.0 { (2, x, z) } else { (3, x, -z) }
    } else if x > 0.0 {
        (0, -z, -y)
    } else {
        (1, z, -y)
    };
    Some(FacePoint {
        face,
        place: [s / largest, t / largest],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_returns_to_its_place() {
        for face in 0..6 {
            for place in [[0.3, -0.7], [-0.99, 0.01], [0.5, 0.25]] {
                let d = direction(face, place).map(|x| 3.5 * x);
                let point = face_point(d).expect("a direction");
                assert_eq!(point.face, face);
                for (got, want) in point.place.iter().zip(place) {
                    assert!((got - want).abs() < 1e-15);
                }
            }
        }
        assert!(face_point([0.0; 3]).is_none());
        assert!(face_point([f64::NAN, 1.0, 0.0]).is_none());
    }

    #[test]
    fn filtering_knows_no_seam_at_an_edge() {
        let cube = CubeTexture::new(64);
        // From the face of +x to that of +z across their edge.
        let mut last: Option<[f32; 2]> = None;
        for i in 0..400_u16 {
            let elevation = 0.6 + 0.001 * f32::from(i);
            let d = [elevation.cos(), 0.2, elevation.sin()];
            let texel = cube.sample(d);
            if let Some(before) = last {
                let step = (texel[1] - before[1]).abs();
                assert!(step < 0.004, "{elevation}: {step}");
            }
            last = Some(texel);
        }
    }

    #[test]
    fn a_texel_beyond_an_edge_is_one_of_the_next_face() {
        let cube = CubeTexture::new(8);
        let texels: Vec<[f32; 2]> = (0..6).flat_map(|face| cube.face(face)).collect();
        let close = |a: [f32; 2], b: [f32; 2]| a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-5);
        for face in 0..6 {
            for (s, t) in (0..8).flat_map(|i| [(i, -1), (i, 8), (-1, i), (8, i)]) {
                let beyond = cube.texel(face, [s, t]);
                assert_eq!(texels.iter().filter(|x| close(**x, beyond)).count(), 1);
            }
        }
        // Negative control: the place simply continued beyond the edge is nobody's texel.
        let continued = CubeTexture::angles(direction(4, [cube.place(8), cube.place(3)]));
        let continued = continued.map(nearest_f32);
        assert!(!texels.iter().any(|x| close(*x, continued)));
    }
}
