// Study `pipelines`: one invocation places a vertex of a geometry image and keeps its clip position, row by row.
// Workgroups of 64, the least width that fills every GPU's subgroups.
#import shared/image.wgsl

@group(0) @binding(2) var<storage, read_write> placed: array<vec4<f32>>;

@compute @workgroup_size(64)
fn compute_main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let vertex = invocation.x;
    if vertex < arrayLength(&placed) {
        let side = mesh.cells + 1u;
        placed[vertex] = image_clip(vec2<u32>(vertex % side, vertex / side));
    }
}
