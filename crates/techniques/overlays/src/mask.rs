// SPDX-License-Identifier: MIT OR Apache-2.0
//! The mask texture: every region of the scene drawn once into a texture of ids over the rectangle of
//! longitude and latitude that bounds them all; a full-screen pass then turns each pixel's depth into
//! a place and looks its id up.
//!
//! Angles in radians, lengths in metres. Rows go from north to south. The rectangle crosses the
//! antimeridian only as the whole way round: then it spans −180° to 180°, and triangles that reach over
//! one end are drawn at the other too. A triangle with a corner at a pole becomes the quadrangle that
//! it is in this plane. A triangle that holds a pole inside has no shape there and is refused.
//!
//! Longitude and latitude come from `f32`. In a rectangle narrower than [`MAX_LOCAL_RAD`] they are
//! differences from its middle, which keep their digits; in a wider one Bowring's formula (1976) has an
//! error of metres, below a hundredth of a texel.

use glam::{DMat3, DVec3};
use terrafill_contract::{Colours, Counters, DeviceError, FillInput, MemoryUse, count_u32};
use terrafill_core::{Ellipsoid, Extent, nearest_f32};
use terrafill_gpu::{
    COLOUR_FORMAT, Gpu, HeldBuffer, Overlay, RenderTargets, attached, described, vertex_layout,
};
use terrafill_plan::LazyMesh;
use terrafill_variant::{SwitchError, Variant};

/// Key of the texture's longer side, texels.
pub(crate) const SIZE: &str = "size";

/// Its values.
pub(crate) const SIZES: &[&str] = &["4096", "1024", "2048", "8192"];

/// Half of the widest rectangle whose angles are differences from its middle, radians. Their error is
/// `δ³ e² R / 4`, 10 m at the end, where a texel of the largest mask is 156 m wide.
const MAX_LOCAL_RAD: f64 = 0.1;

/// Two bytes an id.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Uint;

/// The largest id in [`FORMAT`].
const MAX_ID: usize = 65_535;

/// From a pole, degrees: corners nearer than this are at it.
const POLE_DEG: f64 = 1e-9;

fn size(variant: &Variant) -> Result<u32, SwitchError> {
    let choices = [
        ("1024", 1024),
        ("2048", 2048),
        ("4096", 4096),
        ("8192", 8192),
    ];
    variant.choice(SIZE, &choices)
}

/// Degrees; `west < east`, at most 360 apart.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Rectangle {
    west: f64,
    south: f64,
    east: f64,
    north: f64,
}

impl Rectangle {
    /// Around all extents, a little wider, so that no boundary lies on its edge; from −180° to 180°
    /// where one of them crosses the antimeridian.
    fn around<'a>(extents: impl IntoIterator<Item = &'a Extent>) -> Option<Self> {
        let mut all: Option<Self> = None;
        for extent in extents {
            let crosses = extent.west_deg > extent.east_deg;
            let own = Self {
                west: if crosses { -180.0 } else { extent.west_deg },
                south: extent.south_deg,
                east: if crosses { 180.0 } else { extent.east_deg },
                north: extent.north_deg,
            };
            all = Some(all.map_or(own, |all| Self {
                west: all.west.min(own.west),
                south: all.south.min(own.south),
                east: all.east.max(own.east),
                north: all.north.max(own.north),
            }));
        }
        let all = all?;
        let (width, height) = (all.east - all.west, all.north - all.south);
        let margin = 1e-3 * width.max(height).max(1e-9);
        Some(Self {
            west: (all.west - margin).max(-180.0),
            south: (all.south - margin).max(-90.0),
            east: (all.east + margin).min(180.0),
            north: (all.north + margin).min(90.0),
        })
    }

    fn middle_deg(&self) -> [f64; 2] {
        [
            0.5 * (self.west + self.east),
            0.5 * (self.south + self.north),
        ]
    }

    fn half_deg(&self) -> [f64; 2] {
        [
            0.5 * (self.east - self.west),
            0.5 * (self.north - self.south),
        ]
    }

    /// Columns and rows with `longer` texels along the longer side.
    #[allow(clippy::cast_possible_truncation, reason = "between 1 and `longer`")]
    fn texels(&self, longer: u32) -> [u32; 2] {
        let [x, y] = self.half_deg();
        let scale = f64::from(longer) / x.max(y);
        [x, y].map(|side| ((side * scale).round() as u32).clamp(1, longer))
    }
}

