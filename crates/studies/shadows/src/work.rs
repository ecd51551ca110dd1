// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the cases compute.

mod rounding;
mod staged;

pub(crate) use self::rounding::ROUNDING_PX;

use crate::count::{Rule, Stencil, Wrong, draw, draw_within};
use crate::reference::{Light, Reference, Seen, Truth};
use crate::scissor::{Rectangle, above_horizon, around_pixels, depths_of_parts, of_parts};
#[cfg(test)]
use crate::view::bridge;
use crate::view::{View, sun};
use glam::DVec3;
use std::cell::OnceCell;
use terrafill_casters::{
    EdgeTable, Extent, Facing, LightError, Mesh, Policy, PortSize, Prepared, Side, Volume,
    feet_below_sea, port, sea_level_below,
};

/// Eyes on deck.
pub(crate) const EYES: usize = 400;
/// Near planes, m.
pub(crate) const NEARS: [f64; 3] = [0.1, 0.5, 1.0];
/// Below the sea at its lowest, m: waves of a harbour.
const MARGIN_M: f64 = 1.0;
/// The same of a sea without waves: what a device draws of it lies less below the sphere.
const CALM_M: f64 = 0.2;
/// Casters that 8 bits can count.
const MAX_COUNT: u32 = 255;

/// Ranges of depth are wider than volumes by this share, as a device's are for its rounding.
pub(crate) const BOUNDS_SHARE: f64 = 1.0 / 1024.0;

/// Where volumes end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum End {
    Infinite,
    Sea,
    /// The same of casters that go on under the sea.
    SeaOfWhole,
    /// Below a sea without waves.
    Calm,
    Finite(f64),
}

impl End {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Infinite => "infinite",
            Self::Sea => "sea-closed",
            Self::SeaOfWhole => "sea-closed, whole hulls",
            Self::Calm => "sea-closed, calm",
            Self::Finite(_) => "finite",
        }
    }

    /// How far below the sea its casters go, m: what is lower is not seen, but z-fail counts its volumes. `None` for
    /// as far as they do.
    pub(crate) fn feet_m(self) -> Option<f64> {
        match self {
            Self::Sea => Some(MARGIN_M),
            Self::Calm => Some(CALM_M),
            Self::Infinite | Self::SeaOfWhole | Self::Finite(_) => None,
        }
    }
}

/// What the stencil is restricted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scissor {
    Off,
    Horizon,
    CasterRectangle,
    ReceiverRectangle,
}

impl Scissor {
    pub(crate) const ALL: [Self; 4] = [
        Self::Off,
        Self::Horizon,
        Self::CasterRectangle,
        Self::ReceiverRectangle,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Horizon => "horizon",
            Self::CasterRectangle => "caster-rect",
            Self::ReceiverRectangle => "receiver-rect",
        }
    }
}

/// The port under a sun, seen from the bridge.
pub(crate) struct Scene {
    pub(crate) to_light: DVec3,
    prepared: Prepared,
    facing: Facing,
    sides: Vec<Side>,
    pub(crate) channels: Vec<(View, Truth)>,
    /// The channel with most shadow alone, in pictures of the size that is timed.
    timed: OnceCell<Option<Box<Self>>>,
}

/// What a way of drawing came to, over all channels.
#[derive(Debug, Clone, Default)]
pub(crate) struct Drawn {
    pub(crate) wrong: Wrong,
    pub(crate) updates: u64,
    pub(crate) worst_channel_updates: u64,
    pub(crate) max_overlap: i32,
    pub(crate) volume_triangles: usize,
    /// Shadow pixels of the reference that are lit, in the band too.
    pub(crate) lost: usize,
    /// Those on casters.
    pub(crate) lost_on_casters: usize,
}

/// What the views hold, over all channels.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Pixels {
    pub(crate) all: usize,
    pub(crate) receivers: usize,
    pub(crate) shadow: usize,
    pub(crate) edge_on: usize,
    pub(crate) undecided: usize,
}

