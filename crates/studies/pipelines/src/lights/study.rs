// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: one, four and sixteen lights by every way to their maps.

use super::on_vulkan::OnVulkan;
use super::reference::LitRays;
use super::scene::{DistantLight, lights};
use super::way::LightWay;
use crate::STUDY;
use crate::draws::verdict_of;
use crate::grid::{Grid, View};
use crate::images::{size_px, write_lit};
use crate::keys;
use crate::keys::{EXPERIMENT, GRID_CELLS, LAYERS_BY, MAP_TEXELS};
use crate::rays::{Cut, Rays};
use std::collections::BTreeMap;
use terrafill_fill::{DeviceError, ids_of};
use terrafill_results::{CaseId, PlannedCase, Status, Verdict};
use terrafill_scene::ImageSize;
use terrafill_study::{Context, Group, Session, StudyError};

const LIGHTS: [u32; 3] = [1, 4, 16];
const QUICK_LIGHTS: [u32; 1] = [4];
/// Cells a side of the ground, and texels a side of a map.
const SIZES: [u32; 2] = [256, 1_024];
const QUICK_SIZES: [u32; 2] = [64, 256];
/// Every such pixel is held against rays; pictures must be equal besides.
const RAY_EVERY: usize = 29;

/// Shadows of so many lights.
pub(crate) struct Lights {
    planned: Vec<PlannedCase>,
    ways: Vec<LightWay>,
    lights: Vec<DistantLight>,
    cells: u32,
    side: u32,
    size: ImageSize,
}

impl Lights {
    pub(crate) fn all(is_quick: bool, pictures: (ImageSize, u32)) -> Vec<Self> {
        let (counts, sizes): (&[u32], _) = match is_quick {
            true => (&QUICK_LIGHTS, QUICK_SIZES),
            false => (&LIGHTS, SIZES),
        };
        let of = |count: &u32| Self::new(*count, sizes, pictures);
        counts.iter().map(of).collect()
    }

    fn new(count: u32, [cells, side]: [u32; 2], (size, samples): (ImageSize, u32)) -> Self {
        let planned = |way: &LightWay| {
            let conditions = [
                (EXPERIMENT, "lights".to_owned()),
                (LAYERS_BY, way.name().to_owned()),
                (keys::LIGHTS, count.to_string()),
                (MAP_TEXELS, side.to_string()),
                (GRID_CELLS, cells.to_string()),
            ];
            let values: Vec<&str> = conditions.iter().map(|(_, value)| value.as_str()).collect();
            PlannedCase {
                id: CaseId::new(
                    STUDY,
                    values.join("/"),
                    [&conditions[..], &[size_px(size)]].concat(),
                ),
                samples,
                may_be_wrong: false,
            }
        };
        let ways = LightWay::ALL.to_vec();
        Self {
            planned: ways.iter().map(planned).collect(),
            ways,
            lights: lights(count),
            cells,
            side,
            size,
        }
    }
}

impl Group for Lights {
    fn name(&self) -> String {
        format!("{STUDY}/lights/{}", self.lights.len())
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.planned
    }

    fn open<'a>(&'a self, context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        Ok(Box::new(LightSession {
            group: self,
            context,
            grid: Grid::new(self.cells),
            first: None,
            opened: BTreeMap::new(),
        }))
    }
}

struct LightSession<'a> {
    group: &'a Lights,
    context: Context<'a>,
    grid: Grid,
    /// Numbers of the picture and bits of the depths of the first way that was drawn.
    first: Option<(Vec<u32>, Vec<f32>)>,
    /// By case.
    opened: BTreeMap<usize, OnVulkan>,
}

/// How often two lists differ, bit by bit; places that one of them lacks differ.
pub(crate) fn differing<T: Copy>(one: &[T], other: &[T], bits: impl Fn(T) -> u32) -> usize {
    let pairs = one.iter().zip(other);
    let differ = pairs.filter(|(a, b)| bits(**a) != bits(**b)).count();
    differ + one.len().abs_diff(other.len())
}

impl LightSession<'_> {
    fn open(&self, way: LightWay) -> Result<OnVulkan, DeviceError> {
        let gpu = terrafill_vulkan::shared_gpu(self.context.devices)?;
        let Lights {
            lights, side, size, ..
        } = self.group;
        OnVulkan::new(&gpu, way, &self.grid, lights, *side, *size)
    }

    fn rays(&self) -> LitRays<'_> {
        let size = [self.group.size.width, self.group.size.height];
        LitRays {
            rays: Rays::new(&self.grid, View::new(), size, Cut::Published),
            lights: &self.group.lights,
            side: self.group.side,
        }
    }
}

