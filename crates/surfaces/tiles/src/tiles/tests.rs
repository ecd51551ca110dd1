// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tiles hold what the contract promises: closed, close enough to the full resolution, within their
//! stated heights; and each check fails where it must.

use super::*;
use glam::DVec3;
use std::time::{Duration, Instant};
use terrafill_core::{Geodetic, nearest_f32};
use terrafill_elevation::{Base, Grid, HeightField, Projection, Registration, Relief};
use terrafill_scene::{CameraPose, Scene};
use terrafill_surface::{EllipsoidKind, InBackground, open_surface};

const SIZE: ImageSize = ImageSize::new(96, 96);

/// Ridges of 2 km on 1° × 1° of 300 × 300 samples over a bare ellipsoid.
fn ridges() -> Elevation {
    let samples = (0..90_000_u32).map(|i| {
        let [x, y] = [i % 300, i / 300].map(f64::from);
        let ridge = (x * 0.21).sin() * (y * 0.13 + x * 0.05).cos();
        let spike = if (i.wrapping_mul(2_654_435_761) >> 20).is_multiple_of(37) {
            150.0
        } else {
            0.0
        };
        nearest_f32(1000.0 + 900.0 * ridge + spike)
    });
    let grid = Grid {
        projection: Projection::Geographic,
        registration: Registration::Point,
        columns: 300,
        rows: 300,
        first: [10.0, 47.0],
        step: [1.0 / 299.0; 2],
    };
    let field = HeightField::new("ridges", grid, samples.collect()).expect("a field");
    Elevation::new(vec![field], Base::Flat, 0.05, 1.0)
}

fn grown() -> Elevation {
    let base = Base::Relief {
        relief: Relief { seed: 3 },
        amplitude_m: 9e3,
    };
    Elevation::new(Vec::new(), base, 0.05, 1.0)
}

fn camera(place: [f64; 3], heading_deg: f64, pitch_deg: f64) -> Camera {
    let [longitude, latitude, height_m] = place;
    let pose = CameraPose {
        eye: Geodetic::from_degrees(longitude, latitude, height_m),
        heading_rad: heading_deg.to_radians(),
        pitch_rad: pitch_deg.to_radians(),
        fov_y_rad: 60_f64.to_radians(),
        near_m: 0.5,
    };
    Camera::new(&Ellipsoid::WGS84, &pose)
}

/// Nearest hit of each pixel's ray with a triangle's front, as the multiple of its direction.
fn hits(frame: &SurfaceFrame, camera: &Camera) -> Vec<Option<f64>> {
    let mut nearest: Vec<Option<f64>> = vec![None; SIZE.pixel_count()];
    let directions: Vec<DVec3> = (0..SIZE.height)
        .flat_map(|row| (0..SIZE.width).map(move |column| (column, row)))
        .map(|(column, row)| camera.pixel_direction_ecef(SIZE, column, row))
        .collect();
    let scale = f64::from(SIZE.height) / (2.0 * camera.tan_half_fov());
    for triangle in frame.triangles.iter() {
        let corners = triangle.map(|i| DVec3::from(frame.vertices_rte[i as usize].map(f64::from)));
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        if normal.dot(a) >= 0.0 {
            continue;
        }
        let view = corners.map(|corner| camera.view_from_ecef * corner);
        let mut low = [0.0; 2];
        let mut high = [f64::from(SIZE.width), f64::from(SIZE.height)];
        if view.iter().all(|v| v.z < -camera.near_m) {
            let px = view.map(|v| [v.x / -v.z * scale, -v.y / -v.z * scale]);
            for axis in 0..2 {
                let middle = high[axis] * 0.5;
                let at = px.map(|p| p[axis] + middle);
                low[axis] = (at.into_iter().fold(f64::MAX, f64::min) - 1.0).max(0.0);
                high[axis] = (at.into_iter().fold(f64::MIN, f64::max) + 1.0).min(high[axis]);
            }
        } else if view.iter().all(|v| v.z > 0.0) {
            continue;
        }
        #[allow(clippy::cast_possible_truncation, reason = "cut to the picture")]
        let [columns, rows] =
            [0, 1].map(|axis| low[axis] as usize..high[axis].max(0.0).ceil() as usize);
        for row in rows {
            for column in columns.clone() {
                let pixel = row * SIZE.width as usize + column;
                let direction = directions[pixel];
                let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| p.cross(q).dot(direction));
                if sides.iter().all(|&side| side <= 0.0) {
                    let t = normal.dot(a) / normal.dot(direction);
                    let old = nearest[pixel].unwrap_or(f64::INFINITY);
                    if t > 0.0 && t.is_finite() {
                        nearest[pixel] = Some(old.min(t));
                    }
                }
            }
        }
    }
    nearest
}

