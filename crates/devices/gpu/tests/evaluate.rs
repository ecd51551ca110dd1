// SPDX-License-Identifier: MIT OR Apache-2.0
//! The evaluator gives what the device computes, counts what is not finite, and says what it cannot
//! take. Skipped without a device; see `device.rs`.

use std::sync::Arc;
use terrafill_contract::DeviceError;
use terrafill_core::nearest_f32;
use terrafill_gpu::{
    EVALUATIONS_PER_DISPATCH, EvaluateError, Evaluation, Evaluator, Gpu, GpuOptions, Kernel,
    RouteTexelFormat, RouteTexels, open_for_test,
};

/// Answers of which one of the first `components` is NaN or infinite.
fn non_finite(answer: &Evaluation, components: usize) -> usize {
    let is_bad = |value: &&[f32; 4]| value.iter().take(components).any(|v| !v.is_finite());
    answer.values.iter().filter(is_bad).count()
}

/// Single floats in one row.
fn row(width: u32, is_filtered: bool, bytes: Vec<u8>) -> RouteTexels {
    RouteTexels {
        format: RouteTexelFormat::R32Float,
        is_filtered,
        size: [width, 1],
        is_cube: false,
        bytes,
    }
}

/// A polynomial of the input's first component, with its coefficients as constants.
const CUBIC: &str = "
struct Coefficients { c: vec4f }
fn cubic(x: f32, k: Coefficients) -> f32 {
    return fma(fma(fma(k.c.w, x, k.c.z), x, k.c.y), x, k.c.x);
}
";

const CUBIC_KERNEL: Kernel<'_> = Kernel {
    name: "cubic",
    wgsl: CUBIC,
    constants: Some("Coefficients"),
    call: "vec4f(cubic(x.x, constants), x.y, 0.0, 0.0)",
    table: None,
};

const COEFFICIENTS: [f32; 4] = [0.25, -1.5, 3.0, 0.125];

fn cubic(x: f32) -> f64 {
    let [a, b, c, d] = COEFFICIENTS.map(f64::from);
    let x = f64::from(x);
    ((d * x + c) * x + b) * x + a
}

fn gpu() -> Option<Arc<Gpu>> {
    open_for_test(&GpuOptions::default())
}

/// Inputs in −1 … 1.
fn inputs(count: usize) -> Vec<[f32; 4]> {
    let at = |i: usize| nearest_f32(2.0 * i as f64 / count as f64 - 1.0);
    (0..count).map(|i| [at(i), 7.0, 0.0, 0.0]).collect()
}

/// Largest difference from the polynomial in `f64`.
fn largest_error(values: &[[f32; 4]], inputs: &[[f32; 4]]) -> f64 {
    assert_eq!(values.len(), inputs.len());
    let errors = values
        .iter()
        .zip(inputs)
        .map(|(value, input)| (f64::from(value[0]) - cubic(input[0])).abs());
    errors.fold(0.0, f64::max)
}

#[test]
fn more_inputs_than_a_dispatch_takes_are_taken_in_several() {
    let Some(gpu) = gpu() else { return };
    let evaluator = Evaluator::new(&gpu, &CUBIC_KERNEL, 1).expect("compiles");
    evaluator.set_constants(&[COEFFICIENTS]).expect("room");
    let inputs = inputs(2 * EVALUATIONS_PER_DISPATCH + 5);
    let answer = evaluator.evaluate(&inputs).expect("runs");
    assert_eq!(answer.dispatches, 3);
    assert_eq!(non_finite(&answer, 4), 0);
    // Four roundings of numbers below 8.
    let bound = 4.0 * 8.0 * f64::from(f32::EPSILON);
    assert!(largest_error(&answer.values, &inputs) < bound);
    assert!(
        answer
            .values
            .iter()
            .all(|value| value[1].to_bits() == 7_f32.to_bits())
    );
    assert!(evaluator.evaluate(&[]).expect("runs").values.is_empty());
    // Negative control: a wrong coefficient on the device alone is noticed.
    let wrong = Kernel {
        wgsl: &CUBIC.replace("k.c.z", "(k.c.z * 1.001)"),
        ..CUBIC_KERNEL
    };
    let wrong = Evaluator::new(&gpu, &wrong, 1).expect("compiles");
    wrong.set_constants(&[COEFFICIENTS]).expect("room");
    let answer = wrong.evaluate(&inputs).expect("runs");
    assert!(largest_error(&answer.values, &inputs) > 100.0 * bound);
}

#[test]
fn what_is_not_finite_is_counted() {
    let Some(gpu) = gpu() else { return };
    let kernel = Kernel {
        name: "reciprocal",
        wgsl: "",
        constants: None,
        call: "vec4f(1.0 / x.x, x.x / x.x, x.y, 0.0)",
        table: None,
    };
    let evaluator = Evaluator::new(&gpu, &kernel, 0).expect("compiles");
    let inputs = [
        [2.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0],
        [f32::NAN, 0.0, 0.0, 0.0],
        [f32::INFINITY, 0.0, 0.0, 0.0],
        [1.0, f32::INFINITY, 0.0, 0.0],
    ];
    let answer = evaluator.evaluate(&inputs).expect("runs");
    assert_eq!(non_finite(&answer, 2), 3, "{:?}", answer.values);
    assert_eq!(non_finite(&answer, 1), 2, "1 / ∞ is 0");
    assert_eq!(non_finite(&answer, 3), 4);
    // Negative control: numbers only.
    let numbers = evaluator.evaluate(&inputs[..1]).expect("runs");
    assert_eq!(non_finite(&numbers, 4), 0);
}

