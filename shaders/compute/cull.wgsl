// Decides which regions are drawn, and writes the arguments of their draws: one invocation a
// region, 64 a workgroup.
//
// The tests are the frame plan's (`terrafill_scene::FramePlan`): all corners of a box around the
// whole closed volume outside one plane of the frustum, or all in the shadow that the body casts
// from the eye. They run in f32, so each keeps a distance of 1e-5 of the largest term, some 160
// times its rounding. What is left out here, the plan would leave out as well.
#import shared/view.wgsl
#import shared/draw.wgsl

struct CullRegion {
    // Middle of the box from the eye, metres, ECEF axes.
    center_m: vec3<f32>,
    // Where the region's indices begin: the bottom cap.
    first_index: u32,
    // Half the box's edges.
    half_edge_0_m: vec3<f32>,
    bottom_count: u32,
    half_edge_1_m: vec3<f32>,
    // Top cap and walls.
    upper_count: u32,
    half_edge_2_m: vec3<f32>,
    // Added to each index: where the region's corners begin, if they lie in a buffer.
    base_vertex: i32,
};

// The shadow, in the space where a body wholly below the surface is the unit sphere.
struct Horizon {
    eye: vec3<f32>,
    // Squared distance from the eye to the horizon circle; not positive: nothing is hidden.
    tangent_squared: f32,
    // From metres.
    scale: vec3<f32>,
    padding: u32,
};

@group(3) @binding(1) var<storage, read> cull_regions: array<CullRegion>;
@group(3) @binding(2) var<uniform> horizon: Horizon;

// Whether pieces of regions that the frustum cuts are tested; otherwise those are drawn whole.
override TESTS_PIECES: bool = false;

const MARGIN: f32 = 1e-5;

fn outside_planes(corner_m: vec3<f32>) -> u32 {
    let p = view.view_from_ecef * corner_m;
    let x = p.x * view.clip_scale_x;
    let y = p.y * view.clip_scale_y;
    let margin = MARGIN * length(p) * (1.0 + view.clip_scale_x + view.clip_scale_y);
    return select(0u, 1u, x + p.z > margin) | select(0u, 2u, -x + p.z > margin)
        | select(0u, 4u, y + p.z > margin) | select(0u, 8u, -y + p.z > margin)
        | select(0u, 16u, p.z > margin);
}

// Cozzi and Ring (2011), "3D Engine Design for Virtual Globes", §4.
fn is_hidden(corner_m: vec3<f32>) -> bool {
    let to_corner = corner_m * horizon.scale;
    let along = -dot(to_corner, horizon.eye);
    let tangent_squared = horizon.tangent_squared;
    let length_squared = dot(to_corner, to_corner);
    let largest_squared = length_squared * dot(horizon.eye, horizon.eye);
    return tangent_squared > 0.0
        && along - tangent_squared > MARGIN * (sqrt(largest_squared) + tangent_squared)
        && along * along - tangent_squared * length_squared > MARGIN * largest_squared;
}

fn state_of(region: u32) -> u32 {
    var all_outside = 31u;
    var any_outside = 0u;
    var all_hidden = true;
    for (var i = 0u; i < 8u; i++) {
        let side = vec3<f32>(vec3<u32>(i, i >> 1u, i >> 2u) & vec3<u32>(1u)) * 2.0 - 1.0;
        let corner_m = cull_regions[region].center_m
            + side.x * cull_regions[region].half_edge_0_m
            + side.y * cull_regions[region].half_edge_1_m
            + side.z * cull_regions[region].half_edge_2_m;
        let planes = outside_planes(corner_m);
        all_outside &= planes;
        any_outside |= planes;
        all_hidden = all_hidden && is_hidden(corner_m);
    }
    if all_outside != 0u || all_hidden {
        return LEFT_OUT;
    }
    // Inside all planes no piece can be outside one.
    return select(WHOLE, PIECES, TESTS_PIECES && any_outside != 0u);
}

// A region left out has nothing to draw; to one drawn by pieces they are appended.
fn write_draw(draw: u32, region: u32, first_index: u32, count: u32, state: u32) {
    atomicStore(&draws[draw].index_count, select(0u, count, state == WHOLE));
    draws[draw].instance_count = 1u;
    atomicStore(&draws[draw].first_index, first_index);
    draws[draw].base_vertex = cull_regions[region].base_vertex;
    draws[draw].first_instance = region;
}

@compute @workgroup_size(64)
fn cull_main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let region = invocation.x;
    if region >= arrayLength(&cull_regions) {
        return;
    }
    let state = state_of(region);
    states[region] = state;
    let first_index = cull_regions[region].first_index;
    let upper_first = first_index + cull_regions[region].bottom_count;
    let upper_count = cull_regions[region].upper_count;
    let whole_count = cull_regions[region].bottom_count + upper_count;
    // What is appended to the bottom grows down from where it ends.
    let whole_first = select(first_index, upper_first, state == PIECES);
    write_draw(2u * region, region, whole_first, whole_count, state);
    write_draw(2u * region + 1u, region, upper_first, upper_count, state);
}
