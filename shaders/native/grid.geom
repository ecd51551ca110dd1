#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `pipelines`: one invocation makes CELLS x CELLS cells of a point, as a strip a cell in the order
// published in 2007, or with PER_ROW as a strip a row, which fetches inner columns once. With IMAGE the
// cells are those of a geometry image.
layout(points) in;
#ifdef DECLARED
// More than are emitted: what some devices pay for.
layout(triangle_strip, max_vertices = DECLARED) out;
#elif defined(PER_ROW)
layout(triangle_strip, max_vertices = 2 * CELLS * (CELLS + 1)) out;
#else
layout(triangle_strip, max_vertices = 4 * CELLS * CELLS) out;
#endif
#ifdef IMAGE
#include "image.glsl"
#else
#include "grid.glsl"
#endif

layout(location = 0) flat in uint point[];
layout(location = 0) flat out uint number;

void vertex(uvec2 at, uint begins) {
    number = begins;
    gl_Position = clip_at(at);
    EmitVertex();
}

void main() {
    uint points = grid.cells / CELLS;
    uvec2 first = CELLS * uvec2(point[0] % points, point[0] / points);
    for (uint y = 0; y < CELLS; ++y) {
#ifdef PER_ROW
        for (uint x = 0; x <= CELLS; ++x) {
            uvec2 cell = first + uvec2(x, y);
            vertex(cell, triangle_number(cell, 0));
            vertex(cell + uvec2(0, 1), triangle_number(cell, 1));
        }
        EndPrimitive();
#else
        for (uint x = 0; x < CELLS; ++x) {
            uvec2 cell = first + uvec2(x, y);
            vertex(cell, triangle_number(cell, 0));
            vertex(cell + uvec2(1, 0), triangle_number(cell, 1));
            vertex(cell + uvec2(0, 1), triangle_number(cell, 0));
            vertex(cell + uvec2(1, 1), triangle_number(cell, 0));
            EndPrimitive();
        }
#endif
    }
}
