// Study `pipelines`: one vertex invocation places one of six vertices of a cell of the grid; one fragment looks
// its place up in the depth map of every light and writes which of them reach it.
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

fn is_lit(number: u32, place: vec3<f32>) -> bool {
    let light = lights.each[number];
    let seen = light.column * place.x + light.row * place.y + light.height * place.z + light.origin;
    let last = vec2<i32>(i32(lights.texels) - 1);
    let texel = vec2<i32>(floor((0.5 * seen.xy + 0.5) * f32(lights.texels)));
    let nearest = textureLoad(maps, clamp(texel, vec2<i32>(0), last), i32(number), 0).r;
    return nearest <= seen.z + lights.bias;
}

@fragment
fn fragment_main(@location(0) place: vec3<f32>) -> @location(0) vec4<f32> {
    var mask = 0u;
    for (var number = 0u; number < lights.count; number += 1u) {
        if is_lit(number, place) {
            mask |= 1u << number;
        }
    }
    // From 1, since 0 is what is not drawn.
    return colour_of(mask + 1u);
}
