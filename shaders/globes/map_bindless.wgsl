// As `whole_map` of map.wgsl, from an array of textures, one a tile, which each fragment indexes freely.
enable wgpu_binding_array;
#import shared/map.wgsl

// In a group of its own: WebGPU keeps such arrays apart from uniforms.
@group(2) @binding(0) var each_texels: binding_array<texture_2d<u32>>;

@fragment
fn every_tile(in: Varying) -> @location(0) u32 {
    let at = address(in);
    let number = tile_number(at.key);
    if number == arrayLength(&tiles) {
        return MISSING;
    }
    return textureLoad(each_texels[number], at.texel, 0).r;
}
