#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#ifdef LAYER
#extension GL_ARB_shader_viewport_layer_array : require
#endif
#ifdef VIEW
#extension GL_EXT_multiview : require
#endif
// SPDX-License-Identifier: MIT OR Apache-2.0
// Study `pipelines`: one vertex invocation places one of six vertices of a cell: as a light sees it, whose
// number is that of the instance, in the pass of the light, or with LAYER in the layer, or with VIEW with the
// view's added; with PLACE as it is, for a geometry shader. With LISTED it places a vertex of a list instead.
#ifdef LISTED
layout(set = 0, binding = 1, std430) readonly buffer Places {
    vec4 places[];
};
#else
#include "grid.glsl"
#endif
#include "lights.glsl"

#ifdef PLACE
layout(location = 0) out vec3 place;
#else
out gl_PerVertex {
    invariant vec4 gl_Position;
};
#endif

void main() {
#ifdef LISTED
    vec3 found = places[gl_VertexIndex].xyz;
#else
    uint number = uint(gl_VertexIndex);
    uint cell = number / 6u;
    uint corner = number % 6u;
    uvec2 at = uvec2(cell % grid.cells, cell / grid.cells) + uvec2((0x2au >> corner) & 1u, (0x1cu >> corner) & 1u);
    vec3 found = vec3(vec2(at), texelFetch(heights, ivec2(at), 0).r);
#endif
#ifdef PLACE
    place = found;
#else
    uint light = uint(gl_InstanceIndex);
#ifdef LAYER
    gl_Layer = int(light);
#endif
#ifdef VIEW
    light += uint(gl_ViewIndex);
#endif
    gl_Position = seen_by(light, found);
#endif
}
