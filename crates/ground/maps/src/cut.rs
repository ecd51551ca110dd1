// SPDX-License-Identifier: MIT OR Apache-2.0
//! A picture of the whole body, by longitude and latitude, cut into tiles of a Web Mercator map and into the caps of its
//! poles.
//!
//! A texel shows the picture at its middle, interpolated between four texels of the level of the picture that is no
//! coarser than the tile, in sRGB bytes. Columns of the picture run from −180° east, rows from the north.

use crate::{CAP_SPAN, MapTile};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Texels along a side of a tile, as a number of them.
const SIDE: u32 = 256;

/// A size of a picture.
#[derive(Debug, Clone, Copy)]
pub struct PictureLevel<'a> {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Four bytes a texel, row by row.
    pub rgba: &'a [u8],
}

impl PictureLevel<'_> {
    /// Between four texels: round the body from east to west, and at most the outermost rows towards the poles.
    ///
    /// - `longitude_rad`, `latitude_rad`: geodetic
    #[must_use]
    #[allow(
        clippy::cast_possible_truncation,
        reason = "places inside a picture, and bytes between bytes"
    )]
    pub fn colour(&self, longitude_rad: f64, latitude_rad: f64) -> [u8; 4] {
        let [width, height] = [self.width, self.height].map(f64::from);
        let x = (longitude_rad / TAU + 0.5).rem_euclid(1.0) * width - 0.5;
        let y = ((0.5 - latitude_rad / PI) * height - 0.5).clamp(0.0, height - 1.0);
        let (left, top) = (x.floor(), y.floor());
        let texel = |column: f64, row: f64| {
            let column = column.rem_euclid(width) as usize;
            let row = row.min(height - 1.0) as usize;
            let at = 4 * (row * self.width as usize + column);
            [0, 1, 2, 3].map(|i| f64::from(self.rgba[at + i]))
        };
        let [a, b] = [0.0, 1.0].map(|across| texel(left + across, top));
        let [c, d] = [0.0, 1.0].map(|across| texel(left + across, top + 1.0));
        let (x, y) = (x - left, y - top);
        [0, 1, 2, 3].map(|i| {
            let (upper, lower) = (a[i] + x * (b[i] - a[i]), c[i] + x * (d[i] - c[i]));
            (upper + y * (lower - upper)).round() as u8
        })
    }
}

/// The coarsest level with at least so many columns, or the finest.
fn level_for<'a>(levels: &[PictureLevel<'a>], columns: f64) -> PictureLevel<'a> {
    let fine = levels
        .iter()
        .take_while(|level| f64::from(level.width) >= columns);
    *fine.last().unwrap_or(&levels[0])
}

/// Places of a texel's middle along a side, 0 … 1.
fn middles() -> impl Iterator<Item = f64> {
    (0..SIDE).map(|at| (f64::from(at) + 0.5) / f64::from(SIDE))
}

