// SPDX-License-Identifier: MIT OR Apache-2.0
//! What each pixel should show of the map, in `f64`: by the triangles as drawn, with U kept in one piece, and by
//! the body itself. The first leaves the seam and `f32` as the only causes of an error.

use super::options::Options;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::ops::RangeInclusive;
use terrafill_globe_views::{Eye, SNAPPED_PX, around};
use terrafill_maps::{
    MapPoint, MapTile, TILE_TEXELS, cap_point, half_plane_crossings, level_of, mercator_v,
    mercator_v_of,
};
use terrafill_reference::SurfaceTriangles;
use terrafill_surface::SurfaceFrame;

/// Deepest level: texels of 2 cm.
pub(crate) const MAX_LEVEL: u32 = 22;

/// Texels about a pixel's own within which `f32` may ask for another tile.
const ROUNDING_TEXELS: f64 = 1.5;

/// Share of the distance by which a device's level may round otherwise. The logarithm has an error of 3 ulp
/// (WGSL, 15.7.4.2), so of some 1e-6 of a level; with a margin of a hundred.
const LEVEL_ROUNDING: f64 = 1e-4;

/// A picture of the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Tile {
    /// Of the map, row before column as the device sorts them.
    Map { level: u32, row: u32, column: u32 },
    /// About a pole.
    Cap { is_south: bool },
}

impl Tile {
    /// As the shader names it.
    pub(crate) fn key(self) -> [u32; 4] {
        match self {
            Self::Map { level, row, column } => [level, row, column, 0],
            Self::Cap { is_south } => [1000, 0, u32::from(is_south), 0],
        }
    }

    /// What it is a quarter of; the whole map and caps are in none.
    pub(crate) fn parent(&self) -> Option<Self> {
        let Self::Map { level, row, column } = *self else {
            return None;
        };
        Some(Self::Map {
            level: level.checked_sub(1)?,
            row: row / 2,
            column: column / 2,
        })
    }

    /// Along the side of the picture that it is a part of.
    pub(crate) fn texels(self) -> f64 {
        match self {
            Self::Map { level, .. } => texels_along(level),
            Self::Cap { .. } => TILE_TEXELS,
        }
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "levels up to 22 have no more than 2^22 columns"
    )]
    pub(crate) fn of(tile: MapTile) -> Self {
        Self::Map {
            level: tile.level,
            row: tile.row as u32,
            column: tile.column as u32,
        }
    }
}

/// A place on the map: U in one piece over a triangle, so beyond 0 … 1 on one side of the seam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WrappedPoint {
    pub(crate) u: f64,
    /// V' by the vertex.
    pub(crate) by_vertex: f64,
    /// V, of which a fragment makes V'; `None` where both are the same.
    pub(crate) v: Option<f64>,
    /// Where a cap of a pole shows it.
    pub(crate) cap: Option<[f64; 2]>,
}

impl WrappedPoint {
    /// Whether V' is on the map. Beside a cap, a corner beyond the map's end pulls it off: no texel is there, whatever
    /// the seam.
    pub(crate) fn is_on_map(&self, by_fragment: bool) -> bool {
        (0.0..1.0).contains(&self.mercator_v(by_fragment))
    }

    /// V', which costs a tangent where fragments make it.
    pub(crate) fn mercator_v(&self, by_fragment: bool) -> f64 {
        let v = self.v.filter(|_| by_fragment);
        v.map_or(self.by_vertex, mercator_v)
    }
}

/// A pixel that shows the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Truth {
    pub(crate) drawn: WrappedPoint,
    /// By the body; `None` where it is missed.
    pub(crate) body: Option<WrappedPoint>,
    /// That it asks for: from and to, the same but where rounding to `f32` may change it.
    pub(crate) levels: [u32; 2],
    /// Whether ±180° is within two pixels, on this triangle.
    pub(crate) is_at_seam: bool,
    /// Whether the triangle holds a pole, so that U is no function on it.
    pub(crate) holds_pole: bool,
    /// How far U or V' moves where corners are moved to what a device keeps of them: much where a triangle is seen along
    /// its plane, at the limb.
    pub(crate) snapped: f64,
    /// Whether a pixel beside it shows no surface: what is drawn there may be a triangle that rays miss.
    pub(crate) is_at_outline: bool,
}

/// Pixels in rows.
pub(crate) fn truths(eye: &Eye, frame: &SurfaceFrame) -> Vec<Option<Truth>> {
    let triangles = SurfaceTriangles::new(frame);
    let body = SurfaceTriangles::of_body(&eye.body, eye.camera.eye_ecef);
    let mut truths = eye.by_pixel_with(|known: &mut MapFacet, _, centre, direction| {
        truth(eye, [&triangles, &body], (centre, direction), known)
    });
    let width = eye.size.width as usize;
    let is_open: Vec<bool> = truths.iter().map(Option::is_none).collect();
    for (pixel, truth) in truths.iter_mut().enumerate() {
        if let Some(truth) = truth {
            let mut beside = around(pixel, width, is_open.len());
            truth.is_at_outline = beside.any(|beside| is_open[beside]);
        }
    }
    truths
}

