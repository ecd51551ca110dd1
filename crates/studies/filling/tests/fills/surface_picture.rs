// SPDX-License-Identifier: MIT OR Apache-2.0
//! Surfaces coloured by a picture of the whole body: each pixel beside the place that it stands for, in `f64`.

use crate::drawing::by_main::{Open, prepared};
use crate::drawing::{collection, polygon, shown, square};
use glam::DVec3;
use std::sync::Arc;
use terrafill_contract::{FillInput, Picture, PreparedScene, Technique};
use terrafill_native::NativeTechnique;
use terrafill_scene::{ImageSize, MipChain, Scene, View};
use terrafill_surface::EllipsoidKind;
use terrafill_vertex::VertexTechnique;

const SIZE: ImageSize = square(192);

/// Texels from pole to pole; twice as many around.
const ROWS: u32 = 128;

/// Name, longitude, latitude, height and pitch: all of a hemisphere, across ±180°, both poles, and low enough for
/// a texel to fill the image.
const VIEWS: [(&str, [f64; 4]); 5] = [
    ("globe", [10.0, 20.0, 8e6, -90.0]),
    ("antimeridian", [180.0, -3.0, 1e6, -90.0]),
    ("north", [30.0, 90.0, 2e6, -90.0]),
    ("south", [-120.0, -89.0, 2e6, -60.0]),
    ("low", [-70.0, -33.0, 2e4, -40.0]),
];

fn scene() -> (PreparedScene, Vec<View>) {
    let views = VIEWS.map(|(name, [longitude, latitude, height, pitch])| {
        format!(
            "[[views]]\nname = \"{name}\"\nlongitude_deg = {longitude}\nlatitude_deg = {latitude}\n\
             height_m = {height}\nheading_deg = 0\npitch_deg = {pitch}\n"
        )
    });
    // A scene needs a region; this one is filled in one view, and those pixels are not compared.
    let region = polygon("small", "[[11,21],[12,21],[12,22],[11,22],[11,21]]");
    let text = format!(
        "name = \"picture\"\ndescription = \"a picture\"\nbody = \"wgs84\"\n\
         [regions]\ninline = '''{}'''\n[surface]\nkind = \"ellipsoid\"\nrows = 360\n{}",
        collection(&[region]),
        views.concat()
    );
    let scene = Scene::from_toml(&text, "picture.toml", None).expect("a scene");
    (prepared(&[&EllipsoidKind], &scene), scene.views)
}

/// Levels of 255 that stand for a direction from the body's centre.
fn colour_of(normal: DVec3) -> [f64; 3] {
    (normal * 100.0 + 128.0).to_array()
}

/// Each texel has the colour of its place's normal, turned east by so many columns.
fn picture_of_normals(turned: u32) -> Arc<MipChain> {
    let columns = 2 * ROWS;
    let mut texels = Vec::new();
    for row in 0..ROWS {
        let latitude = 90.0 - 180.0 * (f64::from(row) + 0.5) / f64::from(ROWS);
        for column in 0..columns {
            let at = f64::from((column + turned) % columns) + 0.5;
            let longitude = 360.0 * at / f64::from(columns) - 180.0;
            let (sin_lon, cos_lon) = longitude.to_radians().sin_cos();
            let (sin_lat, cos_lat) = latitude.to_radians().sin_cos();
            let normal = DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
            #[allow(clippy::cast_possible_truncation, reason = "28 to 228")]
            let bytes = colour_of(normal).map(|level| level.round() as u8);
            texels.extend([bytes[0], bytes[1], bytes[2], 255]);
        }
    }
    Arc::new(MipChain::new(columns, ROWS, texels).expect("as many texels"))
}

/// Ground pixels of the two that are not seen edge-on, and how many of them differ by more than the bytes' rounding from the colour of the
/// place that the ray through them meets, times what darkens the plain surface there.
fn compared_and_wrong(input: &FillInput, plain: &Picture, coloured: &Picture) -> [usize; 2] {
    // Blue of the plain surface, levels.
    const PLAIN_BLUE: f64 = 0.58 * 255.0;
    let (mut compared, mut wrong) = (0, 0);
    for (at, pixels) in plain
        .rgba
        .chunks(4)
        .zip(coloured.rgba.chunks(4))
        .enumerate()
    {
        assert_eq!(plain.depth[at].to_bits(), coloured.depth[at].to_bits());
        let depth = f64::from(plain.depth[at]);
        if depth == 0.0 || pixels.0[3] != 0 {
            assert_eq!(pixels.0, pixels.1, "the sky and what is filled");
            continue;
        }
        let at = u32::try_from(at).expect("a small image");
        let (column, row) = (at % SIZE.width, at / SIZE.width);
        let along = input.camera.pixel_direction_ecef(SIZE, column, row);
        let place = input.camera.eye_ecef + along * (input.camera.near_m / depth);
        let place = input.scene.body.ecef_to_geodetic(place);
        let normal =
            (input.scene.body).geodetic_surface_normal(place.longitude_rad, place.latitude_rad);
        // Seen edge-on, a pixel spans places of many colours, and shows what they have in common.
        if -normal.dot(along.normalize()) < 0.2 {
            continue;
        }
        let brightness = f64::from(pixels.0[2]) / PLAIN_BLUE;
        let expected = colour_of(normal).map(|level| (level * brightness).min(255.0));
        compared += 1;
        let is_off = |i: usize| (expected[i] - f64::from(pixels.1[i])).abs() > 3.0;
        wrong += usize::from((0..3).any(is_off) || pixels.1[3] != 0);
    }
    [compared, wrong]
}

#[test]
fn a_picture_of_the_body_lies_where_its_places_are() {
    let Some(open) = Open::new(SIZE) else {
        return;
    };
    let (plain, views) = scene();
    let with = |turned| PreparedScene {
        picture: Some(picture_of_normals(turned)),
        ..plain.clone()
    };
    // Negative control: five columns of 256 are 7°.
    let (right, turned) = (with(0), with(5));
    for technique in [&VertexTechnique as &dyn Technique, &NativeTechnique] {
        for view in &views {
            let draw = |scene| {
                let input = shown(scene, view, SIZE);
                let drawn = open.drawn(technique, &input);
                (input, drawn)
            };
            let (input, bare) = draw(&plain);
            let what = format!("{}, {}", view.name, technique.name());
            let [compared, wrong] = compared_and_wrong(&input, &bare, &draw(&right).1);
            assert!(compared > 10_000, "{what}: {compared}");
            assert_eq!(wrong, 0, "{what}");
            let [compared, wrong] = compared_and_wrong(&input, &bare, &draw(&turned).1);
            // Around a pole a turn moves little.
            assert!(wrong > 500, "{what}: {wrong} of {compared}");
        }
    }
}
