// SPDX-License-Identifier: MIT OR Apache-2.0
//! The port as devices draw it: sea and casters are a surface, and a stencil program counts the volumes.
//!
//! The origin is laid on the north pole of a sphere, so that ENU axes are the body's. A caster's lit
//! triangles are drawn twice, as surface and as light cap. Both take the same `f32` numbers with the corners
//! in the same order, so that their depths are equal: equal depth fails.

use crate::count::{Rule, Wrong};
use crate::device::{Draws, Interface, VolumeSource};
use crate::loading::{Loadable, listed, program};
use crate::near::EyeTest;
use crate::reference::{Light, Reference, SEA_RADIUS_M, Truth};
use crate::scissor::Rectangle;
use crate::sea::surface;
use crate::silhouettes::Silhouettes;
use crate::view::View;
use crate::work::{End, Scene};
use glam::{DMat3, DVec3, Vec3};
use std::cell::LazyCell;
use terrafill_casters::Volume;
use terrafill_core::{Ellipsoid, VolumeHeights};
use terrafill_fill::{
    ColourWay, DepthRuleChoice, DeviceError, Devices, FacePasses, FixedPoint, Frame, Picture,
    PositionFormat, StencilWork, SurfaceView, Switches, ViewId, VolumeConstants, VolumeList,
    VolumePlace, mask_hash,
};
use terrafill_scene::{Camera, ImageSize};

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

    pub(crate) fn relative(self, place: DVec3, eye: DVec3) -> Vec3 {
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
    pub(crate) counting: Counting,
    /// Fragments count only where the surface's depth is in a caster's range.
    pub(crate) has_bounds: bool,
}

/// What is counted together, and who chooses the rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Counting {
    /// All casters, by [`DeviceWay::rule`].
    Casters,
    /// All parts, z-fail for those that a test chooses and z-pass for the others.
    Chosen(EyeTest),
    /// All casters by z-pass, the near plane's own count drawn beside them.
    ZpPlus,
    /// Each part for itself by [`DeviceWay::rule`], in passes of 255 or all at once.
    Parts { is_guarded: bool },
}

impl DeviceWay {
    /// As rows have it.
    pub(crate) fn rule_name(self) -> String {
        match self.counting {
            Counting::Chosen(test) => format!("automatic, {}", test.name()),
            Counting::ZpPlus => "zp-plus".to_owned(),
            Counting::Casters | Counting::Parts { .. } => self.rule.name().to_owned(),
        }
    }

    fn switches(self) -> Switches {
        Switches {
            colour: ColourWay::OneColour,
            faces: self.faces,
            depth_rule: match (self.counting, self.rule) {
                (Counting::Chosen(_), _) => DepthRuleChoice::Automatic,
                (Counting::ZpPlus, _) | (_, Rule::Pass | Rule::Preload) => DepthRuleChoice::Pass,
                _ => DepthRuleChoice::Fail,
            },
            depth_bounds: self.has_bounds,
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
        let found = self.found_by(way, &volume)?;
        let reference = LazyCell::new(|| Reference::new(mesh, self.to_light));
        let mut all = Vec::new();
        for (at, (view, truth)) in self.channels.iter().enumerate() {
            let loadable = match &found {
                None => self.loadable(way, view, &volume, closed.as_ref(), &reference)?,
                Some(found) => {
                    let casters = 0..mesh.casters.len();
                    let whole = Rectangle::whole(view);
                    Loadable {
                        list: casters.map(|caster| listed(whole, caster)).collect(),
                        source: self.seen_from(view, found),
                        left_out: 0,
                    }
                }
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
        let program = program(way, &switches, &loadable.list)?;
        let constants = constants(&camera, loadable.list.len());
        let mut constants = bytemuck::cast_slice(&constants).to_vec();
        if let VolumeSource::Adjacent(own) = &loadable.source {
            constants.extend_from_slice(bytemuck::cast_slice(&own.words_behind(constants.len())));
        }
        let work = StencilWork {
            list: VolumeList {
                view_id: id,
                size,
                volumes: loadable.list,
            },
            program,
            constants,
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

/// Vertices of volumes as this eye has them: bits of `f32`.
pub(crate) fn eye_vertices(positions: Positions, view: &View, volume: &Volume) -> Vec<[u32; 4]> {
    let places = volume.vertices.iter().map(|place| {
        let is_place = place.w > 0.0;
        let along = match is_place {
            true => positions.relative(place.truncate(), view.eye),
            false => place.truncate().as_vec3(),
        };
        let w = f32::from(u8::from(is_place));
        along.extend(w).to_array().map(f32::to_bits)
    });
    places.collect()
}

pub(crate) fn count(length: usize) -> u32 {
    u32::try_from(length).unwrap_or(u32::MAX)
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
