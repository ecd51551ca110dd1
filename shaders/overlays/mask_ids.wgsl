// Ids of a mask texture: one invocation is a corner of a region's triangle in the plane of longitude and
// latitude. One fragment writes the region's id; of two regions the later one stays.

struct Flat {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) id: u32,
};

@vertex
fn vertex_main(@location(0) clip: vec2<f32>, @location(1) id: u32) -> Flat {
    return Flat(vec4<f32>(clip, 0.5, 1.0), id);
}

@fragment
fn fragment_main(in: Flat) -> @location(0) u32 {
    return in.id;
}
