// Study `pipelines`: one invocation looks up a texel of ground whose blocks are kept in
// layers of one array texture, the layer a variable. Workgroups of 64, the least width that fills every GPU's subgroups.
#import shared/cache.wgsl

@group(0) @binding(3) var blocks: texture_2d_array<f32>;
@group(0) @binding(4) var nearest: sampler;

@compute @workgroup_size(64)
fn loaded(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= cache.count {
        return;
    }
    let number = invocation.x;
    let query = queries[number];
    let texel = vec2<i32>(texel_in_block(query.share));
    answers[number] = textureLoad(blocks, texel, block_number(query.block), 0).r;
}

// As published: nearest texel, clamped to the edge.
@compute @workgroup_size(64)
fn sampled(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= cache.count {
        return;
    }
    let number = invocation.x;
    let query = queries[number];
    let layer = block_number(query.block);
    answers[number] = textureSampleLevel(blocks, nearest, query.share, layer, 0.0).r;
}

// The layer from one number for the whole ground, which rounds at the borders of blocks.
@compute @workgroup_size(64)
fn by_world(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= cache.count {
        return;
    }
    let number = invocation.x;
    let query = queries[number];
    let place = query.world_m / cache.block_m;
    let block = floor(place);
    let layer = min(block_number(vec2<u32>(block)), cache.blocks - 1u);
    let texel = min(texel_in_block(place - block), vec2<u32>(cache.side - 1u));
    answers[number] = textureLoad(blocks, vec2<i32>(texel), layer, 0).r;
}
