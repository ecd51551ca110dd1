// A layer of the globe by itself (Gebbie and Bailey, figures 6 and 7): one fragment looks up what its place of the picture
// shows. A picture by longitude and latitude fills it. A cube map is unfolded: a row of four faces, the northern face
// above the second, the southern one below.

// 1: the picture by longitude and latitude.
override BY_ANGLES: u32 = 0u;
// 1: the fourth channel, as grey.
override ALPHA: u32 = 0u;
// Pixels of the picture.
override WIDTH: f32 = 4.0;
override HEIGHT: f32 = 3.0;

@group(0) @binding(0) var cube: texture_cube<f32>;
@group(0) @binding(1) var picture: texture_2d<f32>;
@group(0) @binding(2) var linear: sampler;

// Three vertices cover the picture.
@vertex
fn vertex_main(@builtin(vertex_index) number: u32) -> @builtin(position) vec4<f32> {
    let x = select(-1.0, 3.0, number == 1u);
    let y = select(-1.0, 3.0, number == 2u);
    return vec4<f32>(x, y, 1.0, 1.0);
}

// The direction that the unfolded cube shows: the second face of the row looks along x, north is z. No direction beside
// the faces.
fn unfolded(at: vec2<f32>) -> vec3<f32> {
    let cell = floor(at);
    let s = 2.0 * (at.x - cell.x) - 1.0;
    let t = 2.0 * (at.y - cell.y) - 1.0;
    if cell.y != 1.0 {
        if cell.x != 1.0 {
            return vec3<f32>(0.0);
        }
        return select(vec3<f32>(-t, s, -1.0), vec3<f32>(t, s, 1.0), cell.y < 1.0);
    }
    if cell.x == 0.0 {
        return vec3<f32>(s, -1.0, -t);
    }
    if cell.x == 1.0 {
        return vec3<f32>(1.0, s, -t);
    }
    if cell.x == 2.0 {
        return vec3<f32>(-s, 1.0, -t);
    }
    return vec3<f32>(-1.0, -s, -t);
}

@fragment
fn fragment_main(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let place = at.xy / vec2<f32>(WIDTH, HEIGHT);
    var found = vec4<f32>(0.0);
    if BY_ANGLES == 1u {
        found = textureSampleLevel(picture, linear, place, 0.0);
    } else {
        let direction = unfolded(place * vec2<f32>(4.0, 3.0));
        if dot(direction, direction) == 0.0 {
            return vec4<f32>(0.0);
        }
        found = textureSampleLevel(cube, linear, direction, 0.0);
    }
    return vec4<f32>(select(found.rgb, found.aaa, ALPHA == 1u), 1.0);
}
