// SPDX-License-Identifier: MIT OR Apache-2.0
// Geometry image, as `shared/image.wgsl` has it, cut as published; under the names that `grid.glsl` has.
#include "mesh.glsl"
#define grid mesh

layout(set = 0, binding = 1) uniform texture2D places;

vec4 clip_at(uvec2 vertex) {
    return clip_from_metres(texelFetch(places, ivec2(vertex), 0).xyz);
}

uint triangle_number(uvec2 cell, uint second) {
    return mesh_triangle(0u, cell, second);
}
