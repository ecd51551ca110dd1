// SPDX-License-Identifier: MIT OR Apache-2.0
//! A rabbit-like surface without a foreign model, in metres and `f64`: where a sum of blobs' fields is 1.
//!
//! A blob's field falls by the square of the distance. Lines of steepest descent leave the surface and never meet. Far
//! away they are those of a single blob. So the direction in which a line ends maps its place of the surface to a
//! sphere, though the surface is not star-shaped.

use crate::grid::GridCamera;
use glam::DVec3;

/// Middles and radii: hind part, belly, chest, head, muzzle, tail; then feet and ears, on either side.
const MIDDLE: [([f64; 3], f64); 6] = [
    ([-0.42, 0.0, 0.02], 0.36),
    ([-0.1, 0.0, 0.0], 0.3),
    ([0.22, 0.0, 0.06], 0.24),
    ([0.52, 0.0, 0.5], 0.22),
    ([0.72, 0.0, 0.42], 0.1),
    ([-0.95, 0.0, 0.12], 0.1),
];
const SIDES: [([f64; 3], f64); 6] = [
    ([-0.4, 0.36, -0.36], 0.13),
    ([0.36, 0.2, -0.4], 0.12),
    ([0.46, 0.14, 0.82], 0.08),
    ([0.42, 0.19, 0.98], 0.08),
    ([0.37, 0.25, 1.14], 0.08),
    ([0.31, 0.32, 1.3], 0.09),
];
/// At this distance lines are nearly straight.
const FAR_M: f64 = 60.0;
/// Length of a step along a line, as a share of the distance from the origin.
const STEP: f64 = 0.02;
/// Steps of Newton's method onto the surface.
const STEPS: usize = 6;

/// All blobs.
fn blobs() -> impl Iterator<Item = (DVec3, f64)> {
    let sides = SIDES
        .into_iter()
        .flat_map(|([x, y, z], radius)| [([x, y, z], radius), ([x, -y, z], radius)]);
    let all = MIDDLE.into_iter().chain(sides);
    all.map(|(at, radius)| (DVec3::from(at), radius))
}

/// How much more than on the surface the field is, and its gradient.
pub fn field(place: DVec3) -> (f64, DVec3) {
    let (mut sum, mut gradient) = (-1.0, DVec3::ZERO);
    for (middle, radius) in blobs() {
        let from = place - middle;
        let square = from.length_squared();
        let part = radius * radius / square;
        sum += part;
        gradient -= from * (2.0 * part / square);
    }
    (sum, gradient)
}

/// The place of the surface that a line of steepest change through a place near it meets.
pub fn onto(mut place: DVec3) -> DVec3 {
    for _ in 0..STEPS {
        let (more, gradient) = field(place);
        place -= gradient * (more / gradient.length_squared());
    }
    place
}

/// Distance from the surface along its normal, metres, of a place near it.
pub fn distance_m(place: DVec3) -> f64 {
    (place - onto(place)).length()
}

/// The direction in which the line of steepest fall from a place ends.
pub fn direction(mut place: DVec3) -> DVec3 {
    let fall = |place: DVec3| -field(place).1.normalize();
    while place.length() < FAR_M {
        // Fourth-order Runge–Kutta.
        let step = STEP * place.length().max(0.5);
        let first = fall(place);
        let second = fall(place + 0.5 * step * first);
        let third = fall(place + 0.5 * step * second);
        let fourth = fall(place + step * third);
        place += step / 6.0 * (first + 2.0 * (second + third) + fourth);
    }
    place.normalize()
}

/// The box that holds it, metres.
pub const BOX: [DVec3; 2] = [DVec3::new(-1.6, -1.1, -1.1), DVec3::new(1.4, 1.1, 2.1)];

/// From where it is seen.
pub fn rabbit_view() -> GridCamera {
    let eye = DVec3::new(2.6, -4.0, 1.4);
    GridCamera::looking(eye, DVec3::new(-0.1, 0.0, 0.4), 0.28)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_is_that_of_differences_and_distances_are_along_it() {
        let on = onto(onto(DVec3::new(0.3, -0.8, 0.5)));
        let (value, gradient) = field(on);
        assert!(value.abs() < 1e-12, "{value}");
        for axis in DVec3::AXES {
            const STEP: f64 = 1e-6;
            let difference = (field(on + axis * STEP).0 - value) / STEP;
            assert!((difference - gradient.dot(axis)).abs() < 1e-4, "{axis}");
        }
        let beside = on + 1e-3 * gradient.normalize();
        assert!((distance_m(beside) - 1e-3).abs() < 1e-5);
        // Negative control: a place on the surface is not as far.
        assert!(distance_m(on) < 1e-9);
    }
}
