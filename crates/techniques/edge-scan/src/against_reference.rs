// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures compared with the reference. Where `f32` suffices they are right. Half floats, or an eye close by,
//! make them wrong by as much of the rounding as can be seen. An edge that is missing is noticed.
//!
//! Without a Vulkan device these tests are skipped with the reason printed, unless
//! `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does.

use crate::EdgeScanTechnique;
use crate::outline::{OUTLINE, SceneOutlines};
use crate::scan::EdgeScan;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_conformance::{ErrorFigures, compare, movement_in_picture};
use terrafill_contract::{
    DeviceError, Devices, FillBackend, FillInput, Frame, NO_REGION, PreparedScene, Targets,
    Technique as _,
};
use terrafill_core::{EdgeRule, FootprintMesher, Geodetic, RegionMesh, SensorCone, parse_regions};
use terrafill_gpu::{OverlayBackend, shared_targets};
use terrafill_grid::GridKind;
use terrafill_plan::{PlanOptions, RegionSet};
use terrafill_reference::ReferenceBackend;
use terrafill_scene::{CameraPose, ImageSize, Overlap, Scene};
use terrafill_surface::{EllipsoidKind, open_surface};
use terrafill_variant::Variant;

const SIZE: ImageSize = ImageSize::new(256, 192);

/// From centre to centre of pixels instead of from place to place.
const PICTURE_PX: f64 = 1.5;

fn has_device() -> bool {
    terrafill_gpu::open_for_test(&Default::default()).is_some()
}

fn seen(name: &str, view: &str) -> FillInput {
    let scene = Scene::shipped(name, None).expect("needs no data");
    let mut views = scene.views.iter();
    let place = views.position(|found| found.name == view);
    prepared(&scene, place.expect("it is shipped"))
}

fn prepared(scene: &Scene, view: usize) -> FillInput {
    let (body, rule) = (&scene.body, scene.edge_rule);
    let meshes = RegionMesh::build_all(&scene.regions, body, rule, &scene.mesh);
    let meshes: RegionSet = meshes.expect("it meshes").into();
    let surface = open_surface(&[&EllipsoidKind, &GridKind], scene).expect("a surface");
    let prepared = PreparedScene::new(scene, meshes, surface);
    FillInput::new(&prepared, &scene.views[view], SIZE, PlanOptions::default()).expect("a surface")
}

/// Regions of a GeoJSON text, seen from straight above a place.
fn seen_above(text: &str, rule: EdgeRule, [longitude, latitude]: [f64; 2]) -> FillInput {
    let mut scene = Scene::shipped("california", None).expect("needs no data");
    let regions = parse_regions(text.as_bytes(), "a test").expect("valid");
    scene.regions = regions.into();
    scene.edge_rule = rule;
    scene.overlap = Overlap::Ordered;
    scene.views[0].pose = CameraPose {
        eye: Geodetic::from_degrees(longitude, latitude, 6_000_000.0),
        heading_rad: 0.0,
        pitch_rad: -std::f64::consts::FRAC_PI_2,
        fov_y_rad: 1.0,
        near_m: 1.0,
    };
    prepared(&scene, 0)
}

fn variant(input: &FillInput, outline: &str) -> Variant {
    let main = EdgeScanTechnique.main(input.scene.overlap);
    main.with(OUTLINE, outline)
}

fn targets() -> Targets {
    Targets::new(&Rc::new(Devices::default()), SIZE)
}

fn opened(input: &FillInput, outline: &str) -> Box<dyn FillBackend> {
    let opened = EdgeScanTechnique.open(&targets(), &variant(input, outline));
    opened.expect("opens")
}

fn draw(input: &FillInput, outline: &str) -> Frame {
    let mut backend = opened(input, outline);
    backend.prepare(input).expect("fits");
    backend.render(input).expect("draws")
}

fn reference(input: &FillInput) -> Frame {
    let frame = ReferenceBackend::new().judge(input).expect("judges").frame;
    assert!(frame.filled_px() > 100);
    frame
}

fn figures(reference: &Frame, frame: &Frame) -> ErrorFigures {
    compare(reference, frame).expect("of one size")
}

fn is_right(reference: &Frame, frame: &Frame) -> bool {
    figures(reference, frame).mismatched_px_outside_band == 0
}

