// Study `balls`: terrain and the balls on it in one picture. One vertex invocation places one of six vertices of a cell of
// the terrain, from the layer of its block, or one of six of a disc that stands for a ball. Fragments write a number: of a
// ball from 1, of a triangle of the terrain from GROUND.
#import shared/balls.wgsl

struct SceneConstants {
    // Columns of the matrix from metres to clip space.
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    origin: vec4<f32>,
    // Radius of a disc: metres, and in clip space.
    radius_m: f32,
    radius_clip: f32,
    // The number of the terrain's first triangle.
    ground: u32,
    // Cells along a side of a block, and of the terrain; a side of a cell in metres.
    cells: u32,
    across: u32,
    cell_m: f32,
};

@group(0) @binding(0) var<uniform> constants: SceneConstants;
@group(0) @binding(1) var<storage, read> balls: array<Ball>;
// Heights of (cells + 1)² samples of a block in a layer, metres.
@group(0) @binding(2) var heights: texture_2d_array<f32>;

struct Varying {
    @invariant @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
    // Of the disc's radius.
    @location(1) away: vec2<f32>,
};

// By fused steps, so that no compiler has a choice.
fn clip_of(place: vec3<f32>) -> vec4<f32> {
    let level = fma(constants.z, vec4<f32>(place.z), constants.origin);
    let row = fma(constants.y, vec4<f32>(place.y), level);
    return fma(constants.x, vec4<f32>(place.x), row);
}

// Of two triangles of a square: (0, 0), (1, 0), (0, 1) and (1, 1), (0, 1), (1, 0).
fn corner_of(vertex: u32) -> vec2<u32> {
    return (vec2<u32>(0x2au, 0x1cu) >> vec2<u32>(vertex % 6u)) & vec2<u32>(1u);
}

@vertex
fn ground_main(@builtin(vertex_index) vertex: u32) -> Varying {
    let number = vertex / 6u;
    let cell = vec2<u32>(number % constants.across, number / constants.across);
    let block = cell / constants.cells;
    let layer = block.y * (constants.across / constants.cells) + block.x;
    let at = cell + corner_of(vertex);
    let height = textureLoad(heights, at - block * constants.cells, layer, 0).r;
    let place = vec3<f32>(vec2<f32>(at) * constants.cell_m, height);
    return Varying(clip_of(place), constants.ground + vertex / 3u, vec2<f32>(0.0));
}

@vertex
fn ball_main(@builtin(vertex_index) vertex: u32) -> Varying {
    let ball = vertex / 6u;
    let away = 2.0 * vec2<f32>(corner_of(vertex)) - 1.0;
    // The disc stands on the ball's place.
    var clip = clip_of(balls[ball].place.xyz + vec3<f32>(0.0, 0.0, constants.radius_m));
    clip = vec4<f32>(clip.xy + constants.radius_clip * away, clip.zw);
    return Varying(clip, ball + 1u, away);
}

@fragment
fn fragment_main(
    @location(0) @interpolate(flat) number: u32,
    @location(1) away: vec2<f32>,
) -> @location(0) vec4<f32> {
    if dot(away, away) > 1.0 {
        discard;
    }
    return unpack4x8unorm(number | 0xff000000u);
}
