// SPDX-License-Identifier: MIT OR Apache-2.0
//! Many volumes and covers in one draw: the same picture to the pixel, no more draws than the program has
//! steps and parts, and nothing handed over in a frame like the one before.

use crate::drawing;

use drawing::{
    AllTargets, Devices, Technique, compute, counters, differing, draw_with, in_layout, layouts,
    leveled, made, native, shipped, shown, square, vertex, with_switches,
};
use terrafill_contract::{Colours, Feature, FillInput, PreparedScene};
use terrafill_gpu::VolumeFill;
use terrafill_native::Extrusion;
use terrafill_plan::PlanOptions;
use terrafill_scene::{ImageSize, Scene, View};
use terrafill_stencil::{
    FillCommand, FillPass, FillProgram, FillStep, HeldMeshes, RegionVolumes as _, StencilExecutor,
    StencilWork, VolumeConstants, VolumeList,
};
use terrafill_variant::{BottomCap, ColourWay, DepthRuleChoice, FacePasses, Switches};
use terrafill_vertex::{Layout, VertexVariant, VertexVolumes, Walls};

pub(crate) const SIZE: ImageSize = square(256);

/// The full plan, and each of its draws alone or merged.
pub(crate) fn switches(merges_draws: bool) -> Switches {
    Switches {
        merges_draws,
        depth_rule: DepthRuleChoice::Automatic,
        bottom_cap: BottomCap::WhereNeeded,
        ..Switches::default()
    }
}

pub(crate) fn techniques() -> Vec<Technique> {
    let plain = Switches::default();
    let lists = Technique::Vertex(VertexVariant {
        walls: Walls::List,
        ..VertexVariant::default()
    });
    let others = [
        lists,
        compute(plain),
        native(Extrusion::VsControl, plain),
        native(Extrusion::GsLine, plain),
    ];
    layouts(plain).into_iter().chain(others).collect()
}

pub(crate) fn seen(scene: &PreparedScene, view: &View) -> FillInput {
    shown(scene, view, SIZE)
}

/// Draws of layout `doubled`, or of commands in a list, by the program: caps and walls of each step of volumes, one of each of covers.
fn planned_draws(input: &FillInput, switches: &Switches) -> u64 {
    let list = VolumeList::of(input, switches);
    let program = FillProgram::new(&list.volumes, switches, input.scene.overlap);
    let program = program.expect("allowed");
    let steps = program.passes.iter().flat_map(FillPass::steps);
    let draws = steps.map(|step| match step {
        FillStep::Volumes(_) => 2,
        FillStep::Cover { .. } | FillStep::Resolve => 1,
    });
    draws.sum()
}

#[test]
fn shipped_scenes_look_the_same_whether_draws_are_merged() {
    assert_merged_draws_show_the_same(&["california", "planet-134"]);
}

#[test]
#[ignore = "needs data: natural-earth-110m"]
fn countries_look_the_same_whether_draws_are_merged() {
    assert_merged_draws_show_the_same(&["countries-110m"]);
}

fn assert_merged_draws_show_the_same(names: &[&str]) {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    for &name in names {
        let (scene, views) = shipped(name);
        let mut fewer = 0;
        for view in &views {
            let input = seen(&scene, view);
            for technique in techniques() {
                let what = format!("{name}/{}: {technique:?}", view.name);
                let [each, merged] = [false, true].map(|merges| {
                    let technique = with_switches(technique, switches(merges));
                    let mut backend = targets.open(technique);
                    let frame = draw_with(&mut *backend, &input);
                    if let Some(needs) = backend.needs(&input).expect("prepared") {
                        assert_eq!(needs.undeclared(), None, "{what}");
                    }
                    frame
                });
                assert_eq!(differing(&each, &merged), 0, "{what}");
                let [each, merged] = [&each, &merged].map(counters);
                assert!(merged.draws <= each.draws, "{what}");
                fewer += usize::from(merged.draws < each.draws);
                let is_merged = match technique {
                    Technique::Vertex(variant) => variant.layout == Layout::Doubled,
                    Technique::Native(_) => devices.vulkan().facts.features.draws_listed,
                    Technique::Compute(_) => false,
                };
                if is_merged {
                    // A region that has no boundary has no walls to draw; none of these is one.
                    assert_eq!(
                        merged.draws,
                        planned_draws(&input, &switches(true)),
                        "{what}"
                    );
                    assert_eq!(merged.stencil_fragments, each.stencil_fragments, "{what}");
                }
            }
        }
        assert_eq!(
            fewer > 0,
            name != "california",
            "{name}: one region shares no draw"
        );
    }
}

#[test]
fn every_way_of_colouring_looks_the_same_whether_draws_are_merged() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let (scene, views) = shipped("planet-134");
    let targets = AllTargets::new(&devices, SIZE);
    let input = seen(&scene, &views[0]);
    let plain = Switches::default();
    let techniques = [vertex(plain), native(Extrusion::VsControl, plain)];
    for colour in ColourWay::ALL {
        for faces in [FacePasses::TwoSided, FacePasses::TwoPass] {
            for technique in techniques {
                let [each, merged] = [false, true].map(|merges| {
                    let switches = Switches {
                        colour,
                        faces,
                        ..switches(merges)
                    };
                    targets.draw(&input, with_switches(technique, switches))
                });
                let what = format!("{colour:?} {faces:?} {technique:?}");
                assert_eq!(differing(&each, &merged), 0, "{what}");
                assert!(merged.filled_px() > 1000, "{what}");
            }
        }
    }
}

