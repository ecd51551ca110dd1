// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadows over terrain with objects by filters of depth maps, and the filters' errors against exact visibility.
//! Filters are one depth, 5 × 5 depths compared, and the variance of 5 × 5 depths as published.
//!
//! A picture's pixels are mean shares of light. They are judged by the filter's formula in `f64` over the maps that the
//! device has, for every texel and depth that rounding may choose. The error of the method is the difference
//! from rays from the place itself to each light. Lights are points at infinity, so exact visibility is 0 or 1.

use super::on_vulkan::{LayerParts, OnVulkan};
use super::reference::{DEPTH_BAND_M, LitRays, OFF_GROUND_M};
use super::scene::{LightConstants, RADIUS_M, bias_m, ground, lights};
use super::way::LightWay;
use crate::STUDY;
use crate::draws::{LooksUp as _, bits, count};
use crate::images::{of_shares, size_px, write};
use crate::layered::{TAPS, share_bounds};
use crate::metrics::{self, EXPERIMENT, GRID_CELLS, MAP_TEXELS, SHADOW_FILTER};
use crate::on_vulkan::{heights, uniform};
use crate::variance::Moments;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use terrafill_contract::{DeviceError, ids_of, numbers_hash};
use terrafill_results::Verdict;
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::{Grid, GridCamera, GridConstants, nearest};
use terrafill_shapes::rays::{BAND_PX, Rays, around, within};
use terrafill_study::{
    CaseGroup, Context, Failure, Figures, Group, JudgedOnce, Shows, judged, planned_case, verified,
};

const LIGHTS: u32 = 4;
const CELLS: u32 = 256;
const QUICK_CELLS: u32 = 64;
const SIDES: [u32; 3] = [256, 1_024, 2_048];
const QUICK_SIDES: [u32; 1] = [256];
/// Pixels that are judged, about: bounds take up to 81 filters a light, and exact visibility a ray.
const JUDGED: usize = 8_192;
/// Shares are written in so many steps.
const STEPS: f64 = 65_535.0;
/// Half a step, and sums of four shares in `f32`.
const ALLOWED_SHARE: f64 = 0.5 / STEPS + 1e-6;

terrafill_results::named! {
    /// How depths of a map become a share of light.
    all pub(crate) enum ShadowFilter {
        /// One depth is compared.
        Hard = "one-depth",
        /// The share of 5 × 5 depths that do not hide the place.
        Counted = "25-depths-compared",
        /// By mean and variance of 5 × 5 depths, as published.
        Variance = "25-depths-variance",
        /// The same of depths less the place's.
        FromReceiver = "25-depths-variance-about-the-place",
    }
}

impl ShadowFilter {
    /// As the shader has it.
    fn number(self) -> u32 {
        match self {
            Self::Hard => 0,
            Self::Counted => 1,
            Self::Variance => 2,
            Self::FromReceiver => 3,
        }
    }
}

/// Filters of maps of some sizes.
pub(crate) struct SoftShadows {
    cells: u32,
    cases: Vec<(ShadowFilter, u32)>,
    size: ImageSize,
}

pub(crate) fn soft_group(is_quick: bool, pictures: (ImageSize, u32)) -> impl Group {
    let (cells, sides): (u32, &[u32]) = if is_quick {
        (QUICK_CELLS, &QUICK_SIDES)
    } else {
        (CELLS, &SIDES)
    };
    group(cells, sides, pictures)
}

fn group(cells: u32, sides: &[u32], (size, samples): (ImageSize, u32)) -> CaseGroup<SoftShadows> {
    let of = |&side: &u32| ShadowFilter::ALL.map(|filter| (filter, side));
    let cases: Vec<_> = sides.iter().flat_map(of).collect();
    let case = |(filter, side): &(ShadowFilter, u32)| {
        let conditions = vec![
            (EXPERIMENT, "soft".to_owned()),
            (SHADOW_FILTER, filter.name().to_owned()),
            (metrics::LIGHTS, LIGHTS.to_string()),
            (MAP_TEXELS, side.to_string()),
            (GRID_CELLS, cells.to_string()),
        ];
        planned_case(STUDY, samples, conditions, Some(size_px(size)))
    };
    CaseGroup {
        name: format!("{STUDY}/soft"),
        cases: cases.iter().map(case).collect(),
        warm_up: None,
        work: SoftShadows { cells, cases, size },
        open: |group, context| {
            Ok(Box::new(JudgedOnce::new(SoftSession {
                group,
                context,
                grid: ground(group.work.cells),
                opened: BTreeMap::new(),
            })))
        },
    }
}

