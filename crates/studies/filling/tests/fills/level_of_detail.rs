// SPDX-License-Identifier: MIT OR Apache-2.0
//! Boundary levels of detail held against the reference, which draws every boundary as written: how
//! many pixels a stated deviation really costs, where, and that borders stay closed.
//!
//! Without a Vulkan device these tests are skipped with the reason printed, unless
//! `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does.

use crate::drawing;

use drawing::{Devices, differing, draw, judge, square, stored, vertex};
use terrafill_conformance::{
    BAND_RADIUS_PX, ErrorFigures, MOVED_STEP_PX, boundary_movement, compare_closely,
    verdict_of_moved, with_movement,
};
use terrafill_contract::{FillInput, Frame, NO_REGION, PreparedScene};
use terrafill_core::RegionMesh;
use terrafill_fixtures::data;
use terrafill_native::{Extrusion as Native, Indices};
use terrafill_plan::{LeveledMeshes, PlanOptions, RegionBounds};
use terrafill_reference::{CloseLook, ReferenceBackend};
use terrafill_scene::{ImageSize, LevelChoice, Scene, View};
use terrafill_surface::{EllipsoidKind, open_surface};
use terrafill_variant::Switches;

const SIZE: ImageSize = square(512);

/// A shipped scene with these levels.
fn leveled(name: &str, levels: LevelChoice) -> (Scene, PreparedScene) {
    let mut scene = data::scene(name);
    scene.levels = levels;
    let meshes = LeveledMeshes::build(&scene, &scene.mesh).expect("meshes");
    assert_eq!(meshes.ended_by, None, "{name}");
    assert!(
        meshes.meshes.len() > scene.regions.len(),
        "{name}: one level"
    );
    let surface = open_surface(&[&EllipsoidKind], &scene).expect("a surface");
    let prepared = PreparedScene::leveled(&scene, meshes, surface);
    (scene, prepared)
}

#[test]
fn a_view_makes_the_meshes_that_it_draws_and_their_bounds() {
    let (scene, prepared) = leveled("planet-134", LevelChoice::Automatic);
    let regions = scene.regions.len();
    let made = || -> Vec<usize> {
        let meshes = (regions..prepared.meshes.len()).map(|mesh| (mesh, &prepared.meshes[mesh]));
        let made = meshes.filter(|(_, mesh)| mesh.is_made());
        made.map(|(mesh, _)| mesh).collect()
    };
    assert!(made().is_empty());
    let view = &scene.views[0];
    let input = FillInput::new(&prepared, view, SIZE, options(Some(0.5))).expect("a surface");
    let mut drawn: Vec<usize> = input.plan.regions.iter().map(|of| of.mesh).collect();
    drawn.retain(|mesh| *mesh >= regions);
    drawn.sort_unstable();
    assert!(drawn.len() > 20, "{drawn:?}");
    // Some may turn out to be too small at the level at which they would be drawn.
    assert!(drawn.iter().all(|mesh| made().contains(mesh)));
    assert!(made().len() < drawn.len() + 10, "{}", made().len());
    for mesh in [0, drawn[0]] {
        let mesh_itself: &RegionMesh = &prepared.meshes[mesh];
        let heights = prepared.surface.heights(&mesh_itself.extent);
        let bounds = RegionBounds::new(&scene.body, mesh_itself, heights);
        assert_eq!(prepared.bounds[mesh], bounds);
        // Negative control: those of another mesh are others.
        assert_ne!(prepared.bounds[mesh + 1], bounds);
    }
    // A set of some of them neither makes nor copies any.
    let before = made();
    let some = prepared.meshes.with_geometry_of(|mesh| mesh == 3);
    assert!(std::ptr::eq(&*some[3], &*prepared.meshes[3]));
    assert!(some.iter().filter(|mesh| mesh.vertex_count() > 0).count() == 1);
    assert_eq!(made(), before);
    // Negative control: drawn as they are written, regions need no other mesh.
    FillInput::new(&prepared, view, SIZE, options(None)).expect("a surface");
    assert_eq!(made(), before);
}

fn options(pixels: Option<f64>) -> PlanOptions {
    PlanOptions {
        boundary_lod_px: pixels,
        ..PlanOptions::default()
    }
}

fn draw_plain(devices: &Devices, input: &FillInput) -> Frame {
    draw(devices, input, vertex(Switches::default()))
}

/// What the comparison says, the reference being asked between the centres of its pixels too.
fn figures(truth: &FillInput, reference: &Frame, frame: &Frame) -> ErrorFigures {
    let scene = ReferenceBackend::new().scene(truth).expect("judges");
    let look = CloseLook::new(truth, &scene);
    let shows = |pixel: usize, id: u32| look.ids_within(pixel, BAND_RADIUS_PX).contains(&id);
    let figures = compare_closely(reference, frame, |_, _| false, shows).expect("same size");
    let shown_at = |place| look.id_at(place);
    let movement = boundary_movement(reference, frame, shown_at).expect("same size");
    with_movement(figures, movement)
}

