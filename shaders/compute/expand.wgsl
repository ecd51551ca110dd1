// Makes volumes from meshes: one invocation turns one cap triangle into a top and a bottom one, or
// one boundary edge into two wall triangles, or one vertex into two corners in clip space. 64 invocations a workgroup: the widest subgroup there
// is, and small enough that short boundaries waste little.
//
// A corner is written as 2·vertex on top, 2·vertex + 1 at the bottom. A region's indices lie
//     bottom cap | top cap, walls
// so that a draw may begin after the bottom. Where pieces are left out, what remains of the bottom
// ends at the same place and what remains of the rest begins there: one list grows down, the other
// up, and a draw of either kind stays one draw.
#import shared/view.wgsl
#import shared/region.wgsl
#import shared/draw.wgsl

// What one workgroup does; sizes and places in indices.
struct WorkGroup {
    // Index of the region's constants and draws.
    region: u32,
    // First corner of the triangles, or first vertex of the edges.
    first_input: u32,
    // Where top triangles or walls go.
    first_output: u32,
    // Where bottom triangles go.
    first_bottom_output: u32,
    // Triangles or edges, at most 64.
    count: u32,
    // Sum of `WALLS`, `SHORT_INDICES` and `WITHOUT_BOTTOM`.
    kind: u32,
};

const WALLS: u32 = 1u;
const SHORT_INDICES: u32 = 2u;
// No draw of the view has the region's bottom cap, and there is no room for one.
const WITHOUT_BOTTOM: u32 = 4u;

// x, y, z of vertex i at 3i, 3i + 1, 3i + 2.
@group(1) @binding(0) var<storage, read> positions: array<i32>;
// 32-bit indices, or two 16-bit ones a word, low half first.
@group(1) @binding(1) var<storage, read> indices: array<u32>;
@group(2) @binding(0) var<storage, read> work: array<WorkGroup>;
@group(2) @binding(1) var<storage, read_write> expanded: array<u32>;
// In its place where corners are written: in clip space.
@group(2) @binding(1) var<storage, read_write> placed: array<vec4<f32>>;

fn fetch_index(element: u32, kind: u32) -> u32 {
    if (kind & SHORT_INDICES) == 0u {
        return indices[element];
    }
    let word = indices[element >> 1u];
    return select(word & 0xffffu, word >> 16u, (element & 1u) == 1u);
}

fn write_triangle(at: u32, a: u32, b: u32, c: u32) {
    expanded[at] = a;
    expanded[at + 1u] = b;
    expanded[at + 2u] = c;
}

// Corners on top of the triangle that is number `lane` of its workgroup.
fn cap_corners(index: u32, lane: u32) -> vec3<u32> {
    let first = work[index].first_input + 3u * lane;
    let kind = work[index].kind;
    return 2u * vec3<u32>(
        fetch_index(first, kind),
        fetch_index(first + 1u, kind),
        fetch_index(first + 2u, kind),
    );
}

// Ends on top of the edge that is number `lane` of its workgroup.
fn edge_ends(index: u32, lane: u32) -> vec2<u32> {
    let first = work[index].first_input + lane;
    let kind = work[index].kind;
    return 2u * vec2<u32>(fetch_index(first, kind), fetch_index(first + 1u, kind));
}

fn write_top(at: u32, top: vec3<u32>) {
    write_triangle(at, top.x, top.y, top.z);
}

// Seen from below the winding is the other one.
fn write_bottom(at: u32, top: vec3<u32>) {
    write_triangle(at, top.x + 1u, top.z + 1u, top.y + 1u);
}

// The same diagonal as every backend's walls, from the bottom of the start to the top of the end.
fn write_wall(at: u32, ends: vec2<u32>) {
    write_triangle(at, ends.x, ends.x + 1u, ends.y);
    write_triangle(at + 3u, ends.y, ends.x + 1u, ends.y + 1u);
}

// A dispatch has as many rows of workgroups as it takes; the last row may reach beyond the work.
fn work_index(workgroup: vec3<u32>, workgroups: vec3<u32>) -> u32 {
    return workgroup.y * workgroups.x + workgroup.x;
}

fn has_work(index: u32, lane: u32) -> bool {
    return index < arrayLength(&work) && lane < work[index].count;
}

