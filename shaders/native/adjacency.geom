#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// `native/gs-adjacency`: one invocation makes 2 to 8 triangles of one: both caps, and a wall below
// each side without a neighbour. Corners are 0, 2, 4; the vertex after each is that of the
// neighbour across the side that follows, or, where there is none, the corner opposite the side.
// In strips the newest corner is always the third one (Vulkan, "Triangle Strips With Adjacency").
// Where a strip turns the same way twice that is an older corner once more: such a triangle makes
// nothing, and to its two neighbours an end of the side between them says that there is no wall.
layout(triangles_adjacency) in;
layout(triangle_strip, max_vertices = 18) out;
#include "volume.glsl"

void main() {
    if (number(4) == number(0) || number(4) == number(2)) {
        return;
    }
    caps(0, 2, 4);
    if (number(1) == number(4)) {
        wall(0, 2);
    }
    if (number(3) == number(0)) {
        wall(2, 4);
    }
    if (number(5) == number(2)) {
        wall(4, 0);
    }
}
