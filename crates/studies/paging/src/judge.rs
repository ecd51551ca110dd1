// SPDX-License-Identifier: MIT OR Apache-2.0
//! What pixels may show, in `f64`: rays meet the globe's triangles, and the page table of the frame says which page lies
//! in a slot. No code is shared with the shader.
//!
//! A pixel is right if it shows what is right at its middle, or at a place within the band about it: a device places
//! vertices on a grid of its own, and adds and divides in single precision.

use crate::path::{Eye, Globe};
use crate::residency::{LEAF, SLOT};
use crate::stage::Said;
use crate::texture::{PAGE, Page, STORED, Texture, address, clamped, level_of, wrapped};
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::ops::RangeInclusive;
use std::sync::Arc;
use terrafill_reference::SurfaceTriangles;
use terrafill_surface::{HeightRange, SurfaceFrame};

/// How far a place may be off a pixel's middle, pixels.
const BAND_PX: f64 = 1.0 / 32.0;
/// Places that are tried from a pixel's middle to the band's end.
const FINE: i32 = 8;
/// How far the level that a footprint asks for may be off.
const BAND_LEVELS: f64 = 0.05;
/// Of a filter: WebGPU's backends have 8 bits between texels along each axis, and round each of three steps.
const PLACE_TEXELS: f64 = 2.0 / 256.0;
const ROUNDED: f64 = 1.5;
/// Of an address: what texels of one page have in common.
const OF_PAGE: u32 = !((PAGE - 1) << 13 | (PAGE - 1));

/// What was found of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Judged {
    /// Pixels that show what they may not.
    pub(crate) mismatched: u64,
    /// Pixels that show what is right beside their middle alone.
    pub(crate) in_band: u64,
    /// Pixels of the globe.
    pub(crate) covered: u64,
    /// Of them, those that say that they show a coarser page than their footprint asks for.
    pub(crate) missing: u64,
    /// Of them, those more than a level coarser than their footprint.
    pub(crate) blurred: u64,
    /// Levels by which texels are larger than footprints, and pixels: of pages that lie within the picture,
    /// and of those that its edge cuts.
    pub(crate) lost: [(f64, u64); 2],
}

impl Judged {
    fn and(mut self, other: Self) -> Self {
        self.mismatched += other.mismatched;
        self.in_band += other.in_band;
        self.covered += other.covered;
        self.missing += other.missing;
        self.blurred += other.blurred;
        for (own, other) in self.lost.iter_mut().zip(other.lost) {
            own.0 += other.0;
            own.1 += other.1;
        }
        self
    }

    /// Mean levels that pages lose which the picture's edge cuts, less those of pages within; where there are both.
    pub(crate) fn edge_loss(&self) -> Option<f64> {
        let [within, cut] = self.lost.map(|(sum, count)| sum / count as f64);
        self.lost.iter().all(|of| of.1 > 0).then_some(cut - within)
    }
}

type Corners = [[u64; 3]; 3];

/// Rays of a frame's eye at the globe, and the frame's page table.
pub(crate) struct Reference<'a> {
    eye: Eye,
    texture: &'a Texture,
    table: &'a [u32],
    by_derivative: bool,
    triangles: SurfaceTriangles,
    /// Of each triangle as drawn: what turns a direction into its share of the corners, and their U and V.
    facets: Vec<([DVec3; 3], [[f64; 2]; 3])>,
    by_corners: HashMap<Corners, usize>,
}

/// A page that places show, and where on it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Lookup {
    wanted: u32,
    footprint: u32,
    /// With the least and the greatest place in texels from its corner; `None` where no page of theirs is in a slot.
    shown: Option<(Page, [[f64; 2]; 2])>,
}

fn key(corners: [DVec3; 3]) -> Corners {
    corners.map(|corner| corner.to_array().map(f64::to_bits))
}

