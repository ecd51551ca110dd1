// Shadows by triangles through a hierarchy of tiles (Sintorn, Olsson and Assarsson, 2011): tiles of 8, 32 and 128
// pixels with the least and the greatest depth in them. First one invocation a tile, level by level; then one a
// triangle that faces the sun, which goes down into the tiles that its volume meets; then one a pixel. 64 a group.
#import shared/receiver.wgsl

// Least and greatest depth of each tile, m, level by level; 0 for tiles of sky.
@group(0) @binding(4) var<storage, read_write> boxes: array<vec2<f32>>;
// A bit a pixel, two words a tile of 8 pixels; then a word a tile of the other levels, 1 where all of it is dark.
@group(0) @binding(5) var<storage, read_write> dark: array<atomic<u32>>;
// 1 where a pixel is in shadow.
@group(0) @binding(6) var<storage, read_write> answers: array<u32>;

const ALL = 0xffffffffu;
// What a tile may differ from its volume's planes by rounding, m a metre.
const ROUNDING = 4e-6;
// How a tile lies to a volume.
const OUTSIDE = 0u;
const ACROSS = 1u;
const INSIDE = 2u;

fn side(level: u32) -> u32 {
    return 8u << (2u * level);
}

fn tiles(level: u32) -> vec2<u32> {
    return (receivers.size + side(level) - 1u) / side(level);
}

fn count(level: u32) -> u32 {
    let both = tiles(level);
    return both.x * both.y;
}

// Place of a tile in `boxes`.
fn place_of(level: u32, tile: vec2<u32>) -> u32 {
    var first = 0u;
    for (var lower = 0u; lower < level; lower++) {
        first += count(lower);
    }
    return first + tile.y * tiles(level).x + tile.x;
}

// Place of the word of a tile of an upper level in `dark`.
fn word_of(level: u32, tile: vec2<u32>) -> u32 {
    return place_of(level, tile) + count(0u);
}

fn tile_at(level: u32, at: u32) -> vec2<u32> {
    let width = tiles(level).x;
    return vec2<u32>(at % width, at / width);
}

fn joined(one: vec2<f32>, other: vec2<f32>) -> vec2<f32> {
    if one.y == 0.0 || other.y == 0.0 {
        return max(one, other);
    }
    return vec2<f32>(min(one.x, other.x), max(one.y, other.y));
}

@compute @workgroup_size(64)
fn bound(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= count(0u) {
        return;
    }
    let first = 8u * tile_at(0u, id.x);
    let past = min(first + 8u, receivers.size);
    var own = vec2<f32>(0.0);
    for (var y = first.y; y < past.y; y++) {
        for (var x = first.x; x < past.x; x++) {
            own = joined(own, vec2<f32>(depth_m(y * receivers.size.x + x)));
        }
    }
    boxes[id.x] = own;
}

fn join_level(level: u32, at: u32) {
    if at >= count(level) {
        return;
    }
    let tile = tile_at(level, at);
    let first = 4u * tile;
    let past = min(first + 4u, tiles(level - 1u));
    var own = vec2<f32>(0.0);
    for (var y = first.y; y < past.y; y++) {
        for (var x = first.x; x < past.x; x++) {
            own = joined(own, boxes[place_of(level - 1u, vec2<u32>(x, y))]);
        }
    }
    boxes[place_of(level, tile)] = own;
}

@compute @workgroup_size(64)
fn join_middle(@builtin(global_invocation_id) id: vec3<u32>) {
    join_level(1u, id.x);
}

@compute @workgroup_size(64)
fn join_top(@builtin(global_invocation_id) id: vec3<u32>) {
    join_level(2u, id.x);
}

// The volume of a triangle, from it away from the sun: its plane, and one through each edge along the light.
struct Wedge {
    triangle: vec4<u32>,
    // Unit, outwards.
    plane: vec3<f32>,
    sides: array<vec3<f32>, 3>,
    // A place on each side.
    on_sides: array<vec3<f32>, 3>,
};

fn wedge_of(triangle: vec4<u32>) -> Wedge {
    var wedge: Wedge;
    wedge.triangle = triangle;
    wedge.plane = outward(triangle);
    let corners = array<u32, 3>(triangle.x, triangle.y, triangle.z);
    for (var at = 0u; at < 3u; at++) {
        // From the lower to the higher index: the same bits for both triangles of an edge, so that no place
        // slips between them.
        let from_corner = corners[at];
        let to_corner = corners[(at + 1u) % 3u];
        let low = places[min(from_corner, to_corner)].xyz;
        let high = places[max(from_corner, to_corner)].xyz;
        let across = normalize(cross(high - low, receivers.to_light.xyz));
        wedge.sides[at] = select(across, -across, from_corner > to_corner);
        wedge.on_sides[at] = low;
    }
    return wedge;
}

// Least and greatest value of a plane over a tile: linear in the pixel and in the depth.
fn range_over(normal: vec3<f32>, more: f32, on: vec3<f32>, rays: array<vec3<f32>, 4>, box: vec2<f32>) -> vec2<f32> {
    var range = vec2<f32>(1e30, -1e30);
    for (var at = 0u; at < 4u; at++) {
        let slope = dot(normal, rays[at]) + more;
        range = vec2<f32>(
            min(range.x, min(slope * box.x, slope * box.y)),
            max(range.y, max(slope * box.x, slope * box.y)),
        );
    }
    return range - dot(normal, on);
}

