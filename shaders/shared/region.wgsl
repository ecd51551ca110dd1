// Per-region constants of one view, and a stored position made relative to the eye.
//
// Positions are three i32 in units of `unit_m` (a power of two) from an origin that the CPU holds in
// f64. The eye is subtracted in integers, where nothing is lost:
//     ((v >> shift) − eye) · scale − eye_remainder,   scale = unit · 2^shift,
// with one shift per region and frame so that the eye fits: 0 close up, where every bit counts. The
// difference of neighbouring vertices is therefore exact up to one rounding to f32 of the result.

struct RegionConstants {
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
    padding: u32,
    colour: vec4<f32>,
};

@group(0) @binding(1) var<storage, read> regions: array<RegionConstants>;

// 0: three i32 in units; 1: three f32 in metres from the region's origin, for comparison only.
override POSITIONS_ARE_LOCAL_F32: bool = false;

fn eye_relative_m(stored: vec3<i32>, region_index: u32, height_m: f32) -> vec3<f32> {
    let shift = vec3<u32>(regions[region_index].shift);
    let origin = regions[region_index].origin_ecef_m;
    var relative: vec3<f32>;
    var ecef: vec3<f32>;
    if POSITIONS_ARE_LOCAL_F32 {
        let local = bitcast<vec3<f32>>(stored);
        relative = local - regions[region_index].eye_remainder_m;
        ecef = origin + local;
    } else {
        let difference = (stored >> shift) - regions[region_index].eye;
        relative = vec3<f32>(difference) * regions[region_index].scale_m
            - regions[region_index].eye_remainder_m;
        ecef = origin + vec3<f32>(stored) * regions[region_index].unit_m;
    }
    // The vertex lies on the ellipsoid, where (x, y, z a²/b²) is parallel to the geodetic normal.
    let normal = normalize(ecef * view.normal_scale);
    return relative + normal * height_m;
}