/// A corner of a region in the mask.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Corner {
    /// −1 … 1 from west to east and from south to north.
    clip: [f32; 2],
    /// The region's id.
    id: u32,
}

/// Triangles of all regions in the rectangle.
fn corners(meshes: &[LazyMesh], rectangle: &Rectangle) -> Result<Vec<Corner>, DeviceError> {
    let mut corners = Vec::new();
    for (id, mesh) in (1..).zip(meshes) {
        for triangle in &mesh.triangles {
            let places = triangle.map(|vertex| mesh.vertices_deg[vertex as usize]);
            let flat = unrolled(places).ok_or_else(|| DeviceError::Unsupported {
                capability: format!(
                    "a place for region {} ({}): one of its triangles goes round a pole",
                    mesh.region_index, mesh.name
                ),
                adapter: "a mask over longitude and latitude".to_owned(),
            })?;
            for piece in flat {
                push(&mut corners, rectangle, piece, id);
            }
        }
    }
    Ok(corners)
}

/// A triangle, and its copies a turn to either side where they reach into the rectangle.
fn push(corners: &mut Vec<Corner>, rectangle: &Rectangle, triangle: [[f64; 2]; 3], id: u32) {
    let (middle, half) = (rectangle.middle_deg(), rectangle.half_deg());
    for turn in [-360.0, 0.0, 360.0] {
        let moved = triangle.map(|[x, y]| [x + turn, y]);
        let is_seen = moved.iter().any(|place| place[0] > rectangle.west)
            && moved.iter().any(|place| place[0] < rectangle.east);
        if is_seen {
            corners.extend(moved.map(|place| Corner {
                clip: std::array::from_fn(|axis| {
                    nearest_f32((place[axis] - middle[axis]) / half[axis])
                }),
                id,
            }));
        }
    }
}

/// A triangle in the plane of longitude and latitude, degrees, whose longitudes do not jump: one
/// triangle, or the two of a quadrangle for a corner at a pole. `None` where it goes round one.
fn unrolled(mut places: [[f64; 2]; 3]) -> Option<Vec<[[f64; 2]; 3]>> {
    let is_pole = |place: &[f64; 2]| 90.0 - place[1].abs() < POLE_DEG;
    let poles = places.iter().filter(|place| is_pole(place)).count();
    if poles > 1 {
        return Some(Vec::new());
    }
    if let Some(pole) = places.iter().position(is_pole) {
        places.rotate_left(pole);
    }
    // From the first corner that has a longitude the short way to the others.
    let first = usize::from(poles == 1);
    for index in first + 1..3 {
        let step = places[index][0] - places[index - 1][0];
        places[index][0] -= 360.0 * (step / 360.0).round();
    }
    let [a, b, c] = places;
    if poles == 1 {
        let [over_b, over_c] = [b, c].map(|place| [place[0], a[1]]);
        return Some(vec![[over_b, b, c], [over_b, c, over_c]]);
    }
    let back = a[0] - c[0];
    ((back - 360.0 * (back / 360.0).round()) - back)
        .abs()
        .lt(&1.0)
        .then(|| vec![places])
}

/// What the shader reads: twin of `MaskConstants` in `overlays/mask.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct MaskConstants {
    /// Columns, each padded to 16 bytes: view axes to axes at the rectangle's middle, whose x points
    /// from the body's axis to its meridian, y to the east, z to the north pole.
    meridian_from_view: [[f32; 4]; 3],
    /// The eye from the middle's foot on the ellipsoid, metres.
    eye_m: [f32; 3],
    /// Distance of that foot from the body's axis, metres.
    axis_distance_m: f32,
    /// Sine and cosine of the middle's latitude.
    sine: f32,
    cosine: f32,
    /// Radius of the meridian's curvature there, metres, and by how much it grows a radian.
    curvature_m: f32,
    curvature_growth_m: f32,
    /// Half width and half height of the rectangle, radians.
    half_rad: [f32; 2],
    /// Latitude of the middle, radians.
    latitude_rad: f32,
    /// Height of that foot over the equator's plane, metres.
    plane_distance_m: f32,
    equatorial_m: f32,
    polar_m: f32,
    /// Of the ellipsoid's eccentricities, `1 − b²/a²` and `a²/b² − 1`.
    eccentricity_squared: f32,
    second_eccentricity_squared: f32,
    clip_scale: [f32; 2],
    near_m: f32,
    /// 1: angles are differences from the middle.
    is_local: u32,
}

