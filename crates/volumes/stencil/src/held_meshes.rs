// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which meshes a backend has on the device: those of all regions at all levels, or those that views drew.

use crate::VolumeList;
use std::collections::{BTreeMap, BTreeSet};
use terrafill_plan::LevelTable;
use terrafill_variant::Switches;

/// Meshes on the device, by their place in the scene's set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum HeldMeshes {
    /// All of the scene: no view brings a new one.
    All,
    /// These.
    Drawn(BTreeSet<usize>),
}

impl HeldMeshes {
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
    pub(crate) fn has(&self, mesh: usize) -> bool {
        match self {
            Self::All => true,
            Self::Drawn(meshes) => meshes.contains(&mesh),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_plan::Level;

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

    #[test]
    fn what_holds_all_is_never_brought_anything() {
        assert!(HeldMeshes::All.hold(&drawn(&[7])) && HeldMeshes::All.has(7));
        assert!(!drawn(&[7]).hold(&HeldMeshes::All));
        let all = drawn(&[1]).followed_by(&HeldMeshes::All, &levels(), 6);
        assert_eq!(all, HeldMeshes::All);
    }
}
