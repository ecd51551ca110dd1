// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fills over heights: grids and tiles of procedural relief, and real elevation, each beside the reference
//! over the same triangles.

use crate::drawing::by_main::{Open, prepared};
use crate::drawing::{collection, figures, named, polygon, shown, square};
use terrafill_conformance::verdict;
use terrafill_contract::{FillInput, PreparedScene, Technique};
use terrafill_fixtures::data;
use terrafill_grid::GridKind;
use terrafill_native::NativeTechnique;
use terrafill_plan::PlanOptions;
use terrafill_scene::{ImageSize, Scene, View};
use terrafill_surface::{EllipsoidKind, SurfaceKind};
use terrafill_tiles::TilesKind;
use terrafill_vertex::VertexTechnique;

const KINDS: [&dyn SurfaceKind; 3] = [&EllipsoidKind, &GridKind, &TilesKind];

const SIZE: ImageSize = square(256);

/// `[surface]` of scenes over terrain, as in `hills`.
const TERRAIN: &str = "kind = \"grid\"\nrows = 240\nseed = 2007\namplitude_m = 9_000\n";
/// The same terrain in tiles, coarse enough for skirts to be seen.
const TILES: &str =
    "kind = \"tiles\"\nerror_px = 8\nbase = \"relief\"\nseed = 2007\namplitude_m = 9_000\n";
const BARE: &str = "kind = \"ellipsoid\"\nrows = 240\n";

/// Name, longitude, latitude, height, heading and pitch. The terrain at (10°, 10°) is 1,090 m high.
const VIEWS: [(&str, [f64; 5]); 7] = [
    ("orbit", [10.0, 10.0, 3e6, 0.0, -90.0]),
    ("oblique", [10.0, 9.5, 9e3, 20.0, -20.0]),
    ("ridge", [10.0, 10.0, 1_120.0, 60.0, -3.0]),
    ("ridge-back", [10.0, 10.0, 1_120.0, 300.0, -3.0]),
    ("antimeridian", [178.0, 3.0, 3e6, 0.0, -90.0]),
    ("antimeridian-low", [-179.0, -10.5, 2e4, 350.0, -10.0]),
    ("pole", [20.0, 89.0, 4e6, 0.0, -90.0]),
];

/// Those in which tiles are looked at: they take their time in a build without optimisation.
const TILES_VIEWS: [&str; 3] = ["orbit", "ridge", "pole"];

/// Name, west, south, east and north, degrees: round a ridge, behind the horizon, across ±180°, over a pole.
const REGIONS: [(&str, [f64; 4]); 7] = [
    ("here", [9.9, 9.9, 10.05, 10.05]),
    ("beside", [10.05, 9.9, 10.3, 10.1]),
    ("across", [9.0, 10.2, 9.8, 11.0]),
    ("beyond", [11.0, 8.0, 16.0, 14.0]),
    ("hidden", [20.0, 5.0, 30.0, 15.0]),
    ("strip", [170.0, -10.0, 190.0, 10.0]),
    ("cap", [-180.0, 80.0, 180.0, 90.0]),
];

/// The regions over a surface.
fn over(surface: &str) -> (PreparedScene, Vec<View>) {
    let regions = REGIONS.map(|(name, [west, south, east, north])| {
        let ring = format!(
            "[[{west},{south}],[{east},{south}],[{east},{north}],[{west},{north}],[{west},{south}]]"
        );
        polygon(name, &ring)
    });
    let views = VIEWS.map(|(name, [longitude, latitude, height, heading, pitch])| {
        format!(
            "[[views]]\nname = \"{name}\"\nlongitude_deg = {longitude}\nlatitude_deg = {latitude}\n\
             height_m = {height}\nheading_deg = {heading}\npitch_deg = {pitch}\nnear_m = {}\n",
            height * 5e-4
        )
    });
    let text = format!(
        "name = \"terrain\"\ndescription = \"heights\"\nbody = \"wgs84\"\n\
         [regions]\ninline = '''{}'''\n[surface]\n{surface}{}",
        collection(&regions),
        views.concat()
    );
    let scene = Scene::from_toml(&text, "terrain.toml", None).expect("a scene");
    (prepared(&KINDS, &scene), scene.views)
}

