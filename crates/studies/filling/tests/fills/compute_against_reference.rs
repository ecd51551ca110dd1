// SPDX-License-Identifier: MIT OR Apache-2.0
//! The compute backend held against the reference and, to the pixel, against the vertex backend:
//! every expansion, culling and switch on extreme regions and views; culling on the device against
//! the frame plan's; capacities; and the controls that must be noticed.
//!
//! Without a Vulkan device these tests are skipped with the reason printed, unless
//! `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does.

use crate::drawing;

use drawing::pairs::pairwise;
use drawing::sights::{self, POSES, square_from, three_regions_from};
use drawing::{
    AllTargets, Devices, SIZE, Technique, checks, counters, differing, draw, shipped, shown,
    vertex, with_colour, with_switches,
};
use terrafill_compute::{
    Capacity, ComputeBackend, ComputeTechnique, ComputeVariant, Expansion, GpuCulling, Transform,
    compute_bytes, placed_bytes,
};
use terrafill_contract::{DeviceError, FillBackend as _, FillInput, Frame};
use terrafill_plan::{LeftOutReason, PartCulling, PlanOptions, WallHeights};
use terrafill_variant::{ColourWay, Switches};

/// Every expansion with every culling that goes with it, and either transform.
fn all_variants() -> Vec<ComputeVariant> {
    let mut variants = Vec::new();
    for transform in [Transform::VertexStage, Transform::ComputeStage] {
        for expansion in [Expansion::PerFrame, Expansion::Cached] {
            for culling in [GpuCulling::Off, GpuCulling::Regions, GpuCulling::Triangles] {
                variants.push(ComputeVariant {
                    expansion,
                    culling,
                    transform,
                    ..ComputeVariant::default()
                });
            }
        }
    }
    variants.retain(|variant| variant.check().is_ok());
    assert_eq!(variants.len(), 10);
    variants
}

fn with_culling(culling: GpuCulling) -> ComputeVariant {
    ComputeVariant {
        culling,
        ..ComputeVariant::default()
    }
}

/// The same as the bench asks for them.
fn techniques() -> Vec<Technique> {
    all_variants().into_iter().map(Technique::Compute).collect()
}

fn compute(variant: ComputeVariant) -> Technique {
    Technique::Compute(variant)
}

/// On targets of its own.
fn backend(devices: &Devices, variant: ComputeVariant) -> ComputeBackend {
    let targets = AllTargets::new(devices, SIZE);
    ComputeBackend::new(targets.wgpu(), variant).expect("valid shaders")
}

#[test]
fn a_hole_an_island_in_it_and_a_neighbour() {
    checks::assert_all_right(&sights::hole_island_and_neighbour(), &techniques());
}

#[test]
fn across_the_antimeridian_and_over_the_poles() {
    checks::assert_all_right(&sights::seam_and_poles(), &techniques());
}

#[test]
fn a_ten_metre_square_from_fifty_metres() {
    checks::assert_all_right(&sights::ten_metres(), &techniques());
}

#[test]
fn other_bodies() {
    checks::assert_all_right(&sights::other_bodies(), &techniques());
}

#[test]
fn counting_in_front_is_wrong_from_inside_and_the_automatic_rule_knows() {
    checks::assert_forced_in_front_is_wrong_from_inside(&techniques());
}

#[test]
fn broken_volumes_are_noticed() {
    checks::assert_broken_volumes_are_noticed(&techniques());
}

#[test]
fn no_switch_changes_a_pixel() {
    let own = ["expansion", "gpu-culling", "transform"];
    let techniques: Vec<Technique> = pairwise(&ComputeTechnique, &own)
        .iter()
        .map(|variant| Technique::Compute(ComputeVariant::of(variant).expect("known names")))
        .collect();
    checks::assert_no_switch_changes_a_pixel(&techniques);
}

const NOTHING_LEFT_OUT: PlanOptions = PlanOptions {
    sky_culling: false,
    interior: false,
    frustum_culling: false,
    horizon_culling: false,
    too_small_culling: false,
    boundary_lod_px: None,
    far_level_px: None,
    wall_heights: WallHeights::Region,
    part_culling: PartCulling::Off,
};

