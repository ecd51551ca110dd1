// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes of a lamp on devices, by the programs that draw those of the sun.

use super::{LampScene, Limit};
use crate::loading::{program, range_of};
use crate::way::{Bounds, Cut, DeviceWay};
use crate::work::End;
use glam::DVec3;
use std::cell::LazyCell;
use terrafill_contract::{Counters, Devices};
use terrafill_shadow_views::{
    Draws, EyeVolumes, Interface, LampReference, Light, Positions, ROUNDING_PX, Rule, SeenPlace,
    VolumeSource, Wrong, constants, count, eye_vertices, is_joint, is_within_rounding, listed,
    seen_by, slivers,
};
use terrafill_stencil::{DepthRange, StencilWork, Volume, VolumeList};
use terrafill_study::Failure;

/// What a device drew, before anybody judges it.
pub(crate) struct LampDrawn {
    pub(crate) counters: Counters,
    pub(crate) mask: Vec<bool>,
    pub(crate) volume: terrafill_casters::Volume,
    /// Ready to be timed.
    pub(crate) draws: Option<Box<dyn Draws>>,
}

impl LampScene {
    /// Draws volumes without end, or limited in one way.
    pub(crate) fn drawn_by(
        &self,
        devices: &Devices,
        interface: Interface,
        rule: Rule,
        limit: Limit,
    ) -> Result<LampDrawn, Failure> {
        let (view, mesh, volume) = (&self.view, &self.prepared.mesh, self.volume(limit));
        let way = DeviceWay {
            rule,
            end: End::Infinite,
            cut: match limit {
                Limit::Scissor | Limit::HalfScissor => Cut::Rectangle,
                _ => Cut::Off,
            },
            bounds: match limit {
                Limit::Bounds => Bounds::Native,
                _ => Bounds::Off,
            },
            ..DeviceWay::plain(interface)
        };
        let switches = way.switches();
        let mut volumes = EyeVolumes {
            vertices: eye_vertices(way.positions, view, &volume),
            ..EyeVolumes::default()
        };
        let in_reach = (limit == Limit::Casters).then(|| self.parts_in_reach());
        let is_drawn = |part: usize| in_reach.as_ref().is_none_or(|all| all[part]);
        for caster in &mesh.casters {
            let first = count(volumes.indices.len());
            let all = volume.triangles.iter();
            let own = all.filter(|own| {
                let part = own.part as usize;
                caster.parts.contains(&part) && is_drawn(part)
            });
            volumes.indices.extend(own.flat_map(|own| own.corners));
            let range = first..count(volumes.indices.len());
            if !range.is_empty() {
                volumes.ranges.push(range);
            }
        }
        let casters = 0..volumes.ranges.len();
        let rectangle = self.rectangle(limit);
        let depth = match limit {
            Limit::Bounds => range_of(self.lamp.depths(view), view),
            _ => DepthRange::ANY,
        };
        let own = |at| Volume {
            depth,
            ..listed(rectangle, at)
        };
        let list: Vec<_> = casters.map(own).collect();
        let source = VolumeSource::Volumes(volumes);
        let mut draws = seen_by(Positions::Eye, view, mesh, |seen| {
            let constants = constants(seen.camera, list.len());
            let work = StencilWork {
                program: program(way, &switches, &list)?,
                list: VolumeList::new(seen.id, seen.size, list),
                constants: bytemuck::cast_slice(&constants).to_vec(),
                blends: false,
            };
            let open = (&switches, way.bounds == Bounds::Native);
            Ok(interface.open(devices, open, seen, source, (work, None))?)
        })?;
        let (counters, mask) = draws.draw()?;
        Ok(LampDrawn {
            counters,
            mask,
            volume,
            draws: Some(draws),
        })
    }

    /// What is wrong of it.
    pub(crate) fn wrong(&self, drawn: &LampDrawn) -> Wrong {
        let (view, mesh) = (&self.view, &self.prepared.mesh);
        let reference = LazyCell::new(|| LampReference::new(mesh, self.lamp));
        let slivers = LazyCell::new(|| slivers(view, &drawn.volume, ROUNDING_PX));
        let is_rim =
            |at: usize, light| self.is_within_rounding(&reference, at, light) || slivers[at];
        Wrong::but_at_rims(&drawn.mask, self.truth(), is_rim)
    }

