// SPDX-License-Identifier: MIT OR Apache-2.0
//! Views of the controllers: an eye straight above the body, its radii in closed form, and what rays see of a range of
//! stored vertices, in `f64`.

use super::rule::{Counted, Drawn, Limits, PER_TURN, WANTED_PX};
use crate::made::spiral::{Law, Spiral, number_of, per_octave, stored_radius};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::Range;
use terrafill_globe_views::{Eye, SNAPPED_PX, ViewRow};
use terrafill_reference::SurfaceTriangles;

/// Pixels a side.
pub(super) const SIDE_PX: u32 = 256;
/// Height of the eye at first, metres, and frames in which it doubles: a second of 60.
const HEIGHT_M: f64 = 1e5;
const DOUBLING_FRAMES: f64 = 60.0;

/// An eye, where its spiral is, and its radii.
pub(super) struct View {
    pub(super) eye: Eye,
    pub(super) spiral: Spiral,
    pub(super) limits: Limits,
}

/// East, north and down from a focus to every stored vertex, in radii.
pub(super) fn stored() -> Vec<DVec3> {
    let last = number_of(FRAC_PI_2, PER_TURN) + 2 * PER_TURN;
    let vertices = (0..=last).map(|k| {
        let (sin, cos) = (TAU * f64::from(k % PER_TURN) / f64::from(PER_TURN)).sin_cos();
        let radius = stored_radius(k, PER_TURN);
        let level = radius.sin();
        DVec3::new(level * sin, level * cos, 2.0 * (0.5 * radius).sin().powi(2))
    });
    vertices.collect()
}

/// Both radii of a view in closed form: the rim of a fan with the wanted pixels, and the picture's farthest corner.
fn limits(eye: &Eye) -> Limits {
    let body = SurfaceTriangles::of_body(&eye.body, eye.camera.eye_ecef);
    let scaled = eye.camera.eye_ecef / eye.body.radii_m();
    // From the focus to what a place of the picture shows; the body fills it.
    let angle = |at: DVec2| {
        let direction = eye.camera.direction_ecef(eye.size, at.to_array());
        let depth = body.hit(direction, eye.camera.near_m).unwrap_or(0.0);
        let place = scaled + direction * depth / eye.body.radii_m();
        scaled.cross(place).length().atan2(scaled.dot(place))
    };
    let turn = f64::from(PER_TURN);
    // Area of a fan whose first vertex is at radius 1: its last triangle ends on that one again.
    let grows = per_octave(PER_TURN).recip().exp2();
    let edges: f64 = (0..PER_TURN - 1)
        .map(|k| grows.powf(2.0 * f64::from(k) + 1.0))
        .sum();
    let area = 0.5 * (TAU / turn).sin() * (edges + grows.powf(turn - 1.0));
    let middle = DVec2::splat(0.5 * f64::from(SIDE_PX));
    let rim = DVec2::new((WANTED_PX as f64 / area).sqrt(), 0.0);
    let corners = [(0.0, 0.0), (0.0, 2.0), (2.0, 0.0), (2.0, 2.0)];
    let corner = corners.map(|(x, y)| angle(middle * DVec2::new(x, y)));
    let corner = corner.into_iter().fold(0.0, f64::max);
    Limits {
        fan: angle(middle + rim),
        // Chords of a turn are nearer than its vertices.
        outer: (corner.tan() / (PI / turn).cos()).atan(),
    }
}

impl View {
    /// - `frame`: of an eye that rises; 0 for one at rest
    pub(super) fn new(frame: usize) -> Self {
        let row = ViewRow {
            longitude_deg: 15.0,
            latitude_deg: 45.0,
            height_m: HEIGHT_M * (frame as f64 / DOUBLING_FRAMES).exp2(),
            pitch_deg: -90.0,
            ..ViewRow::default()
        };
        let eye = row.eye(SIDE_PX);
        Self {
            spiral: Spiral::new(&eye, PER_TURN, Law::Exponential, None),
            limits: limits(&eye),
            eye,
        }
    }

