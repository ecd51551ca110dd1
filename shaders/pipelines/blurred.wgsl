// Study `pipelines`: one fragment makes its pixel of layers that show a bar at moments of an exposure, or of moments
// of its own.
#import shared/lookup.wgsl

struct Blurred {
    // Of this picture, or moments of a pixel.
    count: u32,
    // 0: the layers' mean. 1: as published, weights count - i and 1 for the first, divided by alpha. 2: these weights
    // over an opaque background. 3: the same with weight count for the first. 4: moments of the pixel's own, its middle
    // covered or not. 5: the same, its covered share.
    resolve: u32,
    // Pixels: how far the bar moves, and how long it is.
    motion: f32,
    bar: f32,
    // A side of the picture.
    pixels: u32,
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

// Bits of a number, scattered (the finaliser of MurmurHash3).
fn scattered(number: u32) -> u32 {
    var mixed = number;
    mixed = (mixed ^ (mixed >> 16u)) * 0x85ebca6bu;
    mixed = (mixed ^ (mixed >> 13u)) * 0xc2b2ae35u;
    return mixed ^ (mixed >> 16u);
}

fn covered(pixel: vec2<u32>, moment: f32) -> f32 {
    let left = f32(pixel.x);
    let start = values[pixel.y] + blurred.motion * moment;
    let end = start + blurred.bar;
    if blurred.resolve == 4u {
        let middle = left + 0.5;
        return select(0.0, 1.0, middle >= start && middle < end);
    }
    return max(min(left + 1.0, end) - max(left, start), 0.0);
}

@fragment
fn fragment_main(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(at.xy);
    var light = 0.0;
    var all = 0.0;
    for (var layer = 0u; layer < blurred.count; layer += 1u) {
        if blurred.resolve >= 4u {
            let number = (pixel.y * blurred.pixels + pixel.x) * blurred.count + layer;
            let moment = f32(scattered(number) >> 8u) / 16777216.0;
            light += covered(pixel, moment);
            all += 1.0;
        } else {
            let weight = weight_of(layer);
            light += weight * textureLoad(maps, vec2<i32>(pixel), i32(layer), 0).r;
            all += weight;
        }
    }
    if blurred.resolve == 1u {
        // What no layer covers is left as it was: layers are white, so light is the sum of alpha.
        return bits(select(0.0, light / light, light > 0.0));
    }
    return bits(light / all);
}
