// Study `decals`: as line.wgsl, behind the depth of the body itself.
#import shared/decal.wgsl
#import shared/body_depth.wgsl

@vertex
fn vertex_main(@location(0) vertex: vec3<f32>) -> TestedVarying {
    if is_body(vertex) {
        return body_vertex(vertex);
    }
    let end = ribbon(vertex);
    return TestedVarying(end.at.clip, vec2<f32>(end.share, 0.0), end.at.before);
}

@fragment
fn fragment_main(in: TestedVarying) -> Tested {
    if in.before > 0.5 * BODY {
        let depth = body_depth(in.share);
        if depth < 0.0 {
            discard;
        }
        return tested(depth);
    }
    if in.before < 0.0 {
        discard;
    }
    return Tested(colour_of(1u + texel(in.share.x)), in.clip.z);
}
