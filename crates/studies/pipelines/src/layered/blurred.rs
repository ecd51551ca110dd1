// SPDX-License-Identifier: MIT OR Apache-2.0
//! Motion blur on devices: a turning pot drawn into layers at moments of an exposure, or added up by blending.
//!
//! Stochastic blur gives each pixel moments of its own, but a rasteriser draws one moment a draw. What stands for it is
//! interleaved sampling (Keller and Heidrich, 2001). Each pixel of a tile of 2 × 2 has layers of its own, of half the
//! picture's side, at jittered moments. So a picture of n moments a pixel has the texels of n layers, of 4 n moments.

use super::listed::{Listed, numbers_of};
use super::on_wgpu::{Accumulator, DrawnInto};
use super::turning::{Layer, Turning, columns};
use crate::STUDY;
use crate::blur::{BlurError, Moments, Resolve, error_of, moment_of};
use crate::draws::{Looked, LooksUp, bits, differing, shown_hash};
use crate::images::{of_shares, size_px, square, write};
use crate::lights::LightWay;
use crate::meshes::size_of;
use crate::metrics::{self, API, EXPERIMENT, LAYERS_BY, MOMENTS, RESOLVE};
use crate::way::Interface;
use bytemuck::{Pod, Zeroable};
use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use terrafill_contract::{DeviceError, Devices, numbers_hash};
use terrafill_results::{PlannedCase, SplitMix64, Verdict};
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, Group, JudgedOnce, Request, Shows, judged,
    planned_case, verified,
};

/// Layers that a pixel is made of.
const LAYERS: [u32; 5] = [2, 4, 8, 16, 32];
const QUICK_LAYERS: [u32; 3] = [2, 8, 32];
/// Those of the published resolve.
const RESOLVED: [u32; 2] = [8, 32];
/// Layers of pictures that are kept.
const PICTURED: [u32; 2] = [2, 16];
/// How often a side of the pot's patches is divided.
const LEVEL: u32 = 8;
const QUICK_LEVEL: u32 = 4;
/// A side of a tile whose pixels have moments of their own.
const TILE: u32 = 2;
/// Depths in `f32`, and sums of at most 32 of them.
const SUM_OFF: f64 = 2e-5;

/// Twin of `Blurred` in `pipelines/blurred.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct BlurredConstants {
    count: u32,
    resolve: u32,
    tile: u32,
    padding: u32,
}

/// What is made of layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LayerUse {
    /// The mean of the middles of parts of the time.
    Mean,
    /// The same of jittered moments of a pixel's own.
    Jittered,
    Resolved(Resolve),
}

impl LayerUse {
    fn tile(self) -> u32 {
        if self == Self::Jittered { TILE } else { 1 }
    }

    /// Layers of so many a pixel, those of a pixel of a tile together.
    fn layers(self, count: u32) -> Vec<Layer> {
        let mut random = SplitMix64::new(5);
        let mut layers = Vec::new();
        let places = (0..self.tile()).flat_map(|y| (0..self.tile()).map(move |x| [x, y]));
        for place in places {
            let moments = match self {
                Self::Mean => Moments::Middle.all(count, &mut random),
                Self::Jittered => Moments::Stratified.all(count, &mut random),
                Self::Resolved(_) => (0..count).map(|of| moment_of(of, count)).collect(),
            };
            layers.extend(moments.into_iter().map(|moment| Layer { moment, place }));
        }
        layers
    }

