// Bicubic patches of 16 control points each, row by row.
#import shared/mesh.wgsl

@group(0) @binding(1) var<storage, read> control: array<vec4<f32>>;

// Weights of four points at a place from 0 to 1, Bernstein's; exactly one point at either end.
fn weights(at: f32) -> vec4<f32> {
    let rest = 1.0 - at;
    return vec4<f32>(rest * rest * rest, 3.0 * rest * rest * at, 3.0 * rest * at * at, at * at * at);
}

fn between(first: u32, by: vec4<f32>) -> vec3<f32> {
    let near = fma(control[first + 1u].xyz, vec3<f32>(by.y), control[first].xyz * by.x);
    return fma(control[first + 3u].xyz, vec3<f32>(by.w), fma(control[first + 2u].xyz, vec3<f32>(by.z), near));
}

// Metres, of a vertex of a patch's cells.
fn on_patch(number: u32, vertex: vec2<u32>) -> vec3<f32> {
    let at = vec2<f32>(vertex) / f32(mesh.cells);
    let across = weights(at.x);
    let down = weights(at.y);
    let first = 16u * number;
    let near = fma(between(first + 4u, across), vec3<f32>(down.y), between(first, across) * down.x);
    let middle = fma(between(first + 8u, across), vec3<f32>(down.z), near);
    return fma(between(first + 12u, across), vec3<f32>(down.w), middle);
}
