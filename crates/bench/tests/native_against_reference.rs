// SPDX-License-Identifier: MIT OR Apache-2.0
//! The native backend held against the reference and, to the pixel, against the vertex backend:
//! every technique, way of colouring and depth rule on extreme regions and views; its bytes; its
//! steady state; and the twins that must be noticed.
//!
//! Without a Vulkan device these tests are skipped with the reason printed, unless
//! `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does.

use std::sync::Arc;
use terrafill_bench::open_scene;
use terrafill_conformance::{compare, filled_only, verdict};
use terrafill_core::{EdgeRule, Ellipsoid, Geodetic, MeshOptions, RegionMesh, parse_regions};
use terrafill_frame::{
    Backend as _, BackendError, BottomCap, ColourWay, Counters, DepthRuleChoice, FacePasses, Frame,
    FrameInput, PreparedScene, StencilClear, Switches, TimedBackend as _, VolumeBackend as _,
};
use terrafill_native::{
    NativeBackend, NativeVariant, Technique, depth_range, native_bytes, walls_with_other_diagonal,
};
use terrafill_reference::ReferenceBackend;
use terrafill_results::ErrorFigures;
use terrafill_scene::{
    CameraPose, ImageSize, Overlap, PlanOptions, SurfaceMesh, View, data_dir_from_env,
};
use terrafill_vertex::{Layout, VertexBackend, VertexVariant, layout_bytes};

const SIZE: ImageSize = ImageSize {
    width: 384,
    height: 384,
};

/// The same device twice: through wgpu and through Vulkan itself.
struct Devices {
    wgpu: Arc<terrafill_gpu::Gpu>,
    vulkan: Arc<terrafill_vulkan::Gpu>,
}

fn devices() -> Option<Devices> {
    Some(Devices {
        wgpu: terrafill_gpu::open_for_test(&Default::default())?,
        vulkan: terrafill_vulkan::open_for_test(&Default::default())?,
    })
}

