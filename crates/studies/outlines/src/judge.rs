// SPDX-License-Identifier: MIT OR Apache-2.0
//! What pixels must show, in `f64`: the method played through at the middle of each pixel, model after model.
//!
//! A model owns a pixel where its nearest face is nearer than what is there. A stroke then covers what lies within half
//! its width of a contour edge, at the depth of the nearest point of that edge. It is kept where it is nearer than what is
//! there and the model does not own the pixel. Owners are known by number: no value repeats.
//!
//! Devices round. Where a border lies within [`BAND_PX`] of the middle, or two depths within what explains, both outcomes
//! are followed. A pixel may show what any of them leaves. Facing is one sign a triangle from its own corners, contours
//! are the borders that one lit triangle has: no plane, table or matrix of what is drawn is used.

use crate::fleet::Fleet;
use glam::{DVec2, DVec3};
use terrafill_casters::{Facing, Side, by_hash};
use terrafill_shapes::rays::{BAND_PX, EQUAL_DEPTH, distance_to_triangle};

/// What a picture shows where nothing is.
pub(crate) const NOTHING: u32 = 0;

/// Number that a model's faces show, or its strokes.
pub(crate) fn number(model: u32, is_stroke: bool) -> u32 {
    2 * model + 1 + u32::from(is_stroke)
}

fn is_stroke(shown: u32) -> bool {
    shown != NOTHING && shown.is_multiple_of(2)
}

/// What one model's faces, or its strokes, have at a pixel: depths, metres.
#[derive(Debug, Clone, Copy)]
struct Layer {
    near: f64,
    /// Of all that may be there.
    far: f64,
    /// The nearest of what is there whatever the rounding; infinite for nothing.
    sure: f64,
}

impl Layer {
    fn new([near, far]: [f64; 2], is_sure: bool) -> Self {
        let sure = if is_sure { far } else { f64::INFINITY };
        Self { near, far, sure }
    }

    fn with(self, other: Self) -> Self {
        Self {
            near: self.near.min(other.near),
            far: self.far.max(other.far),
            sure: self.sure.min(other.sure),
        }
    }
}

/// An outcome that rounding allows: what is shown, who owns the pixel, and its depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Outcome {
    pub(crate) shown: u32,
    /// The model, [`NOTHING`] for none, else one more than its place.
    owner: u32,
    depths: [f64; 2],
}

const EMPTY: Outcome = Outcome {
    shown: NOTHING,
    owner: NOTHING,
    depths: [f64::INFINITY; 2],
};

/// What pixels show that they must not.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Judged {
    /// Pixels that show a stroke and may not.
    pub(crate) inside: usize,
    /// Pixels that show no stroke, or another model's, and must show one.
    pub(crate) missing: usize,
    /// Other pixels that show a model, or none, and may not.
    pub(crate) others: usize,
    /// Of each pixel.
    pub(crate) wrong: Vec<bool>,
}

impl Judged {
    pub(crate) fn all(&self) -> usize {
        self.inside + self.missing + self.others
    }
}

/// Values of a layer, by pixel.
struct Scratch<T> {
    values: Vec<Option<T>>,
    touched: Vec<usize>,
}

impl<T: Copy> Scratch<T> {
    fn new(pixels: usize) -> Self {
        let values = vec![None; pixels];
        let touched = Vec::new();
        Self { values, touched }
    }

    fn add(&mut self, pixel: usize, value: T, with: impl Fn(T, T) -> T) {
        let own = &mut self.values[pixel];
        if own.is_none() {
            self.touched.push(pixel);
        }
        *own = Some(own.map_or(value, |before| with(before, value)));
    }

    fn take(&mut self, mut each: impl FnMut(usize, T)) {
        for pixel in self.touched.drain(..) {
            if let Some(value) = self.values[pixel].take() {
                each(pixel, value);
            }
        }
    }
}

/// A place on the picture, pixels, and its depth along the view's axis, metres.
type Projected = (DVec2, f64);

/// Every pixel's outcomes for strokes of a width.
pub(crate) struct Truth {
    width: u32,
    pub(crate) pixels: Vec<Vec<Outcome>>,
}

