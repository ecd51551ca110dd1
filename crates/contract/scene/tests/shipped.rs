// SPDX-License-Identifier: MIT OR Apache-2.0
//! The scenes that ship: each loads, without data or with it, and each view shows what
//! its name promises.
//!
//! What a view shows is found here by arithmetic of its own, a ray and a count of crossings per
//! sampled pixel, so that no code under test judges itself.

use std::path::{Path, PathBuf};
use terrafill_core::{Ellipsoid, Region};
use terrafill_fixtures::data;
use terrafill_scene::{
    ImageSize, Scene, SceneError, View, scene_names_in_folders, scene_needs, shipped_scene_names,
    shipped_scene_needs,
};

/// Samples along each side of a view.
const SIZE: ImageSize = ImageSize::new(128, 128);

/// Scenes that need nothing, or those that need data.
fn scenes(needs_data: bool) -> Vec<&'static str> {
    let needs = |name: &&str| Scene::shipped(name, None).is_err() == needs_data;
    shipped_scene_names().into_iter().filter(needs).collect()
}

/// Longitude and latitude, degrees, that each sampled pixel of a view shows; `None` is sky.
fn seen_deg(scene: &Scene, view: &View) -> Vec<Option<[f64; 2]>> {
    let camera = view.camera(&scene.body);
    (0..SIZE.height)
        .flat_map(|row| (0..SIZE.width).map(move |column| (column, row)))
        .map(|(column, row)| {
            let direction = camera.pixel_direction_ecef(SIZE, column, row);
            first_hit_deg(&scene.body, camera.eye_ecef.into(), direction.into())
        })
        .collect()
}

/// Where a ray meets the ellipsoid first: the smaller root in the space where the body is a sphere.
fn first_hit_deg(body: &Ellipsoid, eye: [f64; 3], direction: [f64; 3]) -> Option<[f64; 2]> {
    let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
    let scaled = |v: [f64; 3]| [v[0] / a, v[1] / a, v[2] / b];
    let dot = |u: [f64; 3], v: [f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    let (p, d) = (scaled(eye), scaled(direction));
    let (dd, pd, pp) = (dot(d, d), dot(p, d), dot(p, p));
    let discriminant = pd * pd - dd * (pp - 1.0);
    if discriminant < 0.0 || pd > 0.0 {
        return None;
    }
    let t = (-pd - discriminant.sqrt()) / dd;
    let hit: [f64; 3] = std::array::from_fn(|i| eye[i] + t * direction[i]);
    let rho = hit[0].hypot(hit[1]);
    let latitude = (hit[2] * a * a).atan2(rho * b * b);
    Some([hit[1].atan2(hit[0]).to_degrees(), latitude.to_degrees()])
}

/// Answers which region holds a point: the one with an odd number of edges, straight in longitude
/// and latitude, crossed by the ray from the point to the east.
struct Map<'a> {
    regions: &'a [Region],
    /// West, south, east and north of each.
    bounds: Vec<[f64; 4]>,
}

impl<'a> Map<'a> {
    fn new(regions: &'a [Region]) -> Self {
        let bounds = regions
            .iter()
            .map(|region| {
                let ends = region.rings().flat_map(|ring| ring.edges_deg());
                let points = ends.flat_map(|(start, end)| [start, end]);
                points.fold(
                    [f64::MAX, f64::MAX, f64::MIN, f64::MIN],
                    |[w, s, e, n], [x, y]| [w.min(x), s.min(y), e.max(x), n.max(y)],
                )
            })
            .collect();
        Self { regions, bounds }
    }

    fn region_at(&self, point: [f64; 2]) -> Option<usize> {
        (0..self.regions.len()).find(|&i| {
            let [w, s, e, n] = self.bounds[i];
            [-360.0, 0.0, 360.0].iter().any(|turn| {
                let [x, y] = [point[0] + turn, point[1]];
                x >= w && x <= e && y >= s && y <= n && holds(&self.regions[i], [x, y])
            })
        })
    }
}

fn holds(region: &Region, [x, y]: [f64; 2]) -> bool {
    let crossings = region
        .rings()
        .flat_map(|ring| ring.edges_deg())
        .filter(|([x0, y0], [x1, y1])| {
            (*y0 > y) != (*y1 > y) && x < x0 + (y - y0) / (y1 - y0) * (x1 - x0)
        })
        .count();
    crossings % 2 == 1
}

