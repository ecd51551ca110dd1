// SPDX-License-Identifier: MIT OR Apache-2.0
//! Textured covers on a bare globe: coordinates and levels of detail on the device against `f64` from
//! the depth that the device itself left. The routes are written here, plainly; what is tested is
//! everything between depth and picture that is no route.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_frame::{FrameInput, PreparedScene, StencilTest, TexturedRegion};
use terrafill_gpu::{
    BoundCover, CoverPurpose, Gpu, GpuOptions, ImageLevel, Probe, Probed, Stage, TexturedCover,
    TexturedFill, open_for_test,
};
use terrafill_scene::{CameraPose, ImageSize, Overlap, PlanOptions, SurfaceMesh, View};
use terrafill_shaders::{RouteText, TexturedParts, TexturedPlacement};

const SIZE: ImageSize = ImageSize {
    width: 160,
    height: 120,
};
const BODY: Ellipsoid = Ellipsoid::WGS84;
/// Texels of a side of the picture.
const SIDE: u32 = 64;

/// View space, then an affine map into the region's meridian axes.
const EYE_REGION: &str =
    "fn fragment_offset(pixel: vec2f, depth: f32, c: array<vec4f, 4>) -> vec3f {
    let at = vec4f(vec3f((pixel - c[0].xy) * c[0].zw, -1.0) * (view.near_m / depth), 1.0);
    return vec3f(dot(c[1], at), dot(c[2], at), dot(c[3], at));
}";

/// Exact on the ellipsoid, where tan φ = z / ((1 − e²) ρ); c: anchor, its latitude, 1 − e².
const NATIVE: &str = "fn route_angles(d: vec3f, c: array<vec4f, 1>) -> vec2f {
    let p = vec3f(c[0].x + d.x, d.y, c[0].y + d.z);
    return vec2f(atan2(p.y, p.x), atan2(p.z, c[0].w * length(p.xy)) - c[0].z);
}";

/// What a tester may get wrong on purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mutant {
    None,
    SwappedAxes,
    WrongAnchor,
    GeocentricLatitude,
}

#[derive(Debug, Clone, Copy)]
struct Region {
    anchor_rad: [f64; 2],
    extent_rad: [f64; 2],
}

impl Region {
    fn degrees(longitude: f64, latitude: f64, width: f64, height: f64) -> Self {
        Self {
            anchor_rad: [longitude.to_radians(), latitude.to_radians()],
            extent_rad: [width.to_radians(), height.to_radians()],
        }
    }

    fn uv(&self, longitude_rad: f64, latitude_rad: f64) -> [f64; 2] {
        let dlon = (longitude_rad - self.anchor_rad[0] + PI).rem_euclid(TAU) - PI;
        let dlat = latitude_rad - self.anchor_rad[1];
        [
            0.5 + dlon / self.extent_rad[0],
            0.5 - dlat / self.extent_rad[1],
        ]
    }
}

