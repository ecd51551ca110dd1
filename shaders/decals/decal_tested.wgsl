// Study `decals`: as decal.wgsl, behind the depth of the body itself.
#import shared/decal.wgsl
#import shared/body_depth.wgsl

@group(0) @binding(1) var addresses: texture_2d<f32>;

@vertex
fn vertex_main(@location(0) vertex: vec3<f32>) -> TestedVarying {
    if is_body(vertex) {
        return body_vertex(vertex);
    }
    let at = decal_vertex(vertex);
    return TestedVarying(at.clip, share_of(vertex), at.before);
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
    let at = vec2<u32>(texel(in.share.x), texel(in.share.y));
    return Tested(colour_of(u32(textureLoad(addresses, at, 0).x)), in.clip.z);
}
