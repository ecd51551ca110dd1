// Surface pass: one vertex invocation places a vertex of the planet. One fragment shades it as if
// lit from the eye, and its facet's slope as if lit from the north-west. Alpha stays 0, so that a
// pixel with alpha 1 was coloured by a fill.
#import shared/view.wgsl

// Brightness per slope towards the light, exaggerated: mountains are gentle at the scale of a globe.
const RELIEF_PER_SLOPE: f32 = 8.0;

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) relative_m: vec3<f32>,
};

@vertex
fn vertex_main(@location(0) relative_m: vec3<f32>) -> Varying {
    return Varying(clip_from_eye_relative(relative_m), relative_m);
}

@fragment
fn fragment_main(in: Varying) -> @location(0) vec4<f32> {
    let up = normalize((in.relative_m + view.eye_ecef) * view.normal_scale);
    let facing = max(-dot(up, normalize(in.relative_m)), 0.0);
    let shade = 0.35 + 0.65 * sqrt(facing);
    // Normal of the facet, turned up; where it rises towards the north-west, it leans away from there.
    let across = cross(dpdx(in.relative_m), dpdy(in.relative_m));
    let rise = dot(across, up);
    // A facet seen edge-on may have no normal left in f32; it is shaded as level ground.
    let lean = select(across / rise, up, abs(rise) <= 0.01 * length(across)) - up;
    // Shorter towards the poles, where there is no north-west.
    let north = vec3<f32>(0.0, 0.0, 1.0) - up * up.z;
    let east = vec3<f32>(-up.y, up.x, 0.0);
    let relief = clamp(1.0 + RELIEF_PER_SLOPE * dot(lean, north - east), 0.4, 1.6);
    return vec4<f32>(vec3<f32>(0.36, 0.46, 0.58) * shade * relief, 0.0);
}
