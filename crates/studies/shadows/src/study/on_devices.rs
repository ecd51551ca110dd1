// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cases that a device answers: shown in every process, judged in the first.

use super::answers::{map_figures, percent, seen_figures, verdict_of};
use super::driver_fault::LostPixels;
use super::{Answering, MAX_DIFFERS};
use crate::counted::Counted;
use crate::device_map::{DeviceMap, differing};
use crate::drawing::{DeviceDrawn, JudgedDrawn, mask_hash_of};
use crate::job::Job;
use crate::maps::{Bias, Frame};
use crate::metrics::MISCOUNTED;
use crate::rivals::MARGIN_PX;
use crate::views::Eyes;
use crate::way::{DeviceWay, Silhouettes};
use crate::work::{Pixels, Scene};
use glam::DVec3;
use terrafill_casters::EdgeTable;
use terrafill_contract::CpuStopwatch;
use terrafill_results::Verdict;
use terrafill_shadow_views::{Boxes, Draws, Reference, write};
use terrafill_study::{Failure, Figures, verified};

pub(super) fn device_figures(drawn: &DeviceDrawn, judged: &JudgedDrawn, pixels: Pixels) -> Figures {
    let mut figures = vec![
        ("shadow_rim_px", judged.wrong.at_rims as f64),
        ("shadow_bytes", drawn.bytes[0] as f64),
        ("shadow_sun_bytes", drawn.bytes[1] as f64),
    ];
    figures.extend(seen_figures(pixels, judged.lost));
    figures.extend(drawn.build_ms.map(|ms| ("shadow_build_gpu_ms", ms)));
    if let Some(volume) = &drawn.volume {
        figures.extend([
            ("shadow_volume_triangles", volume.triangles.len() as f64),
            ("shadow_draws", drawn.draw_calls as f64),
            ("shadow_casters_left_out", drawn.left_out as f64),
        ]);
        let fragments = judged.fragments.map(|all| all as f64 / pixels.all as f64);
        figures.extend(fragments.map(|share| ("shadow_fragments", share)));
    }
    figures
}

/// How volumes are drawn, where it is volumes.
pub(super) fn way_of(job: Job) -> Option<DeviceWay> {
    match job {
        Job::Device(.., way)
        | Job::Origin(.., way)
        | Job::Facing(.., way)
        | Job::Near(_, way)
        | Job::DeviceRow(_, way) => Some(way),
        Job::StencilStep(_, step) => Some(step.way),
        _ => None,
    }
}

/// Of what edges are: the casters of a sun, cut or not.
fn edges_name(job: Job, way: DeviceWay) -> String {
    let (sun, eyes) = match job {
        Job::Device(sun, eyes, _) => (sun, eyes),
        Job::StencilStep(sun, _) => (sun, Eyes::Bridge),
        _ => ([f64::NAN; 2], Eyes::Bridge),
    };
    format!("{sun:?} {} {:?}", eyes.name(), way.end.feet_m())
}

