// SPDX-License-Identifier: MIT OR Apache-2.0
//! Covers cut to the tiles that a region's cap touches, and everything cut to where the image shows ground: the same
//! picture to the pixel, from fewer pixels.

use crate::{drawing, merged_draws};

use drawing::{
    AllTargets, Devices, counters, draw_with, look, named, polygon, scene, shipped, shown, square,
    with_switches,
};
use merged_draws::{SIZE, differing_when, seen, switches, techniques};
use terrafill_contract::{FillInput, PreparedScene};
use terrafill_core::Ellipsoid;
use terrafill_plan::{PixelRect, PlanOptions};
use terrafill_scene::{ImageSize, Overlap, View};
use terrafill_stencil::VolumeList;
use terrafill_variant::{CoverArea, Switches};

const LARGE: ImageSize = square(1024);

fn tiled() -> Switches {
    Switches {
        cover_area: CoverArea::Tiles,
        ..switches(true)
    }
}

fn without_sky(scene: &PreparedScene, view: &View) -> FillInput {
    let plan = PlanOptions {
        sky_culling: true,
        ..PlanOptions::default()
    };
    FillInput::new(scene, view, SIZE, plan).expect("a surface")
}

#[test]
fn shipped_scenes_look_the_same_from_fewer_pixels() {
    assert_tiles_show_the_same(&["california", "planet-134"]);
}

#[test]
#[ignore = "needs data: natural-earth-110m"]
fn countries_look_the_same_from_fewer_pixels() {
    assert_tiles_show_the_same(&["countries-110m"]);
}

fn assert_tiles_show_the_same(names: &[&str]) {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    for &name in names {
        let (scene, views) = shipped(name);
        let (mut whole, mut covered) = (0, 0);
        for view in &views {
            // A tile is a smaller part of a larger picture.
            let list = VolumeList::of(&shown(&scene, view, LARGE), &tiled());
            for volume in 0..list.volumes.len() {
                whole += list.rect(volume, true).area();
                covered += list
                    .cover_rects(volume, true)
                    .map(PixelRect::area)
                    .sum::<u64>();
            }
            let input = seen(&scene, view);
            let ground = without_sky(&scene, view);
            for technique in techniques() {
                let what = format!("{name}/{}: {technique:?}", view.name);
                let plain = with_switches(technique, switches(true));
                let plain = draw_with(&mut *targets.open(plain), &input);
                for input in [&input, &ground] {
                    let mut backend = targets.open(with_switches(technique, tiled()));
                    let tiles = draw_with(&mut *backend, input);
                    if let Some(needs) = backend.needs(input).expect("prepared") {
                        assert_eq!(needs.undeclared(), None, "{what}");
                    }
                    assert_eq!(drawing::differing(&plain, &tiles), 0, "{what}");
                }
            }
        }
        eprintln!("{name}: {covered} px of tiles instead of {whole} px of rectangles");
        // Countries are bent and made of islands; one region that fills its rectangle gains nothing.
        assert!(covered <= whole, "{name}");
        assert!(
            10 * covered < 9 * whole || name != "countries-110m",
            "{name}: {covered} of {whole}"
        );
    }
}

#[test]
fn a_tile_less_is_seen() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    // A diagonal band has few facets in a large rectangle, and leaves most of it free.
    let band = polygon(
        "band",
        "[[0,0],[0.4,0],[4,3.6],[4,4],[3.6,4],[0,0.4],[0,0]]",
    );
    let scene = scene(&band, Ellipsoid::WGS84, 180, Overlap::Disjoint);
    for pose in [(2.0, 2.0, 4e5, 0.0, -90.0), (2.0, 2.0, 4e5, 30.0, -80.0)] {
        let input = look(&scene, pose, 1e3, SIZE);
        assert_a_tile_less_is_seen(&targets, &input, &format!("{pose:?}"));
    }
}

#[test]
#[ignore = "needs data: us-10m, natural-earth-110m"]
fn a_tile_less_of_states_and_countries_is_seen() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    for name in ["us-states", "countries-110m"] {
        let (scene, views) = shipped(name);
        let mut views_with_tiles = 0;
        for view in &views {
            let input = seen(&scene, view);
            // So small a picture has few regions with many pixels a facet.
            if VolumeList::of(&input, &tiled()).cover_tiles.is_empty() {
                continue;
            }
            assert_a_tile_less_is_seen(&targets, &input, &format!("{name}/{}", view.name));
            views_with_tiles += 1;
        }
        assert!(views_with_tiles > 0, "{name}");
    }
}

fn assert_a_tile_less_is_seen(targets: &AllTargets<'_>, input: &FillInput, what: &str) {
    let tiles = VolumeList::of(input, &tiled()).cover_tiles;
    assert!(!tiles.is_empty(), "{what}: no cover of tiles");
    let none = differing_when(targets, input, tiled(), |_, _| ());
    assert_eq!(none, 0, "{what}");
    let fewer = differing_when(targets, input, tiled(), |_, list| {
        for tiles in list.cover_tiles.values_mut() {
            tiles.remove(tiles.len() / 2);
        }
    });
    assert!(fewer > 20, "{what}: {fewer}");
}

#[test]
fn sky_is_not_drawn_and_a_row_more_is_seen() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let (scene, views) = shipped("planet-134");
    let targets = AllTargets::new(&devices, SIZE);
    let view = named(&views, "horizon");
    let (all, ground) = (seen(&scene, view), without_sky(&scene, view));
    let image_px = PixelRect::full(SIZE).area();
    assert!(ground.plan.sky_px > image_px / 3, "{}", ground.plan.sky_px);
    assert!(
        ground
            .left_out_summary()
            .contains(&format!("{} px of sky", ground.plan.sky_px))
    );
    for technique in techniques() {
        let fragments = |input: &FillInput| {
            let mut backend = targets.open(with_switches(technique, switches(true)));
            counters(&draw_with(&mut *backend, input)).stencil_fragments
        };
        if let (Some(before), Some(after)) = (fragments(&all), fragments(&ground)) {
            assert!(3 * after < 2 * before, "{technique:?}: {after} of {before}");
        }
    }
    assert_eq!(differing_when(&targets, &ground, tiled(), |_, _| ()), 0);
    // Negative control: cut a few rows too low, far pixels are lost.
    let lost = differing_when(&targets, &ground, switches(true), |_, list| {
        list.area.top += 8;
    });
    assert!(lost > 20, "{lost}");
}