    /// Where a vertex, or the focus, is on the screen.
    fn px(&self, vertex: Option<DVec3>) -> DVec2 {
        let [east, north, up] = self.spiral.axes;
        let way = vertex.map_or(DVec3::ZERO, |at| east * at.x + north * at.y - up * at.z);
        let place = self.eye.camera.eye_ecef + self.spiral.focus + way;
        let px = self.eye.camera.project_px(self.eye.size, place);
        // All are in front of an eye that looks straight down.
        px.map_or(DVec2::NAN, DVec2::from)
    }

    /// What rays through the pixels' centres see.
    pub(super) fn seen(&self, stored: &[DVec3], drawn: Drawn) -> Seen {
        let at = |k: u32| self.px(stored.get(k as usize).copied());
        let n = PER_TURN;
        let middle = self.px(None);
        let Drawn { first, last } = drawn;
        let px: Vec<DVec2> = (first..=last + n).map(at).collect();
        let at = |k: u32| px[(k - first) as usize];
        let mut picture = Picture::default();
        for k in first..first + n - 1 {
            picture.draw(1, [middle, at(k + 1), at(k)]);
        }
        picture.draw(1, [middle, at(first), at(first + n - 1)]);
        picture.draw(2, [at(first), at(first + n), at(first + n - 1)]);
        for k in first..last {
            picture.draw(2, [at(k), at(k + 1), at(k + n)]);
            picture.draw(2, [at(k + 1), at(k + n + 1), at(k + n)]);
        }
        // Rims of the fan and of all: vertices of a turn, the last joined to the first.
        let rim = |from: u32, to: u32| {
            let joined = [at(to), at(from)];
            let edges = (from..to).map(|k| [at(k), at(k + 1)]);
            edges.chain([joined]).collect::<Vec<_>>()
        };
        let near = |edges: Vec<[DVec2; 2]>| {
            let mut near = vec![false; PIXELS];
            for edge in edges {
                beside(edge, |pixel| near[pixel] = true);
            }
            near
        };
        picture.seen(&near(rim(first, first + n - 1)), &near(rim(last, last + n)))
    }
}

const PIXELS: usize = (SIDE_PX * SIDE_PX) as usize;

/// What each pixel shows: nothing, the fan, or turns.
struct Picture(Vec<u8>);

impl Default for Picture {
    fn default() -> Self {
        Self(vec![0; PIXELS])
    }
}

/// Pixels along an axis whose centres lie between two places.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "within the picture"
)]
fn pixels_between(from: f64, to: f64) -> Range<usize> {
    let side = f64::from(SIDE_PX);
    let [from, to] = [from, to].map(|at| (at - 0.5).ceil().clamp(0.0, side) as usize);
    from..to
}

/// Pixels whose centres lie in a box, with their centres.
fn in_box(low: DVec2, high: DVec2, mut each: impl FnMut(usize, DVec2)) {
    for row in pixels_between(low.y, high.y) {
        for column in pixels_between(low.x, high.x) {
            let centre = DVec2::new(column as f64, row as f64) + 0.5;
            each(row * SIDE_PX as usize + column, centre);
        }
    }
}

