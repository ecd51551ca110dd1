#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// `native/gs-degenerate`: one invocation makes two triangles of one. A proper triangle becomes both
// caps; a degenerate one (a, b, b) stands for the boundary edge from a to b and becomes its wall.
// One index buffer and one draw hold a whole region. Cozzi (2007), chapter on geometry shaders.
// In strips the first corner is always the oldest index, and the other two are swapped in every
// second triangle (Vulkan, "Triangle Strips"). So indices a b b are (a, b, b) wherever they stand;
// a b a, where a strip turns the same way twice, and a a b, between two edges, have the first
// corner twice and make nothing.
layout(triangles) in;
layout(triangle_strip, max_vertices = 6) out;
#include "volume.glsl"

void main() {
    if (number(1) == number(2)) {
        wall(0, 1);
    } else if (number(0) != number(1) && number(0) != number(2)) {
        caps(0, 1, 2);
    }
}
