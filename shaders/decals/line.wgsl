// Study `decals`: one vertex invocation puts a corner of a line's segment on the picture, as wide as it is drawn; one
// fragment invocation writes which part of the line it is.
#import shared/decal.wgsl

@vertex
fn vertex_main(@location(0) vertex: vec3<f32>) -> Varying {
    let end = ribbon(vertex);
    return Varying(end.at.clip, vec2<f32>(end.share, 0.0), end.at.before);
}

@fragment
fn fragment_main(in: Varying) -> @location(0) vec4<f32> {
    if in.before < 0.0 {
        discard;
    }
    return colour_of(1u + texel(in.share.x));
}
