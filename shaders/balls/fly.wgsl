// Study `balls`: one invocation takes a ball a step of free flight further and reflects it about the normal of the
// ground that it meets. Blocks of the ground lie in the layers of one array texture, and a ball's place chooses its
// layer. Workgroups of 64, the least width that fills every GPU's subgroups.
#import shared/balls.wgsl

const PUBLISHED: u32 = 0u;
const EVENT: u32 = 2u;
// Chords that find where a step meets the ground: to the last places of f32.
const CUTS: u32 = 8u;

@group(0) @binding(0) var<uniform> constants: BallConstants;
@group(0) @binding(1) var<storage, read> before: array<Ball>;
@group(0) @binding(2) var<storage, read_write> after: array<Ball>;
// Heights of (cells + 1)² samples of a block in a layer, metres.
@group(0) @binding(3) var heights: texture_2d_array<f32>;

// Slopes along x and y, and height. Quotients by powers of two are exact, and so is the choice of the layer.
fn ground_at(place: vec2<f32>) -> vec3<f32> {
    let at = place / constants.cell_m;
    let cells = f32(constants.cells);
    let block = clamp(floor(at / cells), vec2<f32>(0.0), vec2<f32>(f32(constants.blocks) - 1.0));
    let inside = at - block * cells;
    let cell = clamp(floor(inside), vec2<f32>(0.0), vec2<f32>(cells - 1.0));
    let share = inside - cell;
    let layer = i32(block.y) * i32(constants.blocks) + i32(block.x);
    let first = vec2<i32>(cell);
    let near = textureLoad(heights, first, layer, 0).r;
    let right = textureLoad(heights, first + vec2<i32>(1, 0), layer, 0).r;
    let below = textureLoad(heights, first + vec2<i32>(0, 1), layer, 0).r;
    let far = textureLoad(heights, first + vec2<i32>(1, 1), layer, 0).r;
    let across = mix(right - near, far - below, share.y);
    let down = mix(below - near, far - right, share.x);
    let height = mix(near, right, share.x) + share.y * down;
    return vec3<f32>(across / constants.cell_m, down / constants.cell_m, height);
}

fn flown(place: vec3<f32>, velocity: vec3<f32>, time: f32) -> vec3<f32> {
    let upwards = velocity.z - 0.5 * constants.gravity * time;
    return place + time * vec3<f32>(velocity.xy, upwards);
}

// Height above the ground.
fn gap(place: vec3<f32>) -> f32 {
    return place.z - ground_at(place.xy).z;
}

// The share of a step at which a ball meets the ground that it is below at its end: by chords, of which an end that
// stays counts half (Illinois).
fn meets(place: vec3<f32>, velocity: vec3<f32>, end: f32) -> f32 {
    var low = vec2<f32>(0.0, gap(place));
    var high = vec2<f32>(1.0, end);
    if low.y <= 0.0 {
        return 0.0;
    }
    var side = 0;
    for (var cut = 0u; cut < CUTS; cut++) {
        let share = (high.x * low.y - low.x * high.y) / (low.y - high.y);
        let found = gap(flown(place, velocity, share * constants.step_s));
        if found > 0.0 {
            low = vec2<f32>(share, found);
            high.y *= select(1.0, 0.5, side == 1);
            side = 1;
        } else {
            high = vec2<f32>(share, found);
            low.y *= select(1.0, 0.5, side == -1);
            side = -1;
        }
    }
    return high.x;
}

@compute @workgroup_size(64)
fn step_main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let index = invocation.x;
    if index >= constants.count {
        return;
    }
    var ball = before[index];
    let place = ball.place.xyz;
    let velocity = ball.velocity.xyz;
    var to = flown(place, velocity, constants.step_s);
    var onward = vec3<f32>(velocity.xy, velocity.z - constants.gravity * constants.step_s);
    var ground = ground_at(to.xy);
    if to.z < ground.z {
        var share = 1.0;
        if constants.law == EVENT {
            share = meets(place, velocity, to.z - ground.z);
            let time = share * constants.step_s;
            to = flown(place, velocity, time);
            ground = ground_at(to.xy);
            onward.z = velocity.z - constants.gravity * time;
        }
        let normal = normalize(vec3<f32>(-ground.xy, 1.0));
        let outwards = dot(onward, normal);
        if outwards < 0.0 || constants.law == PUBLISHED {
            onward = onward - (1.0 + constants.restitution) * outwards * normal;
            if ball.velocity.w == 0.0 {
                ball.velocity.w = ball.place.w + share;
            }
        }
        if constants.law == EVENT {
            let rest = (1.0 - share) * constants.step_s;
            to = flown(vec3<f32>(to.xy, ground.z), onward, rest);
            onward.z = onward.z - constants.gravity * rest;
        }
    }
    ball.place = vec4<f32>(to, ball.place.w + 1.0);
    ball.velocity = vec4<f32>(onward, ball.velocity.w);
    after[index] = ball;
}
