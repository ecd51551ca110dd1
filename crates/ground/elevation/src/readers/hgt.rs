// SPDX-License-Identifier: MIT OR Apache-2.0
//! SRTM tiles: a degree square of big-endian 16-bit whole metres, rows from the north, no header. The
//! name holds the south-western corner. Source: USGS, "SRTM Topography" (documentation of SRTM 2.1).

use crate::error::Complaints;
use crate::{ElevationError, Grid, HeightField, Projection, Registration};
use std::io::{Cursor, Read as _};

/// Samples a side at 3 and at 1 arc-second.
const SIDES: [u32; 2] = [1201, 3601];
/// A sample that has no height.
const VOID: i16 = -32_768;
/// Characters of a corner.
const CORNER: usize = 7;

pub(super) fn read(
    complaints: Complaints<'_>,
    plain: &str,
    bytes: &[u8],
) -> Result<HeightField, ElevationError> {
    let length = |side: u32| 2 * side as usize * side as usize;
    let Some(side) = SIDES.into_iter().find(|&side| length(side) == bytes.len()) else {
        let allowed = SIDES.map(|side| format!("{} ({side} × {side} samples)", length(side)));
        return Err(complaints.value("bytes", bytes.len(), allowed.join(" or ")));
    };
    let [west_deg, south_deg] = corner(plain).ok_or_else(|| {
        let allowed = "a corner such as N27E086, up to 90° and 180°";
        complaints.value("name", format!("{plain:?}"), allowed)
    })?;
    // N45W074T86 is one of the 81 tiles of a degree at 1/3 arc-second, and as large as a whole degree at 3.
    let is_more = |next: char| next.is_ascii_alphanumeric();
    if plain.chars().nth(CORNER).is_some_and(is_more) {
        let allowed = "a corner such as N27E086 alone or before a character that is no letter or digit, for a whole \
                       degree; a tile of a part of one has no header that says where it lies: as a GeoTIFF, by \
                       `gdal_translate -a_ullr WEST NORTH EAST SOUTH`, it is read";
        return Err(complaints.value("name", format!("{plain:?}"), allowed));
    }
    let step = 1.0 / f64::from(side - 1);
    let grid = Grid {
        projection: Projection::Geographic,
        registration: Registration::Point,
        columns: side,
        rows: side,
        first: [west_deg, south_deg + 1.0],
        step: [step, step],
    };
    let sample = |pair: &[u8]| match i16::from_be_bytes([pair[0], pair[1]]) {
        VOID => f32::NAN,
        height_m => f32::from(height_m),
    };
    HeightField::new(
        complaints.file,
        grid,
        bytes.chunks_exact(2).map(sample).collect(),
    )
}

/// The first `.hgt` of an archive. Its corner is in its own name.
pub(super) fn read_zipped(
    complaints: Complaints<'_>,
    plain: &str,
    bytes: &[u8],
) -> Result<HeightField, ElevationError> {
    let broken = |error: zip::result::ZipError| complaints.undecodable("zip archive", error);
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(broken)?;
    let names =
        (0..archive.len()).filter_map(|i| Some(archive.name_for_index(i)?.ok()?.into_owned()));
    let mut names = names.collect::<Vec<String>>().into_iter();
    let entry = names.find(|name| name.to_ascii_lowercase().ends_with(".hgt"));
    let Some(entry) = entry else {
        let found = format!("{} files, none of which ends in .hgt", archive.len());
        return Err(complaints.value("archive", found, "a file that ends in .hgt"));
    };
    let file = archive.by_name(&entry).map_err(broken)?;
    let most = 2 * u64::from(SIDES[1]) * u64::from(SIDES[1]);
    let mut unpacked = Vec::new();
    // One byte more than allowed tells a bomb from a tile. What the archive says of sizes is not asked.
    let outcome = file.take(most + 1).read_to_end(&mut unpacked);
    outcome.map_err(|error| complaints.undecodable("zip archive", error))?;
    if unpacked.len() as u64 > most {
        let found = format!("more than {most} bytes");
        return Err(complaints.value(
            format!("{entry} unpacked"),
            found,
            format!("at most {most}"),
        ));
    }
    let inner = entry.rsplit(['/', '\\']).next().unwrap_or(&entry);
    let named = if corner(inner).is_some() {
        inner
    } else {
        plain
    };
    read(complaints, named, &unpacked)
}

/// Longitude and latitude of the south-western corner, degrees.
fn corner(plain: &str) -> Option<[f64; 2]> {
    let name = plain.get(..CORNER)?.to_ascii_uppercase();
    let signed = |text: &str, letters: [char; 2], most: i32| -> Option<f64> {
        let digits = text
            .get(1..)
            .filter(|t| t.bytes().all(|b| b.is_ascii_digit()))?;
        let degrees: i32 = digits.parse().ok()?;
        let degrees = match text.chars().next()? {
            letter if letter == letters[0] => degrees,
            letter if letter == letters[1] => -degrees,
            _ => return None,
        };
        (-most..most).contains(&degrees).then(|| f64::from(degrees))
    };
    let latitude = signed(name.get(..3)?, ['N', 'S'], 90)?;
    let longitude = signed(name.get(3..)?, ['E', 'W'], 180)?;
    Some([longitude, latitude])
}
