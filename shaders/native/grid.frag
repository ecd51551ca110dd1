#version 450
#extension GL_EXT_mesh_shader : require
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `pipelines`: a fragment writes the number of its triangle, which a mesh shader gave.
layout(location = 0) perprimitiveEXT flat in uint number;
layout(location = 0) out vec4 colour;

void main() {
    colour = unpackUnorm4x8(number | 0xff000000u);
}