/// Pixels whose ray enters the body and meets no triangle.
fn cracks(tiles: &Tiles, camera: &Camera) -> usize {
    cracks_of(tiles, camera, &tiles.frame(camera, SIZE).expect("above"))
}

fn cracks_of(tiles: &Tiles, camera: &Camera, frame: &SurfaceFrame) -> usize {
    let body = &tiles.body;
    let deep = 1.0 + tiles.heights(&Extent::WHOLE).lowest_m.min(0.0) / body.polar_radius_m();
    let a = body.equatorial_radius_m() * deep;
    let inverse = DVec3::new(a, a, body.polar_radius_m() * deep).recip();
    let eye = camera.eye_ecef * inverse;
    let enters = |pixel: usize| {
        let index = u32::try_from(pixel).expect("small");
        let direction = camera.pixel_direction_ecef(SIZE, index % SIZE.width, index / SIZE.width);
        let direction = (direction * inverse).normalize();
        let along = -eye.dot(direction);
        along > 0.0 && (eye + direction * along).length() < 1.0
    };
    let hits = hits(frame, camera);
    assert!(
        hits.iter().flatten().count() > 500,
        "hardly any ground is seen"
    );
    (0..hits.len())
        .filter(|&pixel| hits[pixel].is_none() && enters(pixel))
        .count()
}

#[test]
fn no_ray_passes_between_tiles_unless_the_skirts_are_left_out() {
    let mut found = 0;
    for error_px in [2.0, 12.0] {
        for (elevation, views) in [
            (
                ridges(),
                [
                    ([10.5, 46.5, 2500.0], 30.0, -8.0),
                    ([10.02, 46.02, 2000.0], 45.0, -4.0),
                ],
            ),
            (
                grown(),
                [
                    ([15.0, 20.0, 40e3], 60.0, -12.0),
                    ([15.0, 20.0, 8e6], 0.0, -90.0),
                ],
            ),
        ] {
            let mut tiles = Tiles {
                error_px,
                ..Tiles::new(&Ellipsoid::WGS84, elevation)
            };
            for (place, heading, pitch) in views {
                let camera = camera(place, heading, pitch);
                tiles.skirts = true;
                assert_eq!(cracks(&tiles, &camera), 0, "{error_px} {place:?}");
                tiles.skirts = false;
                found += cracks(&tiles, &camera);
            }
        }
    }
    assert!(found > 0, "the check finds no cracks where there are some");
}

/// The largest distance of what is seen from the full resolution, in pixels of the place where it is.
fn worst_px(tiles: &Tiles, camera: &Camera) -> f64 {
    let frame = tiles.frame(camera, SIZE).expect("above");
    let seen = hits(&frame, camera);
    let distances = seen.iter().enumerate().filter_map(|(pixel, t)| {
        let index = u32::try_from(pixel).expect("small");
        let direction = camera.pixel_direction_ecef(SIZE, index % SIZE.width, index / SIZE.width);
        let place = tiles
            .body
            .ecef_to_geodetic(camera.eye_ecef + direction * (*t)?);
        let [longitude, latitude] = [place.longitude_rad, place.latitude_rad].map(f64::to_degrees);
        let off_m = (place.height_m - tiles.elevation.height_m(longitude, latitude)).abs();
        Some(off_m / camera.pixel_size_m(SIZE, (*t)?))
    });
    distances.fold(0.0, f64::max)
}

