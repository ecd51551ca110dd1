// SPDX-License-Identifier: MIT OR Apache-2.0
//! The reference: which lights reach a pixel, by rays in `f64`.
//!
//! A map says of a texel what is nearest to its light along the ray through the texel's middle. So the ray that is
//! followed is that one, from as far above the place as the bias. What a map shows is right or wrong,
//! apart from a band of 1/32 of a pixel and of a texel, as devices snap vertices. Whether the place itself is in
//! shadow, without any map, is counted beside it.

use super::scene::{CENTRE, DistantLight, RADIUS_M, bias_m, texel_m};
use glam::{DVec2, DVec3};
use terrafill_shapes::rays::{BAND_PX, Judged, Rays, around};

/// Of depths in a map, metres: f32 rounds 3 km to 1e-4 m, a few times in a row.
pub(super) const DEPTH_BAND_M: f64 = 2e-2;
/// Off the ground that a place lies on, metres.
pub(super) const OFF_GROUND_M: f64 = 1e-2;

/// A picture held against rays.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct JudgedLights {
    pub(crate) judged: Judged,
    /// Lights of pixels that were looked at, and those among them whose shadow differs from a ray from the place
    /// itself: the error of the map.
    pub(crate) looked_at: usize,
    pub(crate) map_differs: usize,
    /// Lights of those pixels that do not reach them.
    pub(crate) shadowed: usize,
}

/// What lights reach, for rays.
pub(crate) struct LitRays<'a> {
    pub(crate) rays: Rays<'a>,
    pub(crate) lights: &'a [DistantLight],
    /// A side of the maps, texels.
    pub(crate) side: u32,
}

impl LitRays<'_> {
    /// Holds every so many pixels of a picture of masks, plus 1, against rays.
    pub(crate) fn judge(&self, numbers: &[u32], every: usize) -> JudgedLights {
        let mut all = JudgedLights::default();
        for (pixel, at) in self.rays.centres().enumerate().step_by(every) {
            let shown = numbers[pixel];
            let place = self.rays.place(at);
            let truth = place.map_or(0, |place| 1 + self.mask(place));
            all.judged.add(shown, truth, || self.may_show(at, shown));
            let (Some(place), true) = (place, shown > 0) else {
                continue;
            };
            for (number, light) in self.lights.iter().enumerate() {
                let is_lit = (shown - 1) >> number & 1 == 1;
                let from = place + light.toward * OFF_GROUND_M;
                all.looked_at += 1;
                all.shadowed += usize::from(!is_lit);
                all.map_differs += usize::from(self.rays.hits(from, light.toward) == is_lit);
            }
        }
        all
    }

    /// Which lights a map lets through to a place.
    fn mask(&self, place: DVec3) -> u32 {
        let lights = self.lights.iter().enumerate();
        lights.fold(0, |mask, (number, light)| {
            let middle = middle(self.on_map(light, place));
            mask | u32::from(self.is_lit(light, place, middle, 0.0)) << number
        })
    }

    /// Depth of a place in a map, from 0 to 1.
    pub(super) fn depth(&self, light: &DistantLight, place: DVec3) -> f64 {
        0.5 * (place - CENTRE).dot(light.toward) / RADIUS_M + 0.5
    }

    /// Texels across and upwards.
    pub(super) fn on_map(&self, light: &DistantLight, place: DVec3) -> DVec2 {
        let from = place - CENTRE;
        let at = DVec2::new(from.dot(light.right), from.dot(light.up)) / RADIUS_M;
        (0.5 * at + 0.5) * f64::from(self.side)
    }

    /// Whether nothing hides what lies on the ray through a place of the map, as near to the light as `place`.
    fn is_lit(&self, light: &DistantLight, place: DVec3, texel: DVec2, nearer_m: f64) -> bool {
        let off = (texel - self.on_map(light, place)) * texel_m(self.side);
        let shifted = place + light.right * off.x + light.up * off.y;
        let above = bias_m(self.side) + nearer_m;
        !self.rays.hits(shifted + light.toward * above, light.toward)
    }

    /// Whether each light may be shown as it is by a place within the band of the pixel's middle.
    fn may_show(&self, at: DVec2, shown: u32) -> bool {
        let ring = around(BAND_PX);
        let places: Vec<Option<DVec3>> = ring.map(|off| self.rays.place(at + off)).collect();
        if shown == 0 {
            return places.contains(&None);
        }
        let known = |number: usize, light: &DistantLight| {
            let is_lit = (shown - 1) >> number & 1 == 1;
            places.iter().flatten().any(|place| {
                let on_map = self.on_map(light, *place);
                around(BAND_PX).any(|off| {
                    let middle = middle(on_map + off);
                    around(BAND_PX).any(|edge| {
                        [-DEPTH_BAND_M, DEPTH_BAND_M].iter().any(|nearer_m| {
                            self.is_lit(light, *place, middle + edge, *nearer_m) == is_lit
                        })
                    })
                })
            })
        };
        let mut lights = self.lights.iter().enumerate();
        (shown - 1) >> self.lights.len() == 0 && lights.all(|(number, light)| known(number, light))
    }
}

/// Of the texel that a place of the map lies in.
fn middle(at: DVec2) -> DVec2 {
    at.floor() + 0.5
}