fn constants(input: &FillInput, rectangle: &Rectangle) -> MaskConstants {
    let body: &Ellipsoid = &input.scene.body;
    let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
    let e2 = body.eccentricity_squared();
    let [longitude, latitude] = rectangle.middle_deg().map(f64::to_radians);
    let half = rectangle.half_deg().map(f64::to_radians);
    let (sine, cosine) = latitude.sin_cos();
    let meridian_from_ecef = DMat3::from_rotation_z(-longitude);
    let bend = 1.0 - e2 * sine * sine;
    let axis_distance = a / bend.sqrt() * cosine;
    let plane_distance = a / bend.sqrt() * (1.0 - e2) * sine;
    let foot = DVec3::new(axis_distance, 0.0, plane_distance);
    let eye = meridian_from_ecef * input.camera.eye_ecef - foot;
    let rotation = meridian_from_ecef * input.camera.view_from_ecef.transpose();
    let column = |index: usize| {
        let c = rotation.col(index).as_vec3();
        [c.x, c.y, c.z, 0.0]
    };
    let scale_y = input.camera.tan_half_fov().recip();
    MaskConstants {
        meridian_from_view: [column(0), column(1), column(2)],
        eye_m: eye.as_vec3().to_array(),
        axis_distance_m: nearest_f32(axis_distance),
        sine: nearest_f32(sine),
        cosine: nearest_f32(cosine),
        curvature_m: nearest_f32(a * (1.0 - e2) / bend.powf(1.5)),
        curvature_growth_m: nearest_f32(3.0 * a * (1.0 - e2) * e2 * sine * cosine / bend.powf(2.5)),
        half_rad: half.map(nearest_f32),
        latitude_rad: nearest_f32(latitude),
        plane_distance_m: nearest_f32(plane_distance),
        equatorial_m: nearest_f32(a),
        polar_m: nearest_f32(b),
        eccentricity_squared: nearest_f32(e2),
        second_eccentricity_squared: nearest_f32((a / b).powi(2) - 1.0),
        clip_scale: [scale_y / input.size.aspect(), scale_y].map(nearest_f32),
        near_m: nearest_f32(input.camera.near_m),
        is_local: u32::from(half[0].max(half[1]) <= MAX_LOCAL_RAD),
    }
}

/// A mask as drawn.
#[derive(Debug)]
struct DrawnMask {
    revision: u64,
    rectangle: Rectangle,
    ids: wgpu::TextureView,
    texels: [u32; 2],
}

/// The mask of a scene, and the pass that looks it up.
#[derive(Debug)]
pub(crate) struct MaskTexture {
    size: u32,
    drawing: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    lookup: wgpu::RenderPipeline,
    drawn: Option<DrawnMask>,
    constants: HeldBuffer,
    colours: HeldBuffer,
    bind_group: Option<(u64, wgpu::BindGroup)>,
}

impl MaskTexture {
    pub(crate) fn new(gpu: &Gpu, variant: &Variant) -> Result<Self, DeviceError> {
        let size = size(variant)?;
        let allowed = gpu.device.limits().max_texture_dimension_2d;
        if size > allowed {
            let needs = format!("textures {size} texels wide (it has {allowed})");
            return Err(DeviceError::unsupported(&needs, &gpu.facts.name));
        }
        let buffer = |ty| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let texture = |sample_type| wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let types = [
            buffer(wgpu::BufferBindingType::Uniform),
            buffer(storage),
            texture(wgpu::TextureSampleType::Depth),
            texture(wgpu::TextureSampleType::Uint),
        ];
        let layout = gpu.fragment_layout("mask lookup", &types);
        let shader = gpu.shader("overlays/mask.wgsl")?;
        let draw_shader = gpu.shader("overlays/mask_ids.wgsl")?;
        let (none, bound) = (
            gpu.pipeline_layout("mask", &[]),
            gpu.pipeline_layout("mask lookup", &[Some(&layout)]),
        );
        let (ids, colours) = ([Some(FORMAT.into())], [Some(COLOUR_FORMAT.into())]);
        let attributes = wgpu::vertex_attr_array![0 => Float32x2, 1 => Uint32];
        let corners = [vertex_layout(&attributes)];
        let mut drawing = described("mask", &none, &draw_shader, &ids);
        drawing.vertex.buffers = &corners;
        let lookup = described("mask lookup", &bound, &shader, &colours);
        Ok(Self {
            size,
            drawing: gpu.create_render_pipeline(&drawing),
            lookup: gpu.create_render_pipeline(&lookup),
            layout,
            drawn: None,
            constants: HeldBuffer::default(),
            colours: HeldBuffer::default(),
            bind_group: None,
        })
    }

