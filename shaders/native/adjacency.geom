#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// `native/gs-adjacency`: one invocation makes 2 to 8 triangles of one: both caps, and a wall below
// each side without a neighbour. Corners are 0, 2, 4; the vertex after each is that of the
// neighbour across the side that follows, or, where there is none, the corner opposite the side.
// Where a strip turns the same way twice it says an older corner once more. Such a triangle has two
// equal corners and makes nothing, and to its two neighbours an end of the side between them says
// that there is no wall. Which corner comes first in every second triangle of a strip is not the
// same everywhere (llvmpipe begins with the oldest, Vulkan's table with the one after it), so
// nothing here asks for it.
layout(triangles_adjacency) in;
layout(triangle_strip, max_vertices = 18) out;
#include "volume.glsl"

void main() {
    if (number(0) == number(2) || number(2) == number(4) || number(4) == number(0)) {
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
