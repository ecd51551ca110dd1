// SPDX-License-Identifier: MIT OR Apache-2.0
//! Textured covers on a bare globe: places in the picture and levels of detail on the device against
//! `f64` from the depth that the device itself left. The judge is this file's own arithmetic, by the
//! definitions of the placements, and shares nothing with plan and shaders but the body.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use terrafill_contract::{AddressMode, DeviceError, Feature, FillInput, PreparedScene};
use terrafill_core::{Ellipsoid, Geodetic, parse_regions};
use terrafill_gpu::{
    BoundCover, Gpu, GpuOptions, Probe, RenderTargets, TexturedFill, attached, open_for_test,
    read_only_depth,
};
use terrafill_plan::{
    NearRectangle, PixelRect, PlanOptions, PlannedRegion, RegionSet, SceneBounds,
};
use terrafill_scene::{
    CameraPose, ImageSize, MipChain, Outside, Overlap, SceneTexture, TextureAnchor,
    TexturePlacement, TextureShare, View,
};
use terrafill_stencil::{CoverPurpose, Probed, StencilTest, TexturedPlan, TexturedRegion};
use terrafill_surface::EllipsoidKind;
use terrafill_texture::PositionRoute;
use terrafill_variant::{RouteChoice, Switches};

const SIZE: ImageSize = ImageSize::new(160, 120);
const BODY: Ellipsoid = Ellipsoid::WGS84;
/// Columns and rows of the picture.
const TEXELS: [u32; 2] = [64, 32];

/// Bounds of a region, degrees.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    west: f64,
    south: f64,
    east: f64,
    north: f64,
}

fn bounds(west: f64, south: f64, east: f64, north: f64) -> Bounds {
    Bounds {
        west,
        south,
        east,
        north,
    }
}

/// A picture whose texels say where they are: red by column, blue by row.
fn picture() -> MipChain {
    let [columns, rows] = TEXELS;
    let texel = |at: u32, count: u32| u8::try_from(255 * at / (count - 1)).expect("a byte");
    let rgba = (0..columns * rows)
        .flat_map(|i| {
            [
                texel(i % columns, columns),
                40,
                texel(i / columns, rows),
                255,
            ]
        })
        .collect();
    MipChain::new(columns, rows, rgba).expect("as many bytes as it needs")
}

/// An eye over a region, looking down or aslant.
#[derive(Debug, Clone, Copy)]
struct Eye {
    longitude_deg: f64,
    latitude_deg: f64,
    height_m: f64,
    pitch_deg: f64,
}

fn eye(longitude_deg: f64, latitude_deg: f64, height_m: f64, pitch_deg: f64) -> Eye {
    Eye {
        longitude_deg,
        latitude_deg,
        height_m,
        pitch_deg,
    }
}

