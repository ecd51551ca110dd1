// The depth of the body itself under a triangle over the whole picture, to test decals and lines against.

struct Tested {
    @location(0) colour: vec4<f32>,
    @builtin(frag_depth) depth: f32,
};

struct TestedVarying {
    @builtin(position) clip: vec4<f32>,
    @location(0) share: vec2<f32>,
    // 2 for the body, at most 1 for all else.
    @location(1) before: f32,
};

const BODY: f32 = 2.0;

// Corners of that triangle have the number −1, and their place on the picture.
fn is_body(vertex: vec3<f32>) -> bool {
    return vertex.z < 0.0;
}

fn body_vertex(vertex: vec3<f32>) -> TestedVarying {
    return TestedVarying(vec4<f32>(vertex.xy, 0.5, 1.0), vertex.xy, BODY);
}

// Of the nearer place where the ray meets the body; below 0 where it meets none.
fn body_depth(at: vec2<f32>) -> f32 {
    let ray = decal.forward + at.x * decal.right + at.y * decal.up;
    let toward = dot(decal.eye, ray);
    let root = toward * toward - dot(ray, ray) * decal.height;
    if root < 0.0 || toward >= 0.0 {
        return -1.0;
    }
    return decal.near * (-toward + sqrt(root)) / decal.height;
}

// The body's own number, behind all texels'.
fn tested(depth: f32) -> Tested {
    return Tested(colour_of(1u + decal.texels * decal.texels), depth);
}
