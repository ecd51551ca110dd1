// Study `pipelines`: one invocation places a vertex of a bicubic patch's cells and keeps its clip position, patch by
// patch and row by row. Workgroups of 64, the least width that fills every GPU's subgroups.
#import shared/bezier.wgsl

@group(0) @binding(2) var<storage, read_write> placed: array<vec4<f32>>;

@compute @workgroup_size(64)
fn compute_main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let vertex = invocation.x;
    if vertex < arrayLength(&placed) {
        let side = mesh.cells + 1u;
        let at = vec2<u32>(vertex % side, (vertex / side) % side);
        placed[vertex] = clip_from_metres(on_patch(vertex / (side * side), at));
    }
}
