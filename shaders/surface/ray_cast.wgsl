// Ray cast: one fragment meets its pixel's ray with the body itself and writes the depth of the hit.
// Lengths are shares of the equatorial radius, in the space where the body is the unit sphere; what
// cancels near the body, the eye's height, comes from f64.

struct RayConstants {
    // xyz: ray of the image's upper left corner, and what a column and a row add to it, scaled; w: its
    // scalar product with the eye.
    corner: vec4<f32>,
    column: vec4<f32>,
    row: vec4<f32>,
    // The eye, scaled, and its squared distance from the centre less 1.
    eye: vec3<f32>,
    height: f32,
    // Turns a scaled position into a multiple of the geodetic normal there, and a scaled ray into a true one.
    normal_scale: vec3<f32>,
    // Near plane over the equatorial radius.
    near: f32,
    unscale: vec3<f32>,
};

@group(0) @binding(0) var<uniform> rays: RayConstants;

struct Hit {
    @location(0) colour: vec4<f32>,
    @builtin(frag_depth) depth: f32,
};

@vertex
fn vertex_main(@builtin(vertex_index) vertex_index: u32) -> @builtin(position) vec4<f32> {
    let x = f32(i32(vertex_index & 1u) * 4 - 1);
    let y = f32(i32(vertex_index >> 1u) * 4 - 1);
    return vec4<f32>(x, y, 1.0, 1.0);
}

@fragment
fn fragment_main(@builtin(position) pixel: vec4<f32>) -> Hit {
    let ray = rays.corner + rays.column * pixel.x + rays.row * pixel.y;
    let squared = dot(ray.xyz, ray.xyz);
    let discriminant = ray.w * ray.w - squared * rays.height;
    if ray.w >= 0.0 || discriminant < 0.0 {
        discard;
    }
    // The form of the quadratic formula in which nothing cancels near the body.
    let along = rays.height / (-ray.w + sqrt(discriminant));
    let up = normalize((rays.eye + ray.xyz * along) * rays.normal_scale);
    let facing = max(-dot(up, normalize(ray.xyz * rays.unscale)), 0.0);
    let shade = 0.35 + 0.65 * sqrt(facing);
    return Hit(vec4<f32>(vec3<f32>(0.36, 0.46, 0.58) * shade, 0.0), rays.near / along);
}
