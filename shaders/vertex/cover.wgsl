// Colour pass: one triangle over the whole target, cut to a region's screen rectangle by the
// scissor and to its pixels by the stencil test. One fragment writes the region's colour. When the
// picture is checked, that colour is the region's id: the pipeline that is timed is the one checked.
#import shared/view.wgsl
#import shared/region.wgsl

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) colour: vec4<f32>,
};

@vertex
fn vertex_main(
    @builtin(vertex_index) vertex_index: u32,
    @builtin(instance_index) region_index: u32,
) -> Varying {
    let x = f32(i32(vertex_index & 1u) * 4 - 1);
    let y = f32(i32(vertex_index >> 1u) * 4 - 1);
    return Varying(vec4<f32>(x, y, 1.0, 1.0), regions[region_index].colour);
}

// Many covers in one draw: each instance is a rectangle, left, bottom, right and top in clip space, of four
// vertices in a strip, with the number of its region.
@vertex
fn rectangle_main(
    @builtin(vertex_index) vertex_index: u32,
    @location(0) edges: vec4<f32>,
    @location(1) region_index: u32,
) -> Varying {
    let x = select(edges.x, edges.z, (vertex_index & 1u) != 0u);
    let y = select(edges.y, edges.w, (vertex_index & 2u) != 0u);
    return Varying(vec4<f32>(x, y, 1.0, 1.0), regions[region_index].colour);
}

@fragment
fn fragment_main(in: Varying) -> @location(0) vec4<f32> {
    return in.colour;
}