impl Truth {
    /// - `width_px`: of strokes; 0 draws none
    pub(crate) fn new(fleet: &Fleet, width_px: f64) -> Self {
        let count = fleet.camera.pixel_count();
        let (mesh, eye) = (&fleet.mesh, fleet.camera.eye);
        let is_front = |triangle| {
            let [a, b, c] = mesh.corners(triangle);
            (b - a).cross(c - a).dot(eye - a) > 0.0
        };
        let facing = Facing {
            is_lit: (0..mesh.triangles.len()).map(is_front).collect(),
        };
        let mut contours: Vec<Vec<Side>> = vec![Vec::new(); mesh.parts.len()];
        for side in by_hash(mesh, &facing) {
            let is_before =
                |part: &terrafill_casters::ConvexPart| part.vertices.end <= side[0] as usize;
            contours[mesh.parts.partition_point(is_before)].push(side);
        }
        let mut truth = Self {
            width: fleet.camera.size[0],
            pixels: vec![vec![EMPTY]; count],
        };
        let (mut layers, mut of_part) = (Scratch::new(count), Scratch::new(count));
        for (model, at) in (0..).zip(0..mesh.casters.len()) {
            for part in fleet.parts_before(at) {
                truth.faces(fleet, part, &facing, &mut of_part);
                // A convex body's picture ends at its contour, and nowhere else.
                for side in &contours[part] {
                    truth.along(fleet, *side, BAND_PX, |pixel, _, _| {
                        if let Some(layer) = &mut of_part.values[pixel] {
                            *layer = Layer {
                                sure: f64::INFINITY,
                                ..*layer
                            };
                        }
                    });
                }
                of_part.take(|pixel, layer| layers.add(pixel, layer, Layer::with));
            }
            let owner = model + 1;
            layers.take(|pixel, layer| {
                truth.lay(pixel, layer, number(model, false), |_| Some(owner));
            });
            let half = width_px / 2.0;
            if half == 0.0 {
                continue;
            }
            for part in fleet.parts_before(at) {
                for side in &contours[part] {
                    truth.along(fleet, *side, half + BAND_PX, |pixel, distance, depths| {
                        let layer = Layer::new(depths, distance <= half - BAND_PX);
                        layers.add(pixel, layer, Layer::with);
                    });
                }
            }
            layers.take(|pixel, layer| {
                truth.lay(pixel, layer, number(model, true), |before| {
                    (before != owner).then_some(before)
                });
            });
        }
        truth
    }

    /// Follows every outcome of a layer at a pixel.
    ///
    /// - `owner`: who owns the pixel where the layer is kept, by who owns it before; `None` where the stencil drops it
    fn lay(&mut self, pixel: usize, layer: Layer, shown: u32, owner: impl Fn(u32) -> Option<u32>) {
        let mut after: Vec<Outcome> = Vec::new();
        let mut add = |outcome: Outcome| {
            let is_same =
                |own: &&mut Outcome| (own.shown, own.owner) == (outcome.shown, outcome.owner);
            match after.iter_mut().find(is_same) {
                Some(own) => {
                    let [near, far] = outcome.depths;
                    own.depths = [own.depths[0].min(near), own.depths[1].max(far)];
                }
                None => after.push(outcome),
            }
        };
        for before in &self.pixels[pixel] {
            let kept = owner(before.owner);
            let [near, far] = before.depths;
            if let Some(owner) = kept
                && layer.near < far
            {
                let depths = [
                    layer.near,
                    layer.far.min(layer.sure).min(far).max(layer.near),
                ];
                add(Outcome {
                    shown,
                    owner,
                    depths,
                });
            }
            if kept.is_none() || layer.sure >= near {
                add(*before);
            }
        }
        self.pixels[pixel] = after;
    }

    /// Adds what front faces of a part have at every pixel whose middle may lie in one.
    fn faces(&self, fleet: &Fleet, part: usize, facing: &Facing, layers: &mut Scratch<Layer>) {
        for triangle in fleet.mesh.parts[part].triangles.clone() {
            if !facing.is_lit[triangle] {
                continue;
            }
            let corners = fleet
                .mesh
                .corners(triangle)
                .map(|place| project(fleet, place));
            let places = corners.map(|corner| corner.0);
            self.near_to(&places, BAND_PX, |pixel, at| {
                if distance_to_triangle(at, places) <= BAND_PX {
                    let layer = Layer::new(depths(at, corners), true);
                    let both = |a: Layer, b: Layer| {
                        let far = a.far.max(b.far);
                        Layer::new([a.near.min(b.near), far], true)
                    };
                    layers.add(pixel, layer, both);
                }
            });
        }
    }

