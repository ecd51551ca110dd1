// SPDX-License-Identifier: MIT OR Apache-2.0
//! The vertex backend held against the reference, every layout, position format and way of
//! colouring, on extreme regions and views; and the twins that must be noticed.
//!
//! Without a Vulkan device these tests are skipped with the reason printed, unless
//! `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does.

use std::sync::Arc;
use terrafill_bench::open_scene;
use terrafill_conformance::{compare, filled_only, verdict};
use terrafill_core::{EdgeRule, Ellipsoid, Geodetic, MeshOptions, RegionMesh, parse_regions};
use terrafill_frame::{
    Backend as _, BottomCap, ColourWay, DepthRuleChoice, FacePasses, Frame, FrameInput,
    PositionFormat, PreparedScene, StencilClear, Switches, TimedBackend as _,
};
use terrafill_gpu::{Gpu, GpuOptions, Stage, open_for_test};
use terrafill_reference::ReferenceBackend;
use terrafill_results::ErrorFigures;
use terrafill_scene::{
    CameraPose, ImageSize, Overlap, PlanOptions, SurfaceMesh, View, data_dir_from_env,
};
use terrafill_vertex::{Layout, VertexBackend, VertexVariant};

const SIZE: ImageSize = ImageSize {
    width: 384,
    height: 384,
};

fn all_variants() -> Vec<VertexVariant> {
    let mut variants = Vec::new();
    for layout in [Layout::Doubled, Layout::Pulled] {
        for positions in [PositionFormat::Fixed, PositionFormat::LocalF32] {
            for colour in [ColourWay::Xor, ColourWay::Rectangle] {
                variants.push(VertexVariant {
                    layout,
                    positions,
                    switches: with_colour(colour),
                });
            }
        }
    }
    variants
}

fn with_colour(colour: ColourWay) -> Switches {
    Switches {
        colour,
        ..Switches::default()
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

fn draw(gpu: &Arc<Gpu>, input: &FrameInput, variant: VertexVariant) -> Frame {
    let stage = Stage::shared(gpu, input.size).expect("small targets");
    let mut backend = VertexBackend::new(&stage, variant).expect("valid shaders");
    backend.prepare(input).expect("fits");
    backend.render(input).expect("draws")
}

fn figures(reference: &Frame, frame: &Frame) -> ErrorFigures {
    compare(reference, frame).expect("same size")
}

/// Every variant passes, and the view has both filled and empty surface in it.
fn assert_all_variants_pass(what: &str, input: &FrameInput) {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let judged = ReferenceBackend::new().judge(input).expect("judges");
    let filled = judged.frame.filled_px();
    let surface = judged.frame.surface.iter().filter(|&&is| is).count() as u64;
    assert!(filled > 100, "{what}: only {filled} pixels are filled");
    assert!(filled + 100 < surface, "{what}: no boundary in sight");
    for variant in all_variants() {
        let found = figures(&judged.frame, &draw(&gpu, input, variant));
        let verdict = verdict(&found);
        assert!(verdict.is_pass(), "{what}, {}: {verdict:?}", variant.name());
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
        assert_all_variants_pass(name, &input);
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
        assert_all_variants_pass(name, &input);
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
    assert_all_variants_pass("ten metres", &input);
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

#[test]
fn shipped_scenes_and_real_countries() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let data = data_dir_from_env();
    for name in ["california", "planet-134", "countries-110m"] {
        let scene = match open_scene(name, data.as_deref()) {
            Ok(scene) => scene,
            Err(error) => {
                eprintln!("skipped: {error}");
                continue;
            }
        };
        let meshes =
            RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &scene.mesh)
                .expect("meshes");
        let surface = Arc::new(SurfaceMesh::ellipsoid(&scene.body, scene.surface_rows));
        let prepared = PreparedScene::new(&scene, meshes.into(), surface);
        for view in &scene.views {
            let input = FrameInput::new(&prepared, view, SIZE, PlanOptions::default());
            let judged = ReferenceBackend::new().judge(&input).expect("judges");
            for layout in [Layout::Doubled, Layout::Pulled] {
                let variant = VertexVariant {
                    layout,
                    ..VertexVariant::default()
                };
                let found = figures(&judged.frame, &draw(&gpu, &input, variant));
                let verdict = verdict(&found);
                assert!(
                    verdict.is_pass(),
                    "{name}/{}/{}: {verdict:?} {found:?}",
                    view.name,
                    variant.name()
                );
            }
        }
    }
}

#[test]
fn culling_changes_no_pixel() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let scene = open_scene("planet-134", None).expect("ships with the project");
    let meshes = RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &scene.mesh)
        .expect("meshes");
    let surface = Arc::new(SurfaceMesh::ellipsoid(&scene.body, scene.surface_rows));
    let prepared = PreparedScene::new(&scene, meshes.into(), surface);
    for view in &scene.views {
        let culled = FrameInput::new(&prepared, view, SIZE, PlanOptions::default());
        let everything = culled.remeshed(
            &prepared,
            PlanOptions {
                frustum_culling: false,
                horizon_culling: false,
                too_small_culling: false,
                ..PlanOptions::default()
            },
        );
        assert!(culled.plan.regions.len() < everything.plan.regions.len());
        let variant = VertexVariant {
            switches: with_colour(ColourWay::Rectangle),
            ..VertexVariant::default()
        };
        let (a, b) = (
            draw(&gpu, &culled, variant),
            draw(&gpu, &everything, variant),
        );
        assert_eq!(a.ids, b.ids, "{}", view.name);
    }
}

