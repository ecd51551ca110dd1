// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a stencil would hold: triangles of the volumes counted along the ray of each pixel's centre.
//!
//! Homogeneous edge functions (Olano & Greer, 1997). A triangle's corners relative to the eye are vectors
//! v = place − w·eye. The ray lies inside where det(ray, vᵢ, vⱼ) has one sign for all edges. An edge
//! has the same bits from both of its triangles, so that no ray slips between them. The depth of a lit
//! surface and that of its light cap come from one expression and are equal: equal depth fails.

use crate::reference::{Light, Seen, Truth};
use crate::scissor::around;
use crate::view::{DeckCamera, whole};
use glam::{DVec3, DVec4};
use terrafill_casters::{Mesh, Volume};
use terrafill_plan::PixelRect;

terrafill_results::named! {
    /// Which faces count.
    all pub enum Rule {
        /// Front faces that pass +1, back faces that pass −1.
        Pass = "z-pass",
        /// Back faces that fail +1, front faces that fail −1.
        Fail = "z-fail",
        /// All backwards first, then those that pass forwards.
        Preload = "preload",
        /// As printed in the paper: front faces that pass +1, back faces that **fail** −1.
        PassAsPrinted = "z-pass as printed",
    }
}

impl Rule {
    /// What a fragment adds, and how often it writes.
    fn adds(self, is_front: bool, passes: bool) -> (i32, u64) {
        let way = if is_front { 1 } else { -1 };
        match (self, passes) {
            (Self::Pass, true) => (way, 1),
            (Self::Fail, false) => (-way, 1),
            (Self::Preload, true) => (0, 2),
            (Self::Preload, false) => (-way, 1),
            (Self::PassAsPrinted, _) if passes == is_front => (way, 1),
            _ => (0, 0),
        }
    }
}

/// A stencil after all volumes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stencil {
    /// Unbounded counts.
    pub counts: Vec<i32>,
    /// Stencil writes.
    pub updates: u64,
}

impl Stencil {
    /// Draws volumes, where what is seen lies between the depths of the pass.
    pub fn of(view: &DeckCamera, mesh: &Mesh, volume: &Volume, truth: &Truth, pass: &Pass) -> Self {
        let mut stencil = Self {
            counts: vec![0; view.pixel_count()],
            updates: 0,
        };
        let depths = depths(view, mesh, truth);
        for triangle in &volume.triangles {
            let part = triangle.part as usize;
            let Some((rule, rectangle)) = pass.parts[part] else {
                continue;
            };
            let places = triangle
                .corners
                .map(|corner| volume.vertices[corner as usize]);
            let spanned = Spanned::new(view.eye, places, triangle.corners);
            if spanned.volume == 0.0 {
                continue;
            }
            let seen = around(view, &spanned.corners).within(rectangle);
            let bounds = pass.bounds.get(part);
            fill(view, &spanned, seen, |at, depth, is_front| {
                if bounds.is_some_and(|[near, far]| !(*near..=*far).contains(&depths[at])) {
                    return;
                }
                let (add, writes) = rule.adds(is_front, depth < depths[at]);
                stencil.counts[at] += add;
                stencil.updates += writes;
            });
        }
        stencil
    }

    /// Which pixels are in shadow where a count has 8 bits and wraps.
    pub fn mask(&self) -> Vec<bool> {
        self.counts
            .iter()
            .map(|count| count.rem_euclid(256) != 0)
            .collect()
    }
}

/// What is counted together.
pub struct Pass {
    /// How each part's volume is drawn: `None` for not at all.
    pub parts: Vec<Option<(Rule, PixelRect)>>,
    /// Of each part the depths of what is seen, m, nearest and farthest; empty for all.
    pub bounds: Vec<[f64; 2]>,
}

/// Pixels by what is wrong with them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Wrong {
    /// Lit where the reference has shadow, outside the band.
    pub false_lit: usize,
    /// In shadow where the reference is lit, outside the band.
    pub false_dark: usize,
    /// Either, in the band.
    pub in_band: usize,
    /// Either, outside the band, where a device's rounding alone may make the difference.
    pub at_rims: usize,
}

