#version 450
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `pipelines`: one vertex deforms a vertex of a mesh, as `shared/dents.wgsl`; transform feedback keeps it.
layout(xfb_buffer = 0, xfb_stride = 16) out;

struct Dent {
    vec4 middle;
    vec4 push;
};

layout(set = 0, binding = 1, std430) readonly buffer Rest {
    vec4 rest[];
};
layout(set = 0, binding = 2, std430) readonly buffer Dents {
    Dent dents[];
};
layout(location = 0, xfb_buffer = 0, xfb_offset = 0) out vec4 kept;

void main() {
    vec3 place = rest[gl_VertexIndex].xyz;
    vec3 sum = place;
    for (uint number = 0; number < dents.length(); ++number) {
        Dent dent = dents[number];
        vec3 away = (place - dent.middle.xyz) / dent.middle.w;
        float inside = max(0.0, 1.0 - dot(away, away));
        sum += dent.push.xyz * (inside * inside);
    }
    kept = vec4(sum, 1.0);
    // Points have a size even where nothing draws them.
    gl_PointSize = 1.0;
}