/// A square seen obliquely, its volume broken by `change`, and what the reference says of it.
fn broken(change: fn(&mut RegionMesh)) -> (FrameInput, Frame) {
    let text = polygon("square", "[[0,0],[10,0],[10,10],[0,10],[0,0]]");
    let mut input = input(&text, Ellipsoid::WGS84, 180, (5.0, -1.0, 2e4, 0.0, -15.0));
    let judged = ReferenceBackend::new().judge(&input).expect("judges");
    let mut meshes = input.scene.meshes.to_vec();
    change(&mut meshes[0]);
    input.scene.meshes = meshes.into();
    (input, judged.frame)
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
        let (input, reference) = broken(change);
        for layout in [Layout::Doubled, Layout::Pulled] {
            let variant = VertexVariant {
                layout,
                ..VertexVariant::default()
            };
            let found = figures(&reference, &draw(&gpu, &input, variant));
            let passes = verdict(&found).is_pass();
            assert_eq!(passes, name == "none", "{name}, {layout:?}: {found:?}");
        }
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
                            depth_bounds: false,
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
    let text = collection(&[
        polygon("west", "[[0,0],[4,0],[6,10],[0,10],[0,0]]"),
        polygon("east", "[[4,0],[10,0],[10,10],[6,10],[4,0]]"),
        polygon("far", "[[12,2],[14,2],[14,4],[12,4],[12,2]]"),
    ]);
    // From above; close above a border; and inside the volumes, below their tops.
    let poses = [
        (7.0, 5.0, 3e6, 0.0, -90.0),
        (4.9, 4.0, 2e4, 10.0, -30.0),
        (4.95, 5.0, 400.0, 80.0, -5.0),
    ];
    for pose in poses {
        let input = input(&text, Ellipsoid::WGS84, 180, pose);
        let judged = ReferenceBackend::new().judge(&input).expect("judges").frame;
        let first = draw(&gpu, &input, VertexVariant::default());
        assert!(verdict(&figures(&judged, &first)).is_pass(), "{pose:?}");
        let mask = filled_only(&first).ids;
        let mut count = 0;
        for layout in [Layout::Doubled, Layout::Pulled] {
            for switches in all_switches() {
                let variant = VertexVariant {
                    layout,
                    switches,
                    ..VertexVariant::default()
                };
                let frame = draw(&gpu, &input, variant);
                let name = variant.name();
                assert_eq!(filled_only(&frame).ids, mask, "{pose:?} {name}");
                if switches.colour.tells_regions_apart() {
                    let found = figures(&judged, &frame);
                    assert!(verdict(&found).is_pass(), "{pose:?} {name}: {found:?}");
                }
                count += 1;
            }
        }
        assert!(count > 300, "{count}");
    }
}

