// Ground in blocks of texels and the texels that are looked up in it, whatever keeps the blocks.
struct CacheConstants {
    // Blocks in a row of the ground.
    blocks_across: u32,
    // A side of a block, texels: a power of two.
    side: u32,
    // Number of queries.
    count: u32,
    // Number of blocks.
    blocks: u32,
    // A side of a block, metres.
    block_m: f32,
};

struct TexelQuery {
    // Column and row of the block.
    block: vec2<u32>,
    // Place within it, of its side.
    share: vec2<f32>,
    // The same place from the ground's corner, as a single number each, metres.
    world_m: vec2<f32>,
};

@group(0) @binding(0) var<uniform> cache: CacheConstants;
@group(0) @binding(1) var<storage, read> queries: array<TexelQuery>;
@group(0) @binding(2) var<storage, read_write> answers: array<f32>;

fn block_number(block: vec2<u32>) -> u32 {
    return block.y * cache.blocks_across + block.x;
}

// Exact: shares times a power of two.
fn texel_in_block(share: vec2<f32>) -> vec2<u32> {
    return vec2<u32>(share * f32(cache.side));
}
