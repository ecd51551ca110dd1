// Textured colour pass: one triangle over the whole target, cut to a region's screen rectangle by the
// scissor and to its pixels by the stencil test. One fragment reads the depth that the surface left,
// finds its longitude and latitude from the region's anchor, from them its place in the picture, and
// writes the picture's colour there. Level of detail comes from the map's own derivatives, never from
// neighbouring pixels, so that neither ±180° nor an edge of depth shows in it.
//
// Put in where the lines below say so, before this file is compiled: the position route
// (`fragment_offset`), the coordinate route (`route_angles`), the place in the picture (`place`,
// `picture`), and how many constants the routes have. Meridian axes: body axes turned about the polar
// axis until the anchor's longitude is 0. Lengths in metres, angles in radians.
#import shared/view.wgsl
#import shared/srgb.wgsl

struct TexturedRegion {
    // The region's anchor, meridian axes.
    anchor_m: vec3<f32>,
    // What the probe writes for the region.
    id: f32,
    // Eye minus anchor, meridian axes.
    eye_m: vec3<f32>,
    alpha: f32,
    // The image plane at distance 1: step to the pixel on the right, and to the one below.
    right: vec3<f32>,
    equatorial_radius_m: f32,
    down: vec3<f32>,
    eccentricity_squared: f32,
    // Place in the picture: per radian of longitude, per radian of latitude, and at the anchor.
    u: vec3<f32>,
    // Distance from the eye where nothing is left, and 1 / the length of the fade.
    fade_end_m: f32,
    v: vec3<f32>,
    fade_per_m: f32,
    // Of a pattern: metres that a texel should span, per metre of distance from the eye.
    texel_per_m: f32,
    position: array<vec4<f32>, POSITION_CONSTANTS>,
    route: array<vec4<f32>, ROUTE_CONSTANTS>,
};

@group(1) @binding(0) var surface_depth: texture_depth_2d;
// The region that is covered. Constants at fixed places are the same for a whole draw to a compiler;
// elements of an array by instance number are loaded lane by lane on some devices (llvmpipe).
@group(1) @binding(1) var<uniform> textured: TexturedRegion;
@group(2) @binding(0) var image: texture_2d<f32>;
@group(2) @binding(1) var image_sampler: sampler;

// Whether the picture fades with the distance.
override FADES: bool = false;
// Whether nothing is drawn beyond the picture's edges; otherwise the sampler says what is there.
override ENDS_AT_EDGES: bool = false;
// Whether the position is normalised before its angles are taken, which no angle needs, for the price to
// be measured (Cozzi, 2007, 4.5).
override NORMALIZES_POSITION: bool = false;

// Whether no pixel of the region spans more than a texel: its level is 0 without looking.
override IS_MAGNIFIED: bool = false;

// Whether the picture is sampled once at a place that depends on the depth and means nothing: what is
// left is what any textured fill must pay that looks at depth.
override IS_FLOOR: bool = false;

@vertex
fn vertex_main(@builtin(vertex_index) vertex_index: u32) -> @builtin(position) vec4<f32> {
    let x = f32(i32(vertex_index & 1u) * 4 - 1);
    let y = f32(i32(vertex_index >> 1u) * 4 - 1);
    return vec4<f32>(x, y, 1.0, 1.0);
}

//#insert position

//#insert route

// How longitude and latitude change from the pixel to its right neighbour (x, y) and to the one below
// (z, w) on the ellipsoid's tangent plane at the point, radians.
//
// (N + h) cos φ is the distance from the axis; h = p·n − a √(1 − e² sin² φ) with n the geodetic normal,
// and M = a (1 − e²) / (1 − e² sin² φ)^(3/2). Lines of sight meet the plane where
// (q + s)·n stays the same, q being the way from the eye and s a step of the image plane.
fn angles_per_pixel(offset_m: vec3<f32>, depth: f32) -> vec4<f32> {
    let p = textured.anchor_m + offset_m;
    let q = offset_m - textured.eye_m;
    let distance = view.near_m / depth;
    // On the ellipsoid this is along the geodetic normal; at 10 km height it is 5e-6 rad off.
    let n = normalize(p * view.normal_scale);
    // Seen edge on, a pixel's footprint has no end, and the coarsest level is right for it.
    let facing = min(dot(q, n), -1e-6 * distance);
    let right = textured.right * distance;
    let down = textured.down * distance;
    let on_right = right - q * (dot(right, n) / facing);
    let on_down = down - q * (dot(down, n) / facing);
    // At the pole itself longitude has no derivative; its place is in the coarsest level too.
    let axis_distance = sqrt(max(dot(p.xy, p.xy), 1e-12));
    let outward = p.xy / axis_distance;
    let cos_latitude = length(n.xy);
    let a = textured.equatorial_radius_m;
    let e2 = textured.eccentricity_squared;
    let w2 = 1.0 - e2 * n.z * n.z;
    let w = sqrt(w2);
    let height_m = dot(p, n) - a * w;
    let meridian = a * (1.0 - e2) / (w2 * w) + height_m;
    return vec4<f32>(
        (outward.x * on_right.y - outward.y * on_right.x) / axis_distance,
        (cos_latitude * on_right.z - n.z * dot(outward, on_right.xy)) / meridian,
        (outward.x * on_down.y - outward.y * on_down.x) / axis_distance,
        (cos_latitude * on_down.z - n.z * dot(outward, on_down.xy)) / meridian,
    );
}

