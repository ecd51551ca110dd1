// SPDX-License-Identifier: MIT OR Apache-2.0
//! Covers cut to the tiles that a region's cap touches: the same picture to the pixel, from fewer pixels.

use crate::{drawing, merged_draws};

use drawing::{AllTargets, Devices, draw_with, shipped, with_switches};
use merged_draws::{SIZE, differing_when, seen, switches, techniques};
use terrafill_fill::{CoverArea, FillInput, Switches, VolumeList};
use terrafill_scene::{ImageSize, PixelRect, PlanOptions};

const LARGE: ImageSize = ImageSize {
    width: 1024,
    height: 1024,
};

fn tiled() -> Switches {
    Switches {
        cover_area: CoverArea::Tiles,
        ..switches(true)
    }
}

#[test]
fn shipped_scenes_look_the_same_from_fewer_pixels() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    for name in ["california", "planet-134", "countries-110m"] {
        let Some((scene, views)) = shipped(name) else {
            continue;
        };
        let (mut whole, mut covered) = (0, 0);
        for view in &views {
            // A tile is a smaller part of a larger picture.
            let large = FillInput::new(&scene, view, LARGE, PlanOptions::default());
            let list = VolumeList::of(&large.expect("a surface"), &tiled());
            for volume in 0..list.volumes.len() {
                whole += list.rect(volume, true).area();
                covered += list
                    .cover_rects(volume, true)
                    .map(PixelRect::area)
                    .sum::<u64>();
            }
            let input = seen(&scene, view);
            for technique in techniques() {
                let what = format!("{name}/{}: {technique:?}", view.name);
                let [plain, tiles] = [switches(true), tiled()].map(|switches| {
                    let mut backend = targets.open(with_switches(technique, switches));
                    let frame = draw_with(&mut *backend, &input);
                    if let Some(needs) = backend.needs(&input).expect("prepared") {
                        assert_eq!(needs.undeclared(), None, "{what}");
                    }
                    frame
                });
                assert_eq!(drawing::differing(&plain, &tiles), 0, "{what}");
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
    let Some((scene, views)) = shipped("planet-134") else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    let input = seen(&scene, &views[0]);
    assert_eq!(differing_when(&targets, &input, tiled(), |_, _| ()), 0);
    let fewer = differing_when(&targets, &input, tiled(), |_, list| {
        for tiles in list.cover_tiles.values_mut() {
            tiles.remove(tiles.len() / 2);
        }
    });
    assert!(fewer > 20, "{fewer}");
}
