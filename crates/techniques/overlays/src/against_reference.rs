// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures held against the reference: how far each overlay is off, within what its nature allows; and
//! a control for each that is farther off.
//!
//! Without a Vulkan device these tests are skipped with the reason printed, unless
//! `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does.

use crate::{DRAPED_MESH, FLAT_MESH, MASK_TEXTURE, OverlayTechnique};
use std::rc::Rc;
use terrafill_conformance::{ErrorFigures, compare, movement_in_picture};
use terrafill_contract::{
    Devices, FillBackend, FillInput, Frame, PreparedScene, Targets, Technique as _,
};
use terrafill_core::{Geodetic, RegionMesh, parse_regions};
use terrafill_grid::GridKind;
use terrafill_plan::{PlanOptions, RegionSet};
use terrafill_reference::ReferenceBackend;
use terrafill_scene::{CameraPose, ImageSize, Scene};
use terrafill_surface::{EllipsoidKind, open_surface};

const SIZE: ImageSize = ImageSize::new(256, 192);

/// From centre to centre of pixels instead of from place to place, and a rasteriser's snap.
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

fn opened(technique: &OverlayTechnique, input: &FillInput, value: &str) -> Box<dyn FillBackend> {
    let targets = Targets::new(&Rc::new(Devices::default()), SIZE);
    let key = technique.parameters()[1].key;
    let variant = technique.main(input.scene.overlap).with(key, value);
    technique.open(&targets, &variant).expect("opens")
}

