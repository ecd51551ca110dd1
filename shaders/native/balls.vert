#version 450
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `balls`: one vertex takes a ball a step further, as balls/step.wgsl, or with TERRAIN as
// balls/step_terrain.wgsl; transform feedback keeps it.
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
#endif
};
layout(set = 0, binding = 1, std430) readonly buffer Before {
    Ball before[];
};
layout(location = 0, xfb_buffer = 0, xfb_offset = 0) precise out vec4 place;
layout(location = 1, xfb_buffer = 0, xfb_offset = 16) precise out vec4 velocity;

#ifdef TERRAIN
layout(set = 0, binding = 3, std430) readonly buffer Heights {
    float heights[];
};

// Slopes along x and y, and height.
vec3 ground_at(vec2 at_m) {
    vec2 at = at_m / cell_m;
    float last = float(cells - 1u);
    vec2 cell = clamp(floor(at), vec2(0.0), vec2(last));
    vec2 share = at - cell;
    uint side = cells + 1u;
    uint first = uint(cell.y) * side + uint(cell.x);
    float near = heights[first];
    float right = heights[first + 1u];
    float below = heights[first + side];
    float far = heights[first + side + 1u];
    float across = mix(right - near, far - below, share.y);
    float down = mix(below - near, far - right, share.x);
    float height = mix(near, right, share.x) + share.y * down;
    return vec3(across / cell_m, down / cell_m, height);
}
#endif

void main() {
    Ball ball = before[gl_VertexIndex];
#ifdef TERRAIN
    vec3 ground = ground_at(ball.place.xy);
    precise vec3 acceleration = vec3(0.0, 0.0, -gravity);
    float under = ground.z - ball.place.z;
    if (under > 0.0) {
        vec3 normal = normalize(vec3(-ground.xy, 1.0));
        acceleration = acceleration + stiffness * under * normal.z * normal;
    }
    velocity = vec4(ball.velocity.xyz + step_s * acceleration, ball.velocity.w);
    place = vec4(ball.place.xyz + step_s * velocity.xyz, ball.place.w);
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
