// SPDX-License-Identifier: MIT OR Apache-2.0
//! A large region of which parts are left out: the same picture to the pixel, by fewer vertices, and counted.

use crate::drawing;

use drawing::{AllTargets, Devices, Technique, counters, differing, draw_with, leveled, square};
use terrafill_compute::{ComputeVariant, Expansion, Transform};
use terrafill_contract::{FillBackend, FillInput, Frame, PreparedScene};
use terrafill_instanced::InstancedBackend;
use terrafill_native::{Extrusion, NativeVariant};
use terrafill_plan::{LeftOutReason, PartCulling, PlanOptions};
use terrafill_scene::{ImageSize, Scene, View};
use terrafill_variant::{BottomCap, ColourWay, DepthRuleChoice, Switches};
use terrafill_vertex::{IndexOrder, Layout, VertexVariant, Walls};

const SIZE: ImageSize = square(192);

/// A coast of 12,000 vertices, 80 degrees across, and views in which some of it is not to be seen.
fn coast() -> (PreparedScene, Vec<View>) {
    let view = |name: &str, longitude: f64, latitude: f64, height_m: f64, pitch: f64| {
        format!(
            "[[views]]\nname = \"{name}\"\nlongitude_deg = {longitude}\nlatitude_deg = {latitude}\n\
             height_m = {height_m}\nheading_deg = 250\npitch_deg = {pitch}\nnear_m = {}\n",
            height_m * 1e-3
        )
    };
    let text = [
        "name = \"coast\"\ndescription = \"a coast\"\nbody = \"wgs84\"\n[regions.procedural]\n\
         kind = \"coast\"\nseed = 6\nvertices = 12_000\nlongitude_deg = 10\nlatitude_deg = 20\n\
         radius_deg = 40\n[surface]\nkind = \"ellipsoid\"\nrows = 90\n[mesh]\n\
         boundary_tolerance_m = 500\ncap_step_deg = 3\n[levels]\ndeviation_m = [4_000]\n"
            .to_owned(),
        view("whole", 10.0, 20.0, 9e6, -90.0),
        view("over-the-edge", 75.0, 10.0, 4e6, -80.0),
        view("horizon", 51.5, 20.0, 3e5, -12.0),
        view("close", 51.9, 20.0, 2e4, -60.0),
    ]
    .concat();
    let scene = Scene::from_toml(&text, "coast.toml", None).expect("a scene");
    (leveled(&scene), scene.views)
}

fn seen(scene: &PreparedScene, view: &View, part_culling: PartCulling) -> FillInput {
    let options = PlanOptions {
        part_culling,
        ..PlanOptions::default()
    };
    FillInput::new(scene, view, SIZE, options).expect("a surface")
}

fn in_front() -> Switches {
    Switches {
        depth_rule: DepthRuleChoice::Automatic,
        bottom_cap: BottomCap::WhereNeeded,
        ..Switches::default()
    }
}

fn vertex(switches: Switches) -> Vec<VertexVariant> {
    let with = |layout: Layout| VertexVariant {
        layout,
        parts: true,
        switches,
        ..VertexVariant::default()
    };
    vec![
        with(Layout::Doubled),
        VertexVariant {
            walls: Walls::List,
            index_order: IndexOrder::Cache,
            ..with(Layout::Doubled)
        },
        VertexVariant {
            switches: Switches {
                merges_draws: true,
                ..switches
            },
            ..with(Layout::Doubled)
        },
        VertexVariant {
            walls: Walls::List,
            switches: Switches {
                merges_draws: true,
                ..switches
            },
            ..with(Layout::Doubled)
        },
        with(Layout::Separate),
        with(Layout::Pulled),
    ]
}

fn native(switches: Switches) -> Vec<NativeVariant> {
    let with = |technique, merges_draws| NativeVariant {
        technique,
        parts: true,
        switches: Switches {
            merges_draws,
            ..switches
        },
        ..NativeVariant::default()
    };
    vec![
        with(Extrusion::GsLine, false),
        with(Extrusion::GsLine, true),
        with(Extrusion::VsControl, false),
        with(Extrusion::VsControl, true),
    ]
}

fn compute(switches: Switches) -> Vec<ComputeVariant> {
    let with = |expansion, transform| ComputeVariant {
        expansion,
        transform,
        parts: true,
        switches,
        ..ComputeVariant::default()
    };
    vec![
        with(Expansion::PerFrame, Transform::VertexStage),
        with(Expansion::Cached, Transform::VertexStage),
        with(Expansion::Cached, Transform::ComputeStage),
    ]
}

