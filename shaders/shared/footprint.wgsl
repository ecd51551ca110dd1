// Where the edge of a sensor's cone meets the body, in f32: twin of `ConeEdge` in terrafill-core, which
// has the formula, and a bound on how far the two are apart.
//
// The direction of a ray is axis + right cos + forward sin, of unit length.
struct Footprint {
    // xyz: axis; w: |apex / radii|² − 1.
    axis_and_power: vec4<f32>,
    // xyz: right; w: 1 / equatorial radius, per metre.
    right_and_inverse_a: vec4<f32>,
    // xyz: forward; w: 1 / polar radius, per metre.
    forward_and_inverse_b: vec4<f32>,
    // xyz: apex / radii.
    scaled_apex: vec4<f32>,
};

// From the apex to the body's surface, ECEF metres.
fn footprint_from_apex_m(cos_sin: vec2<f32>, footprint: Footprint) -> vec3<f32> {
    let direction = footprint.axis_and_power.xyz
        + footprint.right_and_inverse_a.xyz * cos_sin.x
        + footprint.forward_and_inverse_b.xyz * cos_sin.y;
    let inverse_a = footprint.right_and_inverse_a.w;
    let inverse_b = footprint.forward_and_inverse_b.w;
    let scaled = direction * vec3<f32>(inverse_a, inverse_a, inverse_b);
    let along = dot(footprint.scaled_apex.xyz, scaled);
    let power = footprint.axis_and_power.w;
    let root = sqrt(max(along * along - power * dot(scaled, scaled), 0.0));
    return direction * (power / (root - along));
}