/// What a view shows.
#[derive(Debug)]
struct Picture {
    /// Share of the image that is the body.
    body: f64,
    /// Share of the image that is the most seen region.
    largest: f64,
    /// Regions seen.
    regions: usize,
    /// Longitude and latitude of the samples that show a region, degrees.
    filled_deg: Vec<[f64; 2]>,
    /// Whether the body reaches the image's border.
    touches_image_edge: bool,
    /// How often filled and empty follow one another along the image's border.
    changes_along_image_edge: usize,
    /// Whether two neighbouring samples of the body differ in region.
    has_boundary: bool,
}

fn picture(scene: &Scene, view: &View) -> Picture {
    let map = Map::new(&scene.regions);
    let points = seen_deg(scene, view);
    let ids: Vec<Option<Option<usize>>> = points
        .iter()
        .map(|point| point.map(|point| map.region_at(point)))
        .collect();
    let filled = points
        .iter()
        .zip(&ids)
        .filter(|(_, id)| matches!(id, Some(Some(_))));
    let mut counts = vec![0_usize; scene.regions.len()];
    for id in ids.iter().flatten().flatten() {
        counts[*id] += 1;
    }
    let share = |count: usize| count as f64 / SIZE.pixel_count() as f64;
    let differ =
        |a: &Option<Option<usize>>, b: &Option<Option<usize>>| a.is_some() && b.is_some() && a != b;
    let columns = SIZE.width as usize;
    Picture {
        body: share(ids.iter().flatten().count()),
        largest: share(counts.iter().copied().max().unwrap_or(0)),
        regions: counts.iter().filter(|&&count| count > 0).count(),
        filled_deg: filled.filter_map(|(point, _)| *point).collect(),
        touches_image_edge: ids.iter().enumerate().any(|(i, id)| {
            let (column, row) = (i % columns, i / columns);
            let last = columns - 1;
            id.is_some() && (column == 0 || row == 0 || column == last || row == last)
        }),
        changes_along_image_edge: changes_along_image_edge(&ids),
        has_boundary: ids
            .chunks(columns)
            .any(|row| row.windows(2).any(|w| differ(&w[0], &w[1])))
            || ids.windows(columns + 1).any(|w| differ(&w[0], &w[columns])),
    }
}

/// Once round the image, along its first and last rows and columns; sky is empty.
fn changes_along_image_edge(ids: &[Option<Option<usize>>]) -> usize {
    let (columns, rows) = (SIZE.width as usize, SIZE.height as usize);
    let top = (0..columns).map(|column| (column, 0));
    let right = (0..rows).map(|row| (columns - 1, row));
    let bottom = (0..columns).rev().map(|column| (column, rows - 1));
    let left = (0..rows).rev().map(|row| (0, row));
    let round = top.chain(right).chain(bottom).chain(left);
    let is_filled: Vec<bool> = round
        .map(|(column, row)| ids[row * columns + column].flatten().is_some())
        .collect();
    let next = is_filled.iter().cycle().skip(1);
    is_filled.iter().zip(next).filter(|(a, b)| a != b).count()
}

/// Whether a view named after a place shows it, in a region.
fn looks_at_its_place(view: &View, seen: &Picture) -> bool {
    let is_at = |[longitude, latitude]: [f64; 2]| match view.name.as_str() {
        "equator" => latitude.abs() < 1.0,
        "latitude-45" => (latitude - 45.0).abs() < 1.0,
        // No country of the file reaches further north than 83.7°.
        "latitude-85" => latitude > 83.0,
        "pole" => latitude.abs() > 89.0,
        "antimeridian" => longitude.abs() > 179.5 && latitude > 60.0,
        "antimeridian-south" => longitude.abs() > 179.5 && latitude < 0.0,
        _ => false,
    };
    seen.filled_deg.iter().any(|&place| is_at(place))
}

