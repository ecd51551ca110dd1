// SPDX-License-Identifier: MIT OR Apache-2.0
//! Textured fills on the device against the reference: where each pixel's texels come from, and the
//! colours, over placements and latitudes, on shipped scenes, by every backend that has them. Wrong
//! latitudes, axes and anchors must be noticed, and plain fills must not know of any of it.

use crate::drawing;

use drawing::by_main::prepared;
use drawing::{
    AllTargets, Devices, Technique, collection, compute, counters, draw, draw_with, in_layout,
    look, made, polygon, scene, shown, storages, stored, vertex, with_colour, with_switches,
};
use std::sync::Arc;
use terrafill_conformance::{
    TextureErrors, Verdict, compare, compare_texture, silhouette_band, texture_verdict, verdict,
};
use terrafill_contract::{DeviceError, FillInput, Frame, PreparedScene};
use terrafill_core::Ellipsoid;
use terrafill_fixtures::data;
use terrafill_native::{Extrusion, Indices};
use terrafill_reference::{ReferenceBackend, ReferenceFrame};
use terrafill_scene::{
    ImageSize, MipChain, Outside, Overlap, Scene, SceneTexture, TextureAnchor, TexturePlacement,
    TextureShare,
};
use terrafill_surface::EllipsoidKind;
use terrafill_variant::{ColourWay, RouteChoice, Switches};
use terrafill_vertex::Layout;

const SIZE: ImageSize = ImageSize::new(256, 192);

fn switches(texture: &str, colour: ColourWay) -> Switches {
    Switches {
        colour,
        texture: Some(RouteChoice::parse(texture).expect("known")),
        ..Switches::default()
    }
}

fn judge(input: &FillInput) -> ReferenceFrame {
    ReferenceBackend::textured()
        .judge(input)
        .expect("regions are readable")
}

/// A frame must be the reference's by region and by texel.
fn assert_right(what: &str, reference: &Frame, frame: &Frame) -> TextureErrors {
    let figures = compare(reference, frame).expect("comparable");
    assert!(verdict(&figures).is_pass(), "{what}: {figures:?}");
    let errors = compare_texture(reference, frame).expect("comparable");
    eprintln!("{what}: {errors:?}");
    // The least is California on a globe of this size.
    assert!(errors.compared_px > 40, "{what}: {errors:?}");
    assert_eq!((errors.non_finite, frame.non_finite), (0, 0), "{what}");
    assert!(texture_verdict(&errors).is_pass(), "{what}: {errors:?}");
    assert!(errors.max_level < 0.02, "{what}: {errors:?}");
    errors
}

/// How far colours are apart where both fill opaquely, away from silhouettes: the largest difference
/// of a channel, and the mean.
fn colours_apart(reference: &ReferenceFrame, frame: &Frame, rgba: &[u8]) -> (u8, f64) {
    let band = silhouette_band(&reference.frame).expect("textured");
    let picture = reference.picture.as_ref().expect("textured");
    let (mut largest, mut sum, mut count) = (0, 0.0, 0.0);
    for (index, (exact, drawn)) in picture
        .chunks_exact(3)
        .zip(rgba.chunks_exact(4))
        .enumerate()
    {
        let is_same = reference.frame.ids[index] == frame.ids[index] && frame.ids[index] > 0;
        if !is_same || band[index] || drawn[3] < 255 {
            continue;
        }
        for (a, b) in exact.iter().zip(drawn) {
            let apart = a.abs_diff(*b);
            largest = largest.max(apart);
            sum += f64::from(apart);
            count += 1.0;
        }
    }
    assert!(count > 0.0, "nothing to compare");
    (largest, sum / count)
}

/// A scene that ships with the program.
fn shipped(name: &str) -> (Scene, PreparedScene) {
    let scene = data::scene(name);
    let prepared = prepared(&[&EllipsoidKind], &scene);
    (scene, prepared)
}

#[test]
fn shipped_scenes_show_their_picture_where_the_reference_does() {
    assert_pictures_as_the_reference(&[
        "california",
        "shared-picture",
        "window-west",
        "window-east",
        "hatching",
        "fade",
    ]);
}

#[test]
#[ignore = "needs data: natural-earth-110m, blue-marble"]
fn countries_show_the_blue_marble_where_the_reference_does() {
    assert_pictures_as_the_reference(&["blue-marble"]);
}