fn globe(longitude_deg: f64, latitude_deg: f64, height_m: f64, pitch_deg: f64) -> FrameInput {
    let scene = PreparedScene {
        name: "bare".to_owned(),
        body: BODY,
        edge_rule: Default::default(),
        overlap: Overlap::Disjoint,
        regions: Arc::new([]),
        meshes: Arc::new([]),
        levels: Arc::default(),
        bounds: Arc::new([]),
        surface: Arc::new(SurfaceMesh::ellipsoid(&BODY, 720)),
    };
    let view = View {
        name: "globe".to_owned(),
        pose: CameraPose {
            eye: Geodetic::from_degrees(longitude_deg, latitude_deg, height_m),
            heading_rad: 0.3,
            pitch_rad: pitch_deg.to_radians(),
            fov_y_rad: 60_f64.to_radians(),
            near_m: 10.0,
        },
        note: None,
    };
    FrameInput::new(&scene, &view, SIZE, PlanOptions::default())
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "rounding to what the GPU reads is the purpose"
)]
fn cover(input: &FrameInput, region: &Region, mutant: Mutant) -> TexturedCover {
    let [mut longitude, latitude] = region.anchor_rad;
    if mutant == Mutant::WrongAnchor {
        longitude += 0.02 * region.extent_rad[0];
    }
    let turn = glam::DMat3::from_rotation_z(-longitude);
    let anchor = turn
        * BODY.geodetic_to_ecef(Geodetic {
            longitude_rad: longitude,
            latitude_rad: latitude,
            height_m: 0.0,
        });
    let eye = turn * input.camera.eye_ecef - anchor;
    let from_view = turn * input.camera.view_from_ecef.transpose();
    let tan = input.camera.tan_half_fov();
    let [width, height] = [SIZE.width, SIZE.height].map(f64::from);
    let px = 2.0 * tan / height;
    let (right, down) = (from_view.x_axis * px, from_view.y_axis * -px);
    let row = |i: usize| {
        let turned = from_view.row(i).as_vec3();
        [turned.x, turned.y, turned.z, eye[i] as f32]
    };
    let e2 = BODY.eccentricity_squared();
    let keep = if mutant == Mutant::GeocentricLatitude {
        1.0
    } else {
        1.0 - e2
    };
    let (u, v) = (
        [(1.0 / region.extent_rad[0]) as f32, 0.0, 0.5],
        [0.0, (-1.0 / region.extent_rad[1]) as f32, 0.5],
    );
    let (u, v) = match mutant {
        Mutant::SwappedAxes => ([u[1], u[0], u[2]], [v[1], v[0], v[2]]),
        _ => (u, v),
    };
    TexturedCover {
        parts: 0,
        image: 0,
        address: [wgpu::AddressMode::ClampToEdge; 2],
        ends_at_edges: false,
        fades: false,
        is_translucent: false,
        region: TexturedRegion {
            anchor_m: anchor.as_vec3().to_array(),
            id: 7.0,
            eye_m: eye.as_vec3().to_array(),
            alpha: 1.0,
            right: right.as_vec3().to_array(),
            equatorial_radius_m: BODY.equatorial_radius_m() as f32,
            down: down.as_vec3().to_array(),
            eccentricity_squared: e2 as f32,
            u,
            fade_end_m: 0.0,
            v,
            fade_per_m: 0.0,
            texel_per_m: 0.0,
            padding: [0.0; 3],
        },
        position: vec![
            [
                (width / 2.0) as f32,
                (height / 2.0) as f32,
                px as f32,
                -px as f32,
            ],
            row(0),
            row(1),
            row(2),
        ],
        route: vec![[
            anchor.x as f32,
            anchor.z as f32,
            latitude as f32,
            keep as f32,
        ]],
    }
}

fn parts() -> TexturedParts {
    TexturedParts {
        position: RouteText {
            wgsl: EYE_REGION.to_owned(),
            constants: 4,
        },
        route: RouteText {
            wgsl: NATIVE.to_owned(),
            constants: 1,
        },
        route_room: 1,
        placement: TexturedPlacement::Affine,
    }
}

/// Passes everywhere: the surface pass left 0.
const EVERYWHERE: StencilTest = StencilTest {
    is_equal: true,
    reference: 0,
    read_mask: 0xff,
    zeroes: false,
};

struct Drawn {
    rgba: Vec<u8>,
    depth: Vec<f32>,
    probed: Vec<Option<Probed>>,
}

/// A picture whose texels say where they are: red by column, blue by row.
fn levels() -> Vec<(u32, Vec<u8>)> {
    let mut levels = Vec::new();
    let mut side = SIDE;
    while side > 0 {
        let texel = |at: u32| u8::try_from(255 * at / (side - 1).max(1)).unwrap_or(255);
        let rgba = (0..side * side)
            .flat_map(|i| [texel(i % side), 40, texel(i / side), 255])
            .collect();
        levels.push((side, rgba));
        side /= 2;
    }
    levels
}

fn draw(gpu: &Arc<Gpu>, input: &FrameInput, covers: Vec<TexturedCover>) -> Drawn {
    let mut stage = Stage::new(gpu, SIZE).expect("small targets");
    stage.prepare(input).expect("fits");
    stage.draw_surface().expect("draws");
    let frame_layout = gpu
        .device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
    let frame_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &frame_layout,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: stage.view_constants().as_entire_binding(),
        }],
    });
    let mut fill = TexturedFill::new(gpu, &frame_layout);
    let levels = levels();
    let image: Vec<ImageLevel<'_>> = levels
        .iter()
        .map(|(side, rgba)| ImageLevel {
            width: *side,
            height: *side,
            rgba,
        })
        .collect();
    fill.upload_image(gpu, &image, 1).expect("fits");
    let regions: Vec<usize> = (0..covers.len()).collect();
    fill.set_view(&stage, &[parts()], covers)
        .expect("valid shader");
    let probe = Probe::new(gpu, SIZE);
    let (colour, depth_stencil) = (stage.colour_view(), stage.depth_stencil_view());
    let probe_views = probe.views();
    for purpose in [CoverPurpose::Colour, CoverPurpose::Probe] {
        fill.ensure(gpu, EVERYWHERE, purpose, &regions);
        let attached = |view, load| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load,
                    store: wgpu::StoreOp::Store,
                },
            })
        };
        let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        let targets = match purpose {
            CoverPurpose::Colour => vec![attached(&colour, wgpu::LoadOp::Load)],
            CoverPurpose::Probe => probe_views.iter().map(|v| attached(v, clear)).collect(),
        };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: None,
            color_attachments: &targets,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth_stencil,
                depth_ops: None,
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_bind_group(0, &frame_group, &[]);
        pass.set_stencil_reference(0);
        let mut bound = BoundCover::default();
        for &planned in &regions {
            fill.draw(&mut pass, EVERYWHERE, purpose, planned, &mut bound);
        }
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait().expect("draws");
    }
    let picture = stage.read().expect("reads");
    Drawn {
        rgba: picture.rgba,
        depth: picture.depth,
        probed: probe.read(gpu).expect("reads"),
    }
}

