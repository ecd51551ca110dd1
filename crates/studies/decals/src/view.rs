// SPDX-License-Identifier: MIT OR Apache-2.0
//! From where data is seen, and by which projection: places to the picture and back, in `f64`.
//!
//! Metres from the body's centre, along its axes. Clip space has depth reversed: 1 at the near plane, 0 far away.

use crate::place::{RADIUS_M, angles, axes, direction};
use glam::{DVec2, DVec3, DVec4};
use std::f64::consts::{FRAC_PI_2, PI};
use terrafill_maps::{HALF_RIM, dome, hyperbolic_polar};
use terrafill_shapes::grid::GridCamera;

terrafill_results::named! {
    /// A projection of Gebbie and Bailey.
    all pub(crate) enum Projection {
        Globe = "globe",
        Flat = "flat",
        Hyperbolic = "hyperbolic",
        Dome = "dome",
    }
}

/// How far from the focus half of a hyperbolic map's rim is reached, radii.
pub(crate) const REACH: f64 = HALF_RIM;
/// Half the field of view: 30°.
const TAN_HALF: f64 = 0.577_350_269_189_625_8;
/// Near plane over the eye's height.
const NEAR_SHARE: f64 = 0.1;

/// An eye over the body, and a picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Eye {
    pub(crate) camera: GridCamera,
    pub(crate) projection: Projection,
    /// Longitude and latitude of the place below it, which maps are about; radians.
    pub(crate) focus: DVec2,
    pub(crate) height_m: f64,
    /// A side, pixels.
    pub(crate) side: u32,
}

impl Eye {
    /// Looks at a place.
    ///
    /// - `target`: longitude and latitude of the place, radians
    /// - `away`: how far south of it the eye is, radians
    pub(crate) fn new(target: DVec2, away: f64, height_m: f64, side: u32) -> Self {
        let [_, north, up] = axes(target);
        let below = up * away.cos() - north * away.sin();
        let eye = below * (RADIUS_M + height_m);
        Self {
            camera: GridCamera::looking(eye, up * RADIUS_M, TAN_HALF),
            projection: Projection::Globe,
            focus: angles(below),
            height_m,
            side,
        }
    }

    pub(crate) fn size(&self) -> [u32; 2] {
        [self.side; 2]
    }

    /// Metres.
    pub(crate) fn near_m(&self) -> f64 {
        NEAR_SHARE * self.height_m
    }

    /// Pixels of a step of 1 in clip space.
    pub(crate) fn half_px(&self) -> f64 {
        0.5 * f64::from(self.side)
    }

    /// Pixels of a radian in the middle.
    pub(crate) fn focal_px(&self) -> f64 {
        self.half_px() / TAN_HALF
    }

    /// Clip position of a place.
    ///
    /// - `at`: its longitude and latitude, about which maps are
    pub(crate) fn clip(&self, place: DVec3, at: DVec2) -> DVec4 {
        let camera = &self.camera;
        let from_eye = place - camera.eye;
        let aside = DVec2::new(from_eye.dot(camera.right), from_eye.dot(camera.up));
        let ahead = from_eye.dot(camera.forward);
        let about = at - self.focus;
        let shown = match self.projection {
            Projection::Globe => {
                return DVec4::new(aside.x / TAN_HALF, aside.y / TAN_HALF, self.near_m(), ahead);
            }
            Projection::Flat => about / FRAC_PI_2,
            Projection::Hyperbolic => hyperbolic_polar(about.to_array(), REACH).into(),
            Projection::Dome => dome(aside.extend(-ahead)).into(),
        };
        DVec4::new(shown.x, shown.y, 0.5, 1.0)
    }

    /// On the picture, pixels.
    pub(crate) fn pixel(&self, clip: DVec4) -> DVec2 {
        let at = clip.truncate().truncate() / clip.w;
        DVec2::new(1.0 + at.x, 1.0 - at.y) * self.half_px()
    }

    /// In clip space.
    pub(crate) fn device(&self, at_px: DVec2) -> DVec2 {
        let at = at_px / self.half_px();
        DVec2::new(at.x - 1.0, 1.0 - at.y)
    }

    /// Direction of a ray from the eye; in globes its part along the view's axis is 1. None beyond a map's rim.
    fn ray(&self, at_px: DVec2) -> Option<DVec3> {
        let camera = &self.camera;
        if self.projection == Projection::Globe {
            return Some(camera.direction(at_px, self.size()));
        }
        let at = self.device(at_px);
        let share = at.length();
        let (sin, cos) = (share * FRAC_PI_2).sin_cos();
        let aside = at * (sin / share.max(f64::MIN_POSITIVE));
        let ray = camera.right * aside.x + camera.up * aside.y + camera.forward * cos;
        (share <= 1.0).then_some(ray)
    }

