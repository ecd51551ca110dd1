#version 450
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `globes`: one invocation splits a triangle across 180 degrees (A. Jeromel, StuCoSReC 2018, section 2.4). Two
// corners whose U differ by more than LIMIT get a vertex between them with U = 0 in one part and 1 in the other.
// Both sides of an edge find it from the same operands in the same order, so that no crack opens.
layout(triangles) in;
layout(triangle_strip, max_vertices = 9) out;

// From the eye, metres; U and its half-turned twin; V'.
layout(location = 0) in vec3 corner_relative_m[];
layout(location = 1) in vec2 corner_us[];
layout(location = 2) in float corner_v[];
layout(location = 0) out vec3 relative_m;
layout(location = 1) out vec2 us;
layout(location = 2) out float v;

// Everything of a vertex but its U.
struct Place {
    vec4 clip;
    vec3 relative_m;
    float v;
};

float corner_u(int i) {
    return corner_us[i].x;
}

bool is_split(int i, int j) {
    return abs(corner_u(i) - corner_u(j)) > LIMIT;
}

// Place on the edge where U passes 1.
Place inserted(int one, int other) {
    bool is_high = corner_u(one) > corner_u(other);
    int high = is_high ? one : other;
    int low = is_high ? other : one;
    float rest = 1.0 - corner_u(high);
    float share = rest / (rest + corner_u(low));
    return Place(
        mix(gl_in[high].gl_Position, gl_in[low].gl_Position, share),
        mix(corner_relative_m[high], corner_relative_m[low], share),
        mix(corner_v[high], corner_v[low], share));
}

// U and its twin on the side of a corner.
vec2 side(int i) {
    return vec2(corner_u(i) > 0.5 ? 1.0 : 0.0, 0.0);
}

void vertex(Place place, vec2 place_us) {
    relative_m = place.relative_m;
    us = place_us;
    v = place.v;
    gl_Position = place.clip;
    EmitVertex();
}

// As the corner has them: its twin is rounded once, from more digits than its U has here.
void corner(int i) {
    vertex(Place(gl_in[i].gl_Position, corner_relative_m[i], corner_v[i]), corner_us[i]);
}

void main() {
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3;
        int k = (i + 2) % 3;
        // The corner that is alone on its side.
        if (is_split(i, j) && is_split(i, k) && !is_split(j, k)) {
            Place p = inserted(i, j);
            Place q = inserted(i, k);
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
            Place p = inserted(i, j);
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