impl Session for LightSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        let way = self.group.ways[case];
        let opened = self.open(way);
        let drawn = opened.and_then(|mut opened| Ok((opened.draw()?, opened)));
        let (shown, opened) = match drawn {
            Ok(drawn) => drawn,
            Err(error) => return Ok(verdict_of(&error)),
        };
        let numbers = ids_of(&shown.picture);
        let found = self.rays().judge(&numbers, RAY_EVERY);
        let is_first = self.first.is_none();
        let (first, depths) = self
            .first
            .get_or_insert_with(|| (numbers.clone(), shown.depths.clone()));
        let differing_px = differing(&numbers, first, |number| number);
        let differing_texels = differing(&shown.depths, depths, f32::to_bits);
        let lit = self.group.lights.len();
        let reason = if found.judged.mismatched > 0 {
            let pixels = found.judged.mismatched;
            format!("{pixels} pixels show what the reference does not allow")
        } else if differing_texels > 0 {
            format!("{differing_texels} depths differ from the first way's")
        } else if differing_px > 0 {
            format!("{differing_px} pixels differ from the first way's")
        } else if found.shadowed == 0 {
            "it shows no shadow".to_owned()
        } else {
            String::new()
        };
        let mut figures = vec![
            ("pipeline_mismatched_px", found.judged.mismatched as f64),
            ("pipeline_band_px", found.judged.in_band as f64),
            ("pipeline_differing_px", differing_px as f64),
            ("pipeline_shown_px", found.judged.shown as f64),
            ("pipeline_held_bytes", opened.map_bytes() as f64),
            ("lights_passes", opened.passes() as f64),
            ("lights_depths_differing", differing_texels as f64),
            (
                "lights_map_error",
                found.map_differs as f64 / found.looked_at.max(1) as f64,
            ),
        ];
        figures.extend(shown.counted.figures());
        self.opened.insert(case, opened);
        let mut notes = Vec::new();
        if is_first || !reason.is_empty() {
            let name = &self.group.planned[case].id.name;
            let size = [self.group.size.width, self.group.size.height];
            let written = write_lit(self.context.folder, name, size, &numbers, lit);
            let path = written.map_err(|message| StudyError::Broken {
                place: name.clone(),
                message,
            })?;
            notes.push(("picture", path));
        }
        Ok(Verdict {
            status: match reason.is_empty() {
                true => Status::Ok,
                false => Status::Wrong,
            },
            reason,
            figures,
            notes,
        })
    }

    fn sample(&mut self, case: usize) -> Result<Vec<(&'static str, f64)>, String> {
        let opened = self.opened.get_mut(&case).ok_or("it was not verified")?;
        Ok(opened.time().map_err(|error| error.to_string())?.figures())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::images::PICTURE;
    use std::rc::Rc;
    use terrafill_fill::Devices;

    #[test]
    fn every_way_has_the_same_depths_and_a_turned_light_is_noticed() {
        let devices = Rc::new(Devices::default());
        let opened = terrafill_vulkan::shared_gpu(&devices).map(drop);
        if terrafill_fill::device_for_test(opened).is_none() {
            return;
        }
        let group = Lights::new(4, QUICK_SIZES, (PICTURE, 1));
        let folder = tempfile::tempdir().expect("a folder");
        let context = Context {
            devices: &devices,
            folder: folder.path(),
        };
        let mut session = group.open(context).expect("opens");
        let mut right = 0;
        for (at, planned) in group.planned.iter().enumerate() {
            let verdict = session.verify(at).expect("a verdict");
            let name = &planned.id.name;
            eprintln!(
                "{name}: {:?} {} {:?}",
                verdict.status, verdict.reason, verdict.figures
            );
            if verdict.status != Status::Skipped {
                assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
                right += 1;
            }
        }
        assert!(right >= 3, "{right}");
        let times = session.sample(0).expect("a time");
        assert!(times.iter().all(|(_, ms)| *ms > 0.0), "{times:?}");
        // Twins: a light turned by 3°, and two layers exchanged.
        let gpu = terrafill_vulkan::shared_gpu(&devices).expect("a device");
        let grid = Grid::new(QUICK_SIZES[0]);
        let drawn = |lights: &[DistantLight]| {
            let way = LightWay::Passes;
            let opened = OnVulkan::new(&gpu, way, &grid, lights, QUICK_SIZES[1], PICTURE);
            ids_of(&opened.expect("opens").draw().expect("draws").picture)
        };
        let judge = |numbers: &[u32]| {
            let size = [PICTURE.width, PICTURE.height];
            let rays = LitRays {
                rays: Rays::new(&grid, View::new(), size, Cut::Published),
                lights: &group.lights,
                side: QUICK_SIZES[1],
            };
            rays.judge(numbers, 97).judged.mismatched
        };
        assert_eq!(judge(&drawn(&group.lights)), 0);
        let mut turned = group.lights.clone();
        let turn = glam::DQuat::from_rotation_z(3_f64.to_radians());
        let light = &mut turned[0];
        for axis in [&mut light.right, &mut light.up, &mut light.toward] {
            *axis = turn * *axis;
        }
        assert!(judge(&drawn(&turned)) > 0);
        let mut exchanged = group.lights.clone();
        exchanged.swap(0, 1);
        assert!(judge(&drawn(&exchanged)) > 0);
    }

    #[test]
    fn lists_that_differ_in_a_bit_or_in_length_are_told_apart() {
        let bits = f32::to_bits;
        assert_eq!(differing(&[0.0, 1.0], &[0.0, 1.0], bits), 0);
        assert_eq!(differing(&[0.0, 1.0], &[-0.0, 1.0], bits), 1);
        assert_eq!(differing(&[0.0, 1.0], &[0.0], bits), 1);
    }
}
