// SPDX-License-Identifier: MIT OR Apache-2.0
// Bicubic patches, as `shared/bezier.wgsl` has them.
#include "mesh.glsl"

layout(set = 0, binding = 1, std430) readonly buffer Control {
    vec4 control[];
};

vec4 weights(float at) {
    float rest = 1.0 - at;
    return vec4(rest * rest * rest, 3.0 * rest * rest * at, 3.0 * rest * at * at, at * at * at);
}

vec3 between(uint first, vec4 by) {
    vec3 near = fma(control[first + 1u].xyz, vec3(by.y), control[first].xyz * by.x);
    return fma(control[first + 3u].xyz, vec3(by.w), fma(control[first + 2u].xyz, vec3(by.z), near));
}

// Metres, at a place from 0 to 1 either way.
vec3 on_patch(uint number, vec2 at) {
    vec4 across = weights(at.x);
    vec4 down = weights(at.y);
    uint first = 16u * number;
    vec3 near = fma(between(first + 4u, across), vec3(down.y), between(first, across) * down.x);
    vec3 middle = fma(between(first + 8u, across), vec3(down.z), near);
    return fma(between(first + 12u, across), vec3(down.w), middle);
}
