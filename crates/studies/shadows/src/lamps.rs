// SPDX-License-Identifier: MIT OR Apache-2.0
//! The port by night, under lights at a place: on a crane, on a mast, and a searchlight on own ship.
//!
//! The paper names the deck light, the searchlight and lights on shore, and limits "the range of illumination" by the sea
//! level alone. A lamp has a range of its own, and each limit by it is a case by itself. Volumes may end beyond it. The
//! stencil may be cut to where the lit sphere or cone is seen, or to its depths. Casters out of reach may be left out.

mod drawing;
mod night;

pub(crate) use self::drawing::LampDrawn;
pub(crate) use self::night::{by_moon, picture};

use crate::views::Place;
use crate::work::{ChannelTotals, closed, port_m};
use glam::DVec3;
use std::cell::OnceCell;
use terrafill_casters::{EdgeTable, Facing, Mesh, Prepared, Reach, Side, Volume};
use terrafill_plan::PixelRect;
use terrafill_shadow_views::{
    Beam, DeckCamera, Lamp, LampReference, Light, NONE, Pass, Rule, Stencil, Truth, Wrong, box_of,
    bridge, deck_eyes, eyes_within,
};

/// The moon shines by night as the sun does by day, from this elevation and azimuth from the dock, degrees.
pub(crate) const MOON: [f64; 2] = [25.0, 160.0];
/// As rows have it.
pub(crate) const MOON_NAME: &str = "moon";

/// Eyes on deck among which one in shadow is looked for, and the picture by which it is chosen.
const TRIED: usize = 400;
const TRIED_SIZE: [u32; 2] = [24, 18];
/// What such an eye must see of either light, pixels of that picture.
const SEEN: usize = 30;
/// Share of the reach of a scissor that is too small.
const TOO_SMALL: f64 = 0.5;

terrafill_results::named! {
    /// A light.
    all pub(crate) enum LampName {
        /// 33 m up at a leg of the middle crane, over the edge of the dock.
        Shore = "shore light",
        /// On the foremast of the moored ship.
        Deck = "deck light",
        /// On own ship's foremast, onto the moored ship.
        Search = "searchlight",
    }
}

impl LampName {
    fn lamp(self) -> Lamp {
        let to_all_sides = |place, range_m| Lamp {
            place,
            range_m,
            beam: None,
        };
        match self {
            // Beside the leg, whose face is at y = −8.2.
            Self::Shore => to_all_sides(DVec3::new(6.0, -9.2, 33.0), 100.0),
            // A metre aft of the mast at x = 72.
            Self::Deck => to_all_sides(DVec3::new(71.0, -30.0, 21.5), 60.0),
            Self::Search => {
                // Beside the mast, which would else leave the bridge in its shadow.
                let place = DVec3::new(-6.3, -113.3, 20.0);
                let beam = Beam {
                    axis: (DVec3::new(-45.0, -30.0, 12.0) - place).normalize(),
                    half_deg: 14.0,
                };
                Lamp {
                    beam: Some(beam),
                    ..to_all_sides(place, 200.0)
                }
            }
        }
    }

    /// Among which an eye in its shadow is looked for. Of the searchlight one on the dock sees little: the moored ship
    /// stands between, so that it is over that ship's deck.
    fn tried(self, mesh: &Mesh) -> Vec<DeckCamera> {
        match self {
            Self::Search => {
                let over_deck = [[-85.0, -43.0, 10.7], [60.0, -17.0, 22.0]].map(DVec3::from_array);
                eyes_within(mesh, over_deck, TRIED, 0.5)
            }
            Self::Shore | Self::Deck => deck_eyes(mesh, TRIED, 0.5),
        }
    }

    /// The channel of the bridge that has it in view.
    fn channel(self) -> usize {
        match self {
            Self::Deck => 3,
            Self::Shore | Self::Search => 4,
        }
    }
}

terrafill_results::named! {
    /// From where it is seen.
    all pub(crate) enum LampEye {
        Bridge = "bridge",
        Aerial = "aerial",
        /// On the dock or a ship's deck, in the shadow of something.
        InShadow = "eye in shadow",
    }
}

