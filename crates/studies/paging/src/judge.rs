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

/// A page that a place shows, and where on it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Lookup {
    wanted: u32,
    footprint: u32,
    /// With the place in texels from its corner; `None` where no page of the place is in a slot.
    shown: Option<(Page, [f64; 2])>,
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

    /// U and V of a triangle's plane at a place of the picture, beside the triangle as well.
    fn uv(&self, facet: usize, px: [f64; 2]) -> [f64; 2] {
        let direction = self.eye.camera.direction_ecef(self.eye.size, px);
        let (normals, uvs) = &self.facets[facet];
        let shares =
            DMat3::from_cols_array_2d(&normals.map(|n| n.to_array())).transpose() * direction;
        let sum = shares.element_sum();
        [0, 1].map(|axis| {
            let corners = DVec3::from(uvs.map(|uv| uv[axis]));
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

    /// What a place of the texture shows to a pixel whose footprint asks for a level.
    fn lookup(&self, place: [f64; 2], footprint: u32) -> Lookup {
        let last = if self.by_derivative {
            footprint
        } else {
            self.texture.finest
        };
        let uv = place.map(|at| at.clamp(0.0, 1.0));
        let mut found = Lookup {
            wanted: 0,
            footprint,
            shown: None,
        };
        for level in 0..=last {
            let page = Page::at(level, uv);
            let entry = self.table[page.number()];
            found.wanted = level;
            if entry & SLOT != 0 {
                let side = f64::from(1_u32 << level);
                let corner = [page.x, page.y].map(f64::from);
                let local = [0, 1].map(|axis| (uv[axis] * side - corner[axis]) * f64::from(PAGE));
                found.shown = Some((page, local));
            }
            if entry & LEAF != 0 && !self.by_derivative {
                break;
            }
        }
        found
    }

    /// All that a pixel may show of a triangle at a place of the picture.
    fn lookups(&self, facet: usize, px: [f64; 2]) -> Vec<Lookup> {
        let uv = self.uv(facet, px);
        let level = self.footprint_level(facet, px);
        let near = [0.0, -BAND_LEVELS, BAND_LEVELS].map(|off| self.rounded(level + off));
        let mut levels = Vec::from(near);
        levels.dedup();
        let found = levels.into_iter().map(|level| self.lookup(uv, level));
        found.collect()
    }

    /// Whether any place within the band has something that fits; and whether the pixel's middle has.
    ///
    /// - `middle`: the triangle at the pixel's middle
    fn fits(
        &self,
        px: [f64; 2],
        middle: Option<usize>,
        fits: impl Fn(Option<&Lookup>) -> bool,
    ) -> [bool; 2] {
        let of_facet = |facet, px| self.lookups(facet, px).iter().any(|one| fits(Some(one)));
        let is_exact = match middle {
            Some(facet) => of_facet(facet, px),
            None => fits(None),
        };
        if is_exact {
            return [true; 2];
        }
        let off = |x: i32, y: i32, of: i32| {
            let at = [x, y].map(|at| BAND_PX * f64::from(at) / f64::from(of));
            [px[0] + at[0], px[1] + at[1]]
        };
        let around = (-1..=1).flat_map(|y| (-1..=1).map(move |x| (x, y)));
        let mut facets: Vec<Option<usize>> =
            around.map(|(x, y)| self.facet(off(x, y, 1))).collect();
        facets.sort_unstable();
        facets.dedup();
        // Where triangles are narrow, many texels lie within the band.
        let is_near = facets.into_iter().any(|facet| match facet {
            None => fits(None),
            Some(facet) => {
                (-FINE..=FINE).any(|y| (-FINE..=FINE).any(|x| of_facet(facet, off(x, y, FINE))))
            }
        });
        [is_near, false]
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
    fn is_right(&self, px: [f64; 2], middle: Option<usize>, said: &Said) -> [bool; 2] {
        self.fits(px, middle, |lookup| {
            let expected = lookup.map_or_else(Said::default, |lookup| Said {
                wanted: Some(lookup.wanted),
                footprint: lookup.footprint,
                texels: lookup
                    .shown
                    .map_or([0; 2], |(page, local)| texels(page, local)),
            });
            expected == *said
        })
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
            let shown = colours[pixel];
            let [mut is_right, mut is_exact] =
                self.fits(px, facet, |lookup| match lookup.map(|of| of.shown) {
                    None => shown == [0; 4],
                    Some(None) => false,
                    Some(Some((page, local))) => pages
                        .get(&page)
                        .is_some_and(|texels| is_between(texels, local, shown)),
                });
            let said = said.map(|said| &said[pixel]);
            if let Some(said) = said {
                let [right, exact] = self.is_right(px, facet, said);
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

/// Column and row, in a stored page, of the first of the four texels about a place, and how far the place is past it.
#[allow(clippy::cast_possible_truncation, reason = "held within a page")]
fn first_texel(local: [f64; 2]) -> ([i64; 2], [f64; 2]) {
    let at = local.map(|at| at + 0.5);
    (at.map(|at| at.floor() as i64), at.map(|at| at - at.floor()))
}

/// Addresses of the first and the last of the four texels about a place of a page.
fn texels(page: Page, local: [f64; 2]) -> [u32; 2] {
    let ([column, row], _) = first_texel(local);
    let side = Texture::side(page.level);
    [0, 1].map(|off| {
        let [x, y] = [(page.x, column), (page.y, row)]
            .map(|(page, at)| i64::from(page * PAGE) + at - 1 + off);
        address(page.level, wrapped(x, side), clamped(y, side))
    })
}

/// Whether a colour is what a filter may make of a page's texels at a place.
fn is_between(texels: &[u8], local: [f64; 2], shown: [u8; 4]) -> bool {
    let ([column, row], [across, down]) = first_texel(local);
    [0, 1, 2, 3].into_iter().all(|channel| {
        let texel = |x: i64, y: i64| {
            let at = (row + y) * i64::from(STORED) + column + x;
            let at = usize::try_from(at).unwrap_or(usize::MAX);
            texels
                .get(4 * at + channel)
                .copied()
                .map_or(f64::NAN, f64::from)
        };
        let four = [texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)];
        let [north, south] = [0, 2].map(|at| four[at] + across * (four[at + 1] - four[at]));
        let value = north + down * (south - north);
        let highest = four.into_iter().fold(f64::MIN, f64::max);
        let spread = highest - four.into_iter().fold(f64::MAX, f64::min);
        let doubt = spread * PLACE_TEXELS + ROUNDED;
        (f64::from(shown[channel]) - value).abs() <= doubt
    })
}
