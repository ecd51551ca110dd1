// What a volume's fragments write, whatever layout its vertices came from.

// For passes that also hold a colour target: nothing.
@fragment
fn no_colour() {}

// For counting fragments, with a target whose write mask is empty: drivers need not run, nor count, a
// shader that does nothing (llvmpipe does neither).
@fragment
fn counted() -> @location(0) vec4<f32> {
    return vec4<f32>(1.0);
}

// Colour pass by volumes: the region's colour.
struct Coloured {
    @builtin(position) @invariant clip: vec4<f32>,
    @location(0) @interpolate(flat) colour: vec4<f32>,
};

@fragment
fn region_colour(in: Coloured) -> @location(0) vec4<f32> {
    return in.colour;
}

// First pass of `first-pass=program`: two arctangents, as the textured fill of 2007 had in its
// program. What it gives is used, so that no compiler may leave them out.
@fragment
fn costly(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    let longitude = atan2(pixel.y - 511.5, pixel.x - 511.5);
    let latitude = atan2(pixel.z, length(pixel.xy));
    return vec4<f32>(longitude, latitude, 0.0, 1.0);
}

// Accumulation pass: the volume's number, added or taken away by blending. Behind the surface back
// faces add and front faces take away; in front of it, the other way round.
struct Numbered {
    @builtin(position) @invariant clip: vec4<f32>,
    @location(0) @interpolate(flat) number: f32,
};

fn numbered(clip: vec4<f32>, region_index: u32) -> Numbered {
    return Numbered(clip, f32(region_index + 1u));
}

@fragment
fn number_behind(in: Numbered, @builtin(front_facing) is_front: bool) -> @location(0) f32 {
    return select(in.number, -in.number, is_front);
}

@fragment
fn number_before(in: Numbered, @builtin(front_facing) is_front: bool) -> @location(0) f32 {
    return select(-in.number, in.number, is_front);
}