terrafill_results::named! {
    /// How far its shadows are drawn.
    all pub(crate) enum Limit {
        Off = "off",
        /// Volumes end beyond the range.
        Range = "volumes end beyond it",
        /// Their corners end at the range: a negative control that must lose pixels.
        OnSphere = "volumes' corners end at it",
        /// A scissor round what is in reach.
        Scissor = "scissor",
        /// One of half the range and half the beam: a negative control that must lose pixels.
        HalfScissor = "scissor of half of it",
        /// Between the least and the greatest depth in reach.
        Bounds = "depth bounds",
        /// Parts that cannot be in reach are left out.
        Casters = "casters in reach",
    }
}

impl Limit {
    /// Negative controls, which are too small.
    pub(crate) fn may_be_wrong(self) -> bool {
        matches!(self, Self::OnSphere | Self::HalfScissor)
    }
}

/// The port under a lamp, from one eye.
pub(crate) struct LampScene {
    pub(crate) lamp: Lamp,
    pub(crate) view: DeckCamera,
    truth: OnceCell<Truth>,
    prepared: Prepared,
    facing: Facing,
    sides: Vec<Side>,
}

impl LampScene {
    pub(crate) fn new(name: LampName, eye: LampEye, size: [u32; 2]) -> Result<Self, String> {
        let prepared = closed(port_m()?)?;
        let mesh = &prepared.mesh;
        let lamp = name.lamp();
        let reference = LampReference::new(mesh, lamp);
        let view = match eye {
            LampEye::Bridge => bridge(size)[name.channel()],
            LampEye::Aerial => Place::Aerial.view(size),
            LampEye::InShadow => {
                let is_it = |view: &DeckCamera| {
                    let is_dark = lamp.reaches(view.eye) && reference.is_shadowed(view.eye, None);
                    is_dark && {
                        let truth = reference.picture(&view.sized(TRIED_SIZE));
                        [Light::Lit, Light::Shadow]
                            .iter()
                            .all(|light| truth.count(*light) > SEEN)
                    }
                };
                let found = name.tried(mesh).into_iter().find(is_it);
                let none = || format!("{}: none of {TRIED} eyes is in shadow", name.name());
                found.ok_or_else(none)?.sized(size)
            }
        };
        let facing = Facing::towards(mesh, lamp.place);
        Ok(Self {
            sides: EdgeTable::of(mesh).sides(&prepared, &facing),
            lamp,
            view,
            truth: OnceCell::new(),
            facing,
            prepared,
        })
    }

    /// Found where somebody first asks: a process that only times never does.
    pub(crate) fn truth(&self) -> &Truth {
        self.truth.get_or_init(|| {
            let reference = LampReference::new(&self.prepared.mesh, self.lamp);
            reference.picture(&self.view)
        })
    }

    fn volume(&self, limit: Limit) -> Volume {
        let reach = match limit {
            Limit::Range => Reach::Range(self.lamp.range_m),
            Limit::OnSphere => Reach::OnSphere(self.lamp.range_m),
            _ => Reach::Infinite,
        };
        let light = self.lamp.place;
        Volume::of_lamp(&self.prepared, &self.facing, &self.sides, light, reach)
    }

    /// Of each part, whether a sphere round it meets the lamp's reach.
    fn parts_in_reach(&self) -> Vec<bool> {
        let mesh = &self.prepared.mesh;
        let meets = |part: &terrafill_casters::ConvexPart| {
            let [low, high] = box_of(&mesh.vertices[part.vertices.clone()]);
            let (along, radius) = (
                (low + high) / 2.0 - self.lamp.place,
                (high - low).length() / 2.0,
            );
            let away = along.length();
            let is_beside = self.lamp.beam.is_some_and(|beam| {
                away > radius
                    && along.angle_between(beam.axis)
                        > beam.half_deg.to_radians() + (radius / away).asin()
            });
            away - radius <= self.lamp.range_m && !is_beside
        };
        mesh.parts.iter().map(meets).collect()
    }

