// Numbers of triangles as colours, and cells of two triangles each, cut from their corner (1, 0) to (0, 1).
fn colour_of(number: u32) -> vec4<f32> {
    return unpack4x8unorm(number | 0xff000000u);
}

// Corner of a cell as the six vertices of its two triangles.
fn corner(vertex: u32) -> vec2<u32> {
    let x = (0x2au >> vertex) & 1u;
    let y = (0x1cu >> vertex) & 1u;
    return vec2<u32>(x, y);
}