#[test]
fn counting_in_front_is_wrong_from_inside_and_the_automatic_rule_knows() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let text = polygon("square", "[[0,0],[10,0],[10,10],[0,10],[0,0]]");
    let input = input(&text, Ellipsoid::WGS84, 180, (5.0, 9.0, 300.0, 0.0, -5.0));
    assert!(input.plan.regions[0].near_plane_meets_volume);
    let judged = ReferenceBackend::new().judge(&input).expect("judges").frame;
    let with_rule = |depth_rule| VertexVariant {
        switches: Switches {
            depth_rule,
            ..Switches::default()
        },
        ..VertexVariant::default()
    };
    for (rule, is_right) in [
        (DepthRuleChoice::Automatic, true),
        (DepthRuleChoice::Fail, true),
        (DepthRuleChoice::Pass, false),
    ] {
        let found = figures(&judged, &draw(&gpu, &input, with_rule(rule)));
        assert_eq!(verdict(&found).is_pass(), is_right, "{rule:?}: {found:?}");
    }
}

#[test]
fn xor_is_wrong_where_regions_overlap_and_one_at_a_time_is_right() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let text = collection(&[
        polygon("under", "[[0,0],[10,0],[10,10],[0,10],[0,0]]"),
        polygon("over", "[[5,5],[15,5],[15,15],[5,15],[5,5]]"),
    ]);
    let input = input(&text, Ellipsoid::WGS84, 180, (7.0, 7.0, 3e6, 0.0, -90.0));
    let judged = ReferenceBackend::new().judge(&input).expect("judges");
    for (colour, is_right) in [(ColourWay::Rectangle, true), (ColourWay::Xor, false)] {
        let variant = VertexVariant {
            switches: with_colour(colour),
            ..VertexVariant::default()
        };
        let found = figures(&judged.frame, &draw(&gpu, &input, variant));
        assert_eq!(verdict(&found).is_pass(), is_right, "{colour:?}: {found:?}");
    }
}

#[test]
fn a_frame_needs_preparing_and_an_unchanged_one_uploads_no_geometry() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let text = polygon("square", "[[0,0],[10,0],[10,10],[0,10],[0,0]]");
    let first = input(&text, Ellipsoid::WGS84, 180, (5.0, 5.0, 2e6, 0.0, -90.0));
    let other = input(&text, Ellipsoid::WGS84, 180, (5.0, 5.0, 2e6, 0.0, -90.0));
    let stage = Stage::shared(&gpu, SIZE).expect("small targets");
    let mut backend = VertexBackend::new(&stage, VertexVariant::default()).expect("valid");
    let error = backend.render(&first).expect_err("not prepared");
    assert_eq!(error.to_string(), "vertex was not prepared for test/test");
    assert!(backend.time_frame(&first).is_err());
    let memory = backend.prepare(&first).expect("fits");
    assert_eq!(
        memory.upload_bytes,
        memory.geometry_bytes() + memory.constant_bytes
    );
    let again = backend.prepare(&first).expect("fits");
    assert_eq!(again.upload_bytes, memory.constant_bytes);
    let frame = backend.render(&first).expect("draws");
    let counters = frame.counters.expect("a GPU backend counts");
    assert_eq!((counters.upload_bytes, counters.draws), (0, 3));
    assert!(backend.render(&other).is_err(), "another input");
    let twice = backend.render(&first).expect("draws");
    assert_eq!(frame.ids, twice.ids);
    assert_eq!(frame.counters, twice.counters);
}
