// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures held against the reference: shipped scenes, ways of colouring and counting, an eye inside
//! a volume; and volumes that are broken, which must be noticed.
//!
//! Without a Vulkan device these tests are skipped with the reason printed, unless
//! `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does.

use crate::layout::SceneGeometry;
use crate::{InstancedBackend, instanced_bytes};
use std::sync::Arc;
use terrafill_conformance::{compare, filled_only, verdict};
use terrafill_contract::{FillBackend as _, FillInput, Frame, GeometryBytes, PreparedScene};
use terrafill_core::{Geodetic, RegionMesh};
use terrafill_gpu::{Gpu, RenderTargets, open_for_test};
use terrafill_grid::GridKind;
use terrafill_plan::{NearRectangle, PlanOptions, RegionSet};
use terrafill_reference::ReferenceBackend;
use terrafill_scene::{CameraPose, ImageSize, Scene, View};
use terrafill_surface::{EllipsoidKind, open_surface};
use terrafill_variant::{BottomCap, ColourWay, DepthRuleChoice, FacePasses, Switches};

const SIZE: ImageSize = ImageSize::new(256, 192);

/// A shipped scene with its views.
fn shipped(name: &str) -> (PreparedScene, Vec<View>) {
    let scene = Scene::shipped(name, None).expect("needs no data");
    let (body, rule) = (&scene.body, scene.edge_rule);
    let meshes = RegionMesh::build_all(&scene.regions, body, rule, &scene.mesh);
    let meshes: RegionSet = meshes.expect("it meshes").into();
    let surface = open_surface(&[&EllipsoidKind, &GridKind], &scene).expect("a surface");
    (PreparedScene::new(&scene, meshes, surface), scene.views)
}

fn seen(scene: &PreparedScene, view: &View) -> FillInput {
    FillInput::new(scene, view, SIZE, PlanOptions::default()).expect("a surface")
}

/// California from a shipped view.
fn california(view: &str) -> FillInput {
    let (scene, views) = shipped("california");
    let named = views.iter().find(|found| found.name == view);
    seen(&scene, named.expect("it is shipped"))
}

/// California by an eye near its border and below its volume's top.
fn from_inside() -> FillInput {
    let (scene, _) = shipped("california");
    let view = View {
        name: "inside".to_owned(),
        pose: CameraPose {
            eye: Geodetic::from_degrees(-119.0, 36.0, 300.0),
            heading_rad: 0.0,
            pitch_rad: (-5_f64).to_radians(),
            fov_y_rad: 60_f64.to_radians(),
            near_m: 1.0,
        },
        note: None,
    };
    seen(&scene, &view)
}

fn reference(input: &FillInput) -> Frame {
    ReferenceBackend::new().judge(input).expect("judges").frame
}

fn backend(gpu: &Arc<Gpu>, switches: Switches) -> InstancedBackend {
    let targets = RenderTargets::shared(gpu, SIZE).expect("a size every device has");
    InstancedBackend::new(&targets, switches).expect("valid shaders")
}

fn draw(gpu: &Arc<Gpu>, input: &FillInput, switches: Switches) -> Frame {
    let mut backend = backend(gpu, switches);
    backend.prepare(input).expect("fits");
    backend.render(input).expect("draws")
}

fn is_right(reference: &Frame, frame: &Frame, switches: Switches) -> bool {
    let told_apart = |frame: &Frame| {
        if switches.colour.tells_regions_apart() {
            frame.clone()
        } else {
            filled_only(frame)
        }
    };
    let figures = compare(&told_apart(reference), &told_apart(frame)).expect("of one size");
    let verdict = verdict(&figures);
    if !verdict.is_pass() {
        eprintln!("{switches:?}: {verdict:?}");
    }
    verdict.is_pass()
}

/// Ways of colouring, each with either way of counting; and what else changes the parts drawn.
fn choices() -> Vec<Switches> {
    let mut choices = Vec::new();
    for colour in ColourWay::ALL {
        for depth_rule in [DepthRuleChoice::Fail, DepthRuleChoice::Automatic] {
            choices.push(Switches {
                colour,
                depth_rule,
                ..Switches::default()
            });
        }
    }
    choices.push(Switches {
        depth_rule: DepthRuleChoice::Automatic,
        bottom_cap: BottomCap::WhereNeeded,
        ..Switches::default()
    });
    choices.push(Switches {
        faces: FacePasses::TwoPass,
        scissor: true,
        colour: ColourWay::Volume,
        cover_culls_faces: true,
        ..Switches::default()
    });
    choices
}