/// Pixels whose centres a device's rounding of corners may put on either side of an edge.
fn beside([a, b]: [DVec2; 2], mut each: impl FnMut(usize)) {
    let along = b - a;
    in_box(a.min(b) - 1.0, a.max(b) + 1.0, |pixel, centre| {
        let share = ((centre - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        if centre.distance(a + share * along) < SNAPPED_PX {
            each(pixel);
        }
    });
}

impl Picture {
    /// A ray meets a triangle in front of the eye where its pixel is within the triangle's corners.
    fn draw(&mut self, of: u8, [a, b, c]: [DVec2; 3]) {
        let edges = [[a, b], [b, c], [c, a]];
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        in_box(low, high + 1e-9, |pixel, centre| {
            let sides = edges.map(|[from, to]| (to - from).perp_dot(centre - from));
            if sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0) {
                self.0[pixel] = of;
            }
        });
    }

    fn seen(&self, near_fan: &[bool], near_rim: &[bool]) -> Seen {
        let mut seen = Seen::default();
        let middle = DVec2::splat(0.5 * f64::from(SIDE_PX));
        in_box(DVec2::ZERO, 2.0 * middle, |pixel, centre| {
            let mut add = |[least, most]: [bool; 2], which: usize| {
                seen.least[which] += u64::from(least);
                seen.most[which] += u64::from(most);
            };
            let (of, fan, rim) = (self.0[pixel], near_fan[pixel], near_rim[pixel]);
            add([of == 1 && !fan, of == 1 || fan], 0);
            add([of > 0 && !rim, of > 0 || rim], 1);
            if of == 0 {
                let bare = middle.length() - centre.distance(middle);
                seen.diagonal_px = seen.diagonal_px.max(bare);
            }
        });
        seen
    }
}

/// Pixels of the fan and of all that is drawn: the least and the most that a device's rounding of corners allows. And how
/// far from a corner towards the middle a bare pixel lies, at most.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Seen {
    least: [u64; 2],
    most: [u64; 2],
    pub(super) diagonal_px: f64,
}

impl Seen {
    /// Whether a device's count is one of those.
    pub(super) fn allows(&self, counted: Counted) -> bool {
        let found = [counted.fan, counted.all];
        (0..2).all(|i| (self.least[i]..=self.most[i]).contains(&found[i]))
    }

    /// Pixels in which rounding decides.
    pub(super) fn band_px(&self) -> u64 {
        (0..2).map(|i| self.most[i] - self.least[i]).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_covers_the_corners_and_a_fan_has_the_wanted_pixels() {
        let stored = stored();
        for frame in [0, 60, 179] {
            let view = View::new(frame);
            let drawn = view.limits.drawn();
            let seen = view.seen(&stored, drawn);
            let off = seen.most[0] as f64 / WANTED_PX as f64 - 1.0;
            assert_eq!((seen.least[1], seen.diagonal_px), (PIXELS as u64, 0.0));
            assert!(off.abs() < 0.02, "{off}");
            // Negative controls: half of the radius has a quarter of the pixels, and with half a turn less corners are bare.
            let octave = 254;
            let [smaller, bare] = [[octave, 0], [0, PER_TURN / 2]].map(|[first, last]| Drawn {
                first: drawn.first - first,
                last: drawn.last - last,
            });
            let quarter = view.seen(&stored, smaller).most[0] as f64 / seen.most[0] as f64;
            assert!((quarter - 0.25).abs() < 0.01, "{quarter}");
            let bare = view.seen(&stored, bare);
            assert!(bare.most[1] < PIXELS as u64 && bare.diagonal_px > 0.5);
        }
    }

    #[test]
    fn a_count_that_is_off_by_one_pixel_is_noticed() {
        let stored = stored();
        let view = View::new(0);
        let mut without_band = 0;
        for first in 0..20 {
            let Drawn { first: from, last } = view.limits.drawn();
            let seen = view.seen(
                &stored,
                Drawn {
                    first: from + first,
                    last,
                },
            );
            let [fan, all] = seen.least;
            assert!(
                seen.allows(Counted { fan, all }) && !seen.allows(Counted { fan: fan - 1, all })
            );
            assert!(!seen.allows(Counted { fan, all: all - 1 }));
            let more = Counted { fan: fan + 1, all };
            // Within the band rounding decides; outside it a pixel more is one too many.
            assert_eq!(seen.allows(more), seen.most[0] > fan);
            without_band += u32::from(seen.band_px() == 0);
        }
        assert!(without_band > 0);
    }
}
