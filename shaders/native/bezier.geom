#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `pipelines`: one invocation divides a bicubic patch into cells, a strip a row of them, as far as the 128
// vertices of 2007 reach; or with PER_ROW makes one row of a patch, of up to 10 cells.
layout(points) in;
#ifdef PER_ROW
layout(triangle_strip, max_vertices = 22) out;
#else
layout(triangle_strip, max_vertices = 112) out;
#endif
#include "bezier.glsl"

layout(location = 0) flat in uint point[];
layout(location = 0) flat out uint number;

void vertex(uint square, uvec2 at, uint begins) {
    number = begins;
    gl_Position = clip_from_metres(on_patch(square, vec2(at) / float(mesh.cells)));
    EmitVertex();
}

void row(uint square, uint y) {
    for (uint x = 0; x <= mesh.cells; ++x) {
        uvec2 cell = uvec2(x, y);
        vertex(square, cell, mesh_triangle(square, cell, 0));
        vertex(square, cell + uvec2(0, 1), mesh_triangle(square, cell, 1));
    }
    EndPrimitive();
}

void main() {
#ifdef PER_ROW
    row(point[0] / mesh.cells, point[0] % mesh.cells);
#else
    for (uint y = 0; y < mesh.cells; ++y) {
        row(point[0], y);
    }
#endif
}