#[test]
fn both_ways_open_the_same_adapter() {
    let Some(Devices { wgpu, vulkan }) = devices() else {
        return;
    };
    let (a, b) = (&wgpu.facts, &vulkan.facts);
    assert_eq!((&a.name, a.device_type), (&b.name, b.device_type));
    assert_eq!((a.vendor_id, a.device_id), (b.vendor_id, b.device_id));
    assert_eq!((&a.driver, &a.driver_info), (&b.driver, &b.driver_info));
    assert_eq!(a.features.timestamps, b.features.timestamps);
    assert_eq!(
        a.features.pipeline_statistics,
        b.features.pipeline_statistics
    );
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

fn draw(gpu: &Arc<terrafill_vulkan::Gpu>, input: &FrameInput, variant: NativeVariant) -> Frame {
    let stage = terrafill_vulkan::Stage::shared(gpu, input.size).expect("small targets");
    let mut backend = NativeBackend::new(&stage, variant).expect("has the features");
    backend.prepare(input).expect("fits");
    backend.render(input).expect("draws")
}

fn draw_by_vertex(gpu: &Arc<terrafill_gpu::Gpu>, input: &FrameInput, switches: Switches) -> Frame {
    let stage = terrafill_gpu::Stage::shared(gpu, input.size).expect("small targets");
    let variant = VertexVariant {
        switches,
        ..VertexVariant::default()
    };
    let mut backend = VertexBackend::new(&stage, variant).expect("valid shaders");
    backend.prepare(input).expect("fits");
    backend.render(input).expect("draws")
}

fn figures(reference: &Frame, frame: &Frame) -> ErrorFigures {
    compare(reference, frame).expect("same size")
}

fn with(technique: Technique, switches: Switches) -> NativeVariant {
    NativeVariant {
        technique,
        switches,
    }
}

fn plain(technique: Technique) -> NativeVariant {
    with(technique, Switches::default())
}

/// Pixels that differ.
fn differing(a: &Frame, b: &Frame) -> usize {
    assert_eq!(a.ids.len(), b.ids.len());
    a.ids.iter().zip(&b.ids).filter(|(a, b)| a != b).count()
}

/// Every way of colouring with every depth rule that is right everywhere.
fn ways_and_rules() -> Vec<Switches> {
    let mut all = Vec::new();
    for colour in ColourWay::ALL {
        for depth_rule in [DepthRuleChoice::Fail, DepthRuleChoice::Automatic] {
            all.push(Switches {
                colour,
                depth_rule,
                ..Switches::default()
            });
        }
    }
    all
}

/// Every technique passes, is the vertex backend's picture to the pixel, and the view has both
/// filled and empty surface in it.
fn assert_all_techniques_pass(what: &str, input: &FrameInput) {
    let Some(devices) = devices() else {
        return;
    };
    let judged = ReferenceBackend::new().judge(input).expect("judges");
    let filled = judged.frame.filled_px();
    let surface = judged.frame.surface.iter().filter(|&&is| is).count() as u64;
    assert!(filled > 100, "{what}: only {filled} pixels are filled");
    assert!(filled + 100 < surface, "{what}: no boundary in sight");
    let is_behind = |&ecef| input.camera.project_px(input.size, ecef).is_none();
    let is_clipped = input
        .scene
        .meshes
        .iter()
        .any(|mesh| mesh.vertices_ecef.iter().any(is_behind));
    for switches in ways_and_rules() {
        let vertex = draw_by_vertex(&devices.wgpu, input, switches);
        for technique in Technique::ALL {
            let variant = with(technique, switches);
            let frame = draw(&devices.vulkan, input, variant);
            let name = variant.name();
            let (judged, frame, vertex) = if switches.colour.tells_regions_apart() {
                (judged.frame.clone(), frame, vertex.clone())
            } else {
                // Which of several volumes over a pixel brings the colour is a matter of order.
                (
                    filled_only(&judged.frame),
                    filled_only(&frame),
                    filled_only(&vertex),
                )
            };
            let found = figures(&judged, &frame);
            let verdict = verdict(&found);
            let differ = differing(&frame, &vertex);
            // An inner wall that the near plane clips becomes a fan around another corner when it
            // is turned over, and the two fans' depths differ in the last bit: where the surface
            // lies between them, a pixel is counted once; `vertex/per-triangle` has it too.
            let is_cracked = technique == Technique::GsPerTriangle
                && is_clipped
                && found.mismatched_px_outside_band <= 4
                && differ <= 4;
            assert!(
                (verdict.is_pass() && differ == 0) || is_cracked,
                "{what}, {name}: {verdict:?}, {differ} pixels differ from vertex"
            );
            assert_eq!(frame.surface, vertex.surface, "{what}, {name}");
        }
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
        let input = input(&text, Ellipsoid::WGS84, 180, pose);
        assert_all_techniques_pass(name, &input);
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
        let input = input(&text, Ellipsoid::WGS84, 180, pose);
        assert_all_techniques_pass(name, &input);
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
    let input = input(&text, Ellipsoid::WGS84, 720, pose);
    assert_all_techniques_pass("ten metres", &input);
}

#[test]
fn other_bodies() {
    let text = polygon("patch", "[[-20,-10],[25,-15],[30,40],[-5,35],[-20,-10]]");
    for (body, height) in [
        (Ellipsoid::MOON, 2e6),
        (Ellipsoid::SATURN_LIKE, 8e7),
        (Ellipsoid::UNIT_SPHERE, 1.5),
        (Ellipsoid::ASTEROID_250M, 400.0),
    ] {
        let input = input(&text, body, 180, (5.0, 10.0, height, 0.0, -90.0));
        assert_all_techniques_pass(body.name(), &input);
    }
}

/// A shipped scene, or why it is skipped.
fn prepared(name: &str) -> Option<(PreparedScene, Vec<View>)> {
    let scene = match open_scene(name, data_dir_from_env().as_deref()) {
        Ok(scene) => scene,
        Err(error) => {
            eprintln!("skipped: {error}");
            return None;
        }
    };
    let meshes = RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &scene.mesh)
        .expect("meshes");
    let surface = Arc::new(SurfaceMesh::ellipsoid(&scene.body, scene.surface_rows));
    Some((
        PreparedScene::new(&scene, meshes.into(), surface),
        scene.views.clone(),
    ))
}

#[test]
fn shipped_scenes_and_real_countries() {
    let Some(devices) = devices() else {
        return;
    };
    for name in ["california", "planet-134", "countries-110m"] {
        let Some((prepared, views)) = prepared(name) else {
            continue;
        };
        for view in &views {
            let input = FrameInput::new(&prepared, view, SIZE, PlanOptions::default());
            let switches = Switches::for_overlap(prepared.overlap);
            let judged = ReferenceBackend::new().judge(&input).expect("judges").frame;
            let vertex = draw_by_vertex(&devices.wgpu, &input, switches);
            for technique in Technique::ALL {
                let frame = draw(&devices.vulkan, &input, with(technique, switches));
                let what = format!("{name}/{}/{}", view.name, technique.name());
                let found = figures(&judged, &frame);
                let verdict = verdict(&found);
                assert!(verdict.is_pass(), "{what}: {verdict:?} {found:?}");
                assert_eq!(differing(&frame, &vertex), 0, "{what}");
            }
        }
    }
}

/// Thousands of borders that two countries share, with numbers that descend along many of them. What
/// makes it pass is how vertices are numbered; that numbers as they come fail is shown where they
/// are given.
#[test]
fn volumes_of_single_triangles_leave_no_sliver_between_neighbours() {
    let Some(devices) = devices() else {
        return;
    };
    for name in ["planet-134", "us-states", "countries-110m", "countries-50m"] {
        let Some((prepared, views)) = prepared(name) else {
            continue;
        };
        for mesh in &*prepared.meshes {
            assert_eq!(walls_with_other_diagonal(mesh), 0, "{name}, {}", mesh.name);
        }
        let Some(view) = views.iter().find(|view| view.name == "globe") else {
            continue;
        };
        let size = ImageSize {
            width: 512,
            height: 512,
        };
        let input = FrameInput::new(&prepared, view, size, PlanOptions::default());
        let switches = Switches::for_overlap(prepared.overlap);
        let vertex = draw_by_vertex(&devices.wgpu, &input, switches);
        let variant = with(Technique::GsPerTriangle, switches);
        let frame = draw(&devices.vulkan, &input, variant);
        assert!(frame.filled_px() > 1000, "{name}");
        assert_eq!(differing(&frame, &vertex), 0, "{name}");
    }
}

/// Every switch that changes what a program does, each on its own and all that go together.
fn some_switches() -> Vec<Switches> {
    let base = Switches::default();
    let rectangle = Switches {
        colour: ColourWay::Rectangle,
        ..base
    };
    let accumulated = Switches {
        colour: ColourWay::IdAccumulation,
        ..base
    };
    let by_volume = Switches {
        colour: ColourWay::Volume,
        ..base
    };
    let where_needed = Switches {
        bottom_cap: BottomCap::WhereNeeded,
        depth_rule: DepthRuleChoice::Automatic,
        ..base
    };
    vec![
        Switches {
            faces: FacePasses::TwoPass,
            ..base
        },
        Switches {
            scissor: true,
            ..base
        },
        Switches {
            faces: FacePasses::TwoPass,
            scissor: true,
            ..accumulated
        },
        Switches {
            bottom_cap: BottomCap::WhereNeeded,
            depth_rule: DepthRuleChoice::Automatic,
            ..accumulated
        },
        where_needed,
        Switches {
            colour: ColourWay::Rectangle,
            ..where_needed
        },
        Switches {
            stencil_clear: StencilClear::ByColour,
            ..rectangle
        },
        Switches {
            cover_culls_faces: true,
            ..by_volume
        },
        Switches {
            cover_culls_faces: true,
            stencil_clear: StencilClear::ByColour,
            faces: FacePasses::TwoPass,
            scissor: true,
            colour: ColourWay::Volume,
            ..where_needed
        },
    ]
}

/// Two neighbours with a common border and a third region apart from them.
fn three_regions() -> String {
    collection(&[
        polygon("west", "[[0,0],[4,0],[6,10],[0,10],[0,0]]"),
        polygon("east", "[[4,0],[10,0],[10,10],[6,10],[4,0]]"),
        polygon("far", "[[12,2],[14,2],[14,4],[12,4],[12,2]]"),
    ])
}

/// From above; close above a border; and inside the volumes, below their tops.
const POSES: [Pose; 3] = [
    (7.0, 5.0, 3e6, 0.0, -90.0),
    (4.9, 4.0, 2e4, 10.0, -30.0),
    (4.95, 5.0, 400.0, 80.0, -5.0),
];

#[test]
fn no_switch_changes_a_pixel() {
    let Some(devices) = devices() else {
        return;
    };
    for pose in POSES {
        let input = input(&three_regions(), Ellipsoid::WGS84, 180, pose);
        let first = draw_by_vertex(&devices.wgpu, &input, Switches::default());
        for technique in Technique::ALL {
            for switches in some_switches() {
                let variant = with(technique, switches);
                let frame = draw(&devices.vulkan, &input, variant);
                assert_eq!(differing(&frame, &first), 0, "{pose:?} {}", variant.name());
            }
        }
    }
}

#[test]
fn counting_in_front_is_wrong_from_inside_and_the_automatic_rule_knows() {
    let Some(devices) = devices() else {
        return;
    };
    let pose = (5.0, 9.0, 300.0, 0.0, -5.0);
    let input = input(&square(), Ellipsoid::WGS84, 180, pose);
    assert!(input.plan.regions[0].near_plane_meets_volume);
    let judged = ReferenceBackend::new().judge(&input).expect("judges").frame;
    for technique in Technique::ALL {
        for (depth_rule, is_right) in [
            (DepthRuleChoice::Automatic, true),
            (DepthRuleChoice::Fail, true),
            (DepthRuleChoice::Pass, false),
        ] {
            let switches = Switches {
                depth_rule,
                ..Switches::default()
            };
            let variant = with(technique, switches);
            let found = figures(&judged, &draw(&devices.vulkan, &input, variant));
            let passes = verdict(&found).is_pass();
            assert_eq!(passes, is_right, "{}: {found:?}", variant.name());
        }
    }
}

#[test]
fn broken_volumes_are_noticed() {
    let Some(devices) = devices() else {
        return;
    };
    type Mutation = fn(&mut RegionMesh);
    let mutants: [(&str, Mutation); 6] = [
        ("none", |_| {}),
        ("half the caps missing", |mesh| {
            mesh.triangles.truncate(mesh.triangles.len() / 2);
        }),
        ("walls missing", |mesh| {
            mesh.boundary_loops.clear();
        }),
        ("walls turned over", |mesh| {
            for ring in &mut mesh.boundary_loops {
                ring.reverse();
            }
        }),
        ("caps turned over", |mesh| {
            for [_, b, c] in &mut mesh.triangles {
                std::mem::swap(b, c);
            }
        }),
        ("vertices pushed 50 km east", |mesh| {
            for vertex in &mut mesh.vertices_ecef {
                vertex.y += 5e4;
            }
        }),
    ];
    let pose = (5.0, -1.0, 2e4, 0.0, -15.0);
    for (name, change) in mutants {
        let mut input = input(&square(), Ellipsoid::WGS84, 180, pose);
        let judged = ReferenceBackend::new().judge(&input).expect("judges").frame;
        let mut meshes = input.scene.meshes.to_vec();
        change(&mut meshes[0]);
        input.scene.meshes = meshes.into();
        for technique in Technique::ALL {
            // Counting notices which way a face looks.
            let switches = Switches {
                colour: ColourWay::Rectangle,
                ..Switches::default()
            };
            let found = figures(
                &judged,
                &draw(&devices.vulkan, &input, with(technique, switches)),
            );
            let passes = verdict(&found).is_pass();
            let is_whole = name == "none";
            // These walls come from triangles: the loops are not asked, and a volume that is turned
            // over as a whole counts −1, which is not 0 either.
            let knows_no_loops = technique == Technique::GsPerTriangle
                && ["walls missing", "walls turned over", "caps turned over"].contains(&name);
            let what = format!("{name}, {}: {found:?}", technique.name());
            assert_eq!(passes, is_whole || knows_no_loops, "{what}");
        }
    }
}

#[test]
fn bytes_are_what_the_formula_says_and_at_most_half_of_doubled_vertices() {
    let Some(devices) = devices() else {
        return;
    };
    for name in ["planet-134", "countries-110m", "countries-50m"] {
        let Some((prepared, views)) = prepared(name) else {
            continue;
        };
        let input = FrameInput::new(&prepared, &views[0], SIZE, PlanOptions::default());
        let doubled: u64 = prepared
            .meshes
            .iter()
            .map(|mesh| layout_bytes(Layout::Doubled, mesh).total())
            .sum();
        for technique in Technique::ALL {
            let stage = terrafill_vulkan::Stage::shared(&devices.vulkan, SIZE).expect("small");
            let switches = Switches::for_overlap(prepared.overlap);
            let mut backend =
                NativeBackend::new(&stage, with(technique, switches)).expect("has the features");
            let memory = backend.prepare(&input).expect("fits");
            let formula: u64 = prepared
                .meshes
                .iter()
                .map(|mesh| native_bytes(technique, mesh).total())
                .sum();
            let what = format!("{name}, {}", technique.name());
            assert_eq!(memory.geometry_bytes(), formula, "{what}");
            assert_eq!(
                memory.upload_bytes,
                formula + memory.constant_bytes,
                "{what}"
            );
            let share = formula as f64 / doubled as f64;
            eprintln!("{what}: {formula} bytes, {share:.3} of vertex/doubled");
            match technique {
                Technique::VsControl => assert_eq!(formula, doubled, "{what}"),
                // Three indices an edge, or six a triangle: half, where a region has hardly a
                // vertex inside.
                Technique::GsDegenerate | Technique::GsAdjacency => {
                    assert!(share <= 0.51, "{what}: {share}");
                }
                _ => assert!(share <= 0.45, "{what}: {share}"),
            }
        }
    }
}

#[test]
fn a_frame_needs_preparing_and_a_second_unchanged_one_makes_nothing() {
    let Some(devices) = devices() else {
        return;
    };
    let pose = (5.0, 5.0, 2e6, 0.0, -90.0);
    let first = input(&square(), Ellipsoid::WGS84, 180, pose);
    let other = input(&square(), Ellipsoid::WGS84, 180, pose);
    for technique in Technique::ALL {
        let stage = terrafill_vulkan::Stage::shared(&devices.vulkan, SIZE).expect("small targets");
        let mut backend = NativeBackend::new(&stage, plain(technique)).expect("has the features");
        let error = backend.render(&first).expect_err("not prepared");
        assert_eq!(error.to_string(), "native was not prepared for test/test");
        assert!(backend.time_frame(&first).is_err());
        backend.prepare(&first).expect("fits");
        let counters = |backend: &mut NativeBackend| {
            let frame = backend.render(&first).expect("draws");
            (frame.ids, frame.counters.expect("a GPU backend counts"))
        };
        let (ids, start) = counters(&mut backend);
        let draws = if [Technique::VsControl, Technique::GsLine].contains(&technique) {
            3
        } else {
            2
        };
        assert_eq!((start.draws, start.upload_bytes), (draws, 0));
        assert_eq!((start.buffer_creations, start.uploads > 0), (4, true));
        assert_eq!(start.pipeline_creations, draws);
        // The same again, prepared once more.
        let made = devices.vulkan.work_done();
        let memory = backend.prepare(&first).expect("fits");
        assert_eq!(memory.upload_bytes, 0);
        let (ids_again, again) = counters(&mut backend);
        assert_eq!(devices.vulkan.work_done() - made, Default::default());
        assert_eq!(ids_again, ids);
        let nothing = Counters {
            buffer_creations: 0,
            pipeline_creations: 0,
            uploads: 0,
            ..start
        };
        assert_eq!(again, nothing, "{}", technique.name());
        assert!(backend.render(&other).is_err(), "another input");
        backend
            .time_frame(&first)
            .expect("the stage holds its surface");
        let mut second = NativeBackend::new(&stage, plain(technique)).expect("has the features");
        second.prepare(&other).expect("fits");
        second.draw_own_surface(&other).expect("draws");
        assert!(backend.time_frame(&first).is_err(), "over another surface");
        // Twin: a changed input makes something.
        backend.prepare(&other).expect("fits");
        assert!((devices.vulkan.work_done() - made).uploads > 0);
    }
}

#[test]
fn geometry_shaders_make_the_triangles_that_the_vertex_shader_is_given() {
    let Some(devices) = devices() else {
        return;
    };
    if !devices.vulkan.facts.features.pipeline_statistics {
        eprintln!("skipped: no pipeline statistics");
        return;
    }
    let pose = (5.0, 5.0, 2e6, 0.0, -90.0);
    let input = input(&three_regions(), Ellipsoid::WGS84, 180, pose);
    let meshes = input
        .plan
        .regions
        .iter()
        .map(|planned| &input.scene.meshes[planned.mesh]);
    let (mut caps, mut walls) = (0, 0);
    for mesh in meshes {
        caps += 2 * mesh.triangle_count() as u64;
        walls += 2 * mesh.boundary_edge_count() as u64;
    }
    for technique in Technique::ALL {
        let frame = draw(&devices.vulkan, &input, plain(technique));
        let counters = frame.counters.expect("a GPU backend counts");
        let expected = match technique {
            Technique::VsControl => 0,
            Technique::GsPerTriangle => 4 * caps,
            _ => caps + walls,
        };
        let made = counters.geometry_shader_primitives;
        assert_eq!(made, Some(expected), "{}", technique.name());
        let control = draw(&devices.vulkan, &input, plain(Technique::VsControl));
        let fragments = control.counters.expect("counts").stencil_fragments;
        assert!(fragments.is_some_and(|fragments| fragments > 0));
        if technique != Technique::GsPerTriangle {
            assert_eq!(
                counters.stencil_fragments,
                fragments,
                "{}",
                technique.name()
            );
        }
    }
}

#[test]
fn times_are_measured_and_pictures_in_the_regions_colours() {
    let Some(devices) = devices() else {
        return;
    };
    let pose = (5.0, 5.0, 2e6, 0.0, -90.0);
    let input = input(&three_regions(), Ellipsoid::WGS84, 180, pose);
    let stage = terrafill_vulkan::Stage::shared(&devices.vulkan, SIZE).expect("small targets");
    let mut backend = NativeBackend::new(&stage, NativeVariant::default()).expect("has them");
    assert_eq!(backend.variant_name(), "gs-degenerate");
    backend.prepare(&input).expect("fits");
    backend.draw_own_surface(&input).expect("draws");
    let times = backend.time_frame(&input).expect("draws");
    assert!(times.fill_cpu_ms > 0.0 && times.fill_wall_ms > 0.0);
    let parts = [times.stencil_gpu_ms, times.colour_gpu_ms, times.fill_gpu_ms];
    let timestamps = backend.capabilities().gpu_timestamps;
    assert!(parts.iter().all(|part| part.is_some() == timestamps));
    let frame = backend.render(&input).expect("draws");
    let picture = backend.picture(&input).expect("draws");
    let again = backend.render(&input).expect("draws");
    assert_eq!(frame.ids, again.ids, "the picture's colours are taken back");
    let filled = |alpha: &[u8]| alpha[3] == 255;
    let count = picture.rgba.chunks_exact(4).filter(|p| filled(p)).count() as u64;
    assert_eq!(count, frame.filled_px());
}

#[test]
fn what_the_device_lacks_is_refused_by_name() {
    let Some(devices) = devices() else {
        return;
    };
    let stage = terrafill_vulkan::Stage::shared(&devices.vulkan, SIZE).expect("small targets");
    let bounded = with(
        Technique::GsDegenerate,
        Switches {
            depth_bounds: true,
            ..Switches::default()
        },
    );
    assert_eq!(bounded.name(), "gs-degenerate,depth-bounds=on");
    match NativeBackend::new(&stage, bounded) {
        Err(BackendError::Unsupported { capability, .. }) => {
            assert_eq!(capability, "depthBounds");
            assert!(!devices.vulkan.facts.features.depth_bounds);
        }
        Err(other) => panic!("{other}"),
        Ok(_) => {
            assert!(devices.vulkan.facts.features.depth_bounds);
            for pose in POSES {
                let input = input(&three_regions(), Ellipsoid::WGS84, 180, pose);
                let with_bounds = draw(&devices.vulkan, &input, bounded);
                let without = draw(&devices.vulkan, &input, plain(Technique::GsDegenerate));
                assert_eq!(differing(&with_bounds, &without), 0, "{pose:?}");
            }
        }
    }
}

/// Whether every filled pixel's depth lies in the range of its region.
fn ranges_hold(input: &FrameInput, ids: &[u32], depth: &[f32], tightened: f32) -> bool {
    input.plan.regions.iter().all(|planned| {
        let range = depth_range(input, planned);
        let id = u32::try_from(planned.region).expect("few regions") + 1;
        let of_region = ids.iter().zip(depth).filter(|(found, _)| **found == id);
        of_region
            .into_iter()
            .all(|(_, depth)| range.low * tightened <= *depth && *depth <= range.high / tightened)
    })
}

#[test]
fn depth_bounds_hold_every_pixel_of_their_region() {
    let Some(devices) = devices() else {
        return;
    };
    let mut has_room = true;
    for pose in POSES {
        let input = input(&three_regions(), Ellipsoid::WGS84, 180, pose);
        let stage = terrafill_vulkan::Stage::shared(&devices.vulkan, SIZE).expect("small targets");
        let mut backend = NativeBackend::new(&stage, NativeVariant::default()).expect("has them");
        backend.prepare(&input).expect("fits");
        let ids = backend.render(&input).expect("draws").ids;
        let depth = stage.borrow().read().expect("reads").depth;
        assert!(ranges_hold(&input, &ids, &depth, 1.0), "{pose:?}");
        has_room &= ranges_hold(&input, &ids, &depth, 2.0);
    }
    assert!(!has_room, "the ranges say nothing");
}