    /// Parameter of the nearer place where a pixel's ray meets the body.
    fn meet(&self, ray: DVec3) -> Option<f64> {
        let eye = self.camera.eye / RADIUS_M;
        let (along, toward) = (ray.length_squared(), eye.dot(ray));
        let height = eye.length_squared() - 1.0;
        let root = toward * toward - along * height;
        (toward < 0.0 && root >= 0.0).then(|| RADIUS_M * height / (-toward + root.sqrt()))
    }

    /// Depth of the body at a place of the picture, in globes.
    pub(crate) fn body_depth(&self, at_px: DVec2) -> Option<f64> {
        let away_m = self.meet(self.ray(at_px)?)?;
        Some(self.near_m() / away_m)
    }

    /// Longitude and latitude that a place of the picture shows.
    pub(crate) fn shown(&self, at_px: DVec2) -> Option<DVec2> {
        let at = self.device(at_px);
        match self.projection {
            Projection::Globe | Projection::Dome => {
                let ray = self.ray(at_px)?;
                Some(angles(self.camera.eye + ray * self.meet(ray)?))
            }
            Projection::Flat => self.on_map(at * FRAC_PI_2),
            Projection::Hyperbolic => {
                let from = at.length();
                let about = at * (REACH / (1.0 - from));
                self.on_map(about).filter(|_| from < 1.0)
            }
        }
    }

    /// Longitude and latitude by their offsets from the focus; none beyond a pole or a turn.
    fn on_map(&self, about: DVec2) -> Option<DVec2> {
        let at = self.focus + about;
        (about.x.abs() <= PI && at.y.abs() <= FRAC_PI_2).then_some(at)
    }

    /// Before the horizon above 0, at most 1; linear in the place. Maps hide nothing.
    pub(crate) fn horizon(&self) -> DVec4 {
        if matches!(self.projection, Projection::Flat | Projection::Hyperbolic) {
            return DVec4::W;
        }
        let eye = self.camera.eye / RADIUS_M;
        let scale = eye.length_squared().recip();
        (eye * (scale / RADIUS_M)).extend(-scale)
    }

    /// Pixels that a metre at a place of the body is at most, where it is seen in the picture.
    pub(crate) fn px_per_metre(&self, at: DVec2) -> Option<f64> {
        let place = direction(at) * RADIUS_M;
        let clip = self.clip(place, at);
        let device = clip.truncate().truncate() / clip.w;
        let is_seen = device.abs().max_element() <= 1.0
            && clip.w > 0.0
            && self.horizon().dot(place.extend(1.0)) >= 0.0;
        let tan = device.length() * TAN_HALF;
        is_seen.then(|| self.focal_px() / clip.w * (1.0 + tan * tan).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_projection_goes_there_and_back() {
        let target = DVec2::new(0.3, 0.7);
        for projection in Projection::ALL {
            let eye = Eye {
                projection,
                ..Eye::new(target, 0.2, 3e6, 200)
            };
            for at_px in [[100.0, 100.0], [81.5, 90.25], [110.0, 120.0]].map(DVec2::from) {
                let at = eye.shown(at_px).expect("of the body");
                let back = eye.pixel(eye.clip(direction(at) * RADIUS_M, at));
                assert!(
                    (back - at_px).length() < 1e-6,
                    "{projection:?} {at_px} {back}"
                );
            }
        }
        // Negative control: beside the body and beyond the rim there is nothing.
        let eye = Eye::new(target, 0.0, 3e7, 200);
        assert!(eye.shown(DVec2::splat(1.0)).is_none());
        let eye = Eye {
            projection: Projection::Hyperbolic,
            ..eye
        };
        assert!(eye.shown(DVec2::splat(1.0)).is_none());
    }

    #[test]
    fn the_horizon_divides_what_a_ray_meets_from_what_it_does_not() {
        let eye = Eye::new(DVec2::new(0.3, 0.7), 0.6, 3e6, 200);
        let horizon = (RADIUS_M / (RADIUS_M + 3e6)).acos();
        let [_, north, up] = axes(eye.focus);
        for (turn, is_before) in [(horizon - 1e-6, true), (horizon + 1e-6, false)] {
            let place = (up * turn.cos() + north * turn.sin()) * RADIUS_M;
            assert_eq!(eye.horizon().dot(place.extend(1.0)) > 0.0, is_before);
        }
        let below = (up * RADIUS_M).extend(1.0);
        assert!((0.1..=1.0).contains(&eye.horizon().dot(below)));
    }
}
