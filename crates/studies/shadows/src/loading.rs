// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes from the CPU as a device is handed them, and the stencil program that counts them.
//!
//! Casters, parts, or parts by rule are a volume each of the program's list. Over 255 volumes may lie over one
//! pixel only in passes of 255, each of which darkens for itself.

use crate::counted::Ranges;
use crate::way::{Bounds, Counting, Cut, DeviceWay};
use crate::work::Scene;
use glam::{DVec3, DVec4};
use std::ops::Range;
use terrafill_casters::Volume;
use terrafill_contract::DeviceError;
use terrafill_core::nearest_f32;
use terrafill_plan::{NearRectangle, PixelRect};
use terrafill_scene::Overlap;
use terrafill_shadow_views::{
    Boxes, DeckCamera, EyeVolumes, NONE, Reference, Rule, VolumeSource, around, count,
    eye_vertices, joined, listed, near_caps, of_parts,
};
use terrafill_stencil::{DepthRange, DepthRule, FillCommand, FillProgram};
use terrafill_study::Failure;
use terrafill_variant::Switches;

/// Volumes that 8 bits count over one pixel.
const COUNTABLE: usize = 255;
/// A depth range is wider by this share and by this much, as that of regions is.
const RELATIVE: f64 = 1.0 / 1024.0;
const ABSOLUTE: f64 = 1.0 / (1 << 22) as f64;

/// What a channel's program runs on.
pub(crate) struct Loadable {
    pub(crate) source: VolumeSource,
    pub(crate) list: Vec<terrafill_stencil::Volume>,
    pub(crate) left_out: usize,
}

/// Parts that are one volume of the list, and whether the near plane may meet it.
pub(crate) struct Together {
    pub(crate) parts: Vec<usize>,
    pub(crate) is_near: bool,
}

impl Together {
    /// Where it is drawn; `None` for nowhere.
    ///
    /// - `rectangles`: of each part, where volumes are cut to theirs
    /// - `above_sea`: as of [`Scene::above_sea`]
    pub(crate) fn rectangle(
        &self,
        way: DeviceWay,
        view: &DeckCamera,
        rectangles: Option<&[PixelRect]>,
        above_sea: PixelRect,
    ) -> Option<PixelRect> {
        if way.cut == Cut::SeaLevel {
            return (above_sea.area() > 0).then_some(above_sea);
        }
        let own = rectangles.map(|all| self.parts.iter().map(|part| all[*part]).fold(NONE, joined));
        match own {
            Some(own) if own.area() == 0 => None,
            Some(own) if way.cut == Cut::Rectangle => Some(own),
            _ => Some(view.whole()),
        }
    }
}

impl Scene {
    /// The rectangle round all that stands above the sea, as a view has it; the whole where nothing is cut to it.
    pub(crate) fn above_sea(&self, way: DeviceWay, view: &DeckCamera) -> PixelRect {
        if way.cut != Cut::SeaLevel {
            return view.whole();
        }
        let mesh = self.mesh();
        let all =
            (0..mesh.triangles.len()).map(|at| mesh.corners(at).map(|place| place - view.eye));
        all.map(|corners| around(view, &corners)).fold(NONE, joined)
    }

    /// Depths between which a channel may see something above the sea: those of all that stands in its picture. The lower
    /// one is above the higher one where nothing does.
    fn depths_above_sea(&self, view: &DeckCamera) -> DepthRange {
        let mesh = self.mesh();
        let all = (0..mesh.triangles.len()).map(|at| mesh.corners(at));
        let is_seen =
            |corners: &[DVec3; 3]| around(view, &corners.map(|place| place - view.eye)).area() > 0;
        let seen = all.filter(is_seen).flatten();
        depth_range(view, seen.map(|place| place.extend(1.0)))
    }

    /// What is counted and drawn together.
    pub(crate) fn groups(
        &self,
        way: DeviceWay,
        view: &DeckCamera,
        reference: &Reference<'_>,
    ) -> Vec<Together> {
        let mesh = self.mesh();
        let all = |parts: Range<usize>| Together {
            parts: parts.collect(),
            is_near: false,
        };
        match way.counting {
            Counting::Casters | Counting::ZpPlus => {
                let casters = mesh.casters.iter();
                casters.map(|caster| all(caster.parts.clone())).collect()
            }
            Counting::Parts { .. } => {
                let parts = 0..mesh.parts.len();
                parts.map(|part| all(part..part + 1)).collect()
            }
            Counting::Chosen(test) | Counting::ByView(test) => {
                let mut fail = self.fails(test, view, &Boxes::of(mesh), reference);
                if matches!(way.counting, Counting::ByView(_)) {
                    let is_any = fail.contains(&true);
                    fail.fill(is_any);
                }
                let of = |caster: &terrafill_casters::Caster| {
                    let split = [false, true].map(|is_near| {
                        let parts = caster.parts.clone();
                        let parts = parts.filter(|part| fail[*part] == is_near).collect();
                        Together { parts, is_near }
                    });
                    split.into_iter().filter(|own| !own.parts.is_empty())
                };
                mesh.casters.iter().flat_map(of).collect()
            }
        }
    }

