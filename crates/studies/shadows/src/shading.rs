// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures for people: the port by day, with the shadows that a device drew.
//!
//! Colours are those of a display. What a face has of light is by its normal alone: all of it where the mask is lit, and
//! [`AMBIENT`] of it where the mask is dark. The paper darkens too, and says neither how nor by how much. Patterns are
//! functions of the place in metres, averaged over the width of a pixel.

mod patterns;

use self::patterns::{Material, materials};
use crate::work::Scene;
use glam::DVec3;
use terrafill_shadow_views::{DeckCamera, Seen, Truth};

/// Share of its light that a face keeps in shadow.
pub(crate) const AMBIENT: f64 = 0.6;
/// Elevations over which sunlight turns from that of a low sun to that of noon, as sines.
const WARM: [f64; 2] = [0.05, 0.45];
/// Light of faces that look down, what those that look up have more, and what those have that look at the sun.
const SHADE: [f64; 3] = [0.62, 0.26, 0.12];
/// Waves of the sea: length in m, direction in degrees, steepness.
const WAVES: [[f64; 3]; 5] = [
    [23.0, 20.0, 0.020],
    [11.0, 75.0, 0.025],
    [5.3, -30.0, 0.030],
    [2.1, 50.0, 0.035],
    [0.9, 110.0, 0.040],
];
const WATER: DVec3 = DVec3::new(0.07, 0.25, 0.33);
/// Of light that meets water straight on, the share that it reflects.
const REFLECTED: f64 = 0.02;
/// How fast the sun's glitter falls off beside its mirror image.
const GLITTER: f64 = 180.0;

/// What paints the pictures of a scene.
pub(crate) struct Painter<'a> {
    pub(crate) scene: &'a Scene,
    part_of: Vec<u32>,
    /// By part.
    materials: Vec<Material>,
    /// Of what is lit.
    sunlight: DVec3,
}

impl<'a> Painter<'a> {
    pub(crate) fn new(scene: &'a Scene) -> Self {
        let mesh = scene.mesh();
        let [low, noon] = WARM;
        let height = ((scene.to_light.z - low) / (noon - low)).clamp(0.0, 1.0);
        Self {
            scene,
            part_of: mesh.part_of_triangles(),
            materials: materials(mesh),
            sunlight: DVec3::new(1.0, 0.84, 0.66).lerp(DVec3::ONE, height),
        }
    }

    /// A pixel a triple, row by row from the top.
    ///
    /// - `mask`: which pixels are in shadow
    pub(crate) fn picture(&self, view: &DeckCamera, truth: &Truth, mask: &[bool]) -> Vec<[u8; 3]> {
        let pixels = mask.iter().enumerate();
        let painted = pixels.map(|(at, is_dark)| {
            let [column, row] = view.pixel(at);
            bytes(self.colour(view, view.ray(column, row), truth.seen[at], *is_dark))
        });
        painted.collect()
    }

    fn colour(&self, view: &DeckCamera, ray: DVec3, seen: Seen, is_dark: bool) -> DVec3 {
        let along = ray.normalize();
        let pixel = 2.0 * view.tan[0] / f64::from(view.size[0]);
        match seen {
            Seen::Sky => self.sky(along),
            Seen::Sea(depth) => self.sea(view.eye + ray * depth, along, pixel * depth, is_dark),
            Seen::Triangle(triangle, depth) => {
                let triangle = triangle as usize;
                let plane = self.scene.mesh().planes[triangle] as usize;
                let normal = self.scene.mesh().normals[plane].normalize_or_zero();
                let material = &self.materials[self.part_of[triangle] as usize];
                let place = view.eye + ray * depth;
                material.colour(place, normal, pixel * depth)
                    * self.shade(normal)
                    * self.light(is_dark)
            }
        }
    }

    /// Of sunlight and sky together; of the sky alone in shadow.
    fn light(&self, is_dark: bool) -> DVec3 {
        if is_dark {
            DVec3::splat(AMBIENT)
        } else {
            self.sunlight
        }
    }

    /// By the normal alone, so that forms show in shadow too.
    fn shade(&self, normal: DVec3) -> f64 {
        let [down, up, sunwards] = SHADE;
        let towards = self.scene.to_light.with_z(0.0).normalize_or_zero();
        down + up * (0.5 + 0.5 * normal.z) + sunwards * normal.dot(towards).max(0.0)
    }