    /// To which the stencil is cut.
    fn rectangle(&self, limit: Limit) -> PixelRect {
        match limit {
            Limit::Scissor => self.lamp.rectangle(&self.view, 1.0),
            Limit::HalfScissor => self.lamp.rectangle(&self.view, TOO_SMALL),
            _ => self.view.whole(),
        }
    }

    /// Counts volumes along the rays of pixels.
    pub(crate) fn drawn(&self, rule: Rule, limit: Limit) -> ChannelTotals {
        let (view, volume) = (&self.view, self.volume(limit));
        let rectangle = self.rectangle(limit);
        let count = self.prepared.mesh.parts.len();
        let mut parts = vec![(rectangle != NONE).then_some((rule, rectangle)); count];
        if limit == Limit::Casters {
            let all = parts.iter_mut().zip(self.parts_in_reach());
            for (part, _) in all.filter(|(_, is_in_reach)| !is_in_reach) {
                *part = None;
            }
        }
        let bounds = match limit {
            Limit::Bounds => vec![self.lamp.depths(view); count],
            _ => Vec::new(),
        };
        let pass = Pass { parts, bounds };
        let stencil = Stencil::of(view, &self.prepared.mesh, &volume, self.truth(), &pass);
        let mask = stencil.mask();
        ChannelTotals {
            wrong: Wrong::of(&mask, self.truth()),
            updates: stencil.updates,
            max_overlap: stencil.counts.into_iter().max().unwrap_or(0),
            volume_triangles: volume.triangles.len(),
            masks: vec![mask],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_eye_is_found_that_its_lamp_does_not_see() {
        for name in LampName::ALL {
            let scene = LampScene::new(name, LampEye::InShadow, [24, 18]).expect("an eye");
            let mesh = &scene.prepared.mesh;
            let reference = LampReference::new(mesh, scene.lamp);
            assert!(
                reference.is_shadowed(scene.view.eye, None),
                "{}",
                name.name()
            );
            // Negative control: the lamp itself.
            assert!(!reference.is_shadowed(scene.lamp.place - DVec3::Z * 1e-3, None));
        }
    }

    #[test]
    fn every_limit_writes_no_more_and_loses_nothing_unless_it_is_too_small() {
        let mut lost = [0; Limit::ALL.len()];
        for name in LampName::ALL {
            let scene = LampScene::new(name, LampEye::Bridge, [48, 36]).expect("a port");
            let counts = [
                Light::Lit,
                Light::Shadow,
                Light::OutOfReach,
                Light::Undecided,
            ];
            let [lit, dark, beyond, apart] = counts.map(|light| scene.truth().count(light));
            let seen = format!("{}: {lit} lit, {dark} dark, {beyond} beyond", name.name());
            assert!(lit > 20 && dark > 20 && beyond > 100, "{seen}");
            assert_eq!(apart, 0);
            for rule in [Rule::Pass, Rule::Fail] {
                let whole = scene.drawn(rule, Limit::Off);
                for (limit, lost) in Limit::ALL.into_iter().zip(&mut lost) {
                    let own = scene.drawn(rule, limit);
                    let what = format!("{} {} {}", name.name(), rule.name(), limit.name());
                    eprintln!("{what}: {} writes, {:?}", own.updates, own.wrong);
                    *lost += own.wrong.all();
                    if !limit.may_be_wrong() {
                        assert_eq!(own.wrong.outside(), 0, "{what}");
                        assert_eq!(
                            scene.truth().lost(&own.masks[0]),
                            scene.truth().lost(&whole.masks[0]),
                            "{what}"
                        );
                    }
                    assert!(own.updates <= whole.updates, "{what}");
                }
            }
        }
        // Negative controls.
        for limit in [Limit::OnSphere, Limit::HalfScissor] {
            assert!(lost[limit as usize] > 0, "{}: {lost:?}", limit.name());
        }
    }
}