    /// Draws every region into the mask; what it is drawn from is dropped.
    fn draw_ids(&self, gpu: &Gpu, input: &FillInput) -> Result<DrawnMask, DeviceError> {
        let found = input.scene.regions.len();
        DeviceError::check_capacity("regions of a mask", found as u64, MAX_ID as u64)?;
        // What follows are coarser levels.
        let meshes = &input.scene.meshes[..found];
        let rectangle = Rectangle::around(meshes.iter().map(|mesh| &mesh.extent));
        let rectangle = rectangle.ok_or(DeviceError::Missing("region"))?;
        let corners = corners(meshes, &rectangle)?;
        let count = count_u32("corners of a mask", corners.len())?;
        let bytes = bytemuck::cast_slice(&corners);
        let buffer = gpu.upload("mask corners", bytes, wgpu::BufferUsages::VERTEX)?;
        let texels = rectangle.texels(self.size);
        let [width, height] = texels;
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let texture = gpu.texture("mask", [width, height, 1], 1, FORMAT, usage);
        let ids = texture.create_view(&Default::default());
        let cleared = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("mask"),
            color_attachments: &[Some(attached(&ids, cleared))],
            ..Default::default()
        });
        pass.set_pipeline(&self.drawing);
        pass.set_vertex_buffer(0, buffer.slice(..));
        pass.draw(0..count, 0..1);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        Ok(DrawnMask {
            revision: input.scene.meshes.revision(),
            rectangle,
            ids,
            texels,
        })
    }
}

impl Overlay for MaskTexture {
    const TECHNIQUE: &'static str = "mask-texture";
    const READS_DEPTH: bool = true;

    fn load(
        &mut self,
        targets: &RenderTargets,
        input: &FillInput,
        colours: Colours,
    ) -> Result<(), DeviceError> {
        let gpu = targets.gpu();
        let revision = input.scene.meshes.revision();
        let held = self.drawn.take().filter(|drawn| drawn.revision == revision);
        let drawn = match held {
            Some(drawn) => drawn,
            None => self.draw_ids(gpu, input)?,
        };
        let constants = constants(input, &drawn.rectangle);
        let bytes = bytemuck::bytes_of(&constants).to_vec();
        let uniform = wgpu::BufferUsages::UNIFORM;
        let mut is_new = self.constants.hold(gpu, "mask constants", bytes, uniform)?;
        let of_regions = 0..input.scene.regions.len();
        let of_regions: Vec<[f32; 4]> = of_regions.map(|region| colours.of(region)).collect();
        let bytes = bytemuck::cast_slice(&of_regions).to_vec();
        let storage = wgpu::BufferUsages::STORAGE;
        is_new |= self.colours.hold(gpu, "region colours", bytes, storage)?;
        let is_bound = self
            .bind_group
            .as_ref()
            .is_some_and(|(of, _)| *of == revision);
        if let (Some(constants), Some(colours)) = (self.constants.buffer(), self.colours.buffer())
            && (is_new || !is_bound)
        {
            let depth = targets.depth_view();
            let resources = [
                constants.as_entire_binding(),
                colours.as_entire_binding(),
                wgpu::BindingResource::TextureView(&depth),
                wgpu::BindingResource::TextureView(&drawn.ids),
            ];
            let bound = gpu.bind("mask lookup", &self.layout, resources);
            self.bind_group = Some((revision, bound));
        }
        self.drawn = Some(drawn);
        Ok(())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, counters: &mut Counters) {
        let Some((_, bind_group)) = &self.bind_group else {
            return;
        };
        pass.set_pipeline(&self.lookup);
        pass.set_bind_group(0, bind_group, &[]);
        pass.draw(0..3, 0..1);
        counters.draws += 1;
        counters.vertices += 3;
    }