/// What is wrong with a view, by its name; empty when it shows what it promises.
fn complaints(view: &View, seen: &Picture) -> Vec<&'static str> {
    let says_filled = view
        .note
        .as_deref()
        .is_some_and(|note| note.contains("filled"));
    let expectations = match view.name.as_str() {
        "globe" | "globe-pole" | "globe-dateline" => vec![
            (
                !seen.touches_image_edge,
                "the near side is not wholly in view",
            ),
            (seen.regions > 0, "no region is in view"),
        ],
        "top-down" | "fill" => vec![
            (seen.body == 1.0, "sky is in view"),
            (seen.largest > 0.9, "no region overfills the image"),
        ],
        "horizon" | "eye-level" => vec![
            (
                seen.body < 0.9 && seen.body > 0.1,
                "the horizon is not in view",
            ),
            (view.pose.eye.height_m <= 10_000.0, "the eye is high"),
        ],
        "down-50m" | "oblique-50m" | "down-500km" => vec![
            (seen.body == 1.0, "sky is in view"),
            (
                seen.changes_along_image_edge == 0,
                "the region is not wholly in view",
            ),
            (seen.largest > 0.01, "the region is a speck"),
        ],
        "edge-1m5" | "edge-50m" | "along-50m" => vec![
            (
                seen.changes_along_image_edge == 2,
                "not one edge alone crosses the image",
            ),
            (
                (0.1..0.9).contains(&(seen.largest / seen.body)),
                "one side of the edge is hardly in view",
            ),
            (view.pose.eye.height_m <= 50.0, "the eye is high"),
        ],
        "equator" | "latitude-45" | "latitude-85" | "antimeridian" | "antimeridian-south"
        | "pole" => vec![(
            looks_at_its_place(view, seen),
            "the place that it is named after is not in view",
        )],
        _ => vec![(false, "the view has a name that promises nothing")],
    };
    let boundary = (
        seen.has_boundary != says_filled,
        "the note and the boundary in sight contradict each other",
    );
    expectations
        .into_iter()
        .chain([boundary])
        .filter_map(|(holds, complaint)| (!holds).then_some(complaint))
        .collect()
}

/// Three cameras nearly everywhere; one for each place where textures are hard, and one more along an
/// edge.
fn view_count(scene: &str) -> usize {
    match scene {
        "blue-marble" => 6,
        "spiral" => 5,
        "square-200km" => 4,
        "window-west" | "window-east" => 1,
        _ => 3,
    }
}

#[test]
fn every_shipped_scene_loads_or_is_skipped_for_its_data() {
    let names = shipped_scene_names();
    assert_eq!(
        names,
        [
            "planet-134",
            "california",
            "square-10m",
            "square-200km",
            "hills",
            "screen-grid",
            "spiral",
            "countries-110m",
            "countries-50m",
            "countries-10m",
            "us-states",
            "blue-marble",
            "fade",
            "hatching",
            "shared-picture",
            "window-west",
            "window-east"
        ]
    );
    let without_data = names
        .iter()
        .filter(|name| Scene::shipped(name, None).is_ok())
        .count();
    assert_eq!(without_data, 12, "the embedded scenes need nothing");
    assert_they_load(&scenes(false));
}

#[test]
#[ignore = "needs data: all scenes"]
fn scenes_that_need_data_load_with_it() {
    let scenes = scenes(true);
    assert_eq!(scenes.len(), 5, "{scenes:?}");
    assert_they_load(&scenes);
}

fn assert_they_load(names: &[&str]) {
    for &name in names {
        let scene = data::scene(name);
        assert_eq!(scene.name, name);
        assert!(!scene.regions.is_empty() && scene.views.len() == view_count(name));
    }
}

#[test]
fn data_scenes_without_data_name_file_hash_and_source() {
    let error = Scene::shipped("us-states", None).expect_err("no data");
    let SceneError::DataMissing {
        scene,
        file,
        sha256,
        ..
    } = &error
    else {
        panic!("{error}");
    };
    assert_eq!(
        (scene.as_str(), file.as_str()),
        ("us-states", "vectors/us_states_10m.geojson")
    );
    let text = error.to_string();
    for part in [
        sha256.as_str(),
        "TERRAFILL_DATA is not set",
        "github.com/d3/d3-geo",
    ] {
        assert!(text.contains(part), "{text}");
    }
}

/// Every scene file under `folder`, by its path under `bench-scenes`.
fn scene_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("scenes") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            scene_files(&path, found);
        } else if path.extension().is_some_and(|end| end == "toml") {
            found.push(path);
        }
    }
}

