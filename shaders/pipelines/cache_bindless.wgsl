// Study `pipelines`: one invocation looks up a texel of ground whose blocks are kept in
// an array of textures, one a block. Workgroups of 64, the least width that fills every GPU's subgroups.
enable wgpu_binding_array;
#import shared/cache.wgsl

// In a group of its own: WebGPU keeps such arrays apart from uniforms.
@group(1) @binding(0) var blocks: binding_array<texture_2d<f32>>;

@compute @workgroup_size(64)
fn loaded(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= cache.count {
        return;
    }
    let number = invocation.x;
    let query = queries[number];
    let texel = vec2<i32>(texel_in_block(query.share));
    answers[number] = textureLoad(blocks[block_number(query.block)], texel, 0).r;
}