#[test]
fn what_is_seen_is_within_the_stated_pixels_of_the_full_resolution() {
    let mut tiles = Tiles::new(&Ellipsoid::WGS84, ridges());
    let views = [
        camera([10.5, 46.5, 2100.0], 30.0, -10.0),
        camera([10.5, 46.5, 5000.0], 120.0, -30.0),
        camera([10.5, 46.5, 100e3], 0.0, -90.0),
        camera([10.5, 46.5, 8e6], 0.0, -90.0),
    ];
    let mut coarse = 0.0_f64;
    for camera in &views {
        tiles.error_px = DEFAULT_ERROR_PX;
        let worst = worst_px(&tiles, camera);
        // A skirt that closes a gap hangs between the two tiles' heights.
        assert!(worst <= DEFAULT_ERROR_PX, "{worst}");
        tiles.error_px = 40.0;
        coarse = coarse.max(worst_px(&tiles, camera));
    }
    assert!(
        coarse > DEFAULT_ERROR_PX,
        "{coarse}: the check sees no error where there is some"
    );
}

#[test]
fn triangles_are_limited_and_what_is_out_of_sight_is_left_out() {
    let camera = camera([10.5, 46.5, 2500.0], 30.0, -8.0);
    let mut tiles = Tiles {
        error_px: 0.2,
        ..Tiles::new(&Ellipsoid::WGS84, ridges())
    };
    let count = |tiles: &Tiles| tiles.frame(&camera, SIZE).expect("above").triangles.len();
    let all = count(&tiles);
    tiles.max_triangles = 40_000;
    let few = count(&tiles);
    assert!(all > 60_000 && few < 50_000, "{all} {few}");
    // A tile has 512, and the whole body's are 16,384 at the least.
    let choice = tiles.choice(&tiles.sight(&camera, SIZE), &mut |_| true);
    let chosen = choice.tiles;
    let seen = chosen.iter().filter(|tile| tile.error_px > 0.0).count();
    assert!(
        seen * 512 <= 40_000 && seen < chosen.len(),
        "{seen} of {}",
        chosen.len()
    );
    assert!(tiles.tree().node_count() > 500);
}

/// Largest side of a cell over its distance from the eye, of the tiles that a view may see, by their own vertices.
fn worst_cell_share(tiles: &Tiles, camera: &Camera) -> (f64, usize) {
    let choice = tiles.choice(&tiles.sight(camera, SIZE), &mut |_| true);
    let seen = choice.tiles.iter().filter(|tile| tile.error_px > 0.0);
    let shares = seen.map(|tile| {
        let side_m = tile.id.step_deg().to_radians() * tiles.body.equatorial_radius_m();
        let distances = (0..=16_u32).flat_map(|row| (0..=16_u32).map(move |column| [column, row]));
        let nearest = distances
            .map(|at| {
                let [longitude, latitude] = tile.id.place(at, 16);
                let place = Geodetic::from_degrees(longitude, latitude, 0.0);
                (tiles.body.geodetic_to_ecef(place) - camera.eye_ecef).length()
            })
            .fold(f64::INFINITY, f64::min);
        side_m / nearest
    });
    let shares: Vec<f64> = shares.collect();
    (shares.iter().copied().fold(0.0, f64::max), shares.len())
}