/// A globe with one region that is never meshed: covers are drawn where the stencil is 0, which is
/// everywhere.
fn input(eye: Eye, bounds: Bounds, placement: TexturePlacement) -> FillInput {
    let Bounds {
        west,
        south,
        east,
        north,
    } = bounds;
    let ring = if east - west >= 360.0 && north >= 90.0 {
        // Round the pole, uncut.
        format!("[[-180,{south}],[-60,{south}],[60,{south}],[180,{south}]]")
    } else {
        format!(
            "[[{west},{south}],[{east},{south}],[{east},{north}],[{west},{north}],[{west},{south}]]"
        )
    };
    let text = format!(r#"{{"type":"Polygon","coordinates":[{ring}]}}"#);
    let regions = parse_regions(text.as_bytes(), "test").expect("valid");
    let scene = PreparedScene {
        name: "bare".to_owned(),
        body: BODY,
        edge_rule: Default::default(),
        overlap: Overlap::Disjoint,
        regions: regions.into(),
        meshes: RegionSet::default(),
        levels: Arc::default(),
        footprints: Arc::default(),
        bounds: SceneBounds::default(),
        parts: terrafill_plan::LazyParts::default(),
        surface: EllipsoidKind::surface(&BODY, 720),
        picture: None,
        texture: Some(Arc::new(SceneTexture {
            source: "test".to_owned(),
            image: picture(),
            share: TextureShare::One,
            alpha: 1.0,
            placement,
            fade_m: None,
        })),
    };
    let view = View {
        name: "globe".to_owned(),
        pose: CameraPose {
            eye: Geodetic::from_degrees(eye.longitude_deg, eye.latitude_deg, eye.height_m),
            heading_rad: 0.3,
            pitch_rad: eye.pitch_deg.to_radians(),
            fov_y_rad: 60_f64.to_radians(),
            near_m: 10.0,
        },
        note: None,
    };
    let mut input = FillInput::new(&scene, &view, SIZE, PlanOptions::default()).expect("above");
    input.plan.regions.push(PlannedRegion {
        drawn_as: terrafill_plan::DrawnAs::Volume,
        region: 0,
        mesh: 0,
        heights: terrafill_core::VolumeHeights {
            top_m: 0.0,
            bottom_m: 0.0,
        },
        screen_rect: PixelRect::full(SIZE),
        near_rectangle: NearRectangle::Outside,
    });
    input
}

fn plan_of(input: &FillInput, route: &str) -> TexturedPlan {
    let choice = RouteChoice::parse(route).expect("known");
    TexturedPlan::new(input, choice, PositionRoute::EyeRegion).expect("finite")
}

/// Texture coordinates by the definitions; of a pattern, for k = 0.
fn uv(
    placement: &TexturePlacement,
    bounds: Bounds,
    longitude_rad: f64,
    latitude_rad: f64,
) -> [f64; 2] {
    let half_turn = |angle: f64| (angle + PI).rem_euclid(TAU) - PI;
    let [west, south, east, north] =
        [bounds.west, bounds.south, bounds.east, bounds.north].map(f64::to_radians);
    let (anchor, size_m) = match *placement {
        TexturePlacement::Extents => {
            let from_middle = half_turn(longitude_rad - (west + east) / 2.0);
            let u = 0.5 + from_middle / (east - west);
            return [u, (north - latitude_rad) / (north - south)];
        }
        TexturePlacement::Anchor {
            anchor,
            width_m,
            height_m,
            ..
        } => (anchor, [width_m, height_m]),
        TexturePlacement::Pattern { anchor, .. } => (anchor, TEXELS.map(f64::from)),
    };
    let e2 = BODY.eccentricity_squared();
    let sin = anchor.latitude_rad.sin();
    let n = BODY.equatorial_radius_m() / (1.0 - e2 * sin * sin).sqrt();
    let m = n * (1.0 - e2) / (1.0 - e2 * sin * sin);
    let x = half_turn(longitude_rad - anchor.longitude_rad) * n * anchor.latitude_rad.cos();
    let y = (latitude_rad - anchor.latitude_rad) * m;
    let (sin, cos) = anchor.rotation_rad.sin_cos();
    [
        0.5 + (x * cos - y * sin) / size_m[0],
        0.5 - (x * sin + y * cos) / size_m[1],
    ]
}

/// Passes everywhere: the surface pass left 0.
const EVERYWHERE: StencilTest = StencilTest {
    read_mask: 0xff,
    ..StencilTest::ANYWHERE
};

struct TexturedPicture {
    rgba: Vec<u8>,
    depth: Vec<f32>,
    probed: Vec<Option<Probed>>,
}

fn frame_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let stages = wgpu::ShaderStages::VERTEX_FRAGMENT;
    gpu.buffer_layout("view", stages, &[wgpu::BufferBindingType::Uniform])
}

fn draw(
    gpu: &Arc<Gpu>,
    input: &FillInput,
    plan: &TexturedPlan,
) -> Result<TexturedPicture, DeviceError> {
    let mut targets = RenderTargets::new(gpu, SIZE).expect("small targets");
    targets.prepare(input).expect("fits");
    targets.draw_surface().expect("draws");
    let layout = frame_layout(gpu);
    let frame_group = gpu.bind_buffers("view", &layout, &[targets.view_constants()]);
    let mut fill = TexturedFill::new(gpu, &layout);
    let texture = input.scene.texture.as_ref().expect("a picture");
    fill.upload_image(gpu, &texture.image, 1)?;
    fill.set_view(&targets, plan)?;
    let probe = Probe::new(gpu, SIZE);
    let (colour, depth_stencil) = (targets.colour_view(), targets.depth_stencil_view());
    let probe_views = probe.views();
    for purpose in [CoverPurpose::Colour, CoverPurpose::Probe] {
        fill.ensure(gpu, EVERYWHERE, purpose, &[0]);
        let attached = |view, load| Some(attached(view, load));
        let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        let targets = match purpose {
            CoverPurpose::Colour => vec![attached(&colour, wgpu::LoadOp::Load)],
            CoverPurpose::Probe => probe_views.iter().map(|v| attached(v, clear)).collect(),
        };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: None,
            color_attachments: &targets,
            depth_stencil_attachment: Some(read_only_depth(&depth_stencil, None)),
            ..Default::default()
        });
        pass.set_bind_group(0, &frame_group, &[]);
        pass.set_stencil_reference(0);
        let mut bound = BoundCover::default();
        assert!(fill.bind(&mut pass, EVERYWHERE, purpose, 0, &mut bound));
        pass.draw(0..3, 0..1);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
    }
    let picture = targets.read()?;
    Ok(TexturedPicture {
        rgba: picture.rgba,
        depth: picture.depth,
        probed: probe.read(gpu)?,
    })
}

