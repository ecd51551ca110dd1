// SPDX-License-Identifier: MIT OR Apache-2.0
//! What becomes of each tag of a TIFF: read, harmless, or refused by name because it changes what a sample means.
//!
//! Sources: TIFF 6.0 (Adobe, 1992), appendix A; GeoTIFF 1.1 (OGC 19-008r4), §7; GDAL's GeoTIFF driver for the private
//! tags that it writes. A tag that is in none of them is listed in a warning.

use crate::ElevationError;
use crate::error::Complaints;
use std::io::Cursor;
use tiff::decoder::Decoder;
use tiff::tags::Tag;

/// What a tag does to the meaning of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Treatment {
    /// Honoured here or by `tiff`.
    Read,
    /// Whatever it says, heights and places stay the same.
    Harmless,
    /// Harmless with one of these values. Another one is refused, with the options of `gdal_translate` that write a
    /// file without it.
    Only(&'static [u64], &'static str),
    /// It says that samples are something else than heights.
    Refused(&'static str),
}
use Treatment::{Harmless, Only, Read, Refused};

/// Compressions that `tiff` unpacks without loss: none, LZW, both codes of Deflate, PackBits, ZSTD.
const COMPRESSIONS: &[u64] = &[1, 5, 8, 32_946, 32_773, 50_000];
const UNPACKED: &str = "-co COMPRESS=DEFLATE";
const PLAIN: &str = "-co COMPRESS=NONE";
const ONE_BAND: &str = "-b 1 -co PHOTOMETRIC=MINISBLACK";

/// Number, name and treatment, ascending.
pub(super) const TAGS: &[(u16, &str, Treatment)] = &[
    // The first image of a file may be the full one or a page, and no mask or overview.
    (254, "NewSubfileType", Only(&[0, 2], PLAIN)),
    (255, "SubfileType", Only(&[1, 3], PLAIN)),
    (256, "ImageWidth", Read),
    (257, "ImageLength", Read),
    (258, "BitsPerSample", Read),
    (259, "Compression", Only(COMPRESSIONS, UNPACKED)),
    // WhiteIsZero is about display, and a warning says so. Colours and indices of a palette are no heights.
    (262, "PhotometricInterpretation", Only(&[0, 1], ONE_BAND)),
    (263, "Threshholding", Harmless),
    (264, "CellWidth", Harmless),
    (265, "CellLength", Harmless),
    (266, "FillOrder", Only(&[1], PLAIN)),
    (269, "DocumentName", Harmless),
    (270, "ImageDescription", Harmless),
    (271, "Make", Harmless),
    (272, "Model", Harmless),
    (273, "StripOffsets", Read),
    (274, "Orientation", Only(&[1], PLAIN)),
    (277, "SamplesPerPixel", Read),
    (278, "RowsPerStrip", Read),
    (279, "StripByteCounts", Read),
    (280, "MinSampleValue", Harmless),
    (281, "MaxSampleValue", Harmless),
    (282, "XResolution", Harmless),
    (283, "YResolution", Harmless),
    (284, "PlanarConfiguration", Read),
    (285, "PageName", Harmless),
    (286, "XPosition", Harmless),
    (287, "YPosition", Harmless),
    (288, "FreeOffsets", Harmless),
    (289, "FreeByteCounts", Harmless),
    // How dark each value is printed.
    (290, "GrayResponseUnit", Harmless),
    (291, "GrayResponseCurve", Harmless),
    (292, "T4Options", Refused("fax compression")),
    (293, "T6Options", Refused("fax compression")),
    (296, "ResolutionUnit", Harmless),
    (297, "PageNumber", Harmless),
    (301, "TransferFunction", Harmless),
    (305, "Software", Harmless),
    (306, "DateTime", Harmless),
    (315, "Artist", Harmless),
    (316, "HostComputer", Harmless),
    (317, "Predictor", Only(&[1, 2, 3], UNPACKED)),
    (318, "WhitePoint", Harmless),
    (319, "PrimaryChromaticities", Harmless),
    // Colours for display, unless samples are its indices: PhotometricInterpretation 3.
    (320, "ColorMap", Harmless),
    (321, "HalftoneHints", Harmless),
    (322, "TileWidth", Read),
    (323, "TileLength", Read),
    (324, "TileOffsets", Read),
    (325, "TileByteCounts", Read),
    (330, "SubIFDs", Harmless),
    (332, "InkSet", Refused("inks")),
    (333, "InkNames", Refused("inks")),
    (334, "NumberOfInks", Refused("inks")),
    (336, "DotRange", Refused("inks")),
    (337, "TargetPrinter", Harmless),
    (338, "ExtraSamples", Read),
    (339, "SampleFormat", Only(&[1, 2, 3], "-ot Float32")),
    (340, "SMinSampleValue", Harmless),
    (341, "SMaxSampleValue", Harmless),
    (342, "TransferRange", Harmless),
    (346, "Indexed", Only(&[0], ONE_BAND)),
    (347, "JPEGTables", Refused("lossy compression")),
    (512, "JPEGProc", Refused("lossy compression")),
    (513, "JPEGInterchangeFormat", Refused("lossy compression")),
    (
        514,
        "JPEGInterchangeFormatLngth",
        Refused("lossy compression"),
    ),
    (515, "JPEGRestartInterval", Refused("lossy compression")),
    (517, "JPEGLosslessPredictors", Refused("JPEG")),
    (518, "JPEGPointTransforms", Refused("JPEG")),
    (519, "JPEGQTables", Refused("lossy compression")),
    (520, "JPEGDCTables", Refused("lossy compression")),
    (521, "JPEGACTables", Refused("lossy compression")),
    (529, "YCbCrCoefficients", Refused("colours")),
    (530, "YCbCrSubSampling", Refused("colours")),
    (531, "YCbCrPositioning", Refused("colours")),
    (532, "ReferenceBlackWhite", Refused("coded values")),
    (700, "XMP", Harmless),
    (33_432, "Copyright", Harmless),
    (33_550, "ModelPixelScale", Read),
    (33_723, "IPTC", Harmless),
    (
        33_920,
        "IntergraphMatrix",
        Refused("a place in an obsolete form"),
    ),
    (33_922, "ModelTiepoint", Read),
    (34_264, "ModelTransformation", Read),
    (34_377, "Photoshop", Harmless),
    (34_665, "ExifIFD", Harmless),
    (34_675, "ICCProfile", Harmless),
    (34_735, "GeoKeyDirectory", Read),
    (34_736, "GeoDoubleParams", Read),
    (34_737, "GeoAsciiParams", Read),
    (34_853, "GPSIFD", Harmless),
    (42_112, "GDAL_METADATA", Read),
    (42_113, "GDAL_NODATA", Read),
    // Of an image that is not rectified; a tie point or a transformation says where samples are.
    (50_844, "RPCCoefficient", Harmless),
    (50_908, "TIFF_RSID", Harmless),
    (50_909, "GEO_METADATA", Harmless),
];

