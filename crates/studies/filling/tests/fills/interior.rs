// SPDX-License-Identifier: MIT OR Apache-2.0
//! Views in which all ground is one region's are covered without a volume: the same picture to the pixel.

use crate::{drawing, merged_draws};

use drawing::{AllTargets, Devices, counters, differing, draw_with, shipped, with_switches};
use merged_draws::{SIZE, differing_when, switches, techniques};
use terrafill_contract::{FillInput, PreparedScene};
use terrafill_core::Geodetic;
use terrafill_plan::{DrawnAs, LeftOutReason, PlanOptions};
use terrafill_scene::{CameraPose, View};
use terrafill_stencil::{FillProgram, Volume};

fn view(place_deg: [f64; 2], height_m: f64, pitch_deg: f64) -> View {
    View {
        name: format!("{place_deg:?} from {height_m} m at {pitch_deg}"),
        pose: CameraPose {
            eye: Geodetic::from_degrees(place_deg[0], place_deg[1], height_m),
            heading_rad: 0.4,
            pitch_rad: pitch_deg.to_radians(),
            fov_y_rad: 0.7,
            near_m: 1e-3 * height_m,
        },
        note: None,
    }
}

fn seen(scene: &PreparedScene, view: &View, interior: bool) -> FillInput {
    let plan = PlanOptions {
        interior,
        ..PlanOptions::default()
    };
    FillInput::new(scene, view, SIZE, plan).expect("a surface")
}

/// Whether one region has all ground in view.
fn has_owner(input: &FillInput) -> bool {
    let mut planned = input.plan.regions.iter();
    planned.any(|planned| planned.drawn_as == DrawnAs::Ground)
}

/// Over facets of islands, from so high that some coasts are in view and some are not.
fn views(scene: &PreparedScene) -> Vec<View> {
    let mut views = Vec::new();
    for (number, mesh) in scene.meshes.iter().take(40).enumerate() {
        let facet = mesh.triangles[7 * number % mesh.triangles.len()];
        let corner = |vertex: u32| mesh.vertices_deg[vertex as usize];
        let [a, b, c] = facet.map(corner);
        let middle = [0, 1].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0);
        let height_m = 10_f64.powf(2.5 + (number % 7) as f64 * 0.5);
        let pitch_deg = [-90.0, -70.0, -45.0][number % 3];
        views.push(view(middle, height_m, pitch_deg));
        // Half a picture beside its coast.
        views.push(view(mesh.vertices_deg[0], height_m, -90.0));
    }
    views
}

#[test]
fn views_without_a_coast_are_covered_without_a_volume() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let (scene, _) = shipped("planet-134");
    let targets = AllTargets::new(&devices, SIZE);
    let all = techniques();
    let (mut owned, mut shared, mut empty) = (0, 0, 0);
    for (number, view) in views(&scene).iter().enumerate() {
        let [volumes, interior] = [false, true].map(|interior| seen(&scene, view, interior));
        let technique = all[number % all.len()];
        let technique = with_switches(technique, switches(true));
        let drawn = draw_with(&mut *targets.open(technique), &volumes);
        let mut backend = targets.open(technique);
        let covered = draw_with(&mut *backend, &interior);
        let what = format!("{}: {technique:?}", view.name);
        assert_eq!(differing(&drawn, &covered), 0, "{what}");
        if let Some(needs) = backend.needs(&interior).expect("prepared") {
            assert_eq!(needs.undeclared(), None, "{what}");
        }
        if has_owner(&interior) {
            assert_eq!(interior.plan.regions.len(), 1, "{what}");
            assert_eq!(
                counters(&covered).stencil_fragments.unwrap_or(0),
                0,
                "{what}"
            );
            let summary = interior.left_out_summary();
            assert!(
                summary.contains("which has all ground in view"),
                "{summary}"
            );
            owned += 1;
        } else if interior.plan.regions.len() < volumes.plan.regions.len() {
            empty += 1;
        } else {
            shared += 1;
        }
        // Nothing else is said to be left out for another reason.
        let reasons = |input: &FillInput| {
            let left_out = input.plan.left_out.iter();
            left_out
                .filter(|of| of.reason != LeftOutReason::OutsideFrustum)
                .count()
        };
        assert_eq!(reasons(&volumes), reasons(&interior), "{what}");
    }
    eprintln!("{owned} views of one island, {empty} of none, {shared} with a coast");
    assert!(owned > 10 && shared > 20, "{owned} {empty} {shared}");
}

#[test]
fn a_coast_that_is_overlooked_is_seen() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let (scene, _) = shipped("planet-134");
    let targets = AllTargets::new(&devices, SIZE);
    let coast = view(scene.meshes[0].vertices_deg[0], 20_000.0, -90.0);
    let input = seen(&scene, &coast, true);
    assert!(!has_owner(&input));
    // Negative control: taken for ground that is all its own, the island floods its bay.
    let flooded = differing_when(&targets, &input, switches(true), |program, list| {
        let ground = |volume: &Volume| Volume {
            drawn_as: DrawnAs::Ground,
            ..*volume
        };
        list.volumes = list.volumes.iter().map(ground).collect();
        let made = FillProgram::new(&list.volumes, &switches(true), input.scene.overlap);
        *program = made.expect("allowed");
    });
    assert!(flooded > 1_000, "{flooded}");
}
