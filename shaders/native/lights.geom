#version 450
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `pipelines`: one invocation copies a triangle into the layers of all LIGHTS, as published in 2007, or of a
// list's layers, at most COPIES of them; or with INVOCATIONS into the layer of its own number. With NUMBERED it hands on
// the triangle's number.
#ifdef LIGHTS
#define COPIES LIGHTS
#endif
#ifdef INVOCATIONS
layout(triangles, invocations = INVOCATIONS) in;
layout(triangle_strip, max_vertices = 3) out;
#else
layout(triangles) in;
layout(triangle_strip, max_vertices = 3 * COPIES) out;
#endif

#include "lights.glsl"

layout(location = 0) in vec3 place[];

out gl_PerVertex {
    invariant vec4 gl_Position;
};

void copy(uint light) {
    for (uint vertex = 0u; vertex < 3u; ++vertex) {
        gl_Layer = int(light);
#ifdef NUMBERED
        gl_PrimitiveID = gl_PrimitiveIDIn;
#endif
        gl_Position = seen_by(light, place[vertex]);
        EmitVertex();
    }
    EndPrimitive();
}

void main() {
#ifdef INVOCATIONS
    copy(uint(gl_InvocationID));
#else
#ifdef LIGHTS
    const uint count = LIGHTS;
#else
    uint count = lights.count;
#endif
    for (uint light = 0u; light < count; ++light) {
        copy(light);
    }
#endif
}
