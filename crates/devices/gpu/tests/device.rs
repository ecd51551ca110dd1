// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tests that need a Vulkan device. Without one they are skipped with the reason printed, unless
//! `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does.

use terrafill_contract::{DeviceError, Devices, device_for_test};
use terrafill_fixtures::globe::{SIZE, assert_depth_of_the_ellipsoid, globe_from};
use terrafill_gpu::{
    Baseline, BaselineKind, GpuOptions, POSITIVE_CONTROL, RenderTargets, make_deliberate_error,
    open_for_test, shared_gpu, validation_log,
};
use terrafill_scene::ImageSize;

#[test]
fn a_deliberate_error_is_reported_when_validation_is_on() {
    let options = GpuOptions {
        validation: true,
        ..GpuOptions::default()
    };
    let Some(gpu) = open_for_test(&options) else {
        return;
    };
    let log = validation_log();
    assert!(!log.has(POSITIVE_CONTROL));
    assert!(make_deliberate_error(&gpu), "the device is a Vulkan one");
    assert!(
        log.has(POSITIVE_CONTROL),
        "the validation layer is not at work: {:?}",
        log.after(0)
    );
}

#[test]
fn a_lost_device_is_known_to_the_devices_of_the_run_and_draws_nothing() {
    let devices = Devices::default();
    let Some(gpu) = device_for_test(shared_gpu(&devices)) else {
        return;
    };
    let mut targets = RenderTargets::new(&gpu, SIZE).expect("small targets");
    targets.prepare(&globe_from(8e6)).expect("fits");
    // Negative control: a device that draws is not lost.
    targets.draw_surface().expect("draws");
    assert_eq!(devices.loss().message(), None);
    gpu.device.destroy();
    // `destroy` calls back at the next poll; a loss by the driver does so at once.
    let waited = gpu.wait();
    assert!(
        waited.is_ok() || waited.is_err_and(|error| matches!(error, DeviceError::DeviceLost(_)))
    );
    let drawn = targets.draw_surface().and_then(|_| targets.read());
    assert!(drawn.is_err(), "a picture by a device that is gone");
    let said = devices.loss().message().unwrap_or_default();
    assert!(said.starts_with("Destroyed"), "{said:?}");
}

#[test]
fn the_surface_has_the_depth_of_the_ellipsoid() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let input = globe_from(8e6);
    let mut targets = RenderTargets::new(&gpu, SIZE).expect("small targets");
    targets.prepare(&input).expect("fits");
    let time = targets.draw_surface().expect("draws");
    assert_eq!(time.is_some(), gpu.facts.features.timestamps);
    let picture = targets.read().expect("reads");
    assert_depth_of_the_ellipsoid(&picture);
}

#[test]
fn a_stage_refuses_an_input_of_another_size_and_a_size_no_device_has() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let small = ImageSize::new(10, 10);
    let mut targets = RenderTargets::new(&gpu, small).expect("small targets");
    let error = targets.prepare(&globe_from(8e6)).expect_err("another size");
    assert!(error.to_string().contains("image size differs"), "{error}");
    let sized = |width, height| RenderTargets::new(&gpu, ImageSize { width, height });
    let error = sized(1 << 20, 10).expect_err("too large");
    assert!(error.to_string().contains("1048576 × 10 pixels"), "{error}");
    assert!(sized(0, 1).is_err());
}

#[test]
fn baselines_cover_every_pixel() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let input = globe_from(8e6);
    for kind in [BaselineKind::DepthPass, BaselineKind::StencilPass] {
        let targets = RenderTargets::shared(&gpu, SIZE).expect("small targets");
        targets.borrow_mut().prepare(&input).expect("fits");
        targets.borrow_mut().draw_surface().expect("draws");
        let mut baseline = Baseline::new(kind, &targets).expect("valid shader");
        let times = baseline.time_frame().expect("draws");
        assert!(times.fill_cpu_ms > 0.0 && times.fill_wall_ms > 0.0);
        let picture = targets.borrow().read().expect("reads");
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

/// What a frame does before its pass.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Copies {
    Nothing,
    InTheFrame,
    BeforeTheFrame,
}

#[test]
fn copies_of_a_frame_are_inside_its_gpu_time() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    if !gpu.facts.features.timestamps {
        return;
    }
    let targets = RenderTargets::new(&gpu, SIZE).expect("small targets");
    let buffer = |usage| {
        gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 1 << 26,
            usage,
            mapped_at_creation: false,
        })
    };
    let from = buffer(wgpu::BufferUsages::COPY_SRC);
    let to = buffer(wgpu::BufferUsages::COPY_DST);
    let copy = |encoder: &mut wgpu::CommandEncoder| {
        for _ in 0..8 {
            encoder.copy_buffer_to_buffer(&from, 0, &to, 0, from.size());
        }
    };
    let time = |copies: Copies| {
        let mut before = gpu.device.create_command_encoder(&Default::default());
        let mut frame = targets.direct_frame();
        match copies {
            Copies::Nothing => {}
            Copies::InTheFrame => copy(&mut frame.encoder),
            Copies::BeforeTheFrame => copy(&mut before),
        }
        drop(targets.cleared_pass(&mut frame));
        gpu.queue.submit([before.finish(), frame.encoder.finish()]);
        gpu.wait().expect("a device");
        targets.direct_ms().expect("a device").expect("a time")
    };
    // Pages are there from the first copy on.
    time(Copies::InTheFrame);
    let least = |copies| {
        let times = (0..5).map(|_| time(copies));
        times.min_by(f64::total_cmp).expect("five frames")
    };
    let [alone, inside, before] =
        [Copies::Nothing, Copies::InTheFrame, Copies::BeforeTheFrame].map(least);
    assert!(inside > 4.0 * alone, "{inside} ms against {alone} ms");
    // Negative control: what a submission does before the frame begins is not the frame's.
    assert!(inside > 4.0 * before, "{inside} ms against {before} ms");
}
