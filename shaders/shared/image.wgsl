// A surface as a square of places, one texel a vertex: a side has one more than cells.
#import shared/mesh.wgsl

// Metres.
@group(0) @binding(1) var places: texture_2d<f32>;

fn image_clip(vertex: vec2<u32>) -> vec4<f32> {
    return clip_from_metres(textureLoad(places, vec2<i32>(vertex), 0).xyz);
}

// Corner of a cell as the six vertices of its two triangles, cut from (0, 0) to (1, 1).
fn other_corner(vertex: u32) -> vec2<u32> {
    return vec2<u32>((0x16u >> vertex) & 1u, (0x34u >> vertex) & 1u);
}

// Along the folds of the octahedron that the square was unfolded from, where the mesh says so.
fn image_corner(cell: vec2<u32>, vertex: u32) -> vec2<u32> {
    let is_before = cell < vec2<u32>(mesh.cells / 2u);
    if mesh.is_folded == 1u && is_before.x != is_before.y {
        return other_corner(vertex);
    }
    return corner(vertex);
}
