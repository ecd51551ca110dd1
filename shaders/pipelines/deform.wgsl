// Study `pipelines`: one invocation deforms a vertex of a mesh and keeps it. Workgroups of 64, the least width that fills
// every GPU's subgroups.
#import shared/dents.wgsl

@group(0) @binding(4) var<storage, read_write> kept: array<vec4<f32>>;

@compute @workgroup_size(64)
fn compute_main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let vertex = invocation.x;
    if vertex < arrayLength(&kept) {
        kept[vertex] = vec4<f32>(deformed(rest[vertex].xyz), 1.0);
    }
}
