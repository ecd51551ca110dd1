// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures for people: the port by night, lit by a lamp or by the moon, with the shadows that a device drew.
//!
//! Patterns and materials are those of the port by day. What a face has of the lamp falls off with the cosine of its
//! angle. It falls off with the square of the distance as a share of the range too, so that nothing is lit beyond it.

use super::LampScene;
use crate::shading::{Painter, bytes};
use crate::work::Scene;
use glam::DVec3;
use terrafill_casters::Mesh;
use terrafill_shadow_views::{DeckCamera, Seen, Truth, sun};

/// Light of the night sky, of that of the day.
const NIGHT: f64 = 0.025;
/// Light of a face at the lamp that looks at it, of that of the day.
const BRIGHT: f64 = 1.6;
/// The moon's on a face that looks at it, of that of the day: far brighter than it is, so that forms can be told.
const MOONLIGHT: DVec3 = DVec3::new(0.45, 0.53, 0.66);
/// Share of light that falls on a face at any angle: one that light grazes is rough enough to show it.
const GRAZED: f64 = 0.25;
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
    let (view, truth) = (&scene.view, scene.truth());
    painted(&Painter::new(&day), view, truth, |at, ray, seen| {
        let lit = match seen.depth() {
            Some(depth) if !mask[at] => light(scene, view.eye + ray * depth, seen),
            _ => 0.0,
        };
        [BRIGHT * lit, glow(scene, ray, seen)].map(|share| WARM * share)
    })
}

/// The same under the moon, which shines from where the painter's scene has its light.
pub(crate) fn by_moon(
    painter: &Painter<'_>,
    view: &DeckCamera,
    truth: &Truth,
    mask: &[bool],
) -> Vec<[u8; 3]> {
    let Scene { to_light, .. } = painter.scene;
    painted(painter, view, truth, |at, _, seen| {
        let is_lit = !mask[at] && seen != Seen::Sky;
        let cosine = normal(painter.scene.mesh(), seen).dot(*to_light);
        let lit = if is_lit { facing(cosine) } else { 0.0 };
        [MOONLIGHT * lit, DVec3::ZERO]
    })
}

/// - `shine`: by pixel, ray and what is seen, the light on it of that of the day, and light that shines into the eye
fn painted(
    day: &Painter<'_>,
    view: &DeckCamera,
    truth: &Truth,
    shine: impl Fn(usize, DVec3, Seen) -> [DVec3; 2],
) -> Vec<[u8; 3]> {
    let by_day = day.picture(view, truth, &vec![false; truth.seen.len()]);
    let pixels = by_day.into_iter().enumerate();
    let painted = pixels.map(|(at, colour)| {
        let [column, row] = view.pixel(at);
        let [on, into_eye] = shine(at, view.ray(column, row), truth.seen[at]);
        // Of a display's colours the squares are about as light is.
        let own = DVec3::from(colour.map(|own| f64::from(own) / 255.0));
        let shown = own * own * (DVec3::splat(NIGHT) + on) + into_eye;
        bytes(shown.map(f64::sqrt))
    });
    painted.collect()
}

fn normal(mesh: &Mesh, seen: Seen) -> DVec3 {
    match seen {
        Seen::Triangle(triangle, _) => {
            mesh.normals[mesh.planes[triangle as usize] as usize].normalize_or_zero()
        }
        Seen::Sea(_) | Seen::Sky => DVec3::Z,
    }
}

/// What a face has of light by the cosine of its angle.
fn facing(cosine: f64) -> f64 {
    if cosine > 0.0 {
        GRAZED + (1.0 - GRAZED) * cosine
    } else {
        0.0
    }
}

/// What a place has of the lamp where nothing is between.
fn light(scene: &LampScene, place: DVec3, seen: Seen) -> f64 {
    let lamp = &scene.lamp;
    let way = lamp.place - place;
    let cosine = normal(&scene.prepared.mesh, seen).dot(way.normalize_or_zero());
    let falls = (1.0 - way.length_squared() / lamp.range_m.powi(2)).max(0.0);
    let in_beam = lamp.beam.map_or(1.0, |beam| {
        let angle = (-way).angle_between(beam.axis).to_degrees();
        ((1.0 - angle / beam.half_deg) / RIM).clamp(0.0, 1.0)
    });
    facing(cosine) * falls * in_beam
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lamps::MOON;
    use crate::views::Place;

    #[test]
    fn the_moon_lights_what_its_mask_leaves_lit_and_no_sky() {
        let scene = Scene::of_place(Place::UnderCrane, MOON, [64, 48]).expect("a port");
        let (view, truth) = (&scene.views[0], &scene.truths()[0]);
        let painter = Painter::new(&scene);
        let by = |is_dark| by_moon(&painter, view, truth, &vec![is_dark; truth.seen.len()]);
        let (lit, dark) = (by(false), by(true));
        let sum = |colour: [u8; 3]| colour.map(u32::from).iter().sum::<u32>();
        let mut seen_of = [0; 2];
        for (at, seen) in truth.seen.iter().enumerate() {
            let normal = normal(scene.mesh(), *seen);
            let is_met = *seen != Seen::Sky && normal.dot(scene.to_light) > 0.01;
            assert_eq!(sum(lit[at]) > sum(dark[at]), is_met, "{at}: {seen:?}");
            seen_of[usize::from(is_met)] += 1;
        }
        assert!(seen_of.iter().all(|count| *count > 100), "{seen_of:?}");
    }
}
