// Study `pipelines`: one vertex invocation places a vertex of ground whose blocks are side by side in one texture. Fragments write
// the number of their triangle.
#import shared/blocks.wgsl

@group(0) @binding(1) var blocks: texture_2d<f32>;

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> Varying {
    let found = block_vertex(vertex);
    let texel = vec2<i32>(found.block * (grid.block_cells + 1u) + found.texel);
    return placed(found, textureLoad(blocks, texel, 0).r);
}
