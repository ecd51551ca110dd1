// SPDX-License-Identifier: MIT OR Apache-2.0
//! Walks every tag of TIFF 6.0 and every tag and key of GeoTIFF 1.1.

use super::place::{KEYS, KeyTreatment};
use super::read;
use super::tags::{TAGS, Treatment};
use crate::HeightField;
use crate::error::Complaints;
use std::io::Cursor;
use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;

/// TIFF 6.0, appendix A.
const TIFF_6: [u16; 74] = [
    254, 255, 256, 257, 258, 259, 262, 263, 264, 265, 266, 269, 270, 271, 272, 273, 274, 277, 278,
    279, 280, 281, 282, 283, 284, 285, 286, 287, 288, 289, 290, 291, 292, 293, 296, 297, 301, 305,
    306, 315, 316, 317, 318, 319, 320, 321, 322, 323, 324, 325, 332, 333, 334, 336, 337, 338, 339,
    340, 341, 342, 512, 513, 514, 515, 517, 518, 519, 520, 521, 529, 530, 531, 532, 33_432,
];
/// GeoTIFF 1.1, §7.
const GEOTIFF: [u16; 6] = [33_550, 33_922, 34_264, 34_735, 34_736, 34_737];
/// GeoTIFF 1.1, annex D.
const GEOTIFF_KEYS: [u16; 46] = [
    1024, 1025, 1026, 2048, 2049, 2050, 2051, 2052, 2053, 2054, 2055, 2056, 2057, 2058, 2059, 2060,
    2061, 3072, 3073, 3074, 3075, 3076, 3077, 3078, 3079, 3080, 3081, 3082, 3083, 3084, 3085, 3086,
    3087, 3088, 3089, 3090, 3091, 3092, 3093, 3094, 3095, 4096, 4097, 4098, 4099, 5120,
];
const SAMPLE_FORMAT: u16 = 339;
const DEGREES: [u16; 12] = [1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 4326];

/// 4 columns of 3 rows, with one more tag or key.
fn file(tag: Option<(u16, u16)>, keys: &[u16], doubles: &[f64]) -> Result<HeightField, String> {
    read_written(tag, None, keys, doubles)
}

/// The same, or with a tag of text.
fn read_written(
    tag: Option<(u16, u16)>,
    text: Option<(u16, &str)>,
    keys: &[u16],
    doubles: &[f64],
) -> Result<HeightField, String> {
    let samples: Vec<i16> = (0..12).map(|at| 10 * at).collect();
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).expect("in memory");
    let mut image = encoder
        .new_image::<colortype::GrayI16>(4, 3)
        .expect("a size");
    let directory = image.encoder();
    for (tag, numbers) in [
        (Tag::ModelPixelScaleTag, &[0.5, 0.25, 0.0][..]),
        (Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, 10.0, 50.0, 0.0]),
        (Tag::GeoDoubleParamsTag, doubles),
    ] {
        directory.write_tag(tag, numbers).expect("numbers");
    }
    directory
        .write_tag(Tag::GeoKeyDirectoryTag, keys)
        .expect("keys");
    if let Some((tag, value)) = tag {
        let tag = Tag::from_u16_exhaustive(tag);
        directory.write_tag(tag, value).expect("a tag");
    }
    if let Some((tag, text)) = text {
        let tag = Tag::from_u16_exhaustive(tag);
        directory.write_tag(tag, text).expect("text");
    }
    image.write_data(&samples).expect("samples");
    let mut bytes = bytes.into_inner();
    if let Some((SAMPLE_FORMAT, value)) = tag {
        // The encoder writes its own over it: number, type, count, and signed whole numbers.
        let own = [0x53, 0x01, 3, 0, 1, 0, 0, 0, 2, 0];
        let at = bytes.windows(own.len()).position(|bytes| bytes == own);
        let at = at.expect("little-endian") + own.len() - 2;
        bytes[at..at + 2].copy_from_slice(&value.to_le_bytes());
    }
    let complaints = Complaints { file: "t.tif" };
    read(complaints, &bytes).map_err(|error| error.to_string())
}

fn heights(field: &HeightField) -> Vec<f64> {
    let places = [[10.25, 49.875], [11.75, 49.375], [10.9, 49.6]];
    let heights = places.map(|[x, y]| field.height_m(x, y).expect("inside"));
    heights.to_vec()
}

