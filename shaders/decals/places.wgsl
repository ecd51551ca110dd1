// Study `decals`: one compute invocation puts a vertex of a decal by the functions of decal.wgsl and keeps its clip
// position, so that it can be held against f64. It is another stage than the one that draws: a compiler may contract
// sums there and not here. Workgroups of 64, the least that all devices have.
#import shared/decal.wgsl

@group(0) @binding(1) var<storage, read> vertices: array<f32>;
@group(0) @binding(2) var<storage, read_write> clips: array<vec4<f32>>;

@compute @workgroup_size(64)
fn place_main(@builtin(global_invocation_id) vertex: vec3<u32>) {
    if vertex.x < arrayLength(&clips) {
        let first = 3u * vertex.x;
        let at = vec3<f32>(vertices[first], vertices[first + 1u], vertices[first + 2u]);
        clips[vertex.x] = decal_vertex(at).clip;
    }
}