/// The port, closed.
pub(crate) fn prepared_port() -> Result<Prepared, String> {
    let named = PortSize::named("port-m").ok_or("no port-m")?;
    let prepared = Policy::Refuse.prepare(port(named));
    prepared.map_err(|error| error.to_string())
}

impl Scene {
    /// The port, cut below the sea.
    pub(crate) fn of_port(at: [f64; 2], views: Vec<View>) -> Result<Self, String> {
        Self::standing(&prepared_port()?, at, views, End::Sea.feet_m())
    }

    /// The same from the bridge.
    #[cfg(test)]
    pub(crate) fn new(at: [f64; 2], size: [u32; 2]) -> Result<Self, String> {
        Self::of_port(at, bridge(size))
    }

    /// Casters cut so far below the sea, or not at all.
    ///
    /// # Errors
    /// As [`Prepared::cut_below`].
    pub(crate) fn standing(
        prepared: &Prepared,
        at: [f64; 2],
        views: Vec<View>,
        feet_m: Option<f64>,
    ) -> Result<Self, String> {
        let prepared = match feet_m {
            Some(feet_m) => prepared.cut_below(&feet_below_sea(&prepared.mesh, feet_m)),
            None => Ok(prepared.clone()),
        };
        let prepared = prepared.map_err(|error| error.to_string())?;
        Ok(Self::of_prepared(prepared, at, views))
    }

    pub(crate) fn of(mesh: Mesh, at: [f64; 2], views: Vec<View>) -> Result<Self, String> {
        let prepared = Policy::Refuse
            .prepare(mesh)
            .map_err(|error| error.to_string())?;
        Ok(Self::of_prepared(prepared, at, views))
    }

    pub(crate) fn of_prepared(prepared: Prepared, at: [f64; 2], views: Vec<View>) -> Self {
        Self::lit_from(prepared, sun(at), views)
    }

    fn lit_from(prepared: Prepared, to_light: DVec3, views: Vec<View>) -> Self {
        let facing = Facing::of(&prepared.mesh, to_light);
        let sides = EdgeTable::of(&prepared.mesh).sides(&prepared, &facing);
        let reference = Reference::new(&prepared.mesh, to_light);
        let channels = views.into_iter().map(|view| {
            let truth = reference.picture(&view);
            (view, truth)
        });
        Self {
            to_light,
            channels: channels.collect(),
            timed: OnceCell::new(),
            facing,
            sides,
            prepared,
        }
    }

    pub(crate) fn pixels(&self) -> Pixels {
        let mut pixels = Pixels::default();
        for (_, truth) in &self.channels {
            pixels.all += truth.seen.len();
            pixels.receivers += truth.seen.len() - truth.count(Light::Sky);
            pixels.shadow += truth.count(Light::Shadow);
            pixels.edge_on += truth.count(Light::EdgeOn);
            pixels.undecided += truth.count(Light::Undecided);
        }
        pixels
    }

    pub(crate) fn volume(&self, end: End) -> Result<Volume, LightError> {
        self.volume_of(&self.sides, end)
    }

    /// Silhouette by stored adjacency, found anew.
    pub(crate) fn sides_by(&self, table: &EdgeTable) -> Vec<Side> {
        table.sides(&self.prepared, &self.facing)
    }

    /// Volumes that these sides enclose.
    pub(crate) fn volume_of(&self, sides: &[Side], end: End) -> Result<Volume, LightError> {
        let mesh = &self.prepared.mesh;
        let extent = match end {
            End::Infinite => Extent::Infinite,
            End::Sea | End::SeaOfWhole => {
                Extent::ClosedAt(sea_level_below(mesh, self.to_light, MARGIN_M)?)
            }
            End::Calm => Extent::ClosedAt(sea_level_below(mesh, self.to_light, CALM_M)?),
            End::Finite(length) => Extent::Finite(length),
        };
        Volume::of(&self.prepared, &self.facing, sides, self.to_light, &extent)
    }

