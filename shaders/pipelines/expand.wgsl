// Study `pipelines`: one invocation places a vertex of the grid and keeps its clip position; the first one
// writes the draw's arguments. Workgroups of 64, the least width that fills every GPU's subgroups.
#import shared/grid.wgsl

@group(0) @binding(2) var<storage, read_write> expanded: array<vec4<f32>>;
// Vertices, instances, first vertex, first instance.
@group(0) @binding(3) var<storage, read_write> draw_arguments: array<u32, 4>;

@compute @workgroup_size(8, 8)
fn compute_main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let at = invocation.xy;
    let side = grid.cells + 1u;
    if all(at == vec2<u32>(0u)) {
        draw_arguments = array<u32, 4>(6u * grid.cells * grid.cells, 1u, 0u, 0u);
    }
    if all(at < vec2<u32>(side)) {
        expanded[at.y * side + at.x] = clip_at(at);
    }
}
