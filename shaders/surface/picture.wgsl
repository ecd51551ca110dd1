// Surface pass of a planet with a picture: as surface.wgsl, with the colour of a picture of the whole body, whose
// columns are longitudes from −180° and whose rows are geodetic latitudes from 90° down.
#import shared/relief.wgsl
#import shared/srgb.wgsl

const PI: f32 = 3.14159265;

@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var image_sampler: sampler;

@vertex
fn vertex_main(@location(0) relative_m: vec3<f32>) -> SurfaceVertex {
    return surface_vertex(relative_m);
}

// Length of a step along the ground, seen from the body's centre, radians.
fn ground_step(step_m: vec3<f32>, up: vec3<f32>, radius_m: f32) -> f32 {
    return length(cross(up, step_m)) / radius_m;
}

@fragment
fn fragment_main(in: SurfaceVertex) -> @location(0) vec4<f32> {
    let up = up_at(in.relative_m);
    // At a pole every column is right, and none follows from a vector without length.
    let cos_latitude = length(up.xy);
    let east_west = select(vec2<f32>(1.0, 0.0), up.xy, cos_latitude > 1e-6);
    let uv = vec2<f32>(
        0.5 + atan2(east_west.y, east_west.x) / (2.0 * PI),
        0.5 - atan2(up.z, cos_latitude) / PI,
    );
    // The level by what a pixel spans on the ground in texels of a meridian. Neighbouring pixels' places in the
    // picture would leave a line of coarse texels at ±180°, and blur all columns into one around the poles.
    let radius_m = length(in.relative_m + view.eye_ecef);
    let right = ground_step(dpdx(in.relative_m), up, radius_m);
    let down = ground_step(dpdy(in.relative_m), up, radius_m);
    let texels = max(right, down) * f32(textureDimensions(image).y) / PI;
    let texel = textureSampleLevel(image, image_sampler, uv, log2(max(texels, 1.0)));
    let colour = mix(BARE_COLOUR, srgb_of_linear(texel.xyz), texel.w);
    return vec4<f32>(colour * brightness(in, up), 0.0);
}