fn boundary_vertices(input: &FillInput) -> usize {
    let planned = input.plan.regions.iter();
    planned
        .map(|planned| input.scene.meshes[planned.mesh].boundary_edge_count())
        .sum()
}

/// Pixels of `frame` that nobody owns although they lie on a border: by `truth`, which is `factor`
/// times the size, everything around them belongs to some region, and to more than one.
fn unowned_on_borders(truth: &Frame, factor: usize, frame: &Frame) -> usize {
    let (width, height) = (frame.size.width as usize, frame.size.height as usize);
    let on_border = |index: usize| {
        let (column, row) = (index % width, index / width);
        let mut ids = Vec::new();
        for y in row.saturating_sub(1) * factor..(row + 2).min(height) * factor {
            for x in column.saturating_sub(1) * factor..(column + 2).min(width) * factor {
                ids.push(truth.ids[y * width * factor + x]);
            }
        }
        !ids.contains(&NO_REGION) && ids.iter().any(|id| *id != ids[0])
    };
    (0..frame.ids.len())
        .filter(|&index| frame.ids[index] == NO_REGION && on_border(index))
        .count()
}

/// How much finer borders are looked at where a pixel has no owner. An inlet much narrower than a
/// pixel shows there; moved by half a pixel it may well come to lie on a pixel's centre, and its
/// water has no owner.
const FINE: usize = 4;

/// The reference's picture at [`FINE`] times the size.
fn fine_reference(scene: &PreparedScene, view: &View) -> Frame {
    let size = square(4 * SIZE.width);
    let input = FillInput::new(scene, view, size, options(None)).expect("a surface");
    judge(&input)
}

/// Of one view: asserts what must hold up to half a pixel, and prints what it costs.
fn check_view(devices: &Devices, scene: &PreparedScene, view: &View) -> (usize, usize) {
    let full_input = FillInput::new(scene, view, SIZE, options(None)).expect("a surface");
    let reference = judge(&full_input);
    let full = draw_plain(devices, &full_input);
    let mut at_half = 0;
    for pixels in [0.25, 0.5] {
        let input = full_input.remeshed(scene, options(Some(pixels)));
        let frame = draw_plain(devices, &input);
        let figures = figures(&full_input, &reference, &frame);
        at_half = boundary_vertices(&input);
        eprintln!(
            "{}/{} at {pixels} px: {at_half} of {} boundary vertices, {} pixels wrong, {} outside \
             the band, moved {:?} px; {}",
            scene.name,
            view.name,
            boundary_vertices(&full_input),
            figures.mismatched_px,
            figures.mismatched_px_outside_band,
            figures.boundary_moved_px,
            input.plan.left_out_summary(&scene.meshes),
        );
        assert_eq!(figures.mismatched_px_outside_band, 0, "{}", view.name);
        let verdict = verdict_of_moved(&figures, pixels);
        assert!(verdict.is_pass(), "{}: {figures:?}", view.name);
        if unowned_on_borders(&full, 1, &frame) > 0 {
            let fine = fine_reference(scene, view);
            assert_eq!(unowned_on_borders(&fine, FINE, &frame), 0, "{}", view.name);
        }
    }
    (at_half, boundary_vertices(&full_input))
}

#[test]
fn half_a_pixel_is_seen_in_the_band_alone_and_borders_stay_closed() {
    assert_levels_hold("planet-134", LevelChoice::Automatic);
}

#[test]
#[ignore = "needs data: natural-earth-110m, us-10m"]
fn half_a_pixel_is_seen_in_the_band_alone_and_borders_stay_closed_of_countries_and_states() {
    let given = |deviation_m: &[f64]| LevelChoice::Given(deviation_m.into());
    assert_levels_hold(
        "countries-110m",
        given(&[1_000.0, 4_000.0, 7_000.0, 16_000.0]),
    );
    assert_levels_hold("us-states", given(&[400.0, 1_600.0, 6_400.0, 25_600.0]));
}

fn assert_levels_hold(name: &str, levels: LevelChoice) {
    let Some(devices) = Devices::open() else {
        return;
    };
    let (scene, prepared) = leveled(name, levels);
    let mut fewest_share = 1.0_f64;
    for view in &scene.views {
        let (at_half, of) = check_view(&devices, &prepared, view);
        fewest_share = fewest_share.min(at_half as f64 / of as f64);
    }
    // Negative control: were no level ever chosen, everything above would hold.
    assert!(fewest_share < 0.95, "{name}: {fewest_share}");
}

#[test]
fn boundaries_moved_too_far_are_noticed() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let (scene, prepared) = leveled("planet-134", LevelChoice::Given(vec![6e4]));
    let view = &scene.views[0];
    let input = FillInput::new(&prepared, view, SIZE, options(Some(32.0))).expect("a surface");
    let reference = judge(&input);
    let figures = figures(&input, &reference, &draw_plain(&devices, &input));
    assert!(figures.mismatched_px_outside_band > 0, "{figures:?}");
    assert!(figures.mismatched_px > 1_000, "{figures:?}");
    assert!(!verdict_of_moved(&figures, 0.5).is_pass());
}

