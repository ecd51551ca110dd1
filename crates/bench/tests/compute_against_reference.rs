// SPDX-License-Identifier: MIT OR Apache-2.0
//! The compute backend held against the reference and, to the pixel, against the vertex backend:
//! every expansion, culling and switch on extreme regions and views; culling on the device against
//! the frame plan's; capacities; and the twins that must be noticed.
//!
//! Without a Vulkan device these tests are skipped with the reason printed, unless
//! `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does.

use std::sync::Arc;
use terrafill_bench::open_scene;
use terrafill_compute::{
    Capacity, ComputeBackend, ComputeVariant, Expansion, GpuCulling, Transform, compute_bytes,
    placed_bytes,
};
use terrafill_conformance::{compare, filled_only, verdict};
use terrafill_core::{EdgeRule, Ellipsoid, Geodetic, MeshOptions, RegionMesh, parse_regions};
use terrafill_frame::{
    Backend as _, BackendError, BottomCap, ColourWay, Counters, DepthRuleChoice, FacePasses, Frame,
    FrameInput, PreparedScene, StencilClear, Switches, TimedBackend as _, VolumeBackend as _,
};
use terrafill_gpu::{Gpu, GpuOptions, Stage, open_for_test};
use terrafill_reference::ReferenceBackend;
use terrafill_scene::{
    CameraPose, ImageSize, LeftOutReason, Overlap, PlanOptions, SurfaceMesh, View,
};
use terrafill_vertex::{VertexBackend, VertexVariant};

const SIZE: ImageSize = ImageSize {
    width: 384,
    height: 384,
};

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

/// Longitude, latitude, height, heading, pitch, in degrees and metres.
type Pose = (f64, f64, f64, f64, f64);

fn input(geojson: &str, body: Ellipsoid, rows: u32, pose: Pose) -> FrameInput {
    let regions = parse_regions(geojson.as_bytes(), "test").expect("valid regions");
    let options = MeshOptions {
        boundary_tolerance_m: body.equatorial_radius_m() * 1e-7,
        cap_step_deg: 3.0,
    };
    let meshes = RegionMesh::build_all(&regions, &body, EdgeRule::Planar, &options);
    let scene = PreparedScene {
        name: "test".to_owned(),
        body,
        edge_rule: EdgeRule::Planar,
        overlap: Overlap::Disjoint,
        regions: regions.into(),
        meshes: Arc::new([]),
        levels: Arc::default(),
        bounds: Arc::new([]),
        surface: Arc::new(SurfaceMesh::ellipsoid(&body, rows)),
        texture: None,
    }
    .with_meshes(meshes.expect("meshes").into());
    let (longitude, latitude, height_m, heading, pitch) = pose;
    let view = View {
        name: "test".to_owned(),
        pose: CameraPose {
            eye: Geodetic::from_degrees(longitude, latitude, height_m),
            heading_rad: heading.to_radians(),
            pitch_rad: pitch.to_radians(),
            fov_y_rad: 60_f64.to_radians(),
            near_m: height_m * 1e-3,
        },
        note: None,
    };
    FrameInput::new(&scene, &view, SIZE, PlanOptions::default())
}

fn polygon(name: &str, rings: &str) -> String {
    format!(
        r#"{{"type":"Feature","properties":{{"name":"{name}"}},
            "geometry":{{"type":"Polygon","coordinates":[{rings}]}}}}"#
    )
}

