// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the study measures.

use terrafill_results::{Metric, Primary, Scope};

/// Everything that the study measures.
pub(crate) const METRICS: [Metric; 2] = [
    Metric::time_ms(
        "mesh_cpu_ms",
        "Process CPU time from the outline as GeoJSON text to its mesh, in a process of its own.",
    )
    .covering(Scope::PLAN)
    .ranking(Primary::Any),
    Metric::quantity(
        "vertices_of_outline",
        "Vertices of the shape's outline: about as many as the case is named after.",
    ),
];