/// What the judge knows of a sight.
#[derive(Debug, Clone)]
struct JudgedView {
    name: &'static str,
    bounds: Bounds,
    input: FillInput,
}

impl JudgedView {
    fn new(name: &'static str, eye: Eye, bounds: Bounds, placement: TexturePlacement) -> Self {
        Self {
            name,
            bounds,
            input: input(eye, bounds, placement),
        }
    }

    fn placement(&self) -> &TexturePlacement {
        &self
            .input
            .scene
            .texture
            .as_ref()
            .expect("a picture")
            .placement
    }

    /// Whether a pixel shows a place within the region's bounds.
    fn is_inside(&self, column: u32, row: u32, depth: f32) -> bool {
        let camera = &self.input.camera;
        let direction = camera.pixel_direction_ecef(SIZE, column, row);
        let point = camera.eye_ecef + direction * (camera.near_m / f64::from(depth));
        let found = BODY.ecef_to_geodetic(point);
        let east = (found.longitude_rad.to_degrees() - self.bounds.west).rem_euclid(360.0);
        let latitude = found.latitude_rad.to_degrees();
        east <= self.bounds.east - self.bounds.west
            && (self.bounds.south..=self.bounds.north).contains(&latitude)
    }

    /// Where a pixel really is: coordinates, and the longer footprint in texels.
    fn exact(&self, column: u32, row: u32, depth: f32) -> ([f64; 2], f64) {
        let camera = &self.input.camera;
        let direction = camera.pixel_direction_ecef(SIZE, column, row);
        let distance = camera.near_m / f64::from(depth);
        let point = camera.eye_ecef + direction * distance;
        let uv_of = |at| {
            let found = BODY.ecef_to_geodetic(at);
            uv(
                self.placement(),
                self.bounds,
                found.longitude_rad,
                found.latitude_rad,
            )
        };
        let here = BODY.ecef_to_geodetic(point);
        let normal = BODY.geodetic_surface_normal(here.longitude_rad, here.latitude_rad);
        let uv = uv_of(point);
        // A thousandth of a pixel to the side, on the tangent plane.
        let footprint = |column: u32, row: u32| {
            let to = camera.pixel_direction_ecef(SIZE, column, row);
            let ray = direction + (to - direction) * 1e-3;
            let met =
                camera.eye_ecef + ray * ((point - camera.eye_ecef).dot(normal) / ray.dot(normal));
            let step = uv_of(met);
            let texels = |axis: usize| (step[axis] - uv[axis]) * f64::from(TEXELS[axis]) * 1e3;
            texels(0).hypot(texels(1))
        };
        (
            uv,
            footprint(column + 1, row).max(footprint(column, row + 1)),
        )
    }

    /// The pattern's level at a pixel.
    fn pattern_level(&self, column: u32, row: u32, depth: f32) -> f64 {
        let TexturePlacement::Pattern { texels_per_px, .. } = *self.placement() else {
            return 0.0;
        };
        let camera = &self.input.camera;
        let direction = camera.pixel_direction_ecef(SIZE, column, row);
        let distance = direction.length() * camera.near_m / f64::from(depth);
        (camera.pixel_size_m(SIZE, distance) / texels_per_px).log2()
    }
}

#[derive(Debug, Default)]
struct Errors {
    pixels: usize,
    compared: usize,
    rms: f64,
    max: f64,
    level_max: f64,
    non_finite: usize,
}

