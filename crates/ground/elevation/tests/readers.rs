// SPDX-License-Identifier: MIT OR Apache-2.0
//! Readers: files written here, in every format, right and wrong; and real ones where there are any.

use std::io::{Cursor, Write as _};
use terrafill_elevation::{Bounds, HeightField, Projection, Registration, read};
use terrafill_fixtures::data;
use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;

/// What a synthetic GeoTIFF says of itself.
struct Said<'a> {
    keys: &'a [u16],
    scale: &'a [f64],
    tie: &'a [f64],
    no_data: Option<&'a str>,
}

const DEGREES_AREA: &[u16] = &[1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326];
const DEGREES_POINT: &[u16] = &[1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 2, 2048, 0, 1, 4326];
const MERCATOR: &[u16] = &[1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 3857];

impl Default for Said<'_> {
    fn default() -> Self {
        Self {
            keys: DEGREES_AREA,
            scale: &[0.5, 0.25, 0.0],
            tie: &[0.0, 0.0, 0.0, 10.0, 50.0, 0.0],
            no_data: None,
        }
    }
}

/// What all others say, but for the keys.
fn keys(keys: &[u16]) -> Said<'_> {
    Said {
        keys,
        ..Said::default()
    }
}

fn scale(scale: &[f64]) -> Said<'_> {
    Said {
        scale,
        ..Said::default()
    }
}

fn tie(tie: &[f64]) -> Said<'_> {
    Said {
        tie,
        ..Said::default()
    }
}

fn no_data(text: &str) -> Said<'_> {
    Said {
        no_data: Some(text),
        ..Said::default()
    }
}

/// 4 columns of 3 rows.
fn geotiff<C>(said: &Said<'_>, samples: &[C::Inner]) -> Vec<u8>
where
    C: colortype::ColorType,
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).expect("in memory");
    let mut image = encoder.new_image::<C>(4, 3).expect("a size");
    let directory = image.encoder();
    directory
        .write_tag(Tag::GeoKeyDirectoryTag, said.keys)
        .expect("keys");
    directory
        .write_tag(Tag::ModelPixelScaleTag, said.scale)
        .expect("scale");
    directory
        .write_tag(Tag::ModelTiepointTag, said.tie)
        .expect("tie point");
    if let Some(text) = said.no_data {
        directory.write_tag(Tag::GdalNodata, text).expect("no data");
    }
    image.write_data(samples).expect("samples");
    bytes.into_inner()
}

const WHOLE: [i16; 12] = [0, 10, 20, 30, 100, 110, 120, 130, -200, 210, 220, 230];

fn floats() -> [f32; 12] {
    WHOLE.map(f32::from)
}

fn near(field: &HeightField, longitude: f64, latitude: f64, height_m: f64) {
    let found = field.height_m(longitude, latitude);
    assert!(
        found.is_some_and(|found| (found - height_m).abs() < 1e-3),
        "{longitude} {latitude}: {found:?}, not {height_m}"
    );
}

#[test]
fn a_geotiff_of_areas_begins_half_a_cell_inside_and_one_of_points_at_its_tie() {
    let areas = read(
        "a.tif",
        &geotiff::<colortype::GrayI16>(&Said::default(), &WHOLE),
    );
    let areas = areas.expect("areas");
    let bounds = Bounds {
        west: 10.0,
        south: 49.25,
        east: 12.0,
        north: 50.0,
    };
    assert_eq!(areas.bounds(), bounds);
    near(&areas, 10.25, 49.875, 0.0);
    near(&areas, 10.75, 49.625, 110.0);
    near(&areas, 10.5, 49.75, 55.0);
    // Level from the outermost samples to the edge.
    near(&areas, 10.0, 50.0, 0.0);
    assert_eq!(areas.height_m(9.99, 50.0), None);
    let said = keys(DEGREES_POINT);
    let points = read("p.tiff", &geotiff::<colortype::GrayI16>(&said, &WHOLE)).expect("points");
    near(&points, 10.0, 50.0, 0.0);
    near(&points, 10.25, 49.875, 55.0);
    assert_eq!(points.height_m(11.6, 50.0), None);
    assert_eq!(points.void_samples(), 0);
    assert_eq!(points.heights().lowest_m, -200.0);
}