fn collection(features: &[String]) -> String {
    let joined = features.join(",");
    format!(r#"{{"type":"FeatureCollection","features":[{joined}]}}"#)
}

fn square() -> String {
    polygon("square", "[[0,0],[10,0],[10,10],[0,10],[0,0]]")
}

/// Two neighbours with a common border and a third region apart from them.
fn three_regions() -> String {
    collection(&[
        polygon("west", "[[0,0],[4,0],[6,10],[0,10],[0,0]]"),
        polygon("east", "[[4,0],[10,0],[10,10],[6,10],[4,0]]"),
        polygon("far", "[[12,2],[14,2],[14,4],[12,4],[12,2]]"),
    ])
}

fn backend(gpu: &Arc<Gpu>, size: ImageSize, variant: ComputeVariant) -> ComputeBackend {
    let stage = Stage::shared(gpu, size).expect("small targets");
    ComputeBackend::new(&stage, variant).expect("valid shaders")
}

fn draw(gpu: &Arc<Gpu>, input: &FrameInput, variant: ComputeVariant) -> Frame {
    let mut backend = backend(gpu, input.size, variant);
    backend.prepare(input).expect("fits");
    backend.render(input).expect("draws")
}

fn draw_by_vertex(gpu: &Arc<Gpu>, input: &FrameInput, switches: Switches) -> Frame {
    let stage = Stage::shared(gpu, input.size).expect("small targets");
    let variant = VertexVariant {
        switches,
        ..VertexVariant::default()
    };
    let mut backend = VertexBackend::new(&stage, variant).expect("valid shaders");
    backend.prepare(input).expect("fits");
    backend.render(input).expect("draws")
}

fn counters(frame: &Frame) -> Counters {
    frame.counters.expect("a GPU backend counts")
}

fn is_right(reference: &Frame, frame: &Frame) -> bool {
    verdict(&compare(reference, frame).expect("same size")).is_pass()
}

/// Every variant gives the vertex backend's ids and passes before the reference; and the view has
/// both filled and empty surface in it.
fn assert_all_variants_pass(what: &str, input: &FrameInput) {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let judged = ReferenceBackend::new().judge(input).expect("judges").frame;
    let filled = judged.filled_px();
    let surface = judged.surface.iter().filter(|&&is| is).count() as u64;
    assert!(filled > 100, "{what}: only {filled} pixels are filled");
    assert!(filled + 100 < surface, "{what}: no boundary in sight");
    let by_vertex = draw_by_vertex(&gpu, input, Switches::default());
    for variant in all_variants() {
        let frame = draw(&gpu, input, variant);
        let name = variant.name();
        assert!(is_right(&judged, &frame), "{what}, {name}");
        assert_eq!(frame.ids, by_vertex.ids, "{what}, {name}");
    }
}

#[test]
fn a_hole_an_island_in_it_and_a_neighbour() {
    let features = [
        polygon(
            "shell",
            "[[0,0],[10,0],[10,10],[0,10],[0,0]],[[2,2],[2,8],[8,8],[8,2],[2,2]]",
        ),
        polygon("island", "[[4,4],[6,4],[6,6],[4,6],[4,4]]"),
        polygon("neighbour", "[[10,0],[20,-5],[20,12],[10,10],[10,0]]"),
    ];
    let text = collection(&features);
    for (name, pose) in [
        ("above", (9.0, 4.0, 2e6, 30.0, -90.0)),
        ("oblique", (5.0, -2.0, 3e5, 10.0, -25.0)),
        ("low, inside", (1.7, 5.0, 5e3, 90.0, -12.0)),
    ] {
        assert_all_variants_pass(name, &input(&text, Ellipsoid::WGS84, 180, pose));
    }
}

#[test]
fn across_the_antimeridian_and_over_the_poles() {
    let features = [
        polygon("strip", "[[170,-10],[190,-10],[190,10],[170,10],[170,-10]]"),
        polygon(
            "north",
            "[[-180,80],[-90,75],[0,80],[90,75],[180,80],[180,90],[-180,90],[-180,80]]",
        ),
        polygon(
            "south",
            "[[-180,-90],[180,-90],[180,-70],[60,-75],[-60,-65],[-180,-70],[-180,-90]]",
        ),
    ];
    let text = collection(&features);
    for (name, pose) in [
        ("antimeridian", (178.0, 3.0, 3e6, 0.0, -90.0)),
        ("antimeridian, low", (-179.0, -10.5, 2e4, 350.0, -10.0)),
        ("north pole", (20.0, 89.0, 4e6, 0.0, -90.0)),
        ("over the pole, low", (20.0, 80.5, 2e4, 180.0, -8.0)),
        ("south pole", (20.0, -89.0, 4e6, 0.0, -90.0)),
    ] {
        assert_all_variants_pass(name, &input(&text, Ellipsoid::WGS84, 180, pose));
    }
}

#[test]
fn a_ten_metre_square_from_fifty_metres() {
    // 10 m are 1.39e-4 degrees of longitude and 9e-5 of latitude here.
    let text = polygon(
        "square",
        "[[10.0,50.0],[10.000139,50.0],[10.000139,50.00009],[10.0,50.00009],[10.0,50.0]]",
    );
    let pose = (10.00007, 50.000045, 50.0, 0.0, -90.0);
    // The 1° grid hangs hundreds of metres below the ellipsoid; a fine one keeps the surface near.
    assert_all_variants_pass("ten metres", &input(&text, Ellipsoid::WGS84, 720, pose));
}

#[test]
fn other_bodies() {
    let text = polygon("patch", "[[-20,-10],[25,-15],[30,40],[-5,35],[-20,-10]]");
    for (body, height) in [
        (Ellipsoid::MOON, 2e6),
        (Ellipsoid::MARS, 4e6),
        (Ellipsoid::SATURN_LIKE, 8e7),
        (Ellipsoid::UNIT_SPHERE, 1.5),
        (Ellipsoid::ASTEROID_250M, 400.0),
    ] {
        let input = input(&text, body, 180, (5.0, 10.0, height, 0.0, -90.0));
        assert_all_variants_pass(body.name(), &input);
    }
}

/// Every combination of switches that a scene of disjoint regions allows.
fn all_switches() -> Vec<Switches> {
    let mut all = Vec::new();
    for colour in ColourWay::ALL {
        for faces in [FacePasses::TwoSided, FacePasses::TwoPass] {
            for depth_rule in [DepthRuleChoice::Fail, DepthRuleChoice::Automatic] {
                for bottom_cap in [BottomCap::Always, BottomCap::WhereNeeded] {
                    for flags in 0..8 {
                        all.push(Switches {
                            colour,
                            faces,
                            depth_rule,
                            bottom_cap,
                            scissor: flags & 1 != 0,
                            cover_culls_faces: flags & 2 != 0,
                            stencil_clear: if flags & 4 != 0 {
                                StencilClear::ByColour
                            } else {
                                StencilClear::AtStart
                            },
                            ..Switches::default()
                        });
                    }
                }
            }
        }
    }
    all.retain(|switches| switches.check(Overlap::Disjoint).is_ok());
    all
}

#[test]
fn no_switch_changes_a_pixel() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    // From above; close above a border; and inside the volumes, below their tops.
    let poses = [
        (7.0, 5.0, 3e6, 0.0, -90.0),
        (4.9, 4.0, 2e4, 10.0, -30.0),
        (4.95, 5.0, 400.0, 80.0, -5.0),
    ];
    for (place, pose) in poses.into_iter().enumerate() {
        let input = input(&three_regions(), Ellipsoid::WGS84, 180, pose);
        let judged = ReferenceBackend::new().judge(&input).expect("judges").frame;
        let by_vertex = draw_by_vertex(&gpu, &input, Switches::default());
        let mask = filled_only(&by_vertex).ids;
        // One stage for all: making targets takes longer than drawing into them.
        let stage = Stage::shared(&gpu, SIZE).expect("small targets");
        let variants = all_variants();
        let mut count = 0;
        // Every other combination of switches here, the rest at the next place, each with one of
        // the expansions and cullings, which take turns.
        let all = all_switches().into_iter().enumerate();
        for (index, switches) in all.skip(place % 2).step_by(2) {
            let variant = ComputeVariant {
                switches,
                ..variants[index % variants.len()]
            };
            let mut backend = ComputeBackend::new(&stage, variant).expect("valid shaders");
            backend.prepare(&input).expect("fits");
            let frame = backend.render(&input).expect("draws");
            let name = variant.name();
            assert_eq!(filled_only(&frame).ids, mask, "{pose:?} {name}");
            if switches.colour.tells_regions_apart() {
                assert_eq!(frame.ids, by_vertex.ids, "{pose:?} {name}");
                assert!(is_right(&judged, &frame), "{pose:?} {name}");
            }
            count += 1;
        }
        assert!(count >= 100, "{count}");
    }
}

