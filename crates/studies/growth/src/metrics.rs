// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_results::{Metric, Primary, Scope};

terrafill_results::conditions! {
    shared ;
    OUTLINE_VERTICES = "outline_vertices", "vertices of an outline";
    SHAPE = "shape", "family of outlines";
}

terrafill_results::metrics! {
    /// A mesh is made on the CPU, whatever the device.
    TIME = Metric::time_ms(
        "mesh_cpu_ms",
        "Process CPU time from the outline as GeoJSON text to its mesh, in a process of its own.",
    )
    .covering(Scope::PLAN)
    .ranking(Primary::Any);
    VERTICES = Metric::quantity(
        "vertices_of_outline",
        "Vertices of the shape's outline: about as many as the case is named after.",
    );
}
