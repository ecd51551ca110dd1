#version 450
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `pipelines`: one fragment writes the number of its triangle, from 1, into a face of a cube.
layout(location = 0) out vec4 colour;

void main() {
    colour = unpackUnorm4x8(uint(gl_PrimitiveID + 1) | 0xff000000u);
}