#[test]
fn counting_in_front_is_wrong_from_inside_and_the_automatic_rule_knows() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let pose = (5.0, 9.0, 300.0, 0.0, -5.0);
    let input = input(&square(), Ellipsoid::WGS84, 180, pose);
    assert!(input.plan.regions[0].near_plane_meets_volume);
    let judged = ReferenceBackend::new().judge(&input).expect("judges").frame;
    for (depth_rule, right) in [
        (DepthRuleChoice::Automatic, true),
        (DepthRuleChoice::Fail, true),
        (DepthRuleChoice::Pass, false),
    ] {
        for variant in all_variants() {
            let switches = Switches {
                depth_rule,
                ..Switches::default()
            };
            let frame = draw(
                &gpu,
                &input,
                ComputeVariant {
                    switches,
                    ..variant
                },
            );
            let name = variant.name();
            assert_eq!(is_right(&judged, &frame), right, "{depth_rule:?} {name}");
        }
    }
}

#[test]
fn broken_volumes_are_noticed() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    type Mutation = fn(&mut RegionMesh);
    let mutants: [(&str, Mutation); 4] = [
        ("none", |_| {}),
        ("half the caps missing", |mesh| {
            mesh.triangles.truncate(mesh.triangles.len() / 2);
        }),
        ("walls missing", |mesh| {
            mesh.boundary_loops.clear();
        }),
        ("vertices pushed 50 km east", |mesh| {
            for vertex in &mut mesh.vertices_ecef {
                vertex.y += 5e4;
            }
        }),
    ];
    for (name, change) in mutants {
        let pose = (5.0, -1.0, 2e4, 0.0, -15.0);
        let mut input = input(&square(), Ellipsoid::WGS84, 180, pose);
        let judged = ReferenceBackend::new().judge(&input).expect("judges").frame;
        let mut meshes = input.scene.meshes.to_vec();
        change(&mut meshes[0]);
        input.scene.meshes = meshes.into();
        for variant in all_variants() {
            let frame = draw(&gpu, &input, variant);
            let right = is_right(&judged, &frame);
            assert_eq!(right, name == "none", "{name}, {}", variant.name());
        }
    }
}

