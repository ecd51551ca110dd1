// Lookup of a mask texture: one fragment reads its pixel's depth, turns it into longitude and latitude,
// and writes the colour of the region whose id the mask has there. Reads depth, the mask and the
// regions' colours; angles in radians, lengths in metres.

// Axes at the middle of the mask's rectangle: x from the body's axis to the middle's meridian, y to the
// east, z to the north pole.
struct MaskConstants {
    meridian_from_view: mat3x3<f32>,
    // From the middle's foot on the ellipsoid.
    eye_m: vec3<f32>,
    axis_distance_m: f32,
    // Of the middle's latitude.
    sine: f32,
    cosine: f32,
    // Of the meridian there, and what it grows by a radian.
    curvature_m: f32,
    curvature_growth_m: f32,
    half_rad: vec2<f32>,
    latitude_rad: f32,
    plane_distance_m: f32,
    equatorial_m: f32,
    polar_m: f32,
    eccentricity_squared: f32,
    second_eccentricity_squared: f32,
    clip_scale: vec2<f32>,
    near_m: f32,
    is_local: u32,
};

@group(0) @binding(0) var<uniform> mask: MaskConstants;
@group(0) @binding(1) var<storage, read> colours: array<vec4<f32>>;
@group(0) @binding(2) var depth: texture_depth_2d;
@group(0) @binding(3) var ids: texture_2d<u32>;

@vertex
fn vertex_main(@builtin(vertex_index) vertex_index: u32) -> @builtin(position) vec4<f32> {
    let x = f32(i32(vertex_index & 1u) * 4 - 1);
    let y = f32(i32(vertex_index >> 1u) * 4 - 1);
    return vec4<f32>(x, y, 1.0, 1.0);
}

// From the middle's foot, in its axes.
fn place_m(pixel: vec2<f32>, d: f32) -> vec3<f32> {
    let size = vec2<f32>(textureDimensions(depth));
    let clip = vec2<f32>(2.0, -2.0) * pixel / size + vec2<f32>(-1.0, 1.0);
    let view = vec3<f32>(clip / mask.clip_scale, -1.0) * (mask.near_m / d);
    return mask.meridian_from_view * view + mask.eye_m;
}

// Differences from the middle, which keep their digits where they are small. The latitude is that of the
// circle that fits the meridian best, and the growth of its curvature to first order.
fn near_middle_rad(p: vec3<f32>) -> vec2<f32> {
    let x = mask.axis_distance_m + p.x;
    let along = p.y / x;
    let axis = sqrt(x * x + p.y * p.y);
    let out = p.x + p.y * p.y / (axis + x);
    let north = mask.cosine * p.z - mask.sine * out;
    let radius = mask.curvature_m + mask.cosine * out + mask.sine * p.z;
    let first = north / radius;
    let up = first - 0.5 * mask.curvature_growth_m * first * first / radius;
    return vec2<f32>(
        along * (1.0 - along * along * (1.0 / 3.0 - along * along / 5.0)),
        up * (1.0 - up * up * (1.0 / 3.0 - up * up / 5.0)),
    );
}

// Bowring's formula (1976), one step.
fn anywhere_rad(p: vec3<f32>) -> vec2<f32> {
    let x = mask.axis_distance_m + p.x;
    let z = mask.plane_distance_m + p.z;
    let axis = sqrt(x * x + p.y * p.y);
    let reduced = normalize(vec2<f32>(axis * mask.polar_m, z * mask.equatorial_m));
    let latitude = atan2(
        z + mask.second_eccentricity_squared * mask.polar_m * reduced.y * reduced.y * reduced.y,
        axis - mask.eccentricity_squared * mask.equatorial_m * reduced.x * reduced.x * reduced.x,
    );
    return vec2<f32>(atan2(p.y, x), latitude - mask.latitude_rad);
}

@fragment
fn fragment_main(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    let d = textureLoad(depth, vec2<i32>(pixel.xy), 0);
    if d <= 0.0 {
        discard;
    }
    let p = place_m(pixel.xy, d);
    var angles: vec2<f32>;
    if mask.is_local == 1u {
        angles = near_middle_rad(p);
    } else {
        angles = anywhere_rad(p);
    }
    let at = angles / mask.half_rad;
    if max(abs(at.x), abs(at.y)) > 1.0 {
        discard;
    }
    let size = vec2<f32>(textureDimensions(ids));
    let texel = vec2<i32>(size * (vec2<f32>(0.5, -0.5) * at + 0.5));
    let id = textureLoad(ids, min(texel, vec2<i32>(size) - 1), 0).r;
    if id == 0u {
        discard;
    }
    return colours[id - 1u];
}
