// SPDX-License-Identifier: MIT OR Apache-2.0
//! What GDAL says of samples in tags of its own: which value is a void, and scale, offset and unit of a band.
//!
//! Source: GDAL's GeoTIFF driver, "Nodata value" and "Metadata": `GDAL_METADATA` is XML with an `Item` for each.

use crate::ElevationError;
use crate::error::Complaints;
use std::io::Cursor;
use terrafill_core::nearest_f32;
use tiff::decoder::Decoder;
use tiff::tags::Tag;

const GDAL_METADATA: u16 = 42_112;
/// Names of units as GDAL and people write them, and metres of each.
const UNITS: &[(&[&str], f64)] = &[
    (&["", "m", "metre", "metres", "meter", "meters"], 1.0),
    (&["ft", "foot", "feet", "international foot"], 0.3048),
    (
        &["us-ft", "ftus", "us survey foot", "foot_us"],
        1200.0 / 3937.0,
    ),
    (&["km"], 1000.0),
    (&["dm"], 0.1),
    (&["cm"], 0.01),
    (&["mm"], 0.001),
];

/// How a sample becomes a height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Metadata {
    pub(super) no_data: Option<f64>,
    scale: f64,
    offset: f64,
    /// Metres of the unit.
    unit_m: f64,
}

impl Metadata {
    /// - `vertical_m`: metres of the unit that the file's vertical system has
    pub(super) fn read(
        complaints: Complaints<'_>,
        decoder: &mut Decoder<Cursor<&[u8]>>,
        vertical_m: Option<f64>,
    ) -> Result<Self, ElevationError> {
        let mut metadata = Self {
            no_data: no_data(complaints, decoder)?,
            scale: 1.0,
            offset: 0.0,
            unit_m: vertical_m.unwrap_or(1.0),
        };
        let value = decoder.find_tag(Tag::from_u16_exhaustive(GDAL_METADATA));
        let value = value.ok().flatten();
        let xml = value.map_or(Ok(String::new()), |value| value.into_string());
        let xml = xml.map_err(|_| complaints.value("GDAL_METADATA", "no text", "XML"))?;
        for (attributes, text) in items(&xml) {
            // Of another band.
            if attribute(attributes, "sample").is_some_and(|sample| sample != "0") {
                continue;
            }
            let number = |name: &str, allowed: &str, is_right: fn(f64) -> bool| {
                let number = text.trim().parse::<f64>().ok();
                let number = number.filter(|number| number.is_finite() && is_right(*number));
                number.ok_or_else(|| {
                    complaints.value(
                        format!("GDAL_METADATA, {name}"),
                        format!("{text:?}"),
                        allowed,
                    )
                })
            };
            match attribute(attributes, "role") {
                Some("scale") => {
                    metadata.scale = number("SCALE", "a number that is not 0", |n| n != 0.0)?;
                }
                Some("offset") => metadata.offset = number("OFFSET", "a number", |_| true)?,
                Some("unittype") => {
                    let unit = text.trim().to_lowercase();
                    let mut units = UNITS.iter();
                    let found = units.find(|(names, _)| names.contains(&unit.as_str()));
                    let named = |allowed: String| {
                        complaints.value("GDAL_METADATA, UNITTYPE", format!("{text:?}"), allowed)
                    };
                    let Some((_, unit_m)) = found else {
                        let all = UNITS.iter().flat_map(|(names, _)| *names);
                        let all: Vec<&str> = all.copied().filter(|name| !name.is_empty()).collect();
                        return Err(named(all.join(", ")));
                    };
                    match vertical_m {
                        Some(other) if other != *unit_m && !unit.is_empty() => {
                            return Err(named(format!(
                                "the unit of the file's vertical system, {other} m"
                            )));
                        }
                        Some(_) => {}
                        None => metadata.unit_m = *unit_m,
                    }
                }
                _ => {}
            }
        }
        Ok(metadata)
    }

    /// NaN is a void.
    pub(super) fn height_m(&self, value: f64) -> f32 {
        // Both are the same digits of the same number.
        let is_void = self.no_data.is_some_and(|void| {
            void.to_bits() == value.to_bits() || nearest_f32(void) == nearest_f32(value)
        });
        if is_void {
            f32::NAN
        } else {
            nearest_f32((value * self.scale + self.offset) * self.unit_m)
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

/// Attributes and text of each item.
fn items(xml: &str) -> impl Iterator<Item = (&str, &str)> {
    xml.split("<Item ").skip(1).filter_map(|item| {
        let (attributes, rest) = item.split_once('>')?;
        Some((attributes, rest.split_once("</Item>")?.0))
    })
}

fn attribute<'a>(attributes: &'a str, name: &str) -> Option<&'a str> {
    let mut all = attributes
        .split_inclusive('"')
        .collect::<Vec<_>>()
        .into_iter();
    while let (Some(key), Some(value)) = (all.next(), all.next()) {
        if key.trim().strip_suffix("=\"") == Some(name) {
            return value.strip_suffix('"');
        }
    }
    None
}