/// planet-134 with its views.
fn planet() -> (PreparedScene, Vec<View>) {
    let scene = open_scene("planet-134", None).expect("ships with the project");
    let meshes = RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &scene.mesh)
        .expect("meshes");
    let surface = Arc::new(SurfaceMesh::ellipsoid(&scene.body, scene.surface_rows));
    let prepared = PreparedScene::new(&scene, meshes.into(), surface);
    (prepared, scene.views)
}

const NOTHING_LEFT_OUT: PlanOptions = PlanOptions {
    frustum_culling: false,
    horizon_culling: false,
    too_small_culling: false,
    boundary_lod_px: None,
};

#[test]
fn culling_on_the_device_changes_no_pixel_and_leaves_out_what_the_plan_would() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let (prepared, views) = planet();
    for view in &views {
        let planned = FrameInput::new(&prepared, view, SIZE, PlanOptions::default());
        let everything = planned.remeshed(&prepared, NOTHING_LEFT_OUT);
        assert!(planned.plan.regions.len() < everything.plan.regions.len());
        let uncut = draw(&gpu, &everything, ComputeVariant::default());
        let by_vertex = draw_by_vertex(&gpu, &planned, Switches::default());
        assert_eq!(uncut.ids, by_vertex.ids, "{}", view.name);
        // Regions that the plan leaves out for reasons that the device knows as well.
        let exact = |reason| reason != LeftOutReason::TooSmall;
        let left_out = planned.plan.left_out.iter();
        let plan_leaves = left_out.filter(|region| exact(region.reason)).count();
        for variant in all_variants() {
            let what = format!("{} {}", view.name, variant.name());
            let mut backend = backend(&gpu, SIZE, variant);
            backend.prepare(&everything).expect("fits");
            let frame = backend.render(&everything).expect("draws");
            assert_eq!(frame.ids, uncut.ids, "{what}");
            if variant.culling == GpuCulling::Off {
                assert_eq!(counters(&frame).vertices, counters(&uncut).vertices);
                continue;
            }
            assert!(
                counters(&frame).vertices < counters(&uncut).vertices,
                "{what}"
            );
            let left = backend.regions_left_out().expect("reads back");
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
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    if !gpu.facts.features.pipeline_statistics {
        eprintln!("skipped: no pipeline statistics");
        return;
    }
    let pose = (9.5, 5.0, 2e4, 90.0, -30.0);
    let input = input(&square(), Ellipsoid::WGS84, 180, pose);
    for colour in [ColourWay::Xor, ColourWay::IdAccumulation] {
        let switches = Switches {
            colour,
            ..Switches::default()
        };
        let by_vertex = counters(&draw_by_vertex(&gpu, &input, switches)).stencil_fragments;
        assert!(by_vertex > Some(0), "{colour:?}: {by_vertex:?}");
        for variant in all_variants() {
            let variant = ComputeVariant {
                switches,
                ..variant
            };
            let found = counters(&draw(&gpu, &input, variant)).stencil_fragments;
            assert_eq!(found, by_vertex, "{}", variant.name());
        }
    }
}

#[test]
fn culling_pieces_leaves_out_more_than_culling_regions() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let pose = (9.5, 5.0, 2e4, 90.0, -30.0);
    let input = input(&square(), Ellipsoid::WGS84, 180, pose);
    let vertices = |culling| counters(&draw(&gpu, &input, with_culling(culling))).vertices;
    let whole = vertices(GpuCulling::Off);
    assert_eq!(vertices(GpuCulling::Regions), whole);
    let pieces = vertices(GpuCulling::Triangles);
    assert!(pieces * 2 < whole, "{pieces} of {whole}");
    assert!(pieces > 0);
}

