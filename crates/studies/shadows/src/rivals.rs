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
use crate::casting::{Casting, Receivers};
use crate::drawing::DeviceDrawn;
use crate::work::Scene;
use terrafill_contract::Devices;
use terrafill_core::nearest_f32;
use terrafill_shadow_views::{DeckCamera, Interface, Positions, count, seen_by};
use terrafill_study::Failure;

/// A triangle counts as over a place where the place is this many pixels below it: where rasterisers round corners to
/// 1/256 of a pixel, depths are no more exact.
pub(crate) const MARGIN_PX: f64 = 1.0 / 256.0;

terrafill_results::named! {
    /// How shadows come about without volumes.
    all pub(crate) enum Rival {
        Tiles = "tiles of triangles",
        Rays = "ray query",
    }
}

impl Rival {
    pub(crate) fn interface(self) -> Interface {
        match self {
            Self::Tiles => Interface::Wgpu,
            Self::Rays => Interface::Vulkan,
        }
    }
}

impl Scene {
    /// Asks a rival in every channel.
    ///
    /// - `margin_px`: [`MARGIN_PX`]
    pub(crate) fn asked_by(
        &self,
        devices: &Devices,
        rival: Rival,
        margin_px: f64,
    ) -> Result<DeviceDrawn, Failure> {
        self.draw_channels(|view, _| {
            let casting = self.casting(view, rival, margin_px);
            seen_by(Positions::Eye, view, self.mesh(), |seen| {
                Ok(match rival {
                    Rival::Tiles => Tiles::open(devices, seen, &casting)?,
                    Rival::Rays => Rays::open(devices, seen, &casting)?,
                })
            })
        })
    }

    fn casting(&self, view: &DeckCamera, rival: Rival, margin_px: f64) -> Casting {
        let mesh = self.mesh();
        let places = mesh.vertices.iter();
        let places = places.map(|place| Positions::Eye.relative(*place, view.eye).extend(1.0));
        let all = (0_u32..).zip(&mesh.triangles);
        // Rays leave out what faces away themselves: another sun then changes nothing that is held.
        let taken = all.filter(|(at, _)| rival == Rival::Rays || self.is_lit(*at as usize));
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
                near_m: nearest_f32(view.near),
                margin: nearest_f32(margin_px * pixel),
                unused: [0; 3],
            },
            places: places.map(|place| place.to_array()).collect(),
            triangles,
        }
    }
}

#[cfg(test)]
mod tests;
