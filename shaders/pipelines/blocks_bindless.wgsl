// Study `pipelines`: one vertex invocation places a vertex of ground whose blocks are textures of one array. Fragments write
// the number of their triangle.
enable wgpu_binding_array;
#import shared/blocks.wgsl

// In a group of its own: WebGPU keeps such arrays apart from uniforms.
@group(1) @binding(0) var blocks: binding_array<texture_2d<f32>>;

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> Varying {
    let found = block_vertex(vertex);
    let texel = vec2<i32>(found.texel);
    return placed(found, textureLoad(blocks[layer_of(found.block)], texel, 0).r);
}
