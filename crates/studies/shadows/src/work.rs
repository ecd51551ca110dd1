// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the cases compute.

use crate::count::{Rule, Stencil, Wrong, draw, draw_within};
use crate::near::shadowed_share;
use crate::reference::{Light, Reference, Seen, Truth};
use crate::scissor::{Rectangle, above_horizon, around_pixels, depths_of_parts, of_parts};
use crate::view::{View, bridge, deck_eyes, sun};
use glam::{DVec2, DVec3};
use terrafill_casters::{
    EdgeTable, Extent, Facing, LightError, Mesh, MeshError, Policy, PortSize, Prepared, Side,
    Volume, hull, port, row, sea_level_below,
};
use terrafill_results::SplitMix64;

/// Eyes on deck.
pub(crate) const EYES: usize = 400;
/// Near planes, m.
pub(crate) const NEARS: [f64; 3] = [0.1, 0.5, 1.0];
/// Below the sea at its lowest, m: waves of a harbour.
const MARGIN_M: f64 = 1.0;
/// The same of a sea without waves: what a device draws of it lies less below the sphere.
const CALM_M: f64 = 0.2;
/// Boxes along either axis, their size, m, and their seed.
const BOXES: [u32; 2] = [8, 12];
const BOX_M: f64 = 6.0;
const BOXES_SEED: u64 = 38;
/// Casters that 8 bits can count.
const MAX_COUNT: u32 = 255;

/// Ranges of depth are wider than volumes by this share, as a device's are for its rounding.
pub(crate) const BOUNDS_SHARE: f64 = 1.0 / 1024.0;

/// Where volumes end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum End {
    Infinite,
    Sea,
    /// Below a sea without waves.
    Calm,
    Finite(f64),
}

impl End {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Infinite => "infinite",
            Self::Sea => "sea-closed",
            Self::Calm => "sea-closed, calm",
            Self::Finite(_) => "finite",
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

/// How far beside a pixel's centre a device may look: rasterisers round corners to 1/256 of a pixel, and a
/// triangle thinner than some of these steps has any depth across it.
const ROUNDING_PX: f64 = 8.0 / 256.0;

/// The port under a sun, seen from the bridge.
pub(crate) struct Scene {
    pub(crate) to_light: DVec3,
    prepared: Prepared,
    facing: Facing,
    sides: Vec<Side>,
    pub(crate) channels: Vec<(View, Truth)>,
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

impl Scene {
    pub(crate) fn new(at: [f64; 2], size: [u32; 2]) -> Result<Self, String> {
        let named = PortSize::named("port-m").ok_or("no port-m")?;
        Self::of(port(named), at, bridge(size))
    }

    /// Plates in a row, seen from the side where all of their shadows lie over one another.
    pub(crate) fn of_row(count: u32, size: [u32; 2]) -> Result<Self, String> {
        let eye = DVec3::new(450.0, -250.0, 40.0);
        Self::of(
            row(count),
            [2.0, 180.0],
            vec![View::level(eye, 90.0, 0.5, size)],
        )
    }

    /// The eye on deck that stands in the light while most of its near rectangle is in shadow.
    pub(crate) fn of_missed_eye(at: [f64; 2], size: [u32; 2]) -> Result<Self, String> {
        let mesh = port(PortSize::named("port-m").ok_or("no port-m")?);
        let to_light = sun(at);
        let reference = Reference::new(&mesh, to_light);
        let near = NEARS[NEARS.len() - 1];
        let eyes = deck_eyes(&mesh, EYES, near).into_iter();
        let lit = eyes.filter(|view| !reference.is_shadowed(view.eye, None));
        let dark = lit.map(|view| (shadowed_share(&view, &reference), view));
        let worst = dark.max_by(|(one, _), (other, _)| one.total_cmp(other));
        let (share, view) = worst.ok_or("no eye in the light")?;
        if share == 0.0 {
            return Err("no eye is missed".to_owned());
        }
        drop(reference);
        Self::of(mesh, at, vec![View { size, ..view }])
    }

