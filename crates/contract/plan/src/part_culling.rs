// SPDX-License-Identifier: MIT OR Apache-2.0
//! Plans that leave out parts of large regions.

use crate::left_out::LeftOutReason;
use crate::near_plane::NearRectangle;
use crate::parts::SeenParts;
use crate::plan::{FramePlan, PartCulling, PlacedMesh, Planner};
use glam::DVec3;

impl FramePlan {
    /// Leaves out parts of large regions, as the options say. Comes after
    /// [`FramePlan::settle_near_plane`], which says of which volumes fragments count in front.
    ///
    /// - cost: O(parts of the regions drawn)
    pub(crate) fn cull_parts<'m>(
        &mut self,
        planner: &Planner<'_>,
        placed: impl Fn(usize) -> Option<PlacedMesh<'m>>,
    ) {
        let hides = self.options.part_culling == PartCulling::All;
        for mut planned in std::mem::take(&mut self.regions) {
            let Some(parts) = placed(planned.mesh).and_then(|placed| placed.parts) else {
                self.regions.push(planned);
                continue;
            };
            let counts_in_front = hides && planned.near_rectangle == NearRectangle::Outside;
            let look = |corners: &[DVec3; 8]| planner.look_at_part(corners, counts_in_front);
            let (seen, rect) = parts.seen(planned.heights, look);
            let rect = rect.map(|rect| rect.within(planned.screen_rect));
            if let Some(rect) = rect.filter(|rect| rect.width() > 0 && rect.height() > 0) {
                planned.screen_rect = rect;
                self.regions.push(planned);
                self.seen_parts.insert(planned.mesh, seen);
            } else {
                // A pixel that shows the region shows one of its facets' parts.
                let last = seen.left_out.into_keys().next_back();
                let reason = last.unwrap_or(LeftOutReason::OutsideFrustum);
                self.place(planned.region, Err(reason));
            }
        }
        self.left_out.sort_by_key(|region| region.mesh);
    }

    /// One phrase on the parts left out by reason, of how many, and with how many facets and walls.
    pub(crate) fn parts_left_out(&self) -> Option<String> {
        let sum = |of: fn(&SeenParts) -> usize| self.seen_parts.values().map(of).sum::<usize>();
        let facets = sum(|seen| seen.facets_left_out);
        if facets == 0 {
            return None;
        }
        let by_reason = LeftOutReason::ALL.into_iter().filter_map(|reason| {
            let of = |seen: &SeenParts| seen.left_out.get(&reason).copied().unwrap_or(0);
            let parts: usize = self.seen_parts.values().map(of).sum();
            (parts > 0).then(|| format!("{parts} {}", reason.name()))
        });
        Some(format!(
            "{} of {} parts of large regions, with {facets} of {} facets and walls",
            by_reason.collect::<Vec<_>>().join(" and "),
            sum(|seen| seen.of_parts),
            sum(|seen| seen.of_facets)
        ))
    }
}
