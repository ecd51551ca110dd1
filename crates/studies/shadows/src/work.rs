// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the cases compute.

mod rounding;
mod side_grid;
mod staged;

use self::side_grid::SideGrid;
use glam::DVec3;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use std::sync::OnceLock;
use terrafill_casters::{
    EdgeTable, Extent, Facing, Mesh, Policy, PortSize, Prepared, Side, Volume, feet_below_sea,
    port, sea_level_below,
};
#[cfg(test)]
use terrafill_shadow_views::bridge;
use terrafill_shadow_views::{
    DeckCamera, Light, Pass, Reference, Rule, Seen, Stencil, Truth, Wrong, above_horizon,
    around_pixels, depths_of_parts, of_parts, sun,
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
const MAX_COUNT: usize = 255;

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

terrafill_results::named! {
    /// What the stencil is restricted to.
    all pub(crate) enum Scissor {
        Off = "off",
        /// Rows above the horizon: a reading of "sea level" that the paper does not have.
        Horizon = "horizon",
        /// The rectangle round all that is drawn above the sea.
        SeaLevel = "sea-level",
        CasterRectangle = "caster-rect",
        ReceiverRectangle = "receiver-rect",
    }
}

/// The port under a sun, seen from the bridge.
pub(crate) struct Scene {
    pub(crate) to_light: DVec3,
    pub(crate) prepared: Prepared,
    pub(crate) facing: Facing,
    sides: Vec<Side>,
    /// Of each channel.
    pub(crate) views: Vec<DeckCamera>,
    /// Of the same, found where somebody first asks: a process that only times never does.
    truths: OnceLock<Vec<Truth>>,
    side_grid: OnceLock<SideGrid>,
}

/// Figures of one way of drawing, summed over all channels.
#[derive(Debug, Clone, Default)]
pub(crate) struct ChannelTotals {
    pub(crate) wrong: Wrong,
    pub(crate) updates: u64,
    pub(crate) max_overlap: i32,
    pub(crate) volume_triangles: usize,
    /// Of each channel.
    pub(crate) masks: Vec<Vec<bool>>,
}

impl ChannelTotals {
    /// With those of the next channels of the same volume.
    fn with(mut self, next: Self) -> Self {
        self.wrong = self.wrong.plus(next.wrong);
        self.updates += next.updates;
        self.max_overlap = self.max_overlap.max(next.max_overlap);
        self.masks.extend(next.masks);
        self
    }
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

pub(crate) fn port_m() -> Result<Mesh, String> {
    Ok(port(PortSize::named("port-m").ok_or("no port-m")?))
}

/// Of a closed mesh.
pub(crate) fn closed(mesh: Mesh) -> Result<Prepared, String> {
    let prepared = Policy::Refuse.prepare(mesh);
    prepared.map_err(|error| error.to_string())
}

impl Scene {
    /// The port, cut below the sea.
    pub(crate) fn of_port(at: [f64; 2], views: Vec<DeckCamera>) -> Result<Self, String> {
        Self::standing(&closed(port_m()?)?, at, views, End::Sea.feet_m())
    }

    /// The same from the bridge.
    #[cfg(test)]
    pub(crate) fn new(at: [f64; 2], size: [u32; 2]) -> Result<Self, String> {
        Self::of_port(at, bridge(size))
    }

    /// Casters cut so far below the sea, or not at all.
    pub(crate) fn standing(
        prepared: &Prepared,
        at: [f64; 2],
        views: Vec<DeckCamera>,
        feet_m: Option<f64>,
    ) -> Result<Self, String> {
        let prepared = match feet_m {
            Some(feet_m) => prepared.cut_below(&feet_below_sea(&prepared.mesh, feet_m)),
            None => Ok(prepared.clone()),
        };
        let prepared = prepared.map_err(|error| error.to_string())?;
        Ok(Self::lit_from(prepared, sun(at), views))
    }

    pub(crate) fn of(mesh: Mesh, at: [f64; 2], views: Vec<DeckCamera>) -> Result<Self, String> {
        Ok(Self::lit_from(closed(mesh)?, sun(at), views))
    }

    pub(crate) fn lit_from(prepared: Prepared, to_light: DVec3, views: Vec<DeckCamera>) -> Self {
        let facing = Facing::of(&prepared.mesh, to_light);
        let sides = EdgeTable::of(&prepared.mesh).sides(&prepared, &facing);
        Self {
            to_light,
            views,
            truths: OnceLock::new(),
            side_grid: OnceLock::new(),
            facing,
            sides,
            prepared,
        }
    }

    /// What the reference says of each channel.
    pub(crate) fn truths(&self) -> &[Truth] {
        self.truths.get_or_init(|| {
            let reference = Reference::new(self.mesh(), self.to_light);
            let views = self.views.iter();
            views.map(|view| reference.picture(view)).collect()
        })
    }

    /// Each channel with what the reference says of it.
    pub(crate) fn channels(
        &self,
    ) -> impl DoubleEndedIterator<Item = (&DeckCamera, &Truth)> + ExactSizeIterator {
        self.views.iter().zip(self.truths())
    }

    pub(crate) fn pixels(&self) -> Pixels {
        let mut pixels = Pixels::default();
        for truth in self.truths() {
            pixels.all += truth.seen.len();
            pixels.receivers += truth.seen.len() - truth.count(Light::Sky);
            pixels.shadow += truth.count(Light::Shadow);
            pixels.edge_on += truth.count(Light::EdgeOn);
            pixels.undecided += truth.count(Light::Undecided);
        }
        pixels
    }

    pub(crate) fn volume(&self, end: End) -> Result<Volume, String> {
        self.volume_of(&self.sides, end)
    }

    /// Volumes that these sides enclose.
    pub(crate) fn volume_of(&self, sides: &[Side], end: End) -> Result<Volume, String> {
        let mesh = &self.prepared.mesh;
        let at_sea = |margin_m| {
            let level = sea_level_below(mesh, self.to_light, margin_m);
            level
                .map(Extent::ClosedAt)
                .map_err(|error| error.to_string())
        };
        let extent = match end {
            End::Infinite => Extent::Infinite,
            End::Sea | End::SeaOfWhole => at_sea(MARGIN_M)?,
            End::Calm => at_sea(CALM_M)?,
            End::Finite(length) => Extent::Finite(length),
        };
        let volume = Volume::of(&self.prepared, &self.facing, sides, self.to_light, &extent);
        volume.map_err(|error| error.to_string())
    }

    /// Draws a volume in every channel.
    ///
    /// - `how`: of a channel its passes, each of which darkens for itself
    pub(crate) fn draw_by(
        &self,
        volume: &Volume,
        how: impl Fn(&DeckCamera, &Truth) -> Vec<Pass> + Sync,
    ) -> ChannelTotals {
        let mesh = &self.prepared.mesh;
        let draw = |(view, truth): &(&DeckCamera, &Truth)| {
            let mut drawn = ChannelTotals::default();
            let mut counts = vec![0; view.pixel_count()];
            let mut mask = vec![false; view.pixel_count()];
            for pass in how(view, truth) {
                let stencil = Stencil::of(view, mesh, volume, truth, &pass);
                for (dark, is_dark) in mask.iter_mut().zip(stencil.mask()) {
                    *dark |= is_dark;
                }
                drawn.updates += stencil.updates;
                for (sum, count) in counts.iter_mut().zip(stencil.counts) {
                    *sum += count;
                }
            }
            drawn.wrong = Wrong::of(&mask, truth);
            drawn.max_overlap = counts.into_iter().fold(0, i32::max);
            drawn.masks.push(mask);
            drawn
        };
        let channels: Vec<_> = self.channels().collect();
        let drawn: Vec<ChannelTotals> = channels.par_iter().map(draw).collect();
        let none = ChannelTotals {
            volume_triangles: volume.triangles.len(),
            ..ChannelTotals::default()
        };
        drawn.into_iter().fold(none, ChannelTotals::with)
    }

    /// All parts by one rule, wherever they are.
    pub(crate) fn whole(&self, view: &DeckCamera, rule: Rule) -> Pass {
        let part = Some((rule, view.whole()));
        Pass {
            parts: vec![part; self.prepared.mesh.parts.len()],
            bounds: Vec::new(),
        }
    }

    /// Draws all volumes in every channel.
    pub(crate) fn drawn(
        &self,
        end: End,
        rule: Rule,
        scissor: Scissor,
    ) -> Result<ChannelTotals, String> {
        let volume = self.volume(end)?;
        // A caster's rectangle holds its volume closed at the sea, wherever the one that is drawn ends.
        let closed = match scissor {
            Scissor::Off | Scissor::Horizon | Scissor::SeaLevel => None,
            _ => Some(self.volume(End::Sea)?),
        };
        Ok(self.draw_by(&volume, |view, truth| {
            let mut pass = self.whole(view, rule);
            let within = match scissor {
                Scissor::Off | Scissor::CasterRectangle => view.whole(),
                Scissor::Horizon => above_horizon(view),
                Scissor::SeaLevel | Scissor::ReceiverRectangle => {
                    around_pixels(view, |at| matches!(truth.seen[at], Seen::Triangle(..)))
                }
            };
            let own = closed
                .as_ref()
                .map(|closed| of_parts(view, closed, pass.parts.len()));
            for (at, part) in pass.parts.iter_mut().enumerate() {
                let own = own.as_ref().map_or(within, |own| own[at].within(within));
                *part = Some((rule, own));
            }
            vec![pass]
        }))
    }

    /// The same closed at the sea, where what is seen lies in each part's range of depths.
    ///
    /// - `share`: by which ranges are wider than the volumes
    pub(crate) fn drawn_within(&self, rule: Rule, share: f64) -> Result<ChannelTotals, String> {
        let volume = self.volume(End::Sea)?;
        let parts = self.prepared.mesh.parts.len();
        Ok(self.draw_by(&volume, |view, _| {
            vec![Pass {
                bounds: depths_of_parts(view, &volume, parts, share),
                ..self.whole(view, rule)
            }]
        }))
    }

    /// The same in passes of at most 255 casters, each of which darkens for itself.
    pub(crate) fn drawn_guarded(&self, rule: Rule) -> Result<ChannelTotals, String> {
        let volume = self.volume(End::Infinite)?;
        let count = self.prepared.mesh.parts.len();
        Ok(self.draw_by(&volume, |view, _| {
            let pass = |first: usize| {
                let mut pass = self.whole(view, rule);
                let past = count.min(first + MAX_COUNT);
                pass.parts[..first].fill(None);
                pass.parts[past..].fill(None);
                pass
            };
            (0..count).step_by(MAX_COUNT).map(pass).collect()
        }))
    }

    /// Whether a triangle faces the sun.
    pub(crate) fn is_lit(&self, triangle: usize) -> bool {
        self.facing.is_lit[triangle]
    }

    pub(crate) fn mesh(&self) -> &Mesh {
        &self.prepared.mesh
    }

    /// The channel with the most shadow.
    pub(crate) fn darkest_channel(&self) -> Result<usize, String> {
        let truths = self.truths();
        let shadow = |at: &usize| truths[*at].count(Light::Shadow);
        let darkest = (0..truths.len()).max_by_key(shadow);
        darkest.ok_or_else(|| "no channel".to_owned())
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
            let [few, all] = [within.updates, whole.updates];
            assert!(2 * few < all, "{few} {all}");
            let tight = scene.drawn_within(rule, -1.0 / 32.0).expect("above");
            assert!(tight.wrong.outside() > 0, "{}", rule.name());
        }
    }
}
