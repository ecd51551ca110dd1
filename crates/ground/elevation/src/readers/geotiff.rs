// SPDX-License-Identifier: MIT OR Apache-2.0
//! GeoTIFF (OGC 19-008r4, 2019): one band of whole or floating-point heights, in degrees or EPSG:3857.
//!
//! Whatever changes the meaning of a sample is honoured, or refused by its name with the command that writes a file
//! without it: [`tags`] lists every tag, [`place`] every key.

mod metadata;
mod place;
mod samples;
mod tags;

use self::metadata::Metadata;
use self::place::RasterPlace;
use crate::error::Complaints;
use crate::{ElevationError, HeightField, MAX_SAMPLES};
use std::io::Cursor;
use tiff::decoder::{Decoder, Limits};
use tiff::tags::{IfdPointer, Tag};

/// Samples that a byte of a packed block may become: LZW's longest string in its shortest code.
const MAX_EXPANSION: u64 = 4096;
/// The same of ZSTD: its longest run in its shortest block, 128 KiB in four bytes.
const MAX_EXPANSION_OF_ZSTD: u64 = 32_768;
const ZSTD: u16 = 50_000;
const PHOTOMETRIC: u16 = 262;
/// Values of it: samples as they are, and a mask.
const WHITE_IS_ZERO: u16 = 0;
const BLACK_IS_ZERO: u16 = 1;
/// Bits of `NewSubfileType`.
const OVERVIEW: u32 = 1;
const MASK: u32 = 4;
/// Images of a file that are looked at: pyramids have a dozen, each with a mask.
const MAX_IMAGES: usize = 64;

type Tiff<'a> = Decoder<Cursor<&'a [u8]>>;

pub(super) fn read(
    complaints: Complaints<'_>,
    bytes: &[u8],
) -> Result<HeightField, ElevationError> {
    let broken = |error: tiff::TiffError| complaints.undecodable("GeoTIFF", error);
    let mut decoder = open(complaints, bytes)?;
    let mut warnings = tags::check(complaints, &mut decoder)?;
    let place = RasterPlace::read(complaints, &mut decoder)?;
    warnings.extend(place.warnings.iter().cloned());
    let metadata = Metadata::read(complaints, &mut decoder, place.unit_m)?;
    let (columns, rows) = decoder.dimensions().map_err(broken)?;
    let interpretation = decoder.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation);
    let plain;
    if interpretation.map_err(broken)? == Some(WHITE_IS_ZERO) {
        // `tiff` would turn samples over, as a picture needs it.
        warnings.push(
            "PhotometricInterpretation is 0 (WhiteIsZero), which is about display: heights are read as they are"
                .to_owned(),
        );
        let first = decoder.ifd_pointer();
        plain = interpreted(bytes, first.unwrap_or(IfdPointer(0)), BLACK_IS_ZERO);
        decoder = open(complaints, &plain)?;
    }
    let mut samples = samples::read(complaints, &mut decoder, &metadata, &mut warnings)?;
    let (masks, others) = further_images(&mut decoder);
    if others > 0 {
        warnings.push(format!(
            "the file has {others} further images; the first one is read"
        ));
    }
    if let Some((index, at)) = masks.first() {
        let as_picture = interpreted(bytes, *at, BLACK_IS_ZERO);
        let mut mask = open(complaints, &as_picture)?;
        mask.seek_to_image(*index).map_err(broken)?;
        samples::apply_mask(complaints, &mut mask, (columns, rows), &mut samples)?;
    }
    if place.is_south_up {
        let rows = samples.chunks_exact(columns as usize).rev();
        samples = rows.flatten().copied().collect();
    }
    let field = HeightField::new(complaints.file, place.grid(columns, rows), samples)?;
    Ok(field.with_warnings(warnings))
}