    /// Draws all volumes in every channel.
    pub(crate) fn drawn(&self, end: End, rule: Rule, scissor: Scissor) -> Result<Drawn, String> {
        let volume = self.volume(end).map_err(|error| error.to_string())?;
        let mut drawn = Drawn {
            volume_triangles: volume.triangles.len(),
            ..Drawn::default()
        };
        for (view, truth) in &self.channels {
            let stencil = self.stencil((view, truth), &volume, rule, scissor)?;
            drawn.add(&stencil, &stencil.mask(), truth);
        }
        Ok(drawn)
    }

    /// The same closed at the sea, where what is seen lies in each part's range of depths.
    ///
    /// - `share`: by which ranges are wider than the volumes
    pub(crate) fn drawn_within(&self, rule: Rule, share: f64) -> Result<Drawn, String> {
        let volume = self.volume(End::Sea).map_err(|error| error.to_string())?;
        let mesh = &self.prepared.mesh;
        let mut drawn = Drawn {
            volume_triangles: volume.triangles.len(),
            ..Drawn::default()
        };
        for (view, truth) in &self.channels {
            let bounds = depths_of_parts(view, &volume, mesh.parts.len(), share);
            let mut stencil = Stencil::clear(view);
            let how = |_| Some((rule, Rectangle::whole(view)));
            draw_within(&mut stencil, view, mesh, &volume, truth, &how, &bounds);
            drawn.add(&stencil, &stencil.mask(), truth);
        }
        Ok(drawn)
    }

    /// Of each part; a caster's rectangle holds its volume closed at the sea, wherever the volume that
    /// is drawn ends.
    fn rectangles(
        &self,
        view: &View,
        truth: &Truth,
        scissor: Scissor,
    ) -> Result<Vec<Rectangle>, String> {
        let parts = self.prepared.mesh.parts.len();
        let of_casters = || {
            let closed = self.volume(End::Sea).map_err(|error| error.to_string())?;
            Ok::<_, String>(of_parts(view, &closed, parts))
        };
        Ok(match scissor {
            Scissor::Off => vec![Rectangle::whole(view); parts],
            Scissor::Horizon => vec![above_horizon(view); parts],
            Scissor::CasterRectangle => of_casters()?,
            Scissor::ReceiverRectangle => {
                let receivers =
                    around_pixels(view, |at| matches!(truth.seen[at], Seen::Triangle(..)));
                let all = of_casters()?.into_iter();
                all.map(|rectangle| rectangle.and(receivers)).collect()
            }
        })
    }

    /// The same in passes of at most 255 casters, each of which darkens for itself.
    pub(crate) fn drawn_guarded(&self, rule: Rule) -> Result<Drawn, String> {
        let volume = self
            .volume(End::Infinite)
            .map_err(|error| error.to_string())?;
        let mesh = &self.prepared.mesh;
        let mut drawn = Drawn {
            volume_triangles: volume.triangles.len(),
            ..Drawn::default()
        };
        for (view, truth) in &self.channels {
            let mut dark = vec![false; view.pixel_count()];
            let mut whole = Stencil::clear(view);
            let passes =
                u32::try_from(mesh.parts.len()).map_or(0, |parts| parts.div_ceil(MAX_COUNT));
            for pass in 0..passes {
                let mut stencil = Stencil::clear(view);
                let how =
                    |part: u32| (part / MAX_COUNT == pass).then(|| (rule, Rectangle::whole(view)));
                draw(&mut stencil, view, mesh, &volume, truth, &how);
                for (dark, is_dark) in dark.iter_mut().zip(stencil.mask()) {
                    *dark |= is_dark;
                }
                whole.updates += stencil.updates;
                for (sum, count) in whole.counts.iter_mut().zip(stencil.counts) {
                    *sum += count;
                }
            }
            drawn.add(&whole, &dark, truth);
        }
        Ok(drawn)
    }

    /// Which triangles face the sun.
    pub(crate) fn facing(&self) -> &Facing {
        &self.facing
    }

    /// Whether every triangle casts, see [`terrafill_casters::Policy::Robust`].
    pub(crate) fn is_robust(&self) -> bool {
        self.prepared.is_robust
    }