    /// Volumes of the CPU by caster, as this eye sees them: what is handed over.
    pub(crate) fn eye_volumes(
        &self,
        way: DeviceWay,
        view: &DeckCamera,
        volume: &Volume,
    ) -> EyeVolumes {
        let mut volumes = EyeVolumes {
            vertices: eye_vertices(way.positions, view, volume),
            ..EyeVolumes::default()
        };
        let of_part = corners_of_parts(volume, self.mesh().parts.len());
        for caster in &self.mesh().casters {
            let first = count(volumes.indices.len());
            for part in caster.parts.clone() {
                volumes.indices.extend(&of_part[part]);
            }
            volumes.ranges.push(first..count(volumes.indices.len()));
        }
        volumes
    }

    /// Volumes as this eye sees them.
    ///
    /// - `closed`: what rectangles are made of, where volumes are cut
    pub(crate) fn loadable(
        &self,
        way: DeviceWay,
        view: &DeckCamera,
        volume: &Volume,
        closed: Option<&Volume>,
        reference: &Reference<'_>,
    ) -> Result<Loadable, Failure> {
        let mesh = self.mesh();
        let mut volumes = EyeVolumes {
            vertices: eye_vertices(way.positions, view, volume),
            ..EyeVolumes::default()
        };
        let (mut list, mut left_out) = (Vec::new(), 0);
        let above_sea = self.above_sea(way, view);
        let one_range = (way.ranges == Ranges::One).then(|| self.depths_above_sea(view));
        let rectangles = closed.map(|closed| of_parts(view, closed, mesh.parts.len()));
        let of_part = corners_of_parts(volume, mesh.parts.len());
        for group in self.groups(way, view, reference) {
            let rectangle = group.rectangle(way, view, rectangles.as_deref(), above_sea);
            // A channel that shows the open sea alone has no depth of interest.
            let rectangle = rectangle.filter(|_| one_range.is_none_or(|own| own.low <= own.high));
            let Some(screen_rect) = rectangle else {
                left_out += 1;
                continue;
            };
            let first = volumes.indices.len();
            for part in group.parts {
                volumes.indices.extend(&of_part[part]);
            }
            let own = &volumes.indices[first..];
            let places = own.iter().map(|at| volume.vertices[*at as usize]);
            let depth = match (way.bounds, one_range) {
                (Bounds::Off, _) => DepthRange::ANY,
                (_, Some(of_channel)) => of_channel,
                (_, None) => depth_range(view, places),
            };
            list.push(terrafill_stencil::Volume {
                near_rectangle: NearRectangle::by_bounds(group.is_near),
                depth,
                ..listed(screen_rect, volumes.ranges.len())
            });
            volumes
                .ranges
                .push(count(first)..count(volumes.indices.len()));
        }
        if way.counting == Counting::ZpPlus {
            let caps = near_caps(view, self.to_light, mesh, &self.facing)?;
            let first = count(volumes.indices.len());
            for place in caps.iter().flatten() {
                let along = (*place - view.eye).as_vec3().extend(1.0);
                volumes.indices.push(count(volumes.vertices.len()));
                volumes.vertices.push(along.to_array().map(f32::to_bits));
            }
            if !caps.is_empty() {
                list.push(listed(view.whole(), volumes.ranges.len()));
                volumes.ranges.push(first..count(volumes.indices.len()));
            }
        }
        Ok(Loadable {
            source: VolumeSource::Volumes(volumes),
            list,
            left_out,
        })
    }
}

/// Of each part, corners of its volume's triangles.
fn corners_of_parts(volume: &Volume, parts: usize) -> Vec<Vec<u32>> {
    let mut of_part = vec![Vec::new(); parts];
    for triangle in &volume.triangles {
        of_part[triangle.part as usize].extend(triangle.corners);
    }
    of_part
}