#[test]
fn by_size_no_cell_is_larger_than_its_share_of_the_distance() {
    let bare = Elevation::new(Vec::new(), Base::Flat, 0.0, 1.0);
    let mut tiles = Tiles::new(&Ellipsoid::WGS84, bare);
    let mut counts = Vec::new();
    for camera in [
        camera([10.5, 46.5, 2e3], 30.0, -2.0),
        camera([10.5, 46.5, 1e5], 120.0, -30.0),
        camera([10.5, 46.5, 8e6], 0.0, -90.0),
    ] {
        for share in [0.04, 0.02] {
            tiles.cell_per_distance = Some(share);
            let (worst, count) = worst_cell_share(&tiles, &camera);
            eprintln!("{share}: {count} tiles seen, cells up to {worst:.4} of their distance");
            // Nearest vertices stand for a tile's nearest place, which a ball around it is nearer than.
            assert!(worst <= share, "{worst}");
            counts.push(count);
        }
    }
    // Cells half as large are four times as many, but for whole tiles at the edges.
    let ratio = counts[1] as f64 / counts[0] as f64;
    assert!((2.0..5.0).contains(&ratio), "{counts:?}");
    // Negative control: by the error on the screen, cells of smooth ground are larger.
    tiles.cell_per_distance = None;
    let (worst, _) = worst_cell_share(&tiles, &camera([10.5, 46.5, 2e3], 30.0, -2.0));
    assert!(worst > 0.04, "{worst}");
}

#[test]
fn every_point_drawn_lies_within_the_heights_of_its_view_and_of_all_views() {
    let (mut elsewhere, mut points) = (0, 0);
    for (elevation, camera) in [
        (ridges(), camera([10.5, 46.5, 2500.0], 30.0, -8.0)),
        (grown(), camera([178.0, 70.0, 3e6], 0.0, -80.0)),
    ] {
        let tiles = Tiles::new(&Ellipsoid::WGS84, elevation);
        let frame = tiles.frame(&camera, SIZE).expect("above");
        for triangle in frame.triangles.iter() {
            let corners = triangle.map(|i| {
                camera.eye_ecef + DVec3::from(frame.vertices_rte[i as usize].map(f64::from))
            });
            for point in [
                corners[0],
                (corners[0] + corners[1]) * 0.5,
                (corners[0] + corners[1] + corners[2]) / 3.0,
            ] {
                let place = tiles.body.ecef_to_geodetic(point);
                let [longitude, latitude] =
                    [place.longitude_rad, place.latitude_rad].map(f64::to_degrees);
                // Rounded to f32, a pole has whatever longitude.
                if latitude.abs() > 89.99 {
                    continue;
                }
                let here = Extent {
                    west_deg: longitude,
                    east_deg: longitude,
                    south_deg: latitude,
                    north_deg: latitude,
                };
                // Vertices are rounded to f32 by their distance from the eye.
                let rounding = 1e-3 + 2e-7 * (point - camera.eye_ecef).length();
                let holds = |range: HeightRange| {
                    (range.lowest_m - rounding..=range.highest_m + rounding)
                        .contains(&place.height_m)
                };
                let stated = tiles.heights(&here);
                assert!(holds(stated), "{here:?}: {} {stated:?}", place.height_m);
                assert!(
                    holds(frame.heights_over(&here, stated)),
                    "{here:?}: {}",
                    place.height_m
                );
                // Negative control: the heights of a place beside do not hold it.
                let beside = Extent {
                    west_deg: longitude - 0.15,
                    east_deg: longitude - 0.15,
                    ..here
                };
                elsewhere += usize::from(!holds(frame.heights_over(&beside, stated)));
                points += 1;
            }
        }
    }
    assert!(elsewhere > 500, "{elsewhere} of {points}");
}

fn opened(surface: &str) -> Result<Arc<dyn Surface>, String> {
    let text = format!(
        "name = \"t\"\ndescription = \"d\"\nbody = \"wgs84\"\n\
         [regions]\nembedded = \"california.geojson\"\n[surface]\nkind = \"tiles\"\n{surface}\n\
         [[views]]\nname = \"a\"\nlongitude_deg = 0\nlatitude_deg = 0\nheight_m = 1\n\
         heading_deg = 0\npitch_deg = 0\n"
    );
    let scene = Scene::from_toml(&text, "t.toml", None).map_err(|error| error.to_string())?;
    open_surface(&[&EllipsoidKind, &TilesKind], &scene).map_err(|error| error.to_string())
}

