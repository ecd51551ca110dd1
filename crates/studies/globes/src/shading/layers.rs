// SPDX-License-Identifier: MIT OR Apache-2.0
//! A fragment of five layers in `f64`, as `globes/layers.wgsl` shades it in `f32`. How far a device may be off comes from
//! how far it may be off what it looks up.

use super::sources::{Sources, tangent};
use super::texels::{Looked, Pictures};
use super::way::{Layer, Shading};
use crate::list::ShadedRow;
use glam::{DMat3, DVec3};
use std::f64::consts::TAU;

/// Exponent of the highlight.
const SHINE: i32 = 200;
/// Hours in which clouds go round the body.
const CLOUDS_TURN_HOURS: f64 = 240.0;
/// How far `f32` may be off in sums and products of what is at most 2, and in the power, of its value: 200 times what
/// WGSL allows of a logarithm, 2^-21.
const SUMS: f64 = 1e-5;
const POWER: f64 = 1e-3;

/// What all fragments share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lights {
    /// Towards the sun, of length 1.
    pub(crate) sun: DVec3,
    /// By which clouds are looked up.
    pub(crate) clouds: DMat3,
}

impl Lights {
    /// - `hours`: for which clouds have moved to the east
    pub(crate) fn new(view: &ShadedRow, hours: u32) -> Self {
        Self {
            sun: view.sun(),
            clouds: DMat3::from_rotation_z(-TAU * f64::from(hours) / CLOUDS_TURN_HOURS),
        }
    }
}

/// Where a fragment is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fragment {
    /// Geodetic normal, of length 1.
    pub(crate) n: DVec3,
    /// Of any length.
    pub(crate) to_eye: DVec3,
}

/// A colour, and how far a device's may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shade {
    pub(crate) colour: DVec3,
    pub(crate) doubt: DVec3,
}

/// What a fragment reads.
pub(crate) trait Reads {
    /// - `n`: of length 1
    fn read(&self, layer: Layer, n: DVec3) -> Looked;

    /// The bent normal, and how far it may be off.
    fn bent(&self, shading: Shading, n: DVec3) -> (DVec3, f64);
}

/// Texels of a way to shade, as a sampler filters them.
pub(crate) struct Sampled<'a> {
    pub(crate) pictures: &'a Pictures,
    pub(crate) shading: Shading,
}

fn rgb([r, g, b, _]: [f64; 4]) -> DVec3 {
    DVec3::new(r, g, b)
}

impl Reads for Sampled<'_> {
    fn read(&self, layer: Layer, n: DVec3) -> Looked {
        self.pictures.read_by(self.shading)[layer as usize].bilinear(n)
    }

    fn bent(&self, shading: Shading, n: DVec3) -> (DVec3, f64) {
        let Looked { value, doubt } = self.read(Layer::Bumps, n);
        let shares = 2.0 * rgb(value) - 1.0;
        let scale = f64::from(shading.bump_scale);
        let bent = if shading.is_object_space {
            shares
        } else {
            let mut t = tangent(n);
            if shading.removed >= 3 {
                // Without its length made 1 it is as long as the parallel is wide.
                t *= n.x.hypot(n.y);
            }
            shares.x * n + scale * (shares.y * t + shares.z * n.cross(t))
        };
        let doubt = 2.0 * rgb(doubt).length() * scale.max(1.0);
        (bent.normalize(), doubt / bent.length())
    }
}

/// The layers as published, without the cube maps and pictures that are made of them.
impl Reads for Sources {
    fn read(&self, layer: Layer, n: DVec3) -> Looked {
        Looked {
            value: self.value(layer, n),
            doubt: [0.0; 4],
        }
    }

    fn bent(&self, shading: Shading, n: DVec3) -> (DVec3, f64) {
        let bent = self.bent(n);
        // Over its share of the normal it is the normal less the slopes.
        let slopes = bent / bent.dot(n) - n;
        let scaled = n + f64::from(shading.bump_scale) * slopes;
        (scaled.normalize(), 0.0)
    }
}

/// A fragment's colour with what a way to shade leaves in, without its faults.
pub(crate) fn shade(
    lights: &Lights,
    shading: Shading,
    Fragment { n, to_eye }: Fragment,
    layers: &impl Reads,
) -> Shade {
    let removed = shading.removed;
    if removed >= 6 {
        return Shade {
            colour: DVec3::ONE,
            doubt: DVec3::splat(SUMS),
        };
    }
    let base = layers.read(Layer::Base, n);
    let (m, bend) = if removed < 4 {
        layers.bent(shading, n)
    } else {
        (n, 0.0)
    };
    let light = m.dot(lights.sun).clamp(0.0, 1.0);
    let mut colour = rgb(base.value) * light;
    let mut doubt = SUMS + rgb(base.doubt) * light + rgb(base.value) * bend;
    if removed < 5 {
        let half_way = m.dot((lights.sun + to_eye.normalize()).normalize());
        let shine = |at: f64| at.clamp(0.0, 1.0).powi(SHINE);
        let (least, here, most) = (
            shine(half_way - bend),
            shine(half_way),
            shine(half_way + bend),
        );
        let (water, of_water) = (base.value[3], base.doubt[3]);
        colour += here * water;
        doubt += (most - here).max(here - least) * water + most * of_water + POWER * most * water;
    }
    let level = n.dot(lights.sun).clamp(0.0, 1.0);
    if removed < 1 {
        let clouds = layers.read(Layer::Clouds, lights.clouds * n);
        colour += rgb(clouds.value) * level;
        doubt += rgb(clouds.doubt) * level;
    }
    if removed < 2 {
        let night = layers.read(Layer::Night, n);
        let dark = 1.0 - (10.0 * level).clamp(0.0, 1.0);
        colour += rgb(night.value) * dark;
        doubt += rgb(night.doubt) * dark;
    }
    Shade { colour, doubt }
}
