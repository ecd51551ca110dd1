// SPDX-License-Identifier: MIT OR Apache-2.0
//! The port as devices draw it: sea and casters are a surface, and a stencil program counts the volumes.
//!
//! The origin is laid on the north pole of a sphere, so that ENU axes are the body's. A caster's lit
//! triangles are drawn twice, as surface and as light cap. Both take the same `f32` numbers with the corners
//! in the same order, so that their depths are equal: equal depth fails.

use crate::count::{Rule, Wrong};
use crate::device::{Draws, EyeMesh, EyeVolumes, IS_CAP, Interface, VolumeSource};
use crate::reference::{Light, Reference, SEA_RADIUS_M, Truth};
use crate::scissor::{Rectangle, of_parts};
use crate::view::View;
use crate::work::{End, Scene};
use glam::{DMat3, DVec3, Vec3};
use std::cell::LazyCell;
use terrafill_casters::{EdgeTable, Mesh, Volume};
use terrafill_core::{Ellipsoid, VolumeHeights};
use terrafill_fill::{
    ColourWay, DepthRange, DepthRuleChoice, DeviceError, Devices, FacePasses, FillProgram,
    FixedPoint, Frame, Picture, PositionFormat, StencilWork, SurfaceView, Switches, ViewId,
    VolumeConstants, VolumeList, VolumePlace, mask_hash,
};
use terrafill_scene::{Camera, HeightRange, ImageSize, Overlap, PixelRect};
use terrafill_surface::SurfaceFrame;

/// Between meridians of the sea's patch, degrees.
const SECTOR_DEG: f64 = 1.0;
/// Radius of a ring of the patch over that of the one before. At 5 km a facet is 5 mm below the sphere, a
/// ten-thousandth of a pixel.
const RING_RATIO: f64 = 1.1;

/// What the numbers of vertices count from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Positions {
    /// The eye: subtracted in `f64`, then rounded.
    Eye,
    /// An origin so many metres from the port: rounded to `f32`, then the eye subtracted, as rounded.
    World(f64),
}

impl Positions {
    pub(crate) fn name(self) -> String {
        match self {
            Self::Eye => "from the eye".to_owned(),
            Self::World(m) => format!("f32, origin {} km away", m / 1e3),
        }
    }

    fn relative(self, place: DVec3, eye: DVec3) -> Vec3 {
        match self {
            Self::Eye => (place - eye).as_vec3(),
            Self::World(m) => {
                // Along no axis, as places on a planet lie.
                let port = DVec3::ONE.normalize() * m;
                (port + place).as_vec3() - (port + eye).as_vec3()
            }
        }
    }
}

/// Where silhouettes are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Silhouettes {
    /// By the CPU from stored adjacency: volumes are handed over.
    Adjacency,
    /// By the vertex shader: meshes, edges and facing bits are handed over.
    Pulled,
}

impl Silhouettes {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Adjacency => "adjacency",
            Self::Pulled => "pulled",
        }
    }
}

/// How a device draws volumes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DeviceWay {
    pub(crate) interface: Interface,
    pub(crate) silhouettes: Silhouettes,
    pub(crate) positions: Positions,
    pub(crate) end: End,
    pub(crate) rule: Rule,
    pub(crate) faces: FacePasses,
    /// Each caster is cut to its rectangle, and left out where that is empty.
    pub(crate) is_cut: bool,
}

impl DeviceWay {
    fn switches(self) -> Switches {
        Switches {
            colour: ColourWay::OneColour,
            faces: self.faces,
            depth_rule: match self.rule {
                Rule::Pass => DepthRuleChoice::Pass,
                _ => DepthRuleChoice::Fail,
            },
            scissor: self.is_cut,
            ..Switches::default()
        }
    }
}

/// What a device drew, over all channels.
#[derive(Default)]
pub(crate) struct DeviceDrawn {
    pub(crate) wrong: Wrong,
    /// Shadow pixels of the reference that are lit, in the band too.
    pub(crate) lost: usize,
    pub(crate) draws: u64,
    /// Of volumes; `None` where the device does not count them.
    pub(crate) fragments: Option<u64>,
    /// Of the volumes' source in a channel, and of it what another sun changes.
    pub(crate) bytes: [u64; 2],
    /// Casters times channels that were not drawn.
    pub(crate) left_out: usize,
    pub(crate) volume_triangles: usize,
    /// Of all channels' masks.
    pub(crate) mask_hash: String,
    /// The channel with the most shadow, ready to be timed, and its mask.
    pub(crate) darkest: Option<(Box<dyn Draws>, Vec<bool>)>,
}

