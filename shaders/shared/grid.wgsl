// A grid whose heights lie in one texture.
#import shared/cells.wgsl

// Metres, one texel a vertex: a side has one more than cells.
@group(0) @binding(1) var heights: texture_2d<f32>;

fn clip_at(vertex: vec2<u32>) -> vec4<f32> {
    let height_m = textureLoad(heights, vec2<i32>(vertex), 0).r;
    return clip_from_grid(vec3<f32>(vec2<f32>(vertex), height_m));
}
