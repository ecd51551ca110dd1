// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rivals of shadow volumes that are exact up to the depths of what is seen.
//!
//! One is a hierarchy of tiles into which each lit triangle descends (Sintorn, Olsson & Assarsson, 2011), by compute
//! on wgpu. The other is a ray from each pixel to the sun, by the ray queries of Vulkan.
//!
//! Both are handed the depth that the surface left, as numbers in a buffer, and say of each pixel whether a triangle
//! that faces the sun lies over it. They need no silhouette, no closed mesh, no test of the near plane, and count
//! nothing. Places are `f32` from the eye.

mod on_vulkan;
mod on_wgpu;

use self::on_vulkan::Rays;
use self::on_wgpu::Tiles;
use crate::casting::{Asks, Casting, Receivers};
use crate::count::Wrong;
use crate::drawing::{hash, lost};
use crate::reference::{Light, Reference};
use crate::view::View;
use crate::way::{DrawError, Positions, count};
use crate::work::Scene;
use std::cell::LazyCell;
use terrafill_fill::{Devices, SurfaceView};

/// A triangle counts as over a place where the place is this many pixels below it: where rasterisers round corners to
/// 1/256 of a pixel, depths are no more exact.
const MARGIN_PX: f64 = 1.0 / 256.0;

/// How shadows come about without volumes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rival {
    Tiles,
    Rays,
}

impl Rival {
    pub(crate) const ALL: [Self; 2] = [Self::Tiles, Self::Rays];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Tiles => "tiles of triangles",
            Self::Rays => "ray query",
        }
    }

    pub(crate) fn api(self) -> &'static str {
        match self {
            Self::Tiles => terrafill_gpu::API.name,
            Self::Rays => terrafill_vulkan::API.name,
        }
    }

    /// Whether a triangle that faces away is handed over too: rays leave it out themselves, and another sun then
    /// changes nothing that is held.
    fn takes_all(self) -> bool {
        self == Self::Rays
    }
}

/// What a rival came to, over all channels.
#[derive(Default)]
pub(crate) struct Asked {
    pub(crate) wrong: Wrong,
    /// Shadow pixels of the reference that are lit, in the band too.
    pub(crate) lost: usize,
    /// Of a channel, the largest.
    pub(crate) bytes: [u64; 2],
    pub(crate) build_ms: Option<f64>,
    pub(crate) mask_hash: String,
    /// The channel with the most shadow, and its mask.
    pub(crate) darkest: Option<(Box<dyn Asks>, Vec<bool>)>,
}

impl Scene {
    /// Asks a rival in every channel.
    ///
    /// # Errors
    /// Of the device.
    pub(crate) fn asked_by(&self, devices: &Devices, rival: Rival) -> Result<Asked, DrawError> {
        self.asked_with(devices, rival, MARGIN_PX)
    }

    fn asked_with(
        &self,
        devices: &Devices,
        rival: Rival,
        margin_px: f64,
    ) -> Result<Asked, DrawError> {
        let darkest = self.darkest_channel().ok_or("no channel")?;
        let reference = LazyCell::new(|| Reference::new(self.mesh(), self.to_light));
        let mut asked = Asked::default();
        let mut all = Vec::new();
        for (at, (view, truth)) in self.channels.iter().enumerate() {
            let casting = self.casting(view, rival, margin_px);
            let open = |seen: SurfaceView<'_>| -> Result<Box<dyn Asks>, DrawError> {
                Ok(match rival {
                    Rival::Tiles => Box::new(Tiles::new(devices, seen, &casting)?),
                    Rival::Rays => Box::new(Rays::new(devices, seen, &casting)?),
                })
            };
            let mut channel = self.seen_by(Positions::Eye, view, open)?;
            let mask = channel.mask()?;
            let is_rim = |at, light| self.is_within_rounding(&reference, view, at, light);
            asked.wrong = asked.wrong.plus(Wrong::but_at_rims(&mask, truth, is_rim));
            asked.lost += lost(&mask, truth);
            let bytes = channel.bytes();
            asked.bytes = [0, 1].map(|at| asked.bytes[at].max(bytes[at]));
            let of_receivers = mask.iter().zip(&truth.light);
            all.extend(of_receivers.map(|(dark, light)| *dark && *light != Light::Sky));
            if at == darkest {
                asked.build_ms = channel.build_ms();
                asked.darkest = Some((channel, mask));
            }
        }
        asked.mask_hash = hash(&all);
        Ok(asked)
    }

    #[allow(clippy::cast_possible_truncation, reason = "a device has f32")]
    fn casting(&self, view: &View, rival: Rival, margin_px: f64) -> Casting {
        let mesh = self.mesh();
        let places = mesh.vertices.iter();
        let places = places.map(|place| Positions::Eye.relative(*place, view.eye).extend(1.0));
        let all = (0_u32..).zip(&mesh.triangles);
        let taken = all.filter(|(at, _)| rival.takes_all() || self.is_lit(*at as usize));
        let triangles: Vec<[u32; 4]> = taken.map(|(at, [a, b, c])| [*a, *b, *c, at]).collect();
        let axis = |axis: glam::DVec3| axis.as_vec3().extend(0.0).to_array();
        let pixel = 2.0 * view.tan[0] / f64::from(view.size[0]);
        Casting {
            receivers: Receivers {
                right: axis(view.right * view.tan[0]),
                up: axis(view.up * view.tan[1]),
                ahead: axis(view.forward),
                to_light: axis(self.to_light),
                size: view.size,
                triangles: count(triangles.len()),
                near_m: view.near as f32,
                margin: (margin_px * pixel) as f32,
                unused: [0; 3],
            },
            places: places.map(|place| place.to_array()).collect(),
            triangles,
        }
    }
}

#[cfg(test)]
mod tests;