/// What a channel's program runs on.
struct Loadable {
    source: VolumeSource,
    list: Vec<terrafill_fill::Volume>,
    left_out: usize,
}

impl Scene {
    /// Draws every channel by a device.
    ///
    /// # Errors
    /// Of the device; or that there is no such volume.
    pub(crate) fn drawn_by(
        &self,
        devices: &Devices,
        way: DeviceWay,
    ) -> Result<DeviceDrawn, DrawError> {
        let volume = self.volume(way.end).map_err(|error| error.to_string())?;
        // A rectangle holds the volume closed at the sea, wherever the one that is drawn ends.
        let closed = match way.is_cut {
            true => Some(self.volume(End::Sea).map_err(|error| error.to_string())?),
            false => None,
        };
        let darkest = self.darkest_channel().ok_or("no channel")?;
        let mut drawn = DeviceDrawn {
            volume_triangles: volume.triangles.len(),
            fragments: Some(0),
            ..DeviceDrawn::default()
        };
        let mesh = self.mesh();
        let pulled = match way.silhouettes {
            Silhouettes::Adjacency => None,
            Silhouettes::Pulled => Some(self.pulled()?),
        };
        let reference = LazyCell::new(|| Reference::new(mesh, self.to_light));
        let mut all = Vec::new();
        for (at, (view, truth)) in self.channels.iter().enumerate() {
            let loadable = match &pulled {
                None => loadable(way.positions, view, mesh, &volume, closed.as_ref()),
                Some(pulled) => self.seen_from(view, pulled.clone()),
            };
            let bytes = loadable.source.bytes();
            drawn.bytes = [0, 1].map(|at| drawn.bytes[at].max(bytes[at]));
            drawn.left_out += loadable.left_out;
            let mut channel = self.open(devices, way, view, loadable)?;
            let (counters, picture) = channel.draw()?;
            let mask = mask(&picture);
            let is_rim = |at, light| self.is_within_rounding(&reference, view, at, light);
            let wrong = Wrong::but_at_rims(&mask, truth, is_rim);
            drawn.wrong = drawn.wrong.plus(wrong);
            drawn.lost += lost(&mask, truth);
            drawn.draws += counters.draws;
            let fragments = drawn.fragments.zip(counters.stencil_fragments);
            drawn.fragments = fragments.map(|(before, own)| before + own);
            // What is sky has no shadow, whatever the count there.
            let of_receivers = mask.iter().zip(&truth.light);
            all.extend(of_receivers.map(|(dark, light)| *dark && *light != Light::Sky));
            if at == darkest {
                drawn.darkest = Some((channel, mask));
            }
        }
        drawn.mask_hash = hash(&all);
        Ok(drawn)
    }

    /// Casters for a shader that finds their silhouettes; no place yet, since places are the eye's.
    fn pulled(&self) -> Result<EyeMesh, DrawError> {
        let mesh = self.mesh();
        let edges = EdgeTable::of(mesh).pairs();
        let edges = edges.ok_or_else(|| {
            let needs = "pulled silhouettes: found an edge without two triangles, one either way; allowed: closed meshes";
            DrawError::Unfit(needs.to_owned())
        })?;
        let part_of = mesh.part_of_triangles();
        let mut sides: Vec<Vec<[u32; 4]>> = vec![Vec::new(); mesh.parts.len()];
        for ([low, high], [forward, backward]) in edges {
            sides[part_of[forward as usize] as usize].push([low, high, forward, backward]);
        }
        let mut pulled = EyeMesh {
            lit: self.lit_bits(),
            ..EyeMesh::default()
        };
        for caster in &mesh.casters {
            let first = count(pulled.pieces.len());
            for part in caster.parts.clone() {
                let caps = mesh.parts[part].triangles.clone();
                let cap = |triangle: usize| {
                    let [a, b, c] = mesh.triangles[triangle];
                    [a, b, c, count(triangle) | IS_CAP]
                };
                pulled.pieces.extend(caps.map(cap));
                pulled.pieces.append(&mut sides[part]);
            }
            pulled.ranges.push(first..count(pulled.pieces.len()));
        }
        Ok(pulled)
    }

    fn seen_from(&self, view: &View, mut pulled: EyeMesh) -> Loadable {
        let places = self.mesh().vertices.iter();
        let places = places.map(|place| (place - view.eye).as_vec3().extend(1.0));
        let far = (-self.to_light).as_vec3().extend(0.0);
        let all = places.chain([far]).map(|place| place.to_array());
        pulled.places = all.collect();
        let casters = 0..pulled.ranges.len();
        Loadable {
            list: casters
                .map(|caster| listed(Rectangle::whole(view), caster))
                .collect(),
            source: VolumeSource::Pulled(pulled),
            left_out: 0,
        }
    }

