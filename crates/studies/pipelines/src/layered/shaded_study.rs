// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: variance and hard shadows on devices, by moments, formats, spreads and resolutions.

use super::listed::LooksUp;
use super::shaded::{SHEARS, Shade};
use crate::STUDY;
use crate::draws::verdict_of;
use crate::images::write_shares;
use crate::keys::{API, DEPTH, EXPERIMENT, FLOOR, LAYERS_BY, MOMENTS, SIGMA, SIZE_PX, TEXELS};
use crate::lights::LightWay;
use crate::variance::{DepthFormat, Moments};
use crate::way::Interface;
use std::collections::BTreeMap;
use terrafill_results::{CaseId, ConditionKey, PlannedCase, Status, Verdict};
use terrafill_study::{Context, Group, Session, StudyError, size_name};

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

/// Shadows on devices.
pub(crate) struct Shades {
    planned: Vec<PlannedCase>,
    cases: Vec<ShadeCase>,
}

fn shades(is_quick: bool) -> Vec<Shade> {
    let floors = [None, Some(LEAST)];
    let formats: &[DepthFormat] = match is_quick {
        true => &[DepthFormat::Bits(24), DepthFormat::F32],
        false => &DepthFormat::ALL,
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

impl Shades {
    pub(crate) fn new(is_quick: bool, samples: u32) -> Self {
        let (mut planned, mut cases) = (Vec::new(), Vec::new());
        for shade in shades(is_quick) {
            let mut ways = vec![
                (Interface::Vulkan, LightWay::Passes),
                (Interface::Wgpu, LightWay::Passes),
            ];
            if shade.has_several_lights() {
                ways.push((Interface::Vulkan, LightWay::Copied));
            }
            for (interface, way) in ways {
                let mut conditions = shade.conditions();
                conditions.push((API, interface.name().to_owned()));
                conditions.push((LAYERS_BY, way.name().to_owned()));
                let values: Vec<&str> = conditions.iter().map(|(_, value)| &**value).collect();
                let name = values.join("/");
                conditions.push((SIZE_PX, size_name(shade.size())));
                planned.push(PlannedCase {
                    id: CaseId::new(STUDY, name, conditions),
                    // What is drawn once says all but of several lights.
                    samples: if shade.has_several_lights() {
                        samples
                    } else {
                        0
                    },
                    may_be_wrong: false,
                });
                cases.push(ShadeCase {
                    shade,
                    interface,
                    way,
                });
            }
        }
        Self { planned, cases }
    }
}

impl Group for Shades {
    fn name(&self) -> String {
        format!("{STUDY}/shaded")
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.planned
    }

    fn open<'a>(&'a self, context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        Ok(Box::new(ShadeSession {
            group: self,
            context,
            opened: BTreeMap::new(),
        }))
    }
}

struct ShadeSession<'a> {
    group: &'a Shades,
    context: Context<'a>,
    /// By case.
    opened: BTreeMap<usize, Box<dyn LooksUp>>,
}

impl ShadeSession<'_> {
    /// Path of the picture of what several lights reach.
    fn picture(&self, case: usize, numbers: &[f32]) -> Result<Option<String>, StudyError> {
        let ShadeCase {
            shade,
            interface,
            way,
        } = self.group.cases[case];
        let is_shown = interface == Interface::Vulkan && way == LightWay::Passes;
        if !is_shown || !shade.has_several_lights() {
            return Ok(None);
        }
        let shares: Vec<f32> = match shade {
            // Masks of lights: the lighter, the more of them.
            Shade::Hard { .. } => {
                let most = SHEARS.len() as f32;
                #[allow(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a mask of four bits"
                )]
                let share = |mask: &f32| (*mask as u32).count_ones() as f32 / most;
                numbers.iter().map(share).collect()
            }
            _ => numbers.to_vec(),
        };
        let name = &self.group.planned[case].id.name;
        let written = write_shares(self.context.folder, name, shade.size(), &shares);
        written.map(Some).map_err(|message| StudyError::Broken {
            place: name.clone(),
            message,
        })
    }
}

impl Session for ShadeSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        let ShadeCase {
            shade,
            interface,
            way,
        } = self.group.cases[case];
        let opened = shade.scene().open(self.context.devices, interface, way);
        let drawn = opened.and_then(|mut opened| Ok((opened.draw()?, opened)));
        let (looked, opened) = match drawn {
            Ok(drawn) => drawn,
            Err(error) => return Ok(verdict_of(&error)),
        };
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
        if self.group.planned[case].samples > 0 {
            self.opened.insert(case, opened);
        }
        let picture = self.picture(case, &looked.numbers)?;
        Ok(Verdict {
            status: match reason.is_empty() {
                true => Status::Ok,
                false => Status::Wrong,
            },
            reason,
            figures,
            notes: picture.into_iter().map(|path| ("picture", path)).collect(),
        })
    }

    fn sample(&mut self, case: usize) -> Result<Vec<(&'static str, f64)>, String> {
        let opened = self.opened.get_mut(&case).ok_or("it was not verified")?;
        Ok(opened.time().map_err(|error| error.to_string())?.figures())
    }
}

#[cfg(test)]
mod tests;
