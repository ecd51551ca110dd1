// Triangles across ±180° on Vulkan: one vertex invocation pulls a vertex with its U, which a geometry shader may split;
// one fragment writes its U, without whole turns, in 24 bits.
#import shared/view.wgsl

// Three coordinates from the eye, U, its half-turned twin and V of each vertex.
@group(0) @binding(1) var<storage, read> vertices: array<f32>;

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) u: f32,
};

@vertex
fn vertex_main(@builtin(vertex_index) number: u32) -> Varying {
    let at = 6u * number;
    let relative_m = vec3<f32>(vertices[at], vertices[at + 1u], vertices[at + 2u]);
    return Varying(clip_from_eye_relative(relative_m), vertices[at + 3u]);
}

@fragment
fn fragment_main(@location(0) u: f32) -> @location(0) vec4<f32> {
    let whole = u32(clamp(u - floor(u), 0.0, 0.99999994) * 16777216.0);
    let bytes = vec3<u32>(whole >> 16u, (whole >> 8u) & 255u, whole & 255u);
    return vec4<f32>(vec3<f32>(bytes) / 255.0, 1.0);
}