/// Depths of a surface that has these corners, or is within a closed volume of them.
fn depth_range(view: &DeckCamera, corners: impl Iterator<Item = DVec4>) -> DepthRange {
    let (mut nearest, mut farthest) = (f64::INFINITY, f64::NEG_INFINITY);
    for corner in corners {
        let along = corner.truncate() - view.eye * corner.w;
        let distance = if corner.w > 0.0 {
            along.dot(view.forward)
        } else {
            along.dot(view.forward).signum() * f64::INFINITY
        };
        nearest = nearest.min(distance);
        farthest = farthest.max(distance);
    }
    range_of([nearest, farthest], view)
}

/// Depths of the surface from a nearest to a farthest distance along the view, m.
pub(crate) fn range_of([nearest, farthest]: [f64; 2], view: &DeckCamera) -> DepthRange {
    let depth = |distance: f64| {
        if distance > view.near {
            view.near / distance
        } else {
            1.0
        }
    };
    let low = depth(farthest) * (1.0 - RELATIVE) - ABSOLUTE;
    let high = depth(nearest) * (1.0 + RELATIVE) + ABSOLUTE;
    DepthRange {
        low: nearest_f32(low.clamp(0.0, 1.0)),
        high: nearest_f32(high.clamp(0.0, 1.0)),
    }
}

/// What counts these volumes.
pub(crate) fn program(
    way: DeviceWay,
    switches: &Switches,
    list: &[terrafill_stencil::Volume],
) -> Result<FillProgram, DeviceError> {
    let mut program = match way.counting {
        Counting::Parts { is_guarded: true } => together(switches, list, COUNTABLE)?,
        Counting::Parts { is_guarded: false } => together(switches, list, list.len())?,
        // As many as before over any pixel: rectangles of a caster lie beside each other.
        _ if way.bounds == Bounds::Tiles => together(switches, list, list.len())?,
        _ => FillProgram::new(list, switches, Overlap::Ordered)?,
    };
    if way.rule == Rule::Preload {
        for pass in &mut program.passes {
            let mut preloads = pass.commands.clone();
            preloads.retain_mut(|command| match command {
                FillCommand::Volumes { rule, .. } => {
                    rule.depth = DepthRule::Always;
                    true
                }
                _ => false,
            });
            pass.commands.splice(..0, preloads);
        }
    }
    Ok(program)
}

/// Passes that count so many volumes each.
fn together(
    switches: &Switches,
    list: &[terrafill_stencil::Volume],
    count: usize,
) -> Result<FillProgram, DeviceError> {
    let mut program = FillProgram::default();
    for first in (0..list.len()).step_by(count.max(1)) {
        // Of one volume, which stands for all that are counted with it: the contract's own guard would
        // refuse a case that is to show what wrapping does.
        let mut own = FillProgram::new(&list[first..=first], switches, Overlap::Ordered)?;
        let past = list.len().min(first + count);
        for command in own.passes.iter_mut().flat_map(|pass| &mut pass.commands) {
            match command {
                FillCommand::Volumes { volumes, .. } => *volumes = (first..past).collect(),
                FillCommand::Cover { volumes, .. } => *volumes = vec![first],
                FillCommand::Accumulate { .. } | FillCommand::Resolve => {}
            }
        }
        program.passes.extend(own.passes);
    }
    Ok(program)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_depth_range_holds_its_corners_and_infinity_ends_it() {
        let view = DeckCamera::level(DVec3::ZERO, 0.0, 0.5, [4, 3]);
        let place = |x: f64| DVec3::new(x, 3.0, 1.0).extend(1.0);
        let held = |range: DepthRange, x: f64| {
            let depth = 0.5 / x;
            f64::from(range.low) <= depth && depth <= f64::from(range.high)
        };
        let range = depth_range(&view, [place(10.0), place(20.0)].into_iter());
        assert!(held(range, 10.0) && held(range, 20.0));
        assert!(!held(range, 9.9) && !held(range, 20.1));
        let away = |x: f64| DVec3::new(x, 0.0, -0.1).extend(0.0);
        let range = depth_range(&view, [place(10.0), away(1.0)].into_iter());
        assert_eq!(range.low.to_bits(), 0.0_f32.to_bits());
        assert!(held(range, 1e9) && !held(range, 9.9));
        let range = depth_range(&view, [place(10.0), away(-1.0)].into_iter());
        assert_eq!(range.high.to_bits(), 1.0_f32.to_bits());
        assert!(held(range, 0.6) && !held(range, 10.1));
    }
}
