// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the study measures.

use terrafill_results::{Kind, Metric, Primary, Scope};

/// Everything that the study measures.
pub(crate) const METRICS: [Metric; 2] = [
    Metric::less(
        "mesh_cpu_ms",
        "ms",
        Kind::Time,
        "Process CPU time from the outline as GeoJSON text to its mesh, in a process of its own.",
    )
    .covering(Scope::PLAN)
    .ranking(Primary::Any),
    Metric::neither(
        "vertices_of_outline",
        "",
        Kind::Counter,
        "Vertices of the shape's outline: about as many as the case is named after.",
    ),
];