/// A pixel of a region that all pixels two steps around it belong to.
fn inner_pixel(frame: &Frame) -> usize {
    let width = SIZE.width as usize;
    let rows = (0..frame.ids.len()).step_by(width);
    let is_inner = |&at: &usize| {
        let around = rows
            .clone()
            .take(5)
            .flat_map(|row| (0..5).map(move |column| row + column));
        let mut around = around.map(|step| frame.ids.get(at + step).copied().unwrap_or_default());
        around.all(|id| id == frame.ids[at] && id != NO_REGION)
    };
    let corner = (0..frame.ids.len()).find(is_inner);
    corner.expect("five pixels each way") + 2 * width + 2
}

/// How far a picture's boundaries are off, pixels; infinite where that is not known.
fn moved_px(reference: &Frame, frame: &Frame) -> f64 {
    let moved = movement_in_picture(reference, frame).expect("of one size");
    moved.unwrap_or(f64::INFINITY)
}

#[test]
fn from_afar_floats_suffice() {
    if !has_device() {
        return;
    }
    for (scene, view) in [
        ("planet-134", "globe"),
        ("planet-134", "top-down"),
        ("california", "globe"),
        ("california", "top-down"),
        ("hills", "top-down"),
    ] {
        let input = seen(scene, view);
        let reference = reference(&input);
        let frame = draw(&input, "f32");
        let found = figures(&reference, &frame);
        assert!(is_right(&reference, &frame), "{scene}/{view}: {found:?}");
        // Negative control: one pixel in the middle of what is filled.
        let mut wrong = frame;
        wrong.ids[inner_pixel(&reference)] += 1;
        assert!(!is_right(&reference, &wrong), "{scene}/{view}");
    }
}

/// At 110° W a half float has steps of 1/16°: half a step is 3.4 km at this latitude, seen from 510 km.
#[test]
fn half_floats_are_off_by_half_a_step() {
    if !has_device() {
        return;
    }
    let input = seen("planet-134", "top-down");
    let reference = reference(&input);
    let body = &input.scene.body;
    let eye = body.ecef_to_geodetic(input.camera.eye_ecef);
    let radius_px = body.equatorial_radius_m() / input.camera.pixel_size_m(SIZE, eye.height_m);
    // Latitudes of 8° to 16° have steps of 1/128°.
    let half_steps_rad = [32.0_f64, 256.0].map(|per_degree| per_degree.recip().to_radians());
    let allowed_px = half_steps_rad[0].hypot(half_steps_rad[1]) * radius_px + PICTURE_PX;
    let [floats, halves] = ["f32", "f16"].map(|outline| draw(&input, outline));
    let (found, of_floats) = (moved_px(&reference, &halves), moved_px(&reference, &floats));
    assert!(found <= allowed_px, "{found} of {allowed_px}");
    assert!(
        of_floats <= PICTURE_PX && found > 2.0 * of_floats,
        "{found}, {of_floats}"
    );
    // From close by, over longitudes with steps of 1/8°, nothing is left in its place.
    let input = seen("planet-134", "horizon");
    let reference = self::reference(&input);
    let wrong = ["f32", "f16"].map(|outline| {
        let figures = figures(&reference, &draw(&input, outline));
        figures.mismatched_px_outside_band
    });
    assert!(wrong[1] > 10 * wrong[0].max(10), "{wrong:?}");
}

/// Latitudes there have steps of 0.4 m in `f32`, and from an eye 1.5 m high a pixel is a centimetre.
#[test]
fn a_square_of_ten_metres_is_wrong_from_close_by() {
    if !has_device() {
        return;
    }
    let input = seen("square-10m", "edge-1m5");
    let reference = reference(&input);
    let found = figures(&reference, &draw(&input, "f32"));
    assert!(found.mismatched_px_outside_band > 0, "{found:?}");
    // Half floats cannot tell its corners apart, and it is gone.
    assert_eq!(draw(&input, "f16").filled_px(), 0);
    // Control: from afar the same way of drawing is right.
    let input = seen("california", "globe");
    let reference = self::reference(&input);
    assert!(is_right(&reference, &draw(&input, "f32")));
}