#[test]
fn what_it_cannot_take_is_said() {
    let Some(gpu) = gpu() else { return };
    let evaluator = Evaluator::new(&gpu, &CUBIC_KERNEL, 1).expect("compiles");
    let error = evaluator.set_constants(&[COEFFICIENTS; 2]).err();
    let message = error.expect("refused").to_string();
    assert_eq!(message, "cubic: 2 vectors of constants, allowed: at most 1");
    let broken = Kernel {
        call: "vec4f(cubic(x, constants))",
        ..CUBIC_KERNEL
    };
    match Evaluator::new(&gpu, &broken, 1) {
        Err(EvaluateError::Backend(DeviceError::Shader { name, message })) => {
            assert_eq!(name, "cubic");
            assert!(message.contains("cubic"), "{message}");
        }
        other => panic!("{other:?}"),
    }
    let texels = row(3, false, vec![0; 8]);
    let short = Kernel {
        table: Some(&texels),
        ..Kernel::BASELINE
    };
    let message = Evaluator::new(&gpu, &short, 0).err().map(|e| e.to_string());
    assert_eq!(
        message.as_deref(),
        Some("empty: a table of 8 bytes, needs 12")
    );
}

#[test]
fn tables_are_read_by_texel_and_by_sampler() {
    let Some(gpu) = gpu() else { return };
    let texels: Vec<u8> = [1.0_f32, 3.0, -2.0, 0.5]
        .iter()
        .flat_map(|texel| texel.to_le_bytes())
        .collect();
    let first = |is_filtered| {
        let table = row(4, is_filtered, texels.clone());
        let kernel = Kernel {
            name: "table",
            wgsl: "@group(1) @binding(0) var route_table: texture_2d<f32>;
                @group(1) @binding(1) var route_sampler: sampler;",
            constants: None,
            call: "vec4f(textureLoad(route_table, vec2i(i32(x.x), 0), 0).x,
                textureSampleLevel(route_table, route_sampler, vec2f((x.x + 1.0) * 0.25, 0.5), 0.0).x,
                0.0, 0.0)",
            table: Some(&table),
        };
        let evaluator = Evaluator::new(&gpu, &kernel, 0).expect("compiles");
        evaluator.evaluate(&[[0.0; 4]]).expect("runs").values[0]
    };
    // The sampler is read half way between the first two texels.
    let linear = first(true);
    assert!(
        (linear[0] - 1.0).abs() < 1e-6 && (linear[1] - 2.0).abs() < 0.02,
        "{linear:?}"
    );
    let nearest = first(false);
    assert!((nearest[1] - 2.0).abs() > 0.5, "{nearest:?}");
}

#[test]
fn a_cube_is_read_by_direction() {
    let Some(gpu) = gpu() else { return };
    // Two floats a texel: the face's number and its negative.
    let texels: Vec<u8> = [0.0_f32, 1.0, 2.0, 3.0, 4.0, 5.0]
        .iter()
        .flat_map(|face| [[*face, -*face]; 4])
        .flatten()
        .flat_map(f32::to_le_bytes)
        .collect();
    let faces = RouteTexels {
        format: RouteTexelFormat::Rg32Float,
        is_filtered: true,
        size: [2; 2],
        is_cube: true,
        bytes: texels,
    };
    let kernel = Kernel {
        name: "cube",
        wgsl: "@group(1) @binding(0) var route_cube: texture_cube<f32>;
            @group(1) @binding(1) var route_sampler: sampler;",
        constants: None,
        call: "vec4f(textureSampleLevel(route_cube, route_sampler, x.xyz, 0.0).xy, 0.0, 0.0)",
        table: Some(&faces),
    };
    let evaluator = Evaluator::new(&gpu, &kernel, 0).expect("compiles");
    let directions = [
        [3.0, 0.0, 0.0, 0.0],
        [0.0, -1.0, 0.0, 0.0],
        [0.0, 0.0, 2.0, 0.0],
    ];
    let values = evaluator.evaluate(&directions).expect("runs").values;
    let faces: Vec<[f32; 2]> = values.iter().map(|value| [value[0], value[1]]).collect();
    assert_eq!(faces, [[0.0, 0.0], [3.0, -3.0], [4.0, -4.0]]);
}

#[test]
fn twice_the_evaluations_take_longer_and_the_empty_kernel_takes_less() {
    let Some(gpu) = gpu() else { return };
    let heavy = Kernel {
        name: "heavy",
        wgsl: "",
        constants: None,
        call: "atan2(x, x.yzwx + 2.0)",
        table: None,
    };
    let least = |kernel: &Kernel<'_>, turns: u32| {
        let mut evaluator = Evaluator::new(&gpu, kernel, 0).expect("compiles");
        evaluator.prepare_timing(&inputs(4096), [1e-6; 4], turns);
        let times = (0..7).map(|_| evaluator.time(turns).expect("runs"));
        let times: Vec<_> = times.collect();
        assert!(
            times
                .iter()
                .all(|t| t.evaluations == 4096 * 4 * u64::from(turns))
        );
        assert!(times.iter().all(|t| t.gpu_ms.is_none_or(|ms| ms > 0.0)));
        times.iter().map(|t| t.cpu_ms).fold(f64::INFINITY, f64::min)
    };
    let (short, long) = (least(&heavy, 64), least(&heavy, 256));
    assert!(
        long > 2.0 * short,
        "{short} ms, four times as much {long} ms"
    );
    let empty = least(&Kernel::BASELINE, 256);
    assert!(2.0 * empty < long, "empty {empty} ms, heavy {long} ms");
}