/// Twin of the above: boxes on the far side of the body take their regions with them.
#[test]
fn culling_by_wrong_boxes_is_noticed() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let pose = (7.0, 5.0, 3e6, 0.0, -90.0);
    let mut input = input(&three_regions(), Ellipsoid::WGS84, 180, pose);
    let right = draw(&gpu, &input, ComputeVariant::default());
    let mut bounds = input.scene.bounds.to_vec();
    for region in &mut bounds {
        region.bounds.center_ecef = -region.bounds.center_ecef;
    }
    input.scene.bounds = bounds.into();
    for variant in all_variants() {
        let frame = draw(&gpu, &input, variant);
        let is_blind = variant.culling == GpuCulling::Off;
        assert_eq!(frame.ids == right.ids, is_blind, "{}", variant.name());
        assert_eq!(frame.filled_px() == 0, !is_blind, "{}", variant.name());
    }
}

/// A frame drawn within `capacity`.
fn draw_within(
    gpu: &Arc<Gpu>,
    input: &FrameInput,
    variant: ComputeVariant,
    capacity: Capacity,
) -> Result<Frame, BackendError> {
    let stage = Stage::shared(gpu, input.size).expect("small targets");
    let mut backend = ComputeBackend::with_capacity(&stage, variant, capacity)?;
    backend.prepare(input)?;
    backend.render(input)
}

