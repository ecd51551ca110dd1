// A grid under lights that each have a depth map, and a place of each fragment to look up in them.
#import shared/grid.wgsl

// Columns of the matrix from (column, row, height in m, 1) to a light's map: -1 to 1 across, 0 to 1 in depth,
// greatest nearest to the light.
struct Light {
    column: vec4<f32>,
    row: vec4<f32>,
    height: vec4<f32>,
    origin: vec4<f32>,
};

struct Lights {
    each: array<Light, 16>,
    count: u32,
    // A side of a map.
    texels: u32,
    // What hides a place is nearer to the light by more than this, of the depth.
    bias: f32,
};

@group(0) @binding(2) var<uniform> lights: Lights;
@group(0) @binding(3) var maps: texture_2d_array<f32>;

struct Varying {
    @invariant @builtin(position) clip: vec4<f32>,
    @location(0) place: vec3<f32>,
};

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> Varying {
    let number = vertex / 6u;
    let at = vec2<u32>(number % grid.cells, number / grid.cells) + corner(vertex % 6u);
    let height_m = textureLoad(heights, vec2<i32>(at), 0).r;
    return Varying(clip_at(at), vec3<f32>(vec2<f32>(at), height_m));
}

// A place as a light sees it, in clip space.
fn seen_by(number: u32, place: vec3<f32>) -> vec4<f32> {
    let light = lights.each[number];
    return light.column * place.x + light.row * place.y + light.height * place.z + light.origin;
}

// The texel at -1 to 1 across and upwards.
fn texel_of(across: vec2<f32>) -> vec2<i32> {
    return vec2<i32>(floor((0.5 * across + 0.5) * f32(lights.texels)));
}

// What is nearest to a light in a texel, or in the nearest one that the map has.
fn depth_at(texel: vec2<i32>, number: u32) -> f32 {
    let last = vec2<i32>(i32(lights.texels) - 1);
    return textureLoad(maps, clamp(texel, vec2<i32>(0), last), i32(number), 0).r;
}
