// SPDX-License-Identifier: MIT OR Apache-2.0
//! The far level held against the reference: flat meshes of regions whose volumes are lower than half a
//! pixel show what volumes show, but for pixels along boundaries, and cost less; of higher volumes they do
//! not.
//!
//! Without a Vulkan device these tests are skipped with the reason printed, unless
//! `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does.

use crate::drawing;

use drawing::{
    AllTargets, Devices, Technique, compute, counters, judge, layouts, look, native, scene,
    shipped, sights, square, vertex,
};
use terrafill_conformance::{
    BAND_RADIUS_PX, boundary_movement, compare_closely, verdict_of_moved, with_movement,
};
use terrafill_contract::{FillInput, Frame};
use terrafill_core::Ellipsoid;
use terrafill_native::Extrusion;
use terrafill_plan::{DrawnAs, PlanOptions};
use terrafill_reference::{CloseLook, ReferenceBackend};
use terrafill_scene::{ImageSize, Overlap};
use terrafill_stencil::LOD_PX;
use terrafill_variant::{ColourWay, Switches};

const SIZE: ImageSize = square(512);

fn options(far_level_px: Option<f64>) -> PlanOptions {
    PlanOptions {
        far_level_px,
        ..PlanOptions::default()
    }
}

/// Whether `frame` may pass for the reference's picture with boundaries up to `pixels` aside; and how many
/// of its pixels are wrong, in all and outside the band.
fn held(truth: &FillInput, reference: &Frame, frame: &Frame, pixels: f64) -> (bool, [u64; 2]) {
    let scene = ReferenceBackend::new().scene(truth).expect("judges");
    let look = CloseLook::new(truth, &scene);
    let shows = |pixel: usize, id: u32| look.ids_within(pixel, BAND_RADIUS_PX).contains(&id);
    let found = compare_closely(reference, frame, |_, _| false, shows).expect("same size");
    let movement = boundary_movement(reference, frame, |place| look.id_at(place));
    let found = with_movement(found, movement.expect("same size"));
    let wrong = [found.mismatched_px, found.mismatched_px_outside_band];
    (verdict_of_moved(&found, pixels).is_pass(), wrong)
}

fn flat(input: &FillInput) -> usize {
    let planned = input.plan.regions.iter();
    planned
        .filter(|planned| planned.drawn_as == DrawnAs::FlatMesh)
        .count()
}

#[test]
fn half_a_pixel_of_relief_may_be_left_out_and_saves_the_stencil() {
    assert_relief_may_be_left_out(&["planet-134"]);
}

#[test]
#[ignore = "needs data: natural-earth-110m"]
fn half_a_pixel_of_relief_of_the_countries_may_be_left_out() {
    assert_relief_may_be_left_out(&["countries-110m"]);
}

fn assert_relief_may_be_left_out(names: &[&str]) {
    let Some(devices) = Devices::open() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    let plain = vertex(Switches::default());
    for &name in names {
        let (prepared, views) = shipped(name);
        for view in &views {
            let full = FillInput::new(&prepared, view, SIZE, options(None)).expect("a surface");
            let input = full.remeshed(&prepared, options(Some(LOD_PX)));
            let reference = judge(&full);
            let frame = targets.draw(&input, plain);
            let (is_held, [wrong, outside]) = held(&full, &reference, &frame, LOD_PX);
            let volumes = counters(&targets.draw(&full, plain));
            let drawn = counters(&frame);
            let (flat, all) = (flat(&input), input.plan.regions.len());
            eprintln!(
                "{name}/{}: {flat} of {all} regions flat, {wrong} pixels wrong, {outside} outside the band; \
                 vertices {} → {}, stencil fragments {:?} → {:?}, draws {} → {}",
                view.name,
                volumes.vertices,
                drawn.vertices,
                volumes.stencil_fragments,
                drawn.stencil_fragments,
                volumes.draws,
                drawn.draws,
            );
            assert!(is_held && outside == 0, "{name}/{}", view.name);
            assert_eq!(flat > 0, drawn.vertices < volumes.vertices);
            assert_eq!(view.name == "globe", 2 * flat > all, "{name}/{}", view.name);
        }
    }
}

/// Every technique, and every way to colour of one of them.
fn techniques() -> Vec<Technique> {
    let plain = Switches::default();
    let colours = ColourWay::ALL.into_iter();
    let colours = colours.filter(|colour| colour.tells_regions_apart());
    let colours = colours.map(|colour| vertex(drawing::with_colour(colour)));
    let native = Extrusion::ALL.map(|technique| native(technique, plain));
    let others = colours.chain([compute(plain)]).chain(native);
    layouts(plain).into_iter().chain(others).collect()
}

#[test]
fn every_technique_draws_flat_meshes_and_none_is_right_where_volumes_are_high() {
    let techniques = techniques();
    let Some(devices) = Devices::open_for(&techniques) else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    let prepared = scene(
        &sights::three_regions(),
        Ellipsoid::WGS84,
        180,
        Overlap::Disjoint,
    );
    for (height_m, pixels, is_exact) in [(1.2e7, LOD_PX, true), (2e5, 1e3, false)] {
        let full = look(
            &prepared,
            (9.0, 5.0, height_m, 0.0, -90.0),
            height_m * 1e-3,
            SIZE,
        );
        let input = full.remeshed(&prepared, options(Some(pixels)));
        assert!(flat(&input) > 0, "{height_m}");
        let reference = judge(&full);
        for technique in &techniques {
            let frame = targets.draw(&input, *technique);
            let (is_held, wrong) = held(&full, &reference, &frame, LOD_PX);
            assert_eq!(
                is_held, is_exact,
                "{technique:?} from {height_m}: {wrong:?}"
            );
        }
    }
}
