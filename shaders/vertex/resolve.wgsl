// Colour pass of `colour=id-accumulation`: one triangle over the screen; one fragment reads the
// number that the volumes left at its pixel and writes that region's colour.
#import shared/view.wgsl
#import shared/region.wgsl

@group(1) @binding(0) var numbers: texture_2d<f32>;

@vertex
fn vertex_main(@builtin(vertex_index) vertex_index: u32) -> @builtin(position) vec4<f32> {
    let x = f32(i32(vertex_index & 1u) * 4 - 1);
    let y = f32(i32(vertex_index >> 1u) * 4 - 1);
    return vec4<f32>(x, y, 1.0, 1.0);
}

@fragment
fn fragment_main(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    let number = textureLoad(numbers, vec2<i32>(pixel.xy), 0).x;
    if number == 0.0 {
        discard;
    }
    // Anything that is no region's number, as where regions overlap after all, is black.
    if number < 1.0 || number > f32(arrayLength(&regions)) {
        return vec4<f32>(0.0, 0.0, 0.0, 1.0);
    }
    return regions[u32(number) - 1u].colour;
}
