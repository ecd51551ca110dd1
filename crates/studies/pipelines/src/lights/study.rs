// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: one to sixteen lights over terrain with objects, by every way to their maps.

use super::on_vulkan::OnVulkan;
use super::reference::{JudgedLights, LitRays};
use super::scene::{DistantLight, ground, lights};
use super::way::LightWay;
use crate::STUDY;
use crate::draws::{Counted, LooksUp as _, bits, differing, shown_hash};
use crate::images::{of_lights, size_px, write};
use crate::metrics::{self, EXPERIMENT, GRID_CELLS, LAYERS_BY, MAP_TEXELS};
use std::collections::BTreeMap;
use terrafill_contract::{ids_of, numbers_hash};
use terrafill_results::Verdict;
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::{Grid, GridCamera};
use terrafill_shapes::rays::Rays;
use terrafill_study::{
    CaseGroup, Context, Failure, Figures, Group, JudgedOnce, Shows, judged, planned_case, verified,
};

const LIGHTS: [u32; 5] = [1, 2, 4, 8, 16];
const QUICK_LIGHTS: [u32; 2] = [2, 4];
/// Cells a side of the ground, and texels a side of a map.
const SIZES: [u32; 2] = [256, 1_024];
const QUICK_SIZES: [u32; 2] = [64, 256];
/// Every such pixel is held against rays; pictures must be equal besides.
const RAY_EVERY: usize = 29;

/// Shadows of so many lights, a case for each way.
struct Lights {
    lights: Vec<DistantLight>,
    cells: u32,
    side: u32,
    size: ImageSize,
}

pub(crate) fn groups(is_quick: bool, pictures: (ImageSize, u32)) -> Vec<impl Group> {
    let (counts, sizes): (&[u32], _) = if is_quick {
        (&QUICK_LIGHTS, QUICK_SIZES)
    } else {
        (&LIGHTS, SIZES)
    };
    let of = |count: &u32| group(*count, sizes, pictures);
    counts.iter().map(of).collect()
}

fn group(
    count: u32,
    [cells, side]: [u32; 2],
    (size, samples): (ImageSize, u32),
) -> CaseGroup<Lights> {
    let case = |way: LightWay| {
        let conditions = vec![
            (EXPERIMENT, "lights".to_owned()),
            (LAYERS_BY, way.name().to_owned()),
            (metrics::LIGHTS, count.to_string()),
            (MAP_TEXELS, side.to_string()),
            (GRID_CELLS, cells.to_string()),
        ];
        planned_case(STUDY, samples, conditions, Some(size_px(size)))
    };
    CaseGroup {
        name: format!("{STUDY}/lights/{count}"),
        cases: LightWay::ALL.map(case).into(),
        warm_up: None,
        work: Lights {
            lights: lights(count),
            cells,
            side,
            size,
        },
        open: |group, context| {
            Ok(Box::new(JudgedOnce::new(LightSession {
                group,
                context,
                grid: ground(group.work.cells),
                first: None,
                opened: BTreeMap::new(),
            })))
        },
    }
}

/// Numbers of a picture and bits of its maps' depths.
struct ShownMaps {
    numbers: Vec<u32>,
    depths: Vec<u32>,
    counted: Counted,
}

/// The same of the first way, and what rays say of the numbers.
struct FirstMaps {
    numbers: Vec<u32>,
    depths: Vec<u32>,
    found: JudgedLights,
}

struct LightSession<'a> {
    group: &'a CaseGroup<Lights>,
    context: Context<'a>,
    grid: Grid,
    /// What the first way showed that was drawn.
    first: Option<FirstMaps>,
    /// By case.
    opened: BTreeMap<usize, OnVulkan>,
}