impl Answering<'_> {
    /// What a case of a device is drawn in.
    fn drawn_in(&mut self, job: Job) -> Result<&Scene, Failure> {
        let (size, frame_size) = (self.question.size, self.question.frame_size);
        let end = way_of(job).map_or(crate::work::End::Sea, |way| way.end);
        Ok(match job {
            Job::Device(sun, eyes, _) | Job::Rival(sun, eyes, _) => {
                self.seen_from(eyes, sun, end.feet_m(), frame_size)?
            }
            Job::StencilStep(sun, _) => {
                self.seen_from(Eyes::Bridge, sun, end.feet_m(), frame_size)?
            }
            Job::Origin(sun, eyes, _) => self.seen_from(eyes, sun, end.feet_m(), size)?,
            Job::Facing(sun, is_edge_on, _) => {
                let make = || Scene::of_boxes(sun, is_edge_on, size);
                self.scene(&format!("{sun:?} {is_edge_on}"), make)?
            }
            Job::Near(sun, _) => {
                let make = || Scene::of_missed_eye(sun, size);
                self.scene(&format!("{sun:?}"), make)?
            }
            Job::DeviceRow(count, _) => {
                let make = || Scene::of_row(count, size);
                self.scene(&count.to_string(), make)?
            }
            _ => return Err("no device draws it".to_owned().into()),
        })
    }

    /// Draws volumes in a way, or a rival's shadows.
    pub(super) fn show_device(&mut self, case: usize, job: Job) -> Result<DeviceDrawn, Failure> {
        let devices = self.context.devices;
        let scene = self.drawn_in(job)?;
        let mut drawn = match (way_of(job), job) {
            (Some(way), _) => scene.drawn_by(devices, way)?,
            (None, Job::Rival(_, _, rival)) => scene.asked_by(devices, rival, MARGIN_PX)?,
            (None, _) => return Err("no device draws it".to_owned().into()),
        };
        self.opened.insert(case, std::mem::take(&mut drawn.draws));
        Ok(drawn)
    }

    /// Keeps what drew a case that is timed; others need their memory no more.
    pub(super) fn keep(&mut self, case: usize, draws: Vec<Box<dyn Draws>>) {
        if self.cases[case].samples > 0 {
            self.opened.insert(case, draws);
        }
    }

    /// What the reference says of it.
    pub(super) fn judge_device(
        &mut self,
        case: usize,
        job: Job,
        drawn: &DeviceDrawn,
    ) -> Result<Verdict, Failure> {
        let (context, question) = (self.context, self.question.name);
        let fault = LostPixels::on(context.devices, job, self.question.frame_size)?;
        let mut draws = self.opened.remove(&case).unwrap_or_default();
        let counted = way_of(job).map_or(Counted::All, DeviceWay::counted);
        let scene = self.drawn_in(job)?;
        let judged = scene.compared(drawn, &mut draws, counted)?;
        let figures = device_figures(drawn, &judged, scene.pixels());
        let mut verdict = verdict_of(judged.wrong, figures);
        verdict.reason.push_str(&judged.place(&scene.views));
        if let Some(fault) = fault {
            let (mended, differing) = fault.mended(|channel| &scene.truths()[channel].light, drawn);
            let mended = scene.compared(&mended, &mut draws, counted)?;
            let excused = verdict_of(mended.wrong, Vec::new()).reason;
            (verdict.status, verdict.reason) = fault.settle(&verdict.reason, &excused, differing);
        }
        if let Job::StencilStep(_, step) = job {
            let share = scene.writes_of(step.way)? as f64 / scene.pixels().all as f64;
            verdict.figures.push(("shadow_updates", share));
        }
        if way_of(job).is_some_and(|way| way.silhouettes.decides_by_corners()) {
            let views = scene.views.iter();
            let undecided = views.map(|view| scene.undecided_facings(view)).max();
            let all = scene.mesh().triangles.len();
            let share = undecided.map(|count| percent(count as f64, all));
            let share = share.map(|share| ("shadow_undecided_facings", share));
            verdict.figures.extend(share);
        }
        let shown = match judged.first_wrong {
            Some((channel, _)) => channel,
            None => scene.darkest_channel()?,
        };
        let name = format!("{question}-{case}");
        let (truth, mask) = (&scene.truths()[shown], &drawn.masks[shown]);
        let path = write(context.folder, &name, truth, Some(mask))?;
        verdict.notes.push(("image", path));
        verdict.notes.push(("mask_hash", judged.mask_hash));
        if !judged.miscounted.is_empty() {
            verdict.notes.push((MISCOUNTED, judged.miscounted));
        }
        self.keep(case, draws);
        Ok(verdict)
    }

    /// A map on the device over a frame, made if the last one is another.
    pub(super) fn map(&mut self, sun: [f64; 2], texel_m: f64) -> Result<&DeviceMap, Failure> {
        let is_there = |map: &([f64; 2], f64, DeviceMap)| (map.0, map.1) == (sun, texel_m);
        if !self.map.as_ref().is_some_and(is_there) {
            // Two at a time may be more than there is room for.
            self.map = None;
            let devices = self.context.devices;
            let scene = self.frame(sun)?;
            let frame = Frame::of(scene.mesh(), scene.to_light, texel_m)?;
            let map = scene.device_map(devices, &frame)?;
            self.map = Some((sun, texel_m, map));
        }
        let map = self.map.as_ref().map(|(.., map)| map);
        map.ok_or_else(|| "no map".to_owned().into())
    }

    /// Whether a map shows what it showed: by a step of the bias that is always there.
    pub(super) fn show_map(
        &mut self,
        sun: [f64; 2],
        texel_m: f64,
        bias: Bias,
    ) -> Result<String, Failure> {
        let step = bias.steps().last().copied().unwrap_or_default();
        let masks = self.map(sun, texel_m)?.masks(bias, step, texel_m)?;
        Ok(mask_hash_of(&masks.concat()))
    }

    /// The device's map beside the CPU's, at the step of the bias that is best there.
    pub(super) fn judge_map(
        &mut self,
        sun: [f64; 2],
        texel_m: f64,
        bias: Bias,
    ) -> Result<Verdict, Failure> {
        self.map(sun, texel_m)?;
        let mapped = self.frame(sun)?.mapped(texel_m, bias)?;
        let masks = self.map(sun, texel_m)?.masks(bias, mapped.step, texel_m)?;
        let scene = self.frame(sun)?;
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

    /// What the CPU does for each frame before a device draws it: process CPU time and wall clock, ms. `None` where all
    /// of it is there already.
    ///
    /// A rule is chosen for every channel. Volumes are found once, and handed over once for all channels of an eye.
    pub(super) fn planned(&mut self, case: usize, job: Job) -> Result<Option<[f64; 2]>, Failure> {
        let Job::Device(.., way) = job else {
            return Ok(None);
        };
        if let Some(test) = way.counting.test() {
            let scene = self.drawn_in(job)?;
            let reference = Reference::new(scene.mesh(), scene.to_light);
            let boxes = Boxes::of(scene.mesh());
            let watch = CpuStopwatch::start();
            let chosen = scene.views.iter();
            let chosen = chosen.map(|view| scene.fails(test, view, &boxes, &reference));
            let count = chosen.map(|fails| fails.len()).sum::<usize>();
            let times = [watch.cpu_ms(), watch.wall_ms()];
            // What nobody looks at might never be chosen.
            return Ok((count > 0).then_some(times));
        }
        if way.silhouettes != Silhouettes::EachFrame {
            return Ok(None);
        }
        let known = self.edges.take();
        let scene = self.drawn_in(job)?;
        let name = edges_name(job, way);
        let table = match known {
            Some((own, table)) if own == name => table,
            _ => EdgeTable::of(scene.mesh()),
        };
        let watch = CpuStopwatch::start();
        let volume = scene.volume_of(&table.sides(&scene.prepared, &scene.facing), way.end)?;
        let mut eyes: Vec<DVec3> = Vec::new();
        let mut handed = Vec::new();
        for (channel, view) in scene.views.iter().enumerate() {
            if !eyes.contains(&view.eye) {
                eyes.push(view.eye);
                handed.push((channel, scene.eye_volumes(way, view, &volume)));
            }
        }
        let before = [watch.cpu_ms(), watch.wall_ms()];
        self.edges = Some((name, table));
        let channels = verified(&mut self.opened, case)?;
        let watch = CpuStopwatch::start();
        for (channel, volumes) in &handed {
            channels[*channel].hand_over(volumes)?;
        }
        let after = [watch.cpu_ms(), watch.wall_ms()];
        Ok(Some([0, 1].map(|at| before[at] + after[at])))
    }

    /// Time of finding the volumes of a step, unless they are kept.
    pub(super) fn volumes_ms(&mut self, job: Job) -> Result<Option<f64>, Failure> {
        let Job::StencilStep(_, step) = job else {
            return Ok(None);
        };
        if step.is_kept {
            return Ok(None);
        }
        let known = self.edges.take();
        let scene = self.drawn_in(job)?;
        let name = edges_name(job, step.way);
        let table = match known {
            Some((own, table)) if own == name => table,
            _ => EdgeTable::of(scene.mesh()),
        };
        let cpu_ms = scene.time_volumes(step.way, &table)?;
        self.edges = Some((name, table));
        Ok(Some(cpu_ms))
    }
}
