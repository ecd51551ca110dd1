// Study `pipelines`: one vertex invocation places a vertex of ground whose blocks are slices of a volume texture. Fragments write
// the number of their triangle.
#import shared/blocks.wgsl

@group(0) @binding(1) var blocks: texture_3d<f32>;

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> Varying {
    let found = block_vertex(vertex);
    let texel = vec3<i32>(vec3<u32>(found.texel, layer_of(found.block)));
    return placed(found, textureLoad(blocks, texel, 0).r);
}
