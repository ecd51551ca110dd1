// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: variance and hard shadows on devices, by moments, formats, spreads and resolutions.

use super::listed::numbers_of;
use super::shaded::{SHEARS, Shade};
use crate::STUDY;
use crate::draws::LooksUp;
use crate::images::{of_shares, size_px, write};
use crate::lights::LightWay;
use crate::metrics::{API, DEPTH, EXPERIMENT, FLOOR, LAYERS_BY, MOMENTS, SIGMA, TEXELS};
use crate::variance::{DepthFormat, Moments};
use crate::way::Interface;
use terrafill_results::{ConditionKey, PlannedCase, Verdict};
use terrafill_study::{
    CaseGroup, Context, Failure, Figures, Group, Trial, judged, planned_case, trials,
};

/// Under the variance.
const LEAST: f32 = 1e-7;
/// Spread of depths, of the range.
const SIGMAS: [f64; 4] = [1e-2, 1e-3, 3e-4, 1e-4];
/// Texels a side of a hard shadow's map.
const MAPS: [u32; 3] = [64, 128, 256];
const QUICK_MAPS: usize = 2;
const VARIANCE_MAP: u32 = 256;

#[derive(Debug, Clone, Copy)]
struct ShadeCase {
    shade: Shade,
    interface: Interface,
    way: LightWay,
}

fn shades(is_quick: bool) -> Vec<Shade> {
    let floors = [None, Some(LEAST)];
    let formats: &[DepthFormat] = if is_quick {
        &[DepthFormat::Bits(24), DepthFormat::F32]
    } else {
        &DepthFormat::ALL
    };
    let both = [Moments::Published, Moments::FromReceiver];
    let mut all = Vec::new();
    for moments in both {
        for &format in formats {
            all.extend(floors.map(|least| Shade::Terraces {
                moments,
                format,
                least,
            }));
        }
        all.extend(floors.map(|least| Shade::Disc {
            moments,
            texels: VARIANCE_MAP,
            least,
        }));
    }
    for moments in Moments::ALL {
        // The widest and the narrowest spread say what the others do.
        let step = if is_quick { SIGMAS.len() - 1 } else { 1 };
        let sigmas = SIGMAS.into_iter().step_by(step);
        all.extend(sigmas.map(|sigma| Shade::Rough { moments, sigma }));
    }
    let maps = &MAPS[..if is_quick { QUICK_MAPS } else { MAPS.len() }];
    all.extend(maps.iter().map(|&texels| Shade::Hard { texels }));
    all
}

impl Shade {
    /// In the order of a case's name.
    fn conditions(self) -> Vec<(ConditionKey, String)> {
        let floor = |least: Option<f32>| {
            let shown = least.map(|least| format!("{least:e}"));
            (FLOOR, shown.unwrap_or_else(|| "none".to_owned()))
        };
        match self {
            Self::Terraces {
                moments,
                format,
                least,
            } => vec![
                (EXPERIMENT, "shaded-plane".to_owned()),
                (MOMENTS, moments.name().to_owned()),
                (DEPTH, format.name()),
                floor(least),
            ],
            Self::Rough { moments, sigma } => vec![
                (EXPERIMENT, "shaded-variance".to_owned()),
                (MOMENTS, moments.name().to_owned()),
                (SIGMA, format!("{sigma:e}")),
            ],
            Self::Disc {
                moments,
                texels,
                least,
            } => vec![
                (EXPERIMENT, "shaded-disc".to_owned()),
                (MOMENTS, moments.name().to_owned()),
                floor(least),
                (TEXELS, texels.to_string()),
            ],
            Self::Hard { texels } => vec![
                (EXPERIMENT, "shaded-hard".to_owned()),
                (TEXELS, texels.to_string()),
            ],
        }
    }

    fn has_several_lights(self) -> bool {
        matches!(self, Self::Disc { .. } | Self::Hard { .. })
    }
}

fn cases(is_quick: bool) -> Vec<ShadeCase> {
    let ways = [
        (Interface::Vulkan, LightWay::Passes),
        (Interface::Wgpu, LightWay::Passes),
        (Interface::Vulkan, LightWay::Copied),
    ];
    let of = |shade: Shade| {
        let count = if shade.has_several_lights() { 3 } else { 2 };
        let ways = ways.into_iter().take(count);
        ways.map(move |(interface, way)| ShadeCase {
            shade,
            interface,
            way,
        })
    };
    shades(is_quick).into_iter().flat_map(of).collect()
}