/// Maps by a pass each, which every device has.
fn open(
    context: Context<'_>,
    grid: &Grid,
    (filter, side): (ShadowFilter, u32),
    size: ImageSize,
) -> Result<OnVulkan, DeviceError> {
    let gpu = terrafill_vulkan::shared_gpu(context.devices)?;
    let way = LightWay::Passes;
    let lights = lights(LIGHTS);
    let constants = GridConstants::new(grid);
    let of_lights = LightConstants::new(grid, &lights, side);
    let number = [filter.number(), 0, 0, 0];
    let parts = LayerParts {
        way,
        layers: count(&lights),
        side,
        vertex: way.vertex(),
        geometry: way.geometry(LIGHTS),
        fragment: None,
        vertices: [6 * grid.cells * grid.cells; 2],
        resources: vec![
            uniform(&gpu, "grid constants", bytemuck::bytes_of(&constants))?,
            terrafill_vulkan::Resource::Image(heights(&gpu, grid)?),
            uniform(&gpu, "lights", bytemuck::bytes_of(&of_lights))?,
        ],
        behind: Some(uniform(&gpu, "filter", bytemuck::bytes_of(&number))?),
        picture: "pipelines/soft.wgsl",
        size,
    };
    OnVulkan::with(&gpu, parts)
}

/// Shares that a device may show, and errors of the method.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct JudgedShares {
    mismatched: usize,
    in_band: usize,
    looked_at: usize,
    /// Root mean square difference from exact visibility, and the mean of the signed one: above 0 is too light.
    rms: f64,
    mean: f64,
}

/// A filter's formula over the maps of a device.
struct SoftRays<'a> {
    lit: LitRays<'a>,
    filter: ShadowFilter,
    /// Of all lights, one map after the other.
    depths: &'a [f32],
}