fn lies(wedge: Wedge, level: u32, tile: vec2<u32>) -> u32 {
    let box = boxes[place_of(level, tile)];
    if box.y == 0.0 {
        return OUTSIDE;
    }
    let first = side(level) * tile;
    let low = centre(first);
    let high = centre(min(first + side(level), receivers.size) - 1u);
    let rays = array<vec3<f32>, 4>(
        ray_through(low),
        ray_through(vec2<f32>(high.x, low.y)),
        ray_through(vec2<f32>(low.x, high.y)),
        ray_through(high),
    );
    let on = places[wedge.triangle.x].xyz;
    let rounding = ROUNDING * (2.0 * box.y + length(on));
    var range = range_over(wedge.plane, receivers.margin, on, rays, box);
    if range.x > rounding {
        return OUTSIDE;
    }
    var is_inside = range.y < -rounding;
    for (var at = 0u; at < 3u; at++) {
        range = range_over(wedge.sides[at], 0.0, wedge.on_sides[at], rays, box);
        if range.x > rounding {
            return OUTSIDE;
        }
        is_inside = is_inside && range.y < -rounding;
    }
    return select(ACROSS, INSIDE, is_inside);
}

fn is_in(wedge: Wedge, place: vec3<f32>, depth: f32) -> bool {
    if !is_below(place, depth, wedge.triangle) {
        return false;
    }
    for (var at = 0u; at < 3u; at++) {
        if dot(wedge.sides[at], place - wedge.on_sides[at]) > 0.0 {
            return false;
        }
    }
    return true;
}

fn darken_pixels(wedge: Wedge, tile: vec2<u32>) {
    let first = 8u * tile;
    let past = min(first + 8u, receivers.size);
    var bits = vec2<u32>(0u);
    for (var y = first.y; y < past.y; y++) {
        for (var x = first.x; x < past.x; x++) {
            let depth = depth_m(y * receivers.size.x + x);
            let pixel = vec2<u32>(x, y);
            if depth > 0.0 && is_in(wedge, ray_through(centre(pixel)) * depth, depth) {
                let number = 8u * (y - first.y) + x - first.x;
                bits[number / 32u] |= 1u << (number % 32u);
            }
        }
    }
    let word = 2u * place_of(0u, tile);
    if bits.x != 0u {
        atomicOr(&dark[word], bits.x);
    }
    if bits.y != 0u {
        atomicOr(&dark[word + 1u], bits.y);
    }
}

fn darken_small(wedge: Wedge, tile: vec2<u32>) {
    let word = 2u * place_of(0u, tile);
    let known = vec2<u32>(atomicLoad(&dark[word]), atomicLoad(&dark[word + 1u]));
    if all(known == vec2<u32>(ALL)) {
        return;
    }
    switch lies(wedge, 0u, tile) {
        case INSIDE: {
            atomicStore(&dark[word], ALL);
            atomicStore(&dark[word + 1u], ALL);
        }
        case ACROSS: {
            darken_pixels(wedge, tile);
        }
        default: {}
    }
}

fn darken_middle(wedge: Wedge, tile: vec2<u32>) {
    let word = word_of(1u, tile);
    if atomicLoad(&dark[word]) != 0u {
        return;
    }
    let how = lies(wedge, 1u, tile);
    if how == INSIDE {
        atomicStore(&dark[word], 1u);
    }
    if how != ACROSS {
        return;
    }
    let first = 4u * tile;
    let past = min(first + 4u, tiles(0u));
    for (var y = first.y; y < past.y; y++) {
        for (var x = first.x; x < past.x; x++) {
            darken_small(wedge, vec2<u32>(x, y));
        }
    }
}

@compute @workgroup_size(64)
fn throw_shadows(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= receivers.triangles {
        return;
    }
    let wedge = wedge_of(triangles[id.x]);
    for (var at = 0u; at < count(2u); at++) {
        let tile = tile_at(2u, at);
        let word = word_of(2u, tile);
        if atomicLoad(&dark[word]) != 0u {
            continue;
        }
        let how = lies(wedge, 2u, tile);
        if how == INSIDE {
            atomicStore(&dark[word], 1u);
        }
        if how != ACROSS {
            continue;
        }
        let first = 4u * tile;
        let past = min(first + 4u, tiles(1u));
        for (var y = first.y; y < past.y; y++) {
            for (var x = first.x; x < past.x; x++) {
                darken_middle(wedge, vec2<u32>(x, y));
            }
        }
    }
}

@compute @workgroup_size(64)
fn answer(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= receivers.size.x * receivers.size.y {
        return;
    }
    let pixel = vec2<u32>(id.x % receivers.size.x, id.x / receivers.size.x);
    let small = pixel / 8u;
    let number = 8u * (pixel.y % 8u) + pixel.x % 8u;
    let word = atomicLoad(&dark[2u * place_of(0u, small) + number / 32u]);
    let middle = atomicLoad(&dark[word_of(1u, pixel / 32u)]);
    let top = atomicLoad(&dark[word_of(2u, pixel / 128u)]);
    let is_dark = ((word >> (number % 32u)) & 1u) != 0u || middle != 0u || top != 0u;
    answers[id.x] = select(0u, 1u, is_dark && depths[id.x] > 0.0);
}