impl<'a> Reference<'a> {
    pub(crate) fn new(
        eye: Eye,
        globe: &Globe,
        texture: &'a Texture,
        table: &'a [u32],
        by_derivative: bool,
    ) -> Self {
        let eye_ecef = eye.camera.eye_ecef;
        let places = globe.places.iter();
        let rte = places.map(|place| (DVec3::from(place.map(f64::from)) - eye_ecef).as_vec3());
        let rte: Vec<[f32; 3]> = rte.map(|place| place.to_array()).collect();
        let corner = |at: u32| DVec3::from(rte[at as usize].map(f64::from));
        let facets = globe.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(corner);
            let uvs = triangle.map(|at| globe.uvs[at as usize].map(f64::from));
            ([b.cross(c), c.cross(a), a.cross(b)], uvs)
        });
        let facets = facets.collect();
        let corners = globe.triangles.iter().enumerate();
        let by_corners = corners.map(|(at, triangle)| (key(triangle.map(corner)), at));
        let by_corners = by_corners.collect();
        let frame = SurfaceFrame {
            vertices_rte: rte.into(),
            triangles: globe.triangles.clone().into(),
            heights: HeightRange {
                lowest_m: 0.0,
                highest_m: 0.0,
            },
            parts: Arc::default(),
            shown: None,
        };
        Self {
            eye,
            texture,
            table,
            by_derivative,
            triangles: SurfaceTriangles::new(&frame),
            facets,
            by_corners,
        }
    }

    /// The triangle that a place of the picture shows.
    fn facet(&self, px: [f64; 2]) -> Option<usize> {
        let direction = self.eye.camera.direction_ecef(self.eye.size, px);
        let (_, corners) = self
            .triangles
            .hit_facet(direction, self.eye.camera.near_m)?;
        self.by_corners.get(&key(corners)).copied()
    }

    /// Shares of a triangle's corners at a place of the picture, beside the triangle as well; up to a factor that is
    /// infinite where its plane ends.
    fn shares(&self, facet: usize, px: [f64; 2]) -> DVec3 {
        let direction = self.eye.camera.direction_ecef(self.eye.size, px);
        let normals = self.facets[facet].0.map(|normal| normal.to_array());
        DMat3::from_cols_array_2d(&normals).transpose() * direction
    }

    /// U and V there.
    fn uv(&self, facet: usize, px: [f64; 2]) -> [f64; 2] {
        let shares = self.shares(facet, px);
        let sum = shares.element_sum();
        [0, 1].map(|axis| {
            let corners = DVec3::from(self.facets[facet].1.map(|uv| uv[axis]));
            shares.dot(corners) / sum
        })
    }

    /// The level whose texels are as large as the footprint of a pixel, not rounded: differences within its two by two
    /// pixels, as devices take them.
    fn footprint_level(&self, facet: usize, [x, y]: [f64; 2]) -> f64 {
        let side = f64::from(Texture::side(self.texture.finest));
        let partner = |at: f64| {
            let number = at.floor();
            if number % 2.0 == 0.0 {
                at + 1.0
            } else {
                at - 1.0
            }
        };
        let own = self.uv(facet, [x, y]);
        let along = |px| {
            let other = self.uv(facet, px);
            [0, 1].map(|axis| (other[axis] - own[axis]) * side)
        };
        let [a, b] = [along([partner(x), y]), along([x, partner(y)])];
        f64::from(self.texture.finest) - 0.5 * (a[0] * b[1] - a[1] * b[0]).abs().log2()
    }

    fn rounded(&self, level: f64) -> u32 {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "held within the levels"
        )]
        let level = (level + 0.5).clamp(0.0, f64::from(self.texture.finest)) as u32;
        level
    }

    /// What places of the texture show to a pixel whose footprint asks for a level; `None` where several pages are there.
    ///
    /// - `places`: the least and the greatest
    fn lookup(&self, places: [[f64; 2]; 2], footprint: u32) -> Option<Lookup> {
        let last = if self.by_derivative {
            footprint
        } else {
            self.texture.finest
        };
        let uvs = places.map(|place| place.map(|at| at.clamp(0.0, 1.0)));
        let mut found = Lookup {
            wanted: 0,
            footprint,
            shown: None,
        };
        for level in 0..=last {
            let [page, other] = uvs.map(|uv| Page::at(level, uv));
            if page != other {
                return None;
            }
            let entry = self.table[page.number()];
            found.wanted = level;
            if entry & SLOT != 0 {
                let side = f64::from(1_u32 << level);
                let corner = [page.x, page.y].map(f64::from);
                let local = |axis, uv: [f64; 2]| (uv[axis] * side - corner[axis]) * f64::from(PAGE);
                let locals = uvs.map(|uv| [0, 1].map(|axis| local(axis, uv)));
                found.shown = Some((page, locals));
            }
            if entry & LEAF != 0 && !self.by_derivative {
                break;
            }
        }
        Some(found)
    }

    /// All that a pixel may show of a triangle at places of the picture: one, or the corners of a square. `None` where
    /// one lookup does not say it for the whole square.
    fn lookups(&self, facet: usize, places: &[[f64; 2]]) -> Option<Vec<Lookup>> {
        let mut levels = Vec::new();
        let mut range = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for px in places {
            let uv = self.uv(facet, *px);
            let [low, high] = range;
            range = [
                [low[0].min(uv[0]), low[1].min(uv[1])],
                [high[0].max(uv[0]), high[1].max(uv[1])],
            ];
            let level = self.footprint_level(facet, *px);
            levels.extend([0.0, -BAND_LEVELS, BAND_LEVELS].map(|off| self.rounded(level + off)));
        }
        // A ratio of linear functions is the least and the greatest at corners, unless it has a pole between them.
        let is_before = |px: &&[f64; 2]| self.shares(facet, **px).element_sum() > 0.0;
        if places.len() > 1 && places.iter().filter(is_before).count() % places.len() > 0 {
            return None;
        }
        levels.sort_unstable();
        levels.dedup();
        let found = levels.into_iter().map(|level| self.lookup(range, level));
        found.collect()
    }

    /// Whether something fits at a place of a grid over the band about a pixel's middle. Looks at one square of the grid,
    /// and cuts it in four unless nothing of it may fit.
    ///
    /// - `low`: the square's first corner, in [`FINE`] parts of the band from the middle
    /// - `size`: its side in the same
    fn is_near(
        &self,
        facet: usize,
        px: [f64; 2],
        low: [i32; 2],
        size: i32,
        fits: &impl Fn(Option<&Lookup>) -> bool,
    ) -> bool {
        let corner = |step: i32| {
            [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| [low[0] + step * x, low[1] + step * y])
        };
        let places = corner(size).map(|at| {
            let off = at.map(|at| BAND_PX * f64::from(at) / f64::from(FINE));
            [px[0] + off[0], px[1] + off[1]]
        });
        let places = if size == 0 { &places[..1] } else { &places };
        let found = self.lookups(facet, places);
        let may = found.is_none_or(|found| found.iter().any(|one| fits(Some(one))));
        if size == 0 || !may {
            return may;
        }
        let half = size / 2;
        let mut parts = corner(size - half).into_iter();
        parts.any(|low| self.is_near(facet, px, low, half, fits))
    }

    /// Whether any place within the band has something that fits; and whether the pixel's middle has.
    ///
    /// - `middle`: what that may show; none beside the globe
    fn fits(
        &self,
        px: [f64; 2],
        middle: Option<&[Lookup]>,
        fits: impl Fn(Option<&Lookup>) -> bool,
    ) -> [bool; 2] {
        let is_exact = match middle {
            Some(all) => all.iter().any(|one| fits(Some(one))),
            None => fits(None),
        };
        if is_exact {
            return [true; 2];
        }
        let ends = [-BAND_PX, 0.0, BAND_PX];
        let around = ends.into_iter().flat_map(|y| ends.map(|x| [x, y]));
        let mut facets: Vec<Option<usize>> = around
            .map(|[x, y]| self.facet([px[0] + x, px[1] + y]))
            .collect();
        facets.sort_unstable();
        facets.dedup();
        // Where triangles are narrow, many texels lie within the band.
        let is_near = facets.into_iter().any(|facet| match facet {
            None => fits(None),
            Some(facet) => self.is_near(facet, px, [-FINE; 2], 2 * FINE, &fits),
        });
        [is_near, false]
    }

    /// Levels of the pages that pixels show, row by row.
    pub(crate) fn levels(&self) -> Vec<Option<u32>> {
        let width = self.eye.size.width as usize;
        let pixels = (0..self.eye.size.pixel_count()).into_par_iter();
        let level = pixels.map(|pixel| {
            let px = [pixel % width, pixel / width].map(|at| at as f64 + 0.5);
            let found = self.lookups(self.facet(px)?, &[px])?;
            let (page, _) = found.first()?.shown?;
            Some(page.level)
        });
        level.collect()
    }

    fn by_pixel(&self, one: impl Fn(usize, [f64; 2]) -> Judged + Sync) -> Judged {
        let width = self.eye.size.width as usize;
        let pixels = (0..self.eye.size.pixel_count()).into_par_iter();
        let judged = pixels.map(|pixel| {
            let middle = [pixel % width, pixel / width].map(|at| at as f64 + 0.5);
            one(pixel, middle)
        });
        judged.reduce(Judged::default, Judged::and)
    }

    /// Whether a pixel that says so is right.
    fn is_right(&self, px: [f64; 2], middle: Option<&[Lookup]>, said: &Said) -> [bool; 2] {
        self.fits(px, middle, |lookup| says(lookup, said))
    }

    /// Pages that the picture's edge cuts, by their addresses.
    fn cut(&self, said: &[Said]) -> HashSet<u32> {
        let [width, height] = [self.eye.size.width, self.eye.size.height].map(|of| of as usize);
        let is_edge = |at: usize| {
            let [x, y] = [at % width, at / width];
            x == 0 || y == 0 || x + 1 == width || y + 1 == height
        };
        let edge = said.iter().enumerate().filter(|(at, _)| is_edge(*at));
        edge.map(|(_, said)| said.texels[0] & OF_PAGE).collect()
    }

    /// Judges a frame: its filtered colours, and what its pixels say that they show.
    ///
    /// - `pages`: texels of all pages in slots
    /// - `said`: none of a picture's texels, which do not say their addresses
    pub(crate) fn judge(
        &self,
        colours: &[[u8; 4]],
        pages: &HashMap<Page, Vec<u8>>,
        said: Option<&[Said]>,
    ) -> Judged {
        let cut = said.map_or_else(HashSet::new, |said| self.cut(said));
        self.by_pixel(|pixel, px| {
            let facet = self.facet(px);
            let middle = facet.map(|facet| self.lookups(facet, &[px]).unwrap_or_default());
            let middle = middle.as_deref();
            let shown = colours[pixel];
            let [mut is_right, mut is_exact] =
                self.fits(px, middle, |lookup| match lookup.map(|of| of.shown) {
                    None => shown == [0; 4],
                    Some(None) => false,
                    Some(Some((page, local))) => pages
                        .get(&page)
                        .is_some_and(|texels| is_between(texels, local, shown)),
                });
            let said = said.map(|said| &said[pixel]);
            if let Some(said) = said {
                let [right, exact] = self.is_right(px, middle, said);
                is_right &= right;
                is_exact &= exact;
            }
            let mut judged = Judged {
                mismatched: u64::from(!is_right),
                in_band: u64::from(is_right && !is_exact),
                covered: u64::from(shown != [0; 4]),
                ..Judged::default()
            };
            let Some(said) = said.filter(|said| said.wanted.is_some()) else {
                return judged;
            };
            judged.covered = 1;
            let shown = level_of(said.texels[0]);
            judged.missing = u64::from(shown.is_none_or(|shown| shown < said.footprint));
            if let Some((facet, shown)) = facet.zip(shown) {
                let finest = f64::from(self.texture.finest);
                let own = self.footprint_level(facet, px).clamp(0.0, finest);
                let lost = own - f64::from(shown);
                judged.blurred = u64::from(lost > 1.0);
                let is_cut = cut.contains(&(said.texels[0] & OF_PAGE));
                judged.lost[usize::from(is_cut)] = (lost, 1);
            }
            judged
        })
    }
}

