// Study `pipelines`: one invocation looks up a texel of ground whose blocks are kept in
// a texture of its own, which is bound for the queries of its block. Workgroups of 64, the least width that fills every GPU's subgroups.
#import shared/cache.wgsl

@group(0) @binding(3) var block_texels: texture_2d<f32>;

@compute @workgroup_size(64)
fn loaded(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= cache.count {
        return;
    }
    let number = cache.first + invocation.x;
    let query = queries[number];
    let texel = vec2<i32>(texel_in_block(query.share));
    answers[number] = textureLoad(block_texels, texel, 0).r;
}