fn assert_pictures_as_the_reference(names: &[&str]) {
    let Some(devices) = Devices::open() else {
        return;
    };
    for &name in names {
        let (scene, prepared) = shipped(name);
        let targets = AllTargets::new(&devices, SIZE);
        let mut backend = targets.open(vertex(switches("chosen", ColourWay::Xor)));
        for view in &scene.views {
            let input = shown(&prepared, view, SIZE);
            let reference = judge(&input);
            let frame = draw_with(&mut *backend, &input);
            let note = backend.note().expect("routes");
            let what = format!("{name}/{}: {note}", view.name);
            assert_right(&what, &reference.frame, &frame);
            let texture = scene.texture.as_ref().expect("a picture");
            if texture.fade_m.is_some() || name == "hatching" {
                // What lies under shows, which the reference paints in one colour.
                continue;
            }
            let picture = backend.picture(&input).expect("draws");
            let (largest, mean) = colours_apart(&reference, &frame, &picture.rgba);
            eprintln!("{what}: colours {largest} at most, {mean:.3} in the mean");
            assert!(mean < 1.0, "{what}: {largest} {mean}");
        }
    }
}

#[test]
fn a_region_that_moves_uncovers_a_picture_that_lies_still() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let drawn = |name: &str, placement: Option<TexturePlacement>| {
        let (scene, prepared) = shipped(name);
        let texture = SceneTexture {
            placement: placement.unwrap_or(scene.texture.as_ref().expect("a picture").placement),
            ..SceneTexture::clone(scene.texture.as_deref().expect("a picture"))
        };
        let prepared = PreparedScene {
            texture: Some(Arc::new(texture)),
            ..prepared
        };
        let input = shown(&prepared, &scene.views[0], SIZE);
        let chosen = vertex(switches("chosen", ColourWay::Xor));
        let frame = draw(&devices, &input, chosen);
        frame.texture.expect("textured").pixels
    };
    // Farthest apart that a pixel of both shows the picture, and pixels of both and of one.
    let compared = |placement: Option<TexturePlacement>| {
        let pair = ["window-west", "window-east"].map(|name| drawn(name, placement));
        let (mut apart, mut both, mut one) = (0.0_f64, 0, 0);
        for pixels in pair[0].iter().zip(&pair[1]) {
            match pixels {
                (Some(a), Some(b)) => {
                    both += 1;
                    apart = apart.max((a.uv[0] - b.uv[0]).hypot(a.uv[1] - b.uv[1]));
                }
                (None, None) => {}
                _ => one += 1,
            }
        }
        (apart, both, one)
    };
    let (apart, both, one) = compared(None);
    // Half a texel of 512: the tolerance of a place.
    assert!(apart < 0.5 / 512.0, "{apart}");
    assert!(both > 100 && one > 100, "{both} {one}");
    // Negative control: a picture that lies over the region's extent moves with it.
    let (apart, ..) = compared(Some(TexturePlacement::Extents));
    assert!(apart > 0.1, "{apart}");
}

fn checker(columns: u32, rows: u32) -> MipChain {
    let rgba = (0..columns * rows)
        .flat_map(|i| {
            let (x, y) = (i % columns, i / columns);
            let green = if (x / 8 + y / 8) % 2 == 0 { 60 } else { 190 };
            let ramp = |at: u32, count: u32| u8::try_from(30 + 200 * at / count).unwrap_or(255);
            [ramp(x, columns), green, ramp(y, rows), 255]
        })
        .collect();
    MipChain::new(columns, rows, rgba).expect("as many bytes as it needs")
}

fn textured(scene: &PreparedScene, placement: TexturePlacement) -> PreparedScene {
    PreparedScene {
        texture: Some(Arc::new(SceneTexture {
            source: "test".to_owned(),
            image: checker(128, 64),
            share: TextureShare::One,
            alpha: 1.0,
            placement,
            fade_m: None,
        })),
        ..scene.clone()
    }
}

fn anchor(longitude_deg: f64, latitude_deg: f64, rotation_deg: f64) -> TextureAnchor {
    TextureAnchor {
        longitude_rad: longitude_deg.to_radians(),
        latitude_rad: latitude_deg.to_radians(),
        rotation_rad: rotation_deg.to_radians(),
    }
}

