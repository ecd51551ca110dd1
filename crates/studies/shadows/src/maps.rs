// SPDX-License-Identifier: MIT OR Apache-2.0
//! The rival: a shadow map (Williams, 1978), drawn and asked on the CPU.
//!
//! Orthographic along the light, fitted to the casters, one axis level: texels lie along the sun's
//! azimuth. A texel holds the distance of what is nearest to the sun at its centre, in `f32`. A receiver
//! asks the texel that it lies in. Faces turned away from the sun are dark without asking.

use crate::work::Scene;
use glam::{DVec2, DVec3};
use terrafill_casters::Mesh;
use terrafill_core::nearest_f32;
use terrafill_shadow_views::{DeckCamera, Seen, Truth, Wrong, whole};
use terrafill_study::Failure;

/// The most bytes of a map.
const MAX_BYTES: f64 = 2.5e9;
/// Steps of a constant bias, m along the light.
const CONSTANT_M: [f64; 13] = [
    0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0,
];
/// Steps of a bias by slope, in texels times the tangent between normal and light.
const SLOPE_TEXELS: [f64; 7] = [0.0, 0.25, 0.5, 0.71, 1.0, 1.5, 2.0];

terrafill_results::named! {
    /// What keeps a lit receiver from being in its own shadow.
    all pub(crate) enum Bias {
        /// So many metres.
        Constant = "constant",
        /// So many texels times the slope of the receiver against the light.
        Slope = "slope",
        /// So many metres, and faces turned away from the sun ask the map too, as where a shader knows no normal.
        ///
        /// [`Mapped::wrong_in_three`] with this bias is what another program's curve agrees with: 0.6 % at 5 cm, 2 % at
        /// 25 cm, 3.8 % at 1 m. Its definition was found by trying several.
        Everywhere = "constant, no normals",
    }
}

impl Bias {
    /// Of devices.
    pub(crate) const DRAWN: [Self; 2] = [Self::Constant, Self::Slope];

    pub(crate) fn steps(self) -> &'static [f64] {
        match self {
            Self::Constant | Self::Everywhere => &CONSTANT_M,
            Self::Slope => &SLOPE_TEXELS,
        }
    }

    /// Metres of a step.
    ///
    /// - `slope`: tangent between normal and light
    pub(crate) fn metres(self, step: f64, texel_m: f64, slope: f64) -> f64 {
        match self {
            Self::Constant | Self::Everywhere => step,
            Self::Slope => step * texel_m * slope,
        }
    }
}

/// Where a map lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    to_light: DVec3,
    /// Level, and upwards across the light.
    axes: [DVec3; 2],
    low: DVec2,
    pub(crate) texel_m: f64,
    pub(crate) columns: usize,
    pub(crate) rows: usize,
}

/// Distances towards the sun by texel.
pub(crate) struct Map {
    frame: Frame,
    /// From the origin towards the sun, m; −∞ where nothing is.
    nearest_m: Vec<f32>,
}

impl Frame {
    /// Round all casters.
    ///
    /// # Errors
    /// [`Failure::Unable`] where it has more texels than it may.
    pub(crate) fn of(mesh: &Mesh, to_light: DVec3, texel_m: f64) -> Result<Self, Failure> {
        let level = DVec3::Z.cross(to_light).try_normalize().unwrap_or(DVec3::X);
        let axes = [level, to_light.cross(level)];
        let flat = |place: DVec3| DVec2::new(place.dot(axes[0]), place.dot(axes[1]));
        let places = || mesh.vertices.iter().map(|place| flat(*place));
        let low = places().fold(DVec2::INFINITY, DVec2::min);
        let high = places().fold(low, DVec2::max);
        let count = ((high - low) / texel_m).ceil().max(DVec2::ONE);
        let bytes = count.x * count.y * size_of::<f32>() as f64;
        if bytes > MAX_BYTES {
            let [found, allowed] = [bytes, MAX_BYTES].map(|bytes| bytes / 1e6);
            return Err(Failure::Unable(format!(
                "a map of texels of {texel_m} m takes {found:.0} MB, allowed: {allowed} MB"
            )));
        }
        let [columns, rows] = count.to_array().map(|count| whole(count) as usize);
        Ok(Self {
            to_light,
            axes,
            low,
            texel_m,
            columns,
            rows,
        })
    }

