// Study `balls`: four vertices stand around the crater of a ball that has met the ground for the first time in a step,
// an instance a layer and ball. One fragment writes how deep the crater is at a sample, which blending takes off the
// layer's height.
#import shared/balls.wgsl

@group(0) @binding(0) var<uniform> constants: BallConstants;
@group(0) @binding(1) var<storage, read> before: array<Ball>;
@group(0) @binding(2) var<storage, read> after: array<Ball>;

struct Varying {
    @builtin(position) clip: vec4<f32>,
    // Samples of the layer across and down, radius in cells, depth in metres.
    @location(0) @interpolate(flat) crater: vec4<f32>,
};

@vertex
fn vertex_main(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Varying {
    let was = before[instance % constants.count];
    let met = after[instance % constants.count].velocity.w;
    if was.velocity.w != 0.0 || met == 0.0 {
        // No crater: all four vertices at one place outside of the layer.
        return Varying(vec4<f32>(2.0, 2.0, 0.0, 1.0), vec4<f32>(0.0));
    }
    let layer = instance / constants.count;
    let time = (met - was.place.w) * constants.step_s;
    let place = was.place.xy + time * was.velocity.xy;
    let speed = length(vec3<f32>(was.velocity.xy, was.velocity.z - constants.gravity * time));
    let radius = constants.crater_s * speed;
    let block = vec2<f32>(vec2<u32>(layer % constants.blocks, layer / constants.blocks) * constants.cells);
    // Exact: a side of a cell is a power of two, and what is left has no more places.
    let at = place / constants.cell_m - block;
    let cells = radius / constants.cell_m;
    let sign = 2.0 * vec2<f32>(vec2<u32>(corner & 1u, corner >> 1u)) - 1.0;
    // A cell more all round; sample 0 is in the middle of texel 0.
    let texel = at + 0.5 + (cells + 1.0) * sign;
    let share = 2.0 * texel / f32(constants.cells + 1u) - 1.0;
    return Varying(
        vec4<f32>(share.x, -share.y, 0.0, 1.0),
        vec4<f32>(at, cells, constants.crater_depth * radius),
    );
}

@fragment
fn fragment_main(
    @builtin(position) at: vec4<f32>,
    @location(0) @interpolate(flat) crater: vec4<f32>,
) -> @location(0) vec4<f32> {
    let away = (floor(at.xy) - crater.xy) / crater.z;
    return vec4<f32>(crater.w * max(0.0, 1.0 - dot(away, away)), 0.0, 0.0, 0.0);
}
