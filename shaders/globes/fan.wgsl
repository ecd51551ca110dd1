// The spiral's fan and its turns, drawn from one static buffer by draw arguments alone, so that the pixels of each are
// counted apart (Gebbie and Bailey, occlusion queries). One vertex invocation places a corner of the triangle that its
// number says. Every stored vertex has five triangles. First come its own of a fan, and the one that closes a fan that it
// begins. Then come the one that begins the turns about that fan, and two between its turn and the next. One fragment
// writes what its triangle is of, or colours it. Metres from the eye, ECEF axes.
#import shared/view.wgsl
#import shared/spiral.wgsl

@group(0) @binding(1) var<uniform> spiral: SpiralConstants;
// From a focus to each stored vertex, in radii of the body: east, north and down.
@group(0) @binding(2) var<storage, read> stored: array<f32>;

// Stands for the fan's centre.
const CENTRE: u32 = 0xffffffffu;

struct Varying {
    @invariant @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) part: u32,
};

// Vertices of a triangle, counter-clockwise from above.
fn corners(triangle: u32, count: u32) -> vec3<u32> {
    let n = spiral.per_turn;
    let k = triangle % count;
    switch triangle / count {
        case 0u: { return vec3<u32>(CENTRE, k + 1u, k); }
        case 1u: { return vec3<u32>(CENTRE, k, k + n - 1u); }
        case 2u: { return vec3<u32>(k, k + n, k + n - 1u); }
        default: {
            let pair = triangle - 3u * count;
            let base = pair / 2u;
            if pair % 2u == 0u {
                return vec3<u32>(base, base + 1u, base + n);
            }
            return vec3<u32>(base + 1u, base + n + 1u, base + n);
        }
    }
}

@vertex
fn vertex_main(@builtin(vertex_index) corner: u32) -> Varying {
    let count = arrayLength(&stored) / 3u;
    let triangle = corner / 3u;
    let three = corners(triangle, count);
    // By a choice of each, since not every driver indexes a vector by a variable.
    let number = select(select(three.z, three.y, corner % 3u == 1u), three.x, corner % 3u == 0u);
    var way = vec3<f32>(0.0);
    if number != CENTRE {
        let at = 3u * number;
        way = spiral.east * stored[at] + spiral.north * stored[at + 1u] - spiral.up * stored[at + 2u];
    }
    return Varying(clip_from_eye_relative(way + spiral.focus), select(2u, 1u, triangle < 2u * count));
}

// Numbers begin at 1; 0 is what was cleared.
@fragment
fn number_main(in: Varying) -> @location(0) u32 {
    return in.part;
}

@fragment
fn colour_main(in: Varying) -> @location(0) vec4<f32> {
    return select(vec4<f32>(0.2, 0.4, 0.8, 1.0), vec4<f32>(0.9, 0.6, 0.1, 1.0), in.part == 1u);
}
