// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of texels' addresses, judged in `f64`: against the triangles as drawn, which must agree, and against the exact
//! projection, from which they may differ.
//!
//! A pixel shows the triangle over its centre whose depth is the nearest. Another texel is allowed where one within
//! [`BAND_PX`] of the centre has it, since devices snap vertices. Every other difference is an error.

use crate::divided::{Corner, Divided, TEXELS};
use crate::place::{RADIUS_M, Shape};
use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;
use terrafill_shapes::rays::{BAND_PX, EQUAL_DEPTH, Judged, around, centres, distance_to_triangle};

/// A side of a tile of the picture, whose triangles are listed.
const TILE_PX: u32 = 8;
/// Share of a texel by which interpolation in `f32` may be off: 2⁻²⁴ of 1,024 texels, a few hundred times.
const TEXEL_SLACK: f64 = 1.0 / 32.0;
/// Of what is before the horizon: 2⁻²⁴, a few times.
const HORIZON_SLACK: f64 = 1e-6;

/// A triangle, for places of the picture.
struct Facet {
    corners: [Corner; 3],
    /// From (x, y, 1) in clip space to shares of the corners.
    inverse: DMat3,
    /// On the picture, pixels.
    at_px: [DVec2; 3],
}

/// What a place of the picture shows.
#[derive(Debug, Clone, Copy)]
struct Hit {
    share: DVec2,
    depth: f64,
    /// Whether rounding may decide that it is not shown.
    is_unsure: bool,
}

/// Triangles as drawn, for all places of the picture.
pub(crate) struct Reference<'a> {
    divided: &'a Divided,
    /// Whether the body's depth hides what is behind it.
    has_body: bool,
    facets: Vec<Facet>,
    /// Of the tiles, row by row.
    tiles: Vec<Vec<u32>>,
}