#[test]
fn shipped_scenes_are_right() {
    let Some(gpu) = open_for_test(&Default::default()) else {
        return;
    };
    for name in ["planet-134", "california", "square-10m", "hills"] {
        let (scene, views) = shipped(name);
        for view in &views {
            let input = seen(&scene, view);
            let reference = reference(&input);
            assert!(reference.filled_px() > 100, "{name}/{}", view.name);
            for colour in [ColourWay::Xor, ColourWay::Rectangle, ColourWay::OneColour] {
                for depth_rule in [DepthRuleChoice::Fail, DepthRuleChoice::Automatic] {
                    let switches = Switches {
                        colour,
                        depth_rule,
                        ..Switches::default()
                    };
                    let frame = draw(&gpu, &input, switches);
                    let is_right = is_right(&reference, &frame, switches);
                    assert!(is_right, "{name}/{}, {switches:?}", view.name);
                }
            }
        }
    }
}

#[test]
fn every_way_of_colouring_and_counting_shows_the_same() {
    let Some(gpu) = open_for_test(&Default::default()) else {
        return;
    };
    let (scene, views) = shipped("planet-134");
    for view in &views {
        let input = seen(&scene, view);
        let reference = reference(&input);
        let first = draw(&gpu, &input, Switches::default());
        for switches in choices() {
            let frame = draw(&gpu, &input, switches);
            let what = format!("{}, {switches:?}", view.name);
            assert!(is_right(&reference, &frame, switches), "{what}");
            assert_eq!(filled_only(&frame).ids, filled_only(&first).ids, "{what}");
        }
    }
}

#[test]
fn an_eye_inside_a_volume_sees_the_region() {
    let Some(gpu) = open_for_test(&Default::default()) else {
        return;
    };
    let input = from_inside();
    assert_eq!(input.plan.regions[0].near_rectangle, NearRectangle::Within);
    let reference = reference(&input);
    assert!(reference.filled_px() > 100);
    // Negative control: counting in front of the surface is wrong where the near plane has cut faces off.
    for (depth_rule, right) in [
        (DepthRuleChoice::Fail, true),
        (DepthRuleChoice::Automatic, true),
        (DepthRuleChoice::Uncut, true),
        (DepthRuleChoice::Pass, false),
    ] {
        let switches = Switches {
            depth_rule,
            ..Switches::default()
        };
        let frame = draw(&gpu, &input, switches);
        let found = is_right(&reference, &frame, switches);
        assert_eq!(found, right, "{depth_rule:?}");
    }
}

/// One way to break what is uploaded.
type Break = fn(&mut SceneGeometry);

#[test]
fn broken_volumes_are_noticed() {
    let Some(gpu) = open_for_test(&Default::default()) else {
        return;
    };
    let input = california("horizon");
    let reference = reference(&input);
    let whole: Break = |_| {};
    let half_the_walls: Break = |geometry| {
        for slice in &mut geometry.regions {
            slice.walls.end -= (slice.walls.end - slice.walls.start) / 2;
        }
    };
    let walls_turned: Break = |geometry| {
        for ends in &mut geometry.walls {
            ends.reverse();
        }
    };
    let caps_swapped: Break = |geometry| {
        for corners in geometry.indices.short.chunks_exact_mut(3) {
            corners.swap(1, 2);
        }
    };
    // Which way a face looks is nothing to whoever flips bits.
    let counts = ColourWay::Rectangle;
    for (what, breaks, colour, right) in [
        ("whole", whole, ColourWay::Xor, true),
        ("whole", whole, counts, true),
        ("half the walls", half_the_walls, ColourWay::Xor, false),
        ("half the walls", half_the_walls, counts, false),
        ("walls turned", walls_turned, counts, false),
        ("caps swapped", caps_swapped, counts, false),
    ] {
        let switches = Switches {
            colour,
            ..Switches::default()
        };
        let mut backend = backend(&gpu, switches);
        backend.prepare(&input).expect("fits");
        let mut geometry = SceneGeometry::build(&input.scene.meshes);
        breaks(&mut geometry);
        let uploaded = backend.volumes_mut().upload_geometry(&gpu, geometry);
        uploaded.expect("fits");
        let frame = backend.render(&input).expect("draws");
        let found = is_right(&reference, &frame, switches);
        assert_eq!(found, right, "{what}, {colour:?}");
    }
}

