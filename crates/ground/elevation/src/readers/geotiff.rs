// SPDX-License-Identifier: MIT OR Apache-2.0
//! GeoTIFF (OGC 19-008r4, 2019): one band of whole or floating-point heights, in degrees or EPSG:3857.

use crate::error::Complaints;
use crate::{ElevationError, Grid, HeightField, MAX_SAMPLES, Projection, Registration};
use std::io::Cursor;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

/// Keys of the GeoKeyDirectory, OGC 19-008r4, annex D, by their numbers there.
const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const GEODETIC_CRS: u16 = 2048;
const ANGULAR_UNITS: u16 = 2054;
const PROJECTED_CRS: u16 = 3072;
const LINEAR_UNITS: u16 = 3076;
const VERTICAL_UNITS: u16 = 4099;
/// Values of the keys.
const MODEL_PROJECTED: u16 = 1;
const MODEL_GEOGRAPHIC: u16 = 2;
const PIXEL_IS_AREA: u16 = 1;
const PIXEL_IS_POINT: u16 = 2;
const DEGREE: u16 = 9102;
const METRE: u16 = 9001;
const WEB_MERCATOR: u16 = 3857;
/// WGS 84, NAD 83, WGS 72 and ETRS 89: within two metres of each other, a small part of a sample.
const GEODETIC: [u16; 4] = [4326, 4269, 4322, 4258];
/// A key that says "defined elsewhere" leaves the model's type to speak.
const USER_DEFINED: u16 = 32_767;
/// Bytes that a byte of a packed strip may become: LZW's longest string in its shortest code.
const MAX_EXPANSION: u64 = 4096;

pub(super) fn read(
    complaints: Complaints<'_>,
    bytes: &[u8],
) -> Result<HeightField, ElevationError> {
    let broken = |error: tiff::TiffError| complaints.undecodable("GeoTIFF", error);
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(broken)?;
    let (columns, rows) = decoder.dimensions().map_err(broken)?;
    let count = u64::from(columns) * u64::from(rows);
    let most = MAX_SAMPLES.min(bytes.len() as u64 * MAX_EXPANSION);
    if count < 4 || count > most {
        let found = format!("{columns} × {rows}");
        let allowed = format!("2 × 2 to {most} samples in a file of {} bytes", bytes.len());
        return Err(complaints.value("size", found, allowed));
    }
    let mut limits = Limits::default();
    // A sample has up to eight bytes, and a strip is unpacked before it is copied. A number of a tag takes
    // up to 64 times its bytes while it is read.
    let for_samples = usize::try_from(count * 8).unwrap_or(usize::MAX);
    let for_tags = bytes.len().saturating_mul(64);
    limits.decoding_buffer_size = for_samples.max(for_tags);
    limits.intermediate_buffer_size = limits.decoding_buffer_size;
    limits.ifd_value_size = for_tags;
    decoder = decoder.with_limits(limits);
    let place = Place::read(complaints, &mut decoder)?;
    let no_data = no_data(complaints, &mut decoder)?;
    let image = decoder.read_image().map_err(broken)?;
    let samples = samples(complaints, image, no_data, columns)?;
    let grid = place.grid(columns, rows);
    HeightField::new(complaints.file, grid, samples)
}

/// What a file says of where it lies.
struct Place {
    projection: Projection,
    registration: Registration,
    /// Column and row that have a known place.
    tie: [f64; 2],
    /// That place.
    at: [f64; 2],
    scale: [f64; 2],
}