    /// The same so many texels aside, along either axis.
    #[cfg(test)]
    pub(crate) fn moved(mut self, texels: f64) -> Self {
        self.low += texels * self.texel_m;
        self
    }

    /// In texels from the low corner.
    pub(crate) fn place(&self, place: DVec3) -> DVec2 {
        let flat = DVec2::new(place.dot(self.axes[0]), place.dot(self.axes[1]));
        (flat - self.low) / self.texel_m
    }

    /// Of casters along the light, lowest and highest, m; the lowest a metre lower, since the least depth stands
    /// for nothing.
    pub(crate) fn heights(&self, mesh: &Mesh) -> [f64; 2] {
        let all = || mesh.vertices.iter().map(|place| place.dot(self.to_light));
        [
            all().fold(f64::INFINITY, f64::min) - 1.0,
            all().fold(f64::NEG_INFINITY, f64::max),
        ]
    }
}

impl Map {
    /// # Errors
    /// As [`Frame::of`].
    pub(crate) fn of(mesh: &Mesh, to_light: DVec3, texel_m: f64) -> Result<Self, Failure> {
        let frame = Frame::of(mesh, to_light, texel_m)?;
        let mut map = Self {
            frame,
            nearest_m: vec![f32::NEG_INFINITY; frame.columns * frame.rows],
        };
        for triangle in 0..mesh.triangles.len() {
            map.draw(mesh.corners(triangle));
        }
        Ok(map)
    }

    pub(crate) fn bytes(&self) -> u64 {
        size_of_val(&*self.nearest_m) as u64
    }

    /// Texels whose centres lie between two places along an axis.
    fn between(low: f64, high: f64, count: usize) -> std::ops::Range<usize> {
        let at = |place: f64| whole((place - 0.5).ceil().clamp(0.0, count as f64)) as usize;
        at(low)..at(high).max(at(low))
    }

    fn draw(&mut self, corners: [DVec3; 3]) {
        let frame = self.frame;
        let [a, b, c] = corners.map(|corner| frame.place(corner));
        let (ab, ac) = (b - a, c - a);
        let area = ab.perp_dot(ac);
        if area == 0.0 {
            return;
        }
        let heights = corners.map(|corner| corner.dot(frame.to_light));
        let rise = [heights[1] - heights[0], heights[2] - heights[0]];
        let low = a.min(b).min(c);
        let high = a.max(b).max(c);
        for row in Self::between(low.y, high.y, frame.rows) {
            let y = row as f64 + 0.5;
            // Where the row's centre line meets the triangle's edges.
            let mut span = [f64::INFINITY, f64::NEG_INFINITY];
            for (from, to) in [(a, b), (b, c), (c, a)] {
                if (from.y <= y) != (to.y <= y) {
                    let x = from.x + (to.x - from.x) * ((y - from.y) / (to.y - from.y));
                    span = [span[0].min(x), span[1].max(x)];
                }
            }
            if span[0] > span[1] {
                continue;
            }
            for column in Self::between(span[0], span[1], frame.columns) {
                let at = DVec2::new(column as f64 + 0.5, y) - a;
                let shares = [at.perp_dot(ac) / area, ab.perp_dot(at) / area];
                let height = heights[0] + shares[0] * rise[0] + shares[1] * rise[1];
                let own = &mut self.nearest_m[row * frame.columns + column];
                *own = own.max(nearest_f32(height));
            }
        }
    }

    /// How far above a place, along the light, the map has something; −∞ where it has nothing.
    fn above(&self, place: DVec3) -> f64 {
        let at = self.frame.place(place);
        let [columns, rows] = [self.frame.columns, self.frame.rows];
        let is_in = at.x >= 0.0 && at.y >= 0.0 && at.x < columns as f64 && at.y < rows as f64;
        if !is_in {
            return f64::NEG_INFINITY;
        }
        let [column, row] = at.to_array().map(whole);
        let texel = row as usize * columns + column as usize;
        f64::from(self.nearest_m[texel]) - place.dot(self.frame.to_light)
    }
}