impl Wrong {
    /// Those outside the band that no rounding excuses.
    pub fn outside(self) -> usize {
        self.false_lit + self.false_dark
    }

    /// Those in the band too.
    pub fn all(self) -> usize {
        self.outside() + self.in_band
    }

    /// Both, of two pictures.
    pub fn plus(self, other: Self) -> Self {
        Self {
            false_lit: self.false_lit + other.false_lit,
            false_dark: self.false_dark + other.false_dark,
            in_band: self.in_band + other.in_band,
            at_rims: self.at_rims + other.at_rims,
        }
    }

    /// A mask against the reference; what it cannot decide is not counted.
    pub fn of(mask: &[bool], truth: &Truth) -> Self {
        Self::but_at_rims(mask, truth, |_, _| false)
    }

    /// Pixels outside the band in which a mask is not the reference's, in order, and the light that it has there.
    pub fn outside_band(mask: &[bool], truth: &Truth) -> Vec<(usize, Light)> {
        let mut found = Vec::new();
        Self::but_at_rims(mask, truth, |at, light| {
            found.push((at, light));
            false
        });
        found
    }

    /// The same of a device, which rounds.
    ///
    /// - `is_rim`: whether rounding may give that pixel this light; asked in order of pixels outside the band
    pub fn but_at_rims(
        mask: &[bool],
        truth: &Truth,
        mut is_rim: impl FnMut(usize, Light) -> bool,
    ) -> Self {
        let mut wrong = Self::default();
        for (at, &is_dark) in mask.iter().enumerate() {
            let (count, drawn) = match (truth.light[at], is_dark) {
                (Light::Lit, true) => (&mut wrong.false_dark, Light::Shadow),
                (Light::Shadow, false) => (&mut wrong.false_lit, Light::Lit),
                _ => continue,
            };
            match truth.band[at] {
                true => wrong.in_band += 1,
                false if is_rim(at, drawn) => wrong.at_rims += 1,
                false => *count += 1,
            }
        }
        wrong
    }
}

/// A triangle as the eye has it, its corners by rising index: the same bits whichever way it is wound.
struct Spanned {
    /// Places relative to the eye; a direction for a corner at infinity.
    corners: [DVec3; 3],
    weights: [f64; 3],
    /// Normals of the planes through the eye and each edge, opposite to the corner of its index.
    edges: [DVec3; 3],
    volume: f64,
    /// Whether the order by index is the other way round.
    is_turned: bool,
}

/// Which of the edges opposite to the corners lead from the lower to the higher index.
const IS_FORWARD: [bool; 3] = [true, false, true];

impl Spanned {
    fn new(eye: DVec3, places: [DVec4; 3], corners: [u32; 3]) -> Self {
        let mut order = [0, 1, 2];
        order.sort_by_key(|at| corners[*at]);
        let places = order.map(|at| places[at]);
        let [a, b, c] = places.map(|place| place.truncate() - eye * place.w);
        let edges = [b.cross(c), c.cross(a), a.cross(b)];
        Self {
            volume: a.dot(edges[0]),
            corners: [a, b, c],
            weights: places.map(|place| place.w),
            edges,
            is_turned: !matches!(order, [0, 1, 2] | [1, 2, 0] | [2, 0, 1]),
        }
    }

    /// Depth along a ray that is 1 m deep a unit.
    fn depth(&self, ray: DVec3) -> f64 {
        let shares = self.edges.map(|edge| edge.dot(ray));
        let weight: f64 = shares
            .iter()
            .zip(self.weights)
            .map(|(share, weight)| share * weight)
            .sum();
        // Of places at infinity alone, or along the ray.
        if weight == 0.0 {
            return f64::INFINITY;
        }
        self.volume / weight
    }

    fn is_inside(&self, ray: DVec3, is_positive: bool) -> bool {
        self.edges.iter().zip(IS_FORWARD).all(|(edge, is_forward)| {
            let share = edge.dot(ray);
            // On the edge itself: on the positive side of it as told from its lower vertex.
            let is_on_positive = share > 0.0 || share == 0.0 && is_forward;
            is_on_positive == is_positive
        })
    }
}