impl Errors {
    fn of(sight: &JudgedView, drawn: &TexturedPicture) -> Self {
        let mut errors = Self::default();
        let address = terrafill_contract::PlannedTexture::of_scene(&sight.input.scene)[0].address;
        for row in 0..SIZE.height {
            for column in 0..SIZE.width {
                let index = (row * SIZE.width + column) as usize;
                let Some(Probed { id, place }) = drawn.probed[index] else {
                    continue;
                };
                assert_eq!(id, 1);
                if !place.is_finite() {
                    errors.non_finite += 1;
                    continue;
                }
                let depth = drawn.depth[index];
                errors.pixels += 1;
                // Routes answer for their region, which a stencil would keep the covers to.
                if !sight.is_inside(column, row, depth) {
                    continue;
                }
                errors.compared += 1;
                let (uv, footprint) = sight.exact(column, row, depth);
                let k = sight.pattern_level(column, row, depth);
                // Of a pattern: the pictures differ by whole repeats of the coarser of the two.
                let period = (k.floor() + 1.0).exp2();
                let finest = (-k.floor()).exp2();
                let (period, finest) = match sight.placement() {
                    TexturePlacement::Pattern { .. } => (period, finest),
                    _ => (1.0, 1.0),
                };
                let texels = (0..2).map(|axis| {
                    let off = place.uv[axis] - uv[axis];
                    let off = match address[axis] {
                        AddressMode::Repeat => off - (off / period).round() * period,
                        _ => off,
                    };
                    off.abs() * finest * f64::from(TEXELS[axis])
                });
                let texels = texels.fold(0.0, f64::max);
                errors.rms += texels * texels;
                errors.max = errors.max.max(texels);
                let level = (footprint * finest).log2().max(0.0);
                let off = [
                    place.level - level,
                    place.pattern_level - k,
                    (place.footprint_texels / footprint).log2(),
                ];
                let off = off.into_iter().map(f64::abs).fold(0.0, f64::max);
                errors.level_max = errors.level_max.max(off);
            }
        }
        errors.rms = (errors.rms / errors.compared.max(1) as f64).sqrt();
        errors
    }

    fn is_within(&self) -> bool {
        self.non_finite == 0 && self.rms <= 0.25 && self.max <= 0.5
    }
}

fn anchor(longitude_deg: f64, latitude_deg: f64, rotation_deg: f64) -> TextureAnchor {
    TextureAnchor {
        longitude_rad: longitude_deg.to_radians(),
        latitude_rad: latitude_deg.to_radians(),
        rotation_rad: rotation_deg.to_radians(),
    }
}

/// Places to look at: a region under the eye, from straight above and aslant.
fn sights() -> Vec<JudgedView> {
    let down = -90.0;
    // Longitude, latitude, height and pitch of the eye; west, south, east and north of the region.
    let of_extents = [
        ("equator", [10.0, 0.0, 3e5, down], [8.0, -2.0, 12.0, 2.0]),
        ("45°", [10.0, 45.0, 3e5, down], [8.0, 43.0, 12.0, 47.0]),
        ("aslant", [10.0, 45.0, 3e5, -60.0], [8.0, 43.0, 12.0, 47.0]),
        ("70°", [10.0, 70.0, 3e5, down], [6.0, 68.0, 14.0, 72.0]),
        ("85°", [10.0, 85.0, 3e5, down], [-10.0, 83.0, 30.0, 87.0]),
        (
            "±180°",
            [180.0, -17.0, 3e5, down],
            [177.0, -19.0, 183.0, -15.0],
        ),
        (
            "beyond",
            [-179.9, -17.0, 3e5, down],
            [177.0, -19.0, 183.0, -15.0],
        ),
        ("pole", [0.0, 89.95, 3e5, down], [-180.0, 70.0, 180.0, 90.0]),
    ];
    let of_extents = of_extents.map(
        |(name, [x, y, height_m, pitch], [west, south, east, north])| {
            let (eye, bounds) = (eye(x, y, height_m, pitch), bounds(west, south, east, north));
            JudgedView::new(name, eye, bounds, TexturePlacement::Extents)
        },
    );
    let mut sights = Vec::from(of_extents);
    sights.extend([
        JudgedView::new(
            "turned",
            eye(10.0, 45.0, 3e5, down),
            bounds(8.0, 43.0, 12.0, 47.0),
            TexturePlacement::Anchor {
                anchor: anchor(-120.0, 30.0, 25.0),
                width_m: 9e4,
                height_m: 4e4,
                outside: Outside::Repeat,
            },
        ),
        JudgedView::new(
            "over the edge",
            eye(180.0, 10.0, 3e5, -70.0),
            bounds(177.0, 8.0, 183.0, 12.0),
            TexturePlacement::Anchor {
                anchor: anchor(-179.5, 10.5, 200.0),
                width_m: 3e5,
                height_m: 2e5,
                outside: Outside::Transparent,
            },
        ),
        JudgedView::new(
            "pattern",
            eye(10.0, 45.0, 2e3, -35.0),
            bounds(8.0, 43.0, 12.0, 47.0),
            TexturePlacement::Pattern {
                anchor: anchor(-30.0, 40.0, 30.0),
                texels_per_px: 1.5,
            },
        ),
    ]);
    sights
}

