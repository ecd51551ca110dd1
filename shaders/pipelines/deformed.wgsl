// Study `pipelines`: one vertex invocation deforms a vertex of a mesh and places it in the view of its instance, or
// places one that was deformed and kept before. Views lie side by side. Fragments write the number of their triangle.
enable primitive_index;
#import shared/dents.wgsl

@group(0) @binding(3) var<uniform> other: MeshConstants;
// Deformed vertices, metres.
@group(0) @binding(4) var<storage, read> kept: array<vec4<f32>>;

// Even instances are seen on the left, odd ones from the other side on the right.
fn placed(place: vec3<f32>, instance: u32) -> vec4<f32> {
    if instance % 2u == 0u {
        let clip = clip_in(mesh, place);
        return vec4<f32>(fma(clip.x, 0.5, -0.5 * clip.w), clip.yzw);
    }
    let clip = clip_in(other, place);
    return vec4<f32>(fma(clip.x, 0.5, 0.5 * clip.w), clip.yzw);
}

struct Varying {
    @invariant @builtin(position) clip: vec4<f32>,
};

@vertex
fn deforming(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) instance: u32,
) -> Varying {
    return Varying(placed(deformed(rest[vertex].xyz), instance));
}

@vertex
fn deformed_before(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) instance: u32,
) -> Varying {
    return Varying(placed(kept[vertex].xyz, instance));
}

@fragment
fn fragment_main(@builtin(primitive_index) triangle: u32) -> @location(0) vec4<f32> {
    return colour_of(triangle + 1u);
}