#[test]
fn what_every_scene_of_the_repository_reads_is_known() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let mut files = Vec::new();
    scene_files(&root.join("bench-scenes"), &mut files);
    let known = shipped_scene_needs().expect("scenes");
    let mut needed = 0;
    for file in &files {
        let text = std::fs::read_to_string(file).expect("readable");
        let needs = scene_needs(&text, "a scene").expect("a scene");
        let path = file
            .strip_prefix(&root)
            .expect("under it")
            .display()
            .to_string();
        let name = path
            .trim_start_matches("bench-scenes/")
            .trim_end_matches(".toml");
        let known = known
            .iter()
            .find(|known| known.scene == name)
            .map(|known| known.files.clone());
        needed += needs.len();
        assert_eq!(
            known.unwrap_or_default(),
            needs,
            "{path}: a scene that reads data belongs into shipped.rs"
        );
    }
    assert!(files.len() >= 18 && needed >= 20, "{needed}");
}

#[test]
#[ignore = "needs data: natural-earth-110m, natural-earth-50m"]
fn the_published_files_hold_the_same_regions_as_the_trimmed_ones() {
    for name in ["countries-110m", "countries-50m"] {
        let trimmed = data::scene(name);
        let needs = shipped_scene_needs().expect("scenes");
        let need = needs.into_iter().find(|needs| needs.scene == name);
        let source = need.expect("it is shipped").files[0].source.clone();
        let source = source.expect("a published file").path;
        let folder = tempfile::tempdir().expect("temporary folder");
        std::fs::create_dir(folder.path().join("sources")).expect("writable");
        std::fs::copy(data::file(&source), folder.path().join(&source)).expect("writable");
        // Names too: they are all that is read of the properties.
        let published = Scene::shipped(name, Some(folder.path())).expect("the published file");
        assert!(published.regions == trimmed.regions, "{name}");
        // Negative controls: another name, and another ring.
        let mut renamed = published.regions.to_vec();
        renamed[0].name += "x";
        assert!(renamed[..] != trimmed.regions[..]);
        let mut without = published.regions.to_vec();
        without[0].polygons[0].shell = without[1].polygons[0].shell.clone();
        assert!(without[..] != trimmed.regions[..]);
    }
}

#[test]
fn other_bytes_under_the_right_name_are_not_the_scenes_data() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let vectors = folder.path().join("vectors");
    std::fs::create_dir(&vectors).expect("writable");
    let square = r#"{"type":"Polygon","coordinates":[[[0,0],[1,0],[1,1],[0,1],[0,0]]]}"#;
    std::fs::write(vectors.join("us_states_10m.geojson"), square).expect("writable");
    let error = Scene::shipped("us-states", Some(folder.path())).expect_err("other bytes");
    assert!(matches!(error, SceneError::DataMissing { .. }), "{error}");
    assert!(error.to_string().contains("has sha256"), "{error}");
}

#[test]
fn a_scene_that_is_not_shipped_is_named_with_those_that_are() {
    let error = Scene::shipped("planet-135", None).expect_err("unknown");
    assert_eq!(
        error.to_string(),
        "scene \"planet-135\" is not shipped, allowed: planet-134, california, square-10m, \
         square-200km, hills, screen-grid, spiral, countries-110m … and 54 more; \
         did you mean \"planet-134\"?"
    );
}

#[test]
fn scenes_in_folders_are_named_by_folder_and_file_and_a_path_is_still_one() {
    let names = scene_names_in_folders();
    assert_eq!(
        (names.len(), names[0]),
        (45, "terrain/countries-over-etopo")
    );
    let poles = Scene::open("extreme/poles", None).expect("ships");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let by_path = root.join("bench-scenes/extreme/poles.toml");
    let by_path = Scene::open(&by_path.display().to_string(), None).expect("a path");
    assert_eq!(poles.views, by_path.views);
    let everest = Scene::open("terrain/everest", None).expect_err("no data");
    assert!(
        matches!(everest, SceneError::DataMissing { .. }),
        "{everest}"
    );
    // Negative controls: a bare name is none of a folder's, and a path to nothing no scene.
    for (name, meant) in [
        ("poles", "extreme/poles"),
        ("terrain/everestx", "terrain/everest"),
    ] {
        let error = Scene::open(name, None).expect_err("unknown").to_string();
        let meant = format!("; did you mean {meant:?}?");
        assert!(
            error.contains("is not shipped") && error.ends_with(&meant),
            "{error}"
        );
    }
}