fn sight(name: &str) -> JudgedView {
    let found = sights().into_iter().find(|sight| sight.name == name);
    found.expect("there")
}

#[test]
fn the_chosen_route_is_within_tolerance_wherever_the_region_lies() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    for sight in sights() {
        let plan = plan_of(&sight.input, "chosen");
        let drawn = draw(&gpu, &sight.input, &plan).expect("draws");
        let errors = Errors::of(&sight, &drawn);
        let message = format!("{}: {} {errors:?}", sight.name, plan.note());
        eprintln!("{message}");
        let surface = drawn.depth.iter().filter(|&&depth| depth > 0.0).count();
        assert_eq!(errors.pixels, surface, "{message}");
        assert!(errors.compared > surface / 10, "{message}");
        assert!(errors.is_within(), "{message}");
        assert!(errors.level_max <= 0.01, "{message}");
    }
}

#[test]
fn every_kind_of_route_runs_on_the_device() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let sight = sight("45°");
    for route in [
        "atan2-native",
        "recentred-atan2-native",
        "odd-rel-9",
        "recentred-odd-pin-7",
        "near-odd-rel-7+bowring-2",
        "recentred-rat-2-2",
        "lut-1024-r32f-linear",
        "lut-1024-r32f-linear-exact",
        "gnomonic-3",
        "cube-1024",
    ] {
        let plan = plan_of(&sight.input, route);
        let drawn = draw(&gpu, &sight.input, &plan).expect("draws");
        let errors = Errors::of(&sight, &drawn);
        assert!(errors.is_within(), "{route}: {errors:?}");
    }
    for position in PositionRoute::ALL {
        let choice = RouteChoice::parse("recentred-odd-rel-9").expect("known");
        let plan = TexturedPlan::new(&sight.input, choice, position).expect("finite");
        let drawn = draw(&gpu, &sight.input, &plan).expect("draws");
        let errors = Errors::of(&sight, &drawn);
        assert!(errors.is_within(), "{}: {errors:?}", position.name());
    }
}

#[test]
fn a_wrong_route_axis_or_anchor_is_noticed() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let sight = sight("45°");
    let fails = |plan: &TexturedPlan, what: &str| {
        let drawn = draw(&gpu, &sight.input, plan).expect("draws");
        let errors = Errors::of(&sight, &drawn);
        assert!(!errors.is_within(), "{what}: {errors:?}");
    };
    let plan = |route| plan_of(&sight.input, route);
    fails(&plan("atan2-native+geocentric"), "geocentric latitude");
    fails(&plan("odd-3"), "a route far beyond its region's tolerance");
    let swap = |row: &mut [f32; 3]| row.swap(0, 1);
    let mut swapped = plan("chosen");
    swap(&mut swapped.covers[0].region.u);
    swap(&mut swapped.covers[0].region.v);
    fails(&swapped, "longitude for latitude");
    let mut flipped = plan("chosen");
    flipped.covers[0].region.v[1] *= -1.0;
    fails(&flipped, "down for up");
    // Constants of a region that lies a hundredth of its width further east.
    let mut moved = sight.input.clone();
    let east = input(
        eye(10.04, 45.0, 3e5, -90.0),
        bounds(8.04, 43.0, 12.04, 47.0),
        TexturePlacement::Extents,
    );
    moved.scene = east.scene;
    fails(
        &plan_of(&moved, "recentred-odd-rel-9"),
        "another region's anchor",
    );
}

