// Balls of study `balls`, and what shaders that step them or dig their craters are told.
struct BallConstants {
    step_s: f32,
    gravity: f32,
    // k/m of a spring, 1/s².
    stiffness: f32,
    count: u32,
    // Cells along a side of a block, and a side of a cell in metres: powers of two.
    cells: u32,
    cell_m: f32,
    // Blocks along a side of the ground.
    blocks: u32,
    // A number of `Law`.
    law: u32,
    // Share of the speed along the normal that a reflection leaves.
    restitution: f32,
    // Radius of a crater over the speed of the ball that strikes, and its depth over its radius.
    crater_s: f32,
    crater_depth: f32,
};

struct Ball {
    // Metres from the ground's corner, upwards in z; behind them the steps taken.
    place: vec4<f32>,
    // Metres a second; behind them the first impact's time in steps, 0 before it.
    velocity: vec4<f32>,
};
