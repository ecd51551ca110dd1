// SPDX-License-Identifier: MIT OR Apache-2.0
//! A picture in tiles on a device, and the judge without one.

use super::*;
use crate::views;
use terrafill_fixtures::on_device::{figure, on_device};
use terrafill_results::Status;
use terrafill_screen_grid::ScreenGridKind;
use terrafill_study::Group as _;
use terrafill_surface::SurfaceKind;

const KINDS: &[&dyn SurfaceKind] = &[&ScreenGridKind];

/// Smooth, and different everywhere.
fn made_up() -> Arc<MipChain> {
    let texels = (0..64_u32).flat_map(|row| {
        (0..128_u32).map(move |column| {
            let [red, green] = [2 * column, 4 * row].map(|at| u8::try_from(at).unwrap_or(u8::MAX));
            [red, green, red ^ green, 255]
        })
    });
    let picture = MipChain::new(128, 64, texels.flatten().collect());
    Arc::new(picture.expect("a picture"))
}

#[test]
fn colours_are_those_of_the_texels_and_a_changed_tile_shows() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let views = views::shipped().expect("a list");
        let opened = Rc::new(Opened::new(KINDS));
        let group = Pictured::planned(&views, (96, 1), true, made_up(), &opened);
        assert_eq!(group.cases.len(), QUICK_VIEWS.len());
        let mut session = group.open(context).expect("opens");
        for case in 0..group.cases.len() {
            let verdict = session.verify(case).expect("a verdict");
            assert_eq!(verdict.status, Status::Ok, "{}", verdict.reason);
            assert!(session.time(case).is_ok());
        }
    });
}

#[test]
fn one_area_is_drawn_in_three_levels() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let views = views::shipped().expect("a list");
        let opened = Rc::new(Opened::new(KINDS));
        let group = Pictured::planned(&views, (96, 1), false, made_up(), &opened);
        assert_eq!(group.cases.len(), VIEWS.len() + LEVELS.len());
        let mut session = group.open(context).expect("opens");
        let cases = group.work.works.iter().enumerate();
        let of_frame = cases.filter(|(_, (_, options))| options.one_level.is_some());
        let counts = of_frame.map(|(case, _)| {
            let verdict = session.verify(case).expect("a verdict");
            assert_eq!(verdict.status, Status::Ok, "{}", verdict.reason);
            figure(&verdict, "globe_tile_count")
        });
        // From the coarsest on; a level more has up to four times the tiles.
        let counts: Vec<f64> = counts.collect();
        assert_eq!(counts.len(), LEVELS.len());
        assert!(counts.is_sorted() && counts[0] < counts[2], "{counts:?}");
    });
}

#[test]
fn a_pixel_of_another_colour_is_found() {
    let picture = made_up();
    let tile = Tile::Map {
        level: 0,
        row: 0,
        column: 0,
    };
    let texels = cut(&picture, tile);
    let tiles = BTreeMap::from([(tile, texels)]);
    let texel = Texel {
        tile,
        x: 100,
        y: 90,
    };
    let right = colour_of(&tiles, texel).expect("a texel");
    let whole = levels(&picture)[0];
    let of = |colour: [u8; 4]| judge(&[None], (&[Shown::Texel(texel)], &[colour]), &tiles, &whole);
    assert_eq!((of(right).texels, of(right).wrong), (1, 0));
    // Negative controls: one byte more, and a texel of no tile.
    assert_eq!(of([right[0] + 1, right[1], right[2], right[3]]).wrong, 1);
    let nothing = Texel {
        tile: Tile::Cap { is_south: true },
        ..texel
    };
    assert_eq!(colour_of(&tiles, nothing), None);
}