/// Whether a pixel that shows this may say so.
fn says(lookup: Option<&Lookup>, said: &Said) -> bool {
    let Some(lookup) = lookup else {
        return *said == Said::default();
    };
    said.wanted == Some(lookup.wanted)
        && said.footprint == lookup.footprint
        && match lookup.shown {
            None => said.texels == [0; 2],
            Some((page, places)) => is_among(page, places, said.texels),
        }
}

/// Along an axis, the texels of a stored page between whose middles places lie.
///
/// - `at`: the least and the greatest place, in texels from the page's corner
#[allow(clippy::cast_possible_truncation, reason = "held within a page")]
fn first_texels(at: [f64; 2]) -> RangeInclusive<i64> {
    let [low, high] = at.map(|at| (at + 0.5).floor() as i64);
    low..=high
}

/// Whether the addresses of the first and the last of the four texels about some place of a page are these.
fn is_among(page: Page, [low, high]: [[f64; 2]; 2], said: [u32; 2]) -> bool {
    let side = Texture::side(page.level);
    let corner = [page.x, page.y].map(|page| i64::from(page * PAGE) - 1);
    let mut columns = first_texels([low[0], high[0]]);
    columns.any(|column| {
        first_texels([low[1], high[1]]).any(|row| {
            let [x, y] = [corner[0] + column, corner[1] + row];
            let of = |off| address(page.level, wrapped(x + off, side), clamped(y + off, side));
            [0, 1].map(of) == said
        })
    })
}

