// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_results::{Direction, Kind, Metric, Primary, Scope};

terrafill_results::conditions! {
    shared API, SIZE_PX;
}

pub(crate) const CPU: &Metric = &Metric::time_ms(
    "readback_cpu_ms",
    "Process CPU time of reading colour and depth of the render targets back to the CPU: \
     allocation, copy, wait, and packing of rows.",
)
.covering(Scope::READ_BACK)
.ranking(Primary::Cpu);
pub(crate) const WALL: &Metric =
    &Metric::time_ms("readback_wall_ms", "Wall clock over the same span.")
        .covering(Scope::READ_BACK)
        .ranking(Primary::Wall);
pub(crate) const BYTES: &Metric = &Metric::neither(
    "readback_bytes",
    "bytes",
    Kind::Bytes,
    "Bytes of colour and depth that one read-back returns.",
);
pub(crate) const RATE: &Metric = &Metric {
    better: Direction::More,
    ..Metric::less(
        "readback_rate",
        "MB/s",
        Kind::Time,
        "Bytes of a read-back over its wall clock time, 1 MB = 10⁶ bytes.",
    )
    .covering(Scope::READ_BACK)
};

/// Everything that the study measures.
pub(crate) const METRICS: [Metric; 4] = [*CPU, *WALL, *BYTES, *RATE];