fn draw(technique: &OverlayTechnique, input: &FillInput, value: &str) -> Frame {
    let mut backend = opened(technique, input, value);
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

/// How far a picture's boundaries are off, pixels; infinite where that is not known.
fn moved_px(reference: &Frame, frame: &Frame) -> f64 {
    let moved = movement_in_picture(reference, frame).expect("of one size");
    moved.unwrap_or(f64::INFINITY)
}

/// Pixels between the feet and the tops of the planned volumes' walls, the farthest: on the way from one
/// to the other every wall meets the surface.
fn tallest_wall_px(input: &FillInput) -> f64 {
    let body = &input.scene.body;
    let mut tallest = 0.0_f64;
    for planned in &input.plan.regions {
        let mesh = &input.scene.meshes[planned.mesh];
        for &[longitude, latitude] in &mesh.vertices_deg {
            let at = |height_m: f64| {
                let place = Geodetic::from_degrees(longitude, latitude, height_m);
                input
                    .camera
                    .project_px(input.size, body.geodetic_to_ecef(place))
            };
            let ends = at(planned.heights.bottom_m).zip(at(planned.heights.top_m));
            let [from, to] = ends.map_or([[0.0; 2]; 2], |(from, to)| [from, to]);
            tallest = tallest.max((from[0] - to[0]).hypot(from[1] - to[1]));
        }
    }
    tallest
}

#[test]
fn a_flat_mesh_is_off_by_no_more_than_its_height_is_seen() {
    if !has_device() {
        return;
    }
    for scene in ["california", "hills"] {
        let input = seen(scene, "top-down");
        let reference = reference(&input);
        let allowed_px = tallest_wall_px(&input) + PICTURE_PX;
        let at_top = moved_px(&reference, &draw(&FLAT_MESH, &input, "top"));
        assert!(at_top <= allowed_px, "{scene}: {at_top} of {allowed_px}");
    }
    // Negative controls: terrain stands out of a mesh at the ellipsoid, and hides it where it is below.
    let input = seen("hills", "top-down");
    let reference = reference(&input);
    let wrong = |height| figures(&reference, &draw(&FLAT_MESH, &input, height)).mismatched_px;
    assert!(
        wrong("0") > 2 * wrong("top"),
        "{}, {}",
        wrong("0"),
        wrong("top")
    );
}

/// Whether no more pixels are wrong outside the boundary band than the offset may let through or hide at
/// silhouettes, such as the limb: one in a thousand of those filled.
fn follows_the_terrain(figures: &ErrorFigures) -> bool {
    figures.mismatched_px_outside_band * 1000 <= figures.filled_px
}

#[test]
fn a_draped_mesh_follows_the_terrain() {
    if !has_device() {
        return;
    }
    for scene in ["hills", "planet-134", "california"] {
        for view in ["globe", "top-down", "horizon"] {
            let input = seen(scene, view);
            let reference = reference(&input);
            let draped = figures(&reference, &draw(&DRAPED_MESH, &input, "2^-10"));
            assert!(follows_the_terrain(&draped), "{scene}/{view}: {draped:?}");
        }
    }
    // Negative control: at the surface's own depth the two fight.
    let input = seen("hills", "horizon");
    let reference = reference(&input);
    let fighting = figures(&reference, &draw(&DRAPED_MESH, &input, "0"));
    assert!(!follows_the_terrain(&fighting), "{fighting:?}");
}

/// The longer side of the rectangle around all regions, radians.
fn longer_side_rad(input: &FillInput) -> f64 {
    let extents = || input.scene.meshes.iter().map(|mesh| mesh.extent);
    if extents().any(|extent| extent.west_deg > extent.east_deg) {
        return std::f64::consts::TAU;
    }
    let span = |ends: fn(&terrafill_core::Extent) -> [f64; 2]| {
        let low = extents()
            .map(|extent| ends(&extent)[0])
            .fold(f64::INFINITY, f64::min);
        let high = extents()
            .map(|extent| ends(&extent)[1])
            .fold(f64::NEG_INFINITY, f64::max);
        high - low
    };
    let width = span(|extent| [extent.west_deg, extent.east_deg]);
    let height = span(|extent| [extent.south_deg, extent.north_deg]);
    width.max(height).to_radians()
}

#[test]
fn a_mask_is_off_by_no_more_than_half_a_texel() {
    if !has_device() {
        return;
    }
    // Angles from the middle of a narrow rectangle, and all around the body.
    for scene in ["california", "planet-134"] {
        let input = seen(scene, "top-down");
        let reference = reference(&input);
        let body = &input.scene.body;
        let eye = body.ecef_to_geodetic(input.camera.eye_ecef);
        let pixel_m = input.camera.pixel_size_m(SIZE, eye.height_m);
        let off_px = |size: &str| moved_px(&reference, &draw(&MASK_TEXTURE, &input, size));
        let allowed_px = |texels: f64| {
            let texel_m = longer_side_rad(&input) * body.equatorial_radius_m() / texels;
            texel_m * 0.5_f64.sqrt() / pixel_m + PICTURE_PX
        };
        for (size, texels) in [("1024", 1024.0), ("2048", 2048.0), ("8192", 8192.0)] {
            let (found, allowed) = (off_px(size), allowed_px(texels));
            assert!(found <= allowed, "{scene}, {size}: {found} of {allowed}");
        }
        // Negative control: an eighth of the texels is not within the bound of all.
        let coarse = off_px("1024");
        assert!(
            scene == "california" || coarse > allowed_px(8192.0),
            "{coarse}"
        );
    }
}

#[test]
fn a_steady_frame_uploads_nothing_and_pictures_leave_no_trace() {
    if !has_device() {
        return;
    }
    let [input, other] = ["globe", "top-down"].map(|view| seen("california", view));
    let other = other.remeshed(&input.scene, PlanOptions::default());
    for technique in [&FLAT_MESH, &DRAPED_MESH, &MASK_TEXTURE] {
        let name = technique.name();
        let default = technique.parameters()[1].default;
        let mut backend = opened(technique, &input, default);
        assert!(backend.render(&input).is_err(), "{name}: not prepared");
        let memory = backend.prepare(&input).expect("fits");
        let held = memory.geometry_bytes() + memory.constant_bytes;
        assert!(memory.upload_bytes > 0 && held > 0, "{name}: {memory:?}");
        let first = backend.render(&input).expect("draws");
        backend.prepare(&input).expect("fits");
        let steady = backend.render(&input).expect("draws");
        let counters = steady.counters.expect("counted");
        let done = [
            counters.uploads,
            counters.buffer_creations,
            counters.pipeline_creations,
        ];
        assert_eq!(done, [0; 3], "{name}");
        assert_eq!(first.ids, steady.ids, "{name}");
        // Negative control: another view writes something.
        backend.prepare(&other).expect("fits");
        let counters = backend.render(&other).expect("draws").counters;
        assert!(
            counters.is_some_and(|counters| counters.uploads > 0),
            "{name}"
        );
        let shown = backend.picture(&other).expect("draws");
        assert!(shown.rgba.iter().any(|&byte| byte > 0));
        backend.prepare(&input).expect("fits");
        assert_eq!(
            backend.render(&input).expect("draws").ids,
            first.ids,
            "{name}"
        );
    }
}

#[test]
fn regions_at_the_antimeridian_and_a_pole_are_in_the_mask() {
    if !has_device() {
        return;
    }
    let ring = |places: &str| format!(r#"{{"type":"Polygon","coordinates":[[{places}]]}}"#);
    let crossing = ring("[170,-12],[190,-12],[190,12],[170,12],[170,-12]");
    let polar = ring("[-180,70],[180,70],[180,90],[-180,90],[-180,70]");
    for (text, longitude, latitude) in [(crossing, 180.0, 0.0), (polar, 0.0, 89.0)] {
        let mut scene = Scene::shipped("california", None).expect("needs no data");
        let regions = parse_regions(text.as_bytes(), "a test").expect("valid");
        scene.regions = regions.into();
        scene.views[0].pose = CameraPose {
            eye: Geodetic::from_degrees(longitude, latitude, 6_000_000.0),
            heading_rad: 0.0,
            pitch_rad: -std::f64::consts::FRAC_PI_2,
            fov_y_rad: 1.0,
            near_m: 1.0,
        };
        let input = prepared(&scene, 0);
        let reference = reference(&input);
        let off_px = |size: &str| moved_px(&reference, &draw(&MASK_TEXTURE, &input, size));
        let found = off_px("8192");
        assert!(found <= PICTURE_PX, "{longitude}: {found}");
        // Negative control: without the region nothing is near.
        let mut empty = reference.clone();
        empty.ids.fill(0);
        assert!(moved_px(&reference, &empty) > PICTURE_PX);
    }
}
