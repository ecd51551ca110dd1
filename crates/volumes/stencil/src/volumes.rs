// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a stencil program runs on: closed volumes seen in a view, whatever they are the volumes of.
//!
//! The executors of the device crates take a [`VolumeList`] and know nothing of regions. A fill makes
//! its list from a [`FillInput`], one volume for each planned region; shadows of objects make theirs
//! from whatever casts them.

use crate::cover_tiles::cover_tiles;
use std::collections::BTreeMap;
use terrafill_contract::{FillInput, ViewId};
use terrafill_plan::{DrawnAs, NearRectangle, PixelRect, PlannedRegion};
use terrafill_scene::ImageSize;
use terrafill_variant::{CoverArea, Switches};

/// The range of the surface's depth in which a volume can lie at all; reversed, `0 ≤ low ≤ high ≤ 1`.
///
/// Where the surface is nearer than the volume or farther, every ray crosses the volume an even number of
/// times on either side. So its fragments may be dropped before they touch the stencil. The range is that of
/// the corners of a box that holds the volume, along the viewing direction; with reversed depth the farthest
/// corner gives the lower end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthRange {
    /// At the farthest corner, or below.
    pub low: f32,
    /// At the nearest corner, or above.
    pub high: f32,
}

impl DepthRange {
    /// Every depth there is.
    pub const ANY: Self = Self {
        low: 0.0,
        high: 1.0,
    };
}

/// A closed solid. A stencil program marks the part of the surface that lies inside it.
///
/// Its place in the list is the index of its constants, and the instance number of its draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Volume {
    /// No pixel that it marks lies outside.
    pub screen_rect: PixelRect,
    /// Depth of the surface wherever it may lie inside the volume.
    pub depth: DepthRange,
    /// Where the near rectangle lies, seen from it.
    pub near_rectangle: NearRectangle,
    /// What of it is drawn. As a flat mesh it is so low that its top cap and walls, where nearer than the surface,
    /// stand for it; as ground it holds all surface in view.
    pub drawn_as: DrawnAs,
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
    /// No pixel outside shows what volumes may mark: what is not cut to a rectangle is cut to this.
    pub area: PixelRect,
    /// Later ones cover earlier ones.
    pub volumes: Vec<Volume>,
    /// Of some volumes, rectangles that hold all of their pixels and none twice: what merged covers draw instead
    /// of the screen rectangle.
    pub cover_tiles: BTreeMap<usize, Vec<PixelRect>>,
}

impl VolumeList {
    /// Volumes that may be drawn anywhere in an image.
    #[must_use]
    pub fn new(view_id: ViewId, size: ImageSize, volumes: Vec<Volume>) -> Self {
        Self {
            view_id,
            size,
            area: PixelRect::full(size),
            volumes,
            cover_tiles: BTreeMap::new(),
        }
    }

    /// One volume for each planned region, in the order of the plan, as `switches` need it.
    ///
    /// - cost: with `cover-area=tiles` O(triangles of regions with many pixels a triangle)
    #[must_use]
    pub fn of(input: &FillInput, switches: &Switches) -> Self {
        let mut list = Self::from(input);
        if switches.cover_area == CoverArea::Tiles {
            let planned = input.plan.regions.iter().enumerate();
            let planned = planned.filter(|(_, planned)| planned.drawn_as == DrawnAs::Volume);
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

    /// Where a volume may be drawn: its screen rectangle with `scissor`, else all of the list's area.
    #[must_use]
    pub fn rect(&self, volume: usize, scissor: bool) -> PixelRect {
        if scissor {
            self.volumes[volume].screen_rect
        } else {
            self.area
        }
    }
}

impl From<&FillInput> for VolumeList {
    /// One volume for each planned region, in the order of the plan; geometries are numbered as the
    /// meshes.
    fn from(input: &FillInput) -> Self {
        let volume = |planned: &PlannedRegion| Volume {
            screen_rect: planned.screen_rect,
            depth: DepthRange::ANY,
            near_rectangle: planned.near_rectangle,
            drawn_as: planned.drawn_as,
            geometry: planned.mesh,
        };
        let volumes = input.plan.regions.iter().map(volume).collect();
        let list = Self::new(input.view_id, input.size, volumes);
        Self {
            area: input.plan.ground.unwrap_or(list.area),
            ..list
        }
    }
}
