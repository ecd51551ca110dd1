// SPDX-License-Identifier: MIT OR Apache-2.0
//! Frames of the harbour: every channel drawn by a device, held against rays, and painted for people.

use super::Answering;
use super::answers::verdict_of;
use super::on_devices::device_figures;
use crate::ablation::optimised;
use crate::counted::Counted;
use crate::drawing::{DeviceDrawn, times_of};
use crate::job::{HarbourFrame, Job, PORT, sun_name};
use crate::lamps::{Limit, MOON, MOON_NAME, by_moon};
use crate::metrics::{FRAME_CPU, FRAME_GPU, FRAME_WALL};
use crate::shading::{Painter, strip};
use crate::way::DeviceWay;
use crate::work::{Scene, closed};
use terrafill_casters::PortSize;
use terrafill_contract::CpuStopwatch;
use terrafill_results::Verdict;
use terrafill_shadow_views::{DeckCamera, Interface, Truth, bridge, picture};
use terrafill_study::{Failure, Figures, file_stem, size_name, verified, write_photo, write_rgb};

/// What paints a channel for people, by its mask.
type Paint = fn(&Painter<'_>, &DeckCamera, &Truth, &[bool]) -> Vec<[u8; 3]>;

/// How a frame is drawn, what it is called, and what paints it for people, where this interface does.
struct Framed {
    seen: HarbourFrame,
    way: DeviceWay,
    name: String,
    shown: Option<(&'static str, Paint)>,
}

impl Framed {
    fn of(job: Job) -> Result<Self, String> {
        match job {
            Job::Harbour(frame) => {
                let by_day: Paint = |painter, view, truth, mask| painter.picture(view, truth, mask);
                // The same by every interface, and smaller than any other.
                let is_painted = frame.interface == Interface::Wgpu && frame.size.is_none();
                let mut name = format!("harbour-{}-{}", frame.eyes.name(), sun_name(frame.sun));
                if frame.port != PORT {
                    name += &format!("-{}", frame.port);
                }
                if let Some(size) = frame.size {
                    name += &format!("-{}", size_name(size));
                }
                Ok(Self {
                    way: optimised(frame.interface).ok_or("no optimisation")?,
                    shown: is_painted.then_some(("by-day", by_day)),
                    seen: frame,
                    name,
                })
            }
            // Volumes closed at the sea by one rule.
            Job::DeviceMoon(eyes, interface, rule) => {
                let is_painted = Job::is_painted(interface, rule, Limit::Off);
                Ok(Self {
                    way: DeviceWay {
                        rule,
                        ..DeviceWay::plain(interface)
                    },
                    name: format!("{MOON_NAME}-{}-{}", eyes.name(), rule.name()),
                    shown: is_painted.then_some(("by-night", by_moon as Paint)),
                    seen: HarbourFrame::plain(MOON, eyes, interface),
                })
            }
            _ => Err("no frame".to_owned()),
        }
    }
}

impl Answering<'_> {
    fn framed(&mut self, of: &Framed) -> Result<&Scene, String> {
        let size = of.seen.size.unwrap_or(self.question.frame_size);
        let feet_m = of.way.end.feet_m();
        match of.seen.port {
            PORT => self.seen_from(of.seen.eyes, of.seen.sun, feet_m, size),
            port => self.scene(&format!("{port} {:?} {size:?}", of.seen.sun), || {
                let mesh = terrafill_casters::port(PortSize::named(port).ok_or("no such port")?);
                Scene::standing(&closed(mesh)?, of.seen.sun, bridge(size), feet_m)
            }),
        }
    }

    /// All channels as a device draws them.
    pub(super) fn show_frame(&mut self, case: usize, job: Job) -> Result<DeviceDrawn, Failure> {
        let (devices, of) = (self.context.devices, Framed::of(job)?);
        let mut drawn = self.framed(&of)?.drawn_by(devices, of.way)?;
        self.opened.insert(case, std::mem::take(&mut drawn.draws));
        Ok(drawn)
    }

    /// What the reference says of it, and a strip of all channels for people.
    pub(super) fn judge_frame(
        &mut self,
        case: usize,
        job: Job,
        drawn: &DeviceDrawn,
    ) -> Result<Verdict, Failure> {
        let (context, loses_nothing) = (self.context, self.question.loses_nothing);
        let of = Framed::of(job)?;
        let size = of.seen.size.unwrap_or(self.question.frame_size);
        let mut draws = self.opened.remove(&case).unwrap_or_default();
        let scene = self.framed(&of)?;
        let judged = scene.compared(drawn, &mut draws, Counted::All)?;
        let figures = device_figures(drawn, &judged, scene.pixels());
        let mut verdict = verdict_of(judged.wrong, figures);
        verdict.reason.push_str(&judged.place(&scene.views));
        // Azimuths grow to the left.
        let channels = || scene.channels().zip(&drawn.masks).rev();
        let pictures = channels().map(|((_, truth), mask)| picture(truth, Some(mask)));
        let pictures = strip(&pictures.collect::<Vec<_>>(), size);
        let count = u32::try_from(scene.views.len()).unwrap_or(u32::MAX);
        let all = [size[0] * count, size[1]];
        let interface = of.way.interface.name();
        let name = file_stem(&format!("shadows-{}-{interface}", of.name));
        let path = write_rgb(context.folder, &name, all, &pictures)?;
        verdict.notes.push(("image", path));
        if let Some((called, paint)) = of.shown {
            let painter = Painter::new(scene);
            let painted =
                channels().map(|((view, truth), mask)| paint(&painter, view, truth, mask));
            let painted = strip(&painted.collect::<Vec<_>>(), size);
            let write = if loses_nothing {
                write_rgb
            } else {
                write_photo
            };
            let path = write(context.folder, &format!("{name}-{called}"), all, &painted)?;
            verdict.notes.push(("map", path));
        }
        verdict.notes.push(("mask_hash", judged.mask_hash));
        self.keep(case, draws);
        Ok(verdict)
    }

    /// All channels once, one after the other.
    pub(super) fn frame_times(&mut self, case: usize) -> Result<Figures, Failure> {
        let channels = verified(&mut self.opened, case)?;
        let watch = CpuStopwatch::start();
        let times = times_of(channels)?;
        let (cpu_ms, wall_ms) = (watch.cpu_ms(), watch.wall_ms());
        let gpu_ms = times.surface_gpu_ms.zip(times.fill_gpu_ms);
        let mut values = vec![(FRAME_WALL.name, wall_ms), (FRAME_CPU.name, cpu_ms)];
        values.extend(gpu_ms.map(|(surface, fill)| (FRAME_GPU.name, surface + fill)));
        Ok(values)
    }
}