#[test]
fn voids_are_counted_and_filled_and_web_mercator_is_projected() {
    let said = no_data("110");
    let field = read("v.tif", &geotiff::<colortype::GrayI16>(&said, &WHOLE)).expect("a void");
    assert_eq!(field.void_samples(), 1);
    let filled = field.height_m(10.75, 49.625).expect("inside");
    assert!((-200.0..=230.0).contains(&filled), "{filled}");
    let mut samples = floats();
    samples[5] = f32::NAN;
    let said = no_data("nan");
    let field = read("n.tif", &geotiff::<colortype::Gray32Float>(&said, &samples)).expect("a void");
    assert_eq!(field.void_samples(), 1);
    // A place of EPSG:3857 from its definition: 10° east, 50° north.
    let said = Said {
        keys: MERCATOR,
        scale: &[1000.0, 1000.0, 0.0],
        tie: &[
            0.0,
            0.0,
            0.0,
            1_113_194.907_932_736 - 1500.0,
            6_446_275.841_017_16 + 1500.0,
            0.0,
        ],
        no_data: None,
    };
    let field = read(
        "m.tif",
        &geotiff::<colortype::Gray32Float>(&said, &floats()),
    )
    .expect("metres");
    assert_eq!(field.grid().projection, Projection::WebMercator);
    near(&field, 10.0, 50.0, 110.0);
}

#[test]
fn what_is_wrong_with_a_geotiff_is_named() {
    let error = |said: &Said<'_>| {
        let field = read("w.tif", &geotiff::<colortype::Gray32Float>(said, &floats()));
        field.expect_err("wrong").to_string()
    };
    let utm: &[u16] = &[1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32610];
    let yards: &[u16] = &[
        1, 1, 0, 3, 1024, 0, 1, 2, 2048, 0, 1, 4326, 4099, 0, 1, 9096,
    ];
    for (said, expected) in [
        (
            keys(utm),
            "w.tif: ProjectedCRS: found 32610 (UTM 10 N), allowed: 3857, or a file in degrees; `gdalwarp -t_srs \
             EPSG:4326 -r bilinear w.tif mended.tif` writes one that is read",
        ),
        (
            keys(yards),
            "w.tif: VerticalUnits: found 9096, allowed: 9001 (metre), 9002",
        ),
        (
            keys(&[]),
            "w.tif: GTModelType: found none, allowed: 2 (degrees)",
        ),
        (
            scale(&[0.0, 0.25, 0.0]),
            "w.tif: step to the east: found 0, allowed: 4.2e-8 or more",
        ),
        (
            scale(&[f64::NAN, 0.25, 0.0]),
            "w.tif: step to the east: found NaN",
        ),
        (
            scale(&[1.0]),
            "w.tif: ModelPixelScale: found 1 numbers, allowed: at least 2",
        ),
        (
            tie(&[0.0, 0.0, 0.0, 10.0, 90.5, 0.0]),
            "w.tif: northern edge: found 90.5, allowed: -90 to 90",
        ),
        (
            tie(&[0.0, 0.0, 0.0, f64::INFINITY, 5.0, 0.0]),
            "w.tif: western edge: found inf, allowed: -360 to 360",
        ),
        (
            no_data("none"),
            "w.tif: GDAL_NODATA: found \"none\", allowed: a number or nan",
        ),
    ] {
        let found = error(&said);
        assert!(found.starts_with(expected), "{found}");
    }
    let mut samples = floats();
    samples[6] = 2e5;
    let bytes = geotiff::<colortype::Gray32Float>(&Said::default(), &samples);
    let found = read("w.tif", &bytes).expect_err("wrong").to_string();
    assert!(
        found.contains("column 2, row 1: found 200000, allowed: -100000 to 100000"),
        "{found}"
    );
    let bytes = geotiff::<colortype::RGB8>(&Said::default(), &[0; 36]);
    let found = read("w.tif", &bytes).expect_err("colours").to_string();
    assert!(
        found.starts_with(
            "w.tif: PhotometricInterpretation: found 2 (RGB: colours), allowed: 0, 1; `gdal_translate -b 1"
        ),
        "{found}"
    );
}

