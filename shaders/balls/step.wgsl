// Study `balls`: one invocation takes a ball a step of symplectic Euler further, above ground at height 0
// that a spring pushes balls out of. Workgroups of 64, the least width that fills every GPU's subgroups.
#import shared/balls.wgsl

@group(0) @binding(0) var<uniform> constants: BallConstants;
@group(0) @binding(1) var<storage, read> before: array<Ball>;
@group(0) @binding(2) var<storage, read_write> after: array<Ball>;

@compute @workgroup_size(64)
fn step_main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let index = invocation.x;
    if index >= constants.count {
        return;
    }
    var ball = before[index];
    var acceleration = -constants.gravity;
    if ball.place.z < 0.0 {
        acceleration = acceleration - constants.stiffness * ball.place.z;
    }
    ball.velocity.z = ball.velocity.z + constants.step_s * acceleration;
    ball.place = vec4<f32>(ball.place.xyz + constants.step_s * ball.velocity.xyz, ball.place.w);
    after[index] = ball;
}