impl Shows for LightSession<'_> {
    type Shown = ShownMaps;

    fn show(&mut self, case: usize) -> Result<(String, ShownMaps), Failure> {
        let Lights {
            ref lights,
            side,
            size,
            ..
        } = self.group.work;
        let gpu = terrafill_vulkan::shared_gpu(self.context.devices)?;
        let way = LightWay::ALL[case];
        let mut opened = OnVulkan::new(&gpu, way, &self.grid, lights, side, size)?;
        let shown = opened.draw()?;
        self.opened.insert(case, opened);
        let maps = ShownMaps {
            numbers: ids_of(&shown.picture),
            depths: bits(&shown.depths),
            counted: shown.counted,
        };
        let hash = shown_hash(&maps.numbers, &maps.counted);
        Ok((format!("{hash}-{}", numbers_hash(&maps.depths)), maps))
    }

    fn judge(&mut self, case: usize, shown: ShownMaps) -> Result<Verdict, Failure> {
        let Lights {
            ref lights,
            side,
            size,
            ..
        } = self.group.work;
        let ShownMaps {
            numbers,
            depths,
            counted,
        } = shown;
        let rays = LitRays {
            rays: Rays::new(&self.grid, GridCamera::new(), size),
            lights,
            side,
        };
        let is_first = self.first.is_none();
        let judge = || rays.judge(&numbers, RAY_EVERY);
        let first = self.first.get_or_insert_with(|| FirstMaps {
            found: judge(),
            numbers: numbers.clone(),
            depths: depths.clone(),
        });
        let differing_px = differing(&numbers, &first.numbers);
        let differing_texels = differing(&depths, &first.depths);
        // What equals the first is judged with it.
        let found = if differing_px > 0 {
            judge()
        } else {
            first.found.clone()
        };
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
        let opened = &self.opened[&case];
        let mut figures = vec![
            ("pipeline_mismatched_px", found.judged.mismatched as f64),
            ("pipeline_band_px", found.judged.in_band as f64),
            ("pipeline_differing_px", differing_px as f64),
            ("pipeline_shown_px", found.judged.shown as f64),
            ("pipeline_held_bytes", opened.bytes() as f64),
            ("lights_passes", opened.passes() as f64),
            ("lights_depths_differing", differing_texels as f64),
            (
                "lights_map_error",
                found.map_differs as f64 / found.looked_at.max(1) as f64,
            ),
        ];
        figures.extend(counted.figures());
        let notes = if is_first || !reason.is_empty() {
            let name = &self.group.cases[case].id.name;
            let pixels = of_lights(&numbers, lights.len());
            write(self.context.folder, name, size, pixels)?
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
mod tests {
    use super::*;
    use crate::images::PICTURE;
    use crate::tested::Tested;
    use terrafill_results::Status;

    #[test]
    fn every_way_has_the_same_depths_and_a_turned_light_is_noticed() {
        let Some(tested) = Tested::open() else {
            return;
        };
        let group = group(4, QUICK_SIZES, (PICTURE, 1));
        let verdicts = tested.verdicts(&group);
        for (at, verdict) in &verdicts {
            let name = &group.cases[*at].id.name;
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
        }
        assert!(verdicts.len() >= 3, "{}", verdicts.len());
        // Negative controls: a light turned by 3°, and two layers exchanged.
        let gpu = terrafill_vulkan::shared_gpu(&tested.devices).expect("a device");
        let grid = ground(QUICK_SIZES[0]);
        let drawn = |lights: &[DistantLight]| {
            let way = LightWay::Passes;
            let opened = OnVulkan::new(&gpu, way, &grid, lights, QUICK_SIZES[1], PICTURE);
            ids_of(&opened.expect("opens").draw().expect("draws").picture)
        };
        let judge = |numbers: &[u32]| {
            let rays = LitRays {
                rays: Rays::new(&grid, GridCamera::new(), PICTURE),
                lights: &group.work.lights,
                side: QUICK_SIZES[1],
            };
            rays.judge(numbers, 97).judged.mismatched
        };
        assert_eq!(judge(&drawn(&group.work.lights)), 0);
        let mut turned = group.work.lights.clone();
        let turn = glam::DQuat::from_rotation_z(3_f64.to_radians());
        let light = &mut turned[0];
        for axis in [&mut light.right, &mut light.up, &mut light.toward] {
            *axis = turn * *axis;
        }
        assert!(judge(&drawn(&turned)) > 0);
        let mut exchanged = group.work.lights.clone();
        exchanged.swap(0, 1);
        assert!(judge(&drawn(&exchanged)) > 0);
    }
}