/// Two regions side by side around a place, the second with a hole.
fn around(longitude: f64, latitude: f64, half_width: f64) -> PreparedScene {
    let ring = |w: f64, s: f64, e: f64, n: f64| {
        format!("[[{w},{s}],[{e},{s}],[{e},{n}],[{w},{n}],[{w},{s}]]")
    };
    let (south, north) = (latitude - 1.5, latitude + 1.5);
    let (west, east) = (longitude - half_width, longitude + half_width);
    let hole = ring(
        longitude + 0.3 * half_width,
        latitude - 0.5,
        longitude + 0.6 * half_width,
        latitude + 0.5,
    );
    let features = [
        polygon("west", &ring(west, south, longitude, north)),
        polygon(
            "east",
            &format!("{},{hole}", ring(longitude, south, east, north)),
        ),
    ];
    scene(
        &collection(&features),
        Ellipsoid::WGS84,
        360,
        Overlap::Disjoint,
    )
}

/// A cap around the north pole, which holds it.
fn cap() -> PreparedScene {
    let ring: Vec<String> = (-180..180)
        .step_by(10)
        .chain([180])
        .map(|longitude| format!("[{longitude},86.5]"))
        .collect();
    let features = [polygon("cap", &format!("[{}]", ring.join(",")))];
    scene(
        &collection(&features),
        Ellipsoid::WGS84,
        360,
        Overlap::Disjoint,
    )
}

/// Scenes at the latitudes where angles are hard, each with an eye.
fn places() -> Vec<(&'static str, PreparedScene, drawing::Pose)> {
    vec![
        ("0°", around(12.0, 0.0, 2.0), (12.0, 0.0, 3e5, 20.0, -90.0)),
        (
            "45° aslant",
            around(12.0, 45.0, 2.5),
            (12.0, 44.0, 1.5e5, 0.0, -40.0),
        ),
        (
            "70°",
            around(12.0, 70.0, 4.0),
            (12.0, 70.0, 3e5, 0.0, -90.0),
        ),
        (
            "85°",
            around(12.0, 85.0, 15.0),
            (12.0, 85.0, 3e5, 70.0, -90.0),
        ),
        (
            "±180°",
            around(180.0, -17.0, 2.0),
            (179.9, -17.0, 3e5, 0.0, -90.0),
        ),
        ("pole", cap(), (30.0, 89.9, 5e5, 0.0, -90.0)),
    ]
}

#[test]
fn every_placement_is_right_at_every_latitude() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    for (place, scene, pose) in places() {
        let (longitude, latitude) = (pose.0 + 0.4, pose.1.min(89.0) - 0.3);
        let placements = [
            ("extents", TexturePlacement::Extents),
            (
                "anchor",
                TexturePlacement::Anchor {
                    anchor: anchor(longitude, latitude, 25.0),
                    width_m: 9e4,
                    height_m: 6e4,
                    outside: Outside::Repeat,
                },
            ),
            (
                "pattern",
                TexturePlacement::Pattern {
                    anchor: anchor(longitude, latitude, 70.0),
                    texels_per_px: 1.3,
                },
            ),
        ];
        let targets = AllTargets::new(&devices, SIZE);
        for (name, placement) in placements {
            // Metres east of an anchor are degrees of its own latitude: beyond a pole they mean
            // nothing, and the picture is as torn as the longitude.
            if place == "pole" && name != "extents" {
                continue;
            }
            let input = look(&textured(&scene, placement), pose, 1e3, SIZE);
            let reference = judge(&input);
            let xor = switches("chosen", ColourWay::Xor);
            let planes = switches("chosen", ColourWay::BitPlanes);
            let mut backends = [
                ("vertex", vertex(xor)),
                ("pulled, bit-planes", in_layout(Layout::Pulled, planes)),
                ("compute", compute(xor)),
            ]
            .map(|(name, technique)| (name, targets.open(technique)));
            let mut frames = Vec::new();
            for (backend_name, backend) in &mut backends {
                let frame = draw_with(&mut **backend, &input);
                let note = backend.note().expect("routes");
                let what = format!("{place}, {name}, {backend_name}: {note}");
                assert_right(&what, &reference.frame, &frame);
                frames.push(frame);
            }
            // The same shader over the same depth: the same places to the bit.
            for frame in &frames[1..] {
                assert_eq!(frame.texture, frames[0].texture, "{place}, {name}");
            }
            // The covers are the same whatever marks their pixels: every technique in one place.
            let techniques = if place.starts_with("45") {
                storages()
            } else {
                vec![(Extrusion::GsDegenerate, Indices::List)]
            };
            for (technique, indices) in techniques {
                let way = if technique == Extrusion::GsLine {
                    planes
                } else {
                    xor
                };
                let mut backend = targets.open(stored(technique, indices, way));
                let frame = draw_with(&mut *backend, &input);
                let what = format!("{place}, {name}, {technique:?}, {indices:?}");
                assert_right(&what, &reference.frame, &frame);
                assert_eq!(backend.note(), backends[0].1.note(), "{what}");
            }
            let picture = backends[0].1.picture(&input).expect("draws");
            let (largest, mean) = colours_apart(&reference, &frames[0], &picture.rgba);
            eprintln!("{place}, {name}: colours {largest} at most, {mean:.3} in the mean");
            assert!(mean < 1.0, "{place}, {name}: {largest} {mean}");
        }
    }
}