#[test]
fn no_seam_runs_along_the_antimeridian() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let sight = sight("±180°");
    let drawn = draw(&gpu, &sight.input, &plan_of(&sight.input, "chosen")).expect("draws");
    // The meridian runs down the middle; the picture's red grows evenly across it, and levels with
    // derivatives of neighbouring pixels would fall to the coarsest, a mean grey, there.
    let mut largest = 0;
    for row in drawn.rgba.chunks_exact(4 * SIZE.width as usize) {
        for pair in row.windows(8).step_by(4) {
            largest = largest.max(pair[0].abs_diff(pair[4]));
        }
    }
    assert!((1..=8).contains(&largest), "{largest}");
    let levels = drawn
        .probed
        .iter()
        .flatten()
        .map(|probed| probed.place.level);
    let (low, high) = levels.fold((f64::MAX, f64::MIN), |(low, high), level| {
        (low.min(level), high.max(level))
    });
    assert!(high - low < 1.0, "{low} {high}");
}

#[test]
fn a_magnified_region_looks_the_same_without_looking_for_levels() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let mut kinds = [0; 2];
    for (height_m, pitch_deg) in [
        (1e3, -90.0),
        (1e5, -90.0),
        (1e5, -60.0),
        (1e5, -20.0),
        (5e5, -90.0),
        (1e6, -90.0),
    ] {
        let sight = JudgedView::new(
            "closer",
            eye(10.0, 45.0, height_m, pitch_deg),
            bounds(8.0, 43.0, 12.0, 47.0),
            TexturePlacement::Extents,
        );
        let mut plan = plan_of(&sight.input, "chosen");
        let is_magnified = plan.covers[0].is_magnified;
        let said = draw(&gpu, &sight.input, &plan).expect("draws");
        plan.covers[0].is_magnified = !is_magnified;
        let other = draw(&gpu, &sight.input, &plan).expect("draws");
        // The probe looks for the level in either.
        assert_eq!(said.probed, other.probed);
        let places = said.probed.iter().flatten().map(|probed| probed.place);
        let largest = places.fold(0.0, |largest: f64, at| largest.max(at.footprint_texels));
        let message = format!("{height_m} m, {pitch_deg}°: {largest} texels");
        eprintln!("{message}, magnified: {is_magnified}");
        kinds[usize::from(is_magnified)] += 1;
        if is_magnified {
            assert!(largest < 1.0, "{message}");
            assert_eq!(said.rgba, other.rgba, "{message}");
        } else if largest > 2.0 {
            // Negative control: level 0 where a pixel spans more than its texels shows.
            assert_ne!(said.rgba, other.rgba, "{message}");
        }
        // The bound says so of what is looked at from straight above, well before it is so.
        let is_plain = pitch_deg == -90.0 && largest < 0.5;
        assert!(is_magnified || !is_plain, "{message}");
    }
    assert!(kinds.iter().all(|&count| count >= 2), "{kinds:?}");
}

#[test]
fn a_superfluous_normalize_moves_texels_by_rounding_alone() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let sight = JudgedView::new(
        "far",
        eye(10.0, 45.0, 2e6, -90.0),
        bounds(8.0, 43.0, 12.0, 47.0),
        TexturePlacement::Extents,
    );
    let [once, more] = [false, true].map(|superfluous_normalize| {
        let switches = Switches {
            texture: RouteChoice::parse("atan2-native+geocentric"),
            position: Some(PositionRoute::InverseEcef),
            superfluous_normalize,
            ..Switches::default()
        };
        let plan = TexturedPlan::of_switches(&sight.input, &switches);
        let plan = plan.expect("planned").expect("textured");
        let value = f64::from(u8::from(superfluous_normalize));
        let constants = plan.covers[0].overrides().constants();
        assert!(constants.contains(&("NORMALIZES_POSITION", value)));
        draw(&gpu, &sight.input, &plan).expect("draws")
    });
    let (mut compared, mut moved) = (0, 0);
    for (a, b) in once.probed.iter().zip(&more.probed) {
        let (Some(a), Some(b)) = (a, b) else {
            assert_eq!(a.is_some(), b.is_some(), "the same pixels");
            continue;
        };
        let [a, b] = [a.place.uv, b.place.uv];
        let apart = (a[0] - b[0]).hypot(a[1] - b[1]);
        // 400 km of extent: a few metres of f32 about the centre are 1e-5 of it.
        assert!(apart < 1e-4, "{apart}");
        compared += 1;
        moved += usize::from(apart > 0.0);
    }
    // Negative control: were it not drawn at all, nothing would move.
    assert!(compared > 50 && moved > 0, "{moved} of {compared}");
}

