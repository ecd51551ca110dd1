// Triangles of a list, which are drawn into layers by a matrix each.
struct Layer {
    // Columns of the matrix from a place to the layer: -1 to 1 across and along the rows, 0 to 1 in depth.
    column: vec4<f32>,
    row: vec4<f32>,
    height: vec4<f32>,
    origin: vec4<f32>,
};

struct Layers {
    each: array<Layer, 128>,
    count: u32,
    // By which a layer is added to a sum.
    weight: f32,
};

@group(0) @binding(1) var<storage, read> places: array<vec4<f32>>;
@group(0) @binding(2) var<uniform> layers: Layers;

// By fused steps, so that no compiler has a choice and every stage finds the same bits.
fn seen_by(number: u32, place: vec3<f32>) -> vec4<f32> {
    let layer = layers.each[number];
    let level = fma(layer.height, vec4<f32>(place.z), layer.origin);
    return fma(layer.column, vec4<f32>(place.x), fma(layer.row, vec4<f32>(place.y), level));
}
