// Volumes of `vertex/pulled`: no vertex is stored twice and no index list is stored for walls
// or bottom caps. One invocation works out from `vertex_index` which corner of which triangle it is
// and fetches that vertex.
//
// caps:  3 vertices a triangle for the top, then 3 a triangle for the bottom, winding reversed; a
//        draw of the first half leaves the bottom out.
// walls: 6 vertices an entry of the loop list; entry e and e + 1 are an edge's ends. A loop is
//        stored closed (first vertex again at its end) and followed by a separator; the entries
//        before and at a separator give triangles of zero area.
#import shared/view.wgsl
#import shared/region.wgsl
#import shared/volume.wgsl

// x, y, z of vertex i at 3i, 3i + 1, 3i + 2; of two floats the high parts at 6i, then the low ones;
// with stored normals the position at 6i, then the normal.
@group(1) @binding(0) var<storage, read> positions: array<i32>;
// 32-bit indices, or two 16-bit ones a word, low half first.
@group(1) @binding(1) var<storage, read> indices: array<u32>;

const NO_VERTEX: u32 = 0xffffffffu;

fn fetch_index(region_index: u32, element: u32) -> u32 {
    if regions[region_index].index_bits == 32u {
        return indices[element];
    }
    let word = indices[element >> 1u];
    let half = select(word & 0xffffu, word >> 16u, (element & 1u) == 1u);
    return select(half, NO_VERTEX, half == 0xffffu);
}

fn fetch_words(first: u32) -> vec3<i32> {
    return vec3<i32>(positions[first], positions[first + 1u], positions[first + 2u]);
}

fn extrude(region_index: u32, vertex: u32, is_bottom: bool) -> vec4<f32> {
    let height_m = select(
        regions[region_index].top_m,
        regions[region_index].bottom_m,
        is_bottom,
    );
    let stored = regions[region_index].first_vertex + vertex;
    if POSITIONS == TWO_FLOAT {
        let high = bitcast<vec3<f32>>(fetch_words(6u * stored));
        let low = bitcast<vec3<f32>>(fetch_words(6u * stored + 3u));
        return clip_from_eye_relative(two_float_relative_m(high, low, region_index, height_m));
    }
    if NORMALS == STORED_NORMALS {
        let normal = bitcast<vec3<f32>>(fetch_words(6u * stored + 3u));
        let position = fetch_words(6u * stored);
        return clip_from_eye_relative(
            stored_normal_relative_m(position, normal, region_index, height_m),
        );
    }
    let position = fetch_words(3u * stored);
    return clip_from_eye_relative(eye_relative_m(position, region_index, height_m));
}

fn extrude_cap(vertex_index: u32, region_index: u32) -> vec4<f32> {
    let top_count = 3u * regions[region_index].triangle_count;
    let is_bottom = vertex_index >= top_count;
    let in_cap = select(vertex_index, vertex_index - top_count, is_bottom);
    let corner = in_cap % 3u;
    // 0 1 2 on top, 0 2 1 at the bottom.
    let slot = select(corner, (3u - corner) % 3u, is_bottom);
    let element = regions[region_index].first_triangle_index + in_cap - corner + slot;
    return extrude(region_index, fetch_index(region_index, element), is_bottom);
}

@vertex
fn caps_main(
    @builtin(vertex_index) vertex_index: u32,
    @builtin(instance_index) region_index: u32,
) -> @invariant @builtin(position) vec4<f32> {
    return extrude_cap(vertex_index, region_index);
}

fn extrude_wall(vertex_index: u32, region_index: u32) -> vec4<f32> {
    let entry = regions[region_index].first_loop_index + vertex_index / 6u;
    let corner = vertex_index % 6u;
    let start = fetch_index(region_index, entry);
    let end = fetch_index(region_index, entry + 1u);
    if start == NO_VERTEX || end == NO_VERTEX {
        return vec4<f32>(0.0, 0.0, 0.0, 1.0);
    }
    // Two triangles: top start, bottom start, top end; top end, bottom start, bottom end.
    let is_end = corner == 2u || corner == 3u || corner == 5u;
    let is_bottom = corner == 1u || corner == 4u || corner == 5u;
    return extrude(region_index, select(start, end, is_end), is_bottom);
}

@vertex
fn walls_main(
    @builtin(vertex_index) vertex_index: u32,
    @builtin(instance_index) region_index: u32,
) -> @invariant @builtin(position) vec4<f32> {
    return extrude_wall(vertex_index, region_index);
}

@vertex
fn coloured_caps(
    @builtin(vertex_index) vertex_index: u32,
    @builtin(instance_index) region_index: u32,
) -> Coloured {
    return Coloured(extrude_cap(vertex_index, region_index), regions[region_index].colour);
}

@vertex
fn coloured_walls(
    @builtin(vertex_index) vertex_index: u32,
    @builtin(instance_index) region_index: u32,
) -> Coloured {
    return Coloured(extrude_wall(vertex_index, region_index), regions[region_index].colour);
}

@vertex
fn numbered_caps(
    @builtin(vertex_index) vertex_index: u32,
    @builtin(instance_index) region_index: u32,
) -> Numbered {
    return numbered(extrude_cap(vertex_index, region_index), region_index);
}

@vertex
fn numbered_walls(
    @builtin(vertex_index) vertex_index: u32,
    @builtin(instance_index) region_index: u32,
) -> Numbered {
    return numbered(extrude_wall(vertex_index, region_index), region_index);
}