    fn open(
        &self,
        devices: &Devices,
        way: DeviceWay,
        view: &View,
        loadable: Loadable,
    ) -> Result<Box<dyn Draws>, DrawError> {
        let body = Ellipsoid::new("sea", SEA_RADIUS_M, SEA_RADIUS_M).ok_or("no sphere")?;
        let camera = camera(view);
        let surface = surface(way.positions, view, self.mesh());
        let id = ViewId::unique();
        let size = ImageSize {
            width: view.size[0],
            height: view.size[1],
        };
        let seen = SurfaceView {
            id,
            body: &body,
            camera: &camera,
            size,
            surface: &surface,
        };
        let switches = way.switches();
        let program = FillProgram::new(&loadable.list, &switches, Overlap::Ordered)?;
        let constants = constants(&camera, loadable.list.len());
        let work = StencilWork {
            list: VolumeList {
                view_id: id,
                size,
                volumes: loadable.list,
            },
            program,
            constants: bytemuck::cast_slice(&constants).to_vec(),
            blends: false,
        };
        let interface = way.interface;
        Ok(interface.open(devices, &switches, seen, loadable.source, work)?)
    }
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub(crate) enum DrawError {
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// What is drawn is not for that way.
    #[error("{0}")]
    Unfit(String),
    #[error("{0}")]
    Other(String),
}

impl From<String> for DrawError {
    fn from(message: String) -> Self {
        Self::Other(message)
    }
}

impl From<&str> for DrawError {
    fn from(message: &str) -> Self {
        Self::Other(message.to_owned())
    }
}

fn camera(view: &View) -> Camera {
    Camera {
        eye_ecef: view.eye + DVec3::Z * SEA_RADIUS_M,
        view_from_ecef: DMat3::from_cols(view.right, view.up, -view.forward).transpose(),
        fov_y_rad: 2.0 * view.tan[1].atan(),
        near_m: view.near,
    }
}

/// Sea and casters from the eye.
fn surface(positions: Positions, view: &View, mesh: &Mesh) -> SurfaceFrame {
    let (sea, sea_triangles) = sea(view);
    let all = mesh.vertices.iter().chain(&sea);
    let vertices = all.map(|place| positions.relative(*place, view.eye).to_array());
    let first = count(mesh.vertices.len());
    let of_sea = sea_triangles
        .into_iter()
        .map(|corners| corners.map(|corner| corner + first));
    SurfaceFrame {
        vertices_rte: vertices.collect(),
        triangles: mesh.triangles.iter().copied().chain(of_sea).collect(),
        heights: HeightRange {
            lowest_m: 0.0,
            highest_m: 0.0,
        },
        parts: [].into(),
    }
}

/// The sea in sight of a level camera, as rings about the foot of the eye.
fn sea(view: &View) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let centre = DVec3::NEG_Z * SEA_RADIUS_M;
    let up = (view.eye - centre).normalize();
    let height_m = (view.eye - centre).length() - SEA_RADIUS_M;
    let ahead = (view.forward - up * up.dot(view.forward)).normalize();
    let right = ahead.cross(up);
    let horizon_m = (2.0 * SEA_RADIUS_M * height_m).sqrt();
    let mut away_m = vec![0.5 * height_m];
    while away_m.last().is_some_and(|last| *last < 1.2 * horizon_m) {
        away_m.extend(away_m.last().map(|last| last * RING_RATIO));
    }
    let half_deg = view.tan[0].atan().to_degrees() + SECTOR_DEG;
    let mut azimuths_deg = vec![-half_deg];
    while azimuths_deg.last().is_some_and(|last| *last < half_deg) {
        azimuths_deg.extend(azimuths_deg.last().map(|last| last + SECTOR_DEG));
    }
    let mut places = Vec::with_capacity(away_m.len() * azimuths_deg.len());
    for away in &away_m {
        let (sin, cos) = (away / SEA_RADIUS_M).sin_cos();
        for azimuth in &azimuths_deg {
            let (aside, along) = azimuth.to_radians().sin_cos();
            let direction = up * cos + (ahead * along + right * aside) * sin;
            places.push(centre + direction * SEA_RADIUS_M);
        }
    }
    let [columns, rings] = [azimuths_deg.len(), away_m.len()].map(count);
    let mut triangles = Vec::new();
    for ring in 1..rings {
        for column in 1..columns {
            let [near, far] = [ring - 1, ring].map(|ring| ring * columns + column);
            triangles.push([near - 1, near, far]);
            triangles.push([near - 1, far, far - 1]);
        }
    }
    (places, triangles)
}

