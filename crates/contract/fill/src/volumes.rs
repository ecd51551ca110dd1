// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a stencil program runs on: closed volumes seen in a view, whatever they are the volumes of.
//!
//! The executors of the device crates take a [`VolumeList`] and know nothing of regions. A fill makes
//! its list from a [`FillInput`], one volume for each planned region; shadows of objects make theirs
//! from whatever casts them.

use crate::depth_range::depth_range;
use crate::front_caps::caps_kept;
use crate::{DepthRange, FillInput, Switches, ViewId};
use terrafill_scene::{ImageSize, PixelRect};

/// A closed solid. A stencil program marks the part of the surface that lies inside it.
///
/// Its place in the list is the index of its constants, and the instance number of its draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Volume {
    /// No pixel that it marks lies outside.
    pub screen_rect: PixelRect,
    /// Depth of the surface wherever it may lie inside the volume.
    pub depth: DepthRange,
    /// The near plane may meet it: counting fragments in front of the surface would miss faces.
    pub near_plane_meets_volume: bool,
    /// It is so low that its top cap and walls, where nearer than the surface, may stand for it.
    pub is_flat: bool,
    /// Facets of its top that face away from the eye may be left out, where fragments count in front of
    /// the surface and covers leave out the sky.
    pub front_caps_suffice: bool,
    /// Which geometry it has: a number that only those who draw volumes understand.
    pub geometry: usize,
}

/// The volumes of a view.
#[derive(Debug, Clone, PartialEq)]
pub struct VolumeList {
    /// The view in which they are seen.
    pub view_id: ViewId,
    /// Its image.
    pub size: ImageSize,
    /// Later ones cover earlier ones.
    pub volumes: Vec<Volume>,
}

impl VolumeList {
    /// One volume for each planned region, in the order of the plan, as `switches` need it.
    ///
    /// - cost: with `cap-faces=front`, O(triangles of all planned regions)
    #[must_use]
    pub fn of(input: &FillInput, switches: &Switches) -> Self {
        let mut list = Self::from(input);
        if switches.front_caps {
            for (volume, planned) in list.volumes.iter_mut().zip(&input.plan.regions) {
                volume.front_caps_suffice = caps_kept(input, planned).is_none();
            }
        }
        list
    }

    /// Where a volume may be drawn: its screen rectangle with `scissor`, else everywhere.
    #[must_use]
    pub fn rect(&self, volume: usize, scissor: bool) -> PixelRect {
        if scissor {
            self.volumes[volume].screen_rect
        } else {
            PixelRect::full(self.size)
        }
    }
}

impl From<&FillInput> for VolumeList {
    /// One volume for each planned region, in the order of the plan; geometries are numbered as the
    /// meshes.
    fn from(input: &FillInput) -> Self {
        let planned = input.plan.regions.iter();
        Self {
            view_id: input.view_id,
            size: input.size,
            volumes: planned
                .map(|planned| Volume {
                    screen_rect: planned.screen_rect,
                    depth: depth_range(input, planned),
                    near_plane_meets_volume: planned.near_plane_meets_volume,
                    is_flat: planned.is_flat,
                    front_caps_suffice: false,
                    geometry: planned.mesh,
                })
                .collect(),
        }
    }
}