/// Shadows on devices.
pub(crate) fn group(is_quick: bool, samples: u32) -> impl Group {
    group_of(cases(is_quick), samples)
}

fn group_of(cases: Vec<ShadeCase>, samples: u32) -> CaseGroup<Vec<ShadeCase>> {
    CaseGroup {
        cases: cases.iter().map(|case| case.planned(samples)).collect(),
        ..trials(STUDY, format!("{STUDY}/shaded"), samples, cases)
    }
}

impl ShadeCase {
    fn planned(&self, samples: u32) -> PlannedCase {
        // What is drawn once says all but of several lights.
        let samples = if self.shade.has_several_lights() {
            samples
        } else {
            0
        };
        let size = size_px(self.shade.size());
        planned_case(STUDY, samples, self.conditions(), Some(size))
    }

    /// Shares of light of its picture, where it is kept: what several lights reach.
    fn shares(&self, numbers: Vec<f32>) -> Option<Vec<f32>> {
        let is_shown = self.interface == Interface::Vulkan && self.way == LightWay::Passes;
        if !is_shown || !self.shade.has_several_lights() {
            return None;
        }
        Some(match self.shade {
            // Masks of lights: the lighter, the more of them.
            Shade::Hard { .. } => {
                let most = SHEARS.len() as f32;
                #[allow(clippy::cast_possible_truncation, reason = "a mask of four bits")]
                let share = |mask: &f32| (*mask as u32).count_ones() as f32 / most;
                numbers.iter().map(share).collect()
            }
            _ => numbers,
        })
    }
}

impl Trial for ShadeCase {
    /// Nothing of what is not timed.
    type Opened = Option<Box<dyn LooksUp>>;

    fn conditions(&self) -> Vec<(ConditionKey, String)> {
        let mut conditions = self.shade.conditions();
        conditions.push((API, self.interface.name().to_owned()));
        conditions.push((LAYERS_BY, self.way.name().to_owned()));
        conditions
    }

    fn verify(&self, context: Context<'_>) -> Result<(Self::Opened, Verdict), Failure> {
        let shade = self.shade;
        let scene = shade.scene();
        let mut opened = scene.open(context.devices, self.interface, self.way)?;
        let looked = opened.draw()?;
        let found = shade.judge(&looked);
        let reason = if found.wrong_texels > 0 {
            let texels = found.wrong_texels;
            format!("{texels} texels of maps are not what rays along the light meet")
        } else if found.wrong > 0 {
            let (wrong, judged) = (found.wrong, found.judged);
            format!("{wrong} of {judged} pixels are outside of what rounding allows")
        } else if found.non_finite > 0 {
            format!("{} pixels are not finite", found.non_finite)
        } else if found.judged == 0 {
            "no pixel was judged".to_owned()
        } else {
            String::new()
        };
        let mut figures = found.figures.clone();
        figures.extend([
            ("layered_wrong_texels", found.wrong_texels as f64),
            ("layered_wrong_px", found.wrong as f64),
            ("layered_open_px", found.open as f64),
            ("layered_judged_px", found.judged as f64),
            ("pipeline_held_bytes", opened.bytes() as f64),
            ("lights_passes", opened.passes() as f64),
        ]);
        figures.extend(looked.counted.figures());
        let planned = self.planned(1);
        let notes = match self.shares(numbers_of(&looked.picture.rgba)) {
            Some(shares) => {
                let name = &planned.id.name;
                write(context.folder, name, shade.size(), of_shares(&shares))?
            }
            None => Vec::new(),
        };
        let timed = (planned.samples > 0).then_some(opened);
        Ok((timed, judged(reason, figures, notes)))
    }

    fn time(&self, opened: &mut Self::Opened) -> Result<Figures, Failure> {
        let opened = opened.as_mut();
        let opened = opened.ok_or_else(|| Failure::broken("it is not timed"))?;
        Ok(opened.time()?.figures())
    }
}

#[cfg(test)]
mod tests;
