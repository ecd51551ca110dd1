// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_results::{Kind, Metric, Primary, Scope};

terrafill_results::conditions! {
    shared PART, SIZE_PX;
    ARITHMETIC = "arithmetic", "f64, f32, or f32 with compensated sums";
    BALLS = "balls", "how many balls fall at once";
    CRATER_WAY = "crater_way", "how first impacts of balls change the layers of the ground";
    DRAWN = "drawn", "how balls are drawn: not at all, in one draw, or in one each";
    GROUND = "ground", "what balls fall on";
    INTEGRATOR = "integrator", "how a ball is taken one step further";
    INTERFACE = "interface", "what takes the steps: the CPU, wgpu or Vulkan";
    STATE = "state", "where the state of balls lies";
    STEPS_PER_SECOND = "steps_per_second", "steps for a second of a ball";
    STIFFNESS = "stiffness", "of the spring between ball and ground, newtons a metre";
    WAY = "way", "how steps follow each other on a device";
    "order" = "the power of the step that an error falls with";
    "explicit-euler" = "position and velocity by the old velocity and acceleration";
    "symplectic-euler" = "velocity first, then position by the new velocity";
    "velocity-verlet" = "position by velocity and acceleration, velocity by the mean of both accelerations";
    "split-verlet" = "velocity-verlet, the step cut where the ball crosses the surface";
    "rk4" = "Runge–Kutta method of order 4";
    "implicit-euler" = "by the velocity and the acceleration at the end of the step";
    "implicit-midpoint" = "by velocity and acceleration in the middle of the step";
    "reflect-explicit" = "explicit-euler; the velocity turns round whenever the ball is below the surface";
    "reflect-symplectic" = "symplectic-euler; the velocity turns round whenever the ball is below the surface";
    "reflect-guarded" = "reflect-symplectic for a ball that moves downwards only, which is put onto the surface";
    "as-published" = "free flight; the velocity is reflected about the normal whenever the ball is below the ground";
    "inwards-only" = "the same, only where the velocity leads into the ground";
    "at-event" = "reflected where the ball met the ground, from which it flies on for the rest of the step";
    "cpu" = "the processor, without a device";
    "transform-feedback" = "the vertex shader steps balls, and transform feedback keeps them";
    "reflected" = "how a ball leaves the ground that it meets";
    "craters" = "what balls dig where they first meet the ground";
    "one-thread" = "balls stepped by one thread of the CPU, which writes them for the device to draw";
    "drawn-into-layers" = "a pass a layer takes the craters of a step off its heights";
    "written-by-cpu" = "the CPU reads the balls, computes their craters, and writes the layers that they strike";
    "exact-event" = "the step cut at the time at which the parabola meets the surface";
    "f32" = "single precision";
    "rms" = "root mean square";
    "height" = "of a ball above the ground";
    "CPU µs" = "microseconds of process CPU time";
    "worse below it" = "whether a smaller step than the best one has a larger error";
    "against time" = "error against the time that it takes";
}

