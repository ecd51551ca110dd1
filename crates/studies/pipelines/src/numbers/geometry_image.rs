// SPDX-License-Identifier: MIT OR Apache-2.0
//! Geometry images: a closed shape as a square of positions, its cells cut one way or the other, its
//! positions in few bits; `f64`, metres.
//!
//! The published image of a bunny does not ship, so the shape is analytic: a bumpy ball of radius
//! 1 + 0.2 sin 3x cos 4y + 0.1 sin 7z over directions (x, y, z), about 2.2 m across. The square is folded
//! onto an octahedron (Praun and Hoppe, 2003): its diagonals from middle to middle of the sides become
//! edges there, so the cut of a cell matters.

use glam::{DVec2, DVec3};

/// Across the shape, metres, which fill a picture of so many pixels.
const EXTENT_M: f64 = 2.2;
const PICTURE_PX: f64 = 1_024.0;

terrafill_results::named! {
    /// How cells are cut.
    all pub(super) enum CellCut {
        /// From (x + 1, y) to (x, y + 1) everywhere, as a strip of the published order cuts.
        Published = "published",
        /// Along the fold of the octahedron in every quarter.
        Fold = "fold",
    }
}

/// How positions are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Texels {
    /// As they are.
    Exact,
    /// Whole numbers of so many bits over the box of the shape.
    Bits(u32),
    /// 16-bit floats about the middle of the shape.
    HalfAboutCentre,
    /// 16-bit floats over the box of the shape, 0 to 1.
    HalfInBox,
}

impl Texels {
    pub(super) const ROUNDED: [Self; 7] = [
        Self::Bits(8),
        Self::Bits(10),
        Self::Bits(12),
        Self::Bits(14),
        Self::Bits(16),
        Self::HalfAboutCentre,
        Self::HalfInBox,
    ];

    pub(super) fn name(self) -> String {
        match self {
            Self::Exact => "f64".to_owned(),
            Self::Bits(bits) => format!("{bits} bits"),
            Self::HalfAboutCentre => "f16 about the centre".to_owned(),
            Self::HalfInBox => "f16 in 0 to 1".to_owned(),
        }
    }
}

/// What an image misses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ImageError {
    /// Largest distance from the shape along its normal, at seven points of each triangle.
    pub(super) max_m: f64,
    pub(super) rms_m: f64,
    /// Angle between the facet's normal and the shape's at its middle, weighted by area.
    pub(super) normal_rms_deg: f64,
    /// Texels of the border that are not where their partner is: cracks.
    pub(super) open_texels: usize,
}

impl ImageError {
    pub(super) fn max_px(&self) -> f64 {
        self.max_m / EXTENT_M * PICTURE_PX
    }
}

/// Radius of the shape in a direction of length 1.
fn radius(u: DVec3) -> f64 {
    1.0 + 0.2 * (3.0 * u.x).sin() * (4.0 * u.y).cos() + 0.1 * (7.0 * u.z).sin()
}

/// How far a place is above the shape along its ray, and the gradient of that.
fn above(place: DVec3) -> (f64, DVec3) {
    let length = place.length();
    let u = place / length;
    let by_direction = DVec3::new(
        0.6 * (3.0 * u.x).cos() * (4.0 * u.y).cos(),
        -0.8 * (3.0 * u.x).sin() * (4.0 * u.y).sin(),
        0.7 * (7.0 * u.z).cos(),
    );
    // A direction changes with the part of a step that is across the ray.
    let across = (by_direction - u * by_direction.dot(u)) / length;
    (length - radius(u), u - across)
}

/// Distance from the shape along its normal, by two steps of Newton's.
fn distance_m(place: DVec3) -> f64 {
    let (height, gradient) = above(place);
    let normal = gradient.normalize();
    let first = height / gradient.length();
    let (rest, gradient) = above(place - normal * first);
    (first + rest / gradient.dot(normal)).abs()
}

fn normal(place: DVec3) -> DVec3 {
    above(place).1.normalize()
}

