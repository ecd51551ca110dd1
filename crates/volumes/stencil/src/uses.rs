// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the stencil program of a view does, counted: what reasons for what it holds are made from.

use crate::{CoverShape, DepthRule, FaceEffect, FillCommand, FillProgram, VolumeList};
use std::collections::BTreeSet;
use terrafill_contract::FillInput;
use terrafill_plan::NearRectangle;
use terrafill_variant::Switches;

/// Counts over a program.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Uses {
    /// In view.
    pub(crate) volumes: usize,
    /// Those whose volumes the near plane may meet.
    pub(crate) cut_by_near_plane: usize,
    /// Volumes that the near rectangle lies in.
    pub(crate) around_near_plane: usize,
    /// From the eye to the nearest one's box, metres; 0 inside, `None` without any.
    pub(crate) nearest_m: Option<f64>,
    /// Volumes marked behind the surface, and in front of it.
    pub(crate) behind: usize,
    pub(crate) before: usize,
    /// Volumes drawn with their bottoms.
    pub(crate) bottoms: usize,
    /// Plain covers, by triangles over the screen or by volumes.
    pub(crate) covers: usize,
    /// Low volumes.
    pub(crate) flat: usize,
    /// Bits of the stencil that are written.
    pub(crate) stencil_bits: u8,
    /// Volumes are counted in it.
    pub(crate) counts_in_stencil: bool,
    /// Numbers add up in a target.
    pub(crate) accumulates: bool,
    /// Covers and volumes that are cut to their region's rectangle.
    pub(crate) cut_covers: usize,
    /// Covers cut to tiles, rectangles of these, their pixels, and those of the screen rectangles in their place.
    pub(crate) tiled_covers: Option<[u64; 4]>,
    pub(crate) cut_volumes: usize,
}

impl Uses {
    pub(crate) fn new(
        input: &FillInput,
        list: &VolumeList,
        program: &FillProgram,
        switches: &Switches,
    ) -> Self {
        let lying = |there: NearRectangle| {
            let all = list.volumes.iter();
            all.filter(|volume| volume.near_rectangle == there).count()
        };
        let nearest = input.plan.regions.iter().filter_map(|planned| {
            let bounds = input.scene.bounds.get(planned.mesh)?;
            Some(bounds.bounds.distances_m(input.camera.eye_ecef).0)
        });
        let mut uses = Self {
            volumes: list.volumes.len(),
            cut_by_near_plane: lying(NearRectangle::Cut),
            around_near_plane: lying(NearRectangle::Within),
            nearest_m: nearest.reduce(f64::min),
            accumulates: program.accumulates(),
            tiled_covers: tiled_covers(list),
            ..Self::default()
        };
        // Two commands mark a volume where its faces do so apart.
        let none = || BTreeSet::<usize>::new();
        let [mut behind, mut before, mut bottoms, mut cut] = [none(), none(), none(), none()];
        let mut mark =
            |depth: DepthRule, without_bottom: bool, scissor: bool, volumes: &[usize]| {
                match depth {
                    DepthRule::Fail | DepthRule::Always => behind.extend(volumes),
                    DepthRule::Pass => before.extend(volumes),
                }
                if !without_bottom {
                    bottoms.extend(volumes);
                }
                if scissor {
                    cut.extend(volumes);
                }
            };
        for command in program.commands() {
            match command {
                FillCommand::Volumes {
                    rule,
                    without_bottom,
                    scissor,
                    volumes,
                } => {
                    mark(rule.depth, *without_bottom, *scissor, volumes);
                    let (front, _, mask) = rule.effects();
                    uses.stencil_bits |= mask;
                    uses.counts_in_stencil |= matches!(front, FaceEffect::Add | FaceEffect::Take);
                }
                FillCommand::Accumulate {
                    depth,
                    without_bottom,
                    scissor,
                    volumes,
                    ..
                } => mark(*depth, *without_bottom, *scissor, volumes),
                FillCommand::Cover { shape, volumes, .. } => match shape {
                    CoverShape::Flat => uses.flat += volumes.len(),
                    // Of textured ones, other features speak.
                    CoverShape::Rectangle => {
                        uses.cut_covers += volumes.len();
                        uses.add_covers(volumes.len(), switches);
                    }
                    CoverShape::Screen | CoverShape::Volume { .. } => {
                        uses.add_covers(volumes.len(), switches);
                    }
                },
                FillCommand::Resolve => uses.covers += 1,
            }
        }
        uses.behind = behind.len();
        uses.before = before.len();
        uses.bottoms = bottoms.len();
        uses.cut_volumes = cut.len();
        uses
    }

    fn add_covers(&mut self, covers: usize, switches: &Switches) {
        if switches.texture.is_none() {
            self.covers += covers;
        }
    }
}

/// See [`Uses::tiled_covers`].
fn tiled_covers(list: &VolumeList) -> Option<[u64; 4]> {
    let mut found = [0; 4];
    for (&volume, tiles) in &list.cover_tiles {
        found[0] += 1;
        found[1] += tiles.len() as u64;
        found[2] += tiles.iter().map(|tile| tile.area()).sum::<u64>();
        found[3] += list.volumes[volume].screen_rect.area();
    }
    (found[0] > 0).then_some(found)
}

/// A length in the unit that it is read in.
pub(crate) fn length(metres: f64) -> String {
    if metres < 1e3 {
        format!("{metres:.1} m")
    } else if metres < 1e5 {
        format!("{:.1} km", metres / 1e3)
    } else {
        format!("{:.0} km", metres / 1e3)
    }
}
