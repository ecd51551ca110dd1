// A surface under tiles of a map: vertices with their places on it, and of a fragment the tile and the texel in it.
// Places on the map are shares of its side, from 180° west and from the north; texels of a tile are 256 × 256.
#import shared/view.wgsl

struct MapConstants {
    // U that `rotated` counts from.
    origin_u: f32,
    // Pixels per radian in the image's middle, times the equator's length over 256, metres.
    texel_scale: f32,
    // Sine of the latitude where the map ends, and what a cap of a pole spans there.
    end_sine: f32,
    cap_span: f32,
    // 0: U as it is; 1: U or its half-turned twin, whichever changes less; 2: counted from `origin_u`; 3: counted
    // from `origins`, V' as well.
    seam: u32,
    // 1: V' comes from V for each fragment.
    by_fragment: u32,
    // Level of the whole frame; 255: by fragment.
    level: u32,
    // Tiles without the two caps, which follow.
    tiles: u32,
    // Where `seam` 3 counts from, by level: whole texels of U and V', and the rest as bits of f32.
    origins: array<vec4<u32>, 24>,
};

@group(0) @binding(1) var<uniform> map: MapConstants;
// Level, row, column, sorted.
@group(0) @binding(2) var<storage, read> tiles: array<vec4<u32>>;
const TILE: f32 = 256.0;
const TAU: f32 = 6.2831853;
const MAX_LEVEL: f32 = 22.0;
const CAP_LEVEL: u32 = 1000u;
// What is written where a surface has no tile.
const MISSING: u32 = 0xffffffffu;

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) relative_m: vec3<f32>,
    @location(1) us: vec2<f32>,
    @location(2) v: f32,
};

@vertex
fn vertex_main(
    @location(0) relative_m: vec3<f32>,
    @location(1) us: vec2<f32>,
    @location(2) v: f32,
) -> Varying {
    return Varying(clip_from_eye_relative(relative_m), relative_m, us, v);
}

// Eq. (8) of V with 2M = 2.9688445 rad.
fn mercator_v(v: f32) -> f32 {
    return 0.5 - asinh(tan(2.9688445 * (v - 0.5))) / TAU;
}

// Level, row and column of a tile, and the texel in it.
struct Address {
    key: vec3<u32>,
    texel: vec2<u32>,
};

fn address(in: Varying) -> Address {
    // Derivatives before anything branches.
    let changes = fwidth(in.us);
    let up = normalize((in.relative_m + view.eye_ecef) * view.normal_scale);
    if abs(up.z) > map.end_sine {
        let place = 0.5 + 0.5 * up.xy / ((1.0 + abs(up.z)) * map.cap_span);
        let texel = vec2<u32>(clamp(place * TILE, vec2<f32>(0.0), vec2<f32>(TILE - 1.0)));
        return Address(vec3<u32>(CAP_LEVEL, 0u, select(0u, 1u, up.z < 0.0)), texel);
    }
    var u = in.us.x;
    if map.seam == 1u && changes.y < changes.x {
        u = in.us.y;
    } else if map.seam == 2u {
        u += map.origin_u;
    }
    var v = in.v;
    if map.by_fragment == 1u {
        v = mercator_v(v);
    }
    var level = map.level;
    if level == 255u {
        let cosine = sqrt(max(1.0 - up.z * up.z, 0.0));
        let wanted = log2(map.texel_scale * cosine / length(in.relative_m));
        level = u32(clamp(ceil(wanted), 0.0, MAX_LEVEL));
    }
    let side = TILE * exp2(f32(level));
    let last = (256u << level) - 1u;
    var place: vec2<u32>;
    if map.seam == 3u {
        let origin = map.origins[level];
        let rest = vec2<f32>(bitcast<f32>(origin.z), bitcast<f32>(origin.w));
        let steps = vec2<i32>(floor(rest + vec2<f32>(u, v) * side));
        // Sums of 32 bits go round, as the map does; a power of two is left of them.
        let x = (origin.x + bitcast<u32>(steps.x)) & last;
        let y = clamp(bitcast<i32>(origin.y) + steps.y, 0, i32(last));
        place = vec2<u32>(x, u32(y));
    } else {
        let at = vec2<f32>(u - floor(u), clamp(v, 0.0, 1.0)) * side;
        place = min(vec2<u32>(at), vec2<u32>(last));
    }
    return Address(vec3<u32>(level, place.y >> 8u, place.x >> 8u), place & vec2<u32>(255u));
}

// Whether one key comes before another.
fn precedes(a: vec3<u32>, b: vec3<u32>) -> bool {
    if a.x != b.x {
        return a.x < b.x;
    }
    if a.y != b.y {
        return a.y < b.y;
    }
    return a.z < b.z;
}

// Number of a tile in the list; as many as there are where it is none of them.
fn tile_number(key: vec3<u32>) -> u32 {
    let count = arrayLength(&tiles);
    var first = 0u;
    var end = count;
    while first < end {
        let middle = (first + end) / 2u;
        if precedes(tiles[middle].xyz, key) {
            first = middle + 1u;
        } else {
            end = middle;
        }
    }
    if first < count && all(tiles[first].xyz == key) {
        return first;
    }
    return count;
}