#[test]
fn every_tag_is_read_or_harmless_or_refused_by_name() {
    assert!(TAGS.is_sorted_by_key(|(tag, ..)| *tag));
    let plain = heights(&file(None, &DEGREES, &[0.0]).expect("plain"));
    let mut met = [0; 4];
    for tag in TIFF_6.into_iter().chain(GEOTIFF) {
        let row = TAGS.iter().find(|(number, ..)| *number == tag);
        let (_, name, treatment) = row.unwrap_or_else(|| panic!("{tag} is not in the table"));
        let with = |value| file(Some((tag, value)), &DEGREES, &[0.0]);
        match treatment {
            // What honours each of these has a test of its own, or nothing would be read at all.
            Treatment::Read => met[0] += 1,
            Treatment::Harmless => {
                let field = with(7).unwrap_or_else(|error| panic!("{name}: {error}"));
                assert_eq!(heights(&field), plain, "{name}");
                assert!(
                    field.warnings().is_empty(),
                    "{name}: {:?}",
                    field.warnings()
                );
                met[1] += 1;
            }
            Treatment::Only(..) => {
                // Values that each of these may have, and that are refused.
                let value = match tag {
                    254 => 4,
                    255 => 2,
                    259 => 7,
                    262 => 3,
                    339 => 4,
                    _ => 6,
                };
                let error = with(value).expect_err(name);
                let is_named = error.to_lowercase().contains(&name.to_lowercase());
                assert!(is_named, "{name}: {error}");
                met[2] += 1;
            }
            Treatment::Refused(_) => {
                let error = with(7).expect_err(name);
                // `tiff` refuses one number of the second by the name of a later standard.
                let is_named = error.contains(&format!("tag {tag} ({name})"))
                    || (tag == 530 && error.contains("ChromaSubsampling"));
                assert!(is_named, "{error}");
                met[3] += 1;
            }
        }
    }
    assert_eq!(met.iter().sum::<usize>(), 80);
    assert!(met.iter().all(|count| *count > 7), "{met:?}");
    // Control: a tag that nobody knows is listed.
    let unknown = file(Some((65_001, 7)), &DEGREES, &[0.0]).expect("read");
    let words =
        "t.tif: tags that are not known and not read: 65001; where one changes what samples mean";
    assert!(
        unknown.warnings()[0].starts_with(words),
        "{:?}",
        unknown.warnings()
    );
}

#[test]
fn every_key_is_read_or_harmless_or_refused_by_name() {
    assert!(KEYS.is_sorted_by_key(|(key, ..)| *key));
    let plain = heights(&file(None, &DEGREES, &[0.0]).expect("plain"));
    let with = |entry: [u16; 4], doubles: &[f64]| {
        let mut keys = DEGREES.to_vec();
        keys[3] = 3;
        keys.extend(entry);
        file(None, &keys, doubles)
    };
    for key in GEOTIFF_KEYS {
        let row = KEYS.iter().find(|(number, ..)| *number == key);
        let (_, name, treatment) = row.unwrap_or_else(|| panic!("{key} is not in the table"));
        match treatment {
            KeyTreatment::Read => {}
            KeyTreatment::Harmless => {
                let field = with([key, 0, 1, 77], &[0.0]).unwrap_or_else(|error| panic!("{error}"));
                assert_eq!(heights(&field), plain, "{name}");
                assert!(
                    field.warnings().is_empty(),
                    "{name}: {:?}",
                    field.warnings()
                );
            }
            KeyTreatment::Zero => {
                let of = |value| with([key, 34_736, 1, 0], &[value]);
                assert!(of(0.0).is_ok(), "{name}");
                let error = of(2.337_229).expect_err(name);
                assert!(error.starts_with(&format!(
                    "t.tif: {name}: found 2.337229, allowed: 0; `gdalwarp"
                )));
            }
        }
    }
    // What each key that is read has refused, by name.
    for (entry, expected) in [
        (
            [1025, 0, 1, 3],
            "GTRasterType: found 3, allowed: 1 (areas), 2 (points)",
        ),
        (
            [2051, 0, 1, 8903],
            "PrimeMeridian: found 8903, allowed: 8901; `gdalwarp",
        ),
        (
            [2054, 0, 1, 9105],
            "GeogAngularUnits: found 9105, allowed: 9102, 9122; `gdalwarp",
        ),
        (
            [4096, 0, 1, 5715],
            "Vertical: found 5715 (depths), allowed: heights",
        ),
        (
            [4096, 0, 1, 9999],
            "Vertical: found 9999, allowed: one that is known",
        ),
        (
            [4099, 0, 1, 9005],
            "VerticalUnits: found 9005, allowed: 9001 (metre)",
        ),
    ] {
        let error = with(entry, &[0.0]).expect_err(expected);
        assert!(error.starts_with(&format!("t.tif: {expected}")), "{error}");
    }
    for (crs, datum) in [(4230, 0), (32_767, 6230)] {
        let keys = [
            1, 1, 0, 3, 1024, 0, 1, 2, 2048, 0, 1, crs, 2050, 0, 1, datum,
        ];
        let error = file(None, &keys, &[0.0]).expect_err("another datum");
        assert!(
            error.contains("allowed: 4326") || error.contains("allowed: 6326"),
            "{error}"
        );
    }
    let feet = with([4099, 0, 1, 9002], &[0.0]).expect("feet");
    let expected: Vec<f64> = plain.iter().map(|height| height * 0.3048).collect();
    let close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-4;
    assert!(heights(&feet).iter().zip(&expected).all(close), "{feet:?}");
    // Control: a key that nobody knows is listed.
    let unknown = with([5999, 0, 1, 1], &[0.0]).expect("read");
    let words = "t.tif: keys of the GeoKeyDirectory that are not known and not read: 5999";
    assert_eq!(unknown.warnings(), [words]);
}

