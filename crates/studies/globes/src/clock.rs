// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which times are compared, by the clock that a device is read by.

use terrafill_results::Clock;

/// Of a whole frame.
pub(crate) fn whole(clock: Clock) -> &'static str {
    clock.pick("globe_whole_gpu_ms", "globe_whole_cpu_ms")
}

/// Of drawing it.
pub(crate) fn draw(clock: Clock) -> &'static str {
    clock.pick("globe_draw_gpu_ms", "globe_draw_cpu_ms")
}