#[test]
fn every_truncation_of_every_format_is_an_error() {
    let tiff = geotiff::<colortype::GrayI16>(&Said::default(), &WHOLE);
    let png = tile_png(4, [1, 134, 160, 255]);
    for (name, bytes, from) in [
        ("a.tif", tiff, 0),
        ("a.dt0", dted(), 0),
        ("t_terrain-rgb_1-0-0.png", png, 0),
        ("N01E001.hgt.zip", zipped("N01E001.hgt", &hgt(5)), 0),
        ("N01E001.hgt", hgt(5), 2_880_000),
    ] {
        assert!(
            read(name, &bytes).is_ok(),
            "{name}: {:?}",
            read(name, &bytes).err()
        );
        let step = (bytes.len() / 400).max(1);
        for length in (from..bytes.len()).step_by(step) {
            // A TIFF's tags may end before its last bytes do.
            let cut = read(name, &bytes[..length]);
            assert!(
                cut.is_err() || length + 8 > bytes.len(),
                "{name} of {length} bytes"
            );
        }
    }
}

#[test]
fn sizes_of_headers_alone_allocate_nothing() {
    // A million columns of a million rows in 200 bytes.
    let mut huge = geotiff::<colortype::GrayI16>(&Said::default(), &WHOLE);
    for tag in [256_u16, 257] {
        // Its type, 4, is a whole number of 32 bits.
        let entry = [tag.to_le_bytes(), [4, 0], [1, 0]].concat();
        let at = huge
            .windows(6)
            .position(|bytes| bytes == entry)
            .expect("its tag");
        huge[at + 8..at + 12].copy_from_slice(&60_000_u32.to_le_bytes());
    }
    let error = read("huge.tif", &huge).expect_err("too large").to_string();
    assert!(
        error.contains("found 60000 × 60000, allowed: 2 × 2 to"),
        "{error}"
    );
    let mut many = dted();
    many[47..55].copy_from_slice(b"99999999");
    let error = read("many.dt0", &many).expect_err("too short").to_string();
    assert!(
        error.contains("for 9999 records of 9999 heights"),
        "{error}"
    );
    let bomb = zipped("N01E001.hgt", &vec![0; 30_000_000]);
    assert!(bomb.len() < 100_000);
    let error = read("N01E001.hgt.zip", &bomb)
        .expect_err("a bomb")
        .to_string();
    assert!(
        error.contains("unpacked: found more than 25934402 bytes"),
        "{error}"
    );
}

/// A degree at 3 arc-seconds: height is the row in the first column, else `height`; one void.
fn hgt(height: i16) -> Vec<u8> {
    let mut samples = vec![height; 1201 * 1201];
    for row in 0..1201_i16 {
        samples[usize::from(row.unsigned_abs()) * 1201] = row;
    }
    samples[1201 * 600 + 600] = i16::MIN;
    samples
        .iter()
        .flat_map(|sample| sample.to_be_bytes())
        .collect()
}

fn zipped(name: &str, bytes: &[u8]) -> Vec<u8> {
    let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Deflated);
    writer.start_file("readme.txt", options).expect("in memory");
    writer.write_all(b"a tile").expect("in memory");
    writer.start_file(name, options).expect("in memory");
    writer.write_all(bytes).expect("in memory");
    writer.finish().expect("in memory").into_inner()
}