/// All four walls of the square are in sight.
#[test]
fn a_wall_that_is_missing_is_noticed() {
    let Some(gpu) = open_for_test(&Default::default()) else {
        return;
    };
    let (scene, views) = shipped("square-10m");
    let input = seen(&scene, &views[1]);
    let reference = reference(&input);
    let switches = Switches::default();
    let walls = SceneGeometry::build(&input.scene.meshes).walls.len();
    assert_eq!(walls, 4);
    for missing in 0..walls {
        let mut backend = backend(&gpu, switches);
        backend.prepare(&input).expect("fits");
        let mut geometry = SceneGeometry::build(&input.scene.meshes);
        // A wall without length.
        geometry.walls[missing][1] = geometry.walls[missing][0];
        let uploaded = backend.volumes_mut().upload_geometry(&gpu, geometry);
        uploaded.expect("fits");
        let frame = backend.render(&input).expect("draws");
        assert!(!is_right(&reference, &frame, switches), "wall {missing}");
    }
}

#[test]
fn bytes_by_formula_are_allocated_and_a_steady_frame_uploads_nothing() {
    let Some(gpu) = open_for_test(&Default::default()) else {
        return;
    };
    let [input, other] = ["globe", "top-down"].map(california);
    let other = other.remeshed(&input.scene, PlanOptions::default());
    let formula: GeometryBytes = input
        .scene
        .meshes
        .iter()
        .map(|mesh| instanced_bytes(mesh))
        .sum();
    for switches in choices() {
        let targets = RenderTargets::shared(&gpu, SIZE).expect("a size every device has");
        targets.borrow_mut().prepare(&input).expect("fits");
        let before = gpu.work_done();
        let mut backend = InstancedBackend::new(&targets, switches).expect("valid shaders");
        assert!(backend.render(&input).is_err(), "not prepared");
        let memory = backend.prepare(&input).expect("fits");
        let done = gpu.work_done() - before;
        assert_eq!(memory.vertex_bytes, formula.vertex_bytes);
        assert_eq!(memory.index_bytes, formula.index_bytes);
        assert_eq!(done.upload_bytes, formula.total() + memory.constant_bytes);
        assert_eq!(done.buffer_creations, memory.buffers, "{switches:?}");
        let first = backend.render(&input).expect("draws");
        backend.prepare(&input).expect("fits");
        let steady = backend.render(&input).expect("draws");
        let counters = steady.counters.expect("counted");
        assert_eq!((counters.uploads, counters.upload_bytes), (0, 0));
        assert_eq!(
            (counters.buffer_creations, counters.pipeline_creations),
            (0, 0)
        );
        assert_eq!(first.ids, steady.ids);
        // Negative control: another view writes its constants.
        backend.prepare(&other).expect("fits");
        let counters = backend.render(&other).expect("draws").counters;
        assert_eq!(counters.map(|counters| counters.uploads), Some(1));
        // A picture for people leaves no trace.
        backend.picture(&other).expect("draws");
        backend.prepare(&input).expect("fits");
        assert_eq!(backend.render(&input).expect("draws").ids, first.ids);
    }
}

/// Of every volume once: three indices a triangle and cap, four vertices a wall.
#[test]
fn vertices_of_all_instances_are_counted() {
    let Some(gpu) = open_for_test(&Default::default()) else {
        return;
    };
    let input = california("globe");
    let switches = Switches {
        colour: ColourWay::OneColour,
        ..Switches::default()
    };
    let counters = draw(&gpu, &input, switches).counters.expect("counted");
    let drawn = |mesh: &RegionMesh| 6 * mesh.triangles.len() + 4 * mesh.boundary_edge_count();
    let planned = input.plan.regions.iter();
    let volumes: usize = planned.map(|p| drawn(&input.scene.meshes[p.mesh])).sum();
    // And the triangle over the screen.
    assert_eq!(counters.vertices, volumes as u64 + 3);
    assert_eq!(counters.draws, 3 * input.plan.regions.len() as u64 + 1);
}
