#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// `native/gs-per-triangle`: one invocation makes a closed volume of 8 triangles of every triangle.
// Walls inside a region are drawn twice, facing both ways, and must cancel to the pixel: they are the
// same triangles corner by corner, from the lower number's bottom, and the second one is drawn by a
// pipeline with front and back exchanged (`TURNED`), which draws nothing else. Turned over by the order of
// its corners it would be clipped in that order, and what is left split along another diagonal.
// Walls on the boundary must be those of every technique, from the edge's start to its end. Numbers
// ascend along the boundary, and where one does not the edge is the triangle's first side
// (`ring_order.rs`), which is never turned over.
// Cozzi (2007) started from such volumes.
layout(triangles) in;
layout(triangle_strip, max_vertices = 18) out;
#include "volume.glsl"

layout(constant_id = 1) const bool TURNED = false;

void side(int a, int b) {
    bool is_turned = number(a) > number(b);
    if (is_turned && TURNED) {
        wall(b, a);
    } else if (!is_turned && !TURNED) {
        wall(a, b);
    }
}

void main() {
    if (!TURNED) {
        caps(0, 1, 2);
        wall(0, 1);
    }
    side(1, 2);
    side(2, 0);
}
