// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cases that a device answers.

use super::answers::{map_figures, percent, seen_figures, verdict_of};
use super::{Answering, MAX_DIFFERS};
use crate::ablation::StencilStep;
use crate::device_map::{DeviceMap, differing};
use crate::drawing::{DeviceDrawn, Kept};
use crate::job::Job;
use crate::maps::{Bias, Frame};
use crate::metrics::MISCOUNTED;
use crate::rivals::MARGIN_PX;
use crate::views::Eyes;
use crate::work::{End, Pixels, Scene};
use terrafill_casters::EdgeTable;
use terrafill_results::{Status, Verdict};
use terrafill_shadow_views::{Wrong, write};
use terrafill_study::{Failure, Figures, size_name};

pub(super) fn device_figures(drawn: &DeviceDrawn, pixels: Pixels, is_of_volumes: bool) -> Figures {
    let mut figures = vec![
        ("shadow_rim_px", drawn.wrong.at_rims as f64),
        ("shadow_bytes", drawn.bytes[0] as f64),
        ("shadow_sun_bytes", drawn.bytes[1] as f64),
    ];
    figures.extend(seen_figures(pixels, drawn.lost));
    figures.extend(drawn.build_ms.map(|ms| ("shadow_build_gpu_ms", ms)));
    if is_of_volumes {
        figures.extend([
            ("shadow_volume_triangles", drawn.volume_triangles as f64),
            ("shadow_draws", drawn.draws as f64),
            ("shadow_casters_left_out", drawn.left_out as f64),
        ]);
        let fragments = drawn.fragments.map(|all| all as f64 / pixels.all as f64);
        figures.extend(fragments.map(|share| ("shadow_fragments", share)));
    }
    figures
}

/// Takes into a verdict what is wrong in the picture that is timed.
fn held_as_timed(verdict: &mut Verdict, wrong: Wrong, size: [u32; 2]) {
    let outside = wrong.outside();
    verdict
        .figures
        .push(("shadow_timed_wrong_px", outside as f64));
    if outside > 0 && verdict.status == Status::Ok {
        verdict.status = Status::Wrong;
        verdict.reason = format!(
            "{outside} pixels are wrong outside the band at {}",
            size_name(size)
        );
    }
}