impl<'a> Reference<'a> {
    /// - `corners`: three a triangle, [`Divided::corners`] or as the device has them
    pub(crate) fn new(divided: &'a Divided, corners: &[Corner]) -> Self {
        let eye = &divided.eye;
        let facet = |corners: &[Corner]| {
            let corners = [corners[0], corners[1], corners[2]];
            let columns = corners.map(|of| DVec3::new(of.clip.x, of.clip.y, of.clip.w));
            Facet {
                inverse: DMat3::from_cols(columns[0], columns[1], columns[2]).inverse(),
                at_px: corners.map(|of| eye.pixel(of.clip)),
                corners,
            }
        };
        let facets: Vec<Facet> = corners.chunks_exact(3).map(facet).collect();
        let across = eye.side.div_ceil(TILE_PX);
        let mut tiles = vec![Vec::new(); (across * across) as usize];
        for (number, facet) in (0..).zip(&facets) {
            let [a, b, c] = facet.at_px;
            let tile = |at: DVec2| {
                let last = f64::from(across - 1);
                #[allow(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "held between 0 and the last"
                )]
                let tile = [at.x, at.y].map(|at| (at / f64::from(TILE_PX)).clamp(0.0, last) as u32);
                tile
            };
            let [left, top] = tile(a.min(b).min(c) - 1.0);
            let [right, bottom] = tile(a.max(b).max(c) + 1.0);
            for row in top..=bottom {
                for column in left..=right {
                    tiles[(row * across + column) as usize].push(number);
                }
            }
        }
        Self {
            divided,
            has_body: divided.is_tested,
            facets,
            tiles,
        }
    }

    /// The same triangles where the body hides what is behind it, or nothing.
    pub(crate) fn with_body(self, has_body: bool) -> Self {
        Self { has_body, ..self }
    }

    /// Pixels that show data: those that do all over the band about their centre, and those that may.
    pub(crate) fn counts(&self) -> [u64; 2] {
        let places: Vec<DVec2> = centres(self.divided.eye.size()).collect();
        let one = |at: &DVec2| {
            let hits = || around(BAND_PX).map(|off| self.hit(*at + off));
            let is_sure = hits().all(|hit| hit.is_some_and(|hit| !hit.is_unsure));
            [
                u64::from(is_sure),
                u64::from(hits().any(|hit| hit.is_some())),
            ]
        };
        let all = places.par_iter().map(one);
        all.reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]])
    }

    /// Triangles that may be at a place.
    fn listed(&self, at_px: DVec2) -> impl Iterator<Item = &Facet> {
        let side = f64::from(self.divided.eye.side);
        let inside = at_px.clamp(DVec2::ZERO, DVec2::splat(side - 0.5));
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "inside the picture"
        )]
        let [column, row] = [inside.x, inside.y].map(|at| at as u32 / TILE_PX);
        let across = self.divided.eye.side.div_ceil(TILE_PX);
        let listed = &self.tiles[(row * across + column) as usize];
        listed.iter().map(|number| &self.facets[*number as usize])
    }

    fn hit(&self, at_px: DVec2) -> Option<Hit> {
        let eye = &self.divided.eye;
        let place = eye.device(at_px).extend(1.0);
        let body = self.has_body.then(|| eye.body_depth(at_px)).flatten();
        let hits = self.listed(at_px).filter_map(|facet| {
            let weights = facet.inverse * place;
            let sum = weights.element_sum();
            let is_inside = weights.min_element() >= -1e-9 * weights.abs().max_element();
            if !(is_inside && sum > 0.0 && sum.is_finite()) {
                return None;
            }
            let mean = |of: fn(&Corner) -> f64| {
                let parts = facet.corners.iter().zip(weights.to_array());
                parts
                    .map(|(corner, weight)| of(corner) * weight)
                    .sum::<f64>()
            };
            let before = mean(|of| of.before) / sum;
            let depth = mean(|of| of.clip.z);
            let behind = body.map_or(-1.0, |body| body / depth - 1.0);
            let is_shown = before >= 0.0 && behind < 0.0;
            let is_unsure = before.abs() < HORIZON_SLACK || behind.abs() < EQUAL_DEPTH;
            (is_shown || is_unsure).then(|| Hit {
                share: DVec2::new(mean(|of| of.share.x), mean(|of| of.share.y)) / sum,
                depth: if is_shown { depth } else { f64::MIN_POSITIVE },
                is_unsure,
            })
        });
        hits.reduce(|first, next| {
            if next.depth > first.depth {
                next
            } else {
                first
            }
        })
    }

    /// What the centre of each pixel shows, as it is drawn: shares of the data, row by row.
    pub(crate) fn picture(&self) -> Vec<Option<DVec2>> {
        let places: Vec<DVec2> = centres(self.divided.eye.size()).collect();
        let shown = |at: &DVec2| {
            let hit = self.hit(*at).filter(|hit| hit.depth > f64::MIN_POSITIVE);
            hit.map(|hit| hit.share)
        };
        places.par_iter().map(shown).collect()
    }

    fn number_of(&self, share: DVec2) -> u32 {
        number(self.divided.data.shape, [share.x, share.y].map(texel))
    }

    /// Whether a pixel may show this, within the band.
    fn may_show(&self, at: DVec2, shown: u32) -> bool {
        let hits: Vec<Option<Hit>> = around(BAND_PX).map(|off| self.hit(at + off)).collect();
        if shown == 0 {
            return hits.iter().any(|hit| hit.is_none_or(|hit| hit.is_unsure));
        }
        let Some([x, y]) = texels(self.divided.data.shape, shown) else {
            return false;
        };
        let is_within = |low: DVec2, high: DVec2| {
            let slack = TEXEL_SLACK / f64::from(TEXELS);
            let range = |low: f64, high: f64| texel(low - slack)..=texel(high + slack);
            let is_line = matches!(self.divided.data.shape, Shape::Line(_));
            range(low.x, high.x).contains(&x) && (is_line || range(low.y, high.y).contains(&y))
        };
        let shares = || hits.iter().flatten().map(|hit| hit.share);
        let low = shares().reduce(DVec2::min);
        let high = shares().reduce(DVec2::max);
        let is_seen = low
            .zip(high)
            .is_some_and(|(low, high)| is_within(low, high));
        // Narrower than the band, it may lie between the places that were tried.
        is_seen
            || self.listed(at).any(|facet| {
                let shares = facet.corners.map(|of| of.share);
                let low = shares[0].min(shares[1]).min(shares[2]);
                let high = shares[0].max(shares[1]).max(shares[2]);
                let is_thin = facet.corners.iter().any(|of| of.before.abs() < 1.0)
                    && hits.iter().any(Option::is_none);
                is_thin && is_within(low, high) && distance_to_triangle(at, facet.at_px) <= BAND_PX
            })
    }

    /// Holds a picture against the triangles.
    ///
    /// - `truth`: [`Reference::picture`]
    pub(crate) fn judge(&self, numbers: &[u32], truth: &[Option<DVec2>]) -> Judged {
        let places: Vec<DVec2> = centres(self.divided.eye.size()).collect();
        let pixel = |((at, shown), share): ((&DVec2, &u32), &Option<DVec2>)| {
            let met = share.map_or(0, |share| self.number_of(share));
            (met, met == *shown || self.may_show(*at, *shown))
        };
        let pixels = places.par_iter().zip(numbers).zip(truth);
        let all: Vec<(u32, bool)> = pixels.map(pixel).collect();
        let mut judged = Judged::default();
        for (shown, (met, may)) in numbers.iter().zip(all) {
            judged.add(*shown, met, || may);
        }
        judged
    }
}