#[test]
fn every_technique_fills_rightly_over_terrain_and_over_the_bare_body() {
    let Some(open) = Open::new(SIZE) else {
        return;
    };
    let (bare, views) = over(BARE);
    let [(terrain, _), (tiles, _)] = [TERRAIN, TILES].map(over);
    let mut over_the_other = 0;
    for view in &views {
        let what = |surface: &str| format!("{}/{surface}", view.name);
        let on_bare = open.assert_right(&what("bare"), &shown(&bare, view, SIZE));
        let is_tiled = TILES_VIEWS.contains(&&*view.name);
        let hilly = [("grid", &terrain, true), ("tiles", &tiles, is_tiled)];
        for (name, scene, _) in hilly.into_iter().filter(|(_, _, is_seen)| *is_seen) {
            let judged = open.assert_right(&what(name), &shown(scene, view, SIZE));
            // Negative control: over the bare body the same regions cover other pixels.
            over_the_other += usize::from(!verdict(&figures(&on_bare, &judged)).is_pass());
        }
    }
    // From straight above, terrain moves what it carries by less than a pixel.
    assert!(over_the_other >= 5, "{over_the_other}");
}

fn hills() -> (PreparedScene, Vec<View>) {
    let hills = Scene::open("hills", None).expect("it ships");
    (prepared(&KINDS, &hills), hills.views)
}

#[test]
fn every_technique_fills_the_shipped_hills_rightly() {
    let Some(open) = Open::new(SIZE) else {
        return;
    };
    let (hills, views) = hills();
    assert!(views.len() >= 3);
    for view in &views {
        let judged = open.assert_right(&view.name, &shown(&hills, view, SIZE));
        let (filled, all) = (judged.filled_px(), judged.ids.len() as u64);
        assert!(filled > 1000 && filled + 1000 < all, "{}", view.name);
    }
}

/// Scenes over real elevation, each with a view from nearby and one from afar in which regions have an edge.
const REAL: [(&str, [&str; 2]); 4] = [
    ("san-francisco", ["street", "hundred-kilometres"]),
    ("everest", ["valley", "orbit"]),
    ("grand-canyon", ["rim", "orbit"]),
    ("countries-over-etopo", ["globe", "himalaya"]),
];

#[test]
#[ignore = "needs data: elevation"]
fn every_technique_fills_rightly_over_real_elevation() {
    let Some(open) = Open::new(SIZE) else {
        return;
    };
    for (name, wanted) in REAL {
        let path = format!(
            "{}/../../../bench-scenes/terrain/{name}.toml",
            env!("CARGO_MANIFEST_DIR")
        );
        let scene = data::scene(&path);
        let prepared = prepared(&KINDS, &scene);
        for view in wanted {
            let input = shown(&prepared, named(&scene.views, view), SIZE);
            open.assert_right(&format!("{name}/{view}"), &input);
        }
    }
}

#[test]
fn culling_changes_no_pixel_over_terrain() {
    let Some(open) = Open::new(SIZE) else {
        return;
    };
    let everything = PlanOptions {
        frustum_culling: false,
        horizon_culling: false,
        too_small_culling: false,
        ..PlanOptions::default()
    };
    for (scene, views) in [hills(), over(TERRAIN)] {
        for view in &views {
            let [culled, whole] = [PlanOptions::default(), everything].map(|plan| {
                let input = FillInput::new(&scene, view, SIZE, plan).expect("a surface");
                open.draw(&VertexTechnique, &input)
            });
            assert_eq!(culled.ids, whole.ids, "{}", view.name);
            assert!(culled.filled_px() > 0, "{}", view.name);
        }
    }
}

/// Share of the pixels on the ground in both pictures whose brightness differs by more than a fiftieth.
fn share_apart(one: &[u8], other: &[u8]) -> f64 {
    let is_ground = |pixel: &[u8]| pixel[3] == 0 && pixel[2] > 60;
    let both = one.chunks(4).zip(other.chunks(4));
    let both: Vec<_> = both
        .filter(|(one, other)| is_ground(one) && is_ground(other))
        .collect();
    assert!(both.len() > 10_000, "{}", both.len());
    let apart = both
        .iter()
        .filter(|(one, other)| one[2].abs_diff(other[2]) > 5);
    apart.count() as f64 / both.len() as f64
}

#[test]
fn facets_of_the_bare_body_cast_no_relief_and_mountains_do() {
    let Some(open) = Open::new(SIZE) else {
        return;
    };
    let picture = |surface: &str, technique: &dyn Technique| {
        let (scene, views) = over(surface);
        let input = shown(&scene, named(&views, "orbit"), SIZE);
        open.drawn(technique, &input).rgba
    };
    for technique in [&VertexTechnique as &dyn Technique, &NativeTechnique] {
        let fine = picture(BARE, technique);
        // Facets of 4°: by their tilt against the ground within them, brightness would differ by a quarter.
        let coarse = picture("kind = \"ellipsoid\"\nrows = 45\n", technique);
        let share = share_apart(&coarse, &fine);
        assert!(share < 0.005, "{}: {share}", technique.name());
        // Negative control: terrain shows.
        let share = share_apart(&picture(TERRAIN, technique), &fine);
        assert!(share > 0.1, "{}: {share}", technique.name());
    }
}
