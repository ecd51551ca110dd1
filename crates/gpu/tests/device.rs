// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tests that need a Vulkan device. Without one they are skipped with the reason printed, unless
//! `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does.

use std::sync::Arc;
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_frame::{FrameInput, PreparedScene};
use terrafill_gpu::{
    Baseline, BaselineKind, GpuOptions, POSITIVE_CONTROL, Stage, make_deliberate_error, messages,
    open_for_test,
};
use terrafill_scene::{CameraPose, ImageSize, Overlap, PlanOptions, SurfaceMesh, View};

const SIZE: ImageSize = ImageSize {
    width: 101,
    height: 67,
};

fn globe_from(height_m: f64) -> FrameInput {
    let body = Ellipsoid::WGS84;
    let scene = PreparedScene {
        name: "bare".to_owned(),
        body,
        edge_rule: Default::default(),
        overlap: Overlap::Disjoint,
        regions: Arc::new([]),
        meshes: Arc::new([]),
        levels: Arc::default(),
        bounds: Arc::new([]),
        surface: Arc::new(SurfaceMesh::ellipsoid(&body, 180)),
        texture: None,
    };
    let view = View {
        name: "globe".to_owned(),
        pose: CameraPose {
            eye: Geodetic::from_degrees(15.0, 20.0, height_m),
            heading_rad: 0.0,
            pitch_rad: -std::f64::consts::FRAC_PI_2,
            fov_y_rad: 60_f64.to_radians(),
            near_m: 1000.0,
        },
        note: None,
    };
    FrameInput::new(&scene, &view, SIZE, PlanOptions::default())
}

#[test]
fn a_deliberate_error_is_reported_when_validation_is_on() {
    let options = GpuOptions {
        validation: true,
        ..GpuOptions::default()
    };
    let Some(gpu) = open_for_test(&options) else {
        return;
    };
    let count = || {
        messages()
            .iter()
            .filter(|m| m.id == POSITIVE_CONTROL)
            .count()
    };
    assert_eq!(count(), 0);
    assert!(make_deliberate_error(&gpu), "the device is a Vulkan one");
    assert!(
        count() > 0,
        "the validation layer is not at work: {:?}",
        messages()
    );
}

#[test]
fn the_surface_has_the_depth_of_the_ellipsoid() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let input = globe_from(8e6);
    let mut stage = Stage::new(&gpu, SIZE).expect("small targets");
    stage.prepare(&input).expect("fits");
    let time = stage.draw_surface().expect("draws");
    assert_eq!(time.is_some(), gpu.facts.features.timestamps);
    let picture = stage.read().expect("reads");
    let at = |column: usize, row: usize| picture.depth[row * SIZE.width as usize + column];
    // Reversed depth is near / distance; facets of 1° hang up to 488 m below the ellipsoid.
    let distance = 1000.0 / f64::from(at(50, 33));
    assert!((7.99999e6..8.0005e6).contains(&distance), "{distance}");
    assert_eq!(at(0, 0), 0.0, "the sky keeps the cleared depth");
    let alphas = picture.rgba.chunks_exact(4).map(|pixel| pixel[3]);
    assert!(alphas.into_iter().all(|alpha| alpha == 0));
    // The disc's area against the silhouette of a sphere: sin θ = R / (R + h).
    let covered = picture.depth.iter().filter(|&&depth| depth > 0.0).count();
    let sin = 6.371e6 / (6.371e6 + 8e6);
    let radius_px = sin / f64::sqrt(1.0 - sin * sin) / 30_f64.to_radians().tan() * 33.5;
    let area = std::f64::consts::PI * radius_px * radius_px;
    assert!(
        (covered as f64 / area - 1.0).abs() < 0.02,
        "{covered} of {area}"
    );
}

#[test]
fn a_stage_refuses_an_input_of_another_size_and_a_size_no_device_has() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let small = ImageSize {
        width: 10,
        height: 10,
    };
    let mut stage = Stage::new(&gpu, small).expect("small targets");
    let error = stage.prepare(&globe_from(8e6)).expect_err("another size");
    assert!(error.to_string().contains("image size differs"), "{error}");
    let huge = ImageSize {
        width: 1 << 20,
        height: 10,
    };
    let error = Stage::new(&gpu, huge).expect_err("too large");
    assert!(error.to_string().contains("1048576 × 10 pixels"), "{error}");
    assert!(
        Stage::new(
            &gpu,
            ImageSize {
                width: 0,
                height: 1
            }
        )
        .is_err()
    );
}

#[test]
fn baselines_cover_every_pixel() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let input = globe_from(8e6);
    for kind in [BaselineKind::Bound, BaselineKind::Floor] {
        let stage = Stage::shared(&gpu, SIZE).expect("small targets");
        stage.borrow_mut().prepare(&input).expect("fits");
        stage.borrow_mut().draw_surface().expect("draws");
        let mut baseline = Baseline::new(kind, &stage).expect("valid shader");
        let times = baseline.time_frame().expect("draws");
        assert!(times.fill_cpu_ms > 0.0 && times.fill_wall_ms > 0.0);
        let picture = stage.borrow().read().expect("reads");
        assert!(
            picture
                .rgba
                .chunks_exact(4)
                .all(|pixel| pixel == [255, 204, 51, 255])
        );
        assert!(
            picture.depth.iter().any(|&depth| depth > 0.0),
            "depth survives"
        );
    }
}
