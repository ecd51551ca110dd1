// Decals and lines over a sphere (Gebbie and Bailey): offsets from a corner, in radians, become places about that corner,
// and places become clip positions by one of four projections. Metres along the corner's east, north and up; or from the
// body's centre, along its own axes.
#import shared/triangles.wgsl

struct DecalConstants {
    // Columns of the matrix from metres about the origin to clip space.
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    origin: vec4<f32>,
    // What a place is before the horizon, in its first three parts and beyond them.
    horizon: vec4<f32>,
    // Of a ray through the middle, and of steps to the picture's right and upper edge; in radii of the body.
    right: vec3<f32>,
    // |eye|² − 1, in radii.
    height: f32,
    up: vec3<f32>,
    // Of the near plane, in radii.
    near: f32,
    forward: vec3<f32>,
    radius_m: f32,
    eye: vec3<f32>,
    // Half a side of the picture.
    half_px: f32,
    // Of a great circle at its start.
    toward: vec3<f32>,
    // Its length, radians.
    angle: f32,
    // From the focus to the corner; of the decal, or of a straight line on the map: longitude and latitude, radians.
    focus: vec2<f32>,
    size: vec2<f32>,
    sin_lat: f32,
    cos_lat: f32,
    // Tangent of half the field of view; how far from the focus half of a hyperbolic map's rim is reached.
    tan_half: f32,
    reach: f32,
    half_width_px: f32,
    // Cells along a side of a decal; texels along a side of its picture.
    cells: u32,
    texels: u32,
    // 0: the globe; 1: a flat map; 2: a hyperbolic one; 3: a dome.
    projection: u32,
    // 0: about the corner; 1: from the body's centre, by longitude and latitude themselves.
    form: u32,
    // Order of sine and cosine where it is 1 or 2; else a series of thirteenth and fourteenth order.
    series: u32,
    // 0: a line straight in longitude and latitude; 1: a great circle.
    path: u32,
};

@group(0) @binding(0) var<uniform> decal: DecalConstants;

const QUARTER: f32 = 1.5707964;

// Up to half a turn. The series is one up to a quarter, where what is left out is 7e-10; beyond, the supplement has the
// same sine, and half a turn in two parts leaves nothing of it out.
fn sine(angle: f32) -> f32 {
    if decal.series == 1u || decal.series == 2u {
        return angle;
    }
    let half_turn = sign(angle) * vec2<f32>(3.140625, 9.67653589e-4);
    let x = select(angle, half_turn.x - angle + half_turn.y, abs(angle) > QUARTER);
    let s = x * x;
    let last = 1.0 - s / 72.0 * (1.0 - s / 110.0 * (1.0 - s / 156.0));
    return x * (1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * last)));
}

// 1 − cosine, without their difference.
fn versine(x: f32) -> f32 {
    if decal.series == 1u {
        return 0.0;
    }
    let half = sine(0.5 * x);
    return 2.0 * half * half;
}

// Offsets from the corner, or longitude and latitude, to metres about the origin.
fn place_of(at: vec2<f32>) -> vec3<f32> {
    let level = 1.0 - versine(at.x);
    let flat = 1.0 - versine(at.y);
    if decal.form == 1u {
        return decal.radius_m * vec3<f32>(flat * level, flat * sine(at.x), sine(at.y));
    }
    let cos_lat = decal.cos_lat * flat - decal.sin_lat * sine(at.y);
    let turned = cos_lat * versine(at.x);
    let north = sine(at.y) + decal.sin_lat * turned;
    return decal.radius_m * vec3<f32>(cos_lat * sine(at.x), north, -versine(at.y) - decal.cos_lat * turned);
}

fn globe_clip(place: vec3<f32>) -> vec4<f32> {
    let level = fma(decal.z, vec4<f32>(place.z), decal.origin);
    return fma(decal.x, vec4<f32>(place.x), fma(decal.y, vec4<f32>(place.y), level));
}

// - `at`: offsets from the corner, for maps
fn clip_of(place: vec3<f32>, at: vec2<f32>) -> vec4<f32> {
    let seen = globe_clip(place);
    if decal.projection == 0u {
        return seen;
    }
    let about = decal.focus + at;
    var shown = about / QUARTER;
    if decal.projection == 2u {
        shown = about / (length(about) + decal.reach);
    }
    if decal.projection == 3u {
        let aside = seen.xy * decal.tan_half;
        let across = length(aside);
        shown = select(vec2<f32>(0.0), atan2(across, seen.w) / QUARTER / across * aside, across > 0.0);
    }
    return vec4<f32>(shown, 0.5, 1.0);
}

// Above 0 on the eye's side of the horizon, at most 1; linear in the place.
fn before_horizon(place: vec3<f32>) -> f32 {
    return dot(decal.horizon.xyz, place) + decal.horizon.w;
}

struct Placed {
    clip: vec4<f32>,
    before: f32,
};

fn placed(place: vec3<f32>, at: vec2<f32>) -> Placed {
    return Placed(clip_of(place, at), before_horizon(place));
}

// A decal's vertex: offsets and its number in rows.
fn decal_vertex(vertex: vec3<f32>) -> Placed {
    return placed(place_of(vertex.xy), vertex.xy);
}

// Where a vertex is on the picture, 0 to 1.
fn share_of(vertex: vec3<f32>) -> vec2<f32> {
    let number = u32(vertex.z);
    let side = decal.cells + 1u;
    return vec2<f32>(f32(number % side), f32(number / side)) / f32(decal.cells);
}

// A place of a line, by its share of the way.
fn line_place(share: f32) -> Placed {
    if decal.path == 1u {
        let angle = decal.angle * share;
        let place = decal.radius_m * (decal.toward * sine(angle) - vec3<f32>(0.0, 0.0, versine(angle)));
        return placed(place, vec2<f32>(0.0));
    }
    let at = decal.size * share;
    return placed(place_of(at), at);
}

struct Ribbon {
    at: Placed,
    share: f32,
};

// A corner of what a segment covers: shares of the way to both ends, and which of six corners.
fn ribbon(vertex: vec3<f32>) -> Ribbon {
    let which = corner(u32(vertex.z));
    let ends = array<Placed, 2>(line_place(vertex.x), line_place(vertex.y));
    let along = ends[1].clip.xy / ends[1].clip.w - ends[0].clip.xy / ends[0].clip.w;
    let aside = normalize(vec2<f32>(-along.y, along.x)) * (decal.half_width_px / decal.half_px);
    var at = ends[0];
    var share = vertex.x;
    if which.x == 1u {
        at = ends[1];
        share = vertex.y;
    }
    let side = 2.0 * f32(which.y) - 1.0;
    at.clip = vec4<f32>(at.clip.xy + side * aside * at.clip.w, at.clip.zw);
    return Ribbon(at, share);
}

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) share: vec2<f32>,
    @location(1) before: f32,
};

fn texel(share: f32) -> u32 {
    return u32(clamp(floor(share * f32(decal.texels)), 0.0, f32(decal.texels) - 1.0));
}
