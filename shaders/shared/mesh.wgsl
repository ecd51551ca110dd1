// A mesh of square cells in metres: its camera, and how many cells a side it has.
#import shared/triangles.wgsl

struct MeshConstants {
    // Columns of the matrix from (x, y, z, 1) in metres to clip space.
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    origin: vec4<f32>,
    // A side, of a patch or of the whole.
    cells: u32,
    // Whether a geometry image's cells are cut along its folds: 1 or 0.
    is_folded: u32,
};

@group(0) @binding(0) var<uniform> mesh: MeshConstants;

// By fused steps, so that every stage finds the same bits.
fn clip_in(view: MeshConstants, place: vec3<f32>) -> vec4<f32> {
    let level = fma(view.z, vec4<f32>(place.z), view.origin);
    return fma(view.x, vec4<f32>(place.x), fma(view.y, vec4<f32>(place.y), level));
}

fn clip_from_metres(place: vec3<f32>) -> vec4<f32> {
    return clip_in(mesh, place);
}

// From 1, since 0 is what is not drawn.
fn mesh_triangle(square: u32, cell: vec2<u32>, half: u32) -> u32 {
    return 2u * ((square * mesh.cells + cell.y) * mesh.cells + cell.x) + half + 1u;
}
