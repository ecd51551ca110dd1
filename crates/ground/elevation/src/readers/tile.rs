// SPDX-License-Identifier: MIT OR Apache-2.0
//! Map tiles in the colours of a PNG: terrain-RGB and terrarium, in Web Mercator.
//!
//! Terrain-RGB (Mapbox, "Terrain-RGB v1"): `−10,000 + (65,536 R + 256 G + B) / 10` metres. Terrarium
//! (Tilezen, "Terrain tiles: formats"): `256 R + G + B / 256 − 32,768` metres. Pixels stand for areas; a
//! pixel that is fully transparent is a void.

use crate::error::Complaints;
use crate::{ElevationError, Grid, HeightField, MAX_SAMPLES, Projection, Registration};
use image::{ImageFormat, ImageReader, Limits};
use std::f64::consts::PI;
use std::io::Cursor;

/// Deepest level of a tile's address: 4 cm a tile, which no service has.
const MAX_LEVEL: u32 = 30;
/// Longest side of a tile, pixels; services have 256 and 512.
const MAX_SIDE_PX: u32 = 4096;
/// Half a turn of EPSG:3857, metres.
const HALF_TURN_M: f64 = PI * 6_378_137.0;

/// What colours mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TileEncoding {
    /// Tenths of metres above −10,000 m.
    TerrainRgb,
    /// 256ths of metres above −32,768 m.
    Terrarium,
}

impl TileEncoding {
    /// As in names of files.
    fn name(self) -> &'static str {
        match self {
            Self::TerrainRgb => "terrain-rgb",
            Self::Terrarium => "terrarium",
        }
    }

    #[allow(clippy::cast_possible_truncation, reason = "f32 holds 24 bits")]
    fn height_m(self, [r, g, b, alpha]: [u8; 4]) -> f32 {
        if alpha == 0 {
            return f32::NAN;
        }
        let [r, g, b] = [r, g, b].map(f64::from);
        let height_m = match self {
            Self::TerrainRgb => (65_536.0 * r + 256.0 * g + b) / 10.0 - 10_000.0,
            Self::Terrarium => 256.0 * r + g + b / 256.0 - 32_768.0,
        };
        height_m as f32
    }
}

pub(super) fn read_named(
    complaints: Complaints<'_>,
    plain: &str,
    bytes: &[u8],
) -> Result<HeightField, ElevationError> {
    let encodings = [TileEncoding::TerrainRgb, TileEncoding::Terrarium];
    let named = encodings
        .into_iter()
        .find(|encoding| plain.contains(encoding.name()));
    let stem = plain.get(..plain.len().saturating_sub(4)).unwrap_or("");
    let from = stem.rfind(|c: char| !(c.is_ascii_digit() || c == '-'));
    let numbers = from.map_or(stem, |at| stem.get(at + 1..).unwrap_or(""));
    let parts: Option<Vec<u32>> = numbers.split('-').map(|part| part.parse().ok()).collect();
    match (named, parts.as_deref()) {
        (Some(encoding), Some(&[z, x, y])) => read(complaints, bytes, encoding, [z, x, y]),
        _ => Err(complaints.value(
            "name",
            format!("{plain:?}"),
            "terrain-rgb or terrarium, and z-x-y at the end, as in fuji_terrain-rgb_10-906-404.png",
        )),
    }
}

/// - level, column from 180° west, row from the north: at level 0 there is one tile, each level has twice as many a
///   side
fn read(
    complaints: Complaints<'_>,
    bytes: &[u8],
    encoding: TileEncoding,
    [z, x, y]: [u32; 3],
) -> Result<HeightField, ElevationError> {
    if z > MAX_LEVEL || x >> z > 0 || y >> z > 0 {
        let found = format!("{z}-{x}-{y}");
        let allowed = format!("z up to {MAX_LEVEL}, x and y below 2 to the z");
        return Err(complaints.value("tile address", found, allowed));
    }
    let broken = |error: image::ImageError| complaints.undecodable("PNG", error);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE_PX), Some(MAX_SIDE_PX));
    // Deflate packs at most 1,032 bytes into one; 16 bits a channel are twice what is needed.
    limits.max_alloc = Some((bytes.len() as u64 * 2 * 1032).min(MAX_SAMPLES * 8));
    reader.limits(limits);
    let picture = reader.decode().map_err(broken)?.into_rgba8();
    let (columns, rows) = picture.dimensions();
    let samples = picture
        .pixels()
        .map(|pixel| encoding.height_m(pixel.0))
        .collect();
    let side_m = 2.0 * HALF_TURN_M / 2_f64.powi(z.cast_signed());
    let step = [columns, rows].map(|count| side_m / f64::from(count.max(1)));
    let grid = Grid {
        projection: Projection::WebMercator,
        registration: Registration::Area,
        columns,
        rows,
        first: [
            f64::from(x) * side_m - HALF_TURN_M + 0.5 * step[0],
            HALF_TURN_M - f64::from(y) * side_m - 0.5 * step[1],
        ],
        step,
    };
    HeightField::new(complaints.file, grid, samples)
}