/// Each caster's volume as this eye sees it.
///
/// - `closed`: what rectangles are made of, where volumes are cut
fn loadable(
    positions: Positions,
    view: &View,
    mesh: &Mesh,
    volume: &Volume,
    closed: Option<&Volume>,
) -> Loadable {
    let places = volume.vertices.iter().map(|place| {
        let is_place = place.w > 0.0;
        let along = match is_place {
            true => positions.relative(place.truncate(), view.eye),
            false => place.truncate().as_vec3(),
        };
        let w = f32::from(u8::from(is_place));
        along.extend(w).to_array().map(f32::to_bits)
    });
    let mut volumes = EyeVolumes {
        vertices: places.collect(),
        ..EyeVolumes::default()
    };
    let (mut list, mut left_out) = (Vec::new(), 0);
    let rectangles = closed.map(|closed| of_parts(view, closed, mesh.parts.len()));
    let mut of_parts: Vec<Vec<u32>> = vec![Vec::new(); mesh.parts.len()];
    for triangle in &volume.triangles {
        of_parts[triangle.part as usize].extend(triangle.corners);
    }
    for caster in &mesh.casters {
        let own = caster.parts.clone();
        let rectangle = match &rectangles {
            Some(all) => all[own.clone()]
                .iter()
                .copied()
                .fold(Rectangle::NONE, Rectangle::or),
            None => Rectangle::whole(view),
        };
        if rectangle.is_empty() {
            left_out += 1;
            continue;
        }
        let indices = &mut volumes.indices;
        let first = count(indices.len());
        indices.extend(of_parts[own].iter().flatten());
        list.push(listed(rectangle, volumes.ranges.len()));
        let range = first..count(indices.len());
        volumes.ranges.push(range);
    }
    Loadable {
        source: VolumeSource::Volumes(volumes),
        list,
        left_out,
    }
}

fn count(length: usize) -> u32 {
    u32::try_from(length).unwrap_or(u32::MAX)
}

/// A caster's volume.
fn listed(rectangle: Rectangle, geometry: usize) -> terrafill_fill::Volume {
    terrafill_fill::Volume {
        is_flat: false,
        screen_rect: PixelRect {
            left: rectangle.columns[0],
            top: rectangle.rows[0],
            right: rectangle.columns[1],
            bottom: rectangle.rows[1],
        },
        depth: DepthRange::ANY,
        // The case names its depth rule; only `DepthRuleChoice::Automatic` reads this.
        near_plane_meets_volume: false,
        geometry,
    }
}

/// What the cover reads of each volume, and of an empty list one all the same: its colour.
fn constants(camera: &Camera, volumes: usize) -> Vec<VolumeConstants> {
    let place = VolumePlace {
        fixed: FixedPoint {
            origin_ecef: camera.eye_ecef,
            unit_m: 1.0,
        },
        first_vertex: 0,
        first_triangle_index: 0,
        first_loop_index: 0,
        triangle_count: 0,
        has_short_indices: false,
    };
    let heights = VolumeHeights {
        top_m: 0.0,
        bottom_m: 0.0,
    };
    let dark = [0.05, 0.06, 0.1, 1.0];
    let one = VolumeConstants::new(
        camera.eye_ecef,
        &place,
        heights,
        PositionFormat::Fixed,
        dark,
    );
    vec![one; volumes.max(1)]
}

/// Pixels that the cover coloured.
fn mask(picture: &Picture) -> Vec<bool> {
    let pixels = picture.rgba.chunks_exact(4);
    pixels.map(|pixel| pixel[3] != 0).collect()
}

fn lost(mask: &[bool], truth: &Truth) -> usize {
    let pixels = mask.iter().zip(&truth.light);
    pixels
        .filter(|(is_dark, light)| !**is_dark && **light == Light::Shadow)
        .count()
}

fn hash(mask: &[bool]) -> String {
    mask_hash(&Frame {
        size: ImageSize {
            width: count(mask.len()),
            height: 1,
        },
        ids: mask.iter().map(|is_dark| u32::from(*is_dark)).collect(),
        surface: vec![true; mask.len()],
        non_finite: 0,
        counters: None,
        texture: None,
    })
}
