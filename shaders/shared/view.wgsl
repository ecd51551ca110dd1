// The camera: positions relative to the eye (metres, ECEF axes) to clip space.
// Depth is reversed with an infinite far plane: z/w = near / distance.

struct ViewConstants {
    // Columns of the rotation from ECEF axes to view axes (x right, y up, z towards the viewer).
    view_from_ecef: mat3x3<f32>,
    // Eye, ECEF metres, rounded to f32: too coarse to subtract from positions by itself.
    eye_ecef: vec3<f32>,
    near_m: f32,
    // (1, 1, a²/b²): turns an ECEF position into a multiple of the geodetic normal there.
    normal_scale: vec3<f32>,
    // 1 / (tan(fov/2) · aspect) and 1 / tan(fov/2).
    clip_scale_x: f32,
    clip_scale_y: f32,
    // Height of a pixel at distance 1: 2 tan(fov/2) / rows.
    pixel_per_distance: f32,
};

@group(0) @binding(0) var<uniform> view: ViewConstants;

// By fused steps: what is drawn twice, as surface and as part of a volume, then has the same depth, whichever
// shader's compiler would else choose to fuse.
fn clip_from_eye_relative(relative_m: vec3<f32>) -> vec4<f32> {
    let axes = view.view_from_ecef;
    let p = fma(axes[0], vec3<f32>(relative_m.x), fma(axes[1], vec3<f32>(relative_m.y), axes[2] * relative_m.z));
    return vec4<f32>(p.x * view.clip_scale_x, p.y * view.clip_scale_y, view.near_m, -p.z);
}