#[test]
fn too_much_is_refused_with_numbers_and_just_enough_is_drawn() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let pose = (7.0, 5.0, 3e6, 0.0, -90.0);
    let input = input(&three_regions(), Ellipsoid::WGS84, 180, pose);
    let device = Capacity::of(&gpu.device.limits());
    let output: u64 = input
        .scene
        .meshes
        .iter()
        .map(|mesh| compute_bytes(mesh).output_index_bytes)
        .sum();
    for variant in all_variants() {
        let name = variant.name();
        let within = |capacity| draw_within(&gpu, &input, variant, capacity);
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
                Err(BackendError::OverCapacity { found, allowed, .. }) => {
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
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let stage = Stage::shared(&gpu, SIZE).expect("small targets");
    let variant = ComputeVariant {
        expansion: Expansion::Cached,
        ..with_culling(GpuCulling::Triangles)
    };
    let error = ComputeBackend::new(&stage, variant).expect_err("views differ");
    assert!(error.to_string().contains("gpu-culling"), "{error}");
}

#[test]
fn bytes_are_those_of_the_formula() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let pose = (7.0, 5.0, 3e6, 0.0, -90.0);
    let input = input(&three_regions(), Ellipsoid::WGS84, 180, pose);
    for variant in all_variants() {
        let mut formula: terrafill_compute::ComputeBytes =
            input.scene.meshes.iter().map(compute_bytes).sum();
        if variant.transform == Transform::ComputeStage {
            formula.output_vertex_bytes = input.scene.meshes.iter().map(placed_bytes).sum();
        }
        let mut backend = backend(&gpu, SIZE, variant);
        let memory = backend.prepare(&input).expect("fits");
        assert_eq!(backend.bytes(), formula, "{}", variant.name());
        assert_eq!(memory.geometry_bytes(), formula.total());
        assert!(memory.upload_bytes < formula.total(), "only input goes up");
        assert!(memory.upload_bytes > formula.input());
    }
}

#[test]
fn nothing_in_view_draws_nothing() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let pose = (-150.0, 5.0, 3e5, 0.0, -90.0);
    let empty = input(&square(), Ellipsoid::WGS84, 180, pose);
    assert!(empty.plan.regions.is_empty());
    for variant in all_variants() {
        let mut backend = backend(&gpu, SIZE, variant);
        backend.prepare(&empty).expect("fits");
        let frame = backend.render(&empty).expect("draws");
        assert_eq!((frame.filled_px(), counters(&frame).draws), (0, 0));
        backend.time_frame(&empty).expect("draws");
    }
}

#[test]
fn a_frame_needs_preparing_and_an_unchanged_one_makes_and_uploads_nothing() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let pose = (5.0, 5.0, 2e6, 0.0, -90.0);
    let first = input(&square(), Ellipsoid::WGS84, 180, pose);
    let other = input(&square(), Ellipsoid::WGS84, 180, pose);
    for variant in all_variants() {
        let mut backend = backend(&gpu, SIZE, variant);
        let error = backend.render(&first).expect_err("not prepared");
        assert_eq!(error.to_string(), "compute was not prepared for test/test");
        assert!(backend.time_frame(&first).is_err());
        backend.prepare(&first).expect("fits");
        let frame = backend.render(&first).expect("draws");
        assert!(backend.render(&other).is_err(), "another input");
        let before = gpu.work_done();
        let times = backend.time_frame(&first).expect("draws");
        assert_eq!(gpu.work_done(), before, "{}", variant.name());
        assert_eq!(times.fill_gpu_ms.is_some(), gpu.facts.features.timestamps);
        let again = backend.render(&first).expect("draws");
        assert_eq!(frame.ids, again.ids);
        let steady = counters(&again);
        assert_eq!((steady.uploads, steady.upload_bytes), (0, 0));
        assert_eq!((steady.buffer_creations, steady.pipeline_creations), (0, 0));
        // Twin: preparing does make and upload something, and is counted.
        let before = gpu.work_done();
        backend.prepare(&other).expect("fits");
        let made = gpu.work_done() - before;
        assert!(made.buffer_creations > 0 && made.uploads > 0);
        let prepared = counters(&backend.render(&other).expect("draws"));
        assert!(prepared.buffer_creations > 0 && prepared.uploads > 0);
    }
}

#[test]
fn the_picture_has_the_regions_colours_and_leaves_the_ids_alone() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let pose = (7.0, 5.0, 3e6, 0.0, -90.0);
    let input = input(&three_regions(), Ellipsoid::WGS84, 180, pose);
    for variant in all_variants() {
        let mut backend = backend(&gpu, SIZE, variant);
        backend.prepare(&input).expect("fits");
        let before = backend.render(&input).expect("draws");
        let picture = backend.picture(&input).expect("draws");
        let filled = picture.rgba.chunks(4).filter(|pixel| pixel[3] != 0).count();
        assert_eq!(filled as u64, before.filled_px(), "{}", variant.name());
        let after = backend.render(&input).expect("draws");
        assert_eq!(before.ids, after.ids);
    }
}
