// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: the same ground drawn from its blocks by all that can keep them, on both interfaces.

use super::ground::BlockGround;
use super::{on_vulkan, on_wgpu};
use crate::STUDY;
use crate::cache::keep::Keep;
use crate::draws::{Counted, Draws, differing, shown_hash};
use crate::images::{of_relief, size_px, write};
use crate::metrics::{self, API, EXPERIMENT, GRID_CELLS, KEPT_IN};
use crate::way::Interface;
use std::cell::OnceCell;
use std::collections::BTreeMap;
use terrafill_contract::{DeviceError, Devices, ids_of};
use terrafill_results::Verdict;
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::GridCamera;
use terrafill_shapes::rays::Rays;
use terrafill_study::{
    CaseGroup, Context, Failure, Figures, Group, JudgedOnce, Shows, judged, planned_case, verified,
};

/// Blocks a side of the ground, and cells a side of a block: 257 samples as published, and more blocks of fewer.
const GROUNDS: [[u32; 2]; 3] = [[2, 256], [4, 256], [8, 128]];
const QUICK_GROUNDS: [[u32; 2]; 1] = [[4, 32]];
/// Pixels of a picture that are held against rays, at least: all of a small one. Pictures must be equal besides.
const RAYS: usize = 1 << 16;

/// Every so many pixels of a picture are held against rays.
fn ray_every(size: ImageSize) -> usize {
    let pixels = size.width as usize * size.height as usize;
    // Odd, so that columns are not left out.
    (pixels / RAYS).max(1) | 1
}

/// Ground and the ways that draw it.
pub(crate) struct DrawnBlocks {
    across: u32,
    block_cells: u32,
    ways: Vec<(Interface, Keep)>,
    size: ImageSize,
}

/// A group for each ground.
pub(crate) fn groups(is_quick: bool, pictures: (ImageSize, u32)) -> Vec<impl Group> {
    let grounds: &[[u32; 2]] = if is_quick { &QUICK_GROUNDS } else { &GROUNDS };
    grounds
        .iter()
        .map(|ground| group(*ground, pictures))
        .collect()
}

fn group(
    [across, block_cells]: [u32; 2],
    (size, samples): (ImageSize, u32),
) -> CaseGroup<DrawnBlocks> {
    let on = |interface| Keep::DRAWN.map(|keep| (interface, keep));
    let all = Interface::ALL.into_iter().flat_map(on);
    // Arrays of textures are drawn from on Vulkan, where a draw finds more than one group.
    let is_drawn = |(interface, keep): &(Interface, Keep)| {
        *interface == Interface::Vulkan || *keep != Keep::Bindless
    };
    let ways: Vec<_> = all.filter(is_drawn).collect();
    let case = |(interface, keep): &(Interface, Keep)| {
        let conditions = vec![
            (EXPERIMENT, "blocks".to_owned()),
            (API, interface.name().to_owned()),
            (KEPT_IN, keep.name().to_owned()),
            (metrics::BLOCKS, (across * across).to_string()),
            (GRID_CELLS, (across * block_cells).to_string()),
        ];
        planned_case(STUDY, samples, conditions, Some(size_px(size)))
    };
    CaseGroup {
        name: format!("{STUDY}/blocks/{}", across * across),
        cases: ways.iter().map(case).collect(),
        warm_up: None,
        work: DrawnBlocks {
            across,
            block_cells,
            ways,
            size,
        },
        open: |group, context| {
            let ground = BlockGround::new(group.work.across, group.work.block_cells);
            Ok(Box::new(JudgedOnce::new(BlockSession {
                group,
                context,
                ground,
                truth: OnceCell::new(),
                first: BTreeMap::new(),
                opened: BTreeMap::new(),
            })))
        },
    }
}

fn open(
    devices: &Devices,
    (interface, keep): (Interface, Keep),
    ground: &BlockGround,
    size: ImageSize,
) -> Result<Box<dyn Draws>, DeviceError> {
    Ok(match interface {
        Interface::Wgpu => {
            let gpu = terrafill_gpu::shared_gpu(devices)?;
            Box::new(on_wgpu::OnWgpu::new(&gpu, keep, ground, size)?)
        }
        Interface::Vulkan => {
            let gpu = terrafill_vulkan::shared_gpu(devices)?;
            Box::new(on_vulkan::OnVulkan::new(&gpu, keep, ground, size)?)
        }
    })
}