/// The figure is the movement itself, not merely no more than it: what is stated four times too small
/// is noticed in every view in which a level is drawn that uses half of what it may.
#[test]
fn a_movement_understated_four_times_is_noticed() {
    assert_understatement_is_noticed("planet-134", LevelChoice::Automatic, 0.5);
}

#[test]
#[ignore = "needs data: natural-earth-110m, natural-earth-50m"]
fn a_movement_of_countries_understated_four_times_is_noticed() {
    // Of their own choice the countries take levels that move by less than a fifth of a pixel where
    // half of one is allowed.
    let levels = LevelChoice::Given(vec![4_000.0, 7_000.0]);
    assert_understatement_is_noticed("countries-110m", levels, 0.5);
    assert_understatement_is_noticed("countries-50m", LevelChoice::Automatic, 0.8);
}

fn assert_understatement_is_noticed(name: &str, levels: LevelChoice, drawn_px: f64) {
    let Some(devices) = Devices::open() else {
        return;
    };
    let (scene, prepared) = leveled(name, levels);
    let view = &scene.views[0];
    let full = FillInput::new(&prepared, view, SIZE, options(None)).expect("a surface");
    let reference = judge(&full);
    let input = full.remeshed(&prepared, options(Some(drawn_px)));
    let found = figures(&full, &reference, &draw_plain(&devices, &input));
    let moved_px = found.boundary_moved_px.expect("few pixels mismatch");
    eprintln!(
        "{name}/{}: moved {moved_px} px of {drawn_px}: {found:?}",
        view.name
    );
    assert!(
        verdict_of_moved(&found, drawn_px).is_pass(),
        "{name}: {found:?}"
    );
    assert_eq!(found.mismatched_px_outside_band, 0, "{name}");
    // Islands too small to be seen are among what is judged here.
    let islands = input.plan.small_rings;
    eprintln!("{name}: {islands:?}");
    assert_eq!(islands.rings > 0, name == "countries-50m", "{islands:?}");
    assert!(
        !verdict_of_moved(&found, drawn_px / 4.0).is_pass(),
        "{name}: {found:?}"
    );
    // Negative control: without levels nothing has moved by more than a rasteriser's step.
    let found = figures(&full, &reference, &draw_plain(&devices, &full));
    let moved_px = found.boundary_moved_px.expect("few pixels mismatch");
    assert!(moved_px <= 2.0 * MOVED_STEP_PX, "{name}: {found:?}");
}

#[test]
#[ignore = "needs data: us-10m"]
fn neighbours_at_different_levels_part_and_the_count_of_unowned_pixels_shows_it() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let levels = LevelChoice::Given(vec![12_800.0]);
    let (scene, prepared) = leveled("us-states", levels);
    let view = &scene.views[0];
    let full_input = FillInput::new(&prepared, view, SIZE, options(None)).expect("a surface");
    let full = draw_plain(&devices, &full_input);
    let fine = fine_reference(&prepared, view);
    assert_eq!(unowned_on_borders(&fine, FINE, &full), 0);
    let coarsest = prepared.levels.coarser.last().expect("has levels");
    let mut parted = full_input.clone();
    for planned in parted.plan.regions.iter_mut().step_by(2) {
        planned.mesh = coarsest.meshes[planned.region];
    }
    let apart = unowned_on_borders(&fine, FINE, &draw_plain(&devices, &parted));
    // All of them as coarse as that: only inlets, moved by several pixels, have no owner.
    let mut together = full_input.clone();
    for planned in &mut together.plan.regions {
        planned.mesh = coarsest.meshes[planned.region];
    }
    let frame = draw_plain(&devices, &together);
    assert!(differing(&frame, &full) > 0);
    let unowned = unowned_on_borders(&fine, FINE, &frame);
    eprintln!("us-states: {apart} pixels without an owner parted, {unowned} together");
    assert!(apart > 50 && unowned * 3 < apart, "{apart}, {unowned}");
}

/// Levels are ranges of the same buffers, and strips end in each of them.
#[test]
fn every_level_in_lists_and_strips_shows_what_doubled_vertices_show() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let (scene, prepared) = leveled("planet-134", LevelChoice::Automatic);
    let mut coarser = 0;
    for view in &scene.views {
        let full = FillInput::new(&prepared, view, SIZE, options(None)).expect("a surface");
        let input = full.remeshed(&prepared, options(Some(0.5)));
        let levels = input.plan.regions.iter();
        coarser += levels
            .filter(|planned| planned.mesh != planned.region)
            .count();
        let expected = draw_plain(&devices, &input);
        for technique in [Native::GsDegenerate, Native::GsAdjacency] {
            for indices in Indices::ALL {
                let stored = stored(technique, indices, Switches::default());
                let frame = draw(&devices, &input, stored);
                let what = format!("{}, {}/{}", view.name, technique.name(), indices.name());
                assert_eq!(differing(&frame, &expected), 0, "{what}");
            }
        }
    }
    assert!(coarser > 40, "hardly a coarser level: {coarser}");
}