    fn sky(&self, along: DVec3) -> DVec3 {
        let height = along.z.max(0.0).sqrt();
        let sky = DVec3::new(0.80, 0.87, 0.92).lerp(DVec3::new(0.36, 0.58, 0.84), height);
        let glow = along.dot(self.scene.to_light).max(0.0).powi(24);
        sky.lerp(self.sunlight, 0.7 * glow)
    }

    /// - `pixel_m`: width of a pixel there, across the ray
    fn sea(&self, place: DVec3, along: DVec3, pixel_m: f64, is_dark: bool) -> DVec3 {
        // A pixel is longer on the water than it is wide.
        let pixel_m = pixel_m / along.z.abs().max(1e-3);
        let mut slope = DVec3::ZERO;
        for [length, degrees, steepness] in WAVES {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let way = DVec3::new(cos, sin, 0.0);
            let turns = std::f64::consts::TAU * way.dot(place) / length;
            slope += way * (steepness * turns.cos() * (1.0 - 2.0 * pixel_m / length).max(0.0));
        }
        let normal = (DVec3::Z - slope).normalize();
        let cosine = (-along.dot(normal)).clamp(0.0, 1.0);
        let mirrored = along + 2.0 * cosine * normal;
        let share = REFLECTED + (1.0 - REFLECTED) * (1.0 - cosine).powi(5);
        let water = WATER.lerp(self.sky(mirrored), 0.8 * share);
        let glitter = mirrored.dot(self.scene.to_light).max(0.0).powf(GLITTER);
        let mirrored_sun = if is_dark { 0.0 } else { 0.5 * glitter };
        water * self.light(is_dark) + self.sunlight * mirrored_sun
    }
}

/// Channels beside one another, from the left.
///
/// - `channels`: pictures of one size, by column and row
pub(crate) fn strip(channels: &[Vec<[u8; 3]>], [width, height]: [u32; 2]) -> Vec<u8> {
    let (width, height) = (width as usize, height as usize);
    let rows = (0..height).flat_map(|row| {
        let of_row = channels.iter();
        of_row.flat_map(move |channel| &channel[row * width..(row + 1) * width])
    });
    rows.flatten().copied().collect()
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "from 0 to 255"
)]
pub(crate) fn bytes(colour: DVec3) -> [u8; 3] {
    let byte = |part: f64| (255.0 * part.clamp(0.0, 1.0)).round() as u8;
    colour.to_array().map(byte)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::views::Place;
    use terrafill_shadow_views::Light;

    #[test]
    fn a_shadow_keeps_its_share_of_light_and_a_picture_shows_its_mask() {
        let scene = Scene::of_place(Place::Aerial, [10.0, -60.0], [64, 48]).expect("a port");
        let (view, truth) = (&scene.views[0], &scene.truths()[0]);
        let painter = Painter::new(&scene);
        let ray = view.ray(32, 24);
        let seen = truth.seen.iter().copied();
        let caster = seen.clone().find(|seen| matches!(seen, Seen::Triangle(..)));
        let [lit, dark] = [false, true]
            .map(|is_dark| painter.colour(view, ray, caster.expect("a caster"), is_dark));
        let share = dark / (lit / painter.sunlight);
        assert!(
            (share - DVec3::splat(AMBIENT)).abs().max_element() < 1e-12,
            "{share}"
        );
        let mask: Vec<bool> = truth
            .light
            .iter()
            .map(|light| *light == Light::Shadow)
            .collect();
        let picture = painter.picture(view, truth, &mask);
        // More than a mask: one colour a kind would be four.
        let kinds: std::collections::BTreeSet<[u8; 3]> = picture.iter().copied().collect();
        assert!(kinds.len() > 100, "{}", kinds.len());
        // Negative control: another mask, another picture, at its pixels alone.
        let mut other = mask.clone();
        other[0] = !other[0];
        let changed = painter.picture(view, truth, &other);
        let differing = picture.iter().zip(&changed).filter(|(a, b)| a != b).count();
        assert_eq!(differing, 1);
    }

    #[test]
    fn channels_of_a_strip_lie_beside_one_another() {
        let channel = |colour: u8| vec![[colour; 3]; 4];
        let strip = strip(&[channel(1), channel(2)], [2, 2]);
        assert_eq!(strip.len(), 24);
        assert_eq!([strip[0], strip[6], strip[12], strip[18]], [1, 2, 1, 2]);
    }
}
