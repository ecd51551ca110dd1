// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions over one another: as many as lie over one pixel are right or refused, and translucent
//! ones are blended in the order of the plan.

use crate::drawing;

use drawing::{
    AllTargets, Devices, Technique, collection, draw_with, figures, is_right, judge, look, polygon,
    scene, square, with_colour,
};
use terrafill_conformance::{filled_only, verdict};
use terrafill_contract::{
    DeviceError, FillInput, NO_REGION, Picture, PreparedScene, region_colour,
};
use terrafill_core::Ellipsoid;
use terrafill_scene::{ImageSize, Overlap};
use terrafill_variant::ColourWay;
use terrafill_vertex::VertexVariant;

const SIZE: ImageSize = square(192);

/// Squares around one point, each a little smaller than the one before: as many lie over the middle.
fn nested(count: u32, overlap: Overlap) -> PreparedScene {
    let squares: Vec<String> = (0..count)
        .map(|index| {
            let half = 5.0 - 4.0 * f64::from(index) / f64::from(count);
            let (w, e) = (10.0 - half, 10.0 + half);
            let ring = format!("[[{w},{w}],[{e},{w}],[{e},{e}],[{w},{e}],[{w},{w}]]");
            polygon(&format!("square {index}"), &ring)
        })
        .collect();
    scene(&collection(&squares), Ellipsoid::WGS84, 90, overlap)
}

fn from_above(scene: &PreparedScene) -> FillInput {
    look(scene, (10.0, 10.0, 1.4e6, 0.0, -90.0), 1e3, SIZE)
}

fn translucent(colour: ColourWay, opacity_percent: u8) -> Technique {
    Technique::Vertex(VertexVariant {
        opacity_percent,
        switches: with_colour(colour),
        ..VertexVariant::default()
    })
}

#[test]
fn nested_regions_are_right_or_refused() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    let (mut right, mut refused) = (0, Vec::new());
    for count in [1, 15, 16, 17, 255, 256, 257, 512] {
        let input = from_above(&nested(count, Overlap::Ordered));
        let reference = judge(&input);
        let middle = reference.ids[SIZE.pixel_count() / 2 + SIZE.width as usize / 2];
        assert_eq!(middle, count, "the smallest lies on top");
        for colour in ColourWay::ALL {
            let mut backend = targets.open(translucent(colour, 100));
            match backend.prepare(&input) {
                Ok(_) => {}
                Err(DeviceError::Switch(error)) => {
                    assert!(
                        error
                            .to_string()
                            .contains(&with_colour(colour).setting("colour")),
                        "{error}"
                    );
                    refused.push((colour, count));
                    continue;
                }
                Err(DeviceError::OverCapacity { found, allowed, .. }) => {
                    assert_eq!((found, allowed), (u64::from(count), 255));
                    refused.push((colour, count));
                    continue;
                }
                Err(error) => panic!("{colour:?} {count}: {error}"),
            }
            let frame = draw_with(&mut *backend, &input);
            let found = if colour.tells_regions_apart() {
                figures(&reference, &frame)
            } else {
                figures(&filled_only(&reference), &filled_only(&frame))
            };
            // Hundreds of borders, most closer to one another than a pixel: where one lies is known
            // to a pixel only, but which region is on top must be right outside that band.
            let is_right = if count > 17 && colour.tells_regions_apart() {
                found.mismatched_px_outside_band == 0
                    && found.area_error.is_some_and(|e| e.abs() < 1e-2)
            } else {
                verdict(&found).is_pass()
            };
            assert!(is_right, "{colour:?} {count}: {found:?}");
            right += 1;
        }
    }
    let never = [ColourWay::Xor, ColourWay::IdAccumulation];
    let counted = [ColourWay::OneColour, ColourWay::OneColourVolumes];
    for (colour, count) in &refused {
        let by_count = counted.contains(colour) && *count > 255;
        assert!(never.contains(colour) || by_count, "{colour:?} {count}");
    }
    assert_eq!((right, refused.len()), (8 * 7 - 22, 22));
}

/// Negative control: counted together without the check, 256 volumes over one pixel are none.
#[test]
fn a_count_that_wraps_loses_the_multiples_of_256() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    for (count, is_lost) in [(255, false), (256, true), (257, false), (512, true)] {
        // Said to be disjoint, so that nothing is checked.
        let input = from_above(&nested(count, Overlap::Disjoint));
        let mut backend = targets.open(translucent(ColourWay::OneColour, 100));
        let frame = draw_with(&mut *backend, &input);
        let middle = frame.ids[SIZE.pixel_count() / 2 + SIZE.width as usize / 2];
        assert_eq!(middle == NO_REGION, is_lost, "{count}");
    }
}