    /// Boxes over the sea, two faces of each of which are edge-on to the sun, or all turned at random.
    pub(crate) fn of_boxes(at: [f64; 2], is_edge_on: bool, size: [u32; 2]) -> Result<Self, String> {
        let to_light = sun(at);
        let mut random = SplitMix64::new(BOXES_SEED);
        // 53 bits are as many as an `f64` has.
        let mut share = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for column in 0..BOXES[0] {
            for row in 0..BOXES[1] {
                let mut direction = || DVec3::new(share(), share(), share());
                let (first, second) = (direction(), direction());
                let normal = match is_edge_on {
                    true => first.cross(to_light),
                    false => first,
                };
                let normal = normal.normalize_or(DVec3::X);
                let along = normal
                    .cross(second)
                    .normalize_or(normal.any_orthonormal_vector());
                let axes = [normal, along, normal.cross(along)].map(|axis| axis * BOX_M / 2.0);
                let [x, y] = [column, row].map(|place| 2.5 * BOX_M * f64::from(place));
                let middle = DVec3::new(x, y, 1.5 * BOX_M);
                let start = u32::try_from(vertices.len()).unwrap_or(u32::MAX);
                vertices.extend((0..8).map(|corner| {
                    let way = |bit: u32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
                    middle + axes[0] * way(0) + axes[1] * way(1) + axes[2] * way(2)
                }));
                let quads = [
                    [0, 4, 6, 2],
                    [1, 3, 7, 5],
                    [0, 1, 5, 4],
                    [2, 6, 7, 3],
                    [0, 2, 3, 1],
                    [4, 5, 7, 6],
                ];
                for [a, b, c, d] in quads.map(|quad| quad.map(|corner: u32| start + corner)) {
                    triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        let mesh = Mesh::from_triangles("boxes", vertices, triangles);
        let mesh = mesh.map_err(|error| error.to_string())?;
        let eye = DVec3::new(45.0, -120.0, 45.0);
        Self::of(mesh, at, vec![View::level(eye, 90.0, 0.5, size)])
    }

    /// A hull whose shadow falls towards the eye, seen from below its deck.
    pub(crate) fn of_hull(size: [u32; 2]) -> Result<Self, String> {
        let eye = DVec3::new(0.0, -150.0, 9.0);
        Self::of(
            hull(1_000),
            [30.0, 90.0],
            vec![View::level(eye, 90.0, 0.5, size)],
        )
    }

    /// The same caster with a tenth of its deck missing, by a policy: what it comes to against the whole
    /// one, and its triangles.
    ///
    /// # Errors
    /// What the policy refuses.
    pub(crate) fn drawn_open(&self, policy: Policy) -> Result<(Drawn, usize), MeshError> {
        let mut open = self.prepared.mesh.clone();
        // The deck is the last part of a hull's triangles.
        let is_deck =
            |at: &usize| open.normals[open.planes[*at] as usize].truncate() == DVec2::ZERO;
        let deck: Vec<usize> = (0..open.triangles.len()).filter(is_deck).collect();
        let missing = deck.len() * 45 / 100..deck.len() * 55 / 100;
        for at in deck[missing].iter().rev() {
            open.triangles.remove(*at);
            open.planes.remove(*at);
            open.parts[0].triangles.end -= 1;
        }
        let prepared = policy.prepare(open)?;
        let facing = Facing::of(&prepared.mesh, self.to_light);
        let sides = EdgeTable::of(&prepared.mesh).sides(&prepared, &facing);
        let caster = Self {
            to_light: self.to_light,
            channels: Vec::new(),
            facing,
            sides,
            prepared,
        };
        let volume = caster.volume(End::Sea).unwrap_or_default();
        let mut drawn = Drawn {
            volume_triangles: volume.triangles.len(),
            ..Drawn::default()
        };
        for (view, truth) in &self.channels {
            let mut stencil = Stencil::clear(view);
            let how = |_| Some((Rule::Fail, Rectangle::whole(view)));
            let mesh = &self.prepared.mesh;
            draw(&mut stencil, view, mesh, &volume, truth, &how);
            drawn.add(&stencil, &stencil.mask(), truth);
        }
        Ok((drawn, caster.prepared.mesh.triangles.len()))
    }

    pub(crate) fn of(mesh: Mesh, at: [f64; 2], views: Vec<View>) -> Result<Self, String> {
        let prepared = Policy::Refuse
            .prepare(mesh)
            .map_err(|error| error.to_string())?;
        Ok(Self::of_prepared(prepared, at, views))
    }

    pub(crate) fn of_prepared(prepared: Prepared, at: [f64; 2], views: Vec<View>) -> Self {
        let to_light = sun(at);
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
            End::Sea => Extent::ClosedAt(sea_level_below(mesh, self.to_light, MARGIN_M)?),
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

    /// Whether a device's rounding may give a pixel this light. Around its centre, [`ROUNDING_PX`] away, either
    /// the reference has that light or judges none, or on the way there the boundary of a single part's
    /// shadow is crossed: within the shadow of others it is no boundary of light.
    pub(crate) fn is_within_rounding(
        &self,
        reference: &Reference<'_>,
        view: &View,
        at: usize,
        light: Light,
    ) -> bool {
        let width = view.size[0] as usize;
        let [column, row] = [at % width, at / width].map(|at| u32::try_from(at).unwrap_or(0));
        let look = |right: f64, down: f64| {
            let beside = [right, down].map(|steps| steps * ROUNDING_PX);
            let ray = view.ray_beside(column, row, beside);
            let seen = reference.seen(view.eye, ray, view.near);
            let place = match seen {
                Seen::Sky => None,
                Seen::Sea(depth) | Seen::Triangle(_, depth) => Some(view.eye + ray * depth),
            };
            (reference.light(view, ray, seen), place)
        };
        let (_, own) = look(0.0, 0.0);
        let around = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
        around.into_iter().any(|(right, down)| {
            let (found, other) = look(right, down);
            let is_other_light =
                found == light || matches!(found, Light::EdgeOn | Light::Undecided);
            let ends = own.zip(other);
            let is_between = |(own, other)| self.is_side_between(own, other);
            is_other_light || ends.is_some_and(is_between)
        })
    }

    /// Whether the boundary of a part's shadow lies between two places: a silhouette edge crosses what is
    /// sunwards of the way from one to the other.
    fn is_side_between(&self, own: DVec3, other: DVec3) -> bool {
        let way = other - own;
        let normal = way.cross(self.to_light);
        let (across, sunwards) = (self.to_light.cross(normal), way.cross(normal));
        self.sides.iter().any(|side| {
            let [a, b] = side.map(|vertex| self.mesh().vertices[vertex as usize] - own);
            let [of_a, of_b] = [a, b].map(|place| place.dot(normal));
            if (of_a < 0.0) == (of_b < 0.0) {
                return false;
            }
            let met = a + (b - a) * (of_a / (of_a - of_b));
            let share = met.dot(across) / way.dot(across);
            let height = met.dot(sunwards) / self.to_light.dot(sunwards);
            (0.0..=1.0).contains(&share) && height > 0.0
        })
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
    fn rounding_excuses_few_pixels_outside_the_band() {
        let scene = Scene::new([10.0, -60.0], [64, 48]).expect("a port");
        let reference = Reference::new(scene.mesh(), scene.to_light);
        let (mut excused, mut all) = (0, 0);
        for (view, truth) in &scene.channels {
            for at in (0..truth.light.len()).filter(|at| !truth.band[*at]) {
                let other = match truth.light[at] {
                    Light::Lit => Light::Shadow,
                    Light::Shadow => Light::Lit,
                    _ => continue,
                };
                all += 1;
                let is_excused = scene.is_within_rounding(&reference, view, at, other);
                excused += usize::from(is_excused);
            }
        }
        // 116 of 9,170.
        assert!(all > 5_000 && 50 * excused < all, "{excused} of {all}");
        assert!(excused > 0);
    }

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

    #[test]
    fn a_side_lies_between_light_and_shadow_and_not_within_either() {
        let plate = [3.0, 5.0].map(|y| DVec3::new(0.0, y, 0.0));
        let scene = Scene::of(row(1), [30.0, 180.0], Vec::new()).expect("a plate");
        // 25 m high, under a sun at 30°: 43.3 m of shadow.
        let at = |x: f64| plate[0] + DVec3::X * x;
        assert!(scene.is_side_between(at(40.0), at(50.0)));
        assert!(!scene.is_side_between(at(10.0), at(40.0)));
        assert!(!scene.is_side_between(at(50.0), at(60.0)));
    }
}
