// Flat mesh: one invocation is a vertex of a region's triangles at the height of its top; the instance
// number is the region. One fragment writes the region's colour where the mesh is nearer than the
// surface.
#import shared/view.wgsl
#import shared/region.wgsl
#import shared/volume.wgsl

@vertex
fn vertex_main(
    @location(0) position: vec3<i32>,
    @builtin(instance_index) region_index: u32,
) -> Coloured {
    let relative_m = eye_relative_m(position, region_index, regions[region_index].top_m);
    return Coloured(clip_from_eye_relative(relative_m), regions[region_index].colour);
}
