// SPDX-License-Identifier: MIT OR Apache-2.0
//! A picture's colours in `f64`: against the same texels, filtered alike, which decides; and against the layers as they
//! are published, which says what cube maps, bumps in 8 bits and filters cost.

use super::device::Shading;
use super::layers::{Fragment, Lights, Reads, Sampled, Shade, shade};
use super::sources::Sources;
use super::texels::{Layer, Looked};
use crate::error::shares;
use crate::list::Eye;
use crate::sight::drawn_otherwise;
use glam::{DMat3, DVec3};
use terrafill_reference::SurfaceTriangles;
use terrafill_surface::SurfaceFrame;

/// How far a triangle's corner may be from where it is, along each axis: a device keeps them in steps of 1/256 px.
const SNAPPED_PX: f64 = 1.0 / 256.0;

/// Sine of 85°.
const POLAR_SINE: f64 = 0.996_194_698_091_745_5;

/// How far a shaded picture is off, channels as numbers, 1 being white.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct ShadingErrors {
    /// Of each compared pixel, the largest channel's difference from the same texels.
    pub(super) from_texels: Vec<f64>,
    /// Pixels farther from them than they may be.
    pub(super) beyond: usize,
    /// The same where a layer is exchanged for another, clouds stand still, or it is day at night.
    pub(super) controls: Option<[usize; 3]>,
    /// Of each compared pixel, the largest channel's difference from the layers as published.
    pub(super) all: Vec<f64>,
    /// Within 5° of a pole.
    pub(super) polar: Vec<f64>,
    pub(super) non_finite: usize,
    pub(super) shown: usize,
    /// Pixels that the device draws and rays do not meet, or the other way round, but beside the outline.
    pub(super) otherwise: usize,
}

/// The triangle, relative to the eye, that each pixel's ray meets.
pub(super) struct Met {
    facets: Vec<Option<[DVec3; 3]>>,
}

impl Met {
    pub(super) fn new(eye: &Eye, frame: &SurfaceFrame) -> Self {
        let triangles = SurfaceTriangles::new(frame);
        let facets = eye.by_pixel(|_, _, direction| {
            let hit = triangles.hit_facet(direction, eye.camera.near_m);
            hit.map(|(_, facet)| facet)
        });
        Self { facets }
    }
}

/// What a ray sees of a triangle's plane: normal and direction to the eye are interpolated as the device does.
fn fragment(facet: [DVec3; 3], normals: [DVec3; 3], direction: DVec3) -> Fragment {
    let [a, b, c] = facet;
    let out = (b - a).cross(c - a);
    let at = direction * (a.dot(out) / direction.dot(out));
    let shares = shares(facet, at);
    let mixed = |of: [DVec3; 3]| {
        let terms = of.iter().zip(shares);
        terms.fold(DVec3::ZERO, |sum, (of, share)| sum + *of * share)
    };
    Fragment {
        n: mixed(normals).normalize(),
        to_eye: mixed(facet.map(|corner| -corner)),
    }
}

/// Clouds for lights of night, and the other way round.
struct Exchanged<'a>(&'a Sampled<'a>);

impl Reads for Exchanged<'_> {
    fn read(&self, layer: Layer, n: DVec3) -> Looked {
        let layer = match layer {
            Layer::Clouds => Layer::Night,
            Layer::Night => Layer::Clouds,
            other => other,
        };
        self.0.read(layer, n)
    }

    fn bent(&self, shading: Shading, n: DVec3) -> (DVec3, f64) {
        self.0.bent(shading, n)
    }
}

/// What a pixel must be like, each channel.
struct Allowed {
    least: DVec3,
    most: DVec3,
}

impl Allowed {
    fn has(&self, shown: DVec3) -> bool {
        // What is no number is in no range.
        shown.cmpge(self.least).all() && shown.cmple(self.most).all()
    }

    /// The same width about another colour.
    fn about(&self, colour: DVec3) -> Self {
        let half = 0.5 * (self.most - self.least);
        Self {
            least: colour - half,
            most: colour + half,
        }
    }
}

/// What one pixel is like.
struct Pixel {
    from_texels: f64,
    is_beyond: bool,
    controls: [bool; 3],
    from_sources: f64,
    is_polar: bool,
}