    /// Of the layers at these moments, whatever is made of them.
    fn name(self) -> &'static str {
        match self {
            Self::Mean => "middle",
            Self::Jittered => "jittered",
            Self::Resolved(_) => "trail",
        }
    }

    /// Between which numbers a pixel may be whose layers have these ranges.
    fn allowed(self, ranges: &[[f64; 2]]) -> [f64; 2] {
        let count = u32::try_from(ranges.len()).unwrap_or(u32::MAX);
        let weight = |layer| match self {
            Self::Resolved(resolve) => resolve.weight(layer, count),
            _ => 1.0,
        };
        let weighted = |of: &dyn Fn(&[f64; 2]) -> f64| -> f64 {
            (0..)
                .zip(ranges)
                .map(|(at, own)| weight(at) * of(own))
                .sum()
        };
        let [low, high] = [0, 1].map(|end| weighted(&|own| own[end]));
        let all = weighted(&|_| 1.0);
        if self != Self::Resolved(Resolve::Published) {
            return [low / all, high / all];
        }
        let [sure, may] = [0, 1].map(|end| weighted(&|own| f64::from(u8::from(own[end] > 0.0))));
        if may <= 0.0 {
            return [0.0; 2];
        }
        if sure >= may {
            return [low / sure, high / sure];
        }
        // A border passes by: layers that may cover it add at most their own, and at least nothing.
        let most = ranges.iter().map(|own| own[1]).fold(0.0, f64::max);
        let highest = if sure > 0.0 {
            (high / sure).min(most)
        } else {
            most
        };
        [low / may, highest]
    }
}

/// By what layers come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum BlurWay {
    Layers(Interface, LightWay),
    /// Added up by blending, on wgpu.
    Added(Accumulator),
}

impl BlurWay {
    fn interface(self) -> Interface {
        match self {
            Self::Layers(interface, _) => interface,
            Self::Added(_) => Interface::Wgpu,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Layers(_, way) => way.name(),
            Self::Added(accumulator) => accumulator.name(),
        }
    }