struct BlockSession<'a> {
    group: &'a CaseGroup<DrawnBlocks>,
    context: Context<'a>,
    ground: BlockGround,
    /// Numbers of triangles by rays, each behind its pixel's number.
    truth: OnceCell<Vec<(usize, u32)>>,
    /// Of the first way on each interface.
    first: BTreeMap<Interface, Vec<u32>>,
    /// By case.
    opened: BTreeMap<usize, Box<dyn Draws>>,
}

impl Shows for BlockSession<'_> {
    type Shown = (Vec<u32>, Counted);

    fn show(&mut self, case: usize) -> Result<(String, Self::Shown), Failure> {
        let DrawnBlocks { ref ways, size, .. } = self.group.work;
        let mut opened = open(self.context.devices, ways[case], &self.ground, size)?;
        let (picture, counted) = opened.draw()?;
        let numbers = ids_of(&picture);
        self.opened.insert(case, opened);
        Ok((shown_hash(&numbers, &counted), (numbers, counted)))
    }

    fn judge(&mut self, case: usize, (numbers, counted): Self::Shown) -> Result<Verdict, Failure> {
        let DrawnBlocks { ref ways, size, .. } = self.group.work;
        let (interface, keep) = ways[case];
        let rays = Rays::new(&self.ground.grid, GridCamera::new(), size);
        let truth = self.truth.get_or_init(|| rays.picture(ray_every(size)));
        let found = rays.judge_triangles(&numbers, truth);
        let is_first = !self.first.contains_key(&interface);
        let first = self
            .first
            .entry(interface)
            .or_insert_with(|| numbers.clone());
        let differing = differing(&numbers, first);
        let reason = if found.mismatched > 0 {
            let pixels = found.mismatched;
            format!("{pixels} pixels show what the reference does not allow")
        } else if differing > 0 {
            format!("{differing} pixels differ from the first way's")
        } else if found.shown == 0 {
            "it shows nothing".to_owned()
        } else {
            String::new()
        };
        let draws = self.ground.ranges(keep).len() as f64;
        let texels = self.ground.samples().pow(2) * self.ground.blocks();
        let mut figures = vec![
            ("pipeline_mismatched_px", found.mismatched as f64),
            ("pipeline_band_px", found.in_band as f64),
            ("pipeline_differing_px", differing as f64),
            ("pipeline_shown_px", found.shown as f64),
            ("pipeline_held_bytes", 4.0 * f64::from(texels)),
            ("pipeline_draws", draws),
            ("cache_binds", draws),
        ];
        figures.extend(counted.figures());
        let notes = if is_first || !reason.is_empty() {
            let name = &self.group.cases[case].id.name;
            let pixels = of_relief(&numbers, &self.ground.grid);
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
    use crate::tested::{Tested, figure};
    use terrafill_results::Status;

    #[test]
    fn everything_that_keeps_blocks_draws_the_ground_and_exchanged_blocks_are_noticed() {
        let Some(tested) = Tested::open() else {
            return;
        };
        let group = group(QUICK_GROUNDS[0], (PICTURE, 1));
        let verdicts = tested.verdicts(&group);
        for (at, verdict) in &verdicts {
            let name = &group.cases[*at].id.name;
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
            let (_, keep) = group.work.ways[*at];
            let draws = if keep == Keep::Rebound { 16.0 } else { 1.0 };
            assert!(figure(verdict, "cache_binds") == draws, "{name}");
        }
        // Without an array of textures.
        assert!(verdicts.len() >= 8, "{}", verdicts.len());
        // Negative control, for every way: two blocks in each other's place, all but the samples that they share with others.
        let ground = BlockGround::new(4, 32);
        let rays = Rays::new(&ground.grid, GridCamera::new(), PICTURE);
        let truth = rays.picture(1);
        let mut exchanged = ground.clone();
        for (column, row) in (1..32).flat_map(|row| (1..32).map(move |column| (column, row))) {
            let [one, other] = [32, 64].map(|at| ground.grid.index(at + column, at + row));
            exchanged.grid.heights.swap(one, other);
        }
        for way in &group.work.ways {
            let drawn = |ground: &BlockGround| {
                let mut opened = open(&tested.devices, *way, ground, PICTURE).ok()?;
                let (picture, _) = opened.draw().expect("draws");
                Some(rays.judge_triangles(&ids_of(&picture), &truth).mismatched)
            };
            let Some(right) = drawn(&ground) else {
                continue;
            };
            assert_eq!(right, 0, "{way:?}");
            assert!(drawn(&exchanged).expect("opens") > 0, "{way:?}");
        }
    }
}
