// SPDX-License-Identifier: MIT OR Apache-2.0
// What the geometry shaders of casters share: corners as `adjacent.wgsl` hands them over, and the
// sides of infinite volumes. Every side is emitted counter-clockwise seen from outside.

in gl_PerVertex {
    vec4 gl_Position;
} gl_in[];
out gl_PerVertex {
    vec4 gl_Position;
};

// Place from the eye, and whether the triangle that the corner speaks for is lit.
layout(location = 0) in vec4 place_and_lit[];
// The one end of all sides, in clip space.
layout(location = 1) in vec4 end[];
// The direction towards it.
layout(location = 2) in vec4 away[];

void emit(vec4 clip) {
    gl_Position = clip;
    EmitVertex();
}

// The side of an edge that leads from a to b in its lit triangle.
void side(int a, int b) {
    emit(gl_in[b].gl_Position);
    emit(gl_in[a].gl_Position);
    emit(end[a]);
    EndPrimitive();
}

bool bit(int corner) {
    return place_and_lit[corner].w > 0.5;
}

// The sign as an engine computes it, in the order in which the corners come.
bool computed(int a, int b, int c) {
    vec3 from = place_and_lit[a].xyz;
    vec3 normal = cross(place_and_lit[b].xyz - from, place_and_lit[c].xyz - from);
    return dot(normal, -away[a].xyz) > 0.0;
}