#[test]
fn every_view_shows_what_its_name_promises() {
    assert_views_show_what_they_promise(&scenes(false));
}

#[test]
#[ignore = "needs data: all scenes"]
fn every_view_of_data_shows_what_its_name_promises() {
    assert_views_show_what_they_promise(&scenes(true));
}

fn assert_views_show_what_they_promise(names: &[&str]) {
    for &name in names {
        let scene = data::scene(name);
        for view in &scene.views {
            let seen = picture(&scene, view);
            let wrong = complaints(view, &seen);
            assert!(
                wrong.is_empty(),
                "{name}/{}: {wrong:?}: {seen:?}",
                view.name
            );
        }
    }
}

fn breaks_a_promise(scene: &Scene) -> bool {
    let mut views = scene.views.iter();
    views.any(|view| !complaints(view, &picture(scene, view)).is_empty())
}

#[test]
fn views_that_break_their_promise_are_noticed() {
    // Negative control of the test above: each change below must draw a complaint.
    let text = include_str!("../../../../bench-scenes/california.toml");
    let broken = [
        // A globe from so near that it overfills the image.
        ("height_m = 8_000_000", "height_m = 3_000_000"),
        // Straight down on the sea, and straight down on nothing but land.
        ("longitude_deg = -120.6", "longitude_deg = -130"),
        ("height_m = 230_000", "height_m = 30_000"),
        // A horizon seen over open sea, and one that is out of the image.
        ("longitude_deg = -122.55", "longitude_deg = -140"),
        ("pitch_deg = -2", "pitch_deg = -60"),
    ];
    for (from, to) in broken {
        let changed = text.replacen(from, to, 1);
        assert_ne!(text, changed, "{from} is not in the scene");
        let scene = Scene::from_toml(&changed, "california.toml", None).expect("a valid scene");
        assert!(breaks_a_promise(&scene), "{to} went unnoticed");
    }
}

#[test]
fn views_of_squares_that_break_their_promise_are_noticed() {
    for change in [
        // From so near that sides leave the image, and from so far that little is left.
        "square-10m: height_m = 50\nheading_deg = 0 -> height_m = 5\nheading_deg = 0",
        "square-10m: height_m = 50\nheading_deg = 0 -> height_m = 500\nheading_deg = 0",
        // A corner in view, no edge in view, and the horizon where none is promised.
        "square-10m: height_m = 1.5 -> height_m = 4",
        "square-200km: height_m = 1.5\nheading_deg = 340 -> height_m = 1.5\nheading_deg = 160",
        "square-200km: height_m = 500000\nheading_deg = 0\npitch_deg = -90 -> \
         height_m = 500000\nheading_deg = 0\npitch_deg = -10",
        "square-200km: heading_deg = 70 -> heading_deg = 250\nfov_deg = 1",
    ] {
        let (name, change) = change.split_once(": ").expect("a name");
        let (from, to) = change.split_once(" -> ").expect("a change");
        let text = match name {
            "square-10m" => include_str!("../../../../bench-scenes/square-10m.toml"),
            _ => include_str!("../../../../bench-scenes/square-200km.toml"),
        };
        let changed = text.replacen(from, to, 1);
        assert_ne!(text, changed, "{from} is not in the scene");
        let scene = Scene::from_toml(&changed, name, None).expect("a valid scene");
        assert!(breaks_a_promise(&scene), "{name}: {to} went unnoticed");
    }
}

#[test]
#[ignore = "needs data: natural-earth-110m"]
fn views_of_places_where_textures_are_hard_must_show_them() {
    // The picture takes seconds to read and no part in where a view looks.
    let text = include_str!("../../../../bench-scenes/blue-marble.toml");
    let (head, rest) = text.split_once("[texture]").expect("a texture");
    let (_, views) = rest.split_once("[[views]]").expect("views");
    let text = format!("{head}[[views]]{views}");
    for (from, to) in [
        // A hemisphere off, and over open sea.
        ("latitude_deg = -2\n", "latitude_deg = -30\n"),
        ("latitude_deg = 45.9", "latitude_deg = 75"),
        ("latitude_deg = 85", "latitude_deg = 60"),
        ("longitude_deg = 179\n", "longitude_deg = 100\n"),
        ("latitude_deg = -17.2", "latitude_deg = -35"),
        ("latitude_deg = -90\n", "latitude_deg = -40\n"),
    ] {
        let changed = text.replacen(from, to, 1);
        assert_ne!(text, changed, "{from} is not in the scene");
        let scene = Scene::from_toml(&changed, "blue-marble.toml", Some(&data::folder()));
        let scene = scene.expect("a valid scene");
        assert!(breaks_a_promise(&scene), "{to} went unnoticed");
    }
}

