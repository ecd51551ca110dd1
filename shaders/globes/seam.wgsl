// Triangles across ±180° on Vulkan, under tiles of a map whose texels hold their address: one vertex invocation pulls a
// vertex with its place on the map, and a geometry shader may split the triangle; one fragment finds its tile and texel
// as in map.wgsl and writes the address in 24 bits.
#import shared/map.wgsl

// Three coordinates from the eye, U, its half-turned twin and V' of each vertex.
@group(0) @binding(3) var<storage, read> vertices: array<f32>;
// Of each texel the number of its tile, from 1, times 65,536, plus its row times 256, plus its column: whole numbers
// below 2^24, which f32 holds.
@group(0) @binding(4) var layers: texture_2d_array<f32>;

@vertex
fn pulled_vertex(@builtin(vertex_index) number: u32) -> Varying {
    let at = 6u * number;
    let relative_m = vec3<f32>(vertices[at], vertices[at + 1u], vertices[at + 2u]);
    let us = vec2<f32>(vertices[at + 3u], vertices[at + 4u]);
    return Varying(clip_from_eye_relative(relative_m), relative_m, us, vertices[at + 5u]);
}

@fragment
fn addressed(in: Varying) -> @location(0) vec4<f32> {
    let at = address(in);
    let number = tile_number(at.key);
    if number == arrayLength(&tiles) {
        // A surface without a tile: no address is 0.
        return vec4<f32>(0.0, 0.0, 0.0, 1.0);
    }
    let held = u32(textureLoad(layers, at.texel, number, 0).r);
    let bytes = vec3<u32>(held >> 16u, (held >> 8u) & 255u, held & 255u);
    return vec4<f32>(vec3<f32>(bytes) / 255.0, 1.0);
}
