// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whether the compiler at hand keeps the order in which two-float positions are subtracted.
//!
//! WGSL lets compilers add up floats in another order, and SPIR-V forbids it only with
//! `NoContraction`, which naga does not write. The shader's own function is therefore run on the
//! device; summed up the other way round, it would be off by what the low parts held, which the control
//! shows. Metres, ECEF. Skipped without a device.

use glam::{DVec3, Vec3};
use terrafill_gpu::{Evaluator, GpuOptions, Kernel, open_for_test};
use terrafill_stencil::{two_float, two_float_difference_m};

const RIGHT: &str = "(high - eye_high) + (low - eye_low)";
const REASSOCIATED: &str = "(high + low) - (eye_high + eye_low)";

/// The function as the volumes' shaders have it, and constants for the eye.
fn shader() -> String {
    let composed = terrafill_shaders::compose("vertex/doubled.wgsl").expect("ships");
    let start = composed
        .find("fn two_float_difference_m")
        .expect("is there");
    let length = composed[start..].find("\n}").expect("ends");
    let function = &composed[start..start + length + 2];
    assert_eq!(function.matches(RIGHT).count(), 1, "{function}");
    format!("struct Eye {{ high: vec4f, low: vec4f }}\n{function}\n")
}

/// Vertices around an eye on the ground, from a millimetre to 10 km away.
fn offsets() -> Vec<DVec3> {
    (0..4096)
        .map(|i| {
            let turn = f64::from(i) * 2.399_963_229_7;
            let distance_m = 10_f64.powf(-3.0 + 7.0 * f64::from(i) / 4096.0);
            let height = (f64::from(i) * 0.618_033_988_7).fract() * 2.0 - 1.0;
            let radius = (1.0 - height * height).sqrt();
            DVec3::new(radius * turn.cos(), radius * turn.sin(), height) * distance_m
        })
        .collect()
}

/// Along x, as the device has it: the vertex's parts are inputs, the eye's are constants.
fn differences(wgsl: &str, vertices: &[[Vec3; 2]], eye: [Vec3; 2]) -> Option<Vec<Vec3>> {
    let gpu = open_for_test(&GpuOptions::default())?;
    let kernel = Kernel {
        name: "two-float difference",
        wgsl,
        constants: Some("Eye"),
        call: "vec4f(two_float_difference_m(vec3f(x.x), vec3f(x.y), constants.high.xyz, \
            constants.low.xyz), 0.0)",
        table: None,
    };
    let evaluator = Evaluator::new(&gpu, &kernel, 2).expect("compiles");
    let constants = eye.map(|part| part.extend(0.0).to_array());
    evaluator.set_constants(&constants).expect("room");
    // One axis at a time: an input has four components, and a vertex six.
    let axis = |axis: usize| {
        let inputs: Vec<[f32; 4]> = vertices
            .iter()
            .map(|[high, low]| [high[axis], low[axis], 0.0, 0.0])
            .collect();
        let answer = evaluator.evaluate(&inputs).expect("runs");
        answer
            .values
            .iter()
            .map(|value| value[axis])
            .collect::<Vec<f32>>()
    };
    let [x, y, z] = [0, 1, 2].map(axis);
    Some(
        (0..vertices.len())
            .map(|i| Vec3::new(x[i], y[i], z[i]))
            .collect(),
    )
}

#[test]
fn the_device_subtracts_in_the_order_that_survives() {
    let eye_ecef = DVec3::new(4_449_212.345_67, 784_516.123_45, 4_487_348.987_65);
    let eye = two_float(eye_ecef);
    let offsets = offsets();
    let vertices: Vec<[Vec3; 2]> = offsets
        .iter()
        .map(|offset| two_float(eye_ecef + *offset))
        .collect();
    let right = shader();
    let Some(found) = differences(&right, &vertices, eye) else {
        return;
    };
    // What rounding to two floats and to the result may move: 2⁻⁴⁸ of the radius and 2⁻²³ of the
    // distance, and a margin of two.
    let excess = |found: &[Vec3]| {
        let places = found.iter().zip(&offsets);
        let share = places.map(|(found, offset)| {
            let error = (found.as_dvec3() - *offset).abs().max_element();
            error / (2.0 * (6.4e6 * 2_f64.powi(-48) + offset.length() * 2_f64.powi(-23)))
        });
        share.fold(0.0, f64::max)
    };
    let largest = excess(&found);
    eprintln!("two floats: {largest} of what rounding allows");
    assert!(largest < 1.0, "{largest}");
    // To the bit as on the processor, where nothing is reassociated.
    let on_processor = vertices
        .iter()
        .map(|vertex| two_float_difference_m(*vertex, eye));
    assert!(found.iter().copied().eq(on_processor));
    // Negative control: the other order, on purpose, is off by decimetres, whatever the distance.
    let wrong = right.replace(RIGHT, REASSOCIATED);
    let found = differences(&wrong, &vertices, eye).expect("the same device");
    let error_m = found
        .iter()
        .zip(&offsets)
        .map(|(found, offset)| (found.as_dvec3() - *offset).abs().max_element());
    let largest_m = error_m.fold(0.0, f64::max);
    eprintln!("reassociated: {largest_m} m");
    assert!(
        excess(&found) > 1e4 && (0.1..1.0).contains(&largest_m),
        "{largest_m} m"
    );
}
