// SPDX-License-Identifier: MIT OR Apache-2.0
//! The study on a device, without one, and with wrong parameters.

use super::*;
use crate::api::RAYS;
use crate::error::Errors;
use crate::list::SurfaceRow;
use crate::sight::{RAY_CAST, Work, drawn_otherwise, standing};
use std::path::Path;
use terrafill_contract::{Devices, device_for_test};
use terrafill_results::{
    Block, Chapter, ConditionKey, Metric, Outcome, Run, RunEnvironment, RunFolder, SCHEMA, Status,
};
use terrafill_study::{CaseGroup, Context, Failure, RunOptions, Silent, plan, run};
use terrafill_surface::EllipsoidKind;

const STUDIED: GlobesStudy = GlobesStudy {
    surfaces: &[&EllipsoidKind],
};

/// One view, small.
fn sight(works: &[Work], side_px: u32) -> CaseGroup<SurfacesView> {
    let view = &List::shipped().expect("a list").view[0];
    let opened = Rc::new(Opened::new(STUDIED.surfaces));
    SurfacesView::planned(view, works, &opened, (side_px, 1))
}

fn ellipsoids() -> Vec<Work> {
    let list = List::shipped().expect("a list");
    let rows: Vec<SurfaceRow> = list.surface.into_iter().take(1).collect();
    works(&rows, Depth::Quick)
}

/// That study, but for a smaller picture of one view.
struct Small;

impl Study for Small {
    fn name(&self) -> &'static str {
        STUDY
    }

    fn metrics(&self) -> &'static [Metric] {
        &METRICS
    }

    fn conditions(&self) -> Vec<ConditionKey> {
        STUDIED.conditions()
    }

    fn plan(&self, _request: &Request) -> Result<Planned, StudyError> {
        Ok(Planned {
            groups: vec![Box::new(sight(&ellipsoids(), 100))],
            ..Planned::default()
        })
    }

    fn chapter(&self) -> &dyn Chapter {
        &GlobesChapter
    }
}

fn measure(folder: &Path, devices: Devices) -> Run {
    let options = RunOptions {
        processes: 1,
        process: 0,
        warm_up: 0,
        seed: 1,
        shard: None,
    };
    let plan = plan(&[&Small], &Request::default(), &options).expect("planned");
    let environment = RunEnvironment {
        schema: SCHEMA,
        ..RunEnvironment::default()
    };
    let planned = plan.run_plan().clone();
    let run_folder = RunFolder::create(folder, environment, planned, &METRICS);
    let run_folder = run_folder.expect("a folder");
    run(&plan, &run_folder, &Rc::new(devices), &options, &mut Silent).expect("measured");
    Run::load(folder).expect("a run")
}

#[test]
fn pixels_drawn_otherwise_count_but_beside_the_outline() {
    let rays: Vec<bool> = (0..64).map(|pixel| pixel % 8 > 3).collect();
    assert_eq!(drawn_otherwise(8, &rays, &rays), 0);
    let changed = |pixel: usize| {
        let mut device = rays.clone();
        device[pixel] = !device[pixel];
        drawn_otherwise(8, &rays, &device)
    };
    // A column on either side of the outline may differ, farther ones not.
    for (pixel, count) in [(27, 0), (28, 0), (26, 1), (29, 1), (0, 1), (63, 1)] {
        assert_eq!(changed(pixel), count, "{pixel}");
    }
}

#[test]
fn kinds_that_there_are_not_are_left_out_by_name() {
    let study = GlobesStudy {
        surfaces: &[&EllipsoidKind],
    };
    let request = Request {
        depth: Depth::Quick,
        ..Request::default()
    };
    let planned = study.plan(&request).expect("a plan");
    let cases = planned.groups.iter().flat_map(|group| group.cases());
    let names: Vec<&str> = cases.map(|case| case.id.condition("surface")).collect();
    assert!(names.contains(&"ellipsoid") && names.contains(&"ray-cast"));
    assert!(!names.contains(&"tiles"), "{names:?}");
    let left_out = |what: &str| planned.skipped.iter().any(|skipped| skipped.what == what);
    assert!(left_out("globes/tiles") && !left_out("globes/ellipsoid"));
}

