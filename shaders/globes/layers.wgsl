// The five layers of a globe (Gebbie and Bailey, appendix): one vertex invocation places a vertex whose clip position
// the CPU made; or one of a static buffer of sine, cosine and radius, by one of four projections. One fragment adds
// colour, highlight, clouds and lights of night. Directions are of the ECEF axes. Layers come from four cube maps, or
// from four pictures by longitude and latitude.
#import shared/view.wgsl
#import shared/spiral.wgsl

struct LayerConstants {
    // Towards the sun, of length 1.
    sun: vec3<f32>,
    padding: f32,
    // Rows of the turn by which clouds are looked up.
    clouds_x: vec4<f32>,
    clouds_y: vec4<f32>,
    clouds_z: vec4<f32>,
};

// Where a map lies.
struct MapConstants {
    // Cosine and sine of the focus's longitude, and its latitude.
    cosine: f32,
    sine: f32,
    latitude: f32,
    // How far from the focus half of a hyperbolic map's rim is reached, radii.
    reach: f32,
};

// 0: the globe; 1: a flat map; 2 and 3: a hyperbolic one, polar and Cartesian; 4: a dome.
override PROJECTION: u32 = 0u;
// Features taken away one after the other, as in the paper's Table 3: clouds, lights of night, the tangent's length,
// bumps, highlight, light, the normal's length.
override REMOVED: u32 = 0u;
// 1: pictures by longitude and latitude.
override BY_ANGLES: u32 = 0u;
// 1: bumps are bent normals along ECEF axes, which have no pole.
override OBJECT_SPACE: u32 = 0u;
// Shares of tangent and binormal are multiplied by it.
override BUMP_SCALE: f32 = 1.0;
// 1: the power of what may be negative; 2: the tangent (−y, x, 0) at the poles as well; 3: night by the negated light.
override FAULT: u32 = 0u;

@group(1) @binding(0) var base_cube: texture_cube<f32>;
@group(1) @binding(1) var bump_cube: texture_cube<f32>;
@group(1) @binding(2) var cloud_cube: texture_cube<f32>;
@group(1) @binding(3) var night_cube: texture_cube<f32>;
@group(1) @binding(4) var base_map: texture_2d<f32>;
@group(1) @binding(5) var bump_map: texture_2d<f32>;
@group(1) @binding(6) var cloud_map: texture_2d<f32>;
@group(1) @binding(7) var night_map: texture_2d<f32>;
// Goes round in longitude.
@group(1) @binding(8) var linear: sampler;

@group(2) @binding(0) var<uniform> layers: LayerConstants;
@group(2) @binding(1) var<uniform> spiral: SpiralConstants;
@group(2) @binding(2) var<uniform> map: MapConstants;

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) to_eye: vec3<f32>,
    @location(1) normal: vec3<f32>,
};

@vertex
fn vertex_main(
    @location(0) clip: vec4<f32>,
    @location(1) to_eye: vec3<f32>,
    @location(2) normal: vec3<f32>,
) -> Varying {
    return Varying(clip, to_eye, normal);
}

const QUARTER: f32 = 1.5707964;

// Longitude and latitude about the focus.
fn about_focus(normal: vec3<f32>) -> vec2<f32> {
    let ahead = normal.x * map.cosine + normal.y * map.sine;
    let aside = normal.y * map.cosine - normal.x * map.sine;
    return vec2<f32>(atan2(aside, ahead), atan2(normal.z, length(normal.xy)) - map.latitude);
}

// Where a map shows a place, -1 to 1.
fn on_map(relative_m: vec3<f32>, normal: vec3<f32>) -> vec2<f32> {
    if PROJECTION == 4u {
        let seen = view.view_from_ecef * relative_m;
        let across = length(seen.xy);
        let share = atan2(across, -seen.z) / QUARTER;
        return select(vec2<f32>(0.0), share / across * seen.xy, across > 0.0);
    }
    let at = about_focus(normal);
    if PROJECTION == 1u {
        return at / QUARTER;
    }
    if PROJECTION == 2u {
        return at / (length(at) + map.reach);
    }
    return at / sqrt(at * at + map.reach * map.reach);
}

