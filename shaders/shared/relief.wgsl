// How a surface looks whatever its colour: lit from the eye, and the slope of its facets from the north-west.
#import shared/view.wgsl

// Of a surface that has no picture.
const BARE_COLOUR: vec3<f32> = vec3<f32>(0.36, 0.46, 0.58);
// Brightness per slope towards the light, exaggerated: mountains are gentle at the scale of a globe.
const RELIEF_PER_SLOPE: f32 = 8.0;
// By how much a slope brightens or darkens at most.
const MOST_RELIEF: f32 = 0.6;

struct SurfaceVertex {
    // Light caps of shadow volumes are drawn over the triangles that they are, and equal depth must fail.
    @builtin(position) @invariant clip: vec4<f32>,
    @location(0) relative_m: vec3<f32>,
    // Height above the eye's, measured along the radius; of facets it is interpolated, so that those of a
    // smooth body have no slope, however coarse they are.
    @location(1) above_eye_m: f32,
};

fn surface_vertex(relative_m: vec3<f32>) -> SurfaceVertex {
    return SurfaceVertex(clip_from_eye_relative(relative_m), relative_m, above_eye_m(relative_m));
}

// Difference of two scaled radii as that of their squares over their sum: close to the eye nothing cancels.
fn above_eye_m(relative_m: vec3<f32>) -> f32 {
    let scaled = relative_m * view.normal_scale;
    let difference = dot(scaled, 2.0 * view.eye_ecef + relative_m);
    let eye = dot(view.eye_ecef, view.eye_ecef * view.normal_scale);
    return difference / (sqrt(eye) + sqrt(max(eye + difference, 0.0)));
}

// The geodetic normal under a fragment.
fn up_at(relative_m: vec3<f32>) -> vec3<f32> {
    return normalize((relative_m + view.eye_ecef) * view.normal_scale);
}

// What a fragment's colour is multiplied by.
fn brightness(in: SurfaceVertex, up: vec3<f32>) -> f32 {
    let facing = max(-dot(up, normalize(in.relative_m)), 0.0);
    let shade = 0.35 + 0.65 * sqrt(facing);
    // The height's gradient within the facet: its length is the sine of the slope.
    let right = dpdx(in.relative_m);
    let down = dpdy(in.relative_m);
    let across = cross(right, down);
    let gradient = (dpdx(in.above_eye_m) * cross(down, across) + dpdy(in.above_eye_m) * cross(across, right))
        / dot(across, across);
    let sine_squared = dot(gradient, gradient);
    // A facet seen edge-on may have no normal left in f32, and a wall no slope; both are shaded as level ground.
    // (A comparison with NaN is false.)
    let lean = select(vec3<f32>(0.0), -gradient / (1.0 - sine_squared), sine_squared < 0.9999);
    // Shorter towards the poles, where there is no north-west.
    let north = vec3<f32>(0.0, 0.0, 1.0) - up * up.z;
    let east = vec3<f32>(-up.y, up.x, 0.0);
    // Towards its ends, so that gentle slopes show on a globe and steep ones differ from each other near by.
    let slope = RELIEF_PER_SLOPE * dot(lean, north - east);
    let relief = 1.0 + MOST_RELIEF * slope / (MOST_RELIEF + abs(slope));
    return shade * relief;
}
