#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// Silhouettes of casters: one invocation makes the side of an edge of whose two triangles one is lit. Caps are
// drawn as the mesh itself. The edge is 1, 2; the corners opposite to it are 0, of the triangle that has the
// edge forwards, and 3.
layout(lines_adjacency) in;
layout(triangle_strip, max_vertices = 3) out;
#include "sides.glsl"

void main() {
    if (bit(0) && !bit(3)) {
        side(1, 2);
    } else if (!bit(0) && bit(3)) {
        side(2, 1);
    }
}
