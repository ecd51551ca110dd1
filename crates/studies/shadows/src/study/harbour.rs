// SPDX-License-Identifier: MIT OR Apache-2.0
//! Frames of the harbour: every channel drawn by a device, held against rays, and painted for people.

use super::Answering;
use super::answers::verdict_of;
use super::on_devices::device_figures;
use crate::ablation::optimised;
use crate::drawing::Kept;
use crate::job::{Job, sun_name};
use crate::lamps::{Limit, MOON, MOON_NAME, by_moon};
use crate::metrics::{FRAME_CPU, FRAME_GPU, FRAME_WALL};
use crate::shading::{Painter, strip};
use crate::views::Eyes;
use crate::way::DeviceWay;
use crate::work::{Scene, closed, port_m};
use terrafill_contract::CpuStopwatch;
use terrafill_results::Verdict;
use terrafill_shadow_views::{DeckCamera, Draws, Interface, Rule, Truth, bridge, picture};
use terrafill_study::{Failure, Figures, file_stem, verified, write_photo, write_rgb};

/// What paints a channel for people, by its mask.
type Paint = fn(&Painter<'_>, &DeckCamera, &Truth, &[bool]) -> Vec<[u8; 3]>;

impl Answering<'_> {
    /// Channels of a frame, from the left.
    fn frame(&mut self, sun: [f64; 2], eyes: Eyes, feet_m: Option<f64>) -> Result<&Scene, String> {
        let size = self.question.frame_size;
        let name = format!("{} {sun:?} {feet_m:?} {size:?}", eyes.name());
        self.scene(&name, || {
            let views = match eyes {
                // Azimuths grow to the left.
                Eyes::Bridge => bridge(size).into_iter().rev().collect(),
                Eyes::At(place) => vec![place.view(size)],
            };
            Scene::standing(&closed(port_m()?)?, sun, views, feet_m)
        })
    }

    /// All channels as a device draws them, and a strip of them for people.
    pub(super) fn harbour(
        &mut self,
        case: usize,
        sun: [f64; 2],
        eyes: Eyes,
        interface: Interface,
    ) -> Result<Verdict, Failure> {
        let way = optimised(interface).ok_or_else(|| "no optimisation".to_owned())?;
        let name = format!("harbour-{}-{}", eyes.name(), sun_name(sun));
        // The same by every interface.
        let is_painted = interface == Interface::Wgpu;
        let by_day: Paint = |painter, view, truth, mask| painter.picture(view, truth, mask);
        let shown = is_painted.then_some(("by-day", by_day));
        let (verdict, draws) = self.framed(sun, eyes, way, &name, shown)?;
        self.frames.insert(case, draws);
        Ok(verdict)
    }

    /// The same under the moon, volumes closed at the sea by one rule.
    pub(super) fn moonlit(
        &mut self,
        eyes: Eyes,
        interface: Interface,
        rule: Rule,
    ) -> Result<Verdict, Failure> {
        let way = DeviceWay {
            rule,
            ..DeviceWay::plain(interface)
        };
        let name = format!("{MOON_NAME}-{}-{}", eyes.name(), rule.name());
        let is_painted = Job::is_painted(interface, rule, Limit::Off);
        let shown = is_painted.then_some(("by-night", by_moon as Paint));
        Ok(self.framed(MOON, eyes, way, &name, shown)?.0)
    }

    /// - `shown`: what a picture for people is called, and what paints it
    fn framed(
        &mut self,
        sun: [f64; 2],
        eyes: Eyes,
        way: DeviceWay,
        name: &str,
        shown: Option<(&str, Paint)>,
    ) -> Result<(Verdict, Vec<Box<dyn Draws>>), Failure> {
        let (context, loses_nothing) = (self.context, self.question.loses_nothing);
        let size = self.question.frame_size;
        let scene = self.frame(sun, eyes, way.end.feet_m())?;
        let drawn = scene.drawn_by(context.devices, way, Kept::All)?;
        let figures = device_figures(&drawn, scene.pixels(), true);
        let mut verdict = verdict_of(drawn.wrong, figures);
        let channels = || scene.channels.iter().zip(&drawn.kept);
        let judged = channels().map(|((_, truth), (_, mask))| picture(truth, Some(mask)));
        let judged = strip(&judged.collect::<Vec<_>>(), size);
        let count = u32::try_from(scene.channels.len()).unwrap_or(u32::MAX);
        let all = [size[0] * count, size[1]];
        let name = file_stem(&format!("shadows-{name}-{}", way.interface.name()));
        let path = write_rgb(context.folder, &name, all, &judged)?;
        verdict.notes.push(("image", path));
        if let Some((called, paint)) = shown {
            let painter = Painter::new(scene);
            let painted =
                channels().map(|((view, truth), (_, mask))| paint(&painter, view, truth, mask));
            let painted = strip(&painted.collect::<Vec<_>>(), size);
            let write = if loses_nothing {
                write_rgb
            } else {
                write_photo
            };
            let path = write(context.folder, &format!("{name}-{called}"), all, &painted)?;
            verdict.notes.push(("map", path));
        }
        verdict.notes.push(("mask_hash", drawn.mask_hash));
        let channels = drawn.kept.into_iter().map(|(draws, _)| draws);
        Ok((verdict, channels.collect()))
    }

    /// All channels once, one after the other.
    pub(super) fn frame_times(&mut self, case: usize) -> Result<Figures, Failure> {
        let channels = verified(&mut self.frames, case)?;
        let watch = CpuStopwatch::start();
        let times: Result<Vec<_>, _> = channels.iter_mut().map(|draws| draws.time()).collect();
        let (cpu_ms, wall_ms) = (watch.cpu_ms(), watch.wall_ms());
        let times = times?;
        let of_device = times
            .iter()
            .map(|times| Some(times.surface_gpu_ms? + times.fill_gpu_ms?));
        let gpu_ms: Option<f64> = of_device.sum();
        let mut values = vec![(FRAME_WALL.name, wall_ms), (FRAME_CPU.name, cpu_ms)];
        values.extend(gpu_ms.map(|ms| (FRAME_GPU.name, ms)));
        Ok(values)
    }
}