impl Answering<'_> {
    /// A map on the device, made if the last one is another.
    ///
    /// - `is_timed`: asked for what is timed, else for all channels
    pub(super) fn map(
        &mut self,
        sun: [f64; 2],
        texel_m: f64,
        is_timed: bool,
    ) -> Result<&DeviceMap, Failure> {
        let is_there = |map: &([f64; 2], f64, bool, DeviceMap)| {
            (map.0, map.1, map.2) == (sun, texel_m, is_timed)
        };
        if !self.map.as_ref().is_some_and(is_there) {
            // Two at a time may be more than there is room for.
            self.map = None;
            let devices = self.context.devices;
            let size = self.question.timed_size;
            let scene = self.under(sun)?;
            let scene = scene.timed_at(size).filter(|_| is_timed).unwrap_or(scene);
            let frame = Frame::of(scene.mesh(), scene.to_light, texel_m)?;
            let map = scene.device_map(devices, &frame)?;
            self.map = Some((sun, texel_m, is_timed, map));
        }
        let map = self.map.as_ref().map(|(.., map)| map);
        map.ok_or_else(|| "no map".to_owned().into())
    }

    /// The device's map beside the CPU's, at the step of the bias that is best there.
    pub(super) fn device_mapped(
        &mut self,
        sun: [f64; 2],
        texel_m: f64,
        bias: Bias,
    ) -> Result<Verdict, Failure> {
        self.map(sun, texel_m, false)?;
        let mapped = self.under(sun)?.mapped(texel_m, bias)?;
        let map = self.map(sun, texel_m, false)?;
        let masks = map.masks(bias, mapped.step, texel_m)?;
        let scene = self.under(sun)?;
        let wrong = scene.wrong(&masks);
        let differs = differing(scene, &masks, &mapped.masks);
        let differs = percent(differs as f64, mapped.judged);
        if differs > MAX_DIFFERS {
            let message = format!(
                "{differs:.2} % of the pixels say otherwise than the CPU's map, allowed: {MAX_DIFFERS} %"
            );
            return Ok(Verdict::failed(message));
        }
        let mut figures = map_figures(&mapped, wrong);
        figures.push(("shadow_map_differs", differs));
        Ok(verdict_of(wrong, figures))
    }

    /// What a device draws: volumes in a way, or a rival.
    pub(super) fn device(&mut self, case: usize, job: Job) -> Result<Verdict, Failure> {
        let (context, question, size) = (self.context, self.question.name, self.question.size);
        let timed_size = self.question.timed_size;
        let is_timed = self.cases[case].samples > 0;
        let (scene, way) = match job {
            Job::Device(sun, Eyes::Bridge, way) | Job::Origin(sun, Eyes::Bridge, way) => {
                (self.of_end(sun, way.end)?, Some(way))
            }
            Job::Device(sun, Eyes::At(place), way) => {
                (self.of_place(place, sun, way.end)?, Some(way))
            }
            Job::Origin(sun, Eyes::At(place), way) => {
                (self.of_place(place, sun, End::Sea)?, Some(way))
            }
            Job::StencilStep(sun, step) => (self.of_end(sun, step.way.end)?, Some(step.way)),
            Job::Facing(sun, is_edge_on, way) => {
                let make = || Scene::of_boxes(sun, is_edge_on, size);
                (
                    self.scene(&format!("{sun:?} {is_edge_on}"), make)?,
                    Some(way),
                )
            }
            Job::Near(sun, way) => {
                let make = || Scene::of_missed_eye(sun, size);
                (self.scene(&format!("{sun:?}"), make)?, Some(way))
            }
            Job::DeviceRow(count, way) => {
                let make = || Scene::of_row(count, size);
                (self.scene(&count.to_string(), make)?, Some(way))
            }
            Job::Rival(sun, Eyes::Bridge, _) => (self.under(sun)?, None),
            Job::Rival(sun, Eyes::At(place), _) => (self.of_place(place, sun, End::Sea)?, None),
            _ => return Err("no device draws it".to_owned().into()),
        };
        let draw = |scene: &Scene| match (way, job) {
            (Some(way), _) => scene.drawn_by(context.devices, way, Kept::Darkest),
            (None, Job::Rival(_, _, rival)) => scene.asked_by(context.devices, rival, MARGIN_PX),
            (None, _) => Err("no device draws it".to_owned().into()),
        };
        let mut drawn = draw(scene)?;
        let figures = device_figures(&drawn, scene.pixels(), way.is_some());
        let mut verdict = verdict_of(drawn.wrong, figures);
        if let Job::StencilStep(_, step) = job {
            let share = scene.writes_of(step.way)? as f64 / scene.pixels().all as f64;
            verdict.figures.push(("shadow_updates", share));
        }
        if way.is_some_and(|way| way.silhouettes.decides_by_corners()) {
            let views = scene.channels.iter();
            let undecided = views.map(|(view, _)| scene.undecided_facings(view)).max();
            let all = scene.mesh().triangles.len();
            let share = undecided.map(|count| percent(count as f64, all));
            let share = share.map(|share| ("shadow_undecided_facings", share));
            verdict.figures.extend(share);
        }
        let mut shown = scene;
        if let Some(timed) = scene.timed_at(timed_size).filter(|_| is_timed) {
            drawn.kept.clear();
            let large = draw(timed)?;
            held_as_timed(&mut verdict, large.wrong, timed_size);
            (shown, drawn.kept) = (timed, large.kept);
        }
        let (channel, mask) = drawn.kept.pop().ok_or_else(|| "no channel".to_owned())?;
        let (_, truth) = shown.darkest()?;
        let name = format!("{question}-{case}");
        let path = write(context.folder, &name, truth, Some(&mask))?;
        verdict.notes.push(("image", path));
        verdict.notes.push(("mask_hash", drawn.mask_hash));
        if !drawn.miscounted.is_empty() {
            verdict.notes.push((MISCOUNTED, drawn.miscounted));
        }
        self.opened.insert(case, channel);
        Ok(verdict)
    }

    /// Time of finding the volumes of a step, unless they are kept.
    pub(super) fn volumes_ms(
        &mut self,
        sun: [f64; 2],
        step: StencilStep,
    ) -> Result<Option<f64>, String> {
        if step.is_kept {
            return Ok(None);
        }
        let known = self.edges.take();
        let scene = self.of_end(sun, step.way.end)?;
        let name = format!("{sun:?} {:?}", step.way.end.feet_m());
        let table = match known {
            Some((own, table)) if own == name => table,
            _ => EdgeTable::of(scene.mesh()),
        };
        let cpu_ms = scene.time_volumes(step.way, &table);
        self.edges = Some((name, table));
        cpu_ms.map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_pixel_of_the_timed_picture_makes_a_case_wrong_and_one_in_the_band_does_not() {
        let held = |wrong: Wrong| {
            let mut verdict = verdict_of(Wrong::default(), Vec::new());
            held_as_timed(&mut verdict, wrong, [512, 512]);
            (verdict.status, verdict.reason)
        };
        let in_band = Wrong {
            in_band: 9,
            at_rims: 9,
            ..Wrong::default()
        };
        assert_eq!(held(in_band), (Status::Ok, String::new()));
        let lit = Wrong {
            false_lit: 1,
            ..Wrong::default()
        };
        let (status, reason) = held(lit);
        assert_eq!(status, Status::Wrong);
        assert!(
            reason.contains("1 pixels") && reason.contains("512"),
            "{reason}"
        );
    }
}