/// The largest channel's difference; NaN if any is.
fn largest(difference: DVec3) -> f64 {
    let off = difference.abs().to_array();
    off.into_iter()
        .fold(0.0, |worst, off| if off <= worst { worst } else { off })
}

/// Compares a picture, by the place that each pixel's ray meets.
///
/// - `controls`: whether wrong layers are tried as well, which must be found
pub(super) fn judge(
    eye: &Eye,
    met: &Met,
    lights: &Lights,
    (sampled, sources): (&Sampled<'_>, &Sources),
    picture: &[[f32; 4]],
    controls: bool,
) -> ShadingErrors {
    let shading = sampled.shading;
    let still = Lights {
        clouds: DMat3::IDENTITY,
        ..*lights
    };
    let antipodal = Lights {
        sun: -lights.sun,
        ..*lights
    };
    let judged = eye.by_pixel(|pixel, centre, direction| {
        let facet = met.facets[pixel]?;
        let [r, g, b, alpha] = picture[pixel].map(f64::from);
        if alpha == 0.0 {
            return None;
        }
        let shown = DVec3::new(r, g, b);
        let normals = facet.map(|corner| normal(eye, corner));
        let here = fragment(facet, normals, direction);
        let Shade { colour, mut doubt } = shade(lights, shading, here, sampled);
        let (mut least, mut most) = (colour, colour);
        for way in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
            let beside = [0, 1].map(|axis| centre[axis] + SNAPPED_PX * way[axis]);
            let direction = eye.camera.direction_ecef(eye.size, beside);
            let beside = shade(
                lights,
                shading,
                fragment(facet, normals, direction),
                sampled,
            );
            doubt = doubt.max(beside.doubt);
            (least, most) = (least.min(beside.colour), most.max(beside.colour));
        }
        let allowed = Allowed {
            least: least - doubt,
            most: most + doubt,
        };
        let controls = if controls {
            let wrong = [
                shade(lights, shading, here, &Exchanged(sampled)),
                shade(&still, shading, here, sampled),
                shade(&antipodal, shading, here, sampled),
            ];
            wrong.map(|wrong| !allowed.about(wrong.colour).has(shown))
        } else {
            [false; 3]
        };
        Some(Pixel {
            from_texels: largest(shown - colour),
            is_beyond: !allowed.has(shown),
            controls,
            from_sources: largest(shown - shade(lights, shading, here, sources).colour),
            is_polar: here.n.z.abs() > POLAR_SINE,
        })
    });
    let is_shown: Vec<bool> = picture.iter().map(|colour| colour[3] != 0.0).collect();
    let is_met: Vec<bool> = met.facets.iter().map(Option::is_some).collect();
    let mut found = ShadingErrors {
        non_finite: picture.iter().filter(|colour| is_lost(colour)).count(),
        shown: is_shown.iter().filter(|is_shown| **is_shown).count(),
        otherwise: drawn_otherwise(eye.size.width as usize, &is_met, &is_shown),
        controls: controls.then_some([0; 3]),
        ..ShadingErrors::default()
    };
    for pixel in judged.into_iter().flatten() {
        found.beyond += usize::from(pixel.is_beyond);
        for (count, is_beyond) in found.controls.iter_mut().flatten().zip(pixel.controls) {
            *count += usize::from(is_beyond);
        }
        if !pixel.from_texels.is_finite() {
            continue;
        }
        found.from_texels.push(pixel.from_texels);
        found.all.push(pixel.from_sources);
        if pixel.is_polar {
            found.polar.push(pixel.from_sources);
        }
    }
    found
}

/// Geodetic normal of a place relative to the eye.
pub(super) fn normal(eye: &Eye, relative_m: DVec3) -> DVec3 {
    let radii = eye.body.radii_m();
    ((eye.camera.eye_ecef + relative_m) / (radii * radii)).normalize()
}

/// Whether a colour is no number.
pub(super) fn is_lost(colour: &[f32; 4]) -> bool {
    colour.iter().any(|channel| !channel.is_finite())
}

/// As pictures show it: what is not finite is magenta.
#[allow(
    clippy::cast_possible_truncation,
    reason = "a share of 255 after clamping"
)]
pub(super) fn bytes(colour: [f32; 4]) -> [u8; 3] {
    if is_lost(&colour) {
        [255, 0, 255]
    } else {
        [0, 1, 2].map(|i| (255.0 * colour[i].clamp(0.0, 1.0)).round() as u8)
    }
}
