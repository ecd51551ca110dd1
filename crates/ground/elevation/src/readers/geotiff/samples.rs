// SPDX-License-Identifier: MIT OR Apache-2.0
//! Heights of a GeoTIFF: block by block, since blocks may be missing, with all that says which samples are voids.
//!
//! A sample is a void where it is `GDAL_NODATA` or no number, where its block is missing, where an alpha band is 0, and
//! where a mask is 0. Every other one is `(value × scale + offset) × unit` metres.

use super::metadata::Metadata;
use crate::ElevationError;
use crate::error::Complaints;
use std::io::Cursor;
use tiff::decoder::{ChunkType, Decoder, DecodingResult};
use tiff::tags::Tag;

/// Longest side of a tile, samples: beyond it a header alone would take memory.
const MAX_TILE_SIDE: u32 = 1 << 16;
const TYPES: &str =
    "whole numbers of 16 bits or signed ones of 32, or floating-point numbers of 32 or 64";

/// Second band, which says what the first is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Bands {
    One,
    /// Alpha beside each height.
    WithAlphaBeside,
    /// Alpha behind all heights.
    WithAlphaBehind,
}

/// Blocks of an image: where each lies, and which are there.
struct Blocks {
    columns: usize,
    across: usize,
    side: [usize; 2],
    is_missing: Vec<bool>,
}

impl Blocks {
    fn read(
        complaints: Complaints<'_>,
        decoder: &mut Decoder<Cursor<&[u8]>>,
    ) -> Result<Self, ElevationError> {
        let broken = |error: tiff::TiffError| complaints.undecodable("GeoTIFF", error);
        let (columns, rows) = decoder.dimensions().map_err(broken)?;
        let (width, height) = decoder.chunk_dimensions();
        let (offsets, counts) = match decoder.get_chunk_type() {
            ChunkType::Strip => (Tag::StripOffsets, Tag::StripByteCounts),
            ChunkType::Tile => (Tag::TileOffsets, Tag::TileByteCounts),
        };
        if offsets == Tag::TileOffsets && width.max(height) > MAX_TILE_SIDE {
            let found = format!("{width} × {height}");
            return Err(complaints.value("tiles", found, format!("sides up to {MAX_TILE_SIDE}")));
        }
        let numbers = |decoder: &mut Decoder<_>, tag| decoder.get_tag_u64_vec(tag).map_err(broken);
        let (offsets, counts) = (numbers(decoder, offsets)?, numbers(decoder, counts)?);
        let is_missing = |(offset, count): (u64, u64)| offset == 0 || count == 0;
        let side = [width.min(columns), height.min(rows)].map(|side| side.max(1) as usize);
        Ok(Self {
            columns: columns as usize,
            across: columns.div_ceil(width.max(1)) as usize,
            side,
            is_missing: offsets.into_iter().zip(counts).map(is_missing).collect(),
        })
    }

    /// Index in the whole image of a sample of a block.
    fn index(&self, block: usize, width: usize, sample: usize) -> usize {
        let [left, top] = [
            block % self.across * self.side[0],
            block / self.across * self.side[1],
        ];
        (top + sample / width) * self.columns + left + sample % width
    }
}

/// Heights in metres, rows as the file has them; NaN is a void.
pub(super) fn read(
    complaints: Complaints<'_>,
    decoder: &mut Decoder<Cursor<&[u8]>>,
    metadata: &Metadata,
    warnings: &mut Vec<String>,
) -> Result<Vec<f32>, ElevationError> {
    let broken = |error: tiff::TiffError| complaints.undecodable("GeoTIFF", error);
    let bands = bands(complaints, decoder)?;
    let blocks = Blocks::read(complaints, decoder)?;
    let (columns, rows) = decoder.dimensions().map_err(broken)?;
    let mut samples = vec![f32::NAN; columns as usize * rows as usize];
    let planes = 1 + usize::from(bands == Bands::WithAlphaBehind);
    let in_plane = blocks.is_missing.len() / planes;
    let (mut unnamed, mut type_of_all) = (None, None);
    for block in 0..in_plane {
        if blocks.is_missing[block] {
            continue;
        }
        let chunk = u32::try_from(block).unwrap_or(u32::MAX);
        let width = decoder.chunk_data_dimensions(chunk).0.max(1) as usize;
        let values = decoder.read_chunk(chunk).map_err(broken)?;
        let (beside, type_name) = (
            1 + usize::from(bands == Bands::WithAlphaBeside),
            name(&values),
        );
        type_of_all = type_of_all.or(type_name);
        let is_read = visit(&values, |at, value| {
            let sample = blocks.index(block, width, at / beside);
            if at % beside == 1 {
                // Alpha follows its height, and takes it back where it is 0.
                if value == 0.0 {
                    samples[sample] = f32::NAN;
                }
            } else {
                if value.is_nan() && !metadata.no_data.is_some_and(f64::is_nan) {
                    unnamed = unnamed.or(Some(sample));
                }
                samples[sample] = metadata.height_m(value);
            }
        });
        if !is_read {
            return Err(complaints.value("samples", "another type", TYPES));
        }
        if bands == Bands::WithAlphaBehind && !blocks.is_missing[in_plane + block] {
            let chunk = u32::try_from(in_plane + block).unwrap_or(u32::MAX);
            let alpha = decoder.read_chunk(chunk).map_err(broken)?;
            visit(&alpha, |at, value| {
                if value == 0.0 {
                    samples[blocks.index(block, width, at)] = f32::NAN;
                }
            });
        }
    }
    let missing = blocks.is_missing[..in_plane]
        .iter()
        .filter(|is| **is)
        .count();
    if missing > 0 {
        warnings.push(format!(
            "{missing} of {in_plane} blocks are missing (SPARSE_OK): voids, filled from their neighbours"
        ));
    }
    if let Some(at) = unnamed {
        let (column, row) = (at % columns as usize, at / columns as usize);
        warnings.push(format!(
            "sample in column {column}, row {row} is no number, which GDAL_NODATA does not say: read as a void"
        ));
    }
    if let (Some(void), Some((type_name, low, high))) = (metadata.no_data, type_of_all) {
        let is_value = void.fract() == 0.0 && (low..=high).contains(&void);
        if !is_value {
            warnings.push(format!(
                "GDAL_NODATA is {void}, which no {type_name} sample can be: none is a void by it"
            ));
        }
    }
    Ok(samples)
}

