// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is measured.

use terrafill_results::{Kind, Metric, Primary, Scope};

pub(crate) const METRICS: [Metric; 28] = [
    Metric::less(
        "ball_cpu_us",
        "µs",
        Kind::Time,
        "Process CPU time of one second of one ball.",
    )
    .covering(Scope::PLAN)
    .ranking(Primary::Any),
    Metric::error(
        "ball_rms_m",
        "m",
        "Root mean square error of height after 5 s against the closed form, over balls not blown up.",
    ),
    Metric::error(
        "ball_blown_share",
        "",
        "Share of the balls above 1 km, below −1 km or with more than ten times their first energy.",
    ),
    Metric::neither(
        "ball_energy_change",
        "",
        Kind::Error,
        "Mean of energy at the end over energy at the start, less 1, over balls not blown up.",
    ),
    Metric::neither(
        "ball_deepest_m",
        "m",
        Kind::Error,
        "Largest depth below the surface, over balls not blown up.",
    ),
    Metric::less(
        "ball_step_cpu_us",
        "µs",
        Kind::Time,
        "Process CPU time of one step of all balls on a device, nothing drawn.",
    )
    .covering(Scope::DISPATCH),
    Metric::less(
        "ball_step_gpu_us",
        "µs",
        Kind::Time,
        "GPU time of one step of all balls on a device, nothing drawn.",
    )
    .covering(Scope::DISPATCH),
    Metric::less(
        "ball_step_wall_us",
        "µs",
        Kind::Time,
        "Wall time of one step of all balls on a device, nothing drawn.",
    )
    .covering(Scope::DISPATCH),
    Metric::error(
        "ball_device_max_m",
        "m",
        "Largest difference of a ball's height on a device from the same integrator in f64.",
    ),
    Metric::error(
        "ball_device_rms_m",
        "m",
        "Root mean square difference of heights on a device from the same integrator in f64.",
    ),
    Metric::quantity("ball_device_judged", "Balls compared with f64."),
    Metric::less(
        "ball_upload_bytes",
        "B",
        Kind::Bytes,
        "Bytes that the CPU wrote for the device during all steps.",
    ),
    Metric::error(
        "ball_terrain_max_m",
        "m",
        "Largest distance of a ball over terrain from the same integrator in f64, after 240 steps.",
    ),
    Metric::error(
        "ball_terrain_p95_m",
        "m",
        "95th percentile of that distance: at a border of cells slopes jump, and a ball there may leave otherwise.",
    ),
    Metric::error(
        "ball_terrain_beyond",
        "",
        "Balls over terrain that end more than 1 mm from the same integrator in f64.",
    ),
    Metric::error(
        "ball_terrain_unexplained",
        "",
        "Those of them that never touched the ground in another cell than f64 had them in.",
    ),
    Metric::error(
        "ball_terrain_guided_m",
        "m",
        "Largest distance from f64 that takes the device's cell within 0.5 mm of a border, after 240 steps.",
    ),
    Metric::error(
        "ball_terrain_step_m",
        "m",
        "Largest difference of a ball's place after one step from that of f64 from the same state, along an axis.",
    ),
    Metric::error(
        "ball_terrain_step_speed",
        "m/s",
        "The same of its velocity.",
    ),
    Metric::quantity(
        "ball_terrain_followed",
        "Balls that were followed step by step.",
    ),
    Metric::error(
        "ball_terrain_rms_m",
        "m",
        "Root mean square of that distance.",
    ),
    Metric::error_px(
        "ball_mismatched_px",
        "Pixels that show another ball than the reference allows, outside of the band of 1/32 pixel.",
    ),
    Metric::error_px(
        "ball_differing_px",
        "Pixels that differ from those of one draw for all balls, stepped in the same way.",
    ),
    Metric::counter("ball_draws", "Draw calls of a frame."),
    Metric::less(
        "ball_frame_cpu_us",
        "µs",
        Kind::Time,
        "Process CPU time of a frame: a step over terrain and the draws, each waited for.",
    )
    .covering(Scope::DISPATCH.and(Scope::DRAW)),
    Metric::less(
        "ball_frame_wall_us",
        "µs",
        Kind::Time,
        "Wall clock over the same span.",
    )
    .covering(Scope::DISPATCH.and(Scope::DRAW)),
    Metric::less(
        "ball_draw_cpu_us",
        "µs",
        Kind::Time,
        "Process CPU time of the draws of a frame alone.",
    )
    .covering(Scope::DRAW),
    Metric::less(
        "ball_draw_gpu_us",
        "µs",
        Kind::Time,
        "GPU time of the draws of a frame, where the device keeps it.",
    )
    .covering(Scope::DRAW),
];
