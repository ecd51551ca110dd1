// SPDX-License-Identifier: MIT OR Apache-2.0
// Ground in tiles of patches, as `shared/ground.wgsl` has it.

layout(set = 0, binding = 0) uniform GroundConstants {
    vec4 column;
    vec4 row;
    vec4 height;
    vec4 origin;
    ivec2 eye_cell;
    float eye_height_m;
    uint cells;
    uint tiles;
    uint listed;
    uint test;
    float range;
} ground;
layout(set = 0, binding = 1) uniform texture2D heights;

const uint PATCH_CELLS = 8u;

vec4 clip_at(uvec2 vertex) {
    float height_m = texelFetch(heights, ivec2(vertex), 0).r - ground.eye_height_m;
    vec2 place = vec2(ivec2(vertex) - ground.eye_cell);
    vec4 level = fma(ground.height, vec4(height_m), ground.origin);
    return fma(ground.column, vec4(place.x), fma(ground.row, vec4(place.y), level));
}

uvec2 first_cell(uint patch_number) {
    uint side = ground.cells / PATCH_CELLS;
    return PATCH_CELLS * uvec2(patch_number % side, patch_number / side);
}

uint triangle_number(uvec2 cell, uint second) {
    return 2u * (cell.y * ground.cells + cell.x) + second + 1u;
}
