// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures for people: the port by night, lit by a lamp, with the shadows that a device drew.
//!
//! Patterns and materials are those of the port by day. What a face has of the lamp falls off with the cosine of its
//! angle. It falls off with the square of the distance as a share of the range too, so that nothing is lit beyond it.

use super::LampScene;
use crate::shading::Painter;
use crate::work::Scene;
use glam::DVec3;
use terrafill_shadow_views::{Seen, sun};

/// Light of the night sky, of that of the day.
const NIGHT: f64 = 0.025;
/// Light of a face at the lamp that looks at it, of that of the day.
const BRIGHT: f64 = 1.6;
/// Share of the angle of a beam over which its rim fades.
const RIM: f64 = 0.1;
/// Radius of the glow in which a lamp is seen, pixels.
const GLOW_PX: f64 = 1.5;
/// A lamp's colour.
const WARM: DVec3 = DVec3::new(1.0, 0.93, 0.8);

/// A pixel a triple, row by row from the top.
///
/// - `mask`: which pixels are in shadow
pub(crate) fn picture(scene: &LampScene, mask: &[bool]) -> Vec<[u8; 3]> {
    let day = Scene::lit_from(scene.prepared.clone(), sun([60.0, -60.0]), Vec::new());
    let (view, truth) = (&scene.view, &scene.truth);
    let by_day = Painter::new(&day).picture(view, truth, &vec![false; mask.len()]);
    let pixels = by_day.into_iter().enumerate();
    let painted = pixels.map(|(at, colour)| {
        let [column, row] = view.pixel(at);
        let (ray, seen) = (view.ray(column, row), truth.seen[at]);
        let lit = match seen.depth() {
            Some(depth) if !mask[at] => light(scene, view.eye + ray * depth, seen),
            _ => 0.0,
        };
        // Of a display's colours the squares are about as light is.
        let own = DVec3::from(colour.map(|own| f64::from(own) / 255.0));
        let own = own * own * (DVec3::splat(NIGHT) + WARM * (BRIGHT * lit));
        let shown = (own + WARM * glow(scene, ray, seen)).clamp(DVec3::ZERO, DVec3::ONE);
        shown.to_array().map(|own| byte(own.sqrt()))
    });
    painted.collect()
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "from 0 to 255"
)]
fn byte(share: f64) -> u8 {
    (share * 255.0).round() as u8
}

/// What a place has of the lamp where nothing is between.
fn light(scene: &LampScene, place: DVec3, seen: Seen) -> f64 {
    let (lamp, mesh) = (&scene.lamp, &scene.prepared.mesh);
    let way = lamp.place - place;
    let normal = match seen {
        Seen::Triangle(triangle, _) => {
            mesh.normals[mesh.planes[triangle as usize] as usize].normalize_or_zero()
        }
        Seen::Sea(_) | Seen::Sky => DVec3::Z,
    };
    let cosine = normal.dot(way.normalize_or_zero()).max(0.0);
    let falls = (1.0 - way.length_squared() / lamp.range_m.powi(2)).max(0.0);
    let in_beam = lamp.beam.map_or(1.0, |beam| {
        let angle = (-way).angle_between(beam.axis).to_degrees();
        ((1.0 - angle / beam.half_deg) / RIM).clamp(0.0, 1.0)
    });
    // A face that light grazes is rough enough to show it.
    (0.25 + 0.75 * cosine) * f64::from(u8::from(cosine > 0.0)) * falls * in_beam
}

/// The lamp itself, where nothing hides it.
fn glow(scene: &LampScene, ray: DVec3, seen: Seen) -> f64 {
    let view = &scene.view;
    let along = scene.lamp.place - view.eye;
    let depth = along.dot(view.forward);
    if depth <= view.near || seen.depth().is_some_and(|seen| seen < depth) {
        return 0.0;
    }
    let pixel = 2.0 * view.tan[0] / f64::from(view.size[0]);
    let away_px = (along / depth - ray).length() / pixel;
    (-(away_px / GLOW_PX).powi(2)).exp()
}