#[test]
fn a_scene_names_its_tiles_and_what_is_wrong_is_named() {
    let flat = opened("base = \"flat\"\nskirts = false\nerror_px = 4").expect("tiles");
    assert_eq!(flat.kind(), "tiles");
    let file = "[[surface.files]]\npath = \"../a.tif\"\nsha256 = \"0\"";
    for (text, expected) in [
        (
            "error_px = 0",
            "t.toml: surface.error_px: found 0, allowed: 0.1 to 1000",
        ),
        (
            "rule = \"distance\"",
            "t.toml: surface.rule: found \"distance\", allowed: error, size",
        ),
        (
            "cell_per_distance = 0",
            "t.toml: surface.cell_per_distance: found 0, allowed: 0.001 to 10",
        ),
        (
            "skirts = 1",
            "t.toml: surface.skirts: found 1, allowed: true, false",
        ),
        (
            "base = \"sea\"",
            "t.toml: surface.base: found \"sea\", allowed: flat, relief",
        ),
        (
            "base = \"flat\"\nseed = 3",
            "t.toml: surface.seed: found 3, allowed: only the keys",
        ),
        (
            "max_triangles = 9",
            "t.toml: surface.max_triangles: found 9, allowed: 32768 to 8000000",
        ),
        (
            file,
            "t.toml: surface.files[0].sha256: found \"0\", allowed: 64 lower-case hexadecimal digits",
        ),
    ] {
        let error = opened(text).expect_err(text);
        assert!(error.starts_with(expected), "{error}");
    }
}

#[test]
fn an_eye_below_the_ground_is_refused_and_one_in_a_valley_is_not() {
    let tiles = Tiles::new(&Ellipsoid::WGS84, ridges());
    let ground = tiles.elevation.height_m(10.31, 46.47);
    let frame = |height_m: f64| tiles.frame(&camera([10.31, 46.47, height_m], 0.0, 0.0), SIZE);
    assert!(frame(ground + 2.0).is_ok());
    let error = frame(ground - 2.0)
        .map(|frame| frame.heights)
        .expect_err("below");
    assert!(error.to_string().contains("tiles"), "{error}");
}

/// Refines tiles by threes to the end. Returns the error of each frame on the way, and the last frame.
fn refined(tiles: &Tiles, camera: &Camera) -> (Vec<f64>, SurfaceFrame) {
    let mut errors = Vec::new();
    loop {
        let (frame, refinement) = tiles.frame_now(camera, SIZE).expect("above");
        errors.push(refinement.error_px);
        if refinement.waiting == 0 {
            return (errors, frame);
        }
        assert!(tiles.refine(3) > 0, "{refinement:?}");
    }
}

/// From the side, from afar and straight down.
fn flight() -> [Camera; 3] {
    [
        camera([10.5, 46.5, 2500.0], 30.0, -8.0),
        camera([10.5, 46.5, 8e6], 0.0, -90.0),
        camera([10.5, 46.5, 5000.0], 120.0, -30.0),
    ]
}

#[test]
fn tiles_refine_step_by_step_to_the_same_frame_by_every_route() {
    let whole = Tiles::new(&Ellipsoid::WGS84, ridges());
    let direct = Tiles::new(&Ellipsoid::WGS84, ridges());
    let about = Tiles::new(&Ellipsoid::WGS84, ridges());
    let [low, high, back] = flight();
    let (errors, settled) = refined(&direct, &low);
    assert!(errors.len() > 5 && errors.windows(2).all(|pair| pair[1] <= pair[0]));
    assert!(errors[0] > DEFAULT_ERROR_PX && errors[errors.len() - 1] <= DEFAULT_ERROR_PX);
    for camera in [&high, &back] {
        refined(&about, camera);
    }
    let (others, by_another_route) = refined(&about, &low);
    let wanted = whole.frame(&low, SIZE).expect("above");
    for frame in [&settled, &by_another_route] {
        assert_eq!(frame.vertices_rte, wanted.vertices_rte);
        assert_eq!(frame.triangles, wanted.triangles);
        assert_eq!(frame.parts, wanted.parts);
    }
    // Negative controls: frames on the way differ, and by the other route more was there at first.
    direct.forget();
    let (first, _) = direct.frame_now(&low, SIZE).expect("above");
    assert_ne!(first.vertices_rte, wanted.vertices_rte);
    assert!(others.len() < errors.len());
}

