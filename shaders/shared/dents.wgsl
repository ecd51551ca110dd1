// A mesh at rest and the dents that deform it.
#import shared/mesh.wgsl

struct Dent {
    // Metres, and its radius in w.
    middle: vec4<f32>,
    // How its middle is moved, metres.
    push: vec4<f32>,
};

// Metres.
@group(0) @binding(1) var<storage, read> rest: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> dents: array<Dent>;

// Each dent moves what is nearer than its radius, smoothly down to nothing there.
fn deformed(place: vec3<f32>) -> vec3<f32> {
    var sum = place;
    for (var number = 0u; number < arrayLength(&dents); number += 1u) {
        let dent = dents[number];
        let away = (place - dent.middle.xyz) / dent.middle.w;
        let inside = max(0.0, 1.0 - dot(away, away));
        sum += dent.push.xyz * (inside * inside);
    }
    return sum;
}
