// Constants of each volume in one view, most often that of a region, and a stored position made relative to the eye.
//
// Positions are three i32 in units of `unit_m` (a power of two) from an origin that the CPU holds in
// f64. The eye is subtracted in integers, where nothing is lost:
//     ((v >> shift) − eye) · scale − eye_remainder,   scale = unit · 2^shift,
// with one shift per region and frame so that the eye fits: 0 close up, where every bit counts. The
// difference of neighbouring vertices is therefore exact up to one rounding to f32 of the result.
#import shared/footprint.wgsl

struct VolumeConstants {
    eye: vec3<i32>,
    shift: u32,
    eye_remainder_m: vec3<f32>,
    scale_m: f32,
    origin_ecef_m: vec3<f32>,
    unit_m: f32,
    top_m: f32,
    bottom_m: f32,
    // Layout `pulled` only: where the region's vertices and indices start, in elements.
    first_vertex: u32,
    first_triangle_index: u32,
    first_loop_index: u32,
    triangle_count: u32,
    // Bits of an index in the packed lists: 16 or 32.
    index_bits: u32,
    // Where the volume's `Footprint` begins in `footprints`, in elements; 0: it has none.
    footprint: u32,
    colour: vec4<f32>,
};

@group(0) @binding(1) var<storage, read> regions: array<VolumeConstants>;
// The same buffer: behind the constants of all volumes lie the footprints of those that move.
@group(0) @binding(2) var<storage, read> footprints: array<vec4<f32>>;

// Whether any volume has a footprint. Its stored positions are then the cosine and sine of each vertex's
// angle about the cone's axis, in units of 2⁻³⁰, and its origin is the apex.
override FOOTPRINTS: bool = false;
const CIRCLE_UNIT: f32 = 9.313225746154785e-10;

// How positions are stored: three i32 in units. The others are for comparison only: three f32 metres
// from the region's origin; three f32 metres from the body's centre; those and three more f32 for
// what they rounded away.
const FIXED: u32 = 0u;
const LOCAL_F32: u32 = 1u;
const ECEF_F32: u32 = 2u;
const TWO_FLOAT: u32 = 3u;
override POSITIONS: u32 = FIXED;

// Along what vertices are moved to their caps. The geodetic normal is made here from the position. The direction
// from the body's centre leaves out how oblate the body is, as Cozzi (2007, 2.1.7.3) proposed. A stored normal comes
// with each vertex, as in his meshes. The latter two are for comparison.
const GEODETIC_NORMALS: u32 = 0u;
const CENTRIC_NORMALS: u32 = 1u;
const STORED_NORMALS: u32 = 2u;
override NORMALS: u32 = GEODETIC_NORMALS;

fn footprint_at(first: u32) -> Footprint {
    return Footprint(
        footprints[first],
        footprints[first + 1u],
        footprints[first + 2u],
        footprints[first + 3u],
    );
}

// A vertex at height 0: from the eye, and from the body's centre.
struct OnEllipsoid {
    relative_m: vec3<f32>,
    ecef_m: vec3<f32>,
};

fn on_ellipsoid(stored: vec3<i32>, region_index: u32) -> OnEllipsoid {
    if FOOTPRINTS {
        let first = regions[region_index].footprint;
        if first != 0u {
            let cos_sin = vec2<f32>(stored.xy) * CIRCLE_UNIT;
            let from_apex = footprint_from_apex_m(cos_sin, footprint_at(first));
            return OnEllipsoid(
                from_apex - regions[region_index].eye_remainder_m,
                regions[region_index].origin_ecef_m + from_apex,
            );
        }
    }
    let shift = vec3<u32>(regions[region_index].shift);
    let origin = regions[region_index].origin_ecef_m;
    var relative: vec3<f32>;
    var ecef: vec3<f32>;
    if POSITIONS == LOCAL_F32 {
        let local = bitcast<vec3<f32>>(stored);
        relative = local - regions[region_index].eye_remainder_m;
        ecef = origin + local;
    } else if POSITIONS == ECEF_F32 {
        ecef = bitcast<vec3<f32>>(stored);
        relative = ecef - view.eye_ecef;
    } else {
        let difference = (stored >> shift) - regions[region_index].eye;
        relative = vec3<f32>(difference) * regions[region_index].scale_m
            - regions[region_index].eye_remainder_m;
        ecef = origin + vec3<f32>(stored) * regions[region_index].unit_m;
    }
    return OnEllipsoid(relative, ecef);
}

fn eye_relative_m(stored: vec3<i32>, region_index: u32, height_m: f32) -> vec3<f32> {
    let vertex = on_ellipsoid(stored, region_index);
    return vertex.relative_m + normal_at(vertex.ecef_m) * height_m;
}

// The same along a normal that was stored. The disc of a footprint is stored, not its vertices: they take
// the normal of the place that they are bent to.
fn stored_normal_relative_m(
    stored: vec3<i32>,
    normal: vec3<f32>,
    region_index: u32,
    height_m: f32,
) -> vec3<f32> {
    let vertex = on_ellipsoid(stored, region_index);
    if FOOTPRINTS && regions[region_index].footprint != 0u {
        return vertex.relative_m + normal_at(vertex.ecef_m) * height_m;
    }
    return vertex.relative_m + normal * height_m;
}

// The vertex lies on the ellipsoid, where (x, y, z a²/b²) is parallel to the geodetic normal.
fn normal_at(ecef: vec3<f32>) -> vec3<f32> {
    if NORMALS == CENTRIC_NORMALS {
        return normalize(ecef);
    }
    return normalize(ecef * view.normal_scale);
}

// Parts of like size first: the high ones' difference is exact close up, and the low ones put back
// what they rounded away. WGSL lets compilers add up in another order, which would lose the low
// parts; a test on the device shows whether its compiler does.
fn two_float_difference_m(
    high: vec3<f32>,
    low: vec3<f32>,
    eye_high: vec3<f32>,
    eye_low: vec3<f32>,
) -> vec3<f32> {
    return (high - eye_high) + (low - eye_low);
}

fn two_float_relative_m(
    high: vec3<f32>,
    low: vec3<f32>,
    region_index: u32,
    height_m: f32,
) -> vec3<f32> {
    let eye_low = regions[region_index].eye_remainder_m;
    let relative = two_float_difference_m(high, low, view.eye_ecef, eye_low);
    return relative + normal_at(high) * height_m;
}
