// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where on a Web Mercator map a point of the body is: equations (5) to (8), the tile that holds it, and the
//! level of detail that a pixel asks for.
//!
//! `U` runs east from the antimeridian, `V` with geodetic latitude, `V'` from north (0) to south (1), all over
//! the map's width of 1. Poleward of [`max_latitude_rad`] there is no map, and `V'` is outside 0 … 1.

use glam::DVec3;
use std::f64::consts::TAU;
use terrafill_core::{Ellipsoid, Geodetic};

/// Texels along a side of a tile.
pub const TILE_TEXELS: f64 = 256.0;

/// `atan(sinh π)`, and its sine: asked for each pixel of a picture.
const MAX_LATITUDE_RAD: f64 = 1.484_422_229_745_332_4;
/// `tanh π`.
pub(crate) const END_SINE: f64 = 0.996_272_076_220_749_9;

/// Eq. (7), `M`: where a map as high as wide ends, 85.0511287798°.
#[must_use]
pub fn max_latitude_rad() -> f64 {
    MAX_LATITUDE_RAD
}

/// A vertex's texture coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapPoint {
    /// Eq. (5).
    pub u: f64,
    /// Eq. (6), linear in latitude: what is interpolated where (8) is left to the fragment.
    pub v: f64,
    /// Eq. (8): what is interpolated where the vertex applies it.
    pub mercator_v: f64,
}

impl MapPoint {
    /// Of the place straight above or below a point.
    #[must_use]
    pub fn new(body: &Ellipsoid, ecef: DVec3) -> Self {
        let place = body.ecef_to_geodetic(ecef);
        let v = 0.5 + place.latitude_rad / (2.0 * max_latitude_rad());
        Self {
            u: 0.5 + place.longitude_rad / TAU,
            v,
            mercator_v: mercator_v(v),
        }
    }
}

/// Eq. (8): `V' = ½ − asinh(tan(2M (V − ½))) / 2π`.
#[must_use]
pub fn mercator_v(v: f64) -> f64 {
    let latitude_rad = 2.0 * max_latitude_rad() * (v - 0.5);
    0.5 - latitude_rad.tan().asinh() / TAU
}

/// Eq. (8) of a place by the body's unit normal there: `V' = ½ ∓ ln((1 + |sin φ|) / cos φ) / 2π`, counted from the nearer
/// pole, where nothing cancels.
#[must_use]
pub fn mercator_v_of(normal: DVec3) -> f64 {
    // At a pole itself far off the map, and a number.
    let across = normal.x.hypot(normal.y).max(f64::MIN_POSITIVE);
    let up = ((1.0 + normal.z.abs()) / across).ln();
    0.5 - up.copysign(normal.z) / TAU
}

/// The place on the body that a map shows at `(U, V')`.
#[must_use]
pub fn place(body: &Ellipsoid, u: f64, mercator_v: f64) -> DVec3 {
    body.geodetic_to_ecef(Geodetic {
        longitude_rad: (u - 0.5) * TAU,
        latitude_rad: (TAU * (0.5 - mercator_v)).sinh().atan(),
        height_m: 0.0,
    })
}

/// A tile of the map: 2^level of them along a side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct MapTile {
    /// 0 is the whole map.
    pub level: u32,
    /// From the antimeridian east.
    pub column: u64,
    /// From the north.
    pub row: u64,
}

impl MapTile {
    /// The tile that holds `(U, V')`; `None` where there is no map.
    #[must_use]
    #[allow(
        clippy::cast_possible_truncation,
        reason = "a place on the map is inside 0 … 1"
    )]
    pub fn at(level: u32, u: f64, mercator_v: f64) -> Option<Self> {
        let side = f64::from(level).exp2();
        // U = 1 is U = 0.
        let [column, row] = [u.rem_euclid(1.0), mercator_v].map(|at| (at * side).floor());
        (0.0..1.0).contains(&mercator_v).then_some(Self {
            level,
            column: (column as u64).min((side - 1.0) as u64),
            row: row as u64,
        })
    }
}

