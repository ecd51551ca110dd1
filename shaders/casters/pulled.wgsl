// Volumes of objects' shadows, without an end, of meshes whose edges are stored: three invocations a piece, a
// triangle of the light cap or a side. What the facing bits leave out collapses into a point.
#import shared/view.wgsl
#import shared/volume.wgsl

// From the eye, w = 1; the last one is the direction away from the light, w = 0.
@group(1) @binding(0) var<storage, read> places: array<vec4<f32>>;
// A triangle: its corners, and its number with the highest bit set. A side: the ends of its edge, and the
// triangles that have the edge forwards and backwards.
@group(1) @binding(1) var<storage, read> pieces: array<vec4<u32>>;
// A bit a triangle.
@group(1) @binding(2) var<storage, read> lit: array<u32>;

const IS_CAP = 0x80000000u;

fn is_lit(triangle: u32) -> bool {
    return ((lit[triangle >> 5u] >> (triangle & 31u)) & 1u) == 1u;
}

@vertex
fn vertex_main(@builtin(vertex_index) index: u32) -> @invariant @builtin(position) vec4<f32> {
    let piece = pieces[index / 3u];
    var corners = piece.xyz;
    var is_drawn = false;
    if (piece.w & IS_CAP) != 0u {
        is_drawn = is_lit(piece.w & ~IS_CAP);
    } else {
        let is_forward = is_lit(piece.z);
        is_drawn = is_forward != is_lit(piece.w);
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
