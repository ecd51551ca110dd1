// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_results::{Kind, Metric, Primary, Scope};

terrafill_results::conditions! {
    shared PART;
    ANCHOR = "anchor", "where a region's own coordinates begin";
    CONDITION = "condition", "what makes the case hard";
    DEPTH_FORMAT = "depth_format", "format of the depth that positions come from";
    DISTANCE_M = "distance_m", "of the eye, metres";
    EXTENT_DEG = "extent_deg", "size of a region, degrees";
    FAMILY = "family", "kind of formula";
    HIGHEST_M = "highest_m", "highest ground, metres";
    KNOB = "knob", "what makes a formula finer";
    LATITUDE_DEG = "latitude_deg", "of a region, degrees";
    LOWEST_M = "lowest_m", "lowest ground, metres";
    OF_PART = "of_part", "part whose worst case this is";
    ROUTE = "route", "formulas from a position to a texture coordinate";
}

/// An error by formula.
const fn formula(name: &'static str, unit: &'static str, meaning: &'static str) -> Metric {
    Metric::neither(name, unit, Kind::Error, meaning)
}

terrafill_results::metrics! {
    POINTS = Metric::quantity("points", "Places at which the error was measured.");
    NON_FINITE_EMULATED = Metric::error(
        "non_finite_emulated",
        "",
        "Answers of the emulation that are NaN or infinite.",
    );
    NON_FINITE_DEVICE = Metric::error(
        "non_finite_device",
        "",
        "Answers of the device that are NaN or infinite.",
    );
    EMULATED_MAX_M = Metric::error(
        "emulated_max_m",
        "m",
        "Largest error of the shader's steps run in `f32` on the CPU, metres on the ground or in space.",
    );
    EMULATED_RMS_M = Metric::error("emulated_rms_m", "m", "Root mean square of those errors.");
    DEVICE_MAX_M = Metric::error(
        "device_max_m",
        "m",
        "Largest error of the shader's text run on the device, metres.",
    );
    DEVICE_RMS_M = Metric::error("device_rms_m", "m", "Root mean square of those errors.");
    DEVICE_MAX_RAD = Metric::error(
        "device_max_rad",
        "rad",
        "Largest error on the device of longitude or latitude, radians.",
    );
    DEVICE_RMS_RAD = Metric::error(
        "device_rms_rad",
        "rad",
        "Root mean square error on the device, the larger of longitude's and latitude's, radians.",
    );
    TEXTURE_PX = Metric::neither(
        "texture_px",
        "texels",
        Kind::Counter,
        "Texels along each side of the picture over the extent, in which `max_texels` counts.",
    );
    MAX_TEXELS = Metric::error(
        "max_texels",
        "texels",
        "Largest error on the device along one axis of the picture, texels. Places nearer to a pole than a texel do not count: there a row of texels is one place.",
    );
    RMS_TEXELS = Metric::error(
        "rms_texels",
        "texels",
        "Root mean square error on the device along one axis, texels, as above.",
    );
    PIXEL_M = Metric::neither(
        "pixel_m",
        "m",
        Kind::Counter,
        "Size on the ground of the pixels in which `max_px` counts: the region's height over 1,080 rows, or a view of 60° over as many at the row's distance.",
    );
    MAX_PX = Metric::error("max_px", "px", "Largest error on the device, pixels.");
    RMS_PX = Metric::error(
        "rms_px",
        "px",
        "Root mean square error on the device, pixels.",
    );
    RESIDUAL_MAX_M = formula(
        "residual_max_m",
        "m",
        "Largest error by formula, metres: what the steps leave out in exact arithmetic, sampled densely, and the bound of what a device that keeps to the specification may round. It is computed for every region anew.",
    );
    RESIDUAL_RMS_M = formula(
        "residual_rms_m",
        "m",
        "Root mean square error by formula, metres: roundings taken as independent.",
    );
    RESIDUAL_MAX_RAD = formula(
        "residual_max_rad",
        "rad",
        "Largest error by formula, radians of longitude or latitude.",
    );
    RESIDUAL_RMS_RAD = formula(
        "residual_rms_rad",
        "rad",
        "Root mean square error by formula, radians, the larger of the two.",
    );
    EXPECTED_MAX_RAD = formula(
        "expected_max_rad",
        "rad",
        "Largest error by formula on a device that rounds every step correctly: 2.5 standard deviations of independent roundings in the bound's place, radians. A texture is read as this device's sampler weighs it, which is asked first.",
    );
    MAX_OVER_RESIDUAL = Metric::error(
        "max_over_residual",
        "",
        "`device_max_m` over `residual_max_m`. Above 1.02, what sampling may miss of a peak, the bound does not hold and the row is wrong.",
    );
    RMS_OVER_RESIDUAL = Metric::error(
        "rms_over_residual",
        "",
        "The same of the root mean squares.",
    );
    MEASURED_OVER_EXPECTED = Metric::error(
        "measured_over_expected",
        "",
        "`device_max_rad` over `expected_max_rad`; of positions and vertices, `rms_over_residual`.",
    );
    ADD_MUL_FMA = Metric::counter(
        "add_mul_fma",
        "Sums, differences, products and fused ones of a formula.",
    );
    DIVISIONS = Metric::counter("divisions", "Divisions.");
    COMPARES_SELECTS = Metric::counter(
        "compares_selects",
        "Comparisons, selects, minima and maxima.",
    );
    SQRT = Metric::counter("sqrt", "Square roots and inverse ones.");
    TRANSCENDENTAL = Metric::counter(
        "transcendental",
        "Calls of the device's own `atan`, `atan2` and powers.",
    );
    TEXTURE_FETCHES = Metric::counter("texture_fetches", "Texels loaded and samples taken.");
    OPERATIONS_COST = Metric::counter(
        "operations_cost",
        "All of them in fused multiply-adds, weighted as the chooser of a route does: a division 5, a square root 4, a transcendental 30, a fetch 100.",
    );
    CHOSEN = Metric::quantity(
        "chosen",
        "Whether a frame plan takes this route in the row's region: the cheapest whose residual is within ¼ texel and ¼ pixel RMS and ½ texel at most.",
    );
    // Of an evaluation beyond the empty formula, by the two clocks.
    CPU_NS = Metric::less(
        "cpu_ns",
        "ns",
        Kind::Time,
        "CPU time of the process for one evaluation of a formula beyond that of the empty one in the \
         same block. On a software device this is the device's time. It may be negative where the \
         formula costs less than the clock's noise.",
    )
    .covering(Scope::DISPATCH)
    .ranking(Primary::Cpu);
    GPU_NS = Metric::less("gpu_ns", "ns", Kind::Time, "The same by the GPU's clock.")
        .covering(Scope::DISPATCH)
        .ranking(Primary::Gpu);
}
