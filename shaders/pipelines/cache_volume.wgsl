// Study `pipelines`: one invocation looks up a texel of ground whose blocks are kept in
// slices of a volume texture. Workgroups of 64, the least width that fills every GPU's subgroups.
#import shared/cache.wgsl

@group(0) @binding(3) var blocks: texture_3d<f32>;
@group(0) @binding(4) var nearest: sampler;

@compute @workgroup_size(64)
fn loaded(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= cache.count {
        return;
    }
    let number = invocation.x;
    let query = queries[number];
    let texel = vec2<i32>(texel_in_block(query.share));
    let slice = i32(block_number(query.block));
    answers[number] = textureLoad(blocks, vec3<i32>(texel, slice), 0).r;
}

// The middle of the slice, so that the nearest one is it.
@compute @workgroup_size(64)
fn sampled(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= cache.count {
        return;
    }
    let number = invocation.x;
    let query = queries[number];
    let slice = (f32(block_number(query.block)) + 0.5) / f32(cache.blocks);
    answers[number] = textureSampleLevel(blocks, nearest, vec3<f32>(query.share, slice), 0.0).r;
}