// Where a fragment is in the picture.
struct Place {
    uv: vec2<f32>,
    // Level of detail, 0 or more.
    level: f32,
    // Of a pattern: log2 of the metres that a texel spans here; 0 without one.
    pattern_level: f32,
    // The longer of the footprints of a step to the next pixel, texels; of a pattern, of one metre.
    footprint_texels: f32,
};

fn uv_of(angles: vec2<f32>) -> vec2<f32> {
    let at = vec3<f32>(angles, 1.0);
    return vec2<f32>(dot(textured.u, at), dot(textured.v, at));
}

// The longer of the footprints in the picture of a step to the right and of one down, texels.
fn footprint_of(steps: vec4<f32>) -> f32 {
    let u = textured.u.xy;
    let v = textured.v.xy;
    let texels = vec2<f32>(textureDimensions(image));
    let right = vec2<f32>(dot(u, steps.xy), dot(v, steps.xy)) * texels;
    let down = vec2<f32>(dot(u, steps.zw), dot(v, steps.zw)) * texels;
    return sqrt(min(max(dot(right, right), dot(down, down)), 1e30));
}

//#insert placement

struct Found {
    place: Place,
    distance_m: f32,
};

// Everything up to the sampling of the picture: what the probe writes is what the colour pass uses.
// Only the level is computed by every probe, so that one that is not 0 in a magnified region shows.
fn find(pixel: vec2<f32>) -> Found {
    let depth = textureLoad(surface_depth, vec2<i32>(pixel), 0);
    // The cleared depth is no surface. The stencil keeps such pixels out, and so does this should it
    // not: nothing finite comes of a distance without end.
    if !(depth > 0.0) {
        discard;
    }
    if IS_FLOOR {
        let uv = vec2<f32>(depth) + pixel / vec2<f32>(textureDimensions(surface_depth));
        return Found(Place(uv, 0.0, 0.0, 0.0), 0.0);
    }
    var offset_m = offset_of(pixel, depth);
    if NORMALIZES_POSITION {
        // Back to its length, since routes take offsets: one product and one difference more than then.
        let p = textured.anchor_m + offset_m;
        offset_m = normalize(p) * length(p) - textured.anchor_m;
    }
    let angles = angles_of(offset_m);
    let distance_m = length(offset_m - textured.eye_m);
    if IS_MAGNIFIED {
        return Found(Place(uv_of(angles), 0.0, 0.0, 0.0), distance_m);
    }
    let steps = angles_per_pixel(offset_m, depth);
    return Found(place(angles, steps, distance_m), distance_m);
}

fn is_outside(uv: vec2<f32>) -> bool {
    return any(uv < vec2<f32>(0.0)) || any(uv > vec2<f32>(1.0));
}

@fragment
fn fragment_main(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    let found = find(pixel.xy);
    if IS_FLOOR {
        return textureSampleLevel(image, image_sampler, found.place.uv, 0.0);
    }
    let texel = picture(found.place);
    var alpha = texel.w * textured.alpha;
    if FADES {
        let left = (textured.fade_end_m - found.distance_m)
            * textured.fade_per_m;
        alpha *= clamp(left, 0.0, 1.0);
    }
    if ENDS_AT_EDGES && is_outside(found.place.uv) {
        alpha = 0.0;
    }
    return vec4<f32>(srgb_of_linear(texel.xyz), alpha);
}

struct Probed {
    @location(0) place: vec4<f32>,
    @location(1) sizes: vec4<f32>,
};

@fragment
fn probe_main(@builtin(position) pixel: vec4<f32>) -> Probed {
    let found = find(pixel.xy);
    let place = found.place;
    return Probed(
        vec4<f32>(place.uv, place.level, textured.id),
        vec4<f32>(place.pattern_level, place.footprint_texels, found.distance_m, 0.0),
    );
}
