// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cases under lights at a place.

use super::answers::{seen_figures, verdict_of};
use super::{Answering, Question};
use crate::drawing::plausible;
use crate::job::Job;
use crate::lamps::{LampDrawn, LampEye, LampName, LampScene, Limit, picture};
use crate::metrics::{MISCOUNTED, SHADOW_REACHED_PX};
use crate::work::Pixels;
use terrafill_results::Verdict;
use terrafill_shadow_views::{Interface, Light, Rule, write};
use terrafill_study::{Failure, Figures, file_stem, write_photo, write_rgb};

impl LampScene {
    fn figures(&self, mask: &[bool], volume_triangles: usize) -> Figures {
        let truth = self.truth();
        let count = |light| truth.count(light);
        let (all, shadow) = (truth.light.len(), count(Light::Shadow));
        let receivers = all - count(Light::Sky);
        let pixels = Pixels {
            all,
            receivers,
            shadow,
            ..Pixels::default()
        };
        let mut figures = vec![
            (
                SHADOW_REACHED_PX.name,
                (receivers - count(Light::OutOfReach)) as f64,
            ),
            ("shadow_edge_on_px", count(Light::EdgeOn) as f64),
            ("shadow_undecided_px", count(Light::Undecided) as f64),
            ("shadow_volume_triangles", volume_triangles as f64),
        ];
        figures.extend(seen_figures(pixels, truth.lost(mask)));
        figures
    }
}

impl Answering<'_> {
    /// The port under a lamp, made if the last one is another.
    fn lamp(
        &mut self,
        name: LampName,
        eye: LampEye,
        size: [u32; 2],
    ) -> Result<&LampScene, Failure> {
        let key = format!("{} {} {size:?}", name.name(), eye.name());
        if self.lamp.as_ref().is_none_or(|(own, _)| *own != key) {
            self.lamp = Some((key, LampScene::new(name, eye, size)?));
        }
        let lamp = self.lamp.as_ref().map(|(_, scene)| scene);
        lamp.ok_or_else(|| "no lamp".to_owned().into())
    }

    /// Counted along rays, in the channel of the bridge that sees it.
    pub(super) fn lamp_counted(
        &mut self,
        name: LampName,
        rule: Rule,
        limit: Limit,
    ) -> Result<Verdict, Failure> {
        let size = self.question.size;
        let scene = self.lamp(name, LampEye::Bridge, size)?;
        let drawn = scene.drawn(rule, limit);
        let mask = drawn.masks.first().ok_or_else(|| "no mask".to_owned())?;
        let mut figures = scene.figures(mask, drawn.volume_triangles);
        let pixels = scene.truth().light.len() as f64;
        figures.push(("shadow_updates", drawn.updates as f64 / pixels));
        Ok(verdict_of(drawn.wrong, figures))
    }

    fn lamp_size(&self, job: Job) -> [u32; 2] {
        let Question {
            size, frame_size, ..
        } = self.question;
        job.size(*size, *frame_size).unwrap_or(*frame_size)
    }

    /// By a device.
    pub(super) fn show_lamp(&mut self, case: usize, job: Job) -> Result<LampDrawn, Failure> {
        let Job::DeviceLamp(name, eye, interface, rule, limit) = job else {
            return Err("no device draws it".to_owned().into());
        };
        let (devices, size) = (self.context.devices, self.lamp_size(job));
        let scene = self.lamp(name, eye, size)?;
        let mut drawn = scene.drawn_by(devices, interface, rule, limit)?;
        let draws = std::mem::take(&mut drawn.draws);
        self.opened.insert(case, draws.into_iter().collect());
        Ok(drawn)
    }

    /// What the reference says of it, and painted for people.
    pub(super) fn judge_lamp(
        &mut self,
        case: usize,
        job: Job,
        drawn: &LampDrawn,
    ) -> Result<Verdict, Failure> {
        let Job::DeviceLamp(name, eye, interface, rule, limit) = job else {
            return Err("no device draws it".to_owned().into());
        };
        let dark = drawn.mask.iter().filter(|is_dark| **is_dark).count();
        let mut draws = self.opened.remove(&case).unwrap_or_default();
        let counted = draws.first_mut().map(|draws| draws.fragments());
        let counted = counted.transpose()?.flatten();
        self.keep(case, draws);
        let fragments = plausible(counted, dark);
        let (context, loses_nothing) = (self.context, self.question.loses_nothing);
        let size = self.lamp_size(job);
        let scene = self.lamp(name, eye, size)?;
        let wrong = scene.wrong(drawn);
        let mut figures = scene.figures(&drawn.mask, drawn.volume.triangles.len());
        figures.extend([
            ("shadow_rim_px", wrong.at_rims as f64),
            ("shadow_draws", drawn.counters.draws as f64),
        ]);
        let share = |count: u64| count as f64 / drawn.mask.len() as f64;
        if let Ok(Some(count)) = fragments {
            figures.push(("shadow_fragments", share(count)));
        }
        let mut verdict = verdict_of(wrong, figures);
        let words = [
            name.name(),
            eye.name(),
            interface.name(),
            rule.name(),
            limit.name(),
        ];
        let stem = file_stem(&words.join("-"));
        let path = write(context.folder, &stem, scene.truth(), Some(&drawn.mask))?;
        verdict.notes.push(("image", path));
        // The same by every way.
        if Job::is_painted(interface, rule, limit) {
            let write = if loses_nothing {
                write_rgb
            } else {
                write_photo
            };
            let painted = picture(scene, &drawn.mask).concat();
            let name = format!("shadows-{stem}-by-night");
            verdict
                .notes
                .push(("map", write(context.folder, &name, size, &painted)?));
        }
        if let Err(miscounted) = fragments {
            verdict.notes.push((MISCOUNTED, miscounted));
        }
        Ok(verdict)
    }
}

impl Job {
    /// Of which of a light's pictures by devices there is one for people.
    pub(super) fn is_painted(interface: Interface, rule: Rule, limit: Limit) -> bool {
        (interface, rule, limit) == (Interface::Wgpu, Rule::Fail, Limit::Off)
    }
}