/// Where a pixel really is: texture coordinates, and the longer footprint in texels.
fn exact(
    input: &FrameInput,
    region: &Region,
    column: u32,
    row: u32,
    depth: f32,
) -> ([f64; 2], f64) {
    let camera = &input.camera;
    let direction = camera.pixel_direction_ecef(SIZE, column, row);
    let distance = camera.near_m / f64::from(depth);
    let point = camera.eye_ecef + direction * distance;
    let uv_of = |at| {
        let found = BODY.ecef_to_geodetic(at);
        region.uv(found.longitude_rad, found.latitude_rad)
    };
    let here = BODY.ecef_to_geodetic(point);
    let normal = BODY.geodetic_surface_normal(here.longitude_rad, here.latitude_rad);
    let uv = uv_of(point);
    // A thousandth of a pixel to the side, on the tangent plane.
    let footprint = |column: u32, row: u32| {
        let to = camera.pixel_direction_ecef(SIZE, column, row);
        let ray = direction + (to - direction) * 1e-3;
        let met = camera.eye_ecef + ray * ((point - camera.eye_ecef).dot(normal) / ray.dot(normal));
        let step = uv_of(met);
        let size = f64::from(SIDE) * 1e3;
        ((step[0] - uv[0]) * size).hypot((step[1] - uv[1]) * size)
    };
    (
        uv,
        footprint(column + 1, row).max(footprint(column, row + 1)),
    )
}

#[derive(Debug, Default)]
struct Errors {
    pixels: usize,
    rms: f64,
    max: f64,
    level_max: f64,
    non_finite: usize,
}

impl Errors {
    fn of(input: &FrameInput, region: &Region, drawn: &Drawn) -> Self {
        let mut errors = Self::default();
        for row in 0..SIZE.height {
            for column in 0..SIZE.width {
                let index = (row * SIZE.width + column) as usize;
                let Some(probed) = drawn.probed[index] else {
                    continue;
                };
                let found = [probed.uv[0], probed.uv[1], probed.level, probed.distance_m];
                if found.iter().any(|value| !value.is_finite()) {
                    errors.non_finite += 1;
                    continue;
                }
                let (uv, footprint) = exact(input, region, column, row, drawn.depth[index]);
                let du = f64::from(probed.uv[0]) - uv[0];
                let du = if region.extent_rad[0] >= TAU {
                    du - du.round()
                } else {
                    du
                };
                let dv = f64::from(probed.uv[1]) - uv[1];
                let texels = du.abs().max(dv.abs()) * f64::from(SIDE);
                errors.pixels += 1;
                errors.rms += texels * texels;
                errors.max = errors.max.max(texels);
                let level = footprint.log2().max(0.0);
                errors.level_max = errors
                    .level_max
                    .max((f64::from(probed.level) - level).abs());
            }
        }
        errors.rms = (errors.rms / errors.pixels.max(1) as f64).sqrt();
        errors
    }
}

/// Places to look at: a region under the eye, from straight above and aslant.
fn sights() -> Vec<(&'static str, FrameInput, Region)> {
    let at =
        |name, longitude: f64, latitude: f64, width: f64, height: f64, eye_m: f64, pitch: f64| {
            let input = globe(longitude, latitude.min(89.95), eye_m, pitch);
            (
                name,
                input,
                Region::degrees(longitude, latitude, width, height),
            )
        };
    let mut sights = vec![
        at("equator", 10.0, 0.0, 4.0, 4.0, 3e5, -90.0),
        at("45°", 10.0, 45.0, 4.0, 4.0, 3e5, -90.0),
        at("45° aslant", 10.0, 45.0, 4.0, 4.0, 3e5, -60.0),
        at("70°", 10.0, 70.0, 8.0, 4.0, 3e5, -90.0),
        at("85°", 10.0, 85.0, 40.0, 4.0, 3e5, -90.0),
        at("antimeridian", 180.0, -17.0, 6.0, 4.0, 3e5, -90.0),
        at("other side of it", -179.9, -17.0, 6.0, 4.0, 3e5, -90.0),
    ];
    // Round a pole the anchor lies on the middle parallel of the extent.
    let (_, input, _) = at("pole", 0.0, 90.0, 360.0, 20.0, 3e5, -90.0);
    sights.push(("pole", input, Region::degrees(0.0, 80.0, 360.0, 20.0)));
    sights
}