/// The least level of which no texel is larger than a pixel: `⌈log2(2πR cos φ f / 256 d)⌉`.
///
/// - `cosine`: of the latitude φ
/// - `focal_px`: pixels per radian in the image's middle
/// - `distance_m`: from the eye
#[must_use]
#[allow(
    clippy::cast_possible_truncation,
    reason = "a level is small and not negative"
)]
pub fn level_of(body: &Ellipsoid, cosine: f64, focal_px: f64, distance_m: f64) -> u32 {
    let round_m = TAU * body.equatorial_radius_m() * cosine;
    let level = (round_m * focal_px / (TILE_TEXELS * distance_m)).log2();
    level.ceil().max(0.0) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_papers_form_is_web_mercator() {
        assert!((max_latitude_rad().to_degrees() - 85.051_128_779_8).abs() < 1e-10);
        assert!((max_latitude_rad() - PI.sinh().atan()).abs() < f64::EPSILON);
        assert!((END_SINE - PI.tanh()).abs() < f64::EPSILON);
        assert!(mercator_v_of(DVec3::Z).is_finite() && mercator_v_of(-DVec3::Z) > 1.0);
        let body = Ellipsoid::WGS84;
        for i in -850..=850_i32 {
            let latitude_rad = (f64::from(i) * 0.1).to_radians();
            let at = Geodetic {
                longitude_rad: 1.0,
                latitude_rad,
                height_m: 0.0,
            };
            let ecef = body.geodetic_to_ecef(at);
            let point = MapPoint::new(&body, ecef);
            let usual = 0.5 - (PI / 4.0 + latitude_rad / 2.0).tan().ln() / TAU;
            assert!((point.mercator_v - usual).abs() < 2e-15, "{i}");
            let (normal, _) = body.normal_and_height(ecef);
            assert!((mercator_v_of(normal) - usual).abs() < 2e-15, "{i}");
            let back = place(&body, point.u, point.mercator_v);
            assert!((back - ecef).length() < 1e-7, "{i}");
            // Negative control: geocentric latitude is up to 21.4 km off.
            let centric = (ecef.z / ecef.x.hypot(ecef.y)).atan();
            let v = 0.5 + centric / (2.0 * max_latitude_rad());
            let off = (place(&body, point.u, mercator_v(v)) - ecef).length();
            assert!(i.abs() != 450 || (off - 21_400.0).abs() < 100.0, "{off}");
        }
    }

    #[test]
    fn a_tile_holds_its_place_and_the_map_ends_at_its_rim() {
        let (edge, body) = (max_latitude_rad(), Ellipsoid::UNIT_SPHERE);
        let v_of = |latitude_rad: f64| mercator_v(0.5 + latitude_rad / (2.0 * edge));
        assert!(v_of(edge).abs() < 1e-15 && (v_of(-edge) - 1.0).abs() < 1e-15);
        assert_eq!(MapTile::at(3, 0.3, v_of(edge + 1e-9)), None);
        assert_eq!(MapTile::at(3, 0.3, v_of(-edge - 1e-9)), None);
        for latitude_rad in [edge.next_down(), edge, edge.next_up()] {
            assert!(v_of(latitude_rad).is_finite());
        }
        let tile = |level, column, row| Some(MapTile { level, column, row });
        assert_eq!(MapTile::at(0, 0.999, 0.5), tile(0, 0, 0));
        assert_eq!(MapTile::at(2, 0.3, 0.8), tile(2, 1, 3));
        assert_eq!(MapTile::at(2, 1.0, 0.0), tile(2, 0, 0));
        // A texel of the equator at level 10 is 2πR / 262,144 wide. Where a pixel is as wide, level 10 is
        // enough, and from nearer it is not.
        let texel_m = TAU / 262_144.0;
        assert_eq!(level_of(&body, 1.0, 100.0, 100.0 * texel_m * 1.001), 10);
        assert_eq!(level_of(&body, 1.0, 100.0, 100.0 * texel_m * 0.999), 11);
    }
}