#[test]
#[ignore = "needs data: blue-marble"]
fn blue_marble_has_its_picture_with_all_levels() {
    let scene = data::scene("blue-marble");
    let texture = scene.texture.expect("a texture");
    assert_eq!(texture.image.size_px(), [4096, 2048]);
    assert_eq!(texture.image.levels().len(), 13);
    // Antarctica is white, the southern Pacific dark blue.
    let level = &texture.image.levels()[4];
    // Degrees east of the antimeridian and south of the north pole.
    let texel = |east: u32, south: u32| {
        let (column, row) = (level.width * east / 360, level.height * south / 180);
        let index = 4 * (row * level.width + column) as usize;
        level.rgba[index..index + 3].to_vec()
    };
    assert!(texel(270, 170).iter().all(|&channel| channel > 200));
    let sea = texel(50, 130);
    assert!(sea[0] < 40 && sea[2] > sea[0], "{sea:?}");
}

#[test]
#[ignore = "needs data: natural-earth-110m, natural-earth-50m, natural-earth-10m"]
fn the_countries_are_seen_by_the_cameras_of_the_published_figures() {
    for name in ["countries-110m", "countries-50m", "countries-10m"] {
        let scene = data::scene(name);
        let cameras: Vec<[f64; 6]> = scene
            .views
            .iter()
            .map(|view| {
                let (pose, eye) = (view.pose, view.pose.eye);
                let degrees = [
                    eye.longitude_rad,
                    eye.latitude_rad,
                    pose.heading_rad,
                    pose.pitch_rad,
                    pose.fov_y_rad,
                ]
                .map(|radians| (radians.to_degrees() * 1e6).round() / 1e6);
                let [longitude, latitude, heading, pitch, fov] = degrees;
                [longitude, latitude, eye.height_m, heading, pitch, fov]
            })
            .collect();
        assert_eq!(
            cameras,
            [
                [15.0, 20.0, 8_000_000.0, 0.0, -90.0, 60.0],
                [108.16, 32.47, 1_161_169.0, 0.0, -90.0, 60.0],
                [105.05, 41.42, 2_000.0, 343.6, -2.0, 60.0],
            ]
        );
    }
}

#[test]
fn california_has_about_its_true_area() {
    let scene = Scene::shipped("california", None).expect("embedded");
    assert_eq!(scene.regions[0].vertex_count(), 109);
    // Land 403,660 km² and inland water 7,340 km² (US Census Bureau, 2010); the bay is cut out here
    // and the coast is coarse, hence the tolerance.
    let area = area_km2(&scene.body, &scene.regions[0]);
    assert!((area / 411_000.0 - 1.0).abs() < 0.03, "{area} km²");
    // Negative control: on the Moon the same outline must not pass.
    let wrong = area_km2(&Ellipsoid::MOON, &scene.regions[0]);
    assert!((wrong / 411_000.0 - 1.0).abs() > 0.03, "{wrong} km²");
}

/// Area between planar edges and the equator, summed: the midpoint rule over longitude on the
/// body's exact zone area.
fn area_km2(body: &Ellipsoid, region: &Region) -> f64 {
    const STEPS: u32 = 64;
    let mut area_m2 = 0.0;
    for ([x0, y0], [x1, y1]) in region.rings().flat_map(|ring| ring.edges_deg()) {
        for i in 0..STEPS {
            let along = (f64::from(i) + 0.5) / f64::from(STEPS);
            let latitude = (y0 + (y1 - y0) * along).to_radians();
            let width = (x1 - x0).to_radians() / f64::from(STEPS);
            area_m2 += width * body.zone_area_per_radian(latitude);
        }
    }
    area_m2.abs() / 1e6
}