impl Place {
    fn read(
        complaints: Complaints<'_>,
        decoder: &mut Decoder<Cursor<&[u8]>>,
    ) -> Result<Self, ElevationError> {
        let mut numbers =
            |tag: Tag, name: &str, least: usize| -> Result<Vec<f64>, ElevationError> {
                let found = decoder.find_tag(tag).ok().flatten();
                let found = found
                    .and_then(|value| value.into_f64_vec().ok())
                    .unwrap_or_default();
                if found.len() < least {
                    let words = format!("{} numbers", found.len());
                    return Err(complaints.value(name, words, format!("at least {least}")));
                }
                Ok(found)
            };
        let scale = numbers(Tag::ModelPixelScaleTag, "ModelPixelScale", 2)?;
        let tie = numbers(Tag::ModelTiepointTag, "ModelTiepoint", 6)?;
        let keys = decoder.find_tag(Tag::GeoKeyDirectoryTag).ok().flatten();
        let keys = keys
            .and_then(|value| value.into_u16_vec().ok())
            .unwrap_or_default();
        let key = |wanted: u16| -> Option<u16> {
            // Four numbers a key: which, where its value is (0: here), how many, the value.
            let mut entries = keys.chunks_exact(4).skip(1);
            entries
                .find(|entry| entry[0] == wanted && entry[1] == 0)
                .map(|entry| entry[3])
        };
        let only = |name: &str, found: Option<u16>, allowed: &[u16]| match found {
            Some(found) if !allowed.contains(&found) => {
                let allowed: Vec<String> = allowed.iter().map(u16::to_string).collect();
                Err(complaints.value(name, found, allowed.join(", ")))
            }
            _ => Ok(()),
        };
        let projection = match (key(MODEL_TYPE), key(PROJECTED_CRS), key(GEODETIC_CRS)) {
            (Some(MODEL_GEOGRAPHIC), _, crs) => {
                only("GeodeticCRS", crs.filter(|&c| c != USER_DEFINED), &GEODETIC)?;
                Projection::Geographic
            }
            (Some(MODEL_PROJECTED), Some(WEB_MERCATOR), _) => Projection::WebMercator,
            (model, projected, _) => {
                let found = format!("{model:?} with ProjectedCRS {projected:?}");
                let allowed = "2 (degrees), or 1 (projected) with ProjectedCRS 3857";
                return Err(complaints.value("GTModelType", found, allowed));
            }
        };
        match projection {
            Projection::Geographic => only("GeogAngularUnits", key(ANGULAR_UNITS), &[DEGREE])?,
            Projection::WebMercator => only("ProjLinearUnits", key(LINEAR_UNITS), &[METRE])?,
        }
        only("VerticalUnits", key(VERTICAL_UNITS), &[METRE])?;
        let raster = key(RASTER_TYPE);
        only("GTRasterType", raster, &[PIXEL_IS_AREA, PIXEL_IS_POINT])?;
        Ok(Self {
            projection,
            registration: match raster {
                Some(PIXEL_IS_POINT) => Registration::Point,
                // What the standard says of a file that says nothing.
                _ => Registration::Area,
            },
            tie: [tie[0], tie[1]],
            at: [tie[3], tie[4]],
            scale: [scale[0], scale[1]],
        })
    }

    /// A tie point is a corner of a cell where pixels are areas, a sample where they are points.
    fn grid(&self, columns: u32, rows: u32) -> Grid {
        let half = match self.registration {
            Registration::Area => 0.5,
            Registration::Point => 0.0,
        };
        Grid {
            projection: self.projection,
            registration: self.registration,
            columns,
            rows,
            first: [
                self.at[0] + (half - self.tie[0]) * self.scale[0],
                self.at[1] - (half - self.tie[1]) * self.scale[1],
            ],
            step: self.scale,
        }
    }
}

/// GDAL's word for voids.
fn no_data(
    complaints: Complaints<'_>,
    decoder: &mut Decoder<Cursor<&[u8]>>,
) -> Result<Option<f64>, ElevationError> {
    let Some(value) = decoder.find_tag(Tag::GdalNodata).ok().flatten() else {
        return Ok(None);
    };
    let text = value.into_string().unwrap_or_default();
    let text = text.trim_matches(['\0', ' ']);
    let number = text.parse().map(Some);
    number.map_err(|_| complaints.value("GDAL_NODATA", format!("{text:?}"), "a number or nan"))
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "heights of a planet in f32: half a millimetre at 8 km"
)]
fn samples(
    complaints: Complaints<'_>,
    image: DecodingResult,
    no_data: Option<f64>,
    columns: u32,
) -> Result<Vec<f32>, ElevationError> {
    // A NaN is a void only where the file says so.
    let void_is_nan = no_data.is_some_and(f64::is_nan);
    let height = |index: usize, value: f64| -> Result<f32, ElevationError> {
        if value.is_nan() && !void_is_nan {
            let (columns, allowed) = (columns as usize, "a number, or nan named by GDAL_NODATA");
            let place = format!(
                "sample in column {}, row {}",
                index % columns,
                index / columns
            );
            return Err(complaints.value(place, value, allowed));
        }
        // Both are the same digits of the same number.
        let is_void = no_data
            .is_some_and(|void| void.to_bits() == value.to_bits() || void as f32 == value as f32);
        Ok(if is_void { f32::NAN } else { value as f32 })
    };
    fn all<T: Copy + Into<f64>>(
        samples: Vec<T>,
        height: impl Fn(usize, f64) -> Result<f32, ElevationError>,
    ) -> Result<Vec<f32>, ElevationError> {
        let samples = samples.into_iter().enumerate();
        samples
            .map(|(index, sample)| height(index, sample.into()))
            .collect()
    }
    match image {
        DecodingResult::I16(samples) => all(samples, height),
        DecodingResult::U16(samples) => all(samples, height),
        DecodingResult::I32(samples) => all(samples, height),
        DecodingResult::F32(samples) => all(samples, height),
        DecodingResult::F64(samples) => all(samples, height),
        _ => Err(complaints.value(
            "samples",
            "another type",
            "whole numbers of 16 bits or signed ones of 32, or floating-point numbers of 32 or 64",
        )),
    }
}