impl SoftRays<'_> {
    fn depth(&self, light: usize, texel: DVec2) -> f32 {
        let side = self.lit.side as usize;
        let last = (side - 1) as f64;
        let at = texel.floor().clamp(DVec2::ZERO, DVec2::splat(last));
        #[allow(clippy::cast_possible_truncation, reason = "held within the map")]
        let [x, y] = [at.x as usize, at.y as usize];
        self.depths[(light * side + y) * side + x]
    }

    /// Between which shares of one light a filter may be at a place of its map.
    fn bounds(&self, number: usize, place: DVec3, texel: DVec2) -> [f64; 2] {
        let light = &self.lit.lights[number];
        let scale = 0.5 / RADIUS_M;
        let depth = self.lit.depth(light, place);
        let (bias, band) = (bias_m(self.lit.side) * scale, DEPTH_BAND_M * scale);
        let hidden = |tap: f32, off: f64| f64::from(tap) > depth + bias + off;
        let mut taps = [0.0_f32; TAPS];
        for (number_of_tap, tap) in (0_u8..).zip(&mut taps) {
            let off = DVec2::new(f64::from(number_of_tap % 5), f64::from(number_of_tap / 5)) - 2.0;
            *tap = self.depth(number, texel.floor() + off);
        }
        let shares = |off: f64| {
            let lit = taps.iter().filter(|tap| !hidden(**tap, off)).count();
            lit as f64 / TAPS as f64
        };
        let moments = match self.filter {
            ShadowFilter::Hard => {
                let middle = self.depth(number, texel);
                return [-band, band].map(|off| f64::from(u8::from(!hidden(middle, off))));
            }
            ShadowFilter::Counted => return [-band, band].map(shares),
            ShadowFilter::Variance => Moments::Published,
            ShadowFilter::FromReceiver => Moments::FromReceiver,
        };
        let each = [-band, 0.0, band].map(|off| {
            let receiver = nearest(depth + off);
            share_bounds(&taps, receiver, moments, None).unwrap_or([0.0, 1.0])
        });
        let clamp = |share: f64| share.clamp(0.0, 1.0);
        [
            clamp(each.iter().map(|of| of[0]).fold(f64::INFINITY, f64::min)),
            clamp(
                each.iter()
                    .map(|of| of[1])
                    .fold(f64::NEG_INFINITY, f64::max),
            ),
        ]
    }

    /// Between which mean shares a picture may be at a place; with every texel that is near enough.
    fn mean_bounds(&self, place: DVec3, band: f64) -> [f64; 2] {
        let mut ends = [0.0_f64; 2];
        for (number, light) in self.lit.lights.iter().enumerate() {
            let on_map = self.lit.on_map(light, place);
            let all = within(band).map(|off| self.bounds(number, place, on_map + off));
            let [low, high] = all.fold([1.0_f64, 0.0], |[low, high], [one, other]| {
                [low.min(one), high.max(other)]
            });
            ends[0] += low;
            ends[1] += high;
        }
        ends.map(|end| end / self.lit.lights.len() as f64)
    }

    /// Whether a share lies between those of places within the band of the pixel's middle: shares change steadily between
    /// them, or by steps.
    fn may_show(&self, at: DVec2, shown: f64) -> bool {
        let places: Vec<Option<DVec3>> = around(BAND_PX)
            .map(|off| self.lit.rays.place(at + off))
            .collect();
        if shown < 0.0 {
            return places.contains(&None);
        }
        let bounds = places
            .into_iter()
            .flatten()
            .map(|place| self.mean_bounds(place, BAND_PX));
        let all = bounds.fold([1.0_f64, 0.0], |[low, high], [one, other]| {
            [low.min(one), high.max(other)]
        });
        is_within(all, shown)
    }

    fn judge(&self, shares: &[f32], every: usize) -> JudgedShares {
        let mut judged = JudgedShares::default();
        let rays = &self.lit.rays;
        for (pixel, at) in rays.centres().enumerate().step_by(every) {
            let shown = f64::from(shares[pixel]);
            let Some(place) = rays.place(at) else {
                let may = shown < 0.0 || around(BAND_PX).any(|off| rays.place(at + off).is_some());
                judged.mismatched += usize::from(!may);
                continue;
            };
            if !is_within(self.mean_bounds(place, 0.0), shown) {
                let may = self.may_show(at, shown);
                judged.mismatched += usize::from(!may);
                judged.in_band += usize::from(may);
            }
            if shown < 0.0 {
                continue;
            }
            let reached = self.lit.lights.iter().filter(|light| {
                let from = place + light.toward * OFF_GROUND_M;
                !rays.hits(from, light.toward)
            });
            let error = shown - reached.count() as f64 / self.lit.lights.len() as f64;
            judged.looked_at += 1;
            judged.rms += error * error;
            judged.mean += error;
        }
        let count = judged.looked_at.max(1) as f64;
        judged.rms = (judged.rms / count).sqrt();
        judged.mean /= count;
        judged
    }
}

fn is_within([low, high]: [f64; 2], shown: f64) -> bool {
    shown >= low - ALLOWED_SHARE && shown <= high + ALLOWED_SHARE
}

/// Every so many pixels of a picture are judged: an odd number, so that no column is left out.
fn judged_every(size: ImageSize) -> usize {
    (size.width as usize * size.height as usize / JUDGED).max(1) | 1
}

/// Shares of a picture; below 0 for the sky.
fn shares_of(numbers: &[u32]) -> Vec<f32> {
    let share = |number: &u32| nearest((f64::from(*number) - 1.0) / STEPS);
    numbers.iter().map(share).collect()
}

struct SoftSession<'a> {
    group: &'a CaseGroup<SoftShadows>,
    context: Context<'a>,
    grid: Grid,
    /// By case.
    opened: BTreeMap<usize, OnVulkan>,
}

