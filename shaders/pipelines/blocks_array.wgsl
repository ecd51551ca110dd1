// Study `pipelines`: one vertex invocation places a vertex of ground whose blocks are layers of one array texture. Fragments write
// the number of their triangle.
#import shared/blocks.wgsl

@group(0) @binding(1) var blocks: texture_2d_array<f32>;

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> Varying {
    let found = block_vertex(vertex);
    let texel = vec2<i32>(found.texel);
    return placed(found, textureLoad(blocks, texel, layer_of(found.block), 0).r);
}
