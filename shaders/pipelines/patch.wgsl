// Study `pipelines`: one vertex invocation places a vertex of a patch of 64 x 64 cells, an instance each,
// whose indices all patches share. Fragments write the number of their triangle.
enable primitive_index;
#import shared/grid.wgsl

const SIDE: u32 = 64u;

struct Varying {
    @invariant @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) first_cell: vec2<u32>,
};

@vertex
fn vertex_main(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) patch_number: u32,
) -> Varying {
    let patches = grid.cells / SIDE;
    let first_cell = SIDE * vec2<u32>(patch_number % patches, patch_number / patches);
    let at = first_cell + vec2<u32>(vertex % (SIDE + 1u), vertex / (SIDE + 1u));
    return Varying(clip_at(at), first_cell);
}

@fragment
fn fragment_main(
    @builtin(primitive_index) triangle: u32,
    @location(0) @interpolate(flat) first_cell: vec2<u32>,
) -> @location(0) vec4<f32> {
    let cell = first_cell + vec2<u32>((triangle / 2u) % SIDE, triangle / (2u * SIDE));
    return colour_of(triangle_number(cell, triangle % 2u));
}
