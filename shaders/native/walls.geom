#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// `native/gs-line`, second draw: one invocation makes the wall below one boundary edge.
layout(lines) in;
layout(triangle_strip, max_vertices = 4) out;
#include "volume.glsl"

void main() {
    wall(0, 1);
}
