// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions that outlines alone have, and what is measured of them. Study `shadows` says in its glossary what the
//! conditions are.

use terrafill_results::{ConditionKey, Metric, Scope};

/// How many models are outlined.
pub const MODELS: ConditionKey = ConditionKey::declare("models");
/// How contours within a model are left out.
pub const OUTLINE: ConditionKey = ConditionKey::declare("outline");
/// Width of strokes along contours, pixels.
pub const STROKE_PX: ConditionKey = ConditionKey::declare("stroke_px");

terrafill_results::metrics! {
    pub;
    /// Frames, by the process.
    OUTLINE_CPU_MS = Metric::time_ms(
        "shadow_outline_cpu_ms",
        "Process CPU time in which a device draws all models with their outlines in a picture of `size_px`, every clear of the stencil included; models and contour edges are there already.",
    )
    .covering(Scope::FRAME);
    /// Frames, by the device.
    OUTLINE_GPU_MS =
        Metric::time_ms("shadow_outline_gpu_ms", "GPU time of the same.").covering(Scope::DEVICE);
    /// Wrong pixels.
    SHADOW_CONTOUR_PX = Metric::error_px(
        "shadow_contour_px",
        "Pixels of a device's picture with outlines that show what the method leaves there by no rounding, in f64. They are strokes inside their own model, strokes missing beside it, and any other number of a model.",
    );
    /// Clears.
    SHADOW_CLEARS = Metric::counter(
        "shadow_clears",
        "Clears of the stencil in a frame with outlines, the first included, as the device was told.",
    );
    /// Pixels unlike those of clears.
    SHADOW_OUTLINE_UNLIKE_PX = Metric::error_px(
        "shadow_outline_unlike_px",
        "Pixels that show another number than the same frame with a clear for each model.",
    );
    /// Strokes.
    SHADOW_OUTLINE_PX = Metric::neither(
        "shadow_outline_px",
        "px",
        terrafill_results::Kind::Counter,
        "Pixels that must show a stroke, by the reference.",
    );
    /// Where rounding decides.
    SHADOW_OUTLINE_UNDECIDED_PX = Metric::neither(
        "shadow_outline_undecided_px",
        "px",
        terrafill_results::Kind::Counter,
        "Pixels of which rounding decides what they show: a border within 1/32 of a pixel, or depths that are equal in f32.",
    );
}