/// The same of every so manyth pixel of every so manyth row; what is beside them is not known.
pub(crate) fn truths_of_every(eye: &Eye, frame: &SurfaceFrame, step: u32) -> Vec<Truth> {
    let triangles = SurfaceTriangles::new(frame);
    let body = SurfaceTriangles::of_body(&eye.body, eye.camera.eye_ecef);
    let rows = (0..eye.size.height).into_par_iter().step_by(step as usize);
    let of_row = |row: u32| {
        let mut known = MapFacet::default();
        let columns = (0..eye.size.width).step_by(step as usize);
        let of_pixel = |column: u32| {
            let centre = [column, row].map(|at| f64::from(at) + 0.5);
            let direction = eye.camera.direction_ecef(eye.size, centre);
            truth(eye, [&triangles, &body], (centre, direction), &mut known)
        };
        columns.filter_map(of_pixel).collect::<Vec<_>>()
    };
    rows.flat_map_iter(of_row).collect()
}

/// A triangle's corners on the map, remembered: pixels beside each other mostly show the same one.
#[derive(Debug, Default)]
struct MapFacet {
    /// From the eye.
    facet: [DVec3; 3],
    /// Of the planes through the eye and the edge across from each corner.
    planes: [DVec3; 3],
    /// U in one piece, V' by the vertex, and V.
    corners: [[f64; 3]; 3],
    /// Of ±180° by its edges.
    crossings: usize,
}

impl MapFacet {
    fn take(&mut self, eye: &Eye, facet: [DVec3; 3]) {
        if self.facet == facet {
            return;
        }
        let ecef = facet.map(|corner| corner + eye.camera.eye_ecef);
        let points = ecef.map(|corner| MapPoint::new(&eye.body, corner));
        let first = points[0].u;
        let [a, b, c] = facet;
        *self = Self {
            facet,
            planes: [b.cross(c), c.cross(a), a.cross(b)],
            corners: points.map(|point| {
                let u = point.u - (point.u - first).round();
                [u, point.mercator_v, point.v]
            }),
            crossings: half_plane_crossings(ecef),
        };
    }

    /// U, V' by the vertex, and V where a ray from the eye meets the triangle's plane.
    fn at(&self, direction: DVec3) -> [f64; 3] {
        let sides = self.planes.map(|plane| plane.dot(direction));
        let sum: f64 = sides.iter().sum();
        [0, 1, 2].map(|which| {
            let corners = self.corners.iter().zip(sides);
            corners.map(|(of, side)| of[which] * (side / sum)).sum()
        })
    }
}

/// Of a pixel, by its centre and its ray's direction.
fn truth(
    eye: &Eye,
    [triangles, body]: [&SurfaceTriangles; 2],
    (centre, direction): ([f64; 2], DVec3),
    known: &mut MapFacet,
) -> Option<Truth> {
    let camera = &eye.camera;
    let (depth, facet) = triangles.hit_facet(direction, camera.near_m)?;
    known.take(eye, facet);
    let [u, by_vertex, v] = known.at(direction);
    let beside = [[1.0, 0.0], [0.0, 1.0]].map(|[x, y]| {
        let there = camera.direction_ecef(eye.size, [centre[0] + x, centre[1] + y]);
        (known.at(there)[0] - u).abs()
    });
    let snapped = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(|way| {
        let beside = [0, 1].map(|axis| centre[axis] + SNAPPED_PX * way[axis]);
        let [there_u, by_vertex_there, _] = known.at(camera.direction_ecef(eye.size, beside));
        (there_u - u).abs().max((by_vertex_there - by_vertex).abs())
    });
    let ecef = camera.eye_ecef + direction * depth;
    let drawn = WrappedPoint {
        u,
        by_vertex,
        v: Some(v),
        cap: cap_point(eye.body.normal_and_height(ecef).0),
    };
    let of_body = body.hit(direction, camera.near_m);
    let of_body = of_body.map(|depth| on_body(eye, camera.eye_ecef + direction * depth));
    Some(Truth {
        drawn,
        body: of_body,
        levels: wanted_levels(eye, ecef, direction.length() * depth),
        is_at_seam: known.crossings == 2
            && (u - u.round()).abs() <= 2.0 * beside[0].max(beside[1])
            && [false, true].map(|by_fragment| drawn.is_on_map(by_fragment)) == [true; 2],
        holds_pole: known.crossings % 2 == 1,
        snapped: snapped.into_iter().fold(0.0, f64::max),
        is_at_outline: false,
    })
}

