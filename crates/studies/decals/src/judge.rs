// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of texels' addresses, judged in `f64`: against the triangles as drawn, which must agree, and against the exact
//! projection, from which they may differ.
//!
//! A pixel shows the triangle over its centre whose depth is the nearest. Another texel is allowed where one within
//! [`BAND_PX`] of the centre has it, since devices snap vertices. Every other difference is an error.

use crate::divided::{Corner, Divided, FINE_PX, TEXELS, WIDTH_PX};
use crate::place::{RADIUS_M, Shape};
use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;
use terrafill_shapes::rays::{self, BAND_PX, EQUAL_DEPTH, Judged, around, centres, is_thin_at};

/// A side of a tile of the picture, whose triangles are listed.
const TILE_PX: u32 = 8;
/// Share of a texel by which interpolation in `f32` may be off: 2⁻²⁴ of 1,024 texels, a few hundred times.
const TEXEL_SLACK: f64 = 1.0 / 32.0;
/// Of what is before the horizon: 2⁻²⁴, a few times.
const HORIZON_SLACK: f64 = 1e-6;

/// Number that a picture shows of the body itself, where it is drawn: behind all texels'.
pub(crate) const BODY: u32 = 1 + TEXELS * TEXELS;

/// A triangle, for places of the picture.
struct Facet {
    corners: [Corner; 3],
    /// From (x, y, 1) in clip space to shares of the corners.
    inverse: DMat3,
    /// On the picture, pixels.
    at_px: [DVec2; 3],
}

impl Facet {
    /// Share of the data at a place of the picture, or at the border where the place is beyond it.
    ///
    /// - `place`: in clip space
    fn nearest_share(&self, place: DVec3) -> Option<DVec2> {
        let weights = (self.inverse * place).max(DVec3::ZERO);
        let sum = weights.element_sum();
        let parts = self.corners.iter().zip(weights.to_array());
        let share = parts
            .map(|(corner, weight)| corner.share * weight)
            .sum::<DVec2>()
            / sum;
        share.is_finite().then_some(share)
    }
}

/// What a place of the picture shows.
#[derive(Debug, Clone, Copy)]
struct Hit {
    facet: u32,
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
            if self.hit(*at).is_some_and(|hit| self.is_all_of(&hit, *at)) {
                return [1; 2];
            }
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

    /// Whether a triangle has all of the band about a place, where nothing hides it.
    fn is_all_of(&self, hit: &Hit, at: DVec2) -> bool {
        let facet = &self.facets[hit.facet as usize];
        let is_before = facet.corners.iter().all(|of| of.before >= HORIZON_SLACK);
        let has = |off| (facet.inverse * self.place(at + off)).min_element() >= 0.0;
        !self.has_body && is_before && around(BAND_PX).all(has)
    }

    /// Triangles that may be at a place.
    fn listed(&self, at_px: DVec2) -> impl Iterator<Item = (u32, &Facet)> {
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
        listed
            .iter()
            .map(|number| (*number, &self.facets[*number as usize]))
    }

    fn place(&self, at_px: DVec2) -> DVec3 {
        self.divided.eye.device(at_px).extend(1.0)
    }

