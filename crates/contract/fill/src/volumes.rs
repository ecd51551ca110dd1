// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a stencil program runs on: closed volumes seen in a view, whatever they are the volumes of.
//!
//! The executors of the device crates take a [`VolumeList`] and know nothing of regions. A fill makes
//! its list from a [`FillInput`], one volume for each planned region; shadows of objects make theirs
//! from whatever casts them.

use crate::cover_tiles::cover_tiles;
use crate::depth_range::depth_range;
use crate::front_caps::caps_kept;
use crate::{CoverArea, DepthRange, FillInput, Switches, ViewId};
use std::collections::BTreeMap;
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
    /// Of some volumes, rectangles that hold all of their pixels and none twice: what merged covers draw instead
    /// of the screen rectangle.
    pub cover_tiles: BTreeMap<usize, Vec<PixelRect>>,
}

impl VolumeList {
    /// One volume for each planned region, in the order of the plan, as `switches` need it.
    ///
    /// - cost: with `cap-faces=front` or `cover-area=tiles`, O(triangles of all planned regions)
    #[must_use]
    pub fn of(input: &FillInput, switches: &Switches) -> Self {
        let mut list = Self::from(input);
        if switches.front_caps() {
            for (volume, planned) in list.volumes.iter_mut().zip(&input.plan.regions) {
                volume.front_caps_suffice = caps_kept(input, planned).is_none();
            }
        }
        if switches.cover_area == CoverArea::Tiles {
            let planned = input.plan.regions.iter().enumerate();
            let tiles =
                planned.filter_map(|(at, planned)| Some((at, cover_tiles(input, planned)?)));
            list.cover_tiles = tiles.collect();
        }
        list
    }

    /// Rectangles of a volume's cover.
    pub fn cover_rects(&self, volume: usize, scissor: bool) -> impl Iterator<Item = PixelRect> {
        let tiles = self.cover_tiles.get(&volume).filter(|_| scissor);
        let whole = tiles.is_none().then(|| self.rect(volume, scissor));
        tiles.into_iter().flatten().copied().chain(whole)
    }

    /// How many rectangles merged covers of these volumes are.
    #[must_use]
    pub fn cover_count(&self, volumes: &[usize], scissor: bool) -> u32 {
        let counts = volumes.iter();
        let counts = counts.map(|&volume| self.cover_rects(volume, scissor).count());
        u32::try_from(counts.sum::<usize>()).unwrap_or(u32::MAX)
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
            cover_tiles: BTreeMap::new(),
        }
    }
}
