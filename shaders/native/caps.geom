#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// `native/gs-line`, first draw: one invocation makes both caps' triangles of one.
layout(triangles) in;
layout(triangle_strip, max_vertices = 6) out;
#include "volume.glsl"

void main() {
    caps(0, 1, 2);
}