/// Direction at a place of the square, both from −1 to 1.
fn direction(at: DVec2) -> DVec3 {
    let z = 1.0 - at.x.abs() - at.y.abs();
    let folded = if z < 0.0 {
        let away = |a: f64, b: f64| (1.0 - b.abs()) * if a < 0.0 { -1.0 } else { 1.0 };
        DVec2::new(away(at.x, at.y), away(at.y, at.x))
    } else {
        at
    };
    folded.extend(z).normalize()
}

/// Nearest 16-bit float.
fn half(value: f64) -> f64 {
    // Ten bits after the first; below 2⁻¹⁴ steps stay as they are.
    let step = value.abs().max(2.0_f64.powi(-14)).log2().floor() - 10.0;
    let step = step.exp2();
    (value / step).round_ties_even() * step
}

/// Positions of an image, row by row.
fn image(texels_a_side: u32, stored: Texels) -> Vec<DVec3> {
    let last = f64::from(texels_a_side - 1);
    let place = |index: u32| -1.0 + 2.0 * f64::from(index) / last;
    let rows = 0..texels_a_side;
    let mut positions: Vec<DVec3> = rows
        .flat_map(|y| (0..texels_a_side).map(move |x| (x, y)))
        .map(|(x, y)| {
            let u = direction(DVec2::new(place(x), place(y)));
            u * radius(u)
        })
        .collect();
    let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = positions
        .iter()
        .copied()
        .fold(DVec3::NEG_INFINITY, DVec3::max);
    let span = high - low;
    for position in &mut positions {
        let in_box = (*position - low) / span;
        *position = match stored {
            Texels::Exact => *position,
            Texels::Bits(bits) => {
                let steps = f64::from(bits).exp2() - 1.0;
                low + span * (in_box * steps).round() / steps
            }
            Texels::HalfAboutCentre => {
                let centre = 0.5 * (low + high);
                centre + (*position - centre).map(half)
            }
            Texels::HalfInBox => low + span * in_box.map(half),
        };
    }
    positions
}

/// Texels of the sides that are not where the one is that they are folded onto.
fn open_texels(positions: &[DVec3], texels_a_side: usize) -> usize {
    let last = texels_a_side - 1;
    let at = |x: usize, y: usize| positions[y * texels_a_side + x];
    let is_open = |index: usize, edge: usize| {
        let other = last - index;
        [
            at(index, edge) != at(other, edge),
            at(edge, index) != at(edge, other),
        ]
    };
    let all = (0..texels_a_side).flat_map(|index| [0, last].map(|edge| is_open(index, edge)));
    all.flatten().filter(|is_open| *is_open).count()
}

/// What the triangles of an image miss.
pub(super) fn image_error(texels_a_side: u32, cut: CellCut, stored: Texels) -> ImageError {
    let positions = image(texels_a_side, stored);
    let side = texels_a_side as usize;
    let at = |x: usize, y: usize| positions[y * side + x];
    let (mut max_m, mut squares, mut places) = (0.0_f64, 0.0, 0.0);
    let (mut turned, mut areas) = (0.0, 0.0);
    let mut judge = |corners: [DVec3; 3]| {
        for weights in WEIGHTS {
            let place: DVec3 = corners.iter().zip(weights).map(|(c, w)| *c * w).sum();
            let distance = distance_m(place);
            max_m = max_m.max(distance);
            squares += distance * distance;
            places += 1.0;
        }
        let [a, b, c] = corners;
        let across = (b - a).cross(c - a);
        let area = across.length();
        // A triangle without area has no normal.
        if area > 0.0 {
            let middle = (a + b + c) / 3.0;
            // Both ways round: the square is mirrored where it is folded over.
            let cosine = (across.dot(normal(middle)) / area).abs().min(1.0);
            turned += area * cosine.acos().powi(2);
            areas += area;
        }
    };
    let middle = (side - 1) / 2;
    for y in 0..side - 1 {
        for x in 0..side - 1 {
            let corners = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
            let [near, right, below, far] = corners;
            // Folds run from (x + 1, y) to (x, y + 1) where both halves of the square are the same.
            let is_published = cut == CellCut::Published || (x < middle) == (y < middle);
            if is_published {
                judge([near, right, below]);
                judge([far, below, right]);
            } else {
                judge([near, right, far]);
                judge([near, far, below]);
            }
        }
    }
    ImageError {
        max_m,
        rms_m: (squares / places).sqrt(),
        normal_rms_deg: (turned / areas).sqrt().to_degrees(),
        open_texels: open_texels(&positions, side),
    }
}