    fn open(self, devices: &Devices, scene: &Listed) -> Result<Box<dyn LooksUp>, DeviceError> {
        match self {
            Self::Layers(interface, way) => scene.open(devices, interface, way),
            Self::Added(accumulator) => scene.open_wgpu(devices, DrawnInto::Sum(accumulator)),
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct BlurCase {
    way: BlurWay,
    made: LayerUse,
    /// That a pixel is made of.
    layers: u32,
}

fn cases(layers: u32) -> Vec<BlurCase> {
    let on_vulkan = |way| BlurWay::Layers(Interface::Vulkan, way);
    let case = |made| move |way| BlurCase { way, made, layers };
    let middles = LightWay::ALL.map(on_vulkan).into_iter();
    let middles = middles.chain([BlurWay::Layers(Interface::Wgpu, LightWay::Passes)]);
    let middles = middles.chain(Accumulator::ALL.map(BlurWay::Added));
    let mut cases: Vec<BlurCase> = middles.map(case(LayerUse::Mean)).collect();
    cases.push(case(LayerUse::Jittered)(on_vulkan(LightWay::Instanced)));
    if RESOLVED.contains(&layers) {
        let published = on_vulkan(LightWay::Copied);
        let resolved = Resolve::ALL.map(|resolve| case(LayerUse::Resolved(resolve))(published));
        cases.extend(resolved);
    }
    cases
}

/// What is blurred, made when the first group is opened.
type Shared = Rc<OnceCell<Turning>>;

/// Motion blur of so many layers.
struct Blurs {
    turning: Shared,
    level: u32,
    side: u32,
    cases: Vec<BlurCase>,
}

/// Motion blur on devices, a group for each number of layers: of all numbers together, layers would take gigabytes.
pub(crate) fn groups(request: &Request, samples: u32) -> Vec<impl Group + use<>> {
    let (counts, level): (&[u32], _) = if request.depth == Depth::Quick {
        (&QUICK_LAYERS, QUICK_LEVEL)
    } else {
        (&LAYERS, LEVEL)
    };
    let shared = Shared::default();
    let side = size_of(request).height;
    let of = |count: &u32| group(*count, Rc::clone(&shared), level, side, samples);
    counts.iter().map(of).collect()
}

fn group(layers: u32, turning: Shared, level: u32, side: u32, samples: u32) -> CaseGroup<Blurs> {
    let cases = cases(layers);
    CaseGroup {
        name: format!("{STUDY}/blurred-mesh/{layers}"),
        cases: cases
            .iter()
            .map(|case| case.planned(side, samples))
            .collect(),
        warm_up: None,
        work: Blurs {
            turning,
            level,
            side,
            cases,
        },
        open: |group, context| {
            let Blurs { level, side, .. } = group.work;
            Ok(Box::new(JudgedOnce::new(BlurSession {
                turning: group.work.turning.get_or_init(|| Turning::new(level, side)),
                group,
                context,
                ranges: BTreeMap::new(),
                first: BTreeMap::new(),
                opened: BTreeMap::new(),
            })))
        },
    }
}

impl BlurCase {
    fn planned(&self, side: u32, samples: u32) -> PlannedCase {
        let mut conditions = match self.made {
            LayerUse::Resolved(resolve) => vec![
                (EXPERIMENT, "blurred-mesh-resolve".to_owned()),
                (RESOLVE, resolve.name().to_owned()),
            ],
            made => vec![
                (EXPERIMENT, "blurred-mesh".to_owned()),
                (MOMENTS, made.name().to_owned()),
            ],
        };
        conditions.push((API, self.way.interface().name().to_owned()));
        conditions.push((LAYERS_BY, self.way.name().to_owned()));
        conditions.push((metrics::LAYERS, self.layers.to_string()));
        planned_case(STUDY, samples, conditions, Some(size_px(square(side))))
    }

    /// What is drawn.
    fn scene(&self, turning: &Turning, side: u32) -> Listed {
        let tile = self.made.tile();
        let (count, resolve) = match (self.way, self.made) {
            // The sum is one layer, as it is.
            (BlurWay::Added(_), _) => (1, 0),
            (_, LayerUse::Mean | LayerUse::Jittered) => (self.layers, 0),
            (_, LayerUse::Resolved(Resolve::Published)) => (self.layers, 1),
            (_, LayerUse::Resolved(Resolve::OverBackground)) => (self.layers, 2),
            (_, LayerUse::Resolved(Resolve::CurrentFirst)) => (self.layers, 3),
        };
        let constants = BlurredConstants {
            count,
            resolve,
            tile,
            padding: 0,
        };
        let layers = self.made.layers(self.layers).into_iter();
        Listed {
            places: turning.places(),
            layers: layers.map(|layer| columns(layer, side, tile)).collect(),
            side: side.div_ceil(tile),
            size: square(side),
            // Pictures of shadows look numbers up; these do not.
            values: vec![0.0],
            picture: "pipelines/blurred.wgsl",
            constants: bytemuck::bytes_of(&constants).to_vec(),
        }
    }

    /// Pixels that no rounding explains, and the error against all moments.
    ///
    /// - `ranges`: [`Turning::ranges`]
    fn judge(
        &self,
        turning: &Turning,
        ranges: &[Vec<[f64; 2]>],
        numbers: &[f32],
        side: u32,
    ) -> (usize, BlurError) {
        let rounding = match self.way {
            BlurWay::Added(accumulator) => SUM_OFF + accumulator.rounding(self.layers),
            BlurWay::Layers(..) => SUM_OFF,
        };
        let which = usize::from(matches!(self.made, LayerUse::Resolved(_)));
        let (mut wrong, mut pairs) = (0, Vec::new());
        let judged = turning.pixels.iter().zip(turning.exact()).zip(ranges);
        for (([column, row], exact), own) in judged {
            let shown = numbers.get((row * side + column) as usize);
            let shown = f64::from(shown.copied().unwrap_or(f32::NAN));
            let [low, high] = self.made.allowed(own);
            // What is no number is wrong.
            wrong += usize::from(!(low - rounding..=high + rounding).contains(&shown));
            if exact[which] > 0.0 {
                pairs.push((shown, exact[which]));
            }
        }
        (wrong, error_of(pairs.into_iter()))
    }
}

struct BlurSession<'a> {
    group: &'a CaseGroup<Blurs>,
    context: Context<'a>,
    turning: &'a Turning,
    /// Of layers by the name of their moments: ranges of pixels, and depths of the first way on Vulkan.
    ranges: BTreeMap<&'static str, Vec<Vec<[f64; 2]>>>,
    first: BTreeMap<&'static str, Vec<f32>>,
    /// By case.
    opened: BTreeMap<usize, Box<dyn LooksUp>>,
}

impl Shows for BlurSession<'_> {
    type Shown = Looked;

    fn show(&mut self, case: usize) -> Result<(String, Looked), Failure> {
        let Blurs {
            side, ref cases, ..
        } = self.group.work;
        let scene = cases[case].scene(self.turning, side);
        let mut opened = cases[case].way.open(self.context.devices, &scene)?;
        let looked = opened.draw()?;
        self.opened.insert(case, opened);
        let numbers = bits(&numbers_of(&looked.picture.rgba));
        let depths = numbers_hash(&bits(&looked.depths));
        let hash = format!("{}-{depths}", shown_hash(&numbers, &looked.counted));
        Ok((hash, looked))
    }

    fn judge(&mut self, case: usize, looked: Looked) -> Result<Verdict, Failure> {
        let Blurs {
            side, ref cases, ..
        } = self.group.work;
        let (blurred, turning) = (cases[case], self.turning);
        let moments = blurred.made.name();
        let side_px = side.div_ceil(blurred.made.tile());
        let ranges = self.ranges.entry(moments).or_insert_with(|| {
            let layers = blurred.made.layers(blurred.layers);
            turning.ranges(&layers, blurred.made.tile())
        });
        let numbers = numbers_of(&looked.picture.rgba);
        let (wrong, error) = blurred.judge(turning, ranges, &numbers, side);
        // Other sides are scaled with rounding, which llvmpipe does otherwise behind a geometry shader than without.
        // Jittered moments and trails come by one way, which is compared with nothing.
        let is_compared =
            blurred.made == LayerUse::Mean && blurred.way.interface() == Interface::Vulkan;
        let texels = (is_compared && side_px.is_power_of_two()).then(|| {
            let first = self.first.entry(moments);
            let first = first.or_insert_with(|| looked.depths.clone());
            let of_bits = |depths| bytemuck::cast_slice::<f32, u32>(depths);
            differing(of_bits(&looked.depths), of_bits(first))
        });
        let count = turning.pixels.len();
        let reason = if wrong > 0 {
            format!("{wrong} of {count} pixels are outside of what rounding allows")
        } else if let Some(texels) = texels.filter(|texels| *texels > 0) {
            format!("{texels} texels of layers differ from the first way's")
        } else if error.rms.is_nan() {
            "it shows nothing".to_owned()
        } else {
            String::new()
        };
        let opened = &self.opened[&case];
        let mut figures = vec![
            ("blur_rms", error.rms),
            ("blur_max", error.max),
            ("layered_wrong_px", wrong as f64),
            ("layered_judged_px", count as f64),
            ("pipeline_held_bytes", opened.bytes() as f64),
            ("lights_passes", opened.passes() as f64),
        ];
        figures.retain(|(_, value)| value.is_finite());
        figures.extend(texels.map(|texels| ("lights_depths_differing", texels as f64)));
        figures.extend(looked.counted.figures());
        let is_first = blurred.way == BlurWay::Layers(Interface::Vulkan, LightWay::Passes);
        let is_shown = is_first && PICTURED.contains(&blurred.layers);
        let notes = if is_shown || !reason.is_empty() {
            let name = &self.group.cases[case].id.name;
            write(self.context.folder, name, square(side), of_shares(&numbers))?
        } else {
            Vec::new()
        };
        Ok(judged(reason, figures, notes))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        Ok(verified(&mut self.opened, case)?.time()?.figures())
    }
}

#[cfg(test)]
mod tests;