fn on_body(eye: &Eye, ecef: DVec3) -> WrappedPoint {
    let (normal, _) = eye.body.normal_and_height(ecef);
    WrappedPoint {
        u: 0.5 + normal.y.atan2(normal.x) / TAU,
        by_vertex: mercator_v_of(normal),
        v: None,
        cap: cap_point(normal),
    }
}

/// Pixels in rows, of the body itself, whatever is drawn for it.
pub(crate) fn body_truths(eye: &Eye) -> Vec<Option<Truth>> {
    let camera = &eye.camera;
    let body = SurfaceTriangles::of_body(&eye.body, camera.eye_ecef);
    eye.by_pixel(|_, _, direction| {
        let depth = body.hit(direction, camera.near_m)?;
        let ecef = camera.eye_ecef + direction * depth;
        let drawn = on_body(eye, ecef);
        Some(Truth {
            drawn,
            body: Some(drawn),
            levels: wanted_levels(eye, ecef, direction.length() * depth),
            is_at_seam: false,
            holds_pole: false,
            snapped: 0.0,
            is_at_outline: false,
        })
    })
}

/// From and to, by how a device may round the distance.
fn wanted_levels(eye: &Eye, ecef: DVec3, distance_m: f64) -> [u32; 2] {
    [1.0 + LEVEL_ROUNDING, 1.0 - LEVEL_ROUNDING]
        .map(|share| wanted_level(eye, ecef, share * distance_m))
}

/// By the latitude that the shader has for a place: that of the ellipsoid through it, of the same shape. A coarse grid
/// hangs far below the body, where geodetic latitude is another.
pub(crate) fn wanted_level(eye: &Eye, ecef: DVec3, distance_m: f64) -> u32 {
    let radii = eye.body.radii_m();
    let up = (ecef / (radii * radii)).normalize();
    let cosine = (up.x * up.x + up.y * up.y).sqrt();
    level_of(&eye.body, cosine, eye.focal_px(), distance_m).min(MAX_LEVEL)
}

/// The level of a whole frame, where it has one: by the finest that a pixel of the map asks for.
pub(crate) fn frame_level(truths: &[Option<Truth>], options: &Options) -> Option<u32> {
    let below = options.one_level?;
    let on_map = truths
        .iter()
        .flatten()
        .filter(|truth| truth.drawn.cap.is_none());
    let finest = on_map.map(|truth| truth.levels[1]).max().unwrap_or(0);
    Some(finest.saturating_sub(below))
}

/// The finest level that a view asks for. Nine rays meet the body: through the picture's middle, its corners and the
/// middles of its sides. Where the ground is nearest, straight down or at the lower side, one of them passes.
pub(crate) fn finest_level(eye: &Eye) -> u32 {
    let camera = &eye.camera;
    let body = SurfaceTriangles::of_body(&eye.body, camera.eye_ecef);
    let along = |side: u32| [0.0, 0.5, 1.0].map(|share| share * f64::from(side));
    let (columns, rows) = (along(eye.size.width), along(eye.size.height));
    let places = rows.into_iter().flat_map(|y| columns.map(|x| [x, y]));
    let levels = places.filter_map(|place| {
        let direction = camera.direction_ecef(eye.size, place);
        let depth = body.hit(direction, camera.near_m)?;
        let ecef = camera.eye_ecef + direction * depth;
        Some(wanted_level(eye, ecef, direction.length() * depth))
    });
    levels.max().unwrap_or(0)
}

/// Texels along a side of the whole map.
pub(crate) fn texels_along(level: u32) -> f64 {
    TILE_TEXELS * f64::from(level).exp2()
}

/// Tiles that hold a place, by each of these levels, and those that `f32` may take it to be in.
pub(crate) fn tiles_of(
    place: &WrappedPoint,
    by_fragment: bool,
    levels: RangeInclusive<u32>,
) -> impl Iterator<Item = Tile> {
    const ROUNDING: f64 = ROUNDING_TEXELS / TILE_TEXELS;
    let [u, v] = [place.u, place.mercator_v(by_fragment)];
    let beside = move |level: u32| {
        let count = f64::from(level).exp2();
        let step = ROUNDING / count;
        let all = [
            [0.0, 0.0],
            [step, 0.0],
            [-step, 0.0],
            [0.0, step],
            [0.0, -step],
        ];
        // In the middle of a tile no other is near.
        let is_inside = [u, v].iter().all(|at| {
            let rest = at * count - (at * count).floor();
            (ROUNDING..1.0 - ROUNDING).contains(&rest)
        });
        let all = all.into_iter().take(if is_inside { 1 } else { all.len() });
        all.map(move |[x, y]| (level, u + x, v + y))
    };
    levels.flat_map(beside).filter_map(|(level, u, v)| {
        let v = v.clamp(0.0, 1.0_f64.next_down());
        MapTile::at(level, u, v).map(Tile::of)
    })
}

