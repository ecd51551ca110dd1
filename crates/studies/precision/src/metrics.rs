// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the study measures.

use terrafill_results::{Kind, Metric, Primary, Scope};

/// An error by formula.
const fn formula(name: &'static str, unit: &'static str, meaning: &'static str) -> Metric {
    Metric::neither(name, unit, Kind::Error, meaning)
}

pub(crate) const METRICS: [Metric; 33] = [
    Metric::quantity("points", "Places at which the error was measured."),
    Metric::error(
        "non_finite_emulated",
        "",
        "Answers of the emulation that are NaN or infinite.",
    ),
    Metric::error(
        "non_finite_device",
        "",
        "Answers of the device that are NaN or infinite.",
    ),
    Metric::error(
        "emulated_max_m",
        "m",
        "Largest error of the shader's steps run in `f32` on the CPU, metres on the ground or in space.",
    ),
    Metric::error("emulated_rms_m", "m", "Root mean square of those errors."),
    Metric::error(
        "device_max_m",
        "m",
        "Largest error of the shader's text run on the device, metres.",
    ),
    Metric::error("device_rms_m", "m", "Root mean square of those errors."),
    Metric::error(
        "device_max_rad",
        "rad",
        "Largest error on the device of longitude or latitude, radians.",
    ),
    Metric::error(
        "device_rms_rad",
        "rad",
        "Root mean square error on the device, the larger of longitude's and latitude's, radians.",
    ),
    Metric::neither(
        "texture_px",
        "texels",
        Kind::Counter,
        "Texels along each side of the picture over the extent, in which `max_texels` counts.",
    ),
    Metric::error(
        "max_texels",
        "texels",
        "Largest error on the device along one axis of the picture, texels. Places nearer to a pole than a texel do not count: there a row of texels is one place.",
    ),
    Metric::error(
        "rms_texels",
        "texels",
        "Root mean square error on the device along one axis, texels, as above.",
    ),
    Metric::neither(
        "pixel_m",
        "m",
        Kind::Counter,
        "Size on the ground of the pixels in which `max_px` counts: the region's height over 1,080 rows, or a view of 60° over as many at the row's distance.",
    ),
    Metric::error("max_px", "px", "Largest error on the device, pixels."),
    Metric::error(
        "rms_px",
        "px",
        "Root mean square error on the device, pixels.",
    ),
    formula(
        "residual_max_m",
        "m",
        "Largest error by formula, metres: what the steps leave out in exact arithmetic, sampled densely, and the bound of what a device that keeps to the specification may round. It is computed for every region anew.",
    ),
    formula(
        "residual_rms_m",
        "m",
        "Root mean square error by formula, metres: roundings taken as independent.",
    ),
    formula(
        "residual_max_rad",
        "rad",
        "Largest error by formula, radians of longitude or latitude.",
    ),
    formula(
        "residual_rms_rad",
        "rad",
        "Root mean square error by formula, radians, the larger of the two.",
    ),
    formula(
        "expected_max_rad",
        "rad",
        "Largest error by formula on a device that rounds every step correctly: 2.5 standard deviations of independent roundings in the bound's place, radians. A texture is read as this device's sampler weighs it, which is asked first.",
    ),
    Metric::error(
        "max_over_residual",
        "",
        "`device_max_m` over `residual_max_m`. Above 1.02, what sampling may miss of a peak, the bound does not hold and the row is wrong.",
    ),
    Metric::error(
        "rms_over_residual",
        "",
        "The same of the root mean squares.",
    ),
    Metric::error(
        "measured_over_expected",
        "",
        "`device_max_rad` over `expected_max_rad`; of positions and vertices, `rms_over_residual`.",
    ),
    Metric::counter(
        "add_mul_fma",
        "Sums, differences, products and fused ones of a formula.",
    ),
    Metric::counter("divisions", "Divisions."),
    Metric::counter(
        "compares_selects",
        "Comparisons, selects, minima and maxima.",
    ),
    Metric::counter("sqrt", "Square roots and inverse ones."),
    Metric::counter(
        "transcendental",
        "Calls of the device's own `atan`, `atan2` and powers.",
    ),
    Metric::counter("texture_fetches", "Texels loaded and samples taken."),
    Metric::counter(
        "operations_cost",
        "All of them in fused multiply-adds, weighted as the chooser of a route does: a division 5, a square root 4, a transcendental 30, a fetch 100.",
    ),
    Metric::quantity(
        "chosen",
        "Whether a frame plan takes this route in the row's region: the cheapest whose residual is within ¼ texel and ¼ pixel RMS and ½ texel at most.",
    ),
    // Of an evaluation beyond the empty formula, by the two clocks.
    Metric::less(
        "cpu_ns",
        "ns",
        Kind::Time,
        "CPU time of the process for one evaluation of a formula beyond that of the empty one in the \
         same block. On a software device this is the device's time. It may be negative where the \
         formula costs less than the clock's noise.",
    )
    .covering(Scope::DISPATCH)
    .ranking(Primary::Cpu),
    Metric::less("gpu_ns", "ns", Kind::Time, "The same by the GPU's clock.")
        .covering(Scope::DISPATCH)
        .ranking(Primary::Gpu),
];
