#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// `native/gs-per-triangle`: one invocation makes a closed volume of 8 triangles of every triangle.
// Walls inside a region are drawn twice, facing both ways, and must cancel to the pixel. So the
// second one is the first one's triangles turned over: the same diagonal, always from the lower
// number's bottom, and the last two corners swapped, since a rasteriser that brings all triangles
// into one winding keeps the first corner where it is and computes the same depths to the bit.
// Walls on the boundary must be those of every technique, from the edge's start to its end. Numbers
// ascend along the boundary, and where one does not the edge is the triangle's first side
// (`ring_order.rs`), which is never turned over.
// Cozzi (2007) started from such volumes.
layout(triangles) in;
layout(triangle_strip, max_vertices = 24) out;
#include "volume.glsl"

void side(int a, int b) {
    if (number(a) < number(b)) {
        wall(a, b);
    } else {
        top(b);
        top(a);
        bottom(b);
        EndPrimitive();
        bottom(b);
        top(a);
        bottom(a);
        EndPrimitive();
    }
}

void main() {
    caps(0, 1, 2);
    wall(0, 1);
    side(1, 2);
    side(2, 0);
}
