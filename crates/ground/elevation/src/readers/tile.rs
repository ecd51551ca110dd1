// SPDX-License-Identifier: MIT OR Apache-2.0
//! Map tiles in the colours of a PNG: terrain-RGB and terrarium, in Web Mercator.
//!
//! Terrain-RGB (Mapbox, "Terrain-RGB v1"): `−10,000 + (65,536 R + 256 G + B) / 10` metres. Terrarium
//! (Tilezen, "Terrain tiles: formats"): `256 R + G + B / 256 − 32,768` metres. Pixels stand for areas; a
//! pixel that is fully transparent is a void. So is a black one of terrarium: −32,768 m is the lowest that it can say, and
//! what services send where they have nothing. A black one of terrain-RGB is −10,000 m by its formula, and a tile of
//! nothing else is read so with a warning.

use crate::error::Complaints;
use crate::{ElevationError, Grid, HeightField, MAX_SAMPLES, Projection, Registration};
use image::{ImageFormat, ImageReader, Limits};
use std::f64::consts::PI;
use std::io::Cursor;
use terrafill_core::nearest_f32;

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

    fn height_m(self, pixel: [u8; 4]) -> f32 {
        let [r, g, b, alpha] = pixel;
        if alpha == 0 || (self == Self::Terrarium && is_black(pixel)) {
            return f32::NAN;
        }
        let [r, g, b] = [r, g, b].map(f64::from);
        let height_m = match self {
            Self::TerrainRgb => (65_536.0 * r + 256.0 * g + b) / 10.0 - 10_000.0,
            Self::Terrarium => 256.0 * r + g + b / 256.0 - 32_768.0,
        };
        nearest_f32(height_m)
    }
}

fn is_black([r, g, b, _]: [u8; 4]) -> bool {
    [r, g, b] == [0; 3]
}

/// The encoding is in the path, the address at the end of the name as `z-x-y` or in folders as `z/x/y`.
pub(super) fn read_named(
    complaints: Complaints<'_>,
    bytes: &[u8],
) -> Result<HeightField, ElevationError> {
    let path = complaints.file;
    let encodings = [TileEncoding::TerrainRgb, TileEncoding::Terrarium];
    // terrain-rgb, terrain_rgb and terrainrgb are in use.
    let letters = |text: &str| text.to_ascii_lowercase().replace(['-', '_'], "");
    let folded = letters(path);
    let mut encodings = encodings.into_iter();
    let named = encodings.find(|encoding| folded.contains(&letters(encoding.name())));
    match (named, address(path)) {
        (Some(encoding), Some(address)) => read(complaints, bytes, encoding, address),
        _ => Err(complaints.value(
            "name",
            format!("{path:?}"),
            "terrain-rgb or terrarium, and z-x-y at the end, as in fuji_terrain-rgb_10-906-404.png, or folders z/x/y, \
             as in terrarium/10/906/404.png",
        )),
    }
}

/// Level, column and row in a path.
fn address(path: &str) -> Option<[u32; 3]> {
    let stem = path.get(..path.len().checked_sub(4)?)?;
    // What services append for twice the pixels.
    let stem = stem.strip_suffix("@2x").unwrap_or(stem);
    let mut folders = stem.rsplit(['/', '\\']);
    let last = folders.next()?;
    let parts: Vec<&str> = if last.bytes().all(|byte| byte.is_ascii_digit()) {
        let (x, z) = (folders.next()?, folders.next()?);
        vec![z, x, last]
    } else {
        let from = last.rfind(|c: char| !(c.is_ascii_digit() || c == '-'));
        let numbers = from.map_or(last, |at| last.get(at + 1..).unwrap_or(""));
        numbers.split('-').collect()
    };
    let parts: Option<Vec<u32>> = parts.iter().map(|part| part.parse().ok()).collect();
    parts?.try_into().ok()
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
    let heights = picture.pixels().map(|pixel| encoding.height_m(pixel.0));
    let mut samples: Vec<f32> = heights.collect();
    let mut warnings = Vec::new();
    if samples.iter().all(|sample| sample.is_nan()) {
        warnings.push(
            "every pixel is black or transparent, which says that there is no height: the tile is level at 0 m"
                .to_owned(),
        );
        samples.fill(0.0);
    } else if picture.pixels().all(|pixel| is_black(pixel.0)) {
        let height_m = samples[0];
        warnings.push(format!(
            "every pixel is black, which is {height_m} m by the formula and often means that there is no height"
        ));
    }
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
    Ok(HeightField::new(complaints.file, grid, samples)?.with_warnings(warnings))
}
