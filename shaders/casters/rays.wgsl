enable wgpu_ray_query;
// Shadows by rays of the device: one invocation a pixel sends a ray from what it sees to the sun. 8 × 8 a group:
// neighbours meet the same boxes.
#import shared/receiver.wgsl

@group(0) @binding(4) var tree: acceleration_structure;
// 1 where a pixel is in shadow.
@group(0) @binding(5) var<storage, read_write> answers: array<u32>;

// A driver takes for the front of a triangle the side from which it is wound counter-clockwise. From below one that
// faces the sun is seen from behind.
const CULL_FRONT_FACING = 0x20u;
// Farther than anything, m.
const FAR_M = 1e9;

@compute @workgroup_size(8, 8)
fn ask(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= receivers.size) {
        return;
    }
    let at = id.y * receivers.size.x + id.x;
    let depth = depth_m(at);
    var is_dark = false;
    if depth > 0.0 {
        let place = ray_through(centre(id.xy)) * depth;
        var query: ray_query;
        let to_sun = RayDesc(CULL_FRONT_FACING, 0xffu, 0.0, FAR_M, place, receivers.to_light.xyz);
        rayQueryInitialize(&query, tree, to_sun);
        while rayQueryProceed(&query) {
            let candidate = rayQueryGetCandidateIntersection(&query);
            // The one that the pixel sees is met too.
            if is_below(place, depth, triangles[candidate.primitive_index]) {
                is_dark = true;
                break;
            }
        }
    }
    answers[at] = select(0u, 1u, is_dark);
}
