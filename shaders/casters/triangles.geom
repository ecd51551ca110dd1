#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// Silhouettes of casters: one invocation makes a side below each edge of a lit triangle whose
// neighbour is not lit: 0 to 3 triangles. Caps are drawn beside. Facing bits come with the corners: one a triangle, decided
// once. Corners are 0, 2, 4; the vertex after each is the neighbour's across the edge that follows.
layout(triangles_adjacency) in;
layout(triangle_strip, max_vertices = 9) out;
#include "sides.glsl"

void main() {
    if (!bit(0)) {
        return;
    }
    if (!bit(1)) {
        side(0, 2);
    }
    if (!bit(3)) {
        side(2, 4);
    }
    if (!bit(5)) {
        side(4, 0);
    }
}
