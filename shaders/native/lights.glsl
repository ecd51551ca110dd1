// SPDX-License-Identifier: MIT OR Apache-2.0
// Lights over a grid of heights, as `shared/lit.wgsl` has them; with LISTED layers of listed triangles, as
// `shared/layers.wgsl`. LIGHTS says for how many lights a shader is compiled.

#ifdef LIGHTS
const uint MOST_LIGHTS = LIGHTS;
#elif defined(LISTED)
const uint MOST_LIGHTS = 128u;
#else
const uint MOST_LIGHTS = 16u;
#endif

struct Light {
    vec4 column;
    vec4 row;
    vec4 height;
    vec4 origin;
};
layout(set = 0, binding = 2, std140) uniform Lights {
    Light each[MOST_LIGHTS];
    uint count;
} lights;

// By fused steps, so that no compiler has a choice and every way finds the same bits.
vec4 seen_by(uint number, vec3 place) {
    Light light = lights.each[number];
    vec4 level = fma(light.height, vec4(place.z), light.origin);
    return fma(light.column, vec4(place.x), fma(light.row, vec4(place.y), level));
}