#[test]
fn an_srtm_tile_takes_its_corner_from_its_name() {
    let field = read("some/N46W008.hgt", &hgt(5)).expect("a tile");
    near(&field, -8.0, 47.0, 0.0);
    near(&field, -8.0, 46.0, 1200.0);
    near(&field, -7.0, 46.5, 5.0);
    assert_eq!(field.void_samples(), 1);
    near(&field, -7.5, 46.5, 5.0);
    let packed = read("any.hgt.zip", &zipped("folder/S29W072.hgt", &hgt(7))).expect("zipped");
    near(&packed, -71.0, -28.5, 7.0);
    for (name, bytes, expected) in [
        (
            "46W008.hgt",
            hgt(5),
            "name: found \"46W008.hgt\", allowed: a corner such as N27E086",
        ),
        ("N90E000.hgt", hgt(5), "name: found"),
        (
            "N46W008.hgt",
            vec![0; 77],
            "bytes: found 77, allowed: 2884802",
        ),
        (
            "a.hgt.zip",
            zipped("N46W008.txt", &[]),
            "found 2 files, none of which ends in .hgt",
        ),
        (
            "a.hgt.zip",
            vec![1, 2, 3],
            "a.hgt.zip: not a readable zip archive",
        ),
        (
            "SainteHelens.dem",
            vec![0; 77],
            "USGS ASCII DEM is not read",
        ),
    ] {
        let found = read(name, &bytes).expect_err(name).to_string();
        assert!(found.contains(expected), "{found}");
    }
}

/// 3 meridians of 4 heights: 10 × meridian + parallel, one below zero, one void.
fn dted() -> Vec<u8> {
    let mut bytes = vec![b' '; 80 + 648 + 2700];
    bytes[..4].copy_from_slice(b"UHL1");
    bytes[4..12].copy_from_slice(b"1560000W");
    bytes[12..20].copy_from_slice(b"0190000N");
    bytes[20..28].copy_from_slice(b"03000600");
    bytes[47..55].copy_from_slice(b"00030004");
    for meridian in 0..3_u16 {
        let mut record = vec![0xAA, 0, 0, 0, 0, 0, 0, 0];
        for parallel in 0..4_u16 {
            let bits = match (meridian, parallel) {
                (1, 2) => 0x8000 | 77,
                (2, 1) => 0xFFFF,
                _ => 10 * meridian + parallel,
            };
            record.extend(bits.to_be_bytes());
        }
        let sum: u32 = record.iter().map(|&byte| u32::from(byte)).sum();
        record.extend(sum.to_be_bytes());
        bytes.extend(record);
    }
    bytes
}

#[test]
fn dted_goes_north_in_each_record_and_what_is_wrong_with_it_is_named() {
    let field = read("a.dt0", &dted()).expect("DTED");
    let seconds = 1.0 / 3600.0;
    near(&field, -156.0, 19.0, 0.0);
    near(&field, -156.0, 19.0 + 180.0 * seconds, 3.0);
    near(
        &field,
        -156.0 + 30.0 * seconds,
        19.0 + 120.0 * seconds,
        -77.0,
    );
    assert_eq!(field.void_samples(), 1);
    for (at, value, expected) in [
        (
            0,
            b'X',
            "UHL, first bytes: found \"XHL1\", allowed: \"UHL1\"",
        ),
        (11, b'Q', "UHL, longitude: found \"1560000Q\""),
        (20, b'x', "UHL, longitude interval: found \"x300\""),
        (3428, 0, "record 0, first byte: found 0x00, allowed: 0xaa"),
    ] {
        let mut bytes = dted();
        bytes[at] = value;
        let found = read("a.dt0", &bytes).expect_err(expected).to_string();
        assert!(found.contains(expected), "{found}");
    }
}

fn tile_png(side: u32, pixel: [u8; 4]) -> Vec<u8> {
    let picture = image::RgbaImage::from_pixel(side, side, image::Rgba(pixel));
    let mut bytes = Cursor::new(Vec::new());
    picture
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("in memory");
    bytes.into_inner()
}