#[test]
fn wrong_latitudes_routes_and_anchors_are_noticed() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let scene = textured(&around(12.0, 45.0, 2.5), TexturePlacement::Extents);
    let input = look(&scene, (12.0, 45.0, 3e5, 0.0, -90.0), 1e3, SIZE);
    let reference = judge(&input).frame;
    let targets = AllTargets::new(&devices, SIZE);
    let fails = |what: &str, frame: &Frame| {
        let errors = compare_texture(&reference, frame).expect("comparable");
        let verdict = texture_verdict(&errors);
        assert!(matches!(verdict, Verdict::Fail(_)), "{what}: {errors:?}");
    };
    let with = |route: &str, input: &FillInput| {
        targets.draw(input, vertex(switches(route, ColourWay::Xor)))
    };
    fails("geocentric", &with("odd-15+geocentric", &input));
    fails("a coarse route", &with("odd-3", &input));
    let moved = |placement| FillInput {
        scene: textured(&input.scene, placement),
        ..input.clone()
    };
    // The same extents by way of an anchor, and then a hundredth beside it.
    let body = Ellipsoid::WGS84;
    let turned = |rotation: f64, east: f64| {
        let sin = 45_f64.to_radians().sin();
        let e2 = body.eccentricity_squared();
        let n = body.equatorial_radius_m() / (1.0 - e2 * sin * sin).sqrt();
        let m = n * (1.0 - e2) / (1.0 - e2 * sin * sin);
        moved(TexturePlacement::Anchor {
            anchor: anchor(10.75 + east, 45.0, rotation),
            width_m: 2.5_f64.to_radians() * n * 45_f64.to_radians().cos(),
            height_m: 3_f64.to_radians() * m,
            outside: Outside::Repeat,
        })
    };
    let errors = |input: &FillInput| {
        let mut frame = with("chosen", input);
        // Only the first region lies where the extents' picture does.
        for (id, place) in frame
            .ids
            .iter()
            .zip(&mut frame.texture.as_mut().expect("textured").pixels)
        {
            if *id != 1 {
                *place = None;
            }
        }
        let errors = compare_texture(&reference, &frame).expect("comparable");
        errors.max_texels[0].max(errors.max_texels[1])
    };
    assert!(errors(&turned(0.0, 0.0)) < 0.5);
    assert!(errors(&turned(0.0, 0.025)) > 0.5, "another anchor");
    assert!(errors(&turned(180.0, 0.0)) > 0.5, "upside down");
    assert!(errors(&turned(90.0, 0.0)) > 0.5, "axes swapped");
}

#[test]
fn position_routes_differ_by_what_is_known_of_them() {
    let Some(devices) = Devices::open() else {
        return;
    };
    // 50 m above a picture of 64 m: texels of half a metre.
    let placement = TexturePlacement::Anchor {
        anchor: anchor(12.0, 45.0, 0.0),
        width_m: 64.0,
        height_m: 64.0,
        outside: Outside::Repeat,
    };
    let scene = textured(&around(12.0, 45.0, 0.001), placement);
    let input = look(&scene, (12.0, 45.0, 2e3, 0.0, -90.0), 0.1, SIZE);
    let targets = AllTargets::new(&devices, SIZE);
    let reference = judge(&input).frame;
    let worst = |position: &str| {
        let mut switches = switches("chosen", ColourWay::Xor);
        assert_eq!(switches.set("position", position), Ok(true));
        let frame = targets.draw(&input, vertex(switches));
        let errors = compare_texture(&reference, &frame).expect("comparable");
        assert_eq!(errors.non_finite, 0);
        errors.max_texels[0].max(errors.max_texels[1])
    };
    let found = ["inverse-ecef", "eye-ecef", "eye-region"].map(worst);
    eprintln!("{found:?}");
    let [inverse, eye_ecef, eye_region] = found;
    assert!(eye_region <= 0.5, "{found:?}");
    assert!(eye_ecef > eye_region && inverse > eye_region, "{found:?}");
}

