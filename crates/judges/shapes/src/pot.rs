// SPDX-License-Identifier: MIT OR Apache-2.0
//! A pot of 40 patches, by its own control points: a profile turned about z, a spout and a handle; metres.
//!
//! No foreign model: the famous teapot's points are not here. Patches of the turned profile join smoothly, spout and
//! handle end within its wall.

use crate::grid::GridCamera;
use crate::patch::Patch;
use glam::{DVec2, DVec3};

/// Where the control points of a quarter of a circle of radius 1 lie on its tangents: off by 0.027 % at most.
const QUARTER: f64 = 0.552_284_749_830_793_4;

/// The profile, from the middle of the bottom to that of the lid: radius and height of each piece's points.
const PROFILE: [[[f64; 2]; 4]; 8] = [
    [[0.0, 0.0], [0.25, 0.0], [0.5, 0.0], [0.62, 0.12]],
    [[0.62, 0.12], [0.74, 0.24], [0.85, 0.4], [0.85, 0.65]],
    [[0.85, 0.65], [0.85, 0.95], [0.62, 1.1], [0.5, 1.2]],
    [[0.5, 1.2], [0.44, 1.25], [0.4, 1.3], [0.4, 1.38]],
    [[0.4, 1.38], [0.4, 1.45], [0.46, 1.5], [0.52, 1.5]],
    [[0.52, 1.5], [0.56, 1.5], [0.56, 1.55], [0.52, 1.55]],
    [[0.52, 1.55], [0.44, 1.55], [0.34, 1.5], [0.34, 1.38]],
    [[0.34, 1.38], [0.34, 1.26], [0.2, 1.2], [0.0, 1.2]],
];

/// Four rings each: the place of its middle, its radius, and which way the tube runs there, all in the plane y = 0.
const SPOUT: [([f64; 2], f64, [f64; 2]); 4] = [
    ([0.7, 0.42], 0.2, [1.0, 0.1]),
    ([1.15, 0.5], 0.17, [1.0, 0.6]),
    ([1.1, 1.1], 0.1, [0.2, 1.0]),
    ([1.42, 1.3], 0.08, [1.0, 0.6]),
];
const HANDLE: [([f64; 2], f64, [f64; 2]); 4] = [
    ([-0.5, 1.12], 0.07, [-1.0, 0.2]),
    ([-1.3, 1.35], 0.07, [-1.0, -0.2]),
    ([-1.4, 0.3], 0.07, [0.3, -1.0]),
    ([-0.74, 0.36], 0.07, [1.0, 0.1]),
];

/// Places of a quarter circle's control points, turned by so many quarters.
fn quarter(turned: u32) -> [DVec2; 4] {
    let points = [[1.0, 0.0], [1.0, QUARTER], [QUARTER, 1.0], [0.0, 1.0]].map(DVec2::from);
    points.map(|point| (0..turned).fold(point, |point, _| point.perp()))
}

/// Four patches of a tube through four rings.
///
/// - `ring`: a ring's middle, and its two axes, as long as its radius
fn tube(rings: [[DVec3; 3]; 4]) -> impl Iterator<Item = Patch> {
    (0..4).map(move |turned| {
        let around = quarter(turned);
        Patch(
            rings.map(|[middle, first, second]| {
                around.map(|at| middle + first * at.x + second * at.y)
            }),
        )
    })
}

fn bent_tube(rings: [([f64; 2], f64, [f64; 2]); 4]) -> impl Iterator<Item = Patch> {
    tube(rings.map(|([x, z], radius, [along_x, along_z])| {
        let across = DVec3::new(-along_z, 0.0, along_x).normalize();
        [DVec3::new(x, 0.0, z), DVec3::Y * radius, across * radius]
    }))
}

/// Its patches, as a device reads them.
pub fn pot() -> Vec<Patch> {
    let turned = PROFILE.into_iter().flat_map(|piece| {
        tube(piece.map(|[radius, z]| [DVec3::Z * z, DVec3::X * radius, DVec3::Y * radius]))
    });
    let all = turned.chain(bent_tube(SPOUT)).chain(bent_tube(HANDLE));
    all.map(|patch| patch.rounded()).collect()
}

/// Where it is looked at, metres.
pub const POT_MIDDLE: DVec3 = DVec3::new(0.02, 0.0, 0.72);

/// From where it is seen: all of it, from a little above.
pub fn pot_view() -> GridCamera {
    let eye = DVec3::new(1.6, -4.3, 2.4);
    GridCamera::looking(eye, POT_MIDDLE, 0.33)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest sine of the angle between the tangent planes of two patches along a side that they share.
    fn kink(one: &Patch, other: &Patch, side: impl Fn(f64) -> [DVec2; 2]) -> f64 {
        let normal = |patch: &Patch, at| {
            let [across, down] = patch.slopes(at);
            across.cross(down).normalize()
        };
        let shares = (1..10).map(|share| f64::from(share) / 10.0);
        let kinks = shares.map(|share| {
            let [first, second] = side(share);
            let gap = (one.place(first) - other.place(second)).length();
            assert!(gap < 1e-7, "{gap}");
            normal(one, first).cross(normal(other, second)).length()
        });
        kinks.fold(0.0, f64::max)
    }

    #[test]
    fn patches_join_smoothly_around_and_along_the_profile() {
        let patches = pot();
        assert_eq!(patches.len(), 40);
        let around = |share| [DVec2::new(1.0, share), DVec2::new(0.0, share)];
        let along = |share| [DVec2::new(share, 1.0), DVec2::new(share, 0.0)];
        for first in (0..patches.len()).step_by(4) {
            for turned in 0..4 {
                let next = &patches[first + (turned + 1) % 4];
                let found = kink(&patches[first + turned], next, around);
                assert!(found < 1e-5, "{first} {turned}: {found}");
            }
        }
        for first in 0..4 * (PROFILE.len() - 1) {
            let found = kink(&patches[first], &patches[first + 4], along);
            assert!(found < 1e-5, "{first}: {found}");
        }
        // Negative control: a control point beside the joint is moved.
        let mut moved = patches[5];
        moved.0[1][1] *= 1.05;
        assert!(kink(&patches[1], &moved, along) > 1e-3);
    }
}