#[test]
fn tiles_mean_what_their_encoding_says() {
    // 1·65,536 + 134·256 + 160 = 100,000 tenths.
    let bytes = tile_png(4, [1, 134, 160, 255]);
    let rgb = read("a/x_terrain-rgb_1-1-0.png", &bytes).expect("terrain-RGB");
    assert_eq!(rgb.heights().highest_m, 0.0);
    near(&rgb, 90.0, 40.0, 0.0);
    assert_eq!(rgb.height_m(-90.0, 40.0), None);
    let same = read("x_terrarium_1-1-0.png", &bytes).expect("terrarium");
    near(&same, 90.0, 40.0, 256.0 + 134.0 + 0.625 - 32_768.0);
    assert_eq!(same.grid().registration, Registration::Area);
    for name in [
        "terrarium/1/1/0.png",
        "a/terrarium/1/1/0@2x.png",
        "x_TERRARIUM_1-1-0.png",
    ] {
        let folders = read(name, &bytes).expect(name);
        assert_eq!(folders.grid(), same.grid(), "{name}");
    }
    let names = ["a/terrain_rgb/1/1/0.png", "terrainrgb/1/1/0.png"];
    for name in names {
        near(&read(name, &bytes).expect(name), 90.0, 40.0, 0.0);
    }
    for (name, expected) in [
        ("1/1/0.png", "name: found"),
        ("terrarium/1/0.png", "name: found"),
        ("terrarium/a/1/0.png", "name: found"),
        ("terrarium/1/2/0.png", "tile address: found 1-2-0"),
        ("x_terrain-rgb_1-2-0.png", "tile address: found 1-2-0"),
        ("x_terrain-rgb_99-2-0.png", "tile address: found 99-2-0"),
        ("x_terrain-rgb_1-2.png", "name: found"),
        ("x_1-1-0.png", "name: found"),
    ] {
        let found = read(name, &bytes).expect_err(name).to_string();
        assert!(found.contains(expected), "{found}");
    }
}

/// The heights of a file of the data folder.
fn read_real(name: &str) -> HeightField {
    let bytes = data::bytes(&format!("terrain/{name}"));
    read(name, &bytes).expect(name)
}

