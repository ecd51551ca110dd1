// As `casters/pulled.wgsl`, where no facing bit is stored: each piece computes the facing of its triangles
// from their corners in `f32`, in the order in which it has them. The order differs from piece to piece.
#import shared/view.wgsl
#import shared/volume.wgsl

// From the eye, w = 1; the last one is the direction away from the light, w = 0.
@group(1) @binding(0) var<storage, read> places: array<vec4<f32>>;
// A triangle: its corners, and the highest bit. A side: the ends of its edge, and the corners opposite to it of
// the triangles that have it forwards and backwards.
@group(1) @binding(1) var<storage, read> pieces: array<vec4<u32>>;

const IS_CAP = 0x80000000u;

fn is_lit(a: u32, b: u32, c: u32) -> bool {
    let to_light = -places[arrayLength(&places) - 1u].xyz;
    let first = places[a].xyz;
    return dot(cross(places[b].xyz - first, places[c].xyz - first), to_light) > 0.0;
}

@vertex
fn vertex_main(@builtin(vertex_index) index: u32) -> @invariant @builtin(position) vec4<f32> {
    let piece = pieces[index / 3u];
    var corners = piece.xyz;
    var is_drawn = false;
    if (piece.w & IS_CAP) != 0u {
        is_drawn = is_lit(piece.x, piece.y, piece.z);
    } else {
        let is_forward = is_lit(piece.x, piece.y, piece.z);
        is_drawn = is_forward != is_lit(piece.y, piece.x, piece.w);
        let far = arrayLength(&places) - 1u;
        // Against the lit triangle's direction: the side turns outwards.
        corners = select(vec3<u32>(piece.xy, far), vec3<u32>(piece.yx, far), is_forward);
    }
    if !is_drawn {
        return vec4<f32>(0.0, 0.0, 0.0, 1.0);
    }
    let place = places[corners[index % 3u]];
    let clip = clip_from_eye_relative(place.xyz);
    return vec4<f32>(clip.xy, clip.z * place.w, clip.w);
}
