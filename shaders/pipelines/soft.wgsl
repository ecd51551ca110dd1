// Study `pipelines`: one vertex invocation places one of six vertices of a cell of the grid; one fragment filters the
// depth maps of all lights at its place and writes which mean share of them reaches it.
//
// Depths grow towards the light here; published, away from it. So a place is in shadow where it has less than
// their mean.
#import shared/lit.wgsl

struct Soft {
    // 0: one depth. 1: the share of 25 depths. 2: the published variance of 25 depths. 3: that of depths less the place's.
    filtered: u32,
};

@group(0) @binding(4) var<uniform> soft: Soft;

// Share of 25 depths that do not hide a place.
fn counted(middle: vec2<i32>, number: u32, depth: f32) -> f32 {
    var lit = 0.0;
    for (var y = -2; y <= 2; y += 1) {
        for (var x = -2; x <= 2; x += 1) {
            let nearest = depth_at(middle + vec2<i32>(x, y), number);
            lit += select(0.0, 1.0, nearest <= depth + lights.bias);
        }
    }
    return lit / 25.0;
}

// In the published steps, of depths less an offset.
fn by_variance(middle: vec2<i32>, number: u32, depth: f32, offset: f32) -> f32 {
    var first = 0.0;
    var second = 0.0;
    for (var y = -2; y <= 2; y += 1) {
        for (var x = -2; x <= 2; x += 1) {
            let nearest = depth_at(middle + vec2<i32>(x, y), number) - offset;
            first += nearest / 25.0;
            second += nearest * nearest / 25.0;
        }
    }
    let gap = first - (depth - offset);
    if gap > 0.0 {
        let variance = second - first * first;
        return variance / (variance + gap * gap);
    }
    return 1.0;
}

fn share_of(number: u32, place: vec3<f32>) -> f32 {
    let seen = seen_by(number, place);
    let middle = texel_of(seen.xy);
    switch soft.filtered {
        case 0u: {
            return select(0.0, 1.0, depth_at(middle, number) <= seen.z + lights.bias);
        }
        case 1u: {
            return counted(middle, number, seen.z);
        }
        case 2u: {
            return by_variance(middle, number, seen.z, 0.0);
        }
        default: {
            return by_variance(middle, number, seen.z, seen.z);
        }
    }
}

@fragment
fn fragment_main(@location(0) place: vec3<f32>) -> @location(0) vec4<f32> {
    var sum = 0.0;
    for (var number = 0u; number < lights.count; number += 1u) {
        // What is no number, or outside of what a share may be, is held.
        sum += clamp(share_of(number, place), 0.0, 1.0);
    }
    return colour_of(u32(round(65535.0 * sum / f32(lights.count))) + 1u);
}
