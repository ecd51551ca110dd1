#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// `native/gs-two-edges`: one invocation makes two or four triangles of one. A triangle that begins
// with its smallest number becomes both caps; (a, b, b) stands for the boundary edge from a to b;
// any other (b, c, a) for the edges from a over b to c. Half the indices of the boundary.
layout(triangles) in;
layout(triangle_strip, max_vertices = 6) out;
#include "volume.glsl"

void main() {
    if (number(1) == number(2)) {
        wall(0, 1);
    } else if (number(0) > number(1) || number(0) > number(2)) {
        top(2);
        bottom(2);
        top(0);
        bottom(0);
        top(1);
        bottom(1);
        EndPrimitive();
    } else {
        caps(0, 1, 2);
    }
}
