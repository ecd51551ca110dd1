// Pixels of each node of a quadtree, exactly. A vertex invocation places a corner of a node's mesh and a fragment writes
// the node's number. One compute invocation adds a pixel to its node's count. Workgroups of 8 × 8 pixels: most of
// one is of one node.
#import shared/view.wgsl

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) node: u32,
};

@group(1) @binding(0) var nodes: texture_2d<u32>;
@group(1) @binding(1) var<storage, read_write> counts: array<atomic<u32>>;

@vertex
fn vertex_main(@location(0) relative_m: vec3<f32>, @location(1) node: u32) -> Varying {
    return Varying(clip_from_eye_relative(relative_m), node);
}

// Numbers begin at 1; 0 is what was cleared.
@fragment
fn fragment_main(in: Varying) -> @location(0) u32 {
    return in.node;
}

@compute @workgroup_size(8, 8)
fn count_main(@builtin(global_invocation_id) pixel: vec3<u32>) {
    if any(pixel.xy >= textureDimensions(nodes)) {
        return;
    }
    let node = textureLoad(nodes, pixel.xy, 0).r;
    if node > 0u && node < arrayLength(&counts) {
        atomicAdd(&counts[node], 1u);
    }
}