/// Frames of all that can draw parts, with what drew them.
fn frames(targets: &AllTargets<'_>, input: &FillInput, switches: Switches) -> Vec<(String, Frame)> {
    let vertex = vertex(switches).into_iter().map(Technique::Vertex);
    let native = native(switches).into_iter().map(Technique::Native);
    let compute = compute(switches).into_iter().map(Technique::Compute);
    let mut frames: Vec<(String, Frame)> = vertex
        .chain(native)
        .chain(compute)
        .map(|technique| (format!("{technique:?}"), targets.draw(input, technique)))
        .collect();
    let instanced = InstancedBackend::new(targets.wgpu(), switches);
    let mut instanced: Box<dyn FillBackend> = Box::new(instanced.expect("valid shaders"));
    frames.push(("instanced".to_owned(), draw_with(&mut *instanced, input)));
    frames
}

#[test]
fn what_is_left_out_of_a_large_region_changes_no_pixel_and_is_counted() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    let (scene, views) = coast();
    let mut by_reason = [0, 0];
    for view in &views {
        for (culling, switches) in [
            (PartCulling::Frustum, Switches::default()),
            (PartCulling::All, in_front()),
            (
                PartCulling::All,
                Switches {
                    colour: ColourWay::Volume,
                    ..in_front()
                },
            ),
        ] {
            let whole = seen(&scene, view, PartCulling::Off);
            let input = seen(&scene, view, culling);
            let parts = &input.plan.seen_parts[&0];
            let left_out = |reason| parts.left_out.get(&reason).copied().unwrap_or(0);
            by_reason[0] += left_out(LeftOutReason::OutsideFrustum);
            by_reason[1] += left_out(LeftOutReason::BeyondHorizon);
            let said = input.plan.left_out_summary(&scene.meshes);
            let says = said.contains("parts of large regions");
            assert_eq!(says, parts.facets_left_out > 0, "{}: {said}", view.name);
            assert_eq!(parts.facets_left_out > 0, view.name != "whole", "{said}");
            let both = [&whole, &input].map(|input| frames(&targets, input, switches));
            let expected = &both[0][0].1;
            assert!(expected.filled_px() > 500, "{}", view.name);
            for ((what, whole), (_, some)) in both[0].iter().zip(&both[1]) {
                assert_eq!(differing(whole, expected), 0, "{}: {what}", view.name);
                assert_eq!(differing(some, expected), 0, "{}: {what}", view.name);
                let [all, some] = [whole, some].map(|frame| counters(frame).vertices);
                assert_eq!(
                    some < all,
                    parts.facets_left_out > 0,
                    "{}: {what}",
                    view.name
                );
            }
        }
    }
    assert!(by_reason.iter().all(|&parts| parts > 0), "{by_reason:?}");
}

#[test]
fn a_part_that_is_left_out_and_seen_is_noticed() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    let (scene, views) = coast();
    let input = seen(&scene, &views[0], PartCulling::All);
    let right = frames(&targets, &input, in_front());
    let mut wrong = input.clone();
    let parts = wrong.plan.seen_parts.get_mut(&0).expect("large");
    let first = parts.caps.first_mut().expect("seen");
    let half = (first.end - first.start) / 2;
    first.end -= half;
    parts.facets_left_out += half as usize;
    for ((what, right), (_, wrong)) in right.iter().zip(frames(&targets, &wrong, in_front())) {
        assert!(differing(right, &wrong) > 20, "{what}");
    }
}

#[test]
fn a_frame_like_the_one_before_hands_nothing_over() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    let (scene, views) = coast();
    let vertex = vertex(in_front()).into_iter().map(Technique::Vertex);
    let native = native(in_front()).into_iter().map(Technique::Native);
    for technique in vertex.chain(native) {
        let mut backend = targets.open(technique);
        let inputs = [0, 3].map(|view: usize| seen(&scene, &views[view], PartCulling::All));
        let mut uploads = |input: &FillInput| counters(&draw_with(&mut *backend, input)).uploads;
        assert!(uploads(&inputs[0]) > 0);
        assert_eq!(uploads(&inputs[0]), 0, "{technique:?}");
        // Negative control: other parts are another view's constants, and where draws are merged another list.
        let other = uploads(&inputs[1]);
        assert_eq!(
            other > 1,
            technique.switches().merges_draws,
            "{other}: {technique:?}"
        );
        assert_eq!(uploads(&inputs[1]), 0, "{technique:?}");
    }
}
