#version 450
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `globes`: one invocation splits a triangle across 180 degrees (A. Jeromel, StuCoSReC 2018, section 2.4). Two
// corners whose U differ by more than LIMIT get a vertex between them with U = 0 in one part and 1 in the other.
// Both sides of an edge find it from the same operands in the same order, so that no crack opens.
layout(triangles) in;
layout(triangle_strip, max_vertices = 9) out;

layout(location = 0) in float corner_u[];
layout(location = 0) out float u;

bool is_split(int i, int j) {
    return abs(corner_u[i] - corner_u[j]) > LIMIT;
}

// Place on the edge where U passes 1.
vec4 inserted(int one, int other) {
    bool is_high = corner_u[one] > corner_u[other];
    int high = is_high ? one : other;
    int low = is_high ? other : one;
    float rest = 1.0 - corner_u[high];
    return mix(gl_in[high].gl_Position, gl_in[low].gl_Position, rest / (rest + corner_u[low]));
}

float side(int i) {
    return corner_u[i] > 0.5 ? 1.0 : 0.0;
}

void vertex(vec4 clip, float at) {
    u = at;
    gl_Position = clip;
    EmitVertex();
}

void corner(int i) {
    vertex(gl_in[i].gl_Position, corner_u[i]);
}

void main() {
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3;
        int k = (i + 2) % 3;
        // The corner that is alone on its side.
        if (is_split(i, j) && is_split(i, k) && !is_split(j, k)) {
            vec4 p = inserted(i, j);
            vec4 q = inserted(i, k);
            corner(i);
            vertex(p, side(i));
            vertex(q, side(i));
            EndPrimitive();
            vertex(p, side(j));
            corner(j);
            corner(k);
            EndPrimitive();
            vertex(p, side(j));
            corner(k);
            vertex(q, side(j));
            EndPrimitive();
            return;
        }
    }
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3;
        int k = (i + 2) % 3;
        // One edge alone: what is right on one of its sides is not on the other.
        if (is_split(i, j)) {
            vec4 p = inserted(i, j);
            corner(i);
            vertex(p, side(i));
            corner(k);
            EndPrimitive();
            vertex(p, side(j));
            corner(j);
            corner(k);
            EndPrimitive();
            return;
        }
    }
    corner(0);
    corner(1);
    corner(2);
    EndPrimitive();
}
