#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// `native/gs-degenerate`: one invocation makes two triangles of one. A proper triangle becomes both
// caps; a degenerate one (a, b, b) stands for the boundary edge from a to b and becomes its wall.
// One index buffer and one draw hold a whole region. Cozzi (2007), chapter on geometry shaders.
layout(triangles) in;
layout(triangle_strip, max_vertices = 6) out;
#include "volume.glsl"

void main() {
    if (number(1) == number(2)) {
        wall(0, 1);
    } else {
        caps(0, 1, 2);
    }
}
