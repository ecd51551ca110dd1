// A surface under tiles of a map: one fragment finds its tile and texel and writes what the texel holds, its own address
// or a colour. `whole_map` and `whole_picture` find the tile in an array, in one draw, and `atlas_map` in a picture with
// all tiles side by side. `one_tile`, as published, belongs to one tile and discards every fragment of others.
// `nearest_map` and `nearest_picture` have the layers of the tiles that are there, and show the nearest tile that the
// fragment's own is a part of.
#import shared/map.wgsl

@group(2) @binding(0) var all_texels: texture_2d_array<u32>;
@group(2) @binding(1) var all_colours: texture_2d_array<f32>;
@group(3) @binding(0) var tile_texels: texture_2d<u32>;
@group(3) @binding(1) var<uniform> tile: vec4<u32>;
// As many tiles side by side as below each other.
@group(4) @binding(0) var atlas_texels: texture_2d<u32>;

@fragment
fn whole_map(in: Varying) -> @location(0) u32 {
    let at = address(in);
    let number = tile_number(at.key);
    if number == arrayLength(&tiles) {
        return MISSING;
    }
    return textureLoad(all_texels, at.texel, number, 0).r;
}

@fragment
fn whole_picture(in: Varying) -> @location(0) vec4<f32> {
    let at = address(in);
    let number = tile_number(at.key);
    if number == arrayLength(&tiles) {
        // Magenta, which no colour of a map is.
        return vec4<f32>(1.0, 0.0, 1.0, 1.0);
    }
    return textureLoad(all_colours, at.texel, number, 0);
}

@fragment
fn atlas_map(in: Varying) -> @location(0) u32 {
    let at = address(in);
    let number = tile_number(at.key);
    if number == arrayLength(&tiles) {
        return MISSING;
    }
    let along = textureDimensions(atlas_texels).x >> 8u;
    let first = vec2<u32>(number % along, number / along) << vec2<u32>(8u);
    return textureLoad(atlas_texels, first + at.texel, 0).r;
}

@fragment
fn one_tile(in: Varying) -> @location(0) u32 {
    let at = address(in);
    if any(tile.xyz != at.key) {
        discard;
    }
    return textureLoad(tile_texels, at.texel, 0).r;
}

// Of the finest tile that is there: its layer, which the list has beside its key, and the texel.
struct Found {
    layer: u32,
    texel: vec2<u32>,
};

const NO_LAYER: u32 = 0xffffffffu;

fn nearest(in: Varying) -> Found {
    let at = address(in);
    var key = at.key;
    var texel = at.texel;
    var number = tile_number(key);
    while number == arrayLength(&tiles) && key.x != 0u && key.x != CAP_LEVEL {
        // The quarter of its parent that it is, in texels twice as large. Keys have the row before the column.
        texel = ((key.zy & vec2<u32>(1u)) << vec2<u32>(7u)) + (texel >> vec2<u32>(1u));
        key = vec3<u32>(key.x - 1u, key.yz >> vec2<u32>(1u));
        number = tile_number(key);
    }
    if number == arrayLength(&tiles) {
        return Found(NO_LAYER, texel);
    }
    return Found(tiles[number].w, texel);
}

@fragment
fn nearest_map(in: Varying) -> @location(0) u32 {
    let found = nearest(in);
    if found.layer == NO_LAYER {
        return MISSING;
    }
    return textureLoad(all_texels, found.texel, found.layer, 0).r;
}

@fragment
fn nearest_picture(in: Varying) -> @location(0) vec4<f32> {
    let found = nearest(in);
    if found.layer == NO_LAYER {
        return vec4<f32>(1.0, 0.0, 1.0, 1.0);
    }
    return textureLoad(all_colours, found.texel, found.layer, 0);
}
