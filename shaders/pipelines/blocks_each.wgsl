// Study `pipelines`: one vertex invocation places a vertex of ground whose blocks are a texture each, bound for its own draw. Fragments write
// the number of their triangle.
#import shared/blocks.wgsl

@group(0) @binding(1) var block: texture_2d<f32>;

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> Varying {
    let found = block_vertex(vertex);
    let texel = vec2<i32>(found.texel);
    return placed(found, textureLoad(block, texel, 0).r);
}
