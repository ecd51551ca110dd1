// Study `pipelines`: one vertex invocation places a vertex of a patch of 8 x 8 cells, an instance each, of the
// tiles in view or of a list. Fragments write the number of their triangle.
#import shared/ground.wgsl

@group(0) @binding(4) var<storage, read> kept_patches: array<u32>;

struct Varying {
    @invariant @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
};

// Corner of a cell as the six vertices of its two triangles, cut from (1, 0) to (0, 1).
fn corner(vertex: u32) -> vec2<u32> {
    return vec2<u32>((0x2au >> vertex) & 1u, (0x1cu >> vertex) & 1u);
}

fn placed(patch_number: u32, vertex: u32) -> Varying {
    let inner = vertex / 6u;
    let cell = first_cell(patch_number) + vec2<u32>(inner % PATCH_CELLS, inner / PATCH_CELLS);
    let at = cell + corner(vertex % 6u);
    return Varying(clip_at(at), triangle_number(cell, (vertex % 6u) / 3u));
}

@vertex
fn of_tiles(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) number: u32,
) -> Varying {
    return placed(patch_of_tiles(number), vertex);
}

@vertex
fn of_list(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) number: u32,
) -> Varying {
    return placed(kept_patches[number], vertex);
}

// Hands the number of a point's patch on to a geometry shader, or that the patch is culled.
@vertex
fn labelled_point(@builtin(vertex_index) number: u32) -> Varying {
    let patch_number = patch_of_tiles(number);
    let label = select(0xffffffffu, patch_number, is_kept(patch_number));
    return Varying(vec4<f32>(0.0, 0.0, 0.0, 1.0), label);
}

@fragment
fn fragment_main(@location(0) @interpolate(flat) number: u32) -> @location(0) vec4<f32> {
    return colour_of(number);
}