impl Shows for SoftSession<'_> {
    /// Numbers of the picture, and depths of the maps.
    type Shown = (Vec<u32>, Vec<f32>);

    fn show(&mut self, case: usize) -> Result<(String, Self::Shown), Failure> {
        let SoftShadows {
            ref cases, size, ..
        } = self.group.work;
        let mut opened = open(self.context, &self.grid, cases[case], size)?;
        let shown = opened.draw()?;
        self.opened.insert(case, opened);
        let numbers = ids_of(&shown.picture);
        let depths = numbers_hash(&bits(&shown.depths));
        let hash = format!("{}-{depths}", numbers_hash(&numbers));
        Ok((hash, (numbers, shown.depths)))
    }

    fn judge(&mut self, case: usize, (numbers, depths): Self::Shown) -> Result<Verdict, Failure> {
        let SoftShadows {
            ref cases, size, ..
        } = self.group.work;
        let (filter, side) = cases[case];
        let shares = shares_of(&numbers);
        let lights = lights(LIGHTS);
        let rays = SoftRays {
            lit: LitRays {
                rays: Rays::new(&self.grid, GridCamera::new(), size),
                lights: &lights,
                side,
            },
            filter,
            depths: &depths,
        };
        let found = rays.judge(&shares, judged_every(size));
        let reason = if found.mismatched > 0 {
            let pixels = found.mismatched;
            format!("{pixels} pixels show a share that the formula does not allow")
        } else if found.looked_at == 0 {
            "it shows nothing".to_owned()
        } else {
            String::new()
        };
        let figures = vec![
            ("pipeline_mismatched_px", found.mismatched as f64),
            ("pipeline_band_px", found.in_band as f64),
            ("soft_rms", found.rms),
            ("soft_mean", found.mean),
            ("pipeline_held_bytes", self.opened[&case].bytes() as f64),
        ];
        let name = &self.group.cases[case].id.name;
        let notes = write(self.context.folder, name, size, of_shares(&shares))?;
        Ok(judged(reason, figures, notes))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        Ok(verified(&mut self.opened, case)?.time()?.figures())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::images::PICTURE;
    use crate::lights::scene::DistantLight;
    use crate::tested::{Tested, figure};
    use terrafill_results::Status;

    #[test]
    fn filters_show_what_their_formulas_allow_and_other_filters_are_noticed() {
        let Some(tested) = Tested::open() else {
            return;
        };
        let group = group(QUICK_CELLS, &QUICK_SIDES, (PICTURE, 1));
        let verdicts = tested.verdicts(&group);
        for (at, verdict) in &verdicts {
            let name = &group.cases[*at].id.name;
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
            assert!(figure(verdict, "soft_rms") < 0.5, "{name}");
        }
        assert_eq!(verdicts.len(), 4);
        // Negative controls: each filter's picture is none of another filter, nor that of lights elsewhere.
        let context = Context {
            devices: &tested.devices,
            folder: std::path::Path::new(""),
        };
        let grid = ground(QUICK_CELLS);
        let lights = lights(LIGHTS);
        let mut moved = lights.clone();
        moved.swap(0, 1);
        for filter in ShadowFilter::ALL {
            let mut opened = open(context, &grid, (filter, 256), PICTURE).expect("opens");
            let shown = opened.draw().expect("draws");
            let shares = shares_of(&ids_of(&shown.picture));
            let judge = |filter: ShadowFilter, lights: &[DistantLight]| {
                let rays = SoftRays {
                    lit: LitRays {
                        rays: Rays::new(&grid, GridCamera::new(), PICTURE),
                        lights,
                        side: 256,
                    },
                    filter,
                    depths: &shown.depths,
                };
                rays.judge(&shares, 97).mismatched
            };
            assert_eq!(judge(filter, &lights), 0, "{filter:?}");
            let other = match filter {
                ShadowFilter::Hard => ShadowFilter::Counted,
                ShadowFilter::Counted => ShadowFilter::FromReceiver,
                ShadowFilter::Variance | ShadowFilter::FromReceiver => ShadowFilter::Hard,
            };
            assert!(judge(other, &lights) > 0, "{filter:?}");
            assert!(judge(filter, &moved) > 0, "{filter:?}");
        }
    }
}