#[test]
fn holes_overlaps_the_antimeridian_poles_and_either_edge_rule_are_right() {
    if !has_device() {
        return;
    }
    let polygon = |rings: &str| format!(r#"{{"type":"Polygon","coordinates":{rings}}}"#);
    let collection = |polygons: &[String]| {
        let features = polygons.iter().map(|polygon| {
            format!(r#"{{"type":"Feature","properties":{{}},"geometry":{polygon}}}"#)
        });
        let features: Vec<String> = features.collect();
        let features = features.join(",");
        format!(r#"{{"type":"FeatureCollection","features":[{features}]}}"#)
    };
    let ringed =
        "[[[-20,-15],[20,-15],[20,15],[-20,15],[-20,-15]],[[-8,-8],[-8,8],[8,8],[8,-8],[-8,-8]]]";
    let over = "[[[0,-25],[12,-25],[12,25],[0,25],[0,-25]]]";
    let high = "[[[-25,50],[30,55],[25,75],[-30,65],[-25,50]]]";
    let crossing = "[[[165,-12],[195,-14],[190,12],[170,9],[165,-12]]]";
    let cap = "[[[-180,70],[180,70],[180,90],[-180,90],[-180,70]]]";
    let southern_cap = "[[[-180,-90],[180,-90],[180,-65],[-180,-72],[-180,-90]]]";
    let wedge = "[[[150,-90],[250,-90],[240,-60],[150,-60],[150,-90]]]";
    let (planar, great) = (EdgeRule::Planar, EdgeRule::GreatEllipse);
    let one = |rings: &str| collection(&[polygon(rings)]);
    for (text, rule, place) in [
        (one(ringed), planar, [0.0, 0.0]),
        (
            collection(&[polygon(ringed), polygon(over)]),
            planar,
            [0.0, 0.0],
        ),
        (one(high), planar, [0.0, 60.0]),
        (one(high), great, [0.0, 60.0]),
        (one(crossing), planar, [180.0, 0.0]),
        (one(crossing), great, [180.0, 0.0]),
        (one(cap), planar, [0.0, 89.0]),
        (one(southern_cap), planar, [90.0, -85.0]),
        (one(wedge), planar, [-160.0, -80.0]),
    ] {
        let input = seen_above(&text, rule, place);
        let reference = reference(&input);
        let found = figures(&reference, &draw(&input, "f32"));
        assert_eq!(found.mismatched_px_outside_band, 0, "{text}: {found:?}");
    }
    // Negative controls: the other edge rule, and the other order.
    for (text, rule, other, other_rule) in [
        (one(high), planar, one(high), great),
        (
            collection(&[polygon(ringed), polygon(over)]),
            planar,
            collection(&[polygon(over), polygon(ringed)]),
            planar,
        ),
    ] {
        let place = [0.0, if rule == other_rule { 0.0 } else { 60.0 }];
        let reference = reference(&seen_above(&text, rule, place));
        let frame = draw(&seen_above(&other, other_rule, place), "f32");
        assert!(!is_right(&reference, &frame), "{other}");
    }
}

/// Outlines in which a line has a gap: the edge that ends at a position is left out.
fn without_edge(mut outlines: SceneOutlines, end: u32) -> SceneOutlines {
    let line = outlines.ends.partition_point(|&line_end| line_end <= end);
    outlines.ends.insert(line, end);
    let line = u32::try_from(line).expect("few");
    for place in &mut outlines.places {
        place.lines.start += u32::from(place.lines.start > line);
        place.lines.end += u32::from(place.lines.end > line);
    }
    outlines
}

#[test]
fn an_edge_that_is_missing_is_noticed() {
    if !has_device() {
        return;
    }
    let input = seen_above(
        r#"{"type":"Polygon","coordinates":[[[-20,-15],[20,-12],[15,15],[-20,12],[-20,-15]]]}"#,
        EdgeRule::Planar,
        [0.0, 0.0],
    );
    let reference = reference(&input);
    let targets = targets();
    let shared = shared_targets(&targets).expect("a device");
    let gpu = Arc::clone(shared.borrow().gpu());
    let scan = EdgeScan::new(&gpu, &variant(&input, "f32")).expect("opens");
    let whole = scan.outlines(&input).expect("has shorter ways");
    let mut backend = OverlayBackend::new(&shared, scan);
    let mut picture = |outlines: SceneOutlines| {
        let scan = backend.overlay_mut();
        scan.upload(&gpu, &input, outlines).expect("fits");
        backend.prepare(&input).expect("fits");
        backend.render(&input).expect("draws")
    };
    // Control: the same way to the device with all edges.
    assert!(is_right(&reference, &picture(whole.clone())));
    let mut noticed = 0;
    let pixel_rad = input.camera.pixel_size_m(SIZE, 6_000_000.0) / 6_378_137.0;
    let positions = whole.ends[0];
    assert!(positions >= 5 && whole.ends.len() == 1);
    for end in 1..positions {
        let [longitude, latitude] = [0, 1].map(|axis| {
            let whole = &whole;
            move |at: u32| f32::from_bits(whole.words[2 * at as usize + axis])
        });
        let span_rad = f64::from((longitude(end) - longitude(end - 1)).abs()).to_radians();
        // What lies north of a shorter edge may fall between the centres of pixels. North of the northern side
        // the box ends.
        if span_rad < 1.5 * pixel_rad || latitude(end) > 0.0 {
            continue;
        }
        let frame = picture(without_edge(whole.clone(), end));
        assert!(!is_right(&reference, &frame), "edge {end} of {positions}");
        noticed += 1;
    }
    assert!(noticed > 10, "{noticed}");
}

#[test]
fn a_frame_takes_the_bytes_of_the_formula_and_leaves_out_what_is_out_of_sight() {
    if !has_device() {
        return;
    }
    for scene in ["planet-134", "california", "square-10m"] {
        let input = prepared(&Scene::shipped(scene, None).expect("needs no data"), 0);
        for outline in ["f32", "f16"] {
            let memory = opened(&input, outline).prepare(&input).expect("fits");
            let variant = variant(&input, outline);
            let meshes = input.scene.meshes.iter();
            let bytes = meshes.map(|mesh| EdgeScanTechnique.bytes(&variant, mesh, true));
            let [mut vertex_bytes, mut index_bytes] = [0, 0];
            for of_region in bytes {
                let of_region = of_region.expect("its own");
                vertex_bytes += of_region.vertex_bytes;
                index_bytes += of_region.index_bytes;
            }
            assert_eq!(memory.vertex_bytes, vertex_bytes, "{scene}, {outline}");
            assert_eq!(memory.index_bytes, index_bytes, "{scene}, {outline}");
            // Radii, and 48 bytes for each region that the plan does not leave out.
            let planned = input.plan.regions.len() as u64;
            assert_eq!(memory.constant_bytes, 8 + 48 * planned, "{scene}");
            assert_eq!(memory.padding_bytes, 0);
            assert_eq!(memory.upload_bytes, memory.held_bytes());
        }
    }
    // Negative control: the planet has regions on its other side, and they are no constants of this view.
    let input = seen("planet-134", "globe");
    assert!(input.plan.regions.len() < input.scene.regions.len());
    assert!(!input.left_out_summary().is_empty());
}

#[test]
fn a_steady_frame_uploads_nothing_and_pictures_leave_no_trace() {
    if !has_device() {
        return;
    }
    let [input, other] = ["globe", "top-down"].map(|view| seen("california", view));
    let mut backend = opened(&input, "f32");
    assert!(backend.render(&input).is_err(), "not prepared");
    backend.prepare(&input).expect("fits");
    let first = backend.render(&input).expect("draws");
    backend.prepare(&input).expect("fits");
    let steady = backend.render(&input).expect("draws");
    let counters = steady.counters.expect("counted");
    let done = [
        counters.uploads,
        counters.buffer_creations,
        counters.pipeline_creations,
    ];
    assert_eq!((done, counters.draws, counters.vertices), ([0; 3], 1, 3));
    assert_eq!(first.ids, steady.ids);
    // Negative control: other meshes are uploaded.
    backend.prepare(&other).expect("fits");
    let counters = backend.render(&other).expect("draws").counters;
    assert!(counters.is_some_and(|counters| counters.uploads > 0));
    let shown = backend.picture(&other).expect("draws");
    assert!(shown.rgba.iter().any(|&byte| byte > 0));
    backend.prepare(&input).expect("fits");
    assert_eq!(backend.render(&input).expect("draws").ids, first.ids);
}

#[test]
fn what_moves_on_the_device_is_refused() {
    if !has_device() {
        return;
    }
    let input = seen("california", "globe");
    let mut backend = opened(&input, "f32");
    // Control: without footprints it is drawn.
    assert!(backend.prepare(&input).is_ok());
    let mut moving = input;
    let mesher = FootprintMesher::new(moving.scene.body, 16).expect("allowed");
    let footprint = mesher.moving(&SensorCone {
        apex: Geodetic::from_degrees(-120.0, 37.0, 400_000.0),
        azimuth_rad: 0.0,
        elevation_rad: -std::f64::consts::FRAC_PI_2,
        half_angle_rad: 0.3,
    });
    moving.scene.footprints = Arc::new([(0, footprint.expect("all round"))].into());
    let refused = backend
        .prepare(&moving)
        .expect_err("nothing says where it is");
    assert!(
        matches!(refused, DeviceError::Unsupported { .. }),
        "{refused}"
    );
}