#[test]
fn a_plain_fill_knows_nothing_of_the_scenes_picture() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let bare = around(12.0, 45.0, 2.5);
    let dressed = textured(&bare, TexturePlacement::Extents);
    let pose = (12.0, 45.0, 3e5, 0.0, -90.0);
    let used = |scene: &PreparedScene, technique: Technique| {
        let input = look(scene, pose, 1e3, SIZE);
        let mut backend = AllTargets::new(&devices, SIZE).open(technique);
        let memory = backend.prepare(&input).expect("fits");
        let frame = backend.render(&input).expect("draws");
        if let Technique::Native(_) = technique {
            let again = backend.render(&input).expect("draws");
            assert_eq!(made(&again), [0; 3], "{technique:?}");
            assert!(backend.time_frame(&input).expect("draws").fill_cpu_ms > 0.0);
        } else if technique.switches().texture.is_none() {
            assert_eq!(backend.note(), None);
        }
        (memory, counters(&frame), frame.ids, frame.texture)
    };
    let extruded = [Extrusion::GsDegenerate, Extrusion::VsControl]
        .map(|technique| stored(technique, Indices::List, Switches::default()));
    let coloured = ColourWay::ALL.map(with_colour).into_iter();
    let coloured = coloured.flat_map(|plain| [vertex(plain), compute(plain)]);
    for technique in coloured.chain(extruded) {
        let (with, without) = (used(&dressed, technique), used(&bare, technique));
        assert_eq!(with, without, "{technique:?}");
        assert_eq!((with.0.texture_bytes, with.3), (0, None), "{technique:?}");
    }
    // Negative control: the textured fill of the same scene costs memory, a buffer and other pipelines.
    let chosen = switches("chosen", ColourWay::Xor);
    let image_bytes = dressed.texture.as_ref().expect("a picture").image.bytes();
    for technique in std::iter::once(vertex(Switches::default())).chain(extruded) {
        let (plain_memory, plain, ..) = used(&dressed, technique);
        let (memory, textured, ..) = used(&dressed, with_switches(technique, chosen));
        assert_eq!(memory.texture_bytes, image_bytes);
        assert_eq!(memory.buffers, plain_memory.buffers + 1);
        assert!(memory.constant_bytes > plain_memory.constant_bytes);
        assert_eq!(
            (textured.draws, textured.vertices),
            (plain.draws, plain.vertices)
        );
        assert_eq!(textured.buffer_creations, plain.buffer_creations + 1);
    }
}

#[test]
fn a_second_frame_of_a_textured_fill_makes_and_writes_nothing_more() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let scene = textured(&around(12.0, 45.0, 2.5), TexturePlacement::Extents);
    let input = look(&scene, (12.0, 45.0, 3e5, 0.0, -90.0), 1e3, SIZE);
    let targets = AllTargets::new(&devices, SIZE);
    let chosen = switches("chosen", ColourWay::Xor);
    let second = |technique| {
        let mut backend = targets.open(technique);
        draw_with(&mut *backend, &input);
        let again = draw_with(&mut *backend, &input);
        assert!(backend.time_frame(&input).expect("draws").fill_cpu_ms > 0.0);
        made(&again)
    };
    assert_eq!(second(vertex(chosen)), [0; 3]);
    // What compute makes anew it makes for its volumes, textured or not.
    let plain = compute(Switches::default());
    assert_eq!(second(compute(chosen)), second(plain));
}