#[test]
fn metadata_scale_units_and_voids_that_are_no_values() {
    let with = |tag: u16, text: &str| read_written(None, Some((tag, text)), &DEGREES, &[0.0]);
    let xml = |items: &str| with(42_112, &format!("<GDALMetadata>{items}</GDALMetadata>"));
    let at = |field: &HeightField| field.height_m(11.75, 49.375).expect("inside");
    for (items, expected_m) in [
        ("", 110.0),
        (
            r#"<Item name="SCALE" sample="0" role="scale">0.1</Item><Item name="OFFSET" sample="0" role="offset">-5</Item>"#,
            6.0,
        ),
        (
            r#"<Item name="UNITTYPE" sample="0" role="unittype">ft</Item>"#,
            110.0 * 0.3048,
        ),
        (
            r#"<Item name="SCALE" sample="1" role="scale">9</Item>"#,
            110.0,
        ),
        (r#"<Item name="SCALE">9</Item>"#, 110.0),
        (
            r#"<Item name="STATISTICS_MAXIMUM" sample="0">9</Item>"#,
            110.0,
        ),
    ] {
        let field = xml(items).expect(items);
        assert!(
            (at(&field) - expected_m).abs() < 1e-4,
            "{items}: {}",
            at(&field)
        );
        assert!(field.warnings().is_empty(), "{:?}", field.warnings());
    }
    for (items, expected) in [
        (
            r#"<Item name="SCALE" sample="0" role="scale">0</Item>"#,
            "t.tif: GDAL_METADATA, SCALE: found \"0\", allowed: a number that is not 0",
        ),
        (
            r#"<Item name="UNITTYPE" sample="0" role="unittype">fathom</Item>"#,
            "t.tif: GDAL_METADATA, UNITTYPE: found \"fathom\", allowed: m, metre",
        ),
    ] {
        let error = xml(items).expect_err(items);
        assert!(error.starts_with(expected), "{error}");
    }
    for (void, words) in [
        (
            "-99999",
            "GDAL_NODATA is -99999, which no signed 16-bit sample can be",
        ),
        (
            "10.5",
            "GDAL_NODATA is 10.5, which no signed 16-bit sample can be",
        ),
        (
            "nan",
            "GDAL_NODATA is NaN, which no signed 16-bit sample can be",
        ),
    ] {
        let field = with(42_113, void).expect(void);
        assert!(
            field.warnings()[0].contains(words),
            "{:?}",
            field.warnings()
        );
    }
    // Control: one that is a value, and is there.
    let field = with(42_113, "110").expect("a void");
    assert_eq!((field.void_samples(), field.warnings()), (1, &[][..]));
}