/// Voids where a mask of the same size is 0.
///
/// - `decoder`: at the mask, whose interpretation is one that `tiff` reads
pub(super) fn apply_mask(
    complaints: Complaints<'_>,
    decoder: &mut Decoder<Cursor<&[u8]>>,
    size: (u32, u32),
    samples: &mut [f32],
) -> Result<(), ElevationError> {
    let broken = |error: tiff::TiffError| complaints.undecodable("GeoTIFF", error);
    let found = decoder.dimensions().map_err(broken)?;
    let bits = decoder.get_tag_unsigned::<u64>(Tag::BitsPerSample);
    let bits = bits.unwrap_or(1);
    if found != size || !matches!(bits, 1 | 8) {
        let found = format!("{} × {} of {bits} bits", found.0, found.1);
        let allowed = format!("{} × {} of 1 or 8 bits", size.0, size.1);
        return Err(complaints.value("mask", found, allowed));
    }
    let blocks = Blocks::read(complaints, decoder)?;
    for block in 0..blocks.is_missing.len() {
        let chunk = u32::try_from(block).unwrap_or(u32::MAX);
        let (width, height) = decoder.chunk_data_dimensions(chunk);
        let (width, height) = (width as usize, height as usize);
        // GDAL leaves a block out where all of it is 0.
        let bytes = if blocks.is_missing[block] {
            Vec::new()
        } else if let DecodingResult::U8(bytes) = decoder.read_chunk(chunk).map_err(broken)? {
            bytes
        } else {
            return Err(complaints.value("mask", "another type", "1 or 8 bits unsigned"));
        };
        let a_row = if bits == 1 { width.div_ceil(8) } else { width };
        for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column)))
        {
            let is_valid = match bits {
                1 => bytes
                    .get(row * a_row + column / 8)
                    .is_some_and(|byte| byte >> (7 - column % 8) & 1 == 1),
                _ => bytes
                    .get(row * a_row + column)
                    .is_some_and(|byte| *byte > 0),
            };
            if !is_valid {
                samples[blocks.index(block, width, row * width + column)] = f32::NAN;
            }
        }
    }
    Ok(())
}

fn bands(
    complaints: Complaints<'_>,
    decoder: &mut Decoder<Cursor<&[u8]>>,
) -> Result<Bands, ElevationError> {
    let mut number = |tag: Tag| decoder.find_tag_unsigned_vec::<u16>(tag).ok().flatten();
    let count = number(Tag::SamplesPerPixel).and_then(|all| all.first().copied());
    let extra = number(Tag::ExtraSamples).unwrap_or_default();
    let planar = number(Tag::PlanarConfiguration).and_then(|all| all.first().copied());
    match (count.unwrap_or(1), extra.as_slice()) {
        (1, []) => Ok(Bands::One),
        // Both kinds of alpha: heights are not multiplied by either.
        (2, [1 | 2]) if planar == Some(2) => Ok(Bands::WithAlphaBehind),
        (2, [1 | 2]) => Ok(Bands::WithAlphaBeside),
        (count, extra) => {
            let found = format!("{count} with ExtraSamples {extra:?}");
            let allowed = format!(
                "1, or 2 of which the second is alpha (ExtraSamples 1 or 2); {}",
                complaints.gdal_translate("-b 1")
            );
            Err(complaints.value("SamplesPerPixel", found, allowed))
        }
    }
}

/// Shows every value with its place; `false` for a type that holds no heights.
fn visit(values: &DecodingResult, mut see: impl FnMut(usize, f64)) -> bool {
    fn all<T: Copy + Into<f64>>(values: &[T], see: &mut impl FnMut(usize, f64)) {
        let values = values.iter().enumerate();
        values.for_each(|(at, value)| see(at, (*value).into()));
    }
    match values {
        DecodingResult::I16(values) => all(values, &mut see),
        DecodingResult::U16(values) => all(values, &mut see),
        DecodingResult::I32(values) => all(values, &mut see),
        DecodingResult::F32(values) => all(values, &mut see),
        DecodingResult::F64(values) => all(values, &mut see),
        _ => return false,
    }
    true
}

/// Words for a type of whole numbers, with its least and its greatest value.
fn name(values: &DecodingResult) -> Option<(&'static str, f64, f64)> {
    match values {
        DecodingResult::I16(_) => Some(("signed 16-bit", i16::MIN.into(), i16::MAX.into())),
        DecodingResult::U16(_) => Some(("unsigned 16-bit", 0.0, u16::MAX.into())),
        DecodingResult::I32(_) => Some(("signed 32-bit", i32::MIN.into(), i32::MAX.into())),
        _ => None,
    }
}
