// Study `pipelines`: one invocation tests a patch of the tiles in view and lists it where it may be in view; the
// draw has an instance for each. Workgroups of 64, the least width that fills every GPU's subgroups.
#import shared/ground.wgsl

@group(0) @binding(4) var<storage, read_write> kept_patches: array<u32>;

// Vertices, instances, first vertex, first instance; the CPU writes 0 instances before.
struct Arguments {
    vertices: u32,
    instances: atomic<u32>,
    first_vertex: u32,
    first_instance: u32,
};
@group(0) @binding(5) var<storage, read_write> draw_arguments: Arguments;

@compute @workgroup_size(64)
fn compute_main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let number = invocation.x;
    if number >= ground.listed * patches_a_tile() {
        return;
    }
    let patch_number = patch_of_tiles(number);
    if is_kept(patch_number) {
        let slot = atomicAdd(&draw_arguments.instances, 1u);
        kept_patches[slot] = patch_number;
    }
}