/// What the regions look like one over the other, from coverages that the reference finds for each
/// region alone; rounded to 8 bits after each, as the target does.
fn composite(input: &FillInput, surface: &Picture, opacity: f64, order: &[usize]) -> Vec<[u8; 3]> {
    let mut pixels: Vec<[u8; 3]> = surface
        .rgba
        .chunks_exact(4)
        .map(|p| [p[0], p[1], p[2]])
        .collect();
    for &region in order {
        let alone = PreparedScene {
            regions: vec![input.scene.regions[region].clone()].into(),
            ..input.scene.clone()
        };
        let alone = FillInput {
            scene: alone,
            ..input.clone()
        };
        let covered = judge(&alone);
        let colour = region_colour(region);
        for (pixel, &id) in pixels.iter_mut().zip(&covered.ids) {
            if id != NO_REGION {
                *pixel = std::array::from_fn(|channel| {
                    let over = f64::from(colour[channel]) * opacity;
                    let blended = over + f64::from(pixel[channel]) * (1.0 - opacity);
                    to_byte(blended)
                });
            }
        }
    }
    pixels
}

#[allow(clippy::cast_possible_truncation, reason = "a mean of bytes is a byte")]
fn to_byte(value: f64) -> u8 {
    value.round() as u8
}

/// Pixels that differ by more than `allowed` in some channel.
fn wrong(expected: &[[u8; 3]], picture: &Picture, allowed: u8) -> usize {
    let pixels = expected.iter().zip(picture.rgba.chunks_exact(4));
    pixels
        .filter(|(expected, found)| (0..3).any(|c| expected[c].abs_diff(found[c]) > allowed))
        .count()
}

#[test]
fn translucent_regions_blend_in_the_order_of_the_plan() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let text = collection(&[
        polygon("first", "[[6,6],[11,6],[11,11],[6,11],[6,6]]"),
        polygon("second", "[[9,9],[14,9],[14,14],[9,14],[9,9]]"),
        polygon("third", "[[8,8],[10.5,8],[10.5,13],[8,13],[8,8]]"),
    ]);
    let scene = scene(&text, Ellipsoid::WGS84, 90, Overlap::Ordered);
    let input = from_above(&scene);
    let all = AllTargets::new(&devices, SIZE);
    let targets = all.wgpu();
    targets.borrow_mut().prepare(&input).expect("fits");
    targets.borrow_mut().draw_surface().expect("draws");
    let surface = targets.borrow().read().expect("reads");
    let percent = 40;
    let opacity = f64::from(percent) / 100.0;
    let in_order = composite(&input, &surface, opacity, &[0, 1, 2]);
    let reversed = composite(&input, &surface, opacity, &[2, 1, 0]);
    for colour in [
        ColourWay::Rectangle,
        ColourWay::Volume,
        ColourWay::BitPlanes,
    ] {
        let mut backend = all.open(translucent(colour, percent));
        backend.prepare(&input).expect("fits");
        let picture = backend.picture(&input).expect("draws");
        // Borders may lie a pixel off: as many pixels as three squares have around them.
        let (right, control) = (wrong(&in_order, &picture, 2), wrong(&reversed, &picture, 2));
        assert!(right < 20, "{colour:?}: {right} wrong");
        assert!(
            control > 1_000,
            "{colour:?}: the other order differs in {control} only"
        );
        // The frame to be verified is opaque and in the same order.
        let judged = judge(&input);
        let frame = backend.render(&input).expect("draws");
        assert!(is_right(&judged, &frame), "{colour:?}");
    }
}

#[test]
fn ways_without_an_order_refuse_translucent_regions() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    let input = from_above(&nested(1, Overlap::Disjoint));
    for colour in ColourWay::ALL {
        let has_order = matches!(
            colour,
            ColourWay::Rectangle | ColourWay::Volume | ColourWay::BitPlanes
        );
        for (percent, is_drawn) in [(100, true), (99, has_order)] {
            let mut backend = targets.open(translucent(colour, percent));
            backend.prepare(&input).expect("fits");
            let picture = backend.picture(&input);
            assert_eq!(picture.is_ok(), is_drawn, "{colour:?} {percent}");
            if let Err(error) = picture {
                assert!(error.to_string().contains("opacity"), "{error}");
            }
        }
    }
}