/// Whether a colour is what a filter may make of a page's texels at some place.
///
/// - `places`: the least and the greatest, in texels from the page's corner
fn is_between(texels: &[u8], [low, high]: [[f64; 2]; 2], shown: [u8; 4]) -> bool {
    // Between the middles of four texels a filter's colours are the least and the greatest at corners.
    let stops = |axis: usize| {
        let [low, high] = [low[axis], high[axis]];
        let middles = first_texels([low, high]).skip(1);
        let mut stops = vec![low + 0.5];
        stops.extend(middles.map(|at| at as f64));
        stops.extend((high > low).then_some(high + 0.5));
        stops
    };
    let (across, down) = (stops(0), stops(1));
    [0, 1, 2, 3].into_iter().all(|channel| {
        let at = |x: f64, y: f64| filtered(texels, channel, [x, y]);
        let all = down.iter().flat_map(|y| across.iter().map(|x| at(*x, *y)));
        let none = [f64::INFINITY, f64::NEG_INFINITY, 0.0];
        let [least, most, spread] = all.fold(none, |all, [value, spread]| {
            [all[0].min(value), all[1].max(value), all[2].max(spread)]
        });
        let doubt = spread * PLACE_TEXELS + ROUNDED;
        (least - doubt..=most + doubt).contains(&f64::from(shown[channel]))
    })
}

/// A channel between the middles of four texels, and how far apart they are.
///
/// - `at`: from the middle of the stored page's first texel, in texels
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "held within a page"
)]
pub(crate) fn filtered(texels: &[u8], channel: usize, at: [f64; 2]) -> [f64; 2] {
    let [column, row] = at.map(|at| at.floor() as usize);
    let [across, down] = at.map(|at| at - at.floor());
    let texel = |x: usize, y: usize| {
        let at = 4 * ((row + y) * STORED as usize + column + x) + channel;
        texels.get(at).copied().map_or(f64::NAN, f64::from)
    };
    let four = [texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)];
    let [north, south] = [0, 2].map(|at| four[at] + across * (four[at + 1] - four[at]));
    let highest = four.into_iter().fold(f64::MIN, f64::max);
    let lowest = four.into_iter().fold(f64::MAX, f64::min);
    [north + down * (south - north), highest - lowest]
}

#[cfg(test)]
mod tests;
