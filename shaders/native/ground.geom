#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `pipelines`: two invocations make the 8 x 8 cells of a patch, four rows each, as a strip a row; none of a
// patch whose point the vertex shader labelled as culled. One invocation's 144 vertices would be over the
// usual limit of 1,024 components.
layout(points, invocations = 2) in;
layout(triangle_strip, max_vertices = 72) out;

#include "ground.glsl"

layout(location = 0) flat in uint label[];
layout(location = 0) flat out uint number;

const uint CULLED = 0xffffffffu;
const uint ROWS = PATCH_CELLS / 2u;

void vertex(uvec2 at, uint begins) {
    number = begins;
    gl_Position = clip_at(at);
    EmitVertex();
}

void main() {
    if (label[0] == CULLED) {
        return;
    }
    uvec2 first = first_cell(label[0]) + uvec2(0u, ROWS * gl_InvocationID);
    for (uint y = 0u; y < ROWS; ++y) {
        for (uint x = 0u; x <= PATCH_CELLS; ++x) {
            uvec2 cell = first + uvec2(x, y);
            vertex(cell, triangle_number(cell, 0u));
            vertex(cell + uvec2(0u, 1u), triangle_number(cell, 1u));
        }
        EndPrimitive();
    }
}
