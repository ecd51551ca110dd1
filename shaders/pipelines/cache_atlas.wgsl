// Study `pipelines`: one invocation looks up a texel of ground whose blocks are kept in
// one texture that holds all blocks side by side. Workgroups of 64, the least width that fills every GPU's subgroups.
#import shared/cache.wgsl

@group(0) @binding(3) var blocks: texture_2d<f32>;
@group(0) @binding(4) var nearest: sampler;

@compute @workgroup_size(64)
fn loaded(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= cache.count {
        return;
    }
    let number = invocation.x;
    let query = queries[number];
    let texel = cache.side * query.block + texel_in_block(query.share);
    answers[number] = textureLoad(blocks, vec2<i32>(texel), 0).r;
}

// Block and share in one number of the whole picture, which rounds near the borders of texels.
@compute @workgroup_size(64)
fn sampled(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= cache.count {
        return;
    }
    let number = invocation.x;
    let query = queries[number];
    let size = vec2<f32>(f32(cache.blocks_across), f32(cache.blocks / cache.blocks_across));
    let place = (vec2<f32>(query.block) + query.share) / size;
    answers[number] = textureSampleLevel(blocks, nearest, place, 0.0).r;
}