/// What a map says of a receiver pixel.
pub(crate) struct Asked {
    /// What the map has above it along the light, m; −∞ outside the map.
    above_m: f64,
    /// Tangent between normal and light; `None` where the face is turned away.
    slope: Option<f64>,
}

/// What a map came to.
#[derive(Debug, Clone, Default)]
pub(crate) struct Mapped {
    pub(crate) wrong: Wrong,
    /// Receiver pixels that the reference judges.
    pub(crate) judged: usize,
    /// Of these, wrong without a bias.
    pub(crate) unbiased: usize,
    /// The best step, and what it is in metres on level ground.
    pub(crate) step: f64,
    pub(crate) bias_m: f64,
    pub(crate) bytes: u64,
    /// Share of wrong pixels, the band included, of those that the reference judges: sea and casters, lit or in
    /// shadow, no sky, no edge-on faces. Of the three channels that see most pixels of casters, at the step that is best
    /// for these three together.
    pub(crate) wrong_in_three: f64,
    /// Of each channel, at that step.
    pub(crate) masks: Vec<Vec<bool>>,
}

impl Scene {
    /// Shadows by a map with texels of this size, at the step of the bias that leaves the fewest wrong.
    pub(crate) fn mapped(&self, texel_m: f64, bias: Bias) -> Result<Mapped, Failure> {
        let map = Map::of(self.mesh(), self.to_light, texel_m)?;
        let asked = self.asked(&map);
        let masks = |step: f64| -> Vec<Vec<bool>> {
            let is_dark = |asked: &Option<Asked>| {
                asked.as_ref().is_some_and(|asked| {
                    let above = |slope| asked.above_m > bias.metres(step, texel_m, slope);
                    match bias {
                        Bias::Everywhere => above(0.0),
                        Bias::Constant | Bias::Slope => asked.slope.is_none_or(above),
                    }
                })
            };
            let channels = asked.iter();
            channels
                .map(|channel| channel.iter().map(is_dark).collect())
                .collect()
        };
        let unbiased = self.wrong(&masks(0.0)).all();
        let steps = bias.steps().iter().copied();
        let best = steps.min_by_key(|step| self.wrong(&masks(*step)).all());
        let best = best.unwrap_or(0.0);
        let three = self.with_most_casters(3);
        let in_three = |step: &f64| {
            let masks = masks(*step);
            let (mut sum, mut judged) = (Wrong::default(), 0);
            for &channel in &three {
                let truth = &self.truths()[channel];
                sum = sum.plus(Wrong::of(&masks[channel], truth));
                judged += truth.judged();
            }
            sum.all() as f64 / judged.max(1) as f64
        };
        let wrong_in_three = bias.steps().iter().map(in_three).fold(1.0, f64::min);
        let masks = masks(best);
        let level = self.to_light.z;
        let level_slope = (1.0 - level * level).max(0.0).sqrt() / level;
        Ok(Mapped {
            wrong: self.wrong(&masks),
            judged: self.judged(),
            unbiased,
            bias_m: bias.metres(best, texel_m, level_slope),
            bytes: map.bytes(),
            step: best,
            wrong_in_three,
            masks,
        })
    }

    /// So many channels, those that see most pixels of casters.
    fn with_most_casters(&self, count: usize) -> Vec<usize> {
        let truths = self.truths();
        let seen = |at: &usize| {
            let seen = truths[*at].seen.iter();
            seen.filter(|seen| matches!(seen, Seen::Triangle(..)))
                .count()
        };
        let mut channels: Vec<usize> = (0..truths.len()).collect();
        channels.sort_by_cached_key(|at| std::cmp::Reverse(seen(at)));
        channels.truncate(count);
        channels
    }

    pub(crate) fn judged(&self) -> usize {
        self.truths().iter().map(Truth::judged).sum()
    }

    /// Masks of all channels against the reference.
    pub(crate) fn wrong(&self, masks: &[Vec<bool>]) -> Wrong {
        let channels = masks.iter().zip(self.truths());
        channels.fold(Wrong::default(), |sum, (mask, truth)| {
            sum.plus(Wrong::of(mask, truth))
        })
    }

    /// What the map says of each pixel of each channel; `None` for the sky.
    pub(crate) fn asked(&self, map: &Map) -> Vec<Vec<Option<Asked>>> {
        let channels = self.channels();
        channels
            .map(|(view, truth)| self.asked_of(map, view, truth))
            .collect()
    }

