// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the study measures.

use terrafill_results::{Direction, Kind, Metric, Primary, Scope};

/// Everything that the study measures.
pub(crate) const METRICS: [Metric; 4] = [
    Metric::time_ms(
        "readback_cpu_ms",
        "Process CPU time of reading colour and depth of the render targets back to the CPU: \
         allocation, copy, wait, and packing of rows.",
    )
    .covering(Scope::READ_BACK)
    .ranking(Primary::Cpu),
    Metric::time_ms("readback_wall_ms", "Wall clock over the same span.")
        .covering(Scope::READ_BACK)
        .ranking(Primary::Wall),
    Metric::neither(
        "readback_bytes",
        "bytes",
        Kind::Bytes,
        "Bytes of colour and depth that one read-back returns.",
    ),
    Metric {
        better: Direction::More,
        ..Metric::less(
            "readback_rate",
            "MB/s",
            Kind::Time,
            "Bytes of a read-back over its wall clock time, 1 MB = 10⁶ bytes.",
        )
        .covering(Scope::READ_BACK)
    },
];
