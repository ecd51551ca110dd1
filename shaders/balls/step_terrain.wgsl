// Study `balls`: one invocation takes a ball a step of symplectic Euler further, as balls/step.wgsl, above bilinear
// terrain whose spring pushes along its normal. Workgroups of 64, the least width that fills every GPU's
// subgroups.
struct BallConstants {
    step_s: f32,
    gravity: f32,
    // k/m, 1/s².
    stiffness: f32,
    count: u32,
    // A side of the terrain, and of a cell in metres.
    cells: u32,
    cell_m: f32,
};

struct Ball {
    // Metres from the terrain's corner, upwards in z.
    place: vec4<f32>,
    velocity: vec4<f32>,
};

@group(0) @binding(0) var<uniform> constants: BallConstants;
@group(0) @binding(1) var<storage, read> before: array<Ball>;
@group(0) @binding(2) var<storage, read_write> after: array<Ball>;
// Heights of (cells + 1)² vertices, metres, row by row.
@group(0) @binding(3) var<storage, read> heights: array<f32>;

// Slopes along x and y, and height.
fn ground_at(place: vec2<f32>) -> vec3<f32> {
    let at = place / constants.cell_m;
    let last = f32(constants.cells - 1u);
    let cell = clamp(floor(at), vec2<f32>(0.0), vec2<f32>(last));
    let share = at - cell;
    let side = constants.cells + 1u;
    let first = u32(cell.y) * side + u32(cell.x);
    let near = heights[first];
    let right = heights[first + 1u];
    let below = heights[first + side];
    let far = heights[first + side + 1u];
    let across = mix(right - near, far - below, share.y);
    let down = mix(below - near, far - right, share.x);
    let height = mix(near, right, share.x) + share.y * down;
    return vec3<f32>(across / constants.cell_m, down / constants.cell_m, height);
}

@compute @workgroup_size(64)
fn step_main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let index = invocation.x;
    if index >= constants.count {
        return;
    }
    var ball = before[index];
    let ground = ground_at(ball.place.xy);
    var acceleration = vec3<f32>(0.0, 0.0, -constants.gravity);
    let below = ground.z - ball.place.z;
    if below > 0.0 {
        let normal = normalize(vec3<f32>(-ground.xy, 1.0));
        acceleration = acceleration + constants.stiffness * below * normal.z * normal;
    }
    let velocity = ball.velocity.xyz + constants.step_s * acceleration;
    ball.velocity = vec4<f32>(velocity, ball.velocity.w);
    ball.place = vec4<f32>(ball.place.xyz + constants.step_s * velocity, ball.place.w);
    after[index] = ball;
}