#[test]
fn native_shows_the_picture_that_vertex_shows_and_notices_another_anchor() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let scene = around(12.0, 45.0, 2.5);
    let at = |longitude: f64| {
        let placement = TexturePlacement::Anchor {
            anchor: anchor(longitude, 44.8, 25.0),
            width_m: 9e4,
            height_m: 6e4,
            outside: Outside::Transparent,
        };
        let mut scene = textured(&scene, placement);
        let mut picture = (**scene.texture.as_ref().expect("textured")).clone();
        picture.alpha = 0.75;
        picture.fade_m = Some([2e5, 6e5]);
        picture.share = TextureShare::Each;
        scene.texture = Some(Arc::new(picture));
        look(&scene, (12.0, 44.0, 1.5e5, 0.0, -40.0), 1e3, SIZE)
    };
    let input = at(12.1);
    let reference = judge(&input).frame;
    let targets = AllTargets::new(&devices, SIZE);
    let chosen = switches("chosen", ColourWay::Xor);
    let mut by_vertex = targets.open(vertex(chosen));
    by_vertex.prepare(&input).expect("fits");
    let wanted = by_vertex.picture(&input).expect("draws").rgba;
    let mut by_native = targets.open(stored(Extrusion::GsDegenerate, Indices::List, chosen));
    let frame = draw_with(&mut *by_native, &input);
    let errors = compare_texture(&reference, &frame).expect("comparable");
    eprintln!("native: {errors:?}");
    assert!(texture_verdict(&errors).is_pass(), "{errors:?}");
    let largest = |rgba: &[u8]| {
        let apart = wanted.iter().zip(rgba).map(|(a, b)| a.abs_diff(*b));
        apart.max().expect("pixels")
    };
    let apart = largest(&by_native.picture(&input).expect("draws").rgba);
    assert!(apart <= 2, "{apart}");
    // Negative control: the picture a hundredth of a degree beside, 800 m where a texel is 700 m wide.
    let beside = at(12.11);
    let moved = draw_with(&mut *by_native, &beside);
    let errors = compare_texture(&reference, &moved).expect("comparable");
    assert!(
        matches!(texture_verdict(&errors), Verdict::Fail(_)),
        "{errors:?}"
    );
    assert!(largest(&by_native.picture(&beside).expect("draws").rgba) > 2);
}

/// Routes that read a table: by number, filtered, and a cube.
const TABLES: [&str; 4] = [
    "lut-1024-r32f-linear-exact",
    "lut-64-r8-nearest",
    "lut-256-r16f-linear",
    "cube-256",
];

#[test]
fn tables_are_read_by_native_as_by_vertex() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let scene = textured(&around(12.0, 45.0, 2.5), TexturePlacement::Extents);
    let input = look(&scene, (12.0, 45.0, 3e5, 0.0, -90.0), 1e3, SIZE);
    let targets = AllTargets::new(&devices, SIZE);
    let places = |frame: Frame| frame.texture.expect("textured").pixels;
    let farthest = |route: &str, other: &str| {
        let [first, second] = [route, other].map(|route| switches(route, ColourWay::Xor));
        let by_native = stored(Extrusion::VsControl, Indices::List, second);
        let frames = [vertex(first), by_native].map(|technique| {
            let mut backend = targets.open(technique);
            let frame = draw_with(&mut *backend, &input);
            let memory = backend.prepare(&input).expect("fits");
            (memory.texture_bytes, places(frame))
        });
        let [(bytes, one), (other_bytes, two)] = frames;
        assert_eq!(bytes == other_bytes, route == other);
        let mut largest = 0.0_f64;
        for (a, b) in one.iter().zip(&two) {
            assert_eq!(a.is_some(), b.is_some());
            if let (Some(a), Some(b)) = (a, b) {
                largest = largest.max((a.uv[0] - b.uv[0]).abs().max((a.uv[1] - b.uv[1]).abs()));
            }
        }
        largest
    };
    for route in TABLES {
        let found = farthest(route, route);
        eprintln!("{route}: {found:e}");
        assert!(found < 1e-6, "{route}: {found:e}");
    }
    // Negative control: a table of fewer and coarser texels leads elsewhere.
    assert!(farthest(TABLES[0], TABLES[1]) > 1e-6);
}

#[test]
fn what_cannot_be_textured_is_refused() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let bare = around(12.0, 45.0, 2.5);
    let dressed = textured(&bare, TexturePlacement::Extents);
    let pose = (12.0, 45.0, 3e5, 0.0, -90.0);
    let refused = |scene: &PreparedScene, colour: ColourWay| {
        let input = look(scene, pose, 1e3, SIZE);
        let chosen = vertex(switches("chosen", colour));
        let mut backend = AllTargets::new(&devices, SIZE).open(chosen);
        match backend.prepare(&input) {
            Ok(_) => None,
            Err(DeviceError::Switch(error)) => Some(error.to_string()),
            Err(error) => panic!("{error}"),
        }
    };
    for colour in ColourWay::ALL {
        let apart = [ColourWay::Xor, ColourWay::BitPlanes].contains(&colour);
        let error = refused(&dressed, colour);
        assert_eq!(error.is_none(), apart, "{error:?}");
    }
    let error = refused(&bare, ColourWay::Xor).expect("no picture");
    assert!(error.contains("without a picture"), "{error}");
}
