// Study `pipelines`, on wgpu: one vertex invocation places a vertex of a list in the layer of its instance's number.
// Depth alone is drawn.
#import shared/layers.wgsl

@vertex
fn listed(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) layer: u32,
) -> @builtin(position) vec4<f32> {
    let clip = seen_by(layer, places[vertex].xyz);
    // Rows of a texture run against WebGPU's y.
    return vec4<f32>(clip.x, -clip.y, clip.zw);
}
