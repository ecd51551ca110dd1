// Edge scan: one fragment reads its pixel's depth, turns it into longitude and latitude, and writes the
// colour of the last region that it is in. It tests every edge of each region whose box it lies in. Edges
// south of it, on its own meridian, are counted: an odd number of them turns inside into outside.
// Reads depth and, of the regions of the view, boxes, colours, lines and positions. Degrees; lengths in
// metres about the body's centre, where f32 is off by half a metre. The arctangent is the driver's; Mesa's is
// off by 3e-6 rad. Shaders that users write have both errors, and this technique is here to show them.
#import shared/view.wgsl

// Two halves a position instead of two floats.
override HALVES: bool = false;

struct ScannedRegion {
    // West, south, east, north; west is greater than east of one that lies across the antimeridian.
    box_deg: vec4<f32>,
    colour: vec4<f32>,
    // Of its lines in `ends`.
    first_line: u32,
    end_line: u32,
    // 1: what no edge is south of is inside.
    is_inside_in_the_south: u32,
    padding: u32,
};

// Equatorial and polar radius.
@group(0) @binding(1) var<uniform> radii_m: vec2<f32>;
@group(0) @binding(2) var<storage, read> regions: array<ScannedRegion>;
// Of each line the first position that is none of it any more.
@group(0) @binding(3) var<storage, read> ends: array<u32>;
@group(0) @binding(4) var<storage, read> positions: array<u32>;
@group(0) @binding(5) var depth: texture_depth_2d;

@vertex
fn vertex_main(@builtin(vertex_index) vertex_index: u32) -> @builtin(position) vec4<f32> {
    let x = f32(i32(vertex_index & 1u) * 4 - 1);
    let y = f32(i32(vertex_index >> 1u) * 4 - 1);
    return vec4<f32>(x, y, 1.0, 1.0);
}

fn position_deg(index: u32) -> vec2<f32> {
    if HALVES {
        return unpack2x16float(positions[index]);
    }
    return bitcast<vec2<f32>>(vec2<u32>(positions[2u * index], positions[2u * index + 1u]));
}

fn place_m(pixel: vec2<f32>, d: f32) -> vec3<f32> {
    let size = vec2<f32>(textureDimensions(depth));
    let clip = vec2<f32>(2.0, -2.0) * pixel / size + vec2<f32>(-1.0, 1.0);
    let direction = vec3<f32>(clip / vec2<f32>(view.clip_scale_x, view.clip_scale_y), -1.0);
    return view.eye_ecef + (direction * view.view_from_ecef) * (view.near_m / d);
}

// Longitude from −180 on, below 180, and geodetic latitude by one step of Bowring's formula (1976).
fn geodetic_deg(p: vec3<f32>) -> vec2<f32> {
    let a = radii_m.x;
    let b = radii_m.y;
    let flattening = (a - b) / a;
    let eccentricity_squared = flattening * (2.0 - flattening);
    let axis = length(p.xy);
    let reduced = normalize(vec2<f32>(axis * b, p.z * a));
    let latitude = atan2(
        p.z + eccentricity_squared / (1.0 - eccentricity_squared) * b * reduced.y * reduced.y * reduced.y,
        axis - eccentricity_squared * a * reduced.x * reduced.x * reduced.x,
    );
    let longitude = degrees(atan2(p.y, p.x));
    return vec2<f32>(select(longitude, longitude - 360.0, longitude >= 180.0), degrees(latitude));
}

fn is_in_box(region: u32, place: vec2<f32>) -> bool {
    let around = regions[region].box_deg;
    let is_east = place.x >= around.x;
    let is_west = place.x <= around.z;
    let is_between = select(is_east && is_west, is_east || is_west, around.x > around.z);
    return is_between && place.y >= around.y && place.y <= around.w;
}

fn is_inside(region: u32, place: vec2<f32>) -> bool {
    var inside = regions[region].is_inside_in_the_south == 1u;
    for (var line = regions[region].first_line; line < regions[region].end_line; line++) {
        var index = 0u;
        if line > 0u {
            index = ends[line - 1u];
        }
        var start = position_deg(index);
        for (index++; index < ends[line]; index++) {
            let end = position_deg(index);
            if (start.x <= place.x) != (end.x <= place.x) {
                let share = (place.x - start.x) / (end.x - start.x);
                inside = inside != (start.y + share * (end.y - start.y) < place.y);
            }
            start = end;
        }
    }
    return inside;
}

@fragment
fn fragment_main(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    let d = textureLoad(depth, vec2<i32>(pixel.xy), 0);
    if d <= 0.0 {
        discard;
        return vec4<f32>();
    }
    let place = geodetic_deg(place_m(pixel.xy, d));
    for (var left = arrayLength(&regions); left > 0u; left--) {
        if is_in_box(left - 1u, place) && is_inside(left - 1u, place) {
            return regions[left - 1u].colour;
        }
    }
    discard;
    return vec4<f32>();
}
