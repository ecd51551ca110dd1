// SPDX-License-Identifier: MIT OR Apache-2.0
//! Both radii of the spiral by counted pixels, in frames that devices draw and count (Gebbie and Bailey, “Other Uses for
//! `occlusion_query` for LOD”). The fan's radius changes by constant or by logarithmic steps, the outer one by trying.
//! Beside them stand both in closed form. What a frame draws is a range of one static buffer.

mod device;
mod rule;
mod section;
mod view;

pub(crate) use section::SECTION;

use crate::STUDY;
use crate::counts::device::PixelCount;
use crate::metrics::{self, API, CONTROLLER, COUNTED_BY, DELAY, PATH, RULE, SIZE_PX, STEP};
use device::FanDevice;
use glam::DVec3;
use rayon::prelude::*;
use rule::{Controller, Counted, Drawn, PER_TURN, Rule, WANTED_PX, radii, stable_gain};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use terrafill_contract::CpuStopwatch;
use terrafill_globe_views::fingerprint;
use terrafill_results::{CaseId, PlannedCase, Verdict};
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, JudgedOnce, Shows, judged, verified,
};
use view::{SIDE_PX, Seen, View, stored};

/// Name of this part in cases.
pub(crate) const PART: &str = "controllers";

/// Frames of an eye at rest, in which a loop comes to rest or does not; and of one that rises, to four times its height.
const REST_FRAMES: usize = 72;
const RISING_FRAMES: usize = 120;
/// Counts of a frame are used so many frames later: in the next one, as in the paper, or when mapping has given them.
const DELAYS: [usize; 3] = [1, 2, 3];
/// With a delay of 1 each step jumps past the target by 1.4 of what it was off: some frames pass before the picture's edge.
const WILD: f64 = 1.2;
/// Frames, of the first, over which that is followed.
const GROWTH_FRAMES: usize = 8;
/// Rules with their steps: a gain is a share of the one below which the loop settles. A quarter of it is about the largest
/// without overshoot at the longer delays. Trying by 1 % is slower than a height that doubles each second, by 4 % faster.
const STEPS: [(Rule, f64); 5] = [
    (Rule::Steps, 0.02),
    (Rule::Logarithmic, 0.25),
    (Rule::Logarithmic, WILD),
    (Rule::Trying, 0.01),
    (Rule::Trying, 0.04),
];
/// Pixels of the picture, all of which show the body.
const ALL_PX: u64 = (SIDE_PX * SIDE_PX) as u64;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Work {
    way: PixelCount,
    rises: bool,
    rule: Rule,
    step: f64,
    delay: usize,
}

impl Work {
    fn path(self) -> &'static str {
        if self.rises { "rising" } else { "rest" }
    }

    fn frames(self) -> usize {
        if self.rises {
            RISING_FRAMES
        } else {
            REST_FRAMES
        }
    }

    fn planned(self, samples: u32) -> PlannedCase {
        let [api, way] = self.way.names();
        let [path, rule] = [self.path(), self.rule.name()];
        let name = format!("{PART}/{path}/{way}/{rule}");
        let mut conditions = vec![
            (metrics::PART, PART.to_owned()),
            (PATH, path.to_owned()),
            (API, api.to_owned()),
            (COUNTED_BY, way.to_owned()),
            (CONTROLLER, self.rule.of().to_owned()),
            (RULE, rule.to_owned()),
            (SIZE_PX, SIDE_PX.to_string()),
        ];
        let name = if self.rule == Rule::Closed {
            name
        } else {
            let (step, delay) = (self.step, self.delay);
            conditions.extend([(STEP, step.to_string()), (DELAY, delay.to_string())]);
            format!("{name}/step={step}/delay={delay}")
        };
        PlannedCase {
            id: CaseId::new(STUDY, name, conditions),
            samples,
            may_be_wrong: false,
        }
    }

    /// The vertex that it decides on: of closed form, the fan's.
    fn held(self, drawn: Drawn) -> u32 {
        if self.rule == Rule::Trying {
            drawn.last
        } else {
            drawn.first
        }
    }

    fn controller(self, first: &View) -> Controller {
        let step = match self.rule {
            Rule::Logarithmic => self.step * stable_gain(self.delay),
            _ => self.step,
        };
        Controller::new(self.rule, step, &first.limits)
    }

    /// What each frame draws: counts of frame k decide on frame k + delay.
    ///
    /// - `count`: pixels of a frame by its number and what it draws
    fn course(
        self,
        views: &Views,
        mut count: impl FnMut(usize, Drawn) -> Result<Counted, Failure>,
    ) -> Result<(Vec<Drawn>, Controller), Failure> {
        let mut controller = self.controller(views.of(self, 0));
        let mut counts = Vec::new();
        let mut course = Vec::new();
        for frame in 0..self.frames() {
            if let Some(old) = frame.checked_sub(self.delay) {
                controller.next(counts[old], ALL_PX);
            }
            let drawn = controller.drawn(&views.of(self, frame).limits);
            counts.push(count(frame, drawn)?);
            course.push(drawn);
        }
        Ok((course, controller))
    }
}

