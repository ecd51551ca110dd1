// Volumes of objects' shadows, found anew each frame: one invocation a piece, a triangle of a caster or an
// edge, appends the triangles that it brings to its caster's indices. 64 invocations a group: two warps.

struct Shape {
    pieces: u32,
    // From a vertex to its end; where all end in one point, that point.
    far: u32,
    // 1 where each vertex has an end of its own, and caps are drawn there too.
    is_closed: u32,
    unused: u32,
};

// As `casters/pulled.wgsl` has them.
@group(0) @binding(0) var<storage, read> pieces: array<vec4<u32>>;
// Caster of each piece.
@group(0) @binding(1) var<storage, read> owners: array<u32>;
// A bit a triangle.
@group(0) @binding(2) var<storage, read> lit: array<u32>;
@group(0) @binding(3) var<uniform> shape: Shape;
// Five words a caster, arguments of an indirect draw: indices, instances, first index, base, first instance.
@group(0) @binding(4) var<storage, read_write> draws: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> indices: array<u32>;

const IS_CAP = 0x80000000u;

fn is_lit(triangle: u32) -> bool {
    return ((lit[triangle >> 5u] >> (triangle & 31u)) & 1u) == 1u;
}

fn put(at: u32, corners: vec3<u32>) {
    indices[at] = corners.x;
    indices[at + 1u] = corners.y;
    indices[at + 2u] = corners.z;
}

// Room for so many indices of a caster: the place of the first.
fn room(caster: u32, count: u32) -> u32 {
    let first = atomicLoad(&draws[5u * caster + 2u]);
    return first + atomicAdd(&draws[5u * caster], count);
}

@compute @workgroup_size(64)
fn find(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= shape.pieces {
        return;
    }
    let piece = pieces[id.x];
    let caster = owners[id.x];
    let is_closed = shape.is_closed == 1u;
    let count = select(3u, 6u, is_closed);
    if (piece.w & IS_CAP) != 0u {
        if is_lit(piece.w & ~IS_CAP) {
            let at = room(caster, count);
            put(at, piece.xyz);
            if is_closed {
                // Wound back.
                put(at + 3u, piece.xzy + shape.far);
            }
        }
        return;
    }
    let is_forward = is_lit(piece.z);
    if is_forward == is_lit(piece.w) {
        return;
    }
    // Against the lit triangle's direction: the side turns outwards.
    let side = select(piece.xy, piece.yx, is_forward);
    let at = room(caster, count);
    if is_closed {
        put(at, vec3<u32>(side, side.y + shape.far));
        put(at + 3u, vec3<u32>(side.x, side.y + shape.far, side.x + shape.far));
    } else {
        put(at, vec3<u32>(side, shape.far));
    }
}
