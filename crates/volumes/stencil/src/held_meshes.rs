// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which meshes a backend has on the device, and of which it has bottom caps: those of all regions at all levels, or
//! those that views drew.

use crate::{FillPass, FillProgram, FillStep, VolumeList};
use std::collections::{BTreeMap, BTreeSet};
use terrafill_plan::LevelTable;
use terrafill_variant::{BottomCap, DepthRuleChoice, Switches};

/// Meshes of which something is on the device, by their place in the scene's set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum HeldMeshes {
    /// All of the scene: no view brings a new one.
    All,
    /// These.
    Drawn(BTreeSet<usize>),
}

impl Default for HeldMeshes {
    /// None.
    fn default() -> Self {
        Self::Drawn(BTreeSet::new())
    }
}

impl HeldMeshes {
    /// Those whose bottom caps `program` draws; all of the scene where `switches` ask for them in every view, so that
    /// an eye on the move brings nothing new.
    pub(crate) fn bottoms_drawn_by(
        program: &FillProgram,
        list: &VolumeList,
        switches: &Switches,
    ) -> Self {
        let follows_view = switches.bottom_cap == BottomCap::WhereNeeded
            && switches.depth_rule != DepthRuleChoice::Fail;
        if !follows_view {
            return Self::All;
        }
        let steps = program.passes.iter().flat_map(FillPass::steps);
        let drawn = steps.flat_map(|step| match step {
            FillStep::Volumes(draw) if !draw.without_bottom => draw.volumes,
            _ => &[],
        });
        Self::Drawn(drawn.map(|&volume| list.volumes[volume].geometry).collect())
    }

    /// What the volumes of a view need, as `switches` hold meshes.
    pub(crate) fn needed_by(list: &VolumeList, switches: &Switches) -> Self {
        if !switches.holds_drawn_meshes {
            Self::All
        } else {
            Self::Drawn(list.volumes.iter().map(|volume| volume.geometry).collect())
        }
    }

    /// Whether all of `needed` are among these.
    pub(crate) fn hold(&self, needed: &Self) -> bool {
        match (self, needed) {
            (Self::All, _) => true,
            (Self::Drawn(_), Self::All) => false,
            (Self::Drawn(held), Self::Drawn(needed)) => needed.is_subset(held),
        }
    }

    /// Those of both.
    pub(crate) fn joined(&self, other: &Self) -> Self {
        match (self, other) {
            (Self::Drawn(some), Self::Drawn(others)) => Self::Drawn(some | others),
            _ => Self::All,
        }
    }

    /// What is held after a view that needs `needed`. Of a region that it draws that is the level drawn, and of any
    /// other the level that was held. So a region that leaves the view and comes back is uploaded once.
    ///
    /// - `meshes`: how many the scene has
    pub(crate) fn followed_by(&self, needed: &Self, levels: &LevelTable, meshes: usize) -> Self {
        let (Self::Drawn(held), Self::Drawn(needed)) = (self, needed) else {
            return needed.clone();
        };
        let mut of_region: BTreeMap<usize, usize> = BTreeMap::new();
        for mesh in held.iter().chain(needed) {
            of_region.insert(levels.region_of(*mesh, meshes), *mesh);
        }
        Self::Drawn(of_region.into_values().collect())
    }

    /// Whether a mesh is held.
    #[must_use]
    pub fn has(&self, mesh: usize) -> bool {
        match self {
            Self::All => true,
            Self::Drawn(meshes) => meshes.contains(&mesh),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DepthRange, Volume};
    use terrafill_contract::ViewId;
    use terrafill_plan::{DrawnAs, Level, NearRectangle, PixelRect};
    use terrafill_scene::{ImageSize, Overlap};
    use terrafill_variant::ColourWay;

    fn drawn(meshes: &[usize]) -> HeldMeshes {
        HeldMeshes::Drawn(meshes.iter().copied().collect())
    }

    /// Three regions at two levels: meshes 0, 1, 2, and 3, 4, 5.
    fn levels() -> LevelTable {
        LevelTable {
            coarser: vec![Level {
                tolerance_m: 1.0,
                meshes: vec![3, 4, 5],
                deviation_m: vec![1.0; 3],
                left_out: vec![Default::default(); 3],
            }],
            neighbours: Vec::new(),
            boundaries: Vec::new(),
        }
    }

    #[test]
    fn each_region_is_held_at_the_level_that_it_was_last_drawn_at() {
        let first = drawn(&[3, 4]);
        assert!(first.hold(&drawn(&[4])) && first.has(3) && !first.has(0));
        // Negative control: another level of a region that is held is not held.
        assert!(!first.hold(&drawn(&[1])));
        let second = first.followed_by(&drawn(&[1, 5]), &levels(), 6);
        assert_eq!(second, drawn(&[1, 3, 5]));
        let third = second.followed_by(&drawn(&[0]), &levels(), 6);
        assert_eq!(third, drawn(&[0, 1, 5]));
    }

    /// Three volumes, of meshes 10, 11 and 12; the near plane meets the second.
    fn list() -> VolumeList {
        let size = ImageSize::new(8, 8);
        let volume = |geometry| Volume {
            screen_rect: PixelRect::full(size),
            depth: DepthRange::ANY,
            near_rectangle: NearRectangle::by_bounds(geometry == 11),
            drawn_as: DrawnAs::Volume,
            geometry,
        };
        VolumeList::new(ViewId::unique(), size, (10..13).map(volume).collect())
    }

    fn of(depth_rule: DepthRuleChoice, bottom_cap: BottomCap) -> HeldMeshes {
        let list = list();
        let switches = Switches {
            colour: ColourWay::Rectangle,
            depth_rule,
            bottom_cap,
            ..Switches::default()
        };
        let program = FillProgram::new(&list.volumes, &switches, Overlap::Disjoint);
        HeldMeshes::bottoms_drawn_by(&program.expect("allowed"), &list, &switches)
    }

    #[test]
    fn bottoms_are_those_of_volumes_that_count_behind_the_surface() {
        let found = of(DepthRuleChoice::Automatic, BottomCap::WhereNeeded);
        assert_eq!(found, drawn(&[11]));
        assert!(found.has(11) && !found.has(10));
        let found = of(DepthRuleChoice::Pass, BottomCap::WhereNeeded);
        assert_eq!(found, HeldMeshes::default());
        // Negative controls: asked for in every view, they are all there.
        for (rule, bottom) in [
            (DepthRuleChoice::Fail, BottomCap::WhereNeeded),
            (DepthRuleChoice::Automatic, BottomCap::FirstPass),
            (DepthRuleChoice::Automatic, BottomCap::Always),
        ] {
            assert_eq!(of(rule, bottom), HeldMeshes::All, "{rule:?} {bottom:?}");
        }
    }

    #[test]
    fn what_is_held_grows() {
        let held = drawn(&[1, 2]);
        assert!(held.hold(&HeldMeshes::default()) && !held.hold(&drawn(&[3])));
        assert_eq!(held.joined(&drawn(&[3])), drawn(&[1, 2, 3]));
        assert_eq!(held.joined(&HeldMeshes::All), HeldMeshes::All);
    }

    #[test]
    fn what_holds_all_is_never_brought_anything() {
        assert!(HeldMeshes::All.hold(&drawn(&[7])) && HeldMeshes::All.has(7));
        assert!(!drawn(&[7]).hold(&HeldMeshes::All));
        let all = drawn(&[1]).followed_by(&HeldMeshes::All, &levels(), 6);
        assert_eq!(all, HeldMeshes::All);
    }
}