#[test]
fn coordinates_and_levels_are_those_of_the_depth_wherever_the_region_lies() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    for (name, input, region) in sights() {
        let drawn = draw(&gpu, &input, vec![cover(&input, &region, Mutant::None)]);
        let errors = Errors::of(&input, &region, &drawn);
        let filled = errors.pixels + errors.non_finite;
        assert_eq!(filled, SIZE.pixel_count(), "{name}");
        assert_eq!(errors.non_finite, 0, "{name}: {errors:?}");
        assert!(
            errors.rms <= 0.25 && errors.max <= 0.5,
            "{name}: {errors:?}"
        );
        assert!(errors.level_max <= 0.01, "{name}: {errors:?}");
        let opaque = drawn.rgba.chunks_exact(4).filter(|pixel| pixel[3] == 255);
        assert_eq!(opaque.count(), SIZE.pixel_count(), "{name}");
    }
}

#[test]
fn a_wrong_route_or_anchor_is_noticed() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let (_, input, region) = sights().swap_remove(1);
    for mutant in [
        Mutant::SwappedAxes,
        Mutant::WrongAnchor,
        Mutant::GeocentricLatitude,
    ] {
        let drawn = draw(&gpu, &input, vec![cover(&input, &region, mutant)]);
        let errors = Errors::of(&input, &region, &drawn);
        assert!(errors.max > 0.5, "{mutant:?}: {errors:?}");
    }
}

#[test]
fn cleared_depth_never_reaches_the_map() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    // The stencil test passes over the sky as well; only the shader's own test keeps it out.
    let input = globe(10.0, 45.0, 3e6, -50.0);
    let region = Region::degrees(10.0, 45.0, 120.0, 90.0);
    let drawn = draw(&gpu, &input, vec![cover(&input, &region, Mutant::None)]);
    let sky = drawn.depth.iter().filter(|&&depth| depth == 0.0).count();
    assert!(sky > 1000, "{sky}");
    for ((depth, probed), pixel) in drawn
        .depth
        .iter()
        .zip(&drawn.probed)
        .zip(drawn.rgba.chunks_exact(4))
    {
        assert_eq!(*depth > 0.0, probed.is_some());
        assert_eq!(*depth > 0.0, pixel[3] == 255);
    }
    let errors = Errors::of(&input, &region, &drawn);
    assert_eq!(errors.non_finite, 0);
    assert!(errors.rms <= 0.25 && errors.max <= 0.5, "{errors:?}");
}

#[test]
fn a_second_view_of_as_many_regions_makes_nothing_and_writes_what_changed() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let input = globe(10.0, 45.0, 3e5, -90.0);
    let region = Region::degrees(10.0, 45.0, 4.0, 4.0);
    let stage = Stage::new(&gpu, SIZE).expect("small targets");
    let layout = gpu
        .device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &[],
        });
    let mut fill = TexturedFill::new(&gpu, &layout);
    let texel = [255; 4];
    let level = ImageLevel {
        width: 1,
        height: 1,
        rgba: &texel,
    };
    fill.upload_image(&gpu, &[level], 2).expect("fits");
    assert_eq!(fill.image_bytes(), 8);
    let one = cover(&input, &region, Mutant::None);
    let other = cover(&input, &region, Mutant::WrongAnchor);
    let set = |fill: &mut TexturedFill, cover: &TexturedCover| {
        let before = gpu.work_done();
        fill.set_view(&stage, &[parts()], vec![cover.clone()])
            .expect("valid shader");
        gpu.work_done() - before
    };
    assert_eq!(set(&mut fill, &one).buffer_creations, 1);
    let again = set(&mut fill, &one);
    assert_eq!((again.buffer_creations, again.uploads), (0, 0));
    let moved = set(&mut fill, &other);
    assert_eq!((moved.buffer_creations, moved.uploads), (0, 1));
    assert_eq!(moved.upload_bytes, fill.constant_bytes());
    assert_eq!(
        fill.constant_bytes(),
        16 * (TexturedRegion::VECTORS as u64 + 4 + 1)
    );
}

#[test]
fn a_route_that_does_not_compile_is_named() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let stage = Stage::new(&gpu, SIZE).expect("small targets");
    let layout = gpu
        .device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &[],
        });
    let mut fill = TexturedFill::new(&gpu, &layout);
    let mut broken = parts();
    broken.route.wgsl = broken.route.wgsl.replace("atan2", "arctangent2");
    let error = fill
        .set_view(&stage, &[broken], Vec::new())
        .expect_err("no such function");
    assert!(error.to_string().contains("arctangent2"), "{error}");
}