#[test]
#[ignore = "needs data: elevation"]
fn real_files_have_the_size_bounds_voids_and_heights_that_gdal_found() {
    // Columns, rows, edges of cells, voids, lowest and highest.
    type Facts = (&'static str, [u32; 2], [f64; 4], u64, [f64; 2]);
    let files: [Facts; 11] = [
        (
            "N27E086.hgt",
            [1201; 2],
            [85.999_583, 26.999_583, 87.000_417, 28.000_417],
            0,
            [192.0, 8840.0],
        ),
        (
            "N37W123.hgt",
            [1201; 2],
            [-123.000_417, 36.999_583, -121.999_583, 38.000_417],
            374,
            [-59.0, 991.0],
        ),
        (
            "N46E008_alps.tif",
            [1201; 2],
            [7.999_583, 45.999_583, 9.000_417, 47.000_417],
            103_743,
            [187.0, 4173.0],
        ),
        (
            "S29W072.hgt.zip",
            [1201; 2],
            [-72.000_417, -29.000_417, -70.999_583, -27.999_583],
            21,
            [-5.0, 1899.0],
        ),
        (
            "S33W071_aconcagua.tif",
            [1201; 2],
            [-71.000_417, -33.000_417, -69.999_583, -31.999_583],
            0,
            [250.0, 6929.0],
        ),
        (
            "etopo20_global_i16.tif",
            [1080, 540],
            [-180.0, -90.0, 180.0, 90.0],
            0,
            [-9027.0, 6229.0],
        ),
        (
            "mt_rainier_90m.tif",
            [1201; 2],
            [-122.000_417, 45.999_583, -120.999_583, 47.000_417],
            9033,
            [263.0, 4371.0],
        ),
        (
            "n19_w156_hawaii.dt1",
            [1201; 2],
            [-156.000_417, 18.999_583, -154.999_583, 20.000_417],
            0,
            [-7.0, 4207.0],
        ),
        (
            "san_francisco_1as_i16.tif",
            [1081; 2],
            [-122.600_139, 37.599_861, -122.299_861, 37.900_139],
            1779,
            [-35.0, 410.0],
        ),
        (
            "san_francisco_elev_3857.tif",
            [512; 2],
            [
                -13_630_156.552_456,
                4_549_932.529_261,
                -13_626_714.986_264,
                4_553_034.750_442,
            ],
            0,
            [0.436_01, 114.921],
        ),
        (
            "fuji_terrain-rgb_10-906-404.png",
            [512; 2],
            [15_419_488.8, 4_187_526.2, 15_458_624.6, 4_226_662.0],
            0,
            [13.7, 3751.0],
        ),
    ];
    for (name, size, edges, voids, [lowest, highest]) in files {
        let field = read_real(name);
        let grid = field.grid();
        assert_eq!([grid.columns, grid.rows], size, "{name}");
        // Edges of the samples' cells, as libraries of rasters state the bounds of either registration.
        let [west, north] = [
            grid.first[0] - 0.5 * grid.step[0],
            grid.first[1] + 0.5 * grid.step[1],
        ];
        let east = west + f64::from(grid.columns) * grid.step[0];
        let south = north - f64::from(grid.rows) * grid.step[1];
        let close = if grid.projection == Projection::Geographic {
            1e-6
        } else {
            2.0
        };
        for (found, expected) in [west, south, east, north].into_iter().zip(edges) {
            assert!(
                (found - expected).abs() < close,
                "{name}: {found}, not {expected}"
            );
        }
        assert_eq!(field.void_samples(), voids, "{name}");
        let heights = field.heights();
        assert!(
            (heights.lowest_m - lowest).abs() < 0.05,
            "{name}: {heights:?}"
        );
        assert!(
            (heights.highest_m - highest).abs() < 0.5,
            "{name}: {heights:?}"
        );
    }
}

#[test]
#[ignore = "needs data: elevation"]
fn summits_are_where_they_are() {
    let everest = read_real("N27E086.hgt");
    // 27°59′17″ N, 86°55′31″ E: 8,849 m, of which SRTM's cells of 90 m keep all but some.
    let summit = everest.height_m(86.925_3, 27.988_1).expect("inside");
    assert!((8_700.0..8_850.0).contains(&summit), "{summit}");
    // Negative control: mirrored north to south, the summit is elsewhere.
    let mirrored = everest.height_m(86.925_3, 27.011_9).expect("inside");
    assert!(mirrored < 3_000.0, "{mirrored}");
    let name = "fuji_terrain-rgb_10-906-404.png";
    let fuji = read_real(name);
    let summit = fuji.height_m(138.727_4, 35.360_6).expect("inside");
    assert!((3_600.0..3_777.0).contains(&summit), "{summit}");
    let name = "etopo20_global_i16.tif";
    let globe = read_real(name);
    // Mariana Trench and both poles; ±180° is one meridian.
    assert!(globe.height_m(142.2, 11.35).expect("everywhere") < -5_000.0);
    assert!(globe.height_m(0.0, -90.0).expect("everywhere") > 2_000.0);
    assert!(globe.height_m(0.0, 90.0).expect("everywhere") < -3_000.0);
    for latitude in [-60.0, 0.1, 45.0] {
        let [west, east] = [-180.0, 180.0].map(|l| globe.height_m(l, latitude).expect("there"));
        assert!((west - east).abs() < 1e-6, "{west} {east}");
    }
    let tile = "grand_canyon_terrarium_12-759-1608.png";
    let terrarium = read_real(tile);
    let tile = "grand_canyon_terrain-rgb_12-759-1608.png";
    let rgb = read_real(tile);
    // Two services, one canyon.
    for (longitude, latitude) in [(-113.25, 36.0), (-113.22, 35.97)] {
        let [a, b] =
            [&terrarium, &rgb].map(|field| field.height_m(longitude, latitude).expect("in"));
        assert!((a - b).abs() < 60.0, "{a} {b}");
    }
}
