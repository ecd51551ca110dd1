// Study `decals`: one vertex invocation puts a vertex of a decal's grid on the body; one fragment invocation looks up
// the texel of the decal there, which says its own address, and does nothing else.
#import shared/decal.wgsl

@group(0) @binding(1) var addresses: texture_2d<f32>;

@vertex
fn vertex_main(@location(0) vertex: vec3<f32>) -> Varying {
    let at = decal_vertex(vertex);
    return Varying(at.clip, share_of(vertex), at.before);
}

@fragment
fn fragment_main(in: Varying) -> @location(0) vec4<f32> {
    if in.before < 0.0 {
        discard;
    }
    let at = vec2<u32>(texel(in.share.x), texel(in.share.y));
    return colour_of(u32(textureLoad(addresses, at, 0).x));
}