@vertex
fn stored_main(@location(0) vertex: vec3<f32>) -> Varying {
    let way = stored_way(spiral, vertex);
    let relative_m = way + spiral.focus;
    let normal = normalize((spiral.up + way) * view.normal_scale);
    if PROJECTION == 0u {
        return Varying(clip_from_eye_relative(relative_m), -relative_m, normal);
    }
    let at = on_map(relative_m, normal) * vec2<f32>(view.clip_scale_x / view.clip_scale_y, 1.0);
    // On a map nothing hides anything else; what is nearer to the eye stays so.
    let near = clamp(view.near_m / length(relative_m), 0.0, 1.0);
    return Varying(vec4<f32>(at, near, 1.0), -relative_m, normal);
}

// U and V of a direction; without derivatives, since U jumps.
fn angles(direction: vec3<f32>) -> vec2<f32> {
    let across = length(direction.xy);
    let u = 0.5 + atan2(direction.y, direction.x) / 6.2831853;
    return vec2<f32>(u, 0.5 - atan2(direction.z, across) / 3.1415927);
}

fn looked_up(cube: texture_cube<f32>, picture: texture_2d<f32>, direction: vec3<f32>) -> vec4<f32> {
    if BY_ANGLES == 1u {
        return textureSampleLevel(picture, linear, angles(direction), 0.0);
    }
    return textureSampleLevel(cube, linear, direction, 0.0);
}

@fragment
fn fragment_main(in: Varying) -> @location(0) vec4<f32> {
    if REMOVED >= 7u {
        return vec4<f32>(1.0);
    }
    let n = normalize(in.normal);
    if REMOVED >= 6u {
        // A share that no picture shows keeps the length from being optimised away.
        return vec4<f32>(vec3<f32>(1.0) - 1e-7 * abs(n), 1.0);
    }
    let base = looked_up(base_cube, base_map, n);
    var m = n;
    if REMOVED < 4u && OBJECT_SPACE == 1u {
        m = normalize(2.0 * looked_up(bump_cube, bump_map, n).xyz - 1.0);
    } else if REMOVED < 4u {
        var t = vec3<f32>(-n.y, n.x, 0.0);
        if FAULT == 2u {
            t = normalize(t);
        } else if REMOVED < 3u {
            // At a pole every direction is along a parallel.
            let length = length(t);
            t = select(vec3<f32>(0.0, 1.0, 0.0), t / length, length > 1e-6);
        }
        let b = cross(n, t);
        let c = 2.0 * looked_up(bump_cube, bump_map, n).xyz - 1.0;
        m = normalize(c.x * n + BUMP_SCALE * (c.y * t + c.z * b));
    }
    let light = dot(m, layers.sun);
    var colour = base.rgb * clamp(light, 0.0, 1.0);
    if REMOVED < 5u {
        let half_way = dot(m, normalize(layers.sun + normalize(in.to_eye)));
        let shine = select(max(half_way, 0.0), half_way, FAULT == 1u);
        colour += vec3<f32>(pow(shine, 200.0) * base.a);
    }
    let level = clamp(dot(n, layers.sun), 0.0, 1.0);
    if REMOVED < 1u {
        let turned = vec3<f32>(
            dot(layers.clouds_x.xyz, n),
            dot(layers.clouds_y.xyz, n),
            dot(layers.clouds_z.xyz, n),
        );
        colour += looked_up(cloud_cube, cloud_map, turned).rgb * level;
    }
    if REMOVED < 2u {
        let dark = select(1.0 - clamp(10.0 * level, 0.0, 1.0), clamp(-light, 0.0, 1.0), FAULT == 3u);
        colour += looked_up(night_cube, night_map, n).rgb * dark;
    }
    return vec4<f32>(colour, 1.0);
}