/// Refuses the tags of the first image that change what samples mean.
///
/// - returns: warnings
pub(super) fn check(
    complaints: Complaints<'_>,
    decoder: &mut Decoder<Cursor<&[u8]>>,
) -> Result<Vec<String>, ElevationError> {
    let directory = decoder.image_ifd();
    let present: Vec<Tag> = directory.directory().iter().map(|(tag, _)| tag).collect();
    let mut unknown = Vec::new();
    for tag in present {
        let number = tag.to_u16();
        let Ok(row) = TAGS.binary_search_by_key(&number, |(tag, ..)| *tag) else {
            unknown.push(number.to_string());
            continue;
        };
        let (_, name, treatment) = TAGS[row];
        match treatment {
            Read | Harmless => {}
            Refused(meaning) => {
                let allowed = format!(
                    "no such tag, since it says that samples are {meaning}; {}",
                    complaints.gdal_translate(ONE_BAND)
                );
                return Err(complaints.value(format!("tag {number} ({name})"), "it", allowed));
            }
            Only(allowed, options) => {
                let values = decoder.find_tag_unsigned_vec::<u64>(tag).ok().flatten();
                let values = values.unwrap_or_default();
                let Some(found) = values.iter().find(|value| !allowed.contains(value)) else {
                    continue;
                };
                let allowed: Vec<String> = allowed.iter().map(u64::to_string).collect();
                let allowed = format!(
                    "{}; {}",
                    allowed.join(", "),
                    complaints.gdal_translate(options)
                );
                let found = meaning(number, *found)
                    .map_or(found.to_string(), |word| format!("{found} ({word})"));
                return Err(complaints.value(name, found, allowed));
            }
        }
    }
    let mut warnings = Vec::new();
    if !unknown.is_empty() {
        warnings.push(format!(
            "tags that are not known and not read: {}; where one changes what samples mean, heights are wrong",
            unknown.join(", ")
        ));
    }
    Ok(warnings)
}

/// A word for a value that is refused.
fn meaning(tag: u16, value: u64) -> Option<&'static str> {
    Some(match (tag, value) {
        (254, 1) => "an overview",
        (254, 4 | 5) => "a mask",
        (259, 2..=4) => "fax",
        (259, 6 | 7) => "JPEG",
        (259, 34_887) => "LERC",
        (259, 34_925) => "LZMA",
        (259, 50_001) => "WebP",
        (259, 50_002 | 52_546) => "JPEG XL",
        (262, 2) => "RGB: colours",
        (262, 3) => "indices of a palette",
        (262, 4) => "a mask",
        (262, 5..=10) => "colours",
        (266, 2) => "bits from the least",
        (274, _) => "rows and columns elsewhere than from the upper left",
        (339, 4) => "undefined data",
        (339, 5 | 6) => "complex numbers",
        _ => return None,
    })
}
