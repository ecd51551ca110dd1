// Study `pipelines`: one fragment writes a height of a block into its layer: what was there, less the craters that
// reach it. The target is the layer; its heights before lie in a texture of their own.
struct Crater {
    // Columns and rows of the whole ground.
    place: vec2<f32>,
    // Cells.
    radius: f32,
    // Metres, in the middle.
    depth: f32,
};

struct CraterConstants {
    // Column and row of the block's first sample.
    first: vec2<u32>,
    count: u32,
};

@group(0) @binding(0) var<uniform> constants: CraterConstants;
@group(0) @binding(1) var<storage, read> craters: array<Crater>;
@group(0) @binding(2) var before: texture_2d<f32>;

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> @invariant @builtin(position) vec4<f32> {
    // One triangle around the whole target.
    let at = vec2<f32>(f32((vertex << 1u) & 2u), f32(vertex & 2u));
    return vec4<f32>(2.0 * at - 1.0, 0.0, 1.0);
}

@fragment
fn fragment_main(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let texel = vec2<u32>(at.xy);
    var height = textureLoad(before, vec2<i32>(texel), 0).r;
    let place = vec2<f32>(constants.first + texel);
    for (var number = 0u; number < constants.count; number++) {
        let crater = craters[number];
        let away = (place - crater.place) / crater.radius;
        height -= crater.depth * max(0.0, 1.0 - dot(away, away));
    }
    return vec4<f32>(height, 0.0, 0.0, 1.0);
}