/// Pixels whose tiles are put together at once: sets of fewer would be merged again and again.
const PIXELS_OF_PART: usize = 1 << 16;

/// Tiles that a picture shows, sorted, both caps last.
pub(crate) fn tiles(truths: &[Option<Truth>], options: &Options) -> Vec<Tile> {
    let level = frame_level(truths, options);
    // Pixels beside each other mostly ask for the same tile.
    let asked = |(mut tiles, mut last): (BTreeSet<Tile>, Option<Tile>), truth: &Truth| {
        let [from, to] = truth.levels;
        let levels = level.map_or(from..=to, |level| level..=level);
        for tile in tiles_of(&truth.drawn, options.by_fragment, levels) {
            if last != Some(tile) {
                tiles.insert(tile);
            }
            last = Some(tile);
        }
        (tiles, last)
    };
    let parts = truths.par_chunks(PIXELS_OF_PART).map(|part| {
        let (tiles, _) = part.iter().flatten().fold(Default::default(), asked);
        tiles
    });
    let tiles: BTreeSet<Tile> = parts
        .flatten_iter()
        .collect::<Vec<_>>()
        .into_iter()
        .collect();
    let caps = [false, true].map(|is_south| Tile::Cap { is_south });
    tiles.into_iter().chain(caps).collect()
}

/// A texel as a picture shows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Texel {
    pub(crate) tile: Tile,
    pub(crate) x: u32,
    pub(crate) y: u32,
}

/// Texels by which a pixel beside the seam may be off.
pub(crate) const ALLOWED_TEXELS: f64 = 0.5;

/// How far outside a texel a place lies, texels; 0 inside it.
pub(crate) fn off_texels(texel: Texel, place: &WrappedPoint, by_fragment: bool) -> f64 {
    let beyond = |shown: f64, at: f64| ((shown + 0.5 - at).abs() - 0.5).max(0.0);
    let [x, y] = [texel.x, texel.y].map(f64::from);
    match (texel.tile, place.cap) {
        (Tile::Map { row, column, .. }, _) => {
            let side = texel.tile.texels();
            let shown = f64::from(column) * TILE_TEXELS + x;
            let at = place.u.rem_euclid(1.0) * side;
            // Round the map the nearer way.
            let at = at + side * ((shown - at) / side).round();
            let v = place.mercator_v(by_fragment);
            beyond(shown, at).max(beyond(f64::from(row) * TILE_TEXELS + y, v * side))
        }
        (Tile::Cap { .. }, Some(cap)) => {
            let [u, v] = cap.map(|at| at * TILE_TEXELS);
            beyond(x, u).max(beyond(y, v))
        }
        // A cap where the map reaches: by how much it should not have been, in its own texels.
        (Tile::Cap { .. }, None) => {
            let latitude = (TAU * (0.5 - place.by_vertex)).sinh().atan().abs();
            let end = terrafill_maps::max_latitude_rad();
            0.5 * TILE_TEXELS * (end - latitude).max(0.0) / (std::f64::consts::FRAC_PI_2 - end)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::views::tiled_view;

    #[test]
    fn far_below_the_body_a_level_goes_by_the_latitude_that_the_shader_has() {
        let eye = tiled_view("globe").eye(1024);
        let radii = eye.body.radii_m();
        let place = 0.6 * DVec3::new(0.5, 0.5, 0.7) * radii;
        let up = (place / (radii * radii)).normalize();
        // At a distance between what both latitudes ask for, geodetic latitude asks for another level.
        let latitudes = [up.z.asin(), eye.body.ecef_to_geodetic(place).latitude_rad];
        let round_m = latitudes.map(|latitude| {
            TAU * eye.body.equatorial_radius_m() * latitude.cos() * eye.focal_px() / TILE_TEXELS
        });
        assert!((latitudes[0] - latitudes[1]).abs() > 1e-3, "{latitudes:?}");
        let between_m = 0.5 * (round_m[0] + round_m[1]) / 8.0;
        let [by_shader, geodetic] = latitudes.map(f64::cos);
        let level = level_of(&eye.body, geodetic, eye.focal_px(), between_m);
        assert_ne!(wanted_level(&eye, place, between_m), level);
        assert_eq!(
            wanted_level(&eye, place, between_m),
            level_of(&eye.body, by_shader, eye.focal_px(), between_m)
        );
    }
}