/// A decoder at the first image, which takes no more memory than a multiple of the file.
fn open<'a>(complaints: Complaints<'_>, bytes: &'a [u8]) -> Result<Tiff<'a>, ElevationError> {
    let broken = |error: tiff::TiffError| complaints.undecodable("GeoTIFF", error);
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(broken)?;
    let (columns, rows) = decoder.dimensions().map_err(broken)?;
    let count = u64::from(columns) * u64::from(rows);
    let compression = decoder.find_tag_unsigned::<u16>(Tag::Compression);
    let expansion = match compression.ok().flatten() {
        Some(ZSTD) => MAX_EXPANSION_OF_ZSTD,
        _ => MAX_EXPANSION,
    };
    let most = MAX_SAMPLES.min(bytes.len() as u64 * expansion);
    if count < 4 || count > most {
        let found = format!("{columns} × {rows}");
        let allowed = format!("2 × 2 to {most} samples in a file of {} bytes", bytes.len());
        return Err(complaints.value("size", found, allowed));
    }
    let mut limits = Limits::default();
    // A sample has up to eight bytes, two bands of them, and a strip is unpacked before it is copied. A number of a tag
    // takes up to 64 times its bytes while it is read.
    let for_samples = usize::try_from(count * 16).unwrap_or(usize::MAX);
    let for_tags = bytes.len().saturating_mul(64);
    limits.decoding_buffer_size = for_samples.max(for_tags);
    limits.intermediate_buffer_size = limits.decoding_buffer_size;
    limits.ifd_value_size = for_tags;
    Ok(decoder.with_limits(limits))
}

/// Masks of the full image, with their places among the images and in the file; and how many others there are that are
/// no overviews.
fn further_images(decoder: &mut Tiff<'_>) -> (Vec<(usize, IfdPointer)>, usize) {
    let (mut masks, mut others) = (Vec::new(), 0);
    let first = decoder
        .ifd_pointer()
        .and_then(|first| decoder.read_directory(first).ok());
    let mut next = first.and_then(|directory| directory.next());
    for index in 1..MAX_IMAGES {
        let Some(at) = next else { break };
        let Ok(directory) = decoder.read_directory(at) else {
            break;
        };
        next = directory.next();
        let mut tags = decoder.read_directory_tags(&directory);
        let kind = tags.find_tag_unsigned::<u32>(Tag::NewSubfileType);
        let kind = kind.ok().flatten().unwrap_or(0);
        if kind & OVERVIEW == 0 {
            match kind & MASK {
                0 => others += 1,
                _ => masks.push((index, at)),
            }
        }
    }
    (masks, others)
}

/// A copy of the file in which an image has another interpretation: `tiff` neither reads masks nor leaves white alone.
fn interpreted(bytes: &[u8], image: IfdPointer, interpretation: u16) -> Vec<u8> {
    let mut copy = bytes.to_vec();
    let is_little = bytes.starts_with(b"II");
    let number = |at: usize, length: usize| -> Option<usize> {
        let digits = bytes.get(at..at.checked_add(length)?)?.iter();
        let join = |number: usize, byte: &u8| number << 8 | usize::from(*byte);
        Some(if is_little {
            digits.rev().fold(0, join)
        } else {
            digits.fold(0, join)
        })
    };
    // BigTIFF counts entries in eight bytes, and has twenty for each with its value from the twelfth on.
    let (count_bytes, entry_bytes, value_at) = match number(2, 2) {
        Some(43) => (8, 20, 12),
        _ => (2, 12, 8),
    };
    let at = || -> Option<usize> {
        let start = usize::try_from(image.0).ok()?;
        let count = number(start, count_bytes)?.min(bytes.len());
        let mut entries = (0..count).map(|entry| start + count_bytes + entry * entry_bytes);
        let entry = entries.find(|entry| number(*entry, 2) == Some(PHOTOMETRIC.into()))?;
        Some(entry + value_at)
    };
    let value = if is_little {
        interpretation.to_le_bytes()
    } else {
        interpretation.to_be_bytes()
    };
    if let Some(place) = at().and_then(|at| copy.get_mut(at..at + 2)) {
        place.copy_from_slice(&value);
    }
    copy
}

#[cfg(test)]
mod tests;