/// Of an eye that rises, frame by frame; the first is that of one at rest.
struct Views(Vec<View>);

impl Views {
    fn new() -> Self {
        let frames = (0..RISING_FRAMES).into_par_iter();
        Self(frames.map(View::new).collect())
    }

    fn of(&self, work: Work, frame: usize) -> &View {
        &self.0[if work.rises { frame } else { 0 }]
    }
}

/// All work on controllers, as one group of cases.
pub(crate) struct Controllers {
    work: Vec<Work>,
}

impl Controllers {
    pub(crate) fn planned(depth: Depth, samples: u32) -> CaseGroup<Self> {
        let (ways, delays) = if depth == Depth::Quick {
            (&[PixelCount::Queries][..], &DELAYS[..1])
        } else {
            (&PixelCount::ALL[..], &DELAYS[..])
        };
        let mut work = Vec::new();
        for &way in ways {
            for rises in [false, true] {
                let one = |rule, step, delay| Work {
                    way,
                    rises,
                    rule,
                    step,
                    delay,
                };
                work.push(one(Rule::Closed, 0.0, 1));
                // A loop that explodes does so at rest.
                let steps = STEPS.iter().filter(|(_, step)| !rises || *step < 1.0);
                for &(rule, step) in steps {
                    work.extend(delays.iter().map(|delay| one(rule, step, *delay)));
                }
            }
        }
        CaseGroup {
            name: format!("{STUDY}/{PART}"),
            cases: work.iter().map(|work| work.planned(samples)).collect(),
            warm_up: None,
            work: Self { work },
            open: |group, context| {
                let part = ControllerPart::new(&group.work, context);
                Ok(Box::new(JudgedOnce::new(part)))
            },
        }
    }
}

struct ControllerPart<'a> {
    group: &'a Controllers,
    context: Context<'a>,
    views: Views,
    stored: Vec<DVec3>,
    /// By interface.
    devices: BTreeMap<&'static str, FanDevice>,
    /// The last frame of each case, and the state that led to it.
    last: BTreeMap<usize, (Controller, Counted)>,
}

/// What a case drew, what of it was counted, and bytes sent, frame by frame; and its state at the end.
#[derive(Debug, Clone)]
struct Course {
    drawn: Vec<Drawn>,
    counts: Vec<Counted>,
    bytes: Vec<usize>,
    end: Controller,
}

impl<'a> ControllerPart<'a> {
    fn new(group: &'a Controllers, context: Context<'a>) -> Self {
        Self {
            group,
            context,
            views: Views::new(),
            stored: stored(),
            devices: BTreeMap::new(),
            last: BTreeMap::new(),
        }
    }

    /// Opened when it is first wanted.
    fn open(&mut self, way: PixelCount) -> Result<(&Views, &mut FanDevice), Failure> {
        let [name, _] = way.names();
        if !self.devices.contains_key(name) {
            let device = FanDevice::new(way, self.context.devices)?;
            self.devices.insert(name, device);
        }
        let device = self.devices.get_mut(name);
        let device = device.ok_or_else(|| Failure::broken("it was not opened"))?;
        Ok((&self.views, device))
    }

    /// - `fed`: counts of another case, where its own are not used
    fn run(&mut self, work: Work, fed: Option<&[Counted]>) -> Result<Course, Failure> {
        let (views, device) = self.open(work.way)?;
        device.forget();
        let (mut counts, mut bytes) = (Vec::new(), Vec::new());
        let (drawn, end) = work.course(views, |frame, drawn| {
            bytes.push(device.send(views.of(work, frame))?);
            let counted = device.count(drawn)?;
            counts.push(counted);
            Ok(fed.map_or(counted, |fed| fed[frame]))
        })?;
        Ok(Course {
            drawn,
            counts,
            bytes,
            end,
        })
    }