fn expand(index: u32, lane: u32) {
    let first_output = work[index].first_output;
    if (work[index].kind & WALLS) != 0u {
        write_wall(first_output + 6u * lane, edge_ends(index, lane));
        return;
    }
    let top = cap_corners(index, lane);
    write_top(first_output + 3u * lane, top);
    if (work[index].kind & WITHOUT_BOTTOM) == 0u {
        write_bottom(work[index].first_bottom_output + 3u * lane, top);
    }
}

// Everything.
@compute @workgroup_size(64)
fn expand_all(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = work_index(workgroup, workgroups);
    if has_work(index, lane) {
        expand(index, lane);
    }
}

// Regions that are drawn.
@compute @workgroup_size(64)
fn expand_drawn(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = work_index(workgroup, workgroups);
    if has_work(index, lane) && states[work[index].region] != LEFT_OUT {
        expand(index, lane);
    }
}

fn clip_position(corner: u32, region_index: u32) -> vec4<f32> {
    let first = 3u * (regions[region_index].first_vertex + (corner >> 1u));
    let position = vec3<i32>(positions[first], positions[first + 1u], positions[first + 2u]);
    let height_m = select(
        regions[region_index].top_m,
        regions[region_index].bottom_m,
        (corner & 1u) != 0u,
    );
    return clip_from_eye_relative(eye_relative_m(position, region_index, height_m));
}

// Both corners of one vertex. `first_input` of the work is a vertex here.
@compute @workgroup_size(64)
fn place_corners(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = work_index(workgroup, workgroups);
    if !has_work(index, lane) {
        return;
    }
    let region = work[index].region;
    let top = 2u * (work[index].first_input + lane);
    let at = work[index].first_output + 2u * lane;
    placed[at] = clip_position(top, region);
    placed[at + 1u] = clip_position(top + 1u, region);
}

// Bits of the planes of the view frustum that a point lies outside of: right, left, up, down, near.
// A thousandth of w is half a pixel or more up to 1,000 pixels a side, and far above rounding for
// any size: a point outside by less counts as inside.
fn outside_planes(clip: vec4<f32>) -> u32 {
    let limit = clip.w + 1e-3 * abs(clip.w);
    return select(0u, 1u, clip.x > limit) | select(0u, 2u, -clip.x > limit)
        | select(0u, 4u, clip.y > limit) | select(0u, 8u, -clip.y > limit)
        | select(0u, 16u, clip.w < 0.999 * view.near_m);
}

fn corner_planes(corner: u32, region_index: u32) -> u32 {
    return outside_planes(clip_position(corner, region_index));
}

// Regions that are drawn, without the pieces that lie wholly outside one plane of the frustum.
@compute @workgroup_size(64)
fn expand_visible(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = work_index(workgroup, workgroups);
    if !has_work(index, lane) {
        return;
    }
    let region = work[index].region;
    let state = states[region];
    if state == WHOLE {
        expand(index, lane);
    }
    if state != PIECES {
        return;
    }
    let whole = 2u * region;
    if (work[index].kind & WALLS) != 0u {
        let ends = edge_ends(index, lane);
        let planes = corner_planes(ends.x, region) & corner_planes(ends.x + 1u, region)
            & corner_planes(ends.y, region) & corner_planes(ends.y + 1u, region);
        if planes == 0u {
            write_wall(append_upwards(whole, 6u), ends);
        }
        return;
    }
    let top = cap_corners(index, lane);
    let top_planes = corner_planes(top.x, region) & corner_planes(top.y, region)
        & corner_planes(top.z, region);
    if top_planes == 0u {
        write_top(append_upwards(whole, 3u), top);
    }
    let bottom_planes = corner_planes(top.x + 1u, region) & corner_planes(top.y + 1u, region)
        & corner_planes(top.z + 1u, region);
    if bottom_planes == 0u && (work[index].kind & WITHOUT_BOTTOM) == 0u {
        write_bottom(append_downwards(whole, 3u), top);
    }
}

// Room for `count` indices after the bottom cap. Order among workgroups is left to the device: no
// stencil operation of a fill depends on it.
fn append_upwards(whole: u32, count: u32) -> u32 {
    atomicAdd(&draws[whole].index_count, count);
    let place = atomicAdd(&draws[whole + 1u].index_count, count);
    return atomicLoad(&draws[whole + 1u].first_index) + place;
}

// Room for `count` indices before what the bottom cap has already.
fn append_downwards(whole: u32, count: u32) -> u32 {
    atomicAdd(&draws[whole].index_count, count);
    return atomicSub(&draws[whole].first_index, count) - count;
}
