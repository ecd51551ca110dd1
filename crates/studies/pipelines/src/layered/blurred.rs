// SPDX-License-Identifier: MIT OR Apache-2.0
//! Motion blur on devices: a bar drawn into layers at moments of an exposure, added up by blending, or looked up at
//! moments of each pixel's own.
//!
//! A picture has 64 rows, each with a bar of another place between pixels, so that it has all phases at once.

use super::listed::{Listed, numbers_of, rectangle};
use super::on_wgpu::{Accumulator, Into};
use crate::STUDY;
use crate::blur::{
    BAR_PX, BlurError, Filter, MOTION_PX, Moments, PHASES, PIXELS, Resolve, error_of, fading,
    moment_of, starts,
};
use crate::cache::scatter;
use crate::draws::{LooksUp, bits, differing};
use crate::images::square;
use crate::lights::{LightColumns, LightWay};
use crate::metrics::{self, API, EXPERIMENT, FILTER, LAYERS_BY, MOMENTS, RESOLVE, SIZE_PX};
use crate::way::Interface;
use bytemuck::{Pod, Zeroable};
use std::collections::BTreeMap;
use terrafill_contract::{DeviceError, Devices};
use terrafill_results::{PlannedCase, SplitMix64, Verdict};
use terrafill_shapes::grid::nearest;
use terrafill_study::{
    CaseGroup, Context, Failure, Figures, Group, Session, judged, planned_case, verified,
};

/// A side of the picture, pixels.
const SIDE: u32 = 64;
/// Where the first pixel of the trail lies, so that nothing is clipped.
const FIRST: u32 = 2;
/// Layers of an exposure, and of the published resolve.
const LAYERS: [u32; 6] = [4, 8, 16, 32, 64, 128];
const QUICK_LAYERS: [u32; 3] = [32, 64, 128];
const RESOLVED: [u32; 4] = [4, 8, 16, 32];
/// Within this of a pixel's middle an edge may be on either side: half a step of the coarsest grid of places.
const BAND_PX: f64 = 1.0 / 32.0;
/// By how much a covered share may be off: both edges by half a step of 1/256 pixel.
const SHARE_OFF: f64 = 1.0 / 256.0;
/// Sums of at most 128 numbers up to 1 in `f32`.
const SUM_OFF: f64 = 2e-5;

/// Twin of `Blurred` in `pipelines/blurred.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct BlurredConstants {
    count: u32,
    resolve: u32,
    motion: f32,
    bar: f32,
    pixels: u32,
    padding: [u32; 3],
}

/// What is made of layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LayerUse {
    /// Their mean, at middles or ends.
    Mean {
        filter: Filter,
        moments: Moments,
    },
    Resolved(Resolve),
}

/// By what layers come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum BlurWay {
    Layers(Interface, LightWay),
    /// Added up by blending, on wgpu.
    Added(Accumulator),
    /// No layers: moments of each pixel's own.
    Own(Interface),
}