    /// Whether counts are what rays see and ranges what the rule makes of them; if not, why.
    fn judged(&self, work: Work, course: &Course) -> Result<(Figures, String), Failure> {
        let (views, stored) = (&self.views.0, &self.stored);
        // Frames of an eye at rest that draw the same show the same.
        let seen_in = |frames: Range<usize>| -> Vec<(bool, Seen)> {
            let of = |frame: usize| {
                (
                    frame * usize::from(work.rises),
                    course.drawn[frame],
                    course.counts[frame],
                )
            };
            let frames: BTreeSet<(usize, Drawn, Counted)> = frames.map(of).collect();
            let seen = |(frame, drawn, counted): (usize, Drawn, Counted)| {
                let seen = views[frame].seen(stored, drawn);
                (seen.allows(counted), seen)
            };
            frames.into_par_iter().map(seen).collect()
        };
        let frames = course.drawn.len();
        let [early, late] = [0..frames / 2, frames / 2..frames].map(seen_in);
        let all = || early.iter().chain(&late);
        let wrong = all().filter(|(is_right, _)| !is_right).count();
        let band = all().map(|(_, seen)| seen.band_px()).max().unwrap_or(0);
        let (own, _) = work.course(&self.views, |frame, _| Ok(course.counts[frame]))?;
        let other = own.iter().zip(&course.drawn).position(|(a, b)| a != b);
        let mut figures = vec![
            ("globe_controller_wrong_frames", wrong as f64),
            ("globe_controller_frames", all().count() as f64),
            ("globe_controller_band_px", band as f64),
        ];
        if work.rule.of() != "fan" {
            let bare = late.iter().map(|(_, seen)| seen.diagonal_px);
            figures.push(("globe_bare_diagonal_px", bare.fold(0.0, f64::max)));
        }
        let reason = match (wrong, other) {
            (0, None) => String::new(),
            (0, Some(frame)) => {
                format!("frame {frame} draws other vertices than the rule makes of its own counts")
            }
            (wrong, _) => format!(
                "in {wrong} frames the fan or all that is drawn has pixels that rays do not see, allowed 0"
            ),
        };
        Ok((figures, reason))
    }

    /// Radius that a frame draws over that in closed form.
    fn over_closed(&self, work: Work, course: &Course, frame: usize) -> f64 {
        let closed = self.views.of(work, frame).limits.drawn();
        radii(work.held(course.drawn[frame]), work.held(closed))
    }

    fn figures(&self, work: Work, course: &Course) -> Figures {
        let late = course.drawn.len() / 2..course.drawn.len();
        let largest = |of: &dyn Fn(usize) -> f64| late.clone().map(of).fold(0.0, f64::max);
        let percent = |over: f64| 100.0 * (over - 1.0).abs();
        let fan = |frame: usize| (course.counts[frame].fan as f64).max(1.0) / WANTED_PX as f64;
        let off = |frame| percent(self.over_closed(work, course, frame));
        let mut figures = vec![
            ("globe_controller_off", largest(&off)),
            (
                "globe_upload_bytes",
                largest(&|frame| course.bytes[frame] as f64),
            ),
        ];
        if work.rule != Rule::Trying {
            figures.push(("globe_fan_off", largest(&|frame| percent(fan(frame)))));
        }
        if work.rule.of() == "fan" {
            let growth = |frame| fan(frame).ln().abs() / fan(0).ln().abs();
            figures.push(("globe_fan_growth", largest(&growth)));
        } else {
            let bare = |frame: usize| (ALL_PX - course.counts[frame].all) as f64;
            figures.push(("globe_bare_px", largest(&bare)));
            let is_bare = late.clone().filter(|frame| bare(*frame) > 0.0);
            let share = is_bare.count() as f64 / late.len() as f64;
            figures.push(("globe_bare_share", share));
            if work.rises && work.rule == Rule::Trying {
                let third = course.drawn.len() / 3;
                // The first third begins with corners covered.
                let [middle, last] = [third..2 * third, 2 * third..3 * third]
                    .map(|frames| frames.map(bare).sum::<f64>());
                figures.push(("globe_bare_growth", last / middle.max(1.0)));
            }
        }
        if work.rises {
            return figures;
        }
        if work.rule.of() == "fan" {
            figures.extend(growth_by_frame(&course.drawn, &course.counts));
        }
        let held: Vec<u32> = course.drawn.iter().map(|drawn| work.held(*drawn)).collect();
        let [low, high] =
            [u32::min, u32::max].map(|of| held[late.clone()].iter().copied().reduce(of));
        let swing = low.zip(high).map(|(low, high)| percent(radii(high, low)));
        figures.extend(swing.map(|swing| ("globe_controller_swing", swing)));
        let period = period(&held[late.clone()]);
        figures.extend(period.map(|frames| ("globe_controller_period", frames as f64)));
        if period == Some(1) {
            let last = held.windows(2).rposition(|pair| pair[0] != pair[1]);
            let rest = last.map_or(0, |frame| frame + 1);
            figures.push(("globe_controller_rest_frames", rest as f64));
        }
        figures
    }
}