    fn memory(&self) -> MemoryUse {
        let texels = self.drawn.as_ref().map(|drawn| drawn.texels);
        let [columns, rows] = texels.unwrap_or_default().map(u64::from);
        MemoryUse {
            constant_bytes: self.constants.size() + self.colours.size(),
            target_bytes: columns * rows * 2,
            buffers: 2,
            ..MemoryUse::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;
    use terrafill_shaders::struct_layout;

    #[test]
    fn constants_lie_as_the_shader_reads_them() {
        macro_rules! offsets {
            ($($field:ident),*) => {
                [$((stringify!($field), offset_of!(MaskConstants, $field))),*]
            };
        }
        let rust = offsets!(
            meridian_from_view,
            eye_m,
            axis_distance_m,
            sine,
            cosine,
            curvature_m,
            curvature_growth_m,
            half_rad,
            latitude_rad,
            plane_distance_m,
            equatorial_m,
            polar_m,
            eccentricity_squared,
            second_eccentricity_squared,
            clip_scale,
            near_m,
            is_local
        );
        let layout = struct_layout("overlays/mask.wgsl", "MaskConstants").expect("in the shader");
        let members = layout.members.iter();
        let shader: Vec<(&str, usize)> = members
            .map(|(name, offset, _)| (name.as_str(), *offset as usize))
            .collect();
        assert_eq!(shader, rust);
        assert_eq!(layout.stride as usize, size_of::<MaskConstants>());
        // Negative control: two that are exchanged are noticed.
        let mut exchanged = rust;
        exchanged.swap(4, 5);
        assert_ne!(shader, exchanged);
    }

    fn extent(west_deg: f64, east_deg: f64) -> Extent {
        Extent {
            west_deg,
            south_deg: -10.0,
            east_deg,
            north_deg: 20.0,
        }
    }

    #[test]
    fn a_rectangle_holds_every_extent_and_goes_round_for_one_that_crosses() {
        let around = |extents: &[Extent]| Rectangle::around(extents).expect("one at least");
        let plain = around(&[extent(-30.0, -10.0), extent(5.0, 40.0)]);
        assert!(plain.west < -30.0 && plain.west > -31.0 && plain.east > 40.0);
        assert_eq!(plain.texels(1000)[0], 1000);
        assert_eq!(plain.texels(1000)[1], 430);
        // Negative control: one that crosses the antimeridian.
        let round = around(&[extent(-30.0, -10.0), extent(170.0, -175.0)]);
        assert_eq!((round.west, round.east), (-180.0, 180.0));
        assert!(Rectangle::around(&[]).is_none());
    }

    #[test]
    fn triangles_over_the_antimeridian_do_not_jump() {
        let over = unrolled([[179.0, 0.0], [-179.0, 0.0], [180.0, 1.0]]).expect("a triangle");
        assert_eq!(over, [[[179.0, 0.0], [181.0, 0.0], [180.0, 1.0]]]);
        let rectangle = Rectangle {
            west: -180.0,
            south: -90.0,
            east: 180.0,
            north: 90.0,
        };
        let mut corners = Vec::new();
        push(&mut corners, &rectangle, over[0], 7);
        // Where it is, and a turn to the west.
        assert_eq!(corners.len(), 6);
        assert!(corners.iter().all(|corner| corner.id == 7));
        // Negative control: a triangle that does not cross is pushed once.
        let mut corners = Vec::new();
        push(
            &mut corners,
            &rectangle,
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            7,
        );
        assert_eq!(corners.len(), 3);
    }

    #[test]
    fn a_corner_at_a_pole_becomes_a_side_and_a_pole_inside_is_refused() {
        let wedge = unrolled([[10.0, 60.0], [40.0, 60.0], [0.0, 90.0]]).expect("a wedge");
        let area = |t: &[[f64; 2]; 3]| {
            0.5 * ((t[1][0] - t[0][0]) * (t[2][1] - t[0][1])
                - (t[2][0] - t[0][0]) * (t[1][1] - t[0][1]))
        };
        assert_eq!(wedge.iter().map(area).sum::<f64>(), 30.0 * 30.0);
        // Negative control: without a corner there it goes round.
        assert_eq!(unrolled([[0.0, 80.0], [120.0, 80.0], [-120.0, 80.0]]), None);
    }
}