    /// Whether a triangle faces the sun.
    pub(crate) fn is_lit(&self, triangle: usize) -> bool {
        self.facing.is_lit[triangle]
    }

    /// A bit a triangle that faces the sun.
    pub(crate) fn lit_bits(&self) -> Vec<u32> {
        let words = self.facing.is_lit.chunks(u32::BITS as usize);
        let word = |lit: &[bool]| {
            let bits = lit.iter().rev();
            bits.fold(0, |word, is_lit| word << 1 | u32::from(*is_lit))
        };
        words.map(word).collect()
    }

    pub(crate) fn mesh(&self) -> &Mesh {
        &self.prepared.mesh
    }

    /// The channel with the most shadow.
    pub(crate) fn darkest_channel(&self) -> Option<usize> {
        (0..self.channels.len()).max_by_key(|at| self.channels[*at].1.count(Light::Shadow))
    }

    /// The channel with the most shadow alone, in a picture of that size; `None` where it has that size already.
    ///
    /// - `size`: the same whenever it is called
    pub(crate) fn timed_at(&self, size: [u32; 2]) -> Option<&Self> {
        let make = || {
            let (view, _) = self.darkest().filter(|(view, _)| view.size != size)?;
            let views = vec![view.sized(size)];
            let scene = Self::lit_from(self.prepared.clone(), self.to_light, views);
            Some(Box::new(scene))
        };
        self.timed.get_or_init(make).as_deref()
    }

    /// The same, for a picture.
    pub(crate) fn darkest(&self) -> Option<&(View, Truth)> {
        self.darkest_channel().map(|at| &self.channels[at])
    }

    /// Mask of one view.
    pub(crate) fn mask(
        &self,
        (view, truth): &(View, Truth),
        end: End,
        rule: Rule,
        scissor: Scissor,
    ) -> Result<Vec<bool>, String> {
        let volume = self.volume(end).map_err(|error| error.to_string())?;
        let stencil = self.stencil((view, truth), &volume, rule, scissor)?;
        Ok(stencil.mask())
    }

    /// What the volumes leave in one view.
    fn stencil(
        &self,
        (view, truth): (&View, &Truth),
        volume: &Volume,
        rule: Rule,
        scissor: Scissor,
    ) -> Result<Stencil, String> {
        let rectangles = self.rectangles(view, truth, scissor)?;
        let mut stencil = Stencil::clear(view);
        let how = |part: u32| Some((rule, rectangles[part as usize]));
        let mesh = &self.prepared.mesh;
        draw(&mut stencil, view, mesh, volume, truth, &how);
        Ok(stencil)
    }
}

impl Drawn {
    pub(crate) fn add(&mut self, stencil: &Stencil, mask: &[bool], truth: &Truth) {
        self.wrong = self.wrong.plus(Wrong::of(mask, truth));
        self.updates += stencil.updates;
        self.worst_channel_updates = self.worst_channel_updates.max(stencil.updates);
        self.max_overlap = self.max_overlap.max(stencil.max());
        for (at, is_dark) in mask.iter().enumerate() {
            if truth.light[at] == Light::Shadow && !is_dark {
                self.lost += 1;
                self.lost_on_casters += usize::from(matches!(truth.seen[at], Seen::Triangle(..)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_bounds_write_less_and_lose_nothing_unless_too_tight() {
        let scene = Scene::new([10.0, -60.0], [64, 48]).expect("a port");
        for rule in [Rule::Pass, Rule::Fail] {
            let whole = scene.drawn(End::Sea, rule, Scissor::Off).expect("above");
            let within = scene.drawn_within(rule, BOUNDS_SHARE).expect("above");
            assert_eq!(within.wrong, whole.wrong, "{}", rule.name());
            assert!(
                2 * within.updates < whole.updates,
                "{} {}",
                within.updates,
                whole.updates
            );
            let tight = scene.drawn_within(rule, -1.0 / 32.0).expect("above");
            assert!(tight.wrong.outside() > 0, "{}", rule.name());
        }
    }
}