    /// Calls `each` with every pixel whose middle lies so near to an edge: its distance, and depths of the nearest point.
    fn along(
        &self,
        fleet: &Fleet,
        side: Side,
        reach: f64,
        mut each: impl FnMut(usize, f64, [f64; 2]),
    ) {
        let ends = side.map(|end| project(fleet, fleet.mesh.vertices[end as usize]));
        let [(from, near), (to, far)] = ends;
        let along = to - from;
        let length = along.length();
        self.near_to(&[from, to], reach, |pixel, at| {
            let share = |slack: f64| {
                let along = (at - from).dot(along) / length + slack;
                (along / length).clamp(0.0, 1.0)
            };
            // NaN where the edge is seen end on: then either end may be the nearest.
            let shares = [share(-BAND_PX), share(BAND_PX)];
            let [low, high] = if length > 0.0 { shares } else { [0.0, 1.0] };
            let middle = if length > 0.0 { share(0.0) } else { 0.0 };
            let distance = at.distance(from + along * middle);
            if distance <= reach {
                let depth = |share: f64| 1.0 / ((1.0 - share) / near + share / far);
                each(pixel, distance, widened([depth(low), depth(high)]));
            }
        });
    }

    /// Calls `each` with pixels of a box around places, and their middles.
    fn near_to(&self, places: &[DVec2], reach: f64, mut each: impl FnMut(usize, DVec2)) {
        let none = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let around = places.iter();
        let [low, high] = around.fold(none, |[low, high], place| {
            [low.min(*place), high.max(*place)]
        });
        let width = self.width as usize;
        let height = self.pixels.len() / width;
        #[allow(clippy::cast_possible_truncation, reason = "held within the picture")]
        let range = |low: f64, high: f64, size: usize| {
            let held = |at: f64| at.clamp(0.0, size as f64) as usize;
            held((low - reach - 0.5).ceil())..held((high + reach - 0.5).floor() + 1.0)
        };
        for row in range(low.y, high.y, height) {
            for column in range(low.x, high.x, width) {
                each(
                    row * width + column,
                    DVec2::new(column as f64, row as f64) + 0.5,
                );
            }
        }
    }

    /// Holds a picture of numbers against it.
    pub(crate) fn judge(&self, numbers: &[u32]) -> Judged {
        let mut judged = Judged::default();
        for (outcomes, &shown) in self.pixels.iter().zip(numbers) {
            let is_wrong = outcomes.iter().all(|outcome| outcome.shown != shown);
            judged.wrong.push(is_wrong);
            if is_wrong {
                let must = outcomes.iter().all(|outcome| is_stroke(outcome.shown));
                let count = match (must, is_stroke(shown)) {
                    (true, _) => &mut judged.missing,
                    (false, true) => &mut judged.inside,
                    (false, false) => &mut judged.others,
                };
                *count += 1;
            }
        }
        judged
    }

    /// Pixels that must show a stroke, and pixels that may show more than one number.
    pub(crate) fn counts(&self) -> [usize; 2] {
        let shown = |outcomes: &Vec<Outcome>| {
            let first = outcomes[0].shown;
            let is_decided = outcomes.iter().all(|own| own.shown == first);
            is_decided.then_some(first)
        };
        let all = self.pixels.iter().map(shown);
        let strokes = all.clone().flatten().filter(|shown| is_stroke(*shown));
        [strokes.count(), all.filter(Option::is_none).count()]
    }
}

fn project(fleet: &Fleet, place: DVec3) -> Projected {
    let camera = &fleet.camera;
    let from_eye = place - camera.eye;
    let depth = from_eye.dot(camera.forward);
    let [x, y] = [camera.right, camera.up].map(|axis| from_eye.dot(axis) / depth);
    let device = DVec2::new(x / camera.tan[0], -y / camera.tan[1]);
    let size = DVec2::from(camera.size.map(f64::from));
    ((device + 1.0) / 2.0 * size, depth)
}

/// Two depths in order, with what `f32` cannot tell from them.
fn widened([a, b]: [f64; 2]) -> [f64; 2] {
    [
        a.min(b) * (1.0 - EQUAL_DEPTH),
        a.max(b) * (1.0 + EQUAL_DEPTH),
    ]
}

/// Depths that a triangle may have within the band of a place: the inverse of depth is flat over the picture.
fn depths(at: DVec2, corners: [Projected; 3]) -> [f64; 2] {
    let [(a, near), (b, second), (c, third)] = corners;
    let [low, high] = [f64::min, f64::max].map(|of| of(of(near, second), third));
    let (ab, ac) = (b - a, c - a);
    let (by_b, by_c) = (1.0 / second - 1.0 / near, 1.0 / third - 1.0 / near);
    let slope = (DVec2::new(ac.y, -ac.x) * by_b + DVec2::new(-ab.y, ab.x) * by_c) / ab.perp_dot(ac);
    let slack = 2.0 * BAND_PX * slope.length();
    let inverse = 1.0 / near + slope.dot(at - a);
    let held = |inverse: f64| (1.0 / inverse).clamp(low, high);
    // Seen edge-on it has any depth of its corners.
    if !slack.is_finite() || inverse <= slack {
        return widened([low, high]);
    }
    widened([held(inverse + slack), held(inverse - slack)])
}