#[test]
fn no_ray_passes_between_tiles_while_they_refine() {
    let mut found = 0;
    for (place, heading, pitch) in [
        ([10.5, 46.5, 2500.0], 30.0, -8.0),
        ([10.02, 46.02, 2000.0], 45.0, -4.0),
    ] {
        let mut tiles = Tiles::new(&Ellipsoid::WGS84, ridges());
        let camera = camera(place, heading, pitch);
        for step in 0.. {
            let (frame, refinement) = tiles.frame_now(&camera, SIZE).expect("above");
            assert_eq!(cracks_of(&tiles, &camera, &frame), 0, "step {step}");
            tiles.skirts = false;
            let (bare, _) = tiles.frame_now(&camera, SIZE).expect("above");
            found += cracks_of(&tiles, &camera, &bare);
            tiles.skirts = true;
            if refinement.waiting == 0 {
                assert!(step > 3, "there is nothing to refine");
                break;
            }
            tiles.refine(15);
        }
    }
    assert!(found > 0, "the check finds no cracks where there are some");
}

#[test]
fn tiles_stay_within_their_memory_and_say_what_left() {
    let flown = |budget_bytes: u64| {
        let tiles = Tiles {
            store: Mutex::new(Store::new(budget_bytes)),
            ..Tiles::new(&Ellipsoid::WGS84, ridges())
        };
        let mut waited = false;
        for camera in flight().iter().chain(&flight()) {
            loop {
                let (_, refinement) = tiles.frame_now(camera, SIZE).expect("above");
                let memory = tiles.memory();
                assert!(memory.bytes <= memory.budget_bytes, "{memory:?}");
                if tiles.refine(20) == 0 {
                    waited |= refinement.waiting > 0;
                    break;
                }
            }
            // A frame that waits for all tiles takes no more than that either, and is the same as ever.
            let all = tiles.frame(camera, SIZE).expect("above");
            let whole = Tiles::new(&Ellipsoid::WGS84, ridges());
            let wanted = whole.frame(camera, SIZE).expect("above");
            assert_eq!(all.vertices_rte, wanted.vertices_rte);
            assert!(tiles.memory().bytes <= budget_bytes);
        }
        (tiles.memory(), waited)
    };
    let (roomy, waited) = flown(64 * MEGABYTE);
    assert!(roomy.evicted == 0 && roomy.made == roomy.pieces as u64 && !waited);
    let (tight, waited) = flown(roomy.bytes / 8);
    assert!(
        tight.evicted > 0 && tight.made > roomy.made && waited,
        "{tight:?}"
    );
}

#[test]
fn a_thread_makes_the_tiles_while_frames_are_drawn() {
    let tiles = Arc::new(Tiles::new(&Ellipsoid::WGS84, ridges()));
    let [low, ..] = flight();
    let waiting = || tiles.frame_now(&low, SIZE).expect("above").1.waiting;
    assert!(waiting() > 0);
    // Negative control: nothing comes of itself.
    assert!(waiting() > 0);
    let background = InBackground::start(Arc::<Tiles>::clone(&tiles));
    let started = Instant::now();
    while waiting() > 0 {
        assert!(
            started.elapsed() < Duration::from_secs(60),
            "it never settles"
        );
    }
    drop(background);
    let settled = tiles.frame_now(&low, SIZE).expect("above").0;
    let whole = Tiles::new(&Ellipsoid::WGS84, ridges());
    let wanted = whole.frame(&low, SIZE).expect("above");
    assert_eq!(settled.vertices_rte, wanted.vertices_rte);
}
