// Volumes of `instanced`: one invocation is a corner of a cap, read from its vertex, or one of the
// four corners of a wall, made up from the ends of an edge that the wall's instance brings.
//
// caps:  the instance number is the region. Both caps are the same triangles. The pipeline of the
//        bottom sets IS_BOTTOM and turns their front into their back.
// walls: a strip of four vertices an instance: top start, bottom start, top end, bottom end. The
//        instance number is the edge, so the vertex number brings the region: its first vertex is
//        four times the region.
#import shared/view.wgsl
#import shared/region.wgsl
#import shared/volume.wgsl

override IS_BOTTOM: bool = false;

const WALL_CORNERS: u32 = 4u;

fn extrude(position: vec3<i32>, is_bottom: bool, region_index: u32) -> vec4<f32> {
    let height_m = select(
        regions[region_index].top_m,
        regions[region_index].bottom_m,
        is_bottom,
    );
    return clip_from_eye_relative(eye_relative_m(position, region_index, height_m));
}

fn extrude_wall(start: vec3<i32>, end: vec3<i32>, vertex_index: u32) -> vec4<f32> {
    let is_end = (vertex_index & 2u) != 0u;
    let is_bottom = (vertex_index & 1u) != 0u;
    return extrude(select(start, end, is_end), is_bottom, vertex_index / WALL_CORNERS);
}

@vertex
fn caps_main(
    @location(0) position: vec3<i32>,
    @builtin(instance_index) region_index: u32,
) -> @invariant @builtin(position) vec4<f32> {
    return extrude(position, IS_BOTTOM, region_index);
}

@vertex
fn walls_main(
    @location(0) start: vec3<i32>,
    @location(1) end: vec3<i32>,
    @builtin(vertex_index) vertex_index: u32,
) -> @invariant @builtin(position) vec4<f32> {
    return extrude_wall(start, end, vertex_index);
}

@vertex
fn coloured_caps(
    @location(0) position: vec3<i32>,
    @builtin(instance_index) region_index: u32,
) -> Coloured {
    return Coloured(extrude(position, IS_BOTTOM, region_index), regions[region_index].colour);
}

@vertex
fn coloured_walls(
    @location(0) start: vec3<i32>,
    @location(1) end: vec3<i32>,
    @builtin(vertex_index) vertex_index: u32,
) -> Coloured {
    let colour = regions[vertex_index / WALL_CORNERS].colour;
    return Coloured(extrude_wall(start, end, vertex_index), colour);
}

@vertex
fn numbered_caps(
    @location(0) position: vec3<i32>,
    @builtin(instance_index) region_index: u32,
) -> Numbered {
    return numbered(extrude(position, IS_BOTTOM, region_index), region_index);
}

@vertex
fn numbered_walls(
    @location(0) start: vec3<i32>,
    @location(1) end: vec3<i32>,
    @builtin(vertex_index) vertex_index: u32,
) -> Numbered {
    let region_index = vertex_index / WALL_CORNERS;
    return numbered(extrude_wall(start, end, vertex_index), region_index);
}
