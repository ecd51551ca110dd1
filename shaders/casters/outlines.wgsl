// Outlines of models, study `shadows`: vertex invocations bring a model's corner, or a corner of a contour edge's stroke, to
// the picture; fragment invocations write the number of what they show. Lengths in metres from the eye, or in pixels.

struct OutlineConstants {
    // Axes of the picture over the tangents of half its field of view.
    right: vec4<f32>,
    up: vec4<f32>,
    // Axis of the view; w: the near plane, metres.
    forward: vec4<f32>,
    // Columns, rows, half the width of a stroke.
    size_px: vec4<f32>,
}

@group(0) @binding(0) var<uniform> constants: OutlineConstants;

// The far plane lies at infinity, where reversed depth is 0.
fn clip(from_eye: vec3<f32>) -> vec4<f32> {
    return vec4<f32>(
        dot(constants.right.xyz, from_eye),
        dot(constants.up.xyz, from_eye),
        constants.forward.w,
        dot(constants.forward.xyz, from_eye),
    );
}

struct Face {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
}

@vertex
fn face_vertex(@location(0) from_eye: vec3<f32>, @builtin(instance_index) model: u32) -> Face {
    return Face(clip(from_eye), 2u * model + 1u);
}

@fragment
fn face_fragment(face: Face) -> @location(0) u32 {
    return face.number;
}

struct Stroke {
    @builtin(position) position: vec4<f32>,
    // Both ends, pixels from the upper left corner.
    @location(0) @interpolate(flat) ends: vec4<f32>,
    @location(1) @interpolate(flat) depths: vec2<f32>,
    @location(2) @interpolate(flat) number: u32,
}

fn pixel(clip: vec4<f32>) -> vec2<f32> {
    return (clip.xy / clip.w * vec2<f32>(0.5, -0.5) + 0.5) * constants.size_px.xy;
}

@vertex
fn stroke_vertex(
    @location(0) first: vec3<f32>,
    @location(1) second: vec3<f32>,
    @location(2) model: u32,
    @builtin(vertex_index) corner: u32,
) -> Stroke {
    let clips = array<vec4<f32>, 2>(clip(first), clip(second));
    // Behind the eye an edge has no place, and its model no face.
    if min(clips[0].w, clips[1].w) < constants.forward.w {
        return Stroke(vec4<f32>(0.0, 0.0, 0.0, 1.0), vec4<f32>(0.0), vec2<f32>(0.0), 0u);
    }
    let ends = array<vec2<f32>, 2>(pixel(clips[0]), pixel(clips[1]));
    let way = ends[1] - ends[0];
    let along = select(vec2<f32>(1.0, 0.0), way / length(way), length(way) > 0.0);
    // Two triangles around both round caps, a pixel wider: fragments find the border.
    let place = array<u32, 6>(0u, 1u, 2u, 2u, 1u, 3u)[corner];
    let end = place / 2u;
    let reach = constants.size_px.z + 1.0;
    let side = vec2<f32>(f32(end), f32(place % 2u)) * 2.0 - 1.0;
    let across = vec2<f32>(-along.y, along.x);
    let at = ends[end] + (along * side.x + across * side.y) * reach;
    let device = (at / constants.size_px.xy - 0.5) * vec2<f32>(2.0, -2.0);
    let depths = vec2<f32>(clips[0].z / clips[0].w, clips[1].z / clips[1].w);
    return Stroke(
        vec4<f32>(device, depths[end], 1.0),
        vec4<f32>(ends[0], ends[1]),
        depths,
        2u * model + 2u,
    );
}

struct Written {
    @location(0) number: u32,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn stroke_fragment(stroke: Stroke) -> Written {
    let way = stroke.ends.zw - stroke.ends.xy;
    let offset = stroke.position.xy - stroke.ends.xy;
    let squared = dot(way, way);
    let share = select(0.0, clamp(dot(offset, way) / squared, 0.0, 1.0), squared > 0.0);
    if length(offset - way * share) > constants.size_px.z {
        discard;
    }
    return Written(stroke.number, mix(stroke.depths.x, stroke.depths.y, share));
}
