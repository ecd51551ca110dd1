// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_results::{Direction, Kind, Metric, Primary, Scope};

terrafill_results::conditions! {
    shared API, SIZE_PX;
}

terrafill_results::metrics! {
    CPU = Metric::time_ms(
        "readback_cpu_ms",
        "Process CPU time of reading colour and depth of the render targets back to the CPU: \
         allocation, copy, wait, and packing of rows.",
    )
    .covering(Scope::READ_BACK)
    .ranking(Primary::Cpu);
    WALL = Metric::time_ms("readback_wall_ms", "Wall clock over the same span.")
        .covering(Scope::READ_BACK)
        .ranking(Primary::Wall);
    BYTES = Metric::neither(
        "readback_bytes",
        "bytes",
        Kind::Bytes,
        "Bytes of colour and depth that one read-back returns.",
    );
    RATE = Metric {
        better: Direction::More,
        ..Metric::less(
            "readback_rate",
            "MB/s",
            Kind::Time,
            "Bytes of a read-back over its wall clock time, 1 MB = 10⁶ bytes.",
        )
        .covering(Scope::READ_BACK)
    };
}
