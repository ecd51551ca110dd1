// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a stencil program runs on: closed volumes seen in a view, whatever they are the volumes of.
//!
//! The executors of the device crates take a [`VolumeList`] and know nothing of regions. A fill makes
//! its list from a [`FillInput`], one volume for each planned region; shadows of objects make theirs
//! from whatever casts them.

use crate::depth_range::depth_range;
use crate::{DepthRange, FillInput, ViewId};
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
                    geometry: planned.mesh,
                })
                .collect(),
        }
    }
}
