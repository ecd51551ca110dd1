// Surface pass: one vertex invocation places a vertex of the planet. One fragment shades it as if
// lit from the eye, and its facet's slope as if lit from the north-west. Alpha stays 0, so that a
// pixel with alpha 1 was coloured by a fill.
#import shared/relief.wgsl

@vertex
fn vertex_main(@location(0) relative_m: vec3<f32>) -> SurfaceVertex {
    return surface_vertex(relative_m);
}

@fragment
fn fragment_main(in: SurfaceVertex) -> @location(0) vec4<f32> {
    return vec4<f32>(BARE_COLOUR * brightness(in, up_at(in.relative_m)), 0.0);
}
