// SPDX-License-Identifier: MIT OR Apache-2.0
//! Squares of places against each place by itself, without a device.

use super::*;
use crate::path::Path;
use crate::residency::Residency;
use crate::texture::{Source, byte};

/// What the judge finds of a square, against each of its places by itself.
#[test]
fn squares_that_are_left_out_have_no_place_that_fits() {
    let texture = Texture {
        source: Source::Addresses,
        finest: 3,
    };
    let mut held = Residency::new(&texture, 64);
    // Not all pages have a slot.
    let pages = (0..85).filter(|number| number % 5 > 0).map(Page::numbered);
    held.request(&pages.collect::<Vec<_>>(), 0, usize::MAX);
    held.set_leaves((5..21).map(Page::numbered));
    let globe = Globe::new();
    // The last one sees the limb, where triangles are narrow.
    let eyes = [Path::Smooth.eye(0, 64), Eye::over(15.0, 85.0, 2e7, 64)];
    let (mut near, mut away) = (0, 0);
    for (eye, by_derivative) in eyes.iter().flat_map(|eye| [(eye, false), (eye, true)]) {
        let reference = Reference::new(*eye, &globe, &texture, held.table(), by_derivative);
        let middles = (0..64 * 64).step_by(7);
        let middles = middles.map(|at| [at % 64, at / 64].map(|at| f64::from(at) + 0.5));
        for px in middles {
            let Some(facet) = reference.facet(px) else {
                continue;
            };
            for band in [0.4, 0.9, 1.5, 4.0] {
                let beside = [px[0] + band * BAND_PX, px[1] - 0.7 * band * BAND_PX];
                let found = reference.lookups(facet, &[beside]).expect("one place");
                let Some((page, places)) = found[0].shown else {
                    continue;
                };
                let [column, row] = places[0].map(|at| *first_texels([at; 2]).start());
                let side = Texture::side(page.level);
                let [x, y] = [(page.x, column), (page.y, row)]
                    .map(|(page, at)| i64::from(page * PAGE) + at - 1);
                let texels = [0, 1]
                    .map(|off| address(page.level, wrapped(x + off, side), clamped(y + off, side)));
                let said = Said {
                    texels,
                    wanted: Some(found[0].wanted),
                    footprint: found[0].footprint,
                };
                let stored = texture.page(page);
                let shown = [0, 1, 2, 3]
                    .map(|of| filtered(&stored, of, places[0].map(|at| at + 0.5))[0])
                    .map(byte);
                let says = |lookup: Option<&Lookup>| says(lookup, &said);
                let shows = |lookup: Option<&Lookup>| {
                    let shows = lookup.and_then(|lookup| lookup.shown);
                    shows.is_some_and(|(own, places)| {
                        own == page && is_between(&stored, places, shown)
                    })
                };
                let mut compare = |fits: &dyn Fn(Option<&Lookup>) -> bool| {
                    let of_place = |x, y| reference.is_near(facet, px, [x, y], 0, &fits);
                    let places = -FINE..=FINE;
                    let any = places
                        .clone()
                        .any(|y| places.clone().any(|x| of_place(x, y)));
                    let found = reference.is_near(facet, px, [-FINE; 2], 2 * FINE, &fits);
                    assert_eq!(found, any, "{px:?} {band} {said:?}");
                    *(if any { &mut near } else { &mut away }) += 1;
                };
                compare(&says);
                compare(&shows);
            }
        }
    }
    assert!(near > 1_000 && away > 200, "{near} {away}");
}
