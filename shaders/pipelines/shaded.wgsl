// Study `pipelines`: one fragment looks the place of its pixel up in the depth maps of all lights: variances of 25
// depths as published in 2007, or one depth each.
//
// Depths grow towards the light here; published, away from it. So a place is in shadow where it has less than
// their mean.
#import shared/lookup.wgsl

struct Shaded {
    // A side of the maps, and of the picture.
    texels: u32,
    pixels: u32,
    // 0: the variance in the first map. 1: the product of all lights' shares. 2: bits of the lights that reach it.
    shows: u32,
    // What is subtracted from depths first. 0: nothing. 1: one half. 2: the depth of the place.
    moments: u32,
    // Least variance; below 0 none.
    least: f32,
    // By how much one depth hides a place.
    bias: f32,
};

@group(0) @binding(0) var<uniform> shaded: Shaded;

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return whole_picture(vertex);
}

fn depth_at(texel: vec2<i32>, light: u32) -> f32 {
    let last = vec2<i32>(i32(shaded.texels) - 1);
    return textureLoad(maps, clamp(texel, vec2<i32>(0), last), i32(light), 0).r;
}

fn texel_of(seen: vec4<f32>) -> vec2<i32> {
    return vec2<i32>(floor((0.5 * seen.xy + 0.5) * f32(shaded.texels)));
}

fn offset_of(depth: f32) -> f32 {
    if shaded.moments == 0u {
        return 0.0;
    }
    return select(0.5, depth, shaded.moments == 2u);
}

// Mean and variance of 25 depths less an offset, in the published steps.
fn moments_at(middle: vec2<i32>, light: u32, offset: f32) -> vec2<f32> {
    var first = 0.0;
    var second = 0.0;
    for (var y = -2; y <= 2; y += 1) {
        for (var x = -2; x <= 2; x += 1) {
            let depth = depth_at(middle + vec2<i32>(x, y), light) - offset;
            first += depth / 25.0;
            second += depth * depth / 25.0;
        }
    }
    return vec2<f32>(first, second - first * first);
}

fn share_of(light: u32, seen: vec4<f32>) -> f32 {
    let offset = offset_of(seen.z);
    let moments = moments_at(texel_of(seen), light, offset);
    let gap = moments.x - (seen.z - offset);
    if gap > 0.0 {
        var variance = moments.y;
        if shaded.least >= 0.0 {
            variance = max(variance, shaded.least);
        }
        return variance / (variance + gap * gap);
    }
    return 1.0;
}

@fragment
fn fragment_main(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(at.xy);
    let depth = values[pixel.y * shaded.pixels + pixel.x];
    let place = vec3<f32>((vec2<f32>(pixel) + 0.5) / f32(shaded.pixels), depth);
    if shaded.shows == 0u {
        let seen = seen_by(0u, place);
        return bits(moments_at(texel_of(seen), 0u, offset_of(seen.z)).y);
    }
    var product = 1.0;
    var mask = 0u;
    for (var light = 0u; light < layers.count; light += 1u) {
        let seen = seen_by(light, place);
        if shaded.shows == 1u {
            product *= share_of(light, seen);
        } else if depth_at(texel_of(seen), light) <= seen.z + shaded.bias {
            mask |= 1u << light;
        }
    }
    return bits(select(product, f32(mask), shaded.shows == 2u));
}