#[test]
fn a_run_has_errors_times_and_a_chapter() {
    for interface in [terrafill_gpu::SURFACES, RAYS] {
        let size = terrafill_scene::ImageSize::new(1, 1);
        if device_for_test((interface.open)(&Devices::default(), size)).is_none() {
            return;
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let run = measure(&folder.path().join("run"), Devices::default());
    // Three cases, and two of them again.
    assert_eq!(run.cases.len(), 5);
    let value = |surface: &str, rows: &str, metric: &str| {
        let mut cases = run.cases.iter().filter(|case| !case.is_repeat());
        let case = cases
            .find(|case| case.condition("surface") == surface && case.condition("value") == rows);
        case.and_then(|case| case.value(metric))
    };
    for case in &run.cases {
        assert_eq!(case.outcome, Outcome::Ok, "{}: {}", case.id(), case.reason);
        let [cpu, parts @ ..] = [
            "globe_whole_cpu_ms",
            "globe_make_cpu_ms",
            "globe_upload_cpu_ms",
            "globe_draw_cpu_ms",
        ]
        .map(|metric| case.value(metric).expect("measured"));
        // Differences of the same readings add up to the last but the rounding of their sum.
        assert!(parts.iter().sum::<f64>() <= cpu + 1e-9, "{}", case.id());
    }
    // The body itself is met where it is: rays and depths of 24 bits move it by some 1e-5 of a pixel,
    // and the more the closer to the limb.
    let of_rays = |metric| value(RAY_CAST, "", metric).expect("measured");
    assert!(of_rays("globe_px_p99") < 1e-4 && of_rays("globe_px_max") < 1e-3);
    assert_eq!(
        of_rays("globe_uncovered_px") + of_rays("globe_extra_px"),
        0.0
    );
    // Negative control: facets differ from rays, and coarse facets more than fine ones.
    let [coarse, fine] = ["45", "180"].map(|rows| value("ellipsoid", rows, "globe_px_max"));
    assert!(coarse > fine && fine > Some(of_rays("globe_px_p99")));
    assert_eq!(
        value("ellipsoid", "45", "globe_drawn_otherwise_px"),
        Some(0.0)
    );
    let blocks = GlobesChapter.blocks(&run).expect("a chapter");
    let plots = blocks
        .iter()
        .filter(|block| matches!(block, Block::Plot(_)));
    assert_eq!(plots.count(), 2);
}

#[test]
fn a_missing_device_is_skipped_and_a_wrong_parameter_fails() {
    let folder = tempfile::tempdir().expect("a folder");
    let none = Devices::new(Some("no such adapter".to_owned()));
    let run = measure(&folder.path().join("run"), none);
    for case in run.cases.iter().filter(|case| !case.is_repeat()) {
        assert_eq!(case.outcome, Outcome::Skipped, "{}", case.reason);
    }
    let mut works = ellipsoids();
    if let Some(chosen) = &mut works[0].surface {
        chosen.row.knob = "row".to_owned();
    }
    let devices = Rc::new(Devices::default());
    let context = Context {
        devices: &devices,
        folder: folder.path(),
    };
    let sight = sight(&works, 8);
    let mut session = sight.open(context).expect("opens");
    let verdict = session
        .verify(0)
        .or_else(Failure::verdict)
        .expect("a verdict");
    assert_eq!(verdict.status, Status::Failed);
    assert!(verdict.reason.contains("row"), "{}", verdict.reason);
}

#[test]
fn a_surface_that_is_lost_or_drawn_otherwise_is_wrong() {
    let lost = Errors {
        non_finite: 1,
        ..Errors::default()
    };
    assert!(!standing(&lost, None).is_empty());
    assert!(standing(&Errors::default(), Some(1)).contains("1 pixels"));
    // Negative control: one that is not.
    assert_eq!(standing(&Errors::default(), Some(0)), "");
}
