// SPDX-License-Identifier: MIT OR Apache-2.0
//! What both parts of the study measure of a frame, and the conditions that both name.

use terrafill_results::{ConditionKey, Kind, Metric, Primary, Scope};

/// Cells a side, or vertices a turn.
pub const CELLS: ConditionKey = ConditionKey::declare("n");
/// Path of the camera.
pub const PATH: ConditionKey = ConditionKey::declare("path");
/// Which pictures the globe is shaded with.
pub const PICTURES: ConditionKey = ConditionKey::declare("pictures");

/// Pixels of some sort, of which neither more nor fewer are better.
#[must_use]
pub const fn pixels(name: &'static str, meaning: &'static str) -> Metric {
    Metric::neither(name, "px", Kind::Counter, meaning)
}

terrafill_results::metrics! {
    pub;
    /// A whole frame, process CPU time.
    GLOBE_WHOLE_CPU_MS = Metric::time_ms(
        "globe_whole_cpu_ms",
        "Process CPU time of a frame whose eye has moved: making, uploading and drawing the surface.",
    ).covering(Scope::PLAN.and(Scope::FRAME)).ranking(Primary::Cpu);
    /// A whole frame: making and uploading on the CPU, and the GPU's time of drawing.
    GLOBE_WHOLE_GPU_MS = Metric::time_ms(
        "globe_whole_gpu_ms",
        "Process CPU time of making and uploading, and the GPU's time of drawing. The device's copies of what was uploaded are in neither.",
    ).covering(Scope::PLAN.and(Scope::DEVICE)).ranking(Primary::Gpu);
    /// A whole frame, wall clock.
    GLOBE_WHOLE_WALL_MS = Metric::time_ms(
        "globe_whole_wall_ms",
        "Wall clock of making, uploading and drawing.",
    ).covering(Scope::PLAN.and(Scope::FRAME));
    /// Making what a frame draws.
    GLOBE_MAKE_CPU_MS = Metric::time_ms(
        "globe_make_cpu_ms",
        "Process CPU time of making the view's triangles.",
    ).covering(Scope::PLAN);
    /// Handing it to the device.
    GLOBE_UPLOAD_CPU_MS = Metric::time_ms(
        "globe_upload_cpu_ms",
        "Process CPU time of handing them to the device, which copies them later.",
    ).covering(Scope::UPLOAD);
    /// Drawing it, process CPU time.
    GLOBE_DRAW_CPU_MS = Metric::time_ms(
        "globe_draw_cpu_ms",
        "Process CPU time of drawing them, until the device is done.",
    ).covering(Scope::DEVICE);
    /// Drawing it, the GPU's time.
    GLOBE_DRAW_GPU_MS = Metric::time_ms(
        "globe_draw_gpu_ms",
        "GPU time of the pass that draws them.",
    ).covering(Scope::DEVICE);
    /// Bytes that a frame hands to the device.
    GLOBE_UPLOAD_BYTES = Metric::bytes(
        "globe_upload_bytes",
        "Bytes of vertices, indices and constants handed to the device for a frame.",
    );
    /// Bytes that the device keeps for all views.
    GLOBE_STORED_BYTES = Metric::bytes(
        "globe_stored_bytes",
        "Bytes of vertices and indices that the device keeps for all views.",
    );
    /// Triangles of a frame.
    GLOBE_TRIANGLES = Metric::counter("globe_triangles", "Triangles of the view.");
    /// Vertices of a frame.
    GLOBE_VERTICES = Metric::counter("globe_vertices", "Vertices of the view.");
}
