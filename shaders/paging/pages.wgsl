// The Earth under a texture in pages. A vertex invocation places a vertex of the globe. A fragment finds the page that it
// wants, shows the deepest page of its place that lies in a slot, and counts itself where it wants.
#import shared/view.wgsl

// The level with all texels.
override FINEST: u32 = 6;
// Whether a fragment finds its level by its footprint. Else it is that of the tree's leaf.
override BY_DERIVATIVE: bool = false;
// Whether fragments are counted.
override COUNTS: bool = true;
// Whether fragments are counted that show a coarser page than their footprint asks for. No rule needs them.
override MEASURES: bool = false;

// Texels along a side of a page, and as it is stored with its border.
const PAGE: f32 = 128.0;
const STORED: f32 = 130.0;
const LEAF: u32 = 0x80000000u;
const SLOT: u32 = 0xFFFFu;

// An entry for each page of each level.
@group(1) @binding(0) var<storage, read> table: array<u32>;
// Fragments that want each page; the last one: those that show a coarser one than their footprint asks for.
@group(1) @binding(1) var<storage, read_write> counts: array<atomic<u32>>;
@group(1) @binding(2) var pages: texture_2d_array<f32>;
@group(1) @binding(3) var between: sampler;

struct Varying {
    @invariant @builtin(position) clip: vec4<f32>,
    @location(0) uv: vec2<f32>,
};

struct Found {
    wanted: u32,
    footprint: u32,
    slot: u32,
    shown: u32,
    // Texels from the corner of the page that is shown.
    local: vec2<f32>,
};

@vertex
fn vertex_main(@location(0) ecef_m: vec3<f32>, @location(1) uv: vec2<f32>) -> Varying {
    return Varying(clip_from_eye_relative(ecef_m - view.eye_ecef), uv);
}

// The level whose texels have the area of the fragment's footprint, to the nearest.
fn level_of_footprint(uv: vec2<f32>) -> u32 {
    let side = PAGE * f32(1u << FINEST);
    let x = dpdxFine(uv) * side;
    let y = dpdyFine(uv) * side;
    let lod = 0.5 * log2(abs(x.x * y.y - x.y * y.x));
    return u32(clamp(f32(FINEST) - lod + 0.5, 0.0, f32(FINEST)));
}

fn find(place: vec2<f32>) -> Found {
    let footprint = level_of_footprint(place);
    let last = select(FINEST, footprint, BY_DERIVATIVE);
    let uv = clamp(place, vec2<f32>(0.0), vec2<f32>(1.0));
    var found = Found(0u, footprint, 0u, 0u, vec2<f32>(0.0));
    var first = 0u;
    var number = 0u;
    for (var level = 0u; level <= FINEST; level++) {
        let side = 1u << level;
        let at = min(vec2<u32>(uv * f32(side)), vec2<u32>(side - 1u));
        number = first + at.y * side + at.x;
        let entry = table[number];
        found.wanted = level;
        if (entry & SLOT) != 0u {
            found.slot = entry & SLOT;
            found.shown = level;
            found.local = (uv * f32(side) - vec2<f32>(at)) * PAGE;
        }
        if level == last || (!BY_DERIVATIVE && (entry & LEAF) != 0u) {
            break;
        }
        first += side * side;
    }
    if COUNTS {
        atomicAdd(&counts[number], 1u);
    }
    if MEASURES && (found.slot == 0u || found.shown < footprint) {
        atomicAdd(&counts[arrayLength(&counts) - 1u], 1u);
    }
    return found;
}

@fragment
fn fragment_main(in: Varying) -> @location(0) vec4<f32> {
    let found = find(in.uv);
    let at = (found.local + 1.0) / STORED;
    return textureSampleLevel(pages, between, at, max(found.slot, 1u) - 1u, 0.0);
}

fn address(at: vec2<i32>, slot: u32) -> u32 {
    let bytes = vec4<u32>(textureLoad(pages, at, slot, 0) * 255.0 + 0.5);
    return bytes.x | bytes.y << 8u | bytes.z << 16u | bytes.w << 24u;
}

// Addresses of the first and the last of the four texels that a filter mixes, the level that is wanted, from 1, and that of the
// footprint.
@fragment
fn fragment_addresses(in: Varying) -> @location(0) vec4<u32> {
    let found = find(in.uv);
    if found.slot == 0u {
        return vec4<u32>(0u, 0u, found.wanted + 1u, found.footprint);
    }
    let at = vec2<i32>(floor(found.local + 0.5));
    let slot = found.slot - 1u;
    return vec4<u32>(address(at, slot), address(at + 1, slot), found.wanted + 1u, found.footprint);
}