impl BlurWay {
    fn interface(self) -> Interface {
        match self {
            Self::Layers(interface, _) | Self::Own(interface) => interface,
            Self::Added(_) => Interface::Wgpu,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Layers(_, way) => way.name(),
            Self::Added(accumulator) => accumulator.name(),
            Self::Own(_) => "stochastic",
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct BlurCase {
    way: BlurWay,
    made: LayerUse,
    layers: u32,
}

fn cases(is_quick: bool) -> Vec<BlurCase> {
    let counts: &[u32] = if is_quick { &QUICK_LAYERS } else { &LAYERS };
    let layered = LightWay::ALL.map(|way| BlurWay::Layers(Interface::Vulkan, way));
    let passes = BlurWay::Layers(Interface::Wgpu, LightWay::Passes);
    let mut cases = Vec::new();
    for filter in Filter::ALL {
        let mean = |moments| LayerUse::Mean { filter, moments };
        for &layers in counts {
            let ways = layered.into_iter().chain([passes]);
            let ways = ways.chain(Accumulator::ALL.map(BlurWay::Added));
            let mut ways: Vec<(BlurWay, LayerUse)> =
                ways.map(|way| (way, mean(Moments::Middle))).collect();
            ways.push((layered[0], mean(Moments::End)));
            ways.extend(Interface::ALL.map(|api| (BlurWay::Own(api), mean(Moments::Random))));
            let case = |(way, made)| BlurCase { way, made, layers };
            cases.extend(ways.into_iter().map(case));
        }
    }
    for resolve in Resolve::ALL {
        for layers in RESOLVED {
            let made = LayerUse::Resolved(resolve);
            cases.extend([layered[1], passes].map(|way| BlurCase { way, made, layers }));
        }
    }
    cases
}

/// Motion blur on devices.
pub(crate) fn group(is_quick: bool, samples: u32) -> impl Group {
    group_of(cases(is_quick), samples)
}

fn group_of(cases: Vec<BlurCase>, samples: u32) -> CaseGroup<Vec<BlurCase>> {
    CaseGroup {
        name: format!("{STUDY}/blurred"),
        cases: cases.iter().map(|case| case.planned(samples)).collect(),
        warm_up: None,
        work: cases,
        open: |group, context| {
            Ok(Box::new(BlurSession {
                cases: &group.work,
                context,
                first: BTreeMap::new(),
                opened: BTreeMap::new(),
            }))
        },
    }
}

impl BlurCase {
    fn planned(&self, samples: u32) -> PlannedCase {
        let mut conditions = match self.made {
            LayerUse::Mean { filter, moments } => vec![
                (EXPERIMENT, "blurred".to_owned()),
                (FILTER, filter.name().to_owned()),
                (MOMENTS, moments.name().to_owned()),
            ],
            LayerUse::Resolved(resolve) => vec![
                (EXPERIMENT, "blurred-resolve".to_owned()),
                (RESOLVE, resolve.name().to_owned()),
            ],
        };
        conditions.push((API, self.way.interface().name().to_owned()));
        conditions.push((LAYERS_BY, self.way.name().to_owned()));
        conditions.push((metrics::LAYERS, self.layers.to_string()));
        planned_case(
            STUDY,
            samples,
            conditions,
            Some((SIZE_PX, SIDE.to_string())),
        )
    }

    /// Of the same layers, however they come.
    fn layers_name(&self) -> String {
        format!("{:?} of {}", self.made, self.layers)
    }

    fn filter(&self) -> Filter {
        match self.made {
            LayerUse::Mean { filter, .. } => filter,
            LayerUse::Resolved(_) => Filter::Point,
        }
    }

    /// Moment of each layer.
    fn moments(&self) -> Vec<f64> {
        match self.made {
            // Both are exact in f32, and none is random.
            LayerUse::Mean { moments, .. } => moments.all(self.layers, &mut SplitMix64::new(0)),
            LayerUse::Resolved(_) => (0..self.layers)
                .map(|layer| moment_of(layer, self.layers))
                .collect(),
        }
    }

    /// What is drawn.
    fn scene(&self) -> Listed {
        let of_side = |px: f64| px / f64::from(SIDE);
        let bar = |(row, start): (u32, f64)| {
            let quad = |from: f64, to: f64, depths| {
                let [from, to] = [from, to].map(|px| of_side(f64::from(FIRST) + start + px));
                let [top, bottom] = [row, row + 1].map(|row| of_side(f64::from(row)));
                rectangle([from, top], [to, bottom], depths)
            };
            let end = BAR_PX;
            match self.filter() {
                Filter::Point => quad(0.0, end, [1.0; 2]).to_vec(),
                // Depth is the share of a pixel that is covered, where its middle is.
                Filter::Box => [
                    quad(-0.5, 0.5, [0.0, 1.0]),
                    quad(0.5, end - 0.5, [1.0; 2]),
                    quad(end - 0.5, end + 0.5, [1.0, 0.0]),
                ]
                .concat(),
            }
        };
        let layer =
            |moment: &f64| LightColumns::sheared([of_side(MOTION_PX * moment), 0.0], [0.0; 2], 0.0);
        let is_own = matches!(self.way, BlurWay::Own(_));
        let (count, resolve) = match (self.way, self.made) {
            (BlurWay::Own(_), _) if self.filter() == Filter::Point => (self.layers, 4),
            (BlurWay::Own(_), _) => (self.layers, 5),
            // The sum is one layer, as it is.
            (BlurWay::Added(_), _) => (1, 0),
            (_, LayerUse::Mean { .. }) => (self.layers, 0),
            (_, LayerUse::Resolved(Resolve::Published)) => (self.layers, 1),
            (_, LayerUse::Resolved(Resolve::OverBackground)) => (self.layers, 2),
            (_, LayerUse::Resolved(Resolve::CurrentFirst)) => (self.layers, 3),
        };
        let constants = BlurredConstants {
            count,
            resolve,
            motion: nearest(MOTION_PX),
            bar: nearest(BAR_PX),
            pixels: SIDE,
            padding: [0; 3],
        };
        let moments = self.moments();
        // Without layers one is drawn, which nothing looks up.
        let drawn = if is_own { &moments[..1] } else { &moments };
        Listed {
            places: (0..).zip(starts()).flat_map(bar).collect(),
            layers: drawn.iter().map(layer).collect(),
            side: SIDE,
            size: square(SIDE),
            values: starts()
                // Whole numbers of 1/256 pixel are exact in f32.
                .map(|start| nearest(f64::from(FIRST) + start))
                .collect(),
            picture: "pipelines/blurred.wgsl",
            constants: bytemuck::bytes_of(&constants).to_vec(),
        }
    }

    /// Between which numbers a pixel of the trail may be.
    fn allowed(&self, row: u32, pixel: u32, start: f64, moments: &[f64]) -> [f64; 2] {
        if let BlurWay::Own(_) = self.way {
            let shown = own(self.filter(), row, pixel, start, self.layers);
            return [shown - SUM_OFF, shown + SUM_OFF];
        }
        let rounding = match self.way {
            BlurWay::Added(accumulator) => accumulator.rounding(self.layers),
            _ => SUM_OFF,
        };
        let (mut low, mut high, mut all) = (0.0, 0.0, 0.0);
        for (layer, moment) in (0..).zip(moments) {
            let weight = match self.made {
                LayerUse::Mean { .. } => 1.0,
                LayerUse::Resolved(resolve) => resolve.weight(layer, self.layers),
            };
            let at = start + MOTION_PX * moment;
            let shown = match self.filter() {
                Filter::Point => {
                    [-BAND_PX, 0.0, BAND_PX].map(|off| Filter::Point.layer(pixel, at + off))
                }
                Filter::Box => {
                    let share = Filter::Box.layer(pixel, at);
                    [share - SHARE_OFF, share, share + SHARE_OFF]
                }
            };
            low += weight * shown.into_iter().fold(f64::INFINITY, f64::min);
            high += weight * shown.into_iter().fold(0.0, f64::max);
            all += weight;
        }
        if self.made == LayerUse::Resolved(Resolve::Published) {
            return [low, high].map(|light| f64::from(u8::from(light > 0.0)));
        }
        [low / all - rounding, high / all + rounding]
    }

    /// Pixels that no rounding explains, those judged, and the error against the integral.
    fn judge(&self, numbers: &[f32]) -> (usize, usize, BlurError) {
        let moments = self.moments();
        let (mut wrong, mut pairs) = (0, Vec::new());
        for (row, start) in (0..).zip(starts()) {
            for pixel in 0..PIXELS {
                let at = row * SIDE + pixel + FIRST;
                let shown = numbers.get(at as usize).copied().unwrap_or(f32::NAN);
                let shown = f64::from(shown);
                let [low, high] = self.allowed(row, pixel, start, &moments);
                // What is no number is wrong.
                wrong += usize::from(!(low..=high).contains(&shown));
                let exact = match self.made {
                    LayerUse::Mean { filter, .. } => filter.exact(pixel, start),
                    LayerUse::Resolved(_) => fading(f64::from(pixel) + 0.5, start),
                };
                if exact > 0.0 {
                    pairs.push((shown, exact));
                }
            }
        }
        let judged = (PHASES * PIXELS) as usize;
        (wrong, judged, error_of(pairs.into_iter()))
    }
}

/// A pixel of moments of its own.
fn own(filter: Filter, row: u32, pixel: u32, start: f64, count: u32) -> f64 {
    let column = pixel + FIRST;
    let moment = |sample: u32| {
        let number = (row * SIDE + column) * count + sample;
        f64::from(scatter(number, 0) >> 8) / f64::from(1 << 24)
    };
    let shown = (0..count).map(|sample| {
        // The device's place is rounded to f32, which decides of edges.
        let at = nearest(f64::from(FIRST) + start + MOTION_PX * moment(sample));
        filter.layer(column, f64::from(at))
    });
    shown.sum::<f64>() / f64::from(count)
}

impl BlurCase {
    fn open(&self, devices: &Devices) -> Result<Box<dyn LooksUp>, DeviceError> {
        let scene = self.scene();
        match self.way {
            BlurWay::Layers(interface, way) => scene.open(devices, interface, way),
            BlurWay::Added(accumulator) => scene.open_wgpu(devices, Into::Sum(accumulator)),
            BlurWay::Own(interface) => scene.open(devices, interface, LightWay::Passes),
        }
    }
}

struct BlurSession<'a> {
    cases: &'a [BlurCase],
    context: Context<'a>,
    /// Bits of depths of the first way to the same layers on Vulkan.
    first: BTreeMap<String, Vec<u32>>,
    /// By case.
    opened: BTreeMap<usize, Box<dyn LooksUp>>,
}

impl Session for BlurSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let blurred = self.cases[case];
        let mut opened = blurred.open(self.context.devices)?;
        let looked = opened.draw()?;
        let (wrong, count, error) = blurred.judge(&numbers_of(&looked.picture.rgba));
        let texels = match blurred.way {
            BlurWay::Layers(Interface::Vulkan, _) => {
                let depths = bits(&looked.depths);
                let first = self.first.entry(blurred.layers_name());
                differing(&depths, first.or_insert_with(|| depths.clone()))
            }
            _ => 0,
        };
        let reason = if wrong > 0 {
            format!("{wrong} of {count} pixels are outside of what rounding allows")
        } else if texels > 0 {
            format!("{texels} texels of layers differ from the first way's")
        } else {
            String::new()
        };
        let mut figures = vec![
            ("blur_rms", error.rms),
            ("blur_max", error.max),
            ("blur_layers", f64::from(blurred.layers)),
            ("layered_wrong_px", wrong as f64),
            ("layered_judged_px", count as f64),
            ("lights_depths_differing", texels as f64),
            ("pipeline_held_bytes", opened.bytes() as f64),
            ("lights_passes", opened.passes() as f64),
        ];
        figures.retain(|(_, value)| value.is_finite());
        figures.extend(looked.counted.figures());
        self.opened.insert(case, opened);
        Ok(judged(reason, figures, Vec::new()))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        Ok(verified(&mut self.opened, case)?.time()?.figures())
    }
}

#[cfg(test)]
mod tests;