    /// Whether a device's rounding may give a pixel this light.
    fn is_within_rounding(&self, reference: &LampReference<'_>, at: usize, light: Light) -> bool {
        let view = &self.view;
        let look = |ray: DVec3| {
            let seen = reference.seen(view, ray);
            (seen, reference.light(view, ray, seen))
        };
        let is_side_between = |own, other| self.is_side_between(own, other);
        let begins_between = |own: SeenPlace, other: SeenPlace| {
            self.sides.iter().any(|side| {
                let edge = side.map(|vertex| self.prepared.mesh.vertices[vertex as usize]);
                is_joint(view.eye, own, other, edge, |seen, place| {
                    reference.away(seen, place)
                })
            })
        };
        is_within_rounding(view, at, light, look, is_side_between, begins_between)
    }

    /// Whether a silhouette edge crosses the triangle of the lamp and two places.
    fn is_side_between(&self, own: DVec3, other: DVec3) -> bool {
        let from_lamp = |place: DVec3| place - self.lamp.place;
        let (u, v) = (from_lamp(own), from_lamp(other));
        let normal = u.cross(v);
        self.sides.iter().any(|side| {
            let [a, b] = side.map(|vertex| from_lamp(self.prepared.mesh.vertices[vertex as usize]));
            let [of_a, of_b] = [a, b].map(|place| place.dot(normal));
            if (of_a < 0.0) == (of_b < 0.0) {
                return false;
            }
            // Shares of the two places that it is the sum of.
            let met = a + (b - a) * (of_a / (of_a - of_b));
            let area = normal.length_squared();
            let shares = [
                met.cross(v).dot(normal) / area,
                u.cross(met).dot(normal) / area,
            ];
            shares.iter().all(|share| *share >= 0.0) && shares.iter().sum::<f64>() <= 1.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LampEye, LampName};
    use super::*;

    #[test]
    fn devices_have_the_reference_s_shadows_of_a_lamp_and_z_pass_loses_them_within_one() {
        let devices = Devices::default();
        for (name, eye) in [
            (LampName::Search, LampEye::Aerial),
            (LampName::Shore, LampEye::InShadow),
            (LampName::Search, LampEye::InShadow),
        ] {
            let scene = LampScene::new(name, eye, [64, 48]).expect("a port");
            for interface in Interface::ALL {
                for (rule, limit) in [
                    (Rule::Pass, Limit::Off),
                    (Rule::Fail, Limit::Off),
                    (Rule::Fail, Limit::Range),
                ] {
                    let drawn = match scene.drawn_by(&devices, interface, rule, limit) {
                        Err(Failure::Unable(error)) => {
                            let needed = std::env::var_os("TERRAFILL_REQUIRE_DEVICE").is_some();
                            assert!(!needed, "{error}");
                            return;
                        }
                        drawn => drawn.expect("drawn"),
                    };
                    let what = format!("{} {} {}", name.name(), eye.name(), interface.name());
                    let wrong = scene.wrong(&drawn);
                    let what = format!("{what} {} {}: {wrong:?}", rule.name(), limit.name());
                    eprintln!("{what}");
                    let dark = drawn.mask.iter().filter(|is_dark| **is_dark).count();
                    assert!(dark > 20, "{what}");
                    if (eye, rule) == (LampEye::InShadow, Rule::Pass) {
                        // Negative control: the eye is in a volume that is not counted.
                        assert!(wrong.outside() > 100, "{what}");
                    } else {
                        assert_eq!(wrong.outside(), 0, "{what}");
                        assert!(wrong.at_rims < 60, "{what}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_side_lies_between_places_on_either_side_of_a_rim_and_not_beyond_it() {
        let scene = LampScene::new(LampName::Deck, LampEye::Aerial, [4, 3]).expect("a port");
        let mesh = &scene.prepared.mesh;
        let [a, b] = scene.sides[0].map(|vertex| mesh.vertices[vertex as usize]);
        let (light, middle) = (scene.lamp.place, (a + b) / 2.0);
        let across = (b - a).cross(middle - light).normalize() * 1e-3;
        let at = |share: f64, beside: f64| light + (middle - light) * share + across * beside;
        assert!(scene.is_side_between(at(1.1, -1.0), at(1.1, 1.0)));
        // Negative control: both on one side of every edge, next to the lamp.
        assert!(!scene.is_side_between(at(1e-3, -1e-3), at(1e-3, 1e-3)));
    }
}
