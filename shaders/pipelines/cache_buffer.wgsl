// Study `pipelines`: one invocation looks up a texel of ground whose blocks are kept in
// one buffer, block by block. Workgroups of 64, the least width that fills every GPU's subgroups.
#import shared/cache.wgsl

@group(0) @binding(3) var<storage, read> blocks: array<f32>;

@compute @workgroup_size(64)
fn loaded(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= cache.count {
        return;
    }
    let number = invocation.x;
    let query = queries[number];
    let texel = texel_in_block(query.share);
    let inner = texel.y * cache.side + texel.x;
    answers[number] = blocks[block_number(query.block) * cache.side * cache.side + inner];
}