#[test]
fn a_merged_frame_like_the_one_before_hands_nothing_over() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let (scene, views) = shipped("planet-134");
    let targets = AllTargets::new(&devices, SIZE);
    let merged = switches(true);
    for technique in [vertex(merged), native(Extrusion::VsControl, merged)] {
        let mut backend = targets.open(technique);
        let inputs: Vec<FillInput> = views.iter().map(|view| seen(&scene, view)).collect();
        let mut frame = |input: &FillInput| made(&draw_with(&mut *backend, input));
        let first = frame(&inputs[0]);
        assert!(first.iter().all(|&count| count > 0), "{first:?}");
        assert_eq!(frame(&inputs[0]), [0, 0, 0]);
        // Negative control: another view draws others, which is handed over, and then no more.
        let other = frame(&inputs[1]);
        assert!(other[2] > 1, "{other:?}");
        assert_eq!(frame(&inputs[1]), [0, 0, 0]);
    }
}

#[test]
fn levels_share_draws_as_full_boundaries_do() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let scene = Scene::shipped("planet-134", None).expect("ships");
    let prepared = leveled(&scene);
    assert!(prepared.meshes.len() > scene.regions.len(), "one level");
    let targets = AllTargets::new(&devices, SIZE);
    let plan = PlanOptions {
        boundary_lod_px: Some(0.5),
        ..PlanOptions::default()
    };
    for view in &scene.views {
        let input = FillInput::new(&prepared, view, SIZE, plan).expect("a surface");
        let each = targets.draw(&input, vertex(switches(false)));
        let positions = |merges, layout| {
            let technique = in_layout(layout, switches(merges));
            let mut backend = targets.open(technique);
            let frame = draw_with(&mut *backend, &input);
            assert_eq!(differing(&each, &frame), 0, "{}: {technique:?}", view.name);
            let needs = backend.needs(&input).expect("prepared").expect("told");
            assert_eq!(needs.undeclared(), None);
            needs.of(Feature::Positions).expect("told").bytes
        };
        for layout in Layout::ALL {
            assert_eq!(
                positions(false, layout),
                positions(true, layout),
                "{layout:?}"
            );
        }
    }
}

/// Pixels that change where the program of the merged draws is changed.
pub(crate) fn differing_when(
    targets: &AllTargets<'_>,
    input: &FillInput,
    switches: Switches,
    change: impl Fn(&mut FillProgram, &mut VolumeList),
) -> usize {
    let variant = VertexVariant {
        switches,
        ..VertexVariant::default()
    };
    let mut fill = <VolumeFill as StencilExecutor<VertexVolumes>>::new(targets.wgpu(), &switches);
    let fill = fill.as_mut().expect("opens");
    let mut volumes = VertexVolumes::new(fill, variant).expect("opens");
    let mut list = VolumeList::of(input, &switches);
    let program = FillProgram::new(&list.volumes, &switches, input.scene.overlap);
    let mut program = program.expect("allowed");
    change(&mut program, &mut list);
    targets.wgpu().borrow_mut().prepare(input).expect("fits");
    volumes.upload(fill, input, &HeldMeshes::All).expect("fits");
    let places = volumes.places().expect("uploaded");
    let constants = VolumeConstants::bytes_of_all(input, volumes.positions(), Colours::Ids, places);
    let work = StencilWork {
        list,
        program,
        constants,
        blends: false,
    };
    StencilExecutor::<VertexVolumes>::load(fill, work).expect("fits");
    fill.ensure(&mut volumes).expect("makes");
    let drawn = targets.wgpu().borrow_mut().draw_surface();
    drawn.expect("draws");
    fill.draw(&mut volumes).expect("draws");
    let picture = targets.wgpu().borrow().read().expect("reads");
    let all = targets.draw(input, vertex(self::switches(false)));
    let changed = terrafill_contract::ids_of(&picture);
    all.ids.iter().zip(changed).filter(|(a, b)| *a != b).count()
}

/// What the checks above would not notice, if these were right as well.
#[test]
fn draws_that_share_what_they_may_not_are_wrong() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let (scene, views) = shipped("planet-134");
    let targets = AllTargets::new(&devices, SIZE);
    let input = seen(&scene, &views[0]);
    let differing_when = |change: &dyn Fn(&mut FillProgram, &mut VolumeList)| {
        differing_when(&targets, &input, switches(true), change)
    };
    assert_eq!(differing_when(&|_, _| ()), 0);
    // Covers of one number reach over the volumes of that number that they are merged with.
    let wide = differing_when(&|_, list| {
        for volume in &mut list.volumes {
            volume.screen_rect.right = (volume.screen_rect.right + 40).min(SIZE.width);
        }
    });
    // A step loses its last volume to no other.
    let lost = differing_when(&|program, _| {
        for command in program
            .passes
            .iter_mut()
            .flat_map(|pass| &mut pass.commands)
        {
            if let FillCommand::Volumes { volumes, .. } = command {
                volumes.truncate(1);
            }
        }
    });
    // Constants of another volume: the table says whose they are.
    let swapped = differing_when(&|_, list| {
        let last = list.volumes.len() - 1;
        let geometry = list.volumes[0].geometry;
        list.volumes[0].geometry = list.volumes[last].geometry;
        list.volumes[last].geometry = geometry;
    });
    eprintln!("{wide} by wide covers, {lost} lost, {swapped} by swapped constants");
    assert!(wide > 0 && lost > 0 && swapped > 0);
}
