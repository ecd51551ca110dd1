// SPDX-License-Identifier: MIT OR Apache-2.0
//! The vertex stage's footprint of a cone is the one that is followed in f64, within the bound. Skipped
//! without a device; see `device.rs`.

use crate::common::evaluated;
use std::sync::Arc;
use terrafill_core::{
    Ellipsoid, FootprintMesher, Geodetic, MovingFootprint, SensorCone, nearest_f32,
};
use terrafill_gpu::{Gpu, GpuOptions, Kernel, open_for_test};
use terrafill_shaders::shared_text;
use terrafill_stencil::{FixedPoint, FootprintConstants};

const STEPS: u32 = 256;

fn moving(mesher: &FootprintMesher, longitude_deg: f64, tilt_deg: f64) -> MovingFootprint {
    let cone = SensorCone {
        apex: Geodetic::from_degrees(longitude_deg, 35.0, 700_000.0),
        azimuth_rad: 2.0,
        elevation_rad: (tilt_deg - 90.0).to_radians(),
        half_angle_rad: 18_f64.to_radians(),
    };
    mesher.moving(&cone).expect("all round")
}

/// Largest distance from the vertices in f64, metres.
fn worst_m(gpu: &Arc<Gpu>, wgsl: &str, mesher: &FootprintMesher, of: &MovingFootprint) -> f64 {
    let kernel = Kernel {
        name: "footprint",
        wgsl,
        constants: Some("Footprint"),
        call: "vec4f(footprint_from_apex_m(x.xy, constants), 0.0)",
        table: None,
    };
    let constants =
        FootprintConstants::new(&of.edge, &FixedPoint::for_mesh(&mesher.disc("disc", 0)));
    let vectors: [[f32; 4]; 4] = bytemuck::cast(constants);
    let steps = mesher.steps().iter();
    let inputs: Vec<[f32; 3]> = steps
        .map(|&[cos, sin]| [nearest_f32(cos), nearest_f32(sin), 0.0])
        .collect();
    let values = evaluated(gpu, &kernel, &vectors, &inputs);
    assert_eq!(values.len(), mesher.steps().len());
    let off = values.iter().zip(mesher.steps());
    let off = off.map(|(value, &[cos, sin])| {
        let exact = of.edge.hit(cos, sin) - of.edge.apex_ecef;
        let found = [0, 1, 2].map(|axis| f64::from(value[axis]) - exact[axis]);
        found.iter().map(|part| part * part).sum::<f64>().sqrt()
    });
    off.fold(0.0, f64::max)
}

#[test]
fn the_device_bends_a_disc_within_the_bound() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let mesher = FootprintMesher::new(Ellipsoid::WGS84, STEPS).expect("allowed");
    let wgsl = shared_text("shared/footprint.wgsl").expect("it is there");
    for (longitude_deg, tilt_deg) in [(15.0, 5.0), (15.0, 22.0), (-170.0, 22.0)] {
        let moving = moving(&mesher, longitude_deg, tilt_deg);
        let bound_m = moving.edge.rounding_bound_m(mesher.steps());
        let found_m = worst_m(&gpu, wgsl, &mesher, &moving);
        eprintln!("{found_m:.3} m, at most {bound_m:.3} m");
        assert!(found_m <= bound_m, "{found_m} > {bound_m}");
        // Negative control: a formula of which one term is a ten-thousandth off is beyond it.
        let wrong = wgsl.replace("along * along -", "0.9999 * along * along -");
        assert_ne!(wrong, wgsl);
        let found_m = worst_m(&gpu, &wrong, &mesher, &moving);
        assert!(found_m > bound_m, "{found_m} within {bound_m}");
    }
}
