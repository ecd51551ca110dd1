#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `pipelines`: one invocation places a vertex of a divided patch, and says where it lies in cells.
layout(quads, equal_spacing, ccw) in;
#include "bezier.glsl"

layout(location = 0) in uint squares[];
layout(location = 0) flat out uint square;
layout(location = 1) out vec2 at;

void main() {
    square = squares[0];
    at = gl_TessCoord.xy * float(mesh.cells);
    gl_Position = clip_from_metres(on_patch(square, gl_TessCoord.xy));
}
