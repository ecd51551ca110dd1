// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions written down in a test, a view of them, and a vertex backend that draws it.

#![allow(dead_code, reason = "each test binary uses its own part of this")]

use std::sync::Arc;
use terrafill_conformance::compare;
use terrafill_core::{EdgeRule, Ellipsoid, Geodetic, MeshOptions, RegionMesh, parse_regions};
use terrafill_frame::{Backend as _, ColourWay, Frame, FrameInput, PreparedScene, Switches};
use terrafill_gpu::{Gpu, SharedStage, Stage};
use terrafill_results::ErrorFigures;
use terrafill_scene::{CameraPose, ImageSize, Overlap, PlanOptions, SurfaceMesh, View};
use terrafill_vertex::{VertexBackend, VertexVariant};

/// Size of most pictures here.
pub(crate) const SIZE: ImageSize = ImageSize {
    width: 384,
    height: 384,
};

/// Default switches but for the way of colouring.
pub(crate) fn with_colour(colour: ColourWay) -> Switches {
    Switches {
        colour,
        ..Switches::default()
    }
}

/// Longitude, latitude, height, heading, pitch, in degrees and metres.
pub(crate) type Pose = (f64, f64, f64, f64, f64);

/// A view of disjoint regions.
pub(crate) fn input(geojson: &str, body: Ellipsoid, rows: u32, pose: Pose) -> FrameInput {
    let scene = scene(geojson, body, rows, Overlap::Disjoint);
    look(&scene, pose, pose.2 * 1e-3, SIZE)
}

/// Regions over a grid of `rows` rows.
pub(crate) fn scene(geojson: &str, body: Ellipsoid, rows: u32, overlap: Overlap) -> PreparedScene {
    let tolerance_m = body.equatorial_radius_m() * 1e-7;
    scene_within(tolerance_m, geojson, body, rows, overlap)
}

/// The same with boundaries this close to what the reference judges by.
pub(crate) fn scene_within(
    boundary_tolerance_m: f64,
    geojson: &str,
    body: Ellipsoid,
    rows: u32,
    overlap: Overlap,
) -> PreparedScene {
    let regions = parse_regions(geojson.as_bytes(), "test").expect("valid regions");
    let options = MeshOptions {
        boundary_tolerance_m,
        cap_step_deg: 3.0,
    };
    let meshes = RegionMesh::build_all(&regions, &body, EdgeRule::Planar, &options);
    PreparedScene {
        name: "test".to_owned(),
        body,
        edge_rule: EdgeRule::Planar,
        overlap,
        regions: regions.into(),
        meshes: Arc::new([]),
        levels: Arc::default(),
        bounds: Arc::new([]),
        surface: Arc::new(SurfaceMesh::ellipsoid(&body, rows)),
        texture: None,
    }
    .with_meshes(meshes.expect("meshes").into())
}

/// A view of `scene`.
pub(crate) fn look(scene: &PreparedScene, pose: Pose, near_m: f64, size: ImageSize) -> FrameInput {
    let (longitude, latitude, height_m, heading, pitch) = pose;
    let view = View {
        name: "test".to_owned(),
        pose: CameraPose {
            eye: Geodetic::from_degrees(longitude, latitude, height_m),
            heading_rad: heading.to_radians(),
            pitch_rad: pitch.to_radians(),
            fov_y_rad: 60_f64.to_radians(),
            near_m,
        },
        note: None,
    };
    FrameInput::new(scene, &view, size, PlanOptions::default())
}

/// A feature.
pub(crate) fn polygon(name: &str, rings: &str) -> String {
    format!(
        r#"{{"type":"Feature","properties":{{"name":"{name}"}},
            "geometry":{{"type":"Polygon","coordinates":[{rings}]}}}}"#
    )
}

/// Features as a file.
pub(crate) fn collection(features: &[String]) -> String {
    let joined = features.join(",");
    format!(r#"{{"type":"FeatureCollection","features":[{joined}]}}"#)
}

/// The frame on a stage of its own.
pub(crate) fn draw(gpu: &Arc<Gpu>, input: &FrameInput, variant: VertexVariant) -> Frame {
    let stage = Stage::shared(gpu, input.size).expect("small targets");
    draw_on(&stage, input, variant)
}

/// The frame on a stage that may hold the surface already.
pub(crate) fn draw_on(stage: &SharedStage, input: &FrameInput, variant: VertexVariant) -> Frame {
    let mut backend = VertexBackend::new(stage, variant).expect("valid shaders");
    draw_with(&mut backend, input)
}

/// The frame by a backend that may have drawn others.
pub(crate) fn draw_with(backend: &mut VertexBackend, input: &FrameInput) -> Frame {
    backend.prepare(input).expect("fits");
    backend.render(input).expect("draws")
}

/// What the comparison with the reference says.
pub(crate) fn figures(reference: &Frame, frame: &Frame) -> ErrorFigures {
    compare(reference, frame).expect("same size")
}