    fn asked_of(&self, map: &Map, view: &DeckCamera, truth: &Truth) -> Vec<Option<Asked>> {
        let mesh = self.mesh();
        let pixel = |(at, seen): (usize, &Seen)| {
            let (depth, normal) = match *seen {
                Seen::Sky => return None,
                Seen::Sea(depth) => (depth, DVec3::Z),
                Seen::Triangle(triangle, depth) => {
                    let plane = mesh.planes[triangle as usize];
                    (depth, mesh.normals[plane as usize].normalize_or_zero())
                }
            };
            let [column, row] = view.pixel(at);
            let cosine = normal.dot(self.to_light);
            let slope = (1.0 - cosine * cosine).max(0.0).sqrt() / cosine;
            Some(Asked {
                above_m: map.above(view.eye + view.ray(column, row) * depth),
                slope: (cosine > 0.0).then_some(slope),
            })
        };
        truth.seen.iter().enumerate().map(pixel).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_casters::row;
    use terrafill_shadow_views::sun;

    fn share(mapped: &Mapped) -> f64 {
        mapped.wrong.all() as f64 / mapped.judged as f64
    }

    #[test]
    fn a_map_knows_the_shadow_of_a_plate_to_a_texel() {
        let mesh = row(1);
        let map = Map::of(&mesh, sun([30.0, 180.0]), 0.1).expect("small");
        let ends = 0.1 + 25.0 / 30_f64.to_radians().tan();
        let is_dark = |x: f64, bias_m: f64| map.above(DVec3::new(x, 3.0, 0.0)) > bias_m;
        assert!(is_dark(1.0, 0.2) && is_dark(ends - 0.5, 0.2));
        assert!(!is_dark(ends + 0.5, 0.2) && !is_dark(-1.0, 0.2));
        // Negative control: a bias longer than the plate's shadow loses it.
        assert!(!is_dark(ends - 0.5, 60.0));
    }

    #[test]
    fn finer_texels_leave_fewer_wrong_and_no_bias_far_more() {
        let scene = Scene::new([10.0, -60.0], [64, 48]).expect("a port");
        for bias in Bias::DRAWN {
            let [fine, coarse] = [0.25, 2.0].map(|texel| scene.mapped(texel, bias).expect("small"));
            let [of_fine, of_coarse] = [&fine, &coarse].map(share);
            assert!(of_fine < of_coarse, "{bias:?}: {of_fine} {of_coarse}");
            assert!((0.001..0.05).contains(&of_fine), "{of_fine}");
            // Without a bias, texels shade the very casters that they show.
            let wrong = fine.wrong.all();
            assert!(fine.unbiased > 5 * wrong, "{} {wrong}", fine.unbiased);
            assert!(fine.bias_m > 0.0);
            assert!(fine.masks.len() == 7 && fine.masks.iter().all(|mask| mask.len() == 64 * 48));
        }
    }
    /// The facts sheet's curve: its map knew no normals, and its shares were of three channels that see casters.
    #[test]
    fn a_map_without_normals_lights_what_is_thinner_than_its_bias() {
        let scene = Scene::new([10.0, -60.0], [64, 48]).expect("a port");
        let [with, without] =
            [Bias::Constant, Bias::Everywhere].map(|bias| scene.mapped(1.0, bias).expect("small"));
        let lit = |mapped: &Mapped| mapped.wrong.false_lit + mapped.wrong.in_band;
        assert!(lit(&without) > lit(&with), "{without:?} {with:?}");
        // 3.8 % are computed elsewhere, of 7,178 samples.
        let (in_three, in_all) = (without.wrong_in_three, share(&without));
        assert!((0.02..0.06).contains(&in_three), "{in_three}");
        // Channels without casters are right.
        assert!(in_all < in_three, "{in_all} {in_three}");
    }

    #[test]
    fn a_map_that_fills_the_memory_is_refused() {
        let refused = Map::of(&row(1), sun([30.0, 180.0]), 1e-4).map(|map| map.bytes());
        let Err(Failure::Unable(words)) = refused else {
            panic!("billions of texels");
        };
        assert!(words.contains("allowed: 2500 MB"), "{words}");
    }
}
