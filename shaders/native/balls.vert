#version 450
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `balls`: one vertex takes a ball a step further, as balls/step.wgsl; transform feedback keeps it.
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
};
layout(set = 0, binding = 1, std430) readonly buffer Before {
    Ball before[];
};
layout(location = 0, xfb_buffer = 0, xfb_offset = 0) precise out vec4 place;
layout(location = 1, xfb_buffer = 0, xfb_offset = 16) precise out vec4 velocity;

void main() {
    Ball ball = before[gl_VertexIndex];
    precise float acceleration = -gravity;
    if (ball.place.z < 0.0) {
        acceleration = acceleration - stiffness * ball.place.z;
    }
    velocity = ball.velocity;
    velocity.z = ball.velocity.z + step_s * acceleration;
    place = vec4(ball.place.xyz + step_s * velocity.xyz, ball.place.w);
    // Points have a size even where nothing draws them.
    gl_PointSize = 1.0;
}