terrafill_results::metrics! {
    BALL_CPU_US = time_us("ball_cpu_us", "Process CPU time of one second of one ball.")
        .covering(Scope::PLAN)
        .ranking(Primary::Any);
    BALL_RMS_M = metres(
        "ball_rms_m",
        "Root mean square error of height after 5 s against the closed form, over balls not blown up.",
    );
    BALL_BLOWN_SHARE = Metric::error(
        "ball_blown_share",
        "",
        "Share of the balls above 1 km, below −1 km or with more than ten times their first energy.",
    );
    BALL_ENERGY_CHANGE = Metric::neither(
        "ball_energy_change",
        "",
        Kind::Error,
        "Mean of energy at the end over energy at the start, less 1, over balls not blown up.",
    );
    BALL_DEEPEST_M = Metric::neither(
        "ball_deepest_m",
        "m",
        Kind::Error,
        "Largest depth below the surface, over balls not blown up.",
    );
    BALL_STEP_CPU_US = time_us(
        "ball_step_cpu_us",
        "Process CPU time of one step of all balls on a device, nothing drawn.",
    )
    .covering(Scope::DISPATCH);
    BALL_STEP_GPU_US = time_us(
        "ball_step_gpu_us",
        "GPU time of one step of all balls on a device, nothing drawn.",
    )
    .covering(Scope::DISPATCH);
    BALL_STEP_WALL_US = time_us(
        "ball_step_wall_us",
        "Wall time of one step of all balls on a device, nothing drawn.",
    )
    .covering(Scope::DISPATCH);
    BALL_DEVICE_MAX_M = metres(
        "ball_device_max_m",
        "Largest difference of a ball's height on a device from the same integrator in f64.",
    );
    BALL_DEVICE_RMS_M = metres(
        "ball_device_rms_m",
        "Root mean square difference of heights on a device from the same integrator in f64.",
    );
    BALL_DEVICE_JUDGED = Metric::quantity("ball_device_judged", "Balls compared with f64.");
    BALL_UPLOAD_BYTES = Metric::less(
        "ball_upload_bytes",
        "B",
        Kind::Bytes,
        "Bytes that the CPU wrote for the device during all steps.",
    );
    BALL_TERRAIN_STEP_M = metres(
        "ball_terrain_step_m",
        "Largest difference of a ball's place after one step from that of f64 from the same state, along an axis.",
    );
    BALL_TERRAIN_STEP_SPEED = Metric::error(
        "ball_terrain_step_speed",
        "m/s",
        "The same of its velocity.",
    );
    BALL_TERRAIN_FOLLOWED = Metric::quantity(
        "ball_terrain_followed",
        "Balls that were followed step by step.",
    );
    BALL_TERRAIN_IN_BAND = Metric::neither(
        "ball_terrain_in_band",
        "",
        Kind::Error,
        "Steps within 0.1 mm of a border or of the ground, which rounding decided otherwise than f64.",
    );
    BALL_IMPACTS = Metric::quantity(
        "ball_impacts",
        "Balls whose first impact was compared with the exact event.",
    );
    BALL_IMPACT_MAX_S = seconds(
        "ball_impact_max_s",
        "Largest difference of the time of a first impact from the exact event in f64.",
    );
    BALL_IMPACT_RMS_S = seconds(
        "ball_impact_rms_s",
        "Root mean square difference of times of first impacts from exact events in f64.",
    );
    BALL_IMPACT_PLACE_M = metres(
        "ball_impact_place_m",
        "Largest distance of the place of a first impact from the exact event in f64.",
    );
    BALL_IMPACT_ENERGY = Metric::error(
        "ball_impact_energy",
        "",
        "Largest difference of the energy that a first impact takes from what the restitution says, as a share of it.",
    );
    BALL_IMPACT_MISSED = Metric::error(
        "ball_impact_missed",
        "",
        "Share of the balls that had no first impact, or more than a step late.",
    );
    BALL_SUNK_SHARE = Metric::error(
        "ball_sunk_share",
        "",
        "Share of the balls that are more than 25 cm below the ground at the end.",
    );
    BALL_STRIKES = Metric::quantity("ball_strikes", "First impacts of balls, which make craters.");
    BALL_STRIKES_DIFFERING = Metric::error(
        "ball_strikes_differing",
        "",
        "Balls that meet the ground first in another step than in f64, though rounding does not decide it.",
    );
    BALL_BOUNCES_ON_CRATERS = Metric::quantity(
        "ball_bounces_on_craters",
        "Reflections of balls that end the step over a cell that a crater had changed before.",
    );
    BALL_CRATER_M = metres(
        "ball_crater_m",
        "Largest difference of a height after a step from that of f64 after the same step.",
    );
    BALL_CRATER_TORN = Metric::error(
        "ball_crater_torn",
        "",
        "Heights that differ between blocks that share them.",
    );
    BALL_MISMATCHED_PX = Metric::error_px(
        "ball_mismatched_px",
        "Pixels that show another ball, or other ground, than the reference allows, outside of the band of 1/32 pixel.",
    );
    BALL_DIFFERING_PX = Metric::error_px(
        "ball_differing_px",
        "Pixels that differ from those of one draw for all balls, stepped in the same way.",
    );
    BALL_DRAWS = Metric::counter("ball_draws", "Draw calls of a frame.");
    BALL_FRAME_CPU_US = time_us(
        "ball_frame_cpu_us",
        "Process CPU time of a frame: a step over terrain and the draws, each waited for.",
    )
    .covering(Scope::DISPATCH.and(Scope::DRAW));
    BALL_FRAME_WALL_US = time_us("ball_frame_wall_us", "Wall clock over the same span.")
        .covering(Scope::DISPATCH.and(Scope::DRAW));
    BALL_DRAW_CPU_US = time_us(
        "ball_draw_cpu_us",
        "Process CPU time of the draws of a frame alone.",
    )
    .covering(Scope::DRAW);
    BALL_DRAW_GPU_US = time_us(
        "ball_draw_gpu_us",
        "GPU time of the draws of a frame, where the device keeps it.",
    )
    .covering(Scope::DRAW);
}

const fn time_us(name: &'static str, meaning: &'static str) -> Metric {
    Metric::less(name, "µs", Kind::Time, meaning)
}

const fn seconds(name: &'static str, meaning: &'static str) -> Metric {
    Metric::error(name, "s", meaning)
}

/// A difference from the reference in metres.
const fn metres(name: &'static str, meaning: &'static str) -> Metric {
    Metric::error(name, "m", meaning)
}
