// SPDX-License-Identifier: MIT OR Apache-2.0
//! Eyes in the port beside the bridge and the deck, each of which is hard in a way of its own.

use crate::work::{ChannelTotals, End, Scene};
use glam::DVec3;
use terrafill_shadow_views::{Boxes, DeckCamera, EyeTest, Pass, Reference, Rule, chosen};

terrafill_results::named! {
    /// A view of the port.
    pub(crate) enum Place {
        /// Between the legs of a crane, whose lattice has many small shadows.
        UnderCrane = "under-crane",
        /// On deck where the shadow of a rail, 5 cm thick, runs through the near rectangle.
        QuayEdge = "quay-edge",
        /// From a height, looking down: the sea fills what the port leaves, and no horizon is in view.
        Aerial = "aerial",
        /// Where a crane's leg stands in the shadow of a rail, in the middle of a channel [`FINE_COLUMNS`] wide.
        RailShadow = "rail-shadow",
    }
}

/// Pixels across a channel of which [`Place::RailShadow`] is the middle: a simulator's.
const FINE_COLUMNS: f64 = 1024.0;

/// How far [`Place::Aerial`] looks down, degrees: its middle meets the sea beside the dock.
const AERIAL_DEG: f64 = 31.0;

impl Place {
    /// Of which rules are asked.
    pub(crate) const ALL: [Self; 3] = [Self::UnderCrane, Self::QuayEdge, Self::Aerial];

    pub(crate) fn view(self, size: [u32; 2]) -> DeckCamera {
        let (eye, azimuth_deg) = match self {
            Self::UnderCrane => (DVec3::new(0.0, -2.0, 8.9), 40.0),
            // The upper bar of the rail is 8.25 to 8.3 m high at y = −9.9, and no ship lies sunwards. Under a sun at
            // 10° from −60° its shadow is 7.98 to 8.02 m high where the eye is, and 7.87 to 7.92 m at the near rectangle.
            Self::QuayEdge => (DVec3::new(121.0, -8.55, 7.95), 90.0),
            Self::Aerial => (DVec3::new(-260.0, -450.0, 300.0), 60.0),
            // 70 cm before the face of a leg at y = −8.2. Under a sun at 10° from −60° the upper bar of the rail has its
            // shadow there from 7.899 to 7.959 m.
            Self::RailShadow => (DVec3::new(108.0, -8.9, 7.9), 90.0),
        };
        let view = DeckCamera::level(eye, azimuth_deg, 0.5, size);
        match self {
            Self::RailShadow => view.middle_of(FINE_COLUMNS),
            Self::Aerial => view.turned_down(AERIAL_DEG),
            _ => view,
        }
    }
}

/// From where the port is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Eyes {
    /// In seven channels.
    Bridge,
    At(Place),
}

impl Eyes {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Bridge => "bridge",
            Self::At(place) => place.name(),
        }
    }
}

/// Who says how a part counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Chooser {
    All(Rule),
    Test(EyeTest),
}

impl Chooser {
    pub(crate) const ALL: [Self; 4] = [
        Self::All(Rule::Pass),
        Self::All(Rule::Fail),
        Self::Test(EyeTest::Eye),
        Self::Test(EyeTest::Exact),
    ];

    pub(crate) fn name(self) -> String {
        match self {
            Self::All(rule) => rule.name().to_owned(),
            Self::Test(test) => format!("automatic, {}", test.name()),
        }
    }
}

impl Scene {
    /// The port from there.
    #[cfg(test)]
    pub(crate) fn of_place(place: Place, at: [f64; 2], size: [u32; 2]) -> Result<Self, String> {
        Self::of_port(at, vec![place.view(size)])
    }

    /// Draws volumes closed at the sea by the rule that is chosen for each part.
    pub(crate) fn drawn_chosen(&self, chooser: Chooser) -> Result<ChannelTotals, String> {
        let volume = self.volume(End::Sea)?;
        let reference = Reference::new(self.mesh(), self.to_light);
        let boxes = Boxes::of(self.mesh());
        Ok(self.draw_by(&volume, |view, _| {
            let pass = match chooser {
                Chooser::All(rule) => self.whole(view, rule),
                Chooser::Test(test) => {
                    let whole = view.whole();
                    let fails = self.fails(test, view, &boxes, &reference).into_iter();
                    let rule = |is_fail| if is_fail { Rule::Fail } else { Rule::Pass };
                    Pass {
                        parts: fails.map(|is_fail| Some((rule(is_fail), whole))).collect(),
                        bounds: Vec::new(),
                    }
                }
            };
            vec![pass]
        }))
    }

    /// Which parts a test draws by z-fail.
    pub(crate) fn fails(
        &self,
        test: EyeTest,
        view: &DeckCamera,
        boxes: &Boxes,
        reference: &Reference<'_>,
    ) -> Vec<bool> {
        let (mesh, facing) = (self.mesh(), &self.facing);
        chosen(test, view, self.to_light, mesh, facing, boxes, reference)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_shadow_views::{Light, Seen, shadowed_share};

    #[test]
    fn the_view_from_a_height_looks_down_on_casters_sea_and_their_shadows() {
        let scene = Scene::of_place(Place::Aerial, [10.0, -60.0], [64, 48]).expect("a port");
        let (view, truth) = (&scene.views[0], &scene.truths()[0]);
        assert!((view.forward.z + AERIAL_DEG.to_radians().sin()).abs() < 1e-12);
        assert!(view.right.cross(view.forward).distance(view.up) < 1e-12);
        assert_eq!(truth.count(Light::Sky), 0, "no horizon");
        let count = |is_it: fn(&Seen) -> bool| truth.seen.iter().filter(|seen| is_it(seen)).count();
        let [sea, casters] = [
            count(|seen| matches!(seen, Seen::Sea(_))),
            count(|seen| matches!(seen, Seen::Triangle(..))),
        ];
        assert!(sea > 1_000 && casters > 300, "{sea} {casters}");
        assert!(truth.count(Light::Shadow) > 200);
        // Negative control: level, half of it is sky.
        let level = DeckCamera::level(view.eye, 60.0, 0.5, [64, 48]);
        let reference = Reference::new(scene.mesh(), scene.to_light);
        assert!(reference.picture(&level).count(Light::Sky) > 1_000);
    }

    #[test]
    fn a_rail_s_shadow_runs_through_the_near_rectangle_and_not_over_the_eye() {
        let at = [10.0, -60.0];
        let scene = Scene::of_place(Place::QuayEdge, at, [64, 48]).expect("a port");
        let reference = Reference::new(scene.mesh(), scene.to_light);
        let view = &scene.views[0];
        let share = shadowed_share(view, &reference);
        assert!((0.05..0.6).contains(&share), "{share}");
        assert!(!reference.is_shadowed(view.eye, None));
        let wrong = |chooser| scene.drawn_chosen(chooser).expect("above").wrong.outside();
        assert_eq!(wrong(Chooser::Test(EyeTest::Exact)), 0);
        assert_eq!(wrong(Chooser::All(Rule::Fail)), 0);
        // Negative control: the published test finds the eye in the light.
        assert!(wrong(Chooser::Test(EyeTest::Eye)) > 100);
    }
}
