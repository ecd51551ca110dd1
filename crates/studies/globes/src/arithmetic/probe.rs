// SPDX-License-Identifier: MIT OR Apache-2.0
//! The outer radius of the spiral, found by trying. Nothing is counted beyond the edges of the screen, so a mesh that is
//! larger than it needs to be shows as many pixels as one that just fills the screen. The paper's controller therefore
//! shrinks the mesh until pixels are missing, and then lets it grow again.
//!
//! Here the eye looks straight down, and the mesh is a disc about the middle of the screen: its corners go bare first.

/// How a mesh tries its outer radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OuterProbe {
    /// Half of the screen's sides, pixels.
    pub(super) half_px: [f64; 2],
    /// Frames from drawing to using a count, as in [`constant_step`](super::radius::constant_step).
    pub(super) delay: usize,
    /// Share of the radius that is given up in a frame which shows no bare pixel, and taken in one that does.
    pub(super) step: f64,
    /// By how much a frame's radius on the screen falls because the eye rises: 0 for one that stands still.
    pub(super) rising: f64,
}

impl OuterProbe {
    /// From the middle of the screen to its corners, pixels: what a mesh in closed form has for its radius.
    pub(super) fn corner_px(&self) -> f64 {
        self.half_px[0].hypot(self.half_px[1])
    }

    /// Pixels that a disc about the middle of the screen leaves bare.
    pub(super) fn bare_area_px(&self, radius_px: f64) -> f64 {
        let [a, b] = self.half_px;
        if radius_px >= self.corner_px() {
            return 0.0;
        }
        // A quarter of the screen within the disc: a rectangle, and the area below the arc beside it.
        let squared = radius_px * radius_px;
        let from = (squared - b * b).max(0.0).sqrt().min(a);
        let to = a.min(radius_px);
        let below_arc = |x: f64| {
            let height = (squared - x * x).max(0.0).sqrt();
            0.5 * (x * height + squared * x.atan2(height))
        };
        let within = b * from + below_arc(to) - below_arc(from);
        4.0 * (a * b - within)
    }

    /// Radius over that of the corners, frame by frame, from one that just fills the screen.
    pub(super) fn course(&self, frames: usize) -> Vec<f64> {
        let corner = self.corner_px();
        let mut radii = vec![1.0];
        for frame in 0..frames {
            let counted = radii[frame.saturating_sub(self.delay)];
            // A count is of whole pixels.
            let change = if self.bare_area_px(counted * corner) < 1.0 {
                1.0 - self.step
            } else {
                1.0 / (1.0 - self.step)
            };
            radii.push(radii[frame] * change * (1.0 - self.rising));
        }
        radii
    }

    /// How far a corner goes bare in the second half of a course, pixels.
    pub(super) fn bare_px(&self, frames: usize) -> f64 {
        let course = self.course(frames);
        let late = course[frames / 2..].iter();
        let least = late.copied().fold(f64::INFINITY, f64::min);
        self.corner_px() * (1.0 - least).max(0.0)
    }
}

/// The picture of the facts' figure, and the share of the radius that a mesh gives up in a frame.
pub(super) const PROBED: OuterProbe = OuterProbe {
    half_px: [960.0, 540.0],
    delay: 1,
    step: 0.01,
    rising: 0.0,
};

#[test]
fn bare_corners_are_those_that_pixels_show() {
    for radius_px in [300.0, 540.0, 800.0, 960.0, 1000.0, 1090.0, 1101.0, 1102.0] {
        let mut bare = 0.0;
        for y in 0..540 {
            for x in 0..960 {
                let [x, y] = [x, y].map(|at| f64::from(at) + 0.5);
                bare += f64::from(u8::from(x.hypot(y) > radius_px));
            }
        }
        let found = PROBED.bare_area_px(radius_px);
        assert!(
            (found - 4.0 * bare).abs() < 600.0 && found >= 0.0,
            "{radius_px}: {found}, {bare}"
        );
    }
    // Negative controls: none beyond the corner, all without a radius.
    assert_eq!(PROBED.bare_area_px(1101.5), 0.0);
    assert!((PROBED.bare_area_px(0.0) - 1920.0 * 1080.0).abs() < 1e-6);
}
