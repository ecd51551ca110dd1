#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `pipelines`: one invocation says that its patch is divided into as many cells on all sides and inside.
layout(vertices = 1) out;
#include "mesh.glsl"

layout(location = 0) flat in uint point[];
layout(location = 0) out uint square[];

void main() {
    square[gl_InvocationID] = point[gl_InvocationID];
    float cells = float(mesh.cells);
    gl_TessLevelOuter[0] = cells;
    gl_TessLevelOuter[1] = cells;
    gl_TessLevelOuter[2] = cells;
    gl_TessLevelOuter[3] = cells;
    gl_TessLevelInner[0] = cells;
    gl_TessLevelInner[1] = cells;
}
