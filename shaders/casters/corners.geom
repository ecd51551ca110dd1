#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// As `triangles.geom`, where no facing bit is stored: one invocation computes the facing of its triangle and
// of the neighbours from their corners in `f32`. An invocation at the other side of an edge has the same
// corners in another order.
layout(triangles_adjacency) in;
layout(triangle_strip, max_vertices = 9) out;
#include "sides.glsl"

void main() {
    if (!computed(0, 2, 4)) {
        return;
    }
    if (!computed(2, 0, 1)) {
        side(0, 2);
    }
    if (!computed(4, 2, 3)) {
        side(2, 4);
    }
    if (!computed(0, 4, 5)) {
        side(4, 0);
    }
}