#[test]
fn culling_on_the_device_changes_no_pixel_and_leaves_out_what_the_plan_would() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let (prepared, views) = shipped("planet-134");
    for view in &views {
        let planned = shown(&prepared, view, SIZE);
        let everything = planned.remeshed(&prepared, NOTHING_LEFT_OUT);
        assert!(planned.plan.regions.len() < everything.plan.regions.len());
        let uncut = draw(&devices, &everything, compute(ComputeVariant::default()));
        let by_vertex = draw(&devices, &planned, vertex(Switches::default()));
        assert_eq!(differing(&uncut, &by_vertex), 0, "{}", view.name);
        // Regions that the plan leaves out for reasons that the device knows as well.
        let exact = |reason| reason != LeftOutReason::TooSmall;
        let left_out = planned.plan.left_out.iter();
        let plan_leaves = left_out.filter(|region| exact(region.reason)).count();
        for variant in all_variants() {
            let what = format!("{} {variant:?}", view.name);
            let mut backend = backend(&devices, variant);
            backend.prepare(&everything).expect("fits");
            let frame = backend.render(&everything).expect("draws");
            assert_eq!(differing(&frame, &uncut), 0, "{what}");
            if variant.culling == GpuCulling::Off {
                assert_eq!(counters(&frame).vertices, counters(&uncut).vertices);
                continue;
            }
            assert!(
                counters(&frame).vertices < counters(&uncut).vertices,
                "{what}"
            );
            let left = backend.volumes().left_out(backend.executor());
            let left = left.expect("reads back");
            let unplanned = |mesh: &usize| {
                let mut of_plan = planned.plan.left_out.iter();
                of_plan.any(|region| region.mesh == *mesh && exact(region.reason))
            };
            assert!(left.iter().all(unplanned), "{what}: more than the plan");
            assert!(
                left.len() * 10 >= plan_leaves * 9,
                "{what}: {} of {plan_leaves}",
                left.len()
            );
        }
    }
}

#[test]
fn fragments_are_those_of_the_vertex_backend_and_pieces_out_of_view_have_none() {
    let Some(devices) = Devices::open() else {
        return;
    };
    if !devices.wgpu.facts.features.pipeline_statistics {
        eprintln!("skipped: no pipeline statistics");
        return;
    }
    let pose = (9.5, 5.0, 2e4, 90.0, -30.0);
    let input = square_from(pose);
    for colour in [ColourWay::Xor, ColourWay::IdAccumulation] {
        let switches = with_colour(colour);
        let by_vertex = counters(&draw(&devices, &input, vertex(switches))).stencil_fragments;
        assert!(by_vertex > Some(0), "{colour:?}: {by_vertex:?}");
        for variant in all_variants() {
            let technique = with_switches(compute(variant), switches);
            let found = counters(&draw(&devices, &input, technique)).stencil_fragments;
            assert_eq!(found, by_vertex, "{variant:?}");
        }
    }
}

#[test]
fn culling_pieces_leaves_out_more_than_culling_regions() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let pose = (9.5, 5.0, 2e4, 90.0, -30.0);
    let input = square_from(pose);
    let vertices = |culling| {
        let technique = compute(with_culling(culling));
        counters(&draw(&devices, &input, technique)).vertices
    };
    let whole = vertices(GpuCulling::Off);
    assert_eq!(vertices(GpuCulling::Regions), whole);
    let pieces = vertices(GpuCulling::Triangles);
    assert!(pieces * 2 < whole, "{pieces} of {whole}");
    assert!(pieces > 0);
}

/// Twin of the above: boxes on the far side of the body take their regions with them.
#[test]
fn culling_by_wrong_boxes_is_noticed() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let mut input = three_regions_from(POSES[0]);
    let right = draw(&devices, &input, compute(ComputeVariant::default()));
    let turned = (0..input.scene.meshes.len()).map(|mesh| {
        let mut region = input.scene.bounds[mesh];
        region.bounds.center_ecef = -region.bounds.center_ecef;
        (mesh, region)
    });
    input.scene.bounds = input.scene.bounds.with(turned.collect::<Vec<_>>());
    for variant in all_variants() {
        let frame = draw(&devices, &input, compute(variant));
        let is_blind = variant.culling == GpuCulling::Off;
        assert_eq!(frame.ids == right.ids, is_blind, "{variant:?}");
        assert_eq!(frame.filled_px() == 0, !is_blind, "{variant:?}");
    }
}

/// A frame drawn within `capacity`.
fn draw_within(
    devices: &Devices,
    input: &FillInput,
    variant: ComputeVariant,
    capacity: Capacity,
) -> Result<Frame, DeviceError> {
    let targets = AllTargets::new(devices, input.size);
    let mut backend = ComputeBackend::new(targets.wgpu(), variant)?;
    backend.volumes_mut().set_capacity(capacity);
    backend.prepare(input)?;
    backend.render(input)
}

#[test]
fn too_much_is_refused_with_numbers_and_just_enough_is_drawn() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let input = three_regions_from(POSES[0]);
    let device = Capacity::of(&devices.wgpu.device.limits());
    let output: u64 = input
        .scene
        .meshes
        .iter()
        .map(|mesh| compute_bytes(mesh).output_index_bytes)
        .sum();
    for variant in all_variants() {
        let name = format!("{variant:?}");
        let within = |capacity| draw_within(&devices, &input, variant, capacity);
        let frame = within(device).expect("fits");
        // What is expanded is the largest buffer: its size is just enough, a byte less is not.
        let exact = Capacity {
            storage_bytes: output,
            ..device
        };
        assert_eq!(within(exact).expect("just fits").ids, frame.ids, "{name}");
        let error = within(Capacity {
            storage_bytes: output - 1,
            ..device
        })
        .expect_err("does not fit");
        let expected = format!(
            "bytes of expanded volumes: found {output}, allowed {}",
            output - 1
        );
        assert_eq!(error.to_string(), expected, "{name}");
        // Rows of workgroups where one row is too short; and too few of both.
        let mut columns = 1;
        let narrow = loop {
            let narrow = Capacity {
                workgroups_per_dimension: columns,
                ..device
            };
            match within(narrow) {
                Ok(narrow) => break narrow,
                Err(DeviceError::OverCapacity { found, allowed, .. }) => {
                    assert_eq!(allowed, u64::from(columns * columns));
                    assert!(found > allowed);
                }
                Err(error) => panic!("{name}: {error}"),
            }
            columns += 1;
        };
        assert!(columns > 1, "{name}");
        assert_eq!(narrow.ids, frame.ids, "{name}");
    }
}