/// A region that goes on beyond the horizon, and sky above it.
fn over_the_horizon() -> JudgedView {
    JudgedView::new(
        "horizon",
        eye(10.0, 45.0, 3e6, -50.0),
        bounds(-50.0, 0.0, 70.0, 89.0),
        TexturePlacement::Extents,
    )
}

#[test]
fn a_floor_reads_its_depth_and_samples_once_where_another_fill_would() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let sight = over_the_horizon();
    let [floor, chosen] = ["floor", "chosen"].map(|choice| plan_of(&sight.input, choice));
    assert_eq!(floor.note(), "floor (1 region)");
    let drawn = draw(&gpu, &sight.input, &floor).expect("draws");
    let mapped = draw(&gpu, &sight.input, &chosen).expect("draws");
    let sizes = [SIZE.width, SIZE.height].map(f64::from);
    let mut elsewhere = 0;
    for (index, (probed, other)) in drawn.probed.iter().zip(&mapped.probed).enumerate() {
        assert_eq!(probed.is_some(), other.is_some(), "the same pixels");
        let (Some(probed), Some(other)) = (probed, other) else {
            continue;
        };
        let width = SIZE.width as usize;
        let pixel = [index % width, index / width].map(|at| at as f64 + 0.5);
        let depth = f64::from(drawn.depth[index]);
        let expected = [0, 1].map(|axis| depth + pixel[axis] / sizes[axis]);
        let found = probed.place.uv;
        let off = [0, 1].map(|axis| (found[axis] - expected[axis]).abs());
        assert!(off.iter().all(|&off| off < 1e-6), "{found:?} {expected:?}");
        elsewhere += usize::from((found[0] - other.place.uv[0]).abs() > 1e-3);
    }
    // Negative control: where it samples is not where the map would.
    assert!(elsewhere > 1000, "{elsewhere}");
    assert_ne!(drawn.rgba, mapped.rgba);
}

#[test]
fn cleared_depth_never_reaches_the_map() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    // The stencil test passes over the sky as well; only the shader's own test keeps it out.
    let sight = over_the_horizon();
    let plan = plan_of(&sight.input, "recentred-odd-rel-15");
    let drawn = draw(&gpu, &sight.input, &plan).expect("draws");
    let sky = drawn.depth.iter().filter(|&&depth| depth == 0.0).count();
    assert!(sky > 1000, "{sky}");
    let pixels = drawn.probed.iter().zip(drawn.rgba.chunks_exact(4));
    for (depth, (probed, pixel)) in drawn.depth.iter().zip(pixels) {
        assert_eq!(*depth > 0.0, probed.is_some());
        assert_eq!(*depth > 0.0, pixel[3] == 255);
    }
    assert_eq!(Errors::of(&sight, &drawn).non_finite, 0);
    // Negative control: let in, the cleared depth is no number any more.
    let cover = &plan.covers[0];
    let offset = plan
        .position
        .emulate(&plan.depth, &cover.position_constants, [0.5; 2], 0.0);
    assert!(offset.iter().any(|value| !value.is_finite()), "{offset:?}");
}

#[test]
fn edges_and_fades_leave_nothing_where_they_should() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let sight = sight("over the edge");
    let drawn = draw(&gpu, &sight.input, &plan_of(&sight.input, "chosen")).expect("draws");
    let mut seen = [0; 2];
    for (probed, pixel) in drawn.probed.iter().zip(drawn.rgba.chunks_exact(4)) {
        let Some(probed) = probed else { continue };
        let inside = probed.place.uv.iter().all(|c| (0.0..=1.0).contains(c));
        // The surface's alpha is 0, and blending leaves the cover's own.
        assert_eq!(pixel[3], if inside { 255 } else { 0 }, "{probed:?}");
        seen[usize::from(inside)] += 1;
    }
    assert!(seen.iter().all(|&count| count > 1000), "{seen:?}");

    let mut fading = faded(&sight, [3.2e5, 3.6e5]);
    let plan = plan_of(&fading, "chosen");
    let drawn = draw(&gpu, &fading, &plan).expect("draws");
    let mut seen = [0; 3];
    for (probed, pixel) in drawn.probed.iter().zip(drawn.rgba.chunks_exact(4)) {
        let Some(probed) = probed else { continue };
        let inside = probed.place.uv.iter().all(|c| (0.0..=1.0).contains(c));
        let left = ((3.6e5 - probed.place.distance_m) / 4e4).clamp(0.0, 1.0);
        let left = if inside { left } else { 0.0 };
        // Blended over alpha 0: source alpha and nothing of the target's.
        let found = f64::from(pixel[3]) / 255.0;
        assert!((found - left).abs() < 0.01, "{found} {left} {probed:?}");
        seen[if left <= 0.0 {
            0
        } else if left < 1.0 {
            1
        } else {
            2
        }] += 1;
    }
    assert!(seen.iter().all(|&count| count > 100), "{seen:?}");
    fading.scene.texture = None;
    let choice = RouteChoice::Chosen;
    let error = TexturedPlan::new(&fading, choice, PositionRoute::EyeRegion).expect_err("plain");
    assert!(error.to_string().contains("without a picture"), "{error}");
}