/// Seven places of a triangle: its middle, those of its sides, and towards each corner.
const WEIGHTS: [[f64; 3]; 7] = [
    [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
    [2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
];

#[test]
fn the_gradient_is_that_of_differences() {
    for place in [DVec3::new(0.7, 0.5, -0.9), DVec3::new(-1.2, 0.3, 0.1)] {
        let (height, gradient) = above(place);
        for axis in DVec3::AXES {
            const STEP: f64 = 1e-6;
            let difference = (above(place + axis * STEP).0 - height) / STEP;
            assert!((difference - gradient.dot(axis)).abs() < 1e-5, "{axis}");
        }
        // Negative control: half the gradient is noticed.
        let difference = (above(place + DVec3::X * 1e-6).0 - height) / 1e-6;
        assert!((difference - 0.5 * gradient.x).abs() > 1e-3);
    }
}

#[test]
fn distances_are_those_along_the_normal() {
    let u = DVec3::new(0.3, -0.8, 0.5).normalize();
    let on = u * radius(u);
    let off = on + normal(on) * 0.003;
    assert!((distance_m(off) - 0.003).abs() < 1e-5);
    assert!(distance_m(on) < 1e-12);
}

#[test]
fn errors_fall_to_a_quarter_and_the_fold_is_better() {
    let of = |texels, cut| image_error(texels, cut, Texels::Exact);
    for cut in CellCut::ALL {
        let [coarse, fine] = [65, 129].map(|texels| of(texels, cut));
        let ratio = coarse.max_m / fine.max_m;
        assert!((ratio - 4.0).abs() <= 0.2, "{cut:?}: {ratio}");
        assert_eq!(coarse.open_texels, 0);
    }
    let [published, fold] = CellCut::ALL.map(|cut| of(129, cut));
    let gain = published.max_m / fold.max_m;
    assert!(gain >= 2.5, "{gain}");
    let gain = published.normal_rms_deg / fold.normal_rms_deg;
    assert!(gain > 3.0, "{gain}");
    // Negative control: the fold's cut in the other quarters is worse than none.
    assert!(published.max_m > 1.5 * fold.max_m);
}

#[test]
fn coarse_positions_are_noticed_and_an_open_border_is_counted() {
    let of = |stored| image_error(129, CellCut::Fold, stored);
    let [few, many] = [8, 16].map(|bits| of(Texels::Bits(bits)));
    assert!(few.max_m > 4.0 * many.max_m, "{few:?} {many:?}");
    assert!(few.normal_rms_deg > 5.0 * many.normal_rms_deg);
    assert_eq!((few.open_texels, many.open_texels), (0, 0));
    let mut positions = image(9, Texels::Exact);
    assert_eq!(open_texels(&positions, 9), 0);
    positions[3].x += 1e-12;
    // Both of the pair.
    assert_eq!(open_texels(&positions, 9), 2);
}

#[test]
fn halves_are_those_of_the_format() {
    for (value, expected) in [
        (1.0, 1.0),
        (1.0 + 2.0_f64.powi(-11), 1.0),
        (1.0 + 3.0 * 2.0_f64.powi(-11), 1.0 + 2.0_f64.powi(-9)),
        (-0.1, -0.099_975_585_937_5),
        (2.0_f64.powi(-24), 2.0_f64.powi(-24)),
        (2.0_f64.powi(-26), 0.0),
    ] {
        assert!((half(value) - expected).abs() < 1e-18, "{value}");
    }
}