/// By how much the fan's error grows from a frame to the next, the least of the first frames; and the frame that ends
/// them. There its pixels are cut off, by the picture or because no smaller fan is stored.
fn growth_by_frame(drawn: &[Drawn], counts: &[Counted]) -> Figures {
    // A fan of less than half of the picture lies within it.
    let is_cut = |(drawn, counted): (&Drawn, &Counted)| {
        2 * counted.fan >= ALL_PX || drawn.first <= PER_TURN || counted.fan == 0
    };
    let cut = drawn.iter().zip(counts).position(is_cut);
    let free = cut.unwrap_or(counts.len()).min(GROWTH_FRAMES);
    let off = |counted: &Counted| (counted.fan as f64 / WANTED_PX as f64).ln().abs();
    let off: Vec<f64> = counts[..free].iter().map(off).collect();
    let growth = off
        .windows(2)
        .map(|pair| pair[1] / pair[0].max(f64::EPSILON));
    let mut figures = Figures::new();
    // Of one step alone nothing is said.
    if off.len() > 2 {
        let least = growth.fold(f64::INFINITY, f64::min);
        figures.push(("globe_fan_growth_least", least));
    }
    figures.extend(cut.map(|frame| ("globe_fan_cut_frame", frame as f64)));
    figures
}

/// Frames after which a series repeats; `None` where it does not within half of it.
fn period(series: &[u32]) -> Option<usize> {
    (1..series.len() / 2).find(|period| series.iter().zip(&series[*period..]).all(|(a, b)| a == b))
}

impl Shows for ControllerPart<'_> {
    type Shown = Course;

    fn show(&mut self, case: usize) -> Result<(String, Course), Failure> {
        let work = self.group.work[case];
        let course = self.run(work, None)?;
        let last = course.counts.last().copied().unwrap_or_default();
        self.last.insert(case, (course.end.clone(), last));
        let frames = course.drawn.iter().zip(&course.counts);
        let words = frames.flat_map(|(drawn, counted)| {
            [
                drawn.first.into(),
                drawn.last.into(),
                counted.fan,
                counted.all,
            ]
        });
        let words: Vec<u64> = words.collect();
        Ok((fingerprint(&[bytemuck::cast_slice(&words)]), course))
    }

    fn judge(&mut self, case: usize, course: Course) -> Result<Verdict, Failure> {
        let work = self.group.work[case];
        let (mut figures, reason) = self.judged(work, &course)?;
        figures.extend(self.figures(work, &course));
        let frames = 0..course.drawn.len();
        let frames = frames.map(|frame| format!("{:.4}", self.over_closed(work, &course, frame)));
        let frames: Vec<String> = frames.collect();
        let note = ("radius-by-frame", frames.join(" "));
        Ok(judged(reason, figures, vec![note]))
    }

    /// A frame with its decision and its counts read at once, and the same without either.
    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let work = self.group.work[case];
        let (mut controller, counted) = verified(&mut self.last, case)?.clone();
        let (views, device) = self.open(work.way)?;
        let view = views.of(work, work.frames() - 1);
        device.send(view)?;
        // One at rest has what it needs.
        if work.rises {
            device.forget();
        }
        let watch = CpuStopwatch::start();
        controller.next(counted, ALL_PX);
        let drawn = controller.drawn(&view.limits);
        device.send(view)?;
        device.count(drawn)?;
        let controlled_ms = watch.cpu_ms();
        if work.rises {
            device.forget();
        }
        let watch = CpuStopwatch::start();
        device.send(view)?;
        device.draw(drawn)?;
        Ok(vec![
            ("globe_controlled_cpu_ms", controlled_ms),
            ("globe_uncounted_cpu_ms", watch.cpu_ms()),
        ])
    }
}

#[cfg(test)]
mod tests;
