// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which meshes' bottom caps a view draws, so that those that store them hold no others.

use crate::{FillPass, FillProgram, FillStep, VolumeList};
use std::collections::BTreeSet;
use terrafill_variant::{BottomCap, DepthRuleChoice, Switches};

/// Meshes with bottom caps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BottomCaps {
    /// All: the switches draw them whatever the view.
    All,
    /// These.
    Of(BTreeSet<usize>),
}

impl Default for BottomCaps {
    /// None.
    fn default() -> Self {
        Self::Of(BTreeSet::new())
    }
}

impl BottomCaps {
    /// Those that `program` draws; all of the scene where `switches` ask for them in every view, so that an
    /// eye on the move brings nothing new.
    #[must_use]
    pub fn drawn_by(program: &FillProgram, list: &VolumeList, switches: &Switches) -> Self {
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
        Self::Of(drawn.map(|&volume| list.volumes[volume].geometry).collect())
    }

    /// Whether a mesh has one.
    #[must_use]
    pub fn has(&self, mesh: usize) -> bool {
        match self {
            Self::All => true,
            Self::Of(meshes) => meshes.contains(&mesh),
        }
    }

    /// Whether all of `wanted` are among these.
    #[must_use]
    pub fn hold(&self, wanted: &Self) -> bool {
        match (self, wanted) {
            (Self::All, _) => true,
            (Self::Of(_), Self::All) => false,
            (Self::Of(held), Self::Of(wanted)) => wanted.is_subset(held),
        }
    }

    /// Those of both.
    #[must_use]
    pub fn joined(&self, other: &Self) -> Self {
        match (self, other) {
            (Self::Of(some), Self::Of(others)) => Self::Of(some | others),
            _ => Self::All,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DepthRange, Volume};
    use terrafill_contract::ViewId;
    use terrafill_plan::{DrawnAs, NearRectangle, PixelRect};
    use terrafill_scene::{ImageSize, Overlap};
    use terrafill_variant::ColourWay;

    /// Three volumes, of meshes 10, 11 and 12; the near plane meets the second.
    fn list() -> VolumeList {
        let size = ImageSize {
            width: 8,
            height: 8,
        };
        let volume = |geometry| Volume {
            screen_rect: PixelRect::full(size),
            depth: DepthRange::ANY,
            near_rectangle: NearRectangle::by_bounds(geometry == 11),
            drawn_as: DrawnAs::Volume,
            geometry,
        };
        VolumeList::new(ViewId::unique(), size, (10..13).map(volume).collect())
    }

    fn of(depth_rule: DepthRuleChoice, bottom_cap: BottomCap) -> BottomCaps {
        let list = list();
        let switches = Switches {
            colour: ColourWay::Rectangle,
            depth_rule,
            bottom_cap,
            ..Switches::default()
        };
        let program = FillProgram::new(&list.volumes, &switches, Overlap::Disjoint);
        BottomCaps::drawn_by(&program.expect("allowed"), &list, &switches)
    }

    #[test]
    fn bottoms_are_those_of_volumes_that_count_behind_the_surface() {
        let found = of(DepthRuleChoice::Automatic, BottomCap::WhereNeeded);
        assert_eq!(found, BottomCaps::Of([11].into()));
        assert!(found.has(11) && !found.has(10));
        let found = of(DepthRuleChoice::Pass, BottomCap::WhereNeeded);
        assert_eq!(found, BottomCaps::default());
        // Negative controls: asked for in every view, they are all there.
        for (rule, bottom) in [
            (DepthRuleChoice::Fail, BottomCap::WhereNeeded),
            (DepthRuleChoice::Automatic, BottomCap::FirstPass),
            (DepthRuleChoice::Automatic, BottomCap::Always),
        ] {
            assert_eq!(of(rule, bottom), BottomCaps::All, "{rule:?} {bottom:?}");
        }
    }

    #[test]
    fn what_is_held_grows() {
        let of = |meshes: &[usize]| BottomCaps::Of(meshes.iter().copied().collect());
        let held = of(&[1, 2]);
        assert!(held.hold(&of(&[2])) && held.hold(&BottomCaps::default()));
        assert!(!held.hold(&of(&[3])) && !held.hold(&BottomCaps::All));
        assert_eq!(held.joined(&of(&[3])), of(&[1, 2, 3]));
        assert_eq!(held.joined(&BottomCaps::All), BottomCaps::All);
        assert!(BottomCaps::All.hold(&held) && BottomCaps::All.has(7));
    }
}
