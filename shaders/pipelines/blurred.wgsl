// Study `pipelines`: one fragment makes its pixel of layers that show a mesh at moments of an exposure; or it adds one
// moment to the sum of those before.
#import shared/lookup.wgsl

struct Blurred {
    // Layers that a pixel is made of.
    count: u32,
    // 0: the layers' mean. 1: as published, weights count - i and 1 for the first, divided by alpha. 2: these weights
    // over an opaque background. 3: the same with weight count for the first.
    resolve: u32,
    // Pixels a side of a tile: each of its pixels has layers of its own, which have a texel a tile.
    tile: u32,
};

@group(0) @binding(0) var<uniform> blurred: Blurred;

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return whole_picture(vertex);
}

fn weight_of(layer: u32) -> f32 {
    if blurred.resolve == 0u {
        return 1.0;
    }
    if layer == 0u {
        return select(1.0, f32(blurred.count), blurred.resolve == 3u);
    }
    return f32(blurred.count - layer);
}

@fragment
fn fragment_main(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(at.xy);
    let texel = vec2<i32>(pixel / blurred.tile);
    let place = pixel % blurred.tile;
    let first = (place.y * blurred.tile + place.x) * blurred.count;
    var light = 0.0;
    var all = 0.0;
    for (var layer = 0u; layer < blurred.count; layer += 1u) {
        let weight = weight_of(layer);
        // Depth is grey, and 0 where nothing is.
        let grey = textureLoad(maps, texel, i32(first + layer), 0).r;
        light += weight * grey;
        all += select(weight, 0.0, blurred.resolve == 1u && grey <= 0.0);
    }
    // What no layer covers is left as it was.
    return bits(select(0.0, light / all, all > 0.0));
}

@fragment
fn added(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    return vec4<f32>(textureLoad(maps, vec2<i32>(at.xy), 0, 0).r * layers.weight);
}