/// Of a share of a side.
fn texel(share: f64) -> u32 {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "held between 0 and the last texel"
    )]
    let texel = (share * f64::from(TEXELS))
        .floor()
        .clamp(0.0, f64::from(TEXELS - 1)) as u32;
    texel
}

/// Number that a picture shows of a texel, from 1 on.
pub(crate) fn number(shape: Shape, [x, y]: [u32; 2]) -> u32 {
    match shape {
        Shape::Decal(_) => 1 + y * TEXELS + x,
        Shape::Line(_) => 1 + x,
    }
}

/// Texel of a number; none of 0 and of what is no texel.
pub(crate) fn texels(shape: Shape, number: u32) -> Option<[u32; 2]> {
    let index = number.checked_sub(1)?;
    let [x, y] = [index % TEXELS, index / TEXELS];
    let rows = if matches!(shape, Shape::Line(_)) {
        1
    } else {
        TEXELS
    };
    (y < rows).then_some([x, y])
}

/// How far a picture is off the exact projection.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Errors {
    /// Of each pixel that shows data: from its centre to where the texel that it shows belongs, pixels. Sorted.
    pub(crate) off_px: Vec<f64>,
    /// Pixels that show data where the exact projection has none, and the reverse.
    pub(crate) extra: u64,
    pub(crate) missing: u64,
}

impl Errors {
    /// Of a decal: a pixel's ray meets the body, and the place there has an address.
    ///
    /// - `drawn`: [`Reference::picture`], which says where in its texel a pixel is
    pub(crate) fn of_decal(divided: &Divided, numbers: &[u32], drawn: &[Option<DVec2>]) -> Self {
        let Divided { data, eye, .. } = divided;
        let places: Vec<DVec2> = centres(eye.size()).collect();
        let one = |((at_px, shown), drawn): ((&DVec2, &u32), &Option<DVec2>)| {
            let truth = eye.shown(*at_px).and_then(|at| data.share_of(at));
            let inside = |share: DVec2| share.min_element() >= 0.0 && share.max_element() <= 1.0;
            let is_there = truth.is_some_and(inside);
            let Some([x, y]) = texels(data.shape, *shown) else {
                return (None, [0, u64::from(is_there)]);
            };
            let low = DVec2::new(f64::from(x), f64::from(y)) / f64::from(TEXELS);
            let high = low + 1.0 / f64::from(TEXELS);
            let within = drawn.or(truth).unwrap_or(low).clamp(low, high);
            let place = data.direction(within) * RADIUS_M;
            let belongs = eye.pixel(eye.clip(place, data.angles(within)));
            (Some(belongs.distance(*at_px)), [u64::from(!is_there), 0])
        };
        let all: Vec<_> = places.par_iter().zip(numbers).zip(drawn).map(one).collect();
        let mut errors = Self::default();
        for (off, [extra, missing]) in all {
            errors.off_px.extend(off);
            errors.extra += extra;
            errors.missing += missing;
        }
        errors.off_px.sort_by(f64::total_cmp);
        errors
    }

    /// Of a line: each shown pixel's distance from the exact line, less half of its width.
    pub(crate) fn of_line(divided: &Divided, numbers: &[u32]) -> Self {
        const PARTS: u32 = 4_096;
        let Divided { data, eye, .. } = divided;
        let exact: Vec<DVec2> = (0..=PARTS)
            .map(|part| DVec2::X * f64::from(part) / f64::from(PARTS))
            .map(|share| eye.pixel(eye.clip(data.direction(share) * RADIUS_M, data.angles(share))))
            .collect();
        let places: Vec<DVec2> = centres(eye.size()).collect();
        let shown = places
            .par_iter()
            .zip(numbers)
            .filter(|(_, shown)| **shown != 0);
        let off = shown.map(|(at, _)| {
            let segments = exact.windows(2).map(|ends| {
                let side = ends[1] - ends[0];
                let share =
                    (*at - ends[0]).dot(side) / side.length_squared().max(f64::MIN_POSITIVE);
                (*at - ends[0] - side * share.clamp(0.0, 1.0)).length_squared()
            });
            let nearest = segments.fold(f64::INFINITY, f64::min).sqrt();
            (nearest - 0.5 * crate::divided::WIDTH_PX).max(0.0)
        });
        let mut off_px: Vec<f64> = off.collect();
        off_px.sort_by(f64::total_cmp);
        Self {
            off_px,
            ..Self::default()
        }
    }

    /// Largest, 99 % and median; none where nothing is shown.
    pub(crate) fn spread(&self) -> Option<[f64; 3]> {
        let last = self.off_px.len().checked_sub(1)?;
        Some([last, last * 99 / 100, last / 2].map(|at| self.off_px[at]))
    }
}
