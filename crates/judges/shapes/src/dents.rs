// SPDX-License-Identifier: MIT OR Apache-2.0
//! Dents that deform a model, in `f64` and as a device reads them; metres.
//!
//! A dent is a polynomial of the distance. Every device computes it to the last digits of 32-bit floats, which does not
//! hold for sines.

use crate::grid::nearest;
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

/// Middles on and in the rabbit, radii, and how far their middles are moved: knocks from all sides, and bent ears.
const DENTS: [([f64; 3], f64, [f64; 3]); 12] = [
    ([-0.6, -0.45, 0.2], 0.35, [0.1, 0.2, -0.05]),
    ([-0.2, -0.5, 0.1], 0.3, [0.0, 0.18, 0.0]),
    ([0.2, -0.4, 0.2], 0.25, [0.0, 0.12, -0.05]),
    ([0.1, -0.3, -0.4], 0.3, [0.0, 0.05, 0.15]),
    ([0.75, -0.1, 0.6], 0.25, [-0.12, 0.05, 0.0]),
    ([0.4, -0.35, 1.35], 0.6, [0.3, -0.2, -0.25]),
    ([0.4, 0.35, 1.35], 0.6, [0.35, 0.2, -0.3]),
    ([-0.6, 0.45, 0.2], 0.35, [0.1, -0.2, -0.05]),
    ([-0.2, 0.5, 0.1], 0.3, [0.0, -0.18, 0.0]),
    ([0.2, 0.4, 0.2], 0.25, [0.0, -0.12, -0.05]),
    ([-0.5, 0.0, 0.55], 0.4, [0.0, 0.0, 0.2]),
    ([-1.0, 0.0, 0.15], 0.3, [-0.15, 0.0, 0.1]),
];

/// Twin of `Dent` in `shared/dents.wgsl`.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Dent {
    middle: [f32; 3],
    radius: f32,
    push: [f32; 3],
    padding: f32,
}

/// The knocks that the model gets.
#[must_use]
pub fn dents() -> Vec<Dent> {
    let dent = |(middle, radius, push): ([f64; 3], f64, [f64; 3])| Dent {
        middle: middle.map(nearest),
        radius: nearest(radius),
        push: push.map(nearest),
        padding: 0.0,
    };
    DENTS.map(dent).into()
}

/// Twin of `deformed` in `shared/dents.wgsl`.
pub fn deformed(place: DVec3, dents: &[Dent]) -> DVec3 {
    let pushes = dents.iter().map(|dent| {
        let [middle, push] = [dent.middle, dent.push].map(|of| Vec3::from(of).as_dvec3());
        let away = (place - middle) / f64::from(dent.radius);
        let inside = (1.0 - away.length_squared()).max(0.0);
        push * (inside * inside)
    });
    place + pushes.sum::<DVec3>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;
    use terrafill_shaders::struct_layout;

    #[test]
    fn a_dent_moves_its_middle_by_its_push_and_nothing_beyond_its_radius() {
        let dents = dents();
        let one = &dents[..1];
        let middle = Vec3::from(one[0].middle).as_dvec3();
        let push = Vec3::from(one[0].push).as_dvec3();
        assert_eq!(deformed(middle, one), middle + push);
        let beyond = middle + DVec3::X * 0.351;
        assert_eq!(deformed(beyond, one), beyond);
        // Negative control: nearer than its radius it is moved.
        let within = middle + DVec3::X * 0.2;
        assert_ne!(deformed(within, one), within);
    }

    #[test]
    fn dents_lie_as_the_shader_reads_them() {
        let layout = struct_layout("pipelines/deform.wgsl", "Dent").expect("a struct");
        assert_eq!(
            layout.offset("middle").expect("middle"),
            offset_of!(Dent, middle)
        );
        assert_eq!(layout.offset("push").expect("push"), offset_of!(Dent, push));
        assert_eq!(layout.stride as usize, size_of::<Dent>());
        // Negative control.
        assert_ne!(
            layout.offset("push").expect("push"),
            offset_of!(Dent, radius)
        );
    }
}
