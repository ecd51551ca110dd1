// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: variance and hard shadows on devices, by moments, formats, spreads and resolutions.

use super::listed::LooksUp;
use super::shaded::{SHEARS, Shade};
use crate::STUDY;
use crate::draws::verdict_of;
use crate::images::write_shares;
use crate::lights::LightWay;
use crate::variance::{DepthFormat, Moments};
use crate::way::Interface;
use std::collections::BTreeMap;
use terrafill_results::{CaseId, PlannedCase, Status, Verdict};
use terrafill_study::{Context, Group, Session, StudyError};

/// Under the variance.
const LEAST: f32 = 1e-7;
/// Spread of depths, of the range.
const SIGMAS: [f64; 4] = [1e-2, 1e-3, 3e-4, 1e-4];
/// Texels a side of a hard shadow's map.
const MAPS: [u32; 3] = [64, 128, 256];
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
        all.extend(SIGMAS.map(|sigma| Shade::Rough { moments, sigma }));
    }
    all.extend(MAPS.map(|texels| Shade::Hard { texels }));
    all
}

impl Shade {
    /// In the order of a case's name.
    fn conditions(self) -> Vec<(&'static str, String)> {
        let floor = |least: Option<f32>| {
            let shown = least.map(|least| format!("{least:e}"));
            ("floor", shown.unwrap_or_else(|| "none".to_owned()))
        };
        match self {
            Self::Terraces {
                moments,
                format,
                least,
            } => vec![
                ("experiment", "shaded-plane".to_owned()),
                ("moments", moments.name().to_owned()),
                ("depth", format.name()),
                floor(least),
            ],
            Self::Rough { moments, sigma } => vec![
                ("experiment", "shaded-variance".to_owned()),
                ("moments", moments.name().to_owned()),
                ("sigma", format!("{sigma:e}")),
            ],
            Self::Disc {
                moments,
                texels,
                least,
            } => vec![
                ("experiment", "shaded-disc".to_owned()),
                ("moments", moments.name().to_owned()),
                floor(least),
                ("texels", texels.to_string()),
            ],
            Self::Hard { texels } => vec![
                ("experiment", "shaded-hard".to_owned()),
                ("texels", texels.to_string()),
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
                conditions.push(("api", interface.name().to_owned()));
                conditions.push(("layers_by", way.name().to_owned()));
                let values: Vec<&str> = conditions.iter().map(|(_, value)| &**value).collect();
                planned.push(PlannedCase {
                    id: CaseId::new(STUDY, values.join("/"), conditions.clone()),
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
mod tests {
    use super::super::listed::Looked;
    use super::*;
    use std::rc::Rc;
    use terrafill_fill::Devices;

    fn figure(verdict: &Verdict, name: &str) -> f64 {
        let figure = verdict.figures.iter().find(|figure| figure.0 == name);
        figure.unwrap_or_else(|| panic!("{name} in {verdict:?}")).1
    }

    fn has_devices(devices: &Devices) -> bool {
        let wgpu = terrafill_gpu::shared_gpu(devices).map(drop);
        let vulkan = terrafill_vulkan::shared_gpu(devices).map(drop);
        terrafill_fill::device_for_test(wgpu).is_some()
            && terrafill_fill::device_for_test(vulkan).is_some()
    }

    #[test]
    fn devices_show_what_the_formulas_allow() {
        let devices = Rc::new(Devices::default());
        if !has_devices(&devices) {
            return;
        }
        let group = Shades::new(true, 1);
        let folder = tempfile::tempdir().expect("a folder");
        let context = Context {
            devices: &devices,
            folder: folder.path(),
        };
        let mut session = group.open(context).expect("opens");
        let mut right = 0;
        for (at, (planned, case)) in group.planned.iter().zip(&group.cases).enumerate() {
            let verdict = session.verify(at).expect("a verdict");
            let name = &planned.id.name;
            eprintln!("{name}: {} {:?}", verdict.reason, verdict.figures);
            if verdict.status == Status::Skipped {
                continue;
            }
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
            right += 1;
            match case.shade {
                Shade::Rough {
                    moments: Moments::FromReceiver,
                    ..
                } => assert!(figure(&verdict, "variance_relative_rms") <= 2e-6, "{name}"),
                Shade::Terraces {
                    moments: Moments::Published,
                    least,
                    ..
                } => {
                    let dark = figure(&verdict, "variance_dark_share");
                    assert_eq!(dark > 0.0, least.is_none(), "{name}: {dark}");
                }
                Shade::Hard { .. } => {
                    let share = figure(&verdict, "hard_area_share");
                    assert!((share - 0.244).abs() < 0.01, "{name}: {share}");
                }
                _ => {}
            }
        }
        assert!(right >= 40, "{right}");
    }

    #[test]
    fn other_moments_other_maps_and_a_light_that_is_aside_are_noticed() {
        let devices = Devices::default();
        if !has_devices(&devices) {
            return;
        }
        let draw = |scene: &super::super::listed::Listed| -> Looked {
            let opened = scene.open(&devices, Interface::Vulkan, LightWay::Passes);
            opened.expect("opens").draw().expect("draws")
        };
        let rough = |moments| Shade::Rough {
            moments,
            sigma: 1e-4,
        };
        // The published noise is beyond what depths less the receiver's allow.
        let published = draw(&rough(Moments::Published).scene());
        assert_eq!(rough(Moments::Published).judge(&published).wrong, 0);
        assert!(rough(Moments::FromReceiver).judge(&published).wrong > 1_000);
        let disc = Shade::Disc {
            moments: Moments::FromReceiver,
            texels: 128,
            least: Some(LEAST),
        };
        let mut looked = draw(&disc.scene());
        assert_eq!(
            disc.judge(&looked).wrong + disc.judge(&looked).wrong_texels,
            0
        );
        // A light that is two texels aside, whose picture agrees with its own maps.
        let mut aside = disc.scene();
        for layer in &mut aside.layers {
            *layer = crate::lights::LightColumns::sheared([2.0 / 128.0; 2], [0.2; 2], 0.2);
        }
        assert!(disc.judge(&draw(&aside)).wrong_texels > 100);
        // Maps that are five texels aside.
        looked.depths.rotate_left(5);
        assert!(disc.judge(&looked).wrong > 100);
        let hard = Shade::Hard { texels: 64 };
        let mut looked = draw(&hard.scene());
        assert_eq!(hard.judge(&looked).wrong, 0);
        looked.numbers.rotate_right(40);
        assert!(hard.judge(&looked).wrong > 100);
    }
}
