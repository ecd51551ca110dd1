// SPDX-License-Identifier: MIT OR Apache-2.0
// Grid of heights, as `shared/grid.wgsl` has it.
layout(set = 0, binding = 0) uniform GridConstants {
    vec4 column;
    vec4 row;
    vec4 height;
    vec4 origin;
    uint cells;
} grid;
layout(set = 0, binding = 1) uniform texture2D heights;

vec4 clip_at(uvec2 vertex) {
    float height_m = texelFetch(heights, ivec2(vertex), 0).r;
    vec4 level = fma(grid.height, vec4(height_m), grid.origin);
    vec2 place = vec2(vertex);
    return fma(grid.column, vec4(place.x), fma(grid.row, vec4(place.y), level));
}

uint triangle_number(uvec2 cell, uint second) {
    return 2u * (cell.y * grid.cells + cell.x) + second + 1u;
}
