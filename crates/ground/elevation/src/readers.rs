// SPDX-License-Identifier: MIT OR Apache-2.0
//! From the bytes of a file to a height field: which format it is, and what all readers share.

mod dted;
mod geotiff;
mod hgt;
mod tile;

use crate::error::Complaints;
use crate::{ElevationError, HeightField};

/// Reads a file of heights. The end of its name says which format it has:
///
/// | ends in | format |
/// |---|---|
/// | `.tif`, `.tiff` | GeoTIFF in degrees or EPSG:3857; whole or floating-point samples |
/// | `.hgt` | SRTM, 1201 or 3601 samples a side; the name holds the corner, as in `N27E086` |
/// | `.hgt.zip` | the same in a zip archive |
/// | `.dt0`, `.dt1`, `.dt2` | DTED (MIL-PRF-89020B), checksums compared |
/// | `.png` | a map tile; the path holds `terrain-rgb` or `terrarium` and ends in `z-x-y` or `z/x/y` |
///
/// What a file says that changes the meaning of its samples is honoured or refused by name. What was read otherwise
/// than it says, or may be wrong, is in [`HeightField::warnings`].
///
/// USGS ASCII DEM (`.dem`) is refused: no maintained library reads it, and its heights are in UTM.
///
/// - `name`: of the file, with or without folders
///
/// # Errors
/// [`ElevationError`] for a name that fits no format and for anything wrong in the bytes. No more memory is
/// taken than a fixed multiple of the file's length, whatever its header says, and what ZSTD looks back on, up to 128 MiB.
pub fn read(name: &str, bytes: &[u8]) -> Result<HeightField, ElevationError> {
    let complaints = Complaints { file: name };
    let plain = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let lower = plain.to_ascii_lowercase();
    let ends = |endings: &[&str]| endings.iter().any(|ending| lower.ends_with(ending));
    if ends(&[".tif", ".tiff"]) {
        geotiff::read(complaints, bytes)
    } else if ends(&[".hgt.zip"]) {
        hgt::read_zipped(complaints, plain, bytes)
    } else if ends(&[".hgt"]) {
        hgt::read(complaints, plain, bytes)
    } else if ends(&[".dt0", ".dt1", ".dt2"]) {
        dted::read(complaints, bytes)
    } else if ends(&[".png"]) {
        tile::read_named(complaints, bytes)
    } else {
        let allowed =
            ".tif, .tiff, .hgt, .hgt.zip, .dt0, .dt1, .dt2 or .png; USGS ASCII DEM is not read";
        Err(complaints.value("end of the name", format!("{plain:?}"), allowed))
    }
}