#[test]
fn what_does_not_go_together_is_refused() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    let variant = ComputeVariant {
        expansion: Expansion::Cached,
        ..with_culling(GpuCulling::Triangles)
    };
    let error = ComputeBackend::new(targets.wgpu(), variant).expect_err("views differ");
    assert!(error.to_string().contains("gpu-culling"), "{error}");
}

#[test]
fn bytes_are_those_of_the_formula() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let input = three_regions_from(POSES[0]);
    for variant in all_variants() {
        let mut formula: terrafill_compute::ComputeBytes = input
            .scene
            .meshes
            .iter()
            .map(|mesh| compute_bytes(mesh))
            .sum();
        if variant.transform == Transform::ComputeStage {
            formula.output_vertex_bytes = input
                .scene
                .meshes
                .iter()
                .map(|mesh| placed_bytes(mesh))
                .sum();
        }
        let mut backend = backend(&devices, variant);
        let memory = backend.prepare(&input).expect("fits");
        assert_eq!(backend.volumes().bytes(), formula, "{variant:?}");
        assert_eq!(memory.geometry_bytes(), formula.total());
        assert!(memory.upload_bytes < formula.total(), "only input goes up");
        assert!(memory.upload_bytes > formula.input());
    }
}

#[test]
fn nothing_in_view_draws_nothing() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let pose = (-150.0, 5.0, 3e5, 0.0, -90.0);
    let empty = square_from(pose);
    assert!(empty.plan.regions.is_empty());
    for variant in all_variants() {
        let mut backend = backend(&devices, variant);
        backend.prepare(&empty).expect("fits");
        let frame = backend.render(&empty).expect("draws");
        assert_eq!((frame.filled_px(), counters(&frame).draws), (0, 0));
        backend.time_frame(&empty).expect("draws");
    }
}

#[test]
fn a_frame_needs_preparing_and_an_unchanged_one_makes_and_uploads_nothing() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let pose = (5.0, 5.0, 2e6, 0.0, -90.0);
    let [first, other] = [square_from(pose), square_from(pose)];
    for variant in all_variants() {
        let mut backend = backend(&devices, variant);
        let error = backend.render(&first).expect_err("not prepared");
        assert_eq!(
            error.to_string(),
            "backend compute is not prepared for view test of scene test"
        );
        assert!(backend.time_frame(&first).is_err());
        backend.prepare(&first).expect("fits");
        let frame = backend.render(&first).expect("draws");
        assert!(backend.render(&other).is_err(), "another input");
        let before = devices.wgpu.work_done();
        let times = backend.time_frame(&first).expect("draws");
        assert_eq!(devices.wgpu.work_done(), before, "{variant:?}");
        assert_eq!(
            times.fill_gpu_ms.is_some(),
            devices.wgpu.facts.features.timestamps
        );
        let again = backend.render(&first).expect("draws");
        assert_eq!(frame.ids, again.ids);
        let steady = counters(&again);
        assert_eq!((steady.uploads, steady.upload_bytes), (0, 0));
        assert_eq!((steady.buffer_creations, steady.pipeline_creations), (0, 0));
        // Negative control: preparing does make and upload something, and is counted.
        let before = devices.wgpu.work_done();
        backend.prepare(&other).expect("fits");
        let made = devices.wgpu.work_done() - before;
        assert!(made.buffer_creations > 0 && made.uploads > 0);
        let prepared = counters(&backend.render(&other).expect("draws"));
        assert!(prepared.buffer_creations > 0 && prepared.uploads > 0);
    }
}

#[test]
fn the_picture_has_the_regions_colours_and_leaves_the_ids_alone() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let input = three_regions_from(POSES[0]);
    for variant in all_variants() {
        let mut backend = backend(&devices, variant);
        backend.prepare(&input).expect("fits");
        let before = backend.render(&input).expect("draws");
        let picture = backend.picture(&input).expect("draws");
        let filled = picture.rgba.chunks(4).filter(|pixel| pixel[3] != 0).count();
        assert_eq!(filled as u64, before.filled_px(), "{variant:?}");
        let after = backend.render(&input).expect("draws");
        assert_eq!(before.ids, after.ids);
    }
}