/// A tile's 256 × 256 texels, four bytes each, row by row.
///
/// - `levels`: of the picture, the finest first, at least one
#[must_use]
pub fn cut_tile(levels: &[PictureLevel<'_>], tile: MapTile) -> Vec<u8> {
    let tiles = f64::from(tile.level).exp2();
    let level = level_for(levels, tiles * f64::from(SIDE));
    let rows = middles().flat_map(|row| {
        let v = (tile.row as f64 + row) / tiles;
        let latitude_rad = (TAU * (0.5 - v)).sinh().atan();
        middles().flat_map(move |column| {
            let u = (tile.column as f64 + column) / tiles;
            level.colour((u - 0.5) * TAU, latitude_rad)
        })
    });
    rows.collect()
}

/// The same of a pole's cap, in the places of [`crate::cap_point`].
#[must_use]
pub fn cut_cap(levels: &[PictureLevel<'_>], is_south: bool) -> Vec<u8> {
    // A cap's side is 9.9°: a texel is as long as one of 9,300 columns.
    let level = levels[0];
    let sign = if is_south { -1.0 } else { 1.0 };
    let rows = middles().flat_map(|row| {
        middles().flat_map(move |column| {
            let [x, y] = [column, row].map(|at| (2.0 * at - 1.0) * CAP_SPAN);
            let latitude_rad = FRAC_PI_2 - 2.0 * x.hypot(y).atan();
            level.colour(y.atan2(x), sign * latitude_rad)
        })
    });
    rows.collect()
}

#[cfg(test)]
#[allow(clippy::cast_possible_truncation, reason = "places on small pictures")]
mod tests {
    use super::*;
    use crate::{MapPoint, cap_point, max_latitude_rad};
    use terrafill_core::{Ellipsoid, Geodetic};

    /// Red grows with longitude, green with latitude.
    fn picture() -> Vec<u8> {
        let texels = (0..128_u32).flat_map(|row| {
            (0..256_u32).map(move |column| {
                let [red, green] = [column, 2 * row].map(|at| u8::try_from(at).unwrap_or(u8::MAX));
                [red, green, 7, 255]
            })
        });
        texels.flatten().collect()
    }

    #[test]
    fn a_texel_shows_the_picture_where_its_place_is() {
        let rgba = picture();
        let level = PictureLevel {
            width: 256,
            height: 128,
            rgba: &rgba,
        };
        let body = Ellipsoid::UNIT_SPHERE;
        for (latitude, longitude) in [(0.3, 1.0), (-1.2, -2.9), (1.45, 0.2)] {
            let place = body.geodetic_to_ecef(Geodetic {
                longitude_rad: longitude,
                latitude_rad: latitude,
                height_m: 0.0,
            });
            let expected = level.colour(longitude, latitude);
            let point = MapPoint::new(&body, place);
            let tile = MapTile::at(3, point.u, point.mercator_v).expect("on the map");
            let cut = cut_tile(&[level], tile);
            let at = |along: f64, tile: u64| {
                let texel = (along * 8.0 - tile as f64) * 256.0;
                texel as usize
            };
            let texel = |x: usize, y: usize| 4 * (256 * y + x);
            let (x, y) = (at(point.u, tile.column), at(point.mercator_v, tile.row));
            for i in 0..2 {
                let off = i16::from(cut[texel(x, y) + i]) - i16::from(expected[i]);
                // A texel is an eighth of one of the picture.
                assert!(off.abs() <= 1, "{latitude} {longitude} {i} {off}");
            }
            // Negative control: a quarter of the tile beside it shows something else.
            let other = texel((x + 64) % 256, y);
            assert!(cut[other].abs_diff(expected[0]) > 5);
        }
        assert_eq!(
            cut_tile(
                &[level],
                MapTile {
                    level: 0,
                    column: 0,
                    row: 0
                }
            )
            .len(),
            4 * 256 * 256
        );
    }

    #[test]
    fn caps_show_the_picture_round_their_poles_and_coarse_tiles_a_coarse_level() {
        let rgba = picture();
        let fine = PictureLevel {
            width: 256,
            height: 128,
            rgba: &rgba,
        };
        let body = Ellipsoid::UNIT_SPHERE;
        for is_south in [false, true] {
            let cut = cut_cap(&[fine], is_south);
            let sign = if is_south { -1.0 } else { 1.0 };
            let latitude_rad = sign * (max_latitude_rad() + 0.02);
            let at = cap_point(body.geodetic_surface_normal(2.0, latitude_rad)).expect("a cap");
            let [x, y] = at.map(|at| (at * 256.0) as usize);
            let expected = fine.colour(2.0, latitude_rad);
            let found = cut[4 * (256 * y + x)];
            assert!(found.abs_diff(expected[0]) <= 2, "{found} {expected:?}");
            // Negative control: the other pole's rows.
            assert!(cut[4 * (256 * y + x) + 1].abs_diff(fine.colour(2.0, -latitude_rad)[1]) > 200);
        }
        let grey = [9; 4 * 8];
        let coarse = PictureLevel {
            width: 4,
            height: 2,
            rgba: &grey,
        };
        let levels = [fine, coarse];
        assert_eq!(level_for(&levels, 4.0).width, 4);
        assert_eq!(level_for(&levels, 5.0).width, 256);
        assert_eq!(level_for(&levels, 1e4).width, 256);
    }
}
