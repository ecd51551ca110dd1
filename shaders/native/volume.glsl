// SPDX-License-Identifier: MIT OR Apache-2.0
// What the geometry shaders share: corners of a volume as `volume.wgsl` hands them over, and the
// faces made of them. Every face is emitted so that it is counter-clockwise seen from outside.

in gl_PerVertex {
    vec4 gl_Position; // top
} gl_in[];
out gl_PerVertex {
    vec4 gl_Position;
};

// x, y, w of the bottom and the vertex's number.
layout(location = 0) in vec4 bottom_and_number[];

// What every vertex of a region carries and every fragment gets: its colour, or its number.
#if defined(COLOURED)
layout(location = 1) in vec4 carried[];
layout(location = 0) flat out vec4 handed_on;
#elif defined(NUMBERED)
layout(location = 1) in float carried[];
layout(location = 0) flat out float handed_on;
#endif

// Where only what lies in front of the surface counts, no bottom is ever seen.
layout(constant_id = 0) const bool DRAWS_BOTTOM = true;

float number(int corner) {
    return bottom_and_number[corner].w;
}

void emit(int corner, vec4 clip) {
#if defined(COLOURED) || defined(NUMBERED)
    handed_on = carried[corner];
#endif
    gl_Position = clip;
    EmitVertex();
}

void top(int corner) {
    emit(corner, gl_in[corner].gl_Position);
}

void bottom(int corner) {
    vec4 packed = bottom_and_number[corner];
    emit(corner, vec4(packed.xy, gl_in[corner].gl_Position.z, packed.z));
}

// The triangle on top, and turned over below.
void caps(int a, int b, int c) {
    top(a);
    top(b);
    top(c);
    EndPrimitive();
    if (DRAWS_BOTTOM) {
        bottom(a);
        bottom(c);
        bottom(b);
        EndPrimitive();
    }
}

// The wall below the edge from a to b, inside on its left; split from the bottom of a to the top
// of b, like the strips of the vertex-shader technique.
void wall(int a, int b) {
    top(a);
    bottom(a);
    top(b);
    bottom(b);
    EndPrimitive();
}
