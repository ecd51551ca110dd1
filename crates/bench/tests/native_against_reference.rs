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
use terrafill_native::{NativeBackend, NativeVariant, Technique, depth_range, native_bytes};
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

/// Ways of colouring with depth rules, those that the backend has pipelines for.
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
    all.retain(|switches| switches.colour != ColourWay::IdAccumulation);
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
            let verdict = verdict(&figures(&judged, &frame));
            assert!(verdict.is_pass(), "{what}, {name}: {verdict:?}");
            assert_eq!(differing(&frame, &vertex), 0, "{what}, {name}");
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