fn faded(sight: &JudgedView, fade_m: [f64; 2]) -> FillInput {
    let mut input = sight.input.clone();
    let texture = SceneTexture::clone(input.scene.texture.as_ref().expect("a picture"));
    input.scene.texture = Some(Arc::new(SceneTexture {
        fade_m: Some(fade_m),
        ..texture
    }));
    input
}

#[test]
fn a_second_view_of_as_many_regions_makes_nothing_and_writes_what_changed() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let targets = RenderTargets::new(&gpu, SIZE).expect("small targets");
    let mut fill = TexturedFill::new(&gpu, &frame_layout(&gpu));
    let sight = sight("45°");
    let texture = sight.input.scene.texture.as_ref().expect("a picture");
    fill.upload_image(&gpu, &texture.image, 2).expect("fits");
    let held = |fill: &TexturedFill, feature| {
        let held = fill.holdings().into_iter();
        let own = held.filter(|held| held.feature == feature);
        own.map(|held| held.memory.texture_bytes + held.memory.constant_bytes)
            .sum::<u64>()
    };
    assert_eq!(held(&fill, Feature::Picture), 2 * texture.image.bytes());
    let one = plan_of(&sight.input, "recentred-odd-rel-9");
    let mut other = one.clone();
    other.covers[0].region.alpha = 0.5;
    let set = |fill: &mut TexturedFill, plan: &TexturedPlan| {
        let before = gpu.work_done();
        fill.set_view(&targets, plan).expect("valid shader");
        gpu.work_done() - before
    };
    assert_eq!(set(&mut fill, &one).buffer_creations, 1);
    let again = set(&mut fill, &one);
    assert_eq!((again.buffer_creations, again.uploads), (0, 0));
    let moved = set(&mut fill, &other);
    assert_eq!((moved.buffer_creations, moved.uploads), (0, 1));
    let constants = held(&fill, Feature::TextureConstants);
    assert_eq!(moved.upload_bytes, constants);
    let cover = &one.covers[0];
    let vectors = cover.position_constants.len() + cover.route_constants.len();
    let used = 16 * (TexturedRegion::VECTORS + vectors) as u64;
    let alignment = u64::from(gpu.device.limits().min_uniform_buffer_offset_alignment);
    assert_eq!(constants, used.next_multiple_of(alignment));
    // Pipelines: one for each purpose, however often it is asked for.
    let before = gpu.work_done();
    for _ in 0..2 {
        fill.ensure(&gpu, EVERYWHERE, CoverPurpose::Colour, &[0]);
    }
    assert_eq!((gpu.work_done() - before).pipeline_creations, 1);
    // A cover of another number takes the same one, since the number is the pass's.
    let another = StencilTest {
        reference: EVERYWHERE.reference ^ 1,
        ..EVERYWHERE
    };
    fill.ensure(&gpu, another, CoverPurpose::Colour, &[0]);
    assert_eq!((gpu.work_done() - before).pipeline_creations, 1);
    // Negative control: what the pipeline is given makes another one.
    let masked = StencilTest {
        read_mask: EVERYWHERE.read_mask ^ 1,
        ..EVERYWHERE
    };
    fill.ensure(&gpu, masked, CoverPurpose::Colour, &[0]);
    assert_eq!((gpu.work_done() - before).pipeline_creations, 2);
}