/// Of each pixel, whether its centre lies in a triangle of the volumes that is thin there: along a row, a column or a
/// diagonal it ends on both sides of the centre.
///
/// Corners are rounded to 1/256 of a pixel: such a triangle may be seen from either side, or from neither. Two passes
/// that each leave out one side then leave it out twice, as llvmpipe does.
///
/// - `beside_px`: within so many columns and rows of the centre
pub fn slivers(view: &DeckCamera, volume: &Volume, beside_px: f64) -> Vec<bool> {
    let mut held = vec![false; view.pixel_count()];
    for triangle in &volume.triangles {
        let places = triangle
            .corners
            .map(|corner| volume.vertices[corner as usize]);
        let spanned = Spanned::new(view.eye, places, triangle.corners);
        if spanned.volume == 0.0 {
            continue;
        }
        let is_positive = spanned.volume > 0.0;
        let seen = around(view, &spanned.corners);
        fill(view, &spanned, seen, |at, _, _| {
            let [column, row] = view.pixel(at);
            let is_inside = |way: [f64; 2], side_px: f64| {
                let beside = way.map(|steps| steps * side_px);
                spanned.is_inside(view.ray_beside(column, row, beside), is_positive)
            };
            let ways = [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, -1.0]];
            held[at] |= ways
                .into_iter()
                .any(|way| !is_inside(way, beside_px) && !is_inside(way, -beside_px));
        });
    }
    held
}

/// Depths of what is seen, by the expression that volumes use.
fn depths(view: &DeckCamera, mesh: &Mesh, truth: &Truth) -> Vec<f64> {
    let width = view.size[0];
    let depth = |(at, seen): (u32, &Seen)| match seen {
        Seen::Sky => f64::INFINITY,
        Seen::Sea(depth) => *depth,
        Seen::Triangle(triangle, _) => {
            let corners = mesh.triangles[*triangle as usize];
            let places = mesh
                .corners(*triangle as usize)
                .map(|place| place.extend(1.0));
            Spanned::new(view.eye, places, corners).depth(view.ray(at % width, at / width))
        }
    };
    (0..).zip(&truth.seen).map(depth).collect()
}

/// Every pixel's centre inside a triangle beyond the near plane.
fn fill(
    view: &DeckCamera,
    spanned: &Spanned,
    seen: PixelRect,
    mut fragment: impl FnMut(usize, f64, bool),
) {
    // Inside, the shares have the sign that their sum over places before the eye has.
    let is_positive = spanned.volume > 0.0;
    for row in seen.top..seen.bottom {
        let columns = span(view, spanned, row, [seen.left, seen.right], is_positive);
        for column in columns[0]..columns[1] {
            let ray = view.ray(column, row);
            if !spanned.is_inside(ray, is_positive) {
                continue;
            }
            let depth = spanned.depth(ray);
            if depth >= view.near {
                let at = row as usize * view.size[0] as usize + column as usize;
                fragment(at, depth, is_positive == spanned.is_turned);
            }
        }
    }
}

/// Columns of a row that may lie inside, a pixel more on either side: shares are linear along a row.
fn span(
    view: &DeckCamera,
    spanned: &Spanned,
    row: u32,
    columns: [u32; 2],
    is_positive: bool,
) -> [u32; 2] {
    let (start, step) = (view.ray(0, row), view.ray(1, row) - view.ray(0, row));
    let [mut low, mut high] = columns.map(f64::from);
    for edge in &spanned.edges {
        let sign = if is_positive { 1.0 } else { -1.0 };
        let (at_start, slope) = (sign * edge.dot(start), sign * edge.dot(step));
        if slope > 0.0 {
            low = low.max(-at_start / slope - 1.0);
        } else if slope < 0.0 {
            high = high.min(-at_start / slope + 2.0);
        }
    }
    let [first, past] = columns.map(f64::from);
    [low, high].map(|end| whole(end.clamp(first, past)))
}

#[cfg(test)]
mod tests;
