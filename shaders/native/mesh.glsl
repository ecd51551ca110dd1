// SPDX-License-Identifier: MIT OR Apache-2.0
// Mesh of square cells, as `shared/mesh.wgsl` has it.
layout(set = 0, binding = 0) uniform MeshConstants {
    vec4 x;
    vec4 y;
    vec4 z;
    vec4 origin;
    uint cells;
} mesh;

vec4 clip_from_metres(vec3 place) {
    vec4 level = fma(mesh.z, vec4(place.z), mesh.origin);
    return fma(mesh.x, vec4(place.x), fma(mesh.y, vec4(place.y), level));
}

uint mesh_triangle(uint square, uvec2 cell, uint second) {
    return 2u * ((square * mesh.cells + cell.y) * mesh.cells + cell.x) + second + 1u;
}
