// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files of the kinds that public bug reports are about, with the right answer beside each.
//!
//! Heights were computed apart from the readers, from the bytes of each file by its format's formula.

use terrafill_elevation::{HeightField, read};

fn case(name: &str) -> HeightField {
    let path = format!("{}/tests/cases/{name}", env!("CARGO_MANIFEST_DIR"));
    let bytes = std::fs::read(path).expect(name);
    read(name, &bytes).unwrap_or_else(|error| panic!("{error}"))
}

/// The middle of most files.
const MIDDLE: [f64; 2] = [10.253, 44.737];

fn height_m(field: &HeightField, [longitude, latitude]: [f64; 2]) -> f64 {
    field.height_m(longitude, latitude).expect("inside")
}

#[test]
fn what_changes_the_meaning_of_samples_is_honoured() {
    // Name, place, height, and a word of its only warning.
    for (name, place, expected_m, warned) in [
        // GDAL_METADATA's offset of 1,000 m.
        ("scale_offset.tif", MIDDLE, 1356.0, None),
        (
            "miniswhite_f32.tif",
            MIDDLE,
            1356.0,
            Some("PhotometricInterpretation is 0 (WhiteIsZero)"),
        ),
        // EPSG:6360 is in US survey feet: 1,356 of them.
        ("vertical_ftus.tif", MIDDLE, 1356.0 * 1200.0 / 3937.0, None),
        ("southup.tif", MIDDLE, 1356.0, None),
        ("sirgas2000.tif", MIDDLE, 1356.0, None),
        ("alpha_band.tif", MIDDLE, 1356.0, None),
        (
            "nan_untagged.tif",
            MIDDLE,
            1356.0,
            Some("column 0, row 0 is no number, which GDAL_NODATA does not say"),
        ),
        ("rgb_zstd.tif", MIDDLE, 1356.0, None),
        ("internal_mask.tif", MIDDLE, 1356.0, None),
        (
            "sparse_strip.tif",
            [10.3, 44.75],
            2400.0,
            Some("4 of 6 blocks are missing (SPARSE_OK)"),
        ),
        ("grid_registered.tif", [10.0, 0.0], 3260.472, None),
        (
            "bad_checksum.dt0",
            [7.5, 45.5],
            -2650.0,
            Some(
                "1 of 121 records have a wrong checksum, and are read: record 5, checksum: found 30249, allowed: 30248",
            ),
        ),
        (
            "twos_complement.dt0",
            [7.5, 45.5],
            -2650.0,
            Some("14641 heights are in two's complement"),
        ),
        (
            "t_terrarium_12-2130-1473.png",
            [7.25, 45.0],
            0.0,
            Some("every pixel is black or transparent, which says that there is no height"),
        ),
    ] {
        let field = case(name);
        let found = height_m(&field, place);
        assert!((found - expected_m).abs() < 0.01, "{name}: {found}");
        match (warned, field.warnings()) {
            (None, []) => {}
            (Some(words), [warning]) => {
                assert!(warning.starts_with(&format!("{name}: ")), "{warning}");
                assert!(warning.contains(words), "{warning}");
            }
            (_, found) => panic!("{name}: {found:?}"),
        }
    }
}

#[test]
fn masks_and_missing_blocks_are_voids_and_poles_are_reached() {
    let masked = case("internal_mask.tif");
    assert!(masked.void_samples() > 100, "{}", masked.void_samples());
    // Under the mask the file has −30,000 m.
    assert!(
        masked.heights().lowest_m > -7_000.0,
        "{:?}",
        masked.heights()
    );
    let found = height_m(&masked, [10.253, 44.97]);
    assert!((-7_000.0..11_000.0).contains(&found), "{found}");
    let sparse = case("sparse_strip.tif");
    assert_eq!(sparse.void_samples(), 40 * 60);
    let found = height_m(&sparse, [10.3, 44.95]);
    assert!((-5_000.0..9_000.0).contains(&found), "{found}");
    let globe = case("grid_registered.tif");
    for place in [[180.0, 90.0], [-180.0, -90.0], [179.0, 0.0]] {
        assert!((1_500.0..=4_500.0).contains(&height_m(&globe, place)));
    }
    // Rows go north in the one and south in the other: the same ground.
    let (north, south) = (case("sirgas2000.tif"), case("southup.tif"));
    let places = [[10.1, 44.5], [10.4, 44.9], [10.253, 44.6]];
    for place in places {
        let [a, b] = [&north, &south].map(|field| height_m(field, place));
        assert!((a - b).abs() < 1e-2, "{a} {b}");
    }
    // Control: turned over, it would be other ground.
    let mirrored = height_m(&south, [10.1, 44.4 + 45.0 - 44.5]);
    assert!((mirrored - height_m(&north, [10.1, 44.5])).abs() > 100.0);
}

#[test]
fn heights_that_nothing_on_a_body_has_are_said_with_their_place() {
    let masked = case("sirgas2000.tif").expected_within(-12_000.0..=9_000.0);
    let [warning] = masked.warnings() else {
        panic!("one, found {:?}", masked.warnings());
    };
    let words = "of 3600 heights are outside -12000 to 9000 m, which nothing on this body is: 10260 m at longitude \
                 10.59500, latitude 44.99500";
    assert!(warning.contains(words), "{warning}");
    // Control: within wider limits there is nothing to say.
    let within = case("sirgas2000.tif").expected_within(-12_000.0..=11_000.0);
    assert!(within.warnings().is_empty());
}

#[test]
fn a_tile_of_a_part_of_a_degree_is_no_whole_degree() {
    let bytes = vec![0; 2 * 1201 * 1201];
    for name in ["N45W074.hgt", "N45W074.SRTMGL3.hgt", "a/N45W074_v3.hgt"] {
        assert!(read(name, &bytes).is_ok(), "{name}");
    }
    for name in ["N45W074T86.hgt", "N45W0741.hgt"] {
        let error = read(name, &bytes).expect_err(name).to_string();
        assert!(error.contains(&format!("name: found {name:?}")), "{error}");
        assert!(error.contains("a tile of a part of one"), "{error}");
    }
}

#[test]
fn a_black_tile_of_terrain_rgb_is_read_by_its_formula_and_said() {
    let black = |pixel: [u8; 4]| {
        let picture = image::RgbaImage::from_pixel(4, 4, image::Rgba(pixel));
        let mut bytes = std::io::Cursor::new(Vec::new());
        let written = picture.write_to(&mut bytes, image::ImageFormat::Png);
        written.expect("in memory");
        bytes.into_inner()
    };
    let field = read("x_terrain-rgb_1-1-0.png", &black([0, 0, 0, 255])).expect("read");
    assert!((height_m(&field, [90.0, 40.0]) + 10_000.0).abs() < 1e-3);
    assert!(field.warnings()[0].contains("every pixel is black, which is -10000 m"));
    let field = read("x_terrain-rgb_1-1-0.png", &black([0, 0, 0, 0])).expect("read");
    assert!(height_m(&field, [90.0, 40.0]).abs() < 1e-9);
    assert!(field.warnings()[0].contains("the tile is level at 0 m"));
    // Control.
    let field = read("x_terrain-rgb_1-1-0.png", &black([1, 134, 160, 255])).expect("read");
    assert!(field.warnings().is_empty());
}
