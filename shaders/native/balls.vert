#version 450
#extension GL_EXT_samplerless_texture_functions : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `balls`: one vertex takes a ball a step further, as balls/step.wgsl, or with TERRAIN as
// balls/fly.wgsl; transform feedback keeps it.
layout(xfb_buffer = 0, xfb_stride = 32) out;

struct Ball {
    vec4 place;
    vec4 velocity;
};

layout(set = 0, binding = 0, std140) uniform Constants {
    float step_s;
    float gravity;
    float stiffness;
    uint count;
#ifdef TERRAIN
    uint cells;
    float cell_m;
    uint blocks;
    uint law;
    float restitution;
#endif
};
layout(set = 0, binding = 1, std430) readonly buffer Before {
    Ball before[];
};
layout(location = 0, xfb_buffer = 0, xfb_offset = 0) precise out vec4 place;
layout(location = 1, xfb_buffer = 0, xfb_offset = 16) precise out vec4 velocity;

#ifdef TERRAIN
layout(set = 0, binding = 3) uniform texture2DArray heights;

const uint PUBLISHED = 0u;
const uint EVENT = 2u;
const uint CUTS = 8u;

// Slopes along x and y, and height.
vec3 ground_at(vec2 at_m) {
    vec2 at = at_m / cell_m;
    vec2 block = clamp(floor(at / float(cells)), vec2(0.0), vec2(float(blocks) - 1.0));
    vec2 inside = at - block * float(cells);
    vec2 cell = clamp(floor(inside), vec2(0.0), vec2(float(cells) - 1.0));
    vec2 share = inside - cell;
    ivec3 first = ivec3(ivec2(cell), int(block.y) * int(blocks) + int(block.x));
    float near = texelFetch(heights, first, 0).r;
    float right = texelFetch(heights, first + ivec3(1, 0, 0), 0).r;
    float below = texelFetch(heights, first + ivec3(0, 1, 0), 0).r;
    float far = texelFetch(heights, first + ivec3(1, 1, 0), 0).r;
    float across = mix(right - near, far - below, share.y);
    float down = mix(below - near, far - right, share.x);
    float height = mix(near, right, share.x) + share.y * down;
    return vec3(across / cell_m, down / cell_m, height);
}

vec3 flown(vec3 from, vec3 by, float time) {
    return from + time * vec3(by.xy, by.z - 0.5 * gravity * time);
}

float gap(vec3 at) {
    return at.z - ground_at(at.xy).z;
}

// The share of a step at which a ball meets the ground that it is below at its end.
float meets(vec3 from, vec3 by, float end) {
    vec2 low = vec2(0.0, gap(from));
    vec2 high = vec2(1.0, end);
    if (low.y <= 0.0) {
        return 0.0;
    }
    int side = 0;
    for (uint cut = 0u; cut < CUTS; ++cut) {
        float share = (high.x * low.y - low.x * high.y) / (low.y - high.y);
        float found = gap(flown(from, by, share * step_s));
        if (found > 0.0) {
            low = vec2(share, found);
            high.y *= side == 1 ? 0.5 : 1.0;
            side = 1;
        } else {
            high = vec2(share, found);
            low.y *= side == -1 ? 0.5 : 1.0;
            side = -1;
        }
    }
    return high.x;
}
#endif

void main() {
    Ball ball = before[gl_VertexIndex];
#ifdef TERRAIN
    vec3 from = ball.place.xyz;
    vec3 by = ball.velocity.xyz;
    vec3 to = flown(from, by, step_s);
    vec3 onward = vec3(by.xy, by.z - gravity * step_s);
    vec3 ground = ground_at(to.xy);
    float first = ball.velocity.w;
    if (to.z < ground.z) {
        float share = 1.0;
        if (law == EVENT) {
            share = meets(from, by, to.z - ground.z);
            float time = share * step_s;
            to = flown(from, by, time);
            ground = ground_at(to.xy);
            onward.z = by.z - gravity * time;
        }
        vec3 normal = normalize(vec3(-ground.xy, 1.0));
        float outwards = dot(onward, normal);
        if (outwards < 0.0 || law == PUBLISHED) {
            onward = onward - (1.0 + restitution) * outwards * normal;
            first = first == 0.0 ? ball.place.w + share : first;
        }
        if (law == EVENT) {
            float rest = (1.0 - share) * step_s;
            to = flown(vec3(to.xy, ground.z), onward, rest);
            onward.z = onward.z - gravity * rest;
        }
    }
    velocity = vec4(onward, first);
    place = vec4(to, ball.place.w + 1.0);
#else
    precise float acceleration = -gravity;
    if (ball.place.z < 0.0) {
        acceleration = acceleration - stiffness * ball.place.z;
    }
    velocity = ball.velocity;
    velocity.z = ball.velocity.z + step_s * acceleration;
    place = vec4(ball.place.xyz + step_s * velocity.xyz, ball.place.w);
#endif
    // Points have a size even where nothing draws them.
    gl_PointSize = 1.0;
}
