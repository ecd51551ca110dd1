// SPDX-License-Identifier: MIT OR Apache-2.0
//! Squares of 10 m and of 200 km seen from close by, where positions are hardest: the default is wrong
//! in no pixel farther than one from a boundary, and the naive format, the twin, in thousands.
//!
//! The surface is drawn relative to the eye exactly, so all that is wrong is the volumes' doing. The
//! scenes are the shipped ones, at the size that the bench draws them in. Skipped without a device;
//! see `vertex_against_reference.rs`.

mod drawing;

use drawing::{Devices, Stages, differing, figures, judge, shipped};
use std::collections::BTreeMap;
use terrafill_bench::{BenchOptions, Technique, group_cases, open_scene};
use terrafill_conformance::verdict;
use terrafill_frame::{FrameInput, PositionFormat, Switches};
use terrafill_results::ErrorFigures;
use terrafill_scene::{ImageSize, PlanOptions};
use terrafill_vertex::{Layout, VertexVariant};

const SCENES: [&str; 2] = ["square-10m", "square-200km"];

const SIZE: ImageSize = ImageSize {
    width: 1024,
    height: 1024,
};

fn variant(layout: Layout, positions: PositionFormat) -> VertexVariant {
    VertexVariant {
        layout,
        positions,
        switches: Switches::default(),
        ..VertexVariant::default()
    }
}

/// Figures of every format in every view, layouts compared with one another on the way.
fn figures_of(name: &str) -> Option<BTreeMap<(String, &'static str), ErrorFigures>> {
    let devices = Devices::open()?;
    let (prepared, views) = shipped(name).expect("ships with the project");
    let stages = Stages::new(&devices, SIZE);
    let mut all = BTreeMap::new();
    for view in &views {
        let input = FrameInput::new(&prepared, view, SIZE, PlanOptions::default());
        let judged = judge(&input);
        for positions in PositionFormat::ALL {
            let draw = |layout| {
                let technique = Technique::Vertex(variant(layout, positions));
                stages.draw(&input, technique)
            };
            let [frame, pulled] = [Layout::Doubled, Layout::Pulled].map(draw);
            // How vertices are found is nothing that moves them.
            assert_eq!(differing(&frame, &pulled), 0, "{name}/{}", view.name);
            let found = figures(&judged, &frame);
            eprintln!("{name}/{} {}: {found:?}", view.name, positions.name());
            all.insert((view.name.clone(), positions.name()), found);
        }
    }
    Some(all)
}

/// Far away, half a metre is nothing.
fn is_close(view: &str) -> bool {
    view != "down-500km"
}

fn assert_only_the_naive_format_is_wrong(name: &str) {
    let Some(all) = figures_of(name) else {
        return;
    };
    let mut close = 0;
    for ((view, positions), found) in &all {
        let is_pass = verdict(found).is_pass();
        match *positions {
            "fixed" | "two-float" => assert!(is_pass, "{name}/{view} {positions}: {found:?}"),
            // The twin.
            "ecef-f32" => {
                assert_eq!(is_pass, !is_close(view), "{name}/{view}: {found:?}");
                let in_thousands = found.mismatched_px_outside_band > 1_000;
                assert_eq!(in_thousands, is_close(view), "{name}/{view}: {found:?}");
                close += usize::from(is_close(view));
            }
            _ => {}
        }
    }
    assert_eq!(close, 3, "{name}: views from close by");
}

#[test]
fn ten_metres_from_close_by() {
    assert_only_the_naive_format_is_wrong("square-10m");
}

#[test]
fn two_hundred_kilometres_from_close_by() {
    assert_only_the_naive_format_is_wrong("square-200km");
}

#[test]
fn the_bench_sweeps_through_the_formats_where_a_scene_asks_for_it() {
    let options = BenchOptions::default();
    for (name, is_asked) in [
        ("square-10m", true),
        ("square-200km", true),
        ("california", false),
    ] {
        let scene = open_scene(name, None)
            .expect("ships with the project")
            .into();
        let group = group_cases(&scene, &scene.views[0], &options);
        let named = |format: PositionFormat| {
            let part = format!("positions={}", format.name());
            let cases = group.cases.iter();
            cases
                .filter(|case| case.key.variant.contains(&part))
                .collect::<Vec<_>>()
        };
        for format in [
            PositionFormat::LocalF32,
            PositionFormat::EcefF32,
            PositionFormat::TwoFloat,
        ] {
            let cases = named(format);
            let in_sweep = cases.iter().filter(|case| case.roles.sweep).count();
            let tolerances = scene.sweep_boundary_tolerance_m.len();
            assert_eq!(
                in_sweep,
                if is_asked { tolerances } else { 0 },
                "{name} {format:?}"
            );
            // Outside the sweep a wrong picture fails the run.
            let is_main = cases.iter().any(|case| case.roles.main);
            assert_eq!(is_main, !is_asked && format == PositionFormat::LocalF32);
        }
        let default = group
            .cases
            .iter()
            .find(|case| case.key.variant == "doubled");
        assert!(default.is_some_and(|case| case.roles.main && !case.roles.sweep));
    }
}
