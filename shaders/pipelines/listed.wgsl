// Study `pipelines`, on wgpu: one vertex invocation places a vertex of a list in the layer of its instance's number.
// Depth alone is drawn into a map; with a fragment, that depth is added to what is there.
#import shared/layers.wgsl

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) depth: f32,
};

@vertex
fn listed(@builtin(vertex_index) vertex: u32, @builtin(instance_index) layer: u32) -> Varying {
    let place = places[vertex].xyz;
    let clip = seen_by(layer, place);
    // Rows of a texture run against WebGPU's y.
    return Varying(vec4<f32>(clip.x, -clip.y, clip.zw), clip.z);
}

@fragment
fn added(@location(0) depth: f32) -> @location(0) vec4<f32> {
    return vec4<f32>(depth * layers.weight);
}