    fn hit(&self, at_px: DVec2) -> Option<Hit> {
        let eye = &self.divided.eye;
        let place = self.place(at_px);
        let body = self.has_body.then(|| eye.body_depth(at_px)).flatten();
        let hits = self.listed(at_px).filter_map(|(number, facet)| {
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
                facet: number,
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

    /// Number of what is there without data.
    fn under(&self, at_px: DVec2) -> u32 {
        let is_body = self.has_body && self.divided.eye.body_depth(at_px).is_some();
        if is_body { BODY } else { 0 }
    }

    /// Whether a pixel may show this, within the band.
    fn may_show(&self, at: DVec2, shown: u32) -> bool {
        let hits: Vec<Option<Hit>> = around(BAND_PX).map(|off| self.hit(at + off)).collect();
        if shown == 0 || shown == BODY {
            let mut open = around(BAND_PX)
                .zip(&hits)
                .filter(|(_, hit)| hit.is_none_or(|hit| hit.is_unsure));
            return open.any(|(off, _)| self.under(at + off) == shown);
        }
        let Some([x, y]) = texels(self.divided.data.shape, shown) else {
            return false;
        };
        let is_line = matches!(self.divided.data.shape, Shape::Line(_));
        let is_within = |shares: &[DVec2]| {
            let slack = TEXEL_SLACK / f64::from(TEXELS);
            let low = shares
                .iter()
                .copied()
                .reduce(DVec2::min)
                .unwrap_or_default();
            let high = shares
                .iter()
                .copied()
                .reduce(DVec2::max)
                .unwrap_or_default();
            let range = |low: f64, high: f64| texel(low - slack)..=texel(high + slack);
            range(low.x, high.x).contains(&x) && (is_line || range(low.y, high.y).contains(&y))
        };
        // Only what a single triangle has within the band: two that lie far apart in the data allow nothing between them.
        let away = |hit: Hit| rays::Hit {
            number: hit.facet,
            away_m: hit.depth.recip(),
        };
        let met: Vec<_> = hits.iter().map(|hit| hit.map(away)).collect();
        self.listed(at).any(|(number, facet)| {
            if hits.iter().flatten().any(|hit| hit.facet == number) {
                let shares =
                    around(BAND_PX).filter_map(|off| facet.nearest_share(self.place(at + off)));
                return is_within(&shares.collect::<Vec<_>>());
            }
            // Narrower than the band, it may lie between the places that were tried.
            let corner = |of: usize| {
                let clip = facet.corners[of].clip;
                (facet.at_px[of], clip.w / clip.z)
            };
            let is_before = facet.corners.iter().any(|of| of.before >= -HORIZON_SLACK);
            is_before
                && is_thin_at(at, [0, 1, 2].map(corner), &met)
                && is_within(&facet.corners.map(|of| of.share))
        })
    }

    /// Holds a picture against the triangles.
    ///
    /// - `truth`: [`Reference::picture`]
    pub(crate) fn judge(&self, numbers: &[u32], truth: &[Option<DVec2>]) -> Judged {
        let places: Vec<DVec2> = centres(self.divided.eye.size()).collect();
        let pixel = |((at, shown), share): ((&DVec2, &u32), &Option<DVec2>)| {
            let met = share.map_or_else(|| self.under(*at), |share| self.number_of(share));
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
    /// Of each pixel that shows data: from its centre to where what it shows belongs. Of each that shows none and should,
    /// where no depth hides it: how far within the exact decal it is, or beside the shown line. Pixels, sorted.
    pub(crate) off_px: Vec<f64>,
    /// Pixels that show data where the exact projection has none, and the reverse.
    pub(crate) extra: u64,
    pub(crate) missing: u64,
}

impl Errors {
    /// Of a decal: a pixel's ray meets the body, and the place there has an address.
    ///
    /// - `drawn`: [`Reference::picture`], which says where in its texel a pixel is
    /// - `exact`: as of [`exact`]
    pub(crate) fn of_decal(
        divided: &Divided,
        numbers: &[u32],
        drawn: &[Option<DVec2>],
        exact: &[Option<DVec2>],
    ) -> Self {
        let Divided { data, eye, .. } = divided;
        let places: Vec<DVec2> = centres(eye.size()).collect();
        let inside = |share: DVec2| share.min_element() >= 0.0 && share.max_element() <= 1.0;
        type Pixel<'a> = ((&'a DVec2, &'a u32), (&'a Option<DVec2>, &'a Option<DVec2>));
        let one = |((at_px, shown), (drawn, truth)): Pixel<'_>| {
            let is_there = truth.is_some_and(inside);
            let Some([x, y]) = texels(data.shape, *shown) else {
                let has = |at: DVec2| {
                    eye.shown(at)
                        .and_then(|at| data.share_of(at))
                        .is_some_and(inside)
                };
                let is_open = is_there && !divided.is_tested;
                let within = is_open.then(|| within_px(*at_px, 0.01 * f64::from(eye.side), has));
                return (within, [0, u64::from(is_there)]);
            };
            let low = DVec2::new(f64::from(x), f64::from(y)) / f64::from(TEXELS);
            let high = low + 1.0 / f64::from(TEXELS);
            // In the band along their border triangles may have none: then a pixel counts as in its texel's middle.
            let within = drawn.unwrap_or(0.5 * (low + high)).clamp(low, high);
            let place = data.direction(within) * RADIUS_M;
            let belongs = eye.pixel(eye.clip(place, data.angles(within)));
            (Some(belongs.distance(*at_px)), [u64::from(!is_there), 0])
        };
        let truths = drawn.par_iter().zip(exact);
        let all: Vec<_> = places
            .par_iter()
            .zip(numbers)
            .zip(truths)
            .map(one)
            .collect();
        let mut errors = Self::default();
        for (off, [extra, missing]) in all {
            errors.off_px.extend(off);
            errors.extra += extra;
            errors.missing += missing;
        }
        errors.off_px.sort_by(f64::total_cmp);
        errors
    }

    /// Of a line. Of each pixel that shows a part: how far it is from there, less half of the width. Of each pixel of the
    /// exact ribbon that shows nothing: how far the nearest is that does, less the distance of neighbours, since ribbons
    /// gape at their bends. The exact ribbon ends at the horizon, and straight at the line's ends.
    pub(crate) fn of_line(divided: &Divided, numbers: &[u32]) -> Self {
        /// Sides of the exact line for each part that pictures tell apart.
        const SIDES: u32 = 4;
        const HALF_PX: f64 = 0.5 * WIDTH_PX;
        let Divided { data, eye, .. } = divided;
        let last = SIDES * TEXELS;
        let exact: Vec<(DVec2, bool)> = (0..=last)
            .map(|at| {
                let share = DVec2::X * f64::from(at) / f64::from(last);
                let place = data.direction(share) * RADIUS_M;
                let is_before = eye.horizon().dot(place.extend(1.0)) >= 0.0;
                (eye.pixel(eye.clip(place, data.angles(share))), is_before)
            })
            .collect();
        // From a place to a side: its distance, and where the nearest place is along it, within it from 0 to 1.
        let from_side = |at: DVec2, number: usize| {
            let [(start, _), (end, _)] = [exact[number], exact[number + 1]];
            let side = end - start;
            let along = (at - start).dot(side) / side.length_squared().max(f64::MIN_POSITIVE);
            ((at - start - side * along.clamp(0.0, 1.0)).length(), along)
        };
        let side_px = eye.side as usize;
        let mut nearest = vec![f64::INFINITY; numbers.len()];
        for (number, ends) in exact.windows(2).enumerate() {
            let [(start, is_seen), (end, is_end_seen)] = [ends[0], ends[1]];
            if !(is_seen && is_end_seen) {
                continue;
            }
            let size = DVec2::splat(f64::from(eye.side));
            let low = (start.min(end) - HALF_PX)
                .clamp(DVec2::ZERO, size)
                .as_usizevec2();
            let high = (start.max(end) + HALF_PX)
                .ceil()
                .clamp(DVec2::ZERO, size)
                .as_usizevec2();
            for y in low.y..high.y {
                for x in low.x..high.x {
                    let (distance, along) = from_side(DVec2::new(x as f64, y as f64) + 0.5, number);
                    let is_beyond =
                        (number == 0 && along < 0.0) || (number + 2 == exact.len() && along > 1.0);
                    if !is_beyond {
                        let nearest = &mut nearest[y * side_px + x];
                        *nearest = nearest.min(distance);
                    }
                }
            }
        }
        let mut errors = Self::default();
        let (mut shown_at, mut missing_at) = (Vec::new(), Vec::new());
        for ((at, shown), nearest) in centres(eye.size()).zip(numbers).zip(nearest) {
            let is_there = nearest <= HALF_PX;
            if let Some([part, _]) = texels(data.shape, *shown) {
                let sides = (part * SIDES) as usize..((part + 1) * SIDES) as usize;
                let off = sides
                    .map(|side| from_side(at, side).0)
                    .fold(f64::INFINITY, f64::min);
                errors.off_px.push((off - HALF_PX).max(0.0));
                errors.extra += u64::from(!is_there);
                shown_at.push(at);
            } else if is_there {
                missing_at.push(at);
            }
        }
        errors.missing = missing_at.len() as u64;
        if !divided.is_tested {
            let off = missing_at.par_iter().map(|at| {
                let all = shown_at.iter().map(|shown| shown.distance(*at));
                all.fold(f64::INFINITY, f64::min) - std::f64::consts::SQRT_2
            });
            let off: Vec<f64> = off.filter(|off| off.is_finite()).collect();
            errors
                .off_px
                .extend(off.into_iter().map(|off| off.max(0.0)));
        }
        errors.off_px.sort_by(f64::total_cmp);
        errors
    }

    /// Largest, 99 % and median; none where nothing is shown.
    pub(crate) fn spread(&self) -> Option<[f64; 3]> {
        let last = self.off_px.len().checked_sub(1)?;
        Some([last, last * 99 / 100, last / 2].map(|at| self.off_px[at]))
    }
}

/// What the centre of each pixel shows by the exact projection, row by row: shares of both sides of a decal, within or
/// beyond them.
pub(crate) fn exact(divided: &Divided) -> Vec<Option<DVec2>> {
    let Divided { data, eye, .. } = divided;
    let places: Vec<DVec2> = centres(eye.size()).collect();
    let truth = |at_px: &DVec2| eye.shown(*at_px).and_then(|at| data.share_of(at));
    places.par_iter().map(truth).collect()
}

/// How far within data a place is, pixels: the largest of growing rings all of which has data, up to so much.
fn within_px(at: DVec2, most: f64, has: impl Fn(DVec2) -> bool) -> f64 {
    const RING: u32 = 16;
    let is_all = |radius: f64| {
        (0..RING).all(|step| {
            let turn = std::f64::consts::TAU * f64::from(step) / f64::from(RING);
            has(at + radius * DVec2::from_angle(turn))
        })
    };
    let rings = std::iter::successors(Some(0.25 * FINE_PX), |radius| Some(1.25 * radius));
    let own = rings.take_while(|radius| *radius <= most && is_all(*radius));
    own.last().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::{Division, Extent, Part, Vantage, groups};
    use crate::place::Path;

    const SIDE: u32 = 128;

    fn found(part: Part, division: Division) -> Divided {
        let all = groups(false).concat();
        let fits = |work: &&crate::cases::Work| {
            let is_own = (work.part, work.division) == (part, division);
            is_own && (work.extent, work.from) == (Extent::Continent, Vantage::Oblique)
        };
        all.iter().find(fits).expect("a case").divided(SIDE, None)
    }

    /// What the triangles show, and how far it is off where it is moved down by so many pixels.
    fn shown(divided: &Divided, down: usize) -> (Vec<u32>, Errors) {
        let reference = Reference::new(divided, &divided.corners());
        let truth = reference.picture();
        let number = |share: &Option<DVec2>| share.map_or(0, |share| reference.number_of(share));
        let mut numbers: Vec<u32> = truth.iter().map(number).collect();
        numbers.rotate_right(down * SIDE as usize);
        let mut moved = truth;
        moved.rotate_right(down * SIDE as usize);
        let errors = of(divided, &numbers, &moved);
        (numbers, errors)
    }

    fn of(divided: &Divided, numbers: &[u32], drawn: &[Option<DVec2>]) -> Errors {
        match divided.data.shape {
            Shape::Decal(_) => Errors::of_decal(divided, numbers, drawn, &exact(divided)),
            Shape::Line(_) => Errors::of_line(divided, numbers),
        }
    }

    #[test]
    fn a_picture_that_is_moved_is_off_by_as_much() {
        let line = Part::Line {
            is_great_circle: false,
        };
        for part in [Part::Decal, line] {
            let fine = found(part, Division::Formula);
            let (_, errors) = shown(&fine, 0);
            assert!(
                errors.spread().expect("shown")[0] <= FINE_PX,
                "{part:?} {errors:?}"
            );
            let (_, errors) = shown(&fine, 4);
            let most = errors.spread().expect("shown")[0];
            assert!((3.5..4.5).contains(&most), "{part:?} {most}");
            assert!(errors.extra > 20 && errors.missing > 20, "{part:?}");
            // One cell is off by pixels.
            let (_, errors) = shown(&found(part, Division::Fixed(1)), 0);
            assert!(errors.spread().expect("shown")[0] > 2.0, "{part:?}");
        }
    }

    /// A formula that is merely generous would keep its bound with fewer.
    #[test]
    fn half_of_the_cells_that_the_formula_says_are_too_few() {
        let mut tried = 0;
        for work in groups(false).concat() {
            let is_own = work.division == Division::Formula && !work.is_tested;
            let fine = work.divided(SIDE, None);
            // A great circle through the place below the eye is straight.
            let is_straight = matches!(fine.data.shape, Shape::Line(Path::GreatCircle { .. }))
                && work.from == Vantage::Nadir;
            // Of fewer, half is none, or one that is enough by chance.
            if !is_own || is_straight || fine.cells < 3 {
                continue;
            }
            let most = |cells| {
                let (_, errors) = shown(&Divided { cells, ..fine }, 0);
                errors.spread().expect("shown")[0]
            };
            let name = work.name();
            assert!(most(fine.cells) <= FINE_PX, "{name}");
            assert!(most(fine.cells / 2) > FINE_PX, "{name}");
            tried += 1;
        }
        assert!(tried > 30, "{tried}");
    }

    #[test]
    fn a_line_that_stops_half_way_misses_half_of_its_pixels() {
        let line = Part::Line {
            is_great_circle: false,
        };
        let fine = found(line, Division::Formula);
        let (mut numbers, whole) = shown(&fine, 0);
        let count = whole.off_px.len() as u64;
        for number in &mut numbers {
            *number = if *number > TEXELS / 2 { 0 } else { *number };
        }
        let half = Errors::of_line(&fine, &numbers);
        assert!(
            half.missing > count / 3 && whole.missing < count / 10,
            "{}",
            half.missing
        );
        assert!(half.spread().expect("shown")[0] > 2.0 * FINE_PX);
    }
}
