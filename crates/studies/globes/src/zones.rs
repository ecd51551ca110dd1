// SPDX-License-Identifier: MIT OR Apache-2.0
//! Zones of a height field whose levels follow their counted pixels (Gebbie and Bailey, “Using `occlusion_query` for
//! Heightfield Terrains”), drawn and counted on devices. A row of spikes hides the zones behind it at the finest level
//! alone, so that they have fewer pixels the finer they are.

mod field;
mod hill;
pub(crate) mod rule;
mod section;

pub(crate) use hill::{HillPictures, SECTION as HILL_SECTION};
pub(crate) use section::SECTION;

use crate::STUDY;
use crate::counts::course::{CountedFrame, Course};
use crate::counts::device::{Counters, PixelCount, SIDE_PX};
use crate::metrics::{self, API, COUNTED_BY, HYSTERESIS, SIZE_PX, SPIKE_M};
use field::{COARSE_TRIANGLES, FINEST, Field, Levels, ZONES, node, number};
use rule::ZoneRule;
use std::collections::BTreeMap;
use terrafill_globe_views::{Eye, ViewRow};
use terrafill_results::{CaseId, PlannedCase, Verdict};
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, JudgedOnce, Shows, judged, verified,
};

/// Name of this part in cases.
pub(crate) const PART: &str = "zones";

const EYE_M: f64 = 800.0;
const PITCH_DEG: f64 = -12.0;
/// Frames in which zones come to rest or do not.
const FRAMES: usize = 32;
/// Frames from drawing to using a count: the paper's.
const DELAY: usize = 1;
/// Heights of the spikes, metres.
const SPIKES_M: [f64; 3] = [0.0, 300.0, 1200.0];
const HYSTERESES: [f64; 5] = [1.0, 4.0, 8.0, 16.0, 64.0];
/// Pixels a triangle.
const WANTED: [f64; 3] = [3.0, 2.0, 4.5];
/// Pixels of a zone from which it is asked what spikes hide of it.
const MIN_PX: u64 = 20;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Work {
    way: PixelCount,
    spike_m: f64,
    hysteresis: f64,
    wanted: f64,
}

impl Work {
    fn field(self) -> Field {
        Field {
            spike_m: self.spike_m,
            hill: None,
        }
    }
}

/// All work on zones, as one group of cases.
pub(crate) struct Zones {
    work: Vec<Work>,
}

impl Zones {
    pub(crate) fn planned(depth: Depth, samples: u32) -> CaseGroup<Self> {
        let ways = &PixelCount::ALL[..if depth == Depth::Quick { 1 } else { 2 }];
        // Other wishes are more of the same: only a full run has them.
        let all = &WANTED[..if depth == Depth::Full {
            WANTED.len()
        } else {
            1
        }];
        let mut work = Vec::new();
        for &way in ways {
            for spike_m in SPIKES_M {
                for &wanted in all {
                    work.extend(HYSTERESES.map(|hysteresis| Work {
                        way,
                        spike_m,
                        hysteresis,
                        wanted,
                    }));
                }
            }
        }
        let cases = work.iter().map(|work| {
            let [api, way] = work.way.names();
            let conditions = [
                (metrics::PART, PART.to_owned()),
                (API, api.to_owned()),
                (COUNTED_BY, way.to_owned()),
                (SPIKE_M, work.spike_m.to_string()),
                (metrics::WANTED, work.wanted.to_string()),
                (HYSTERESIS, work.hysteresis.to_string()),
                (metrics::DELAY, DELAY.to_string()),
                (SIZE_PX, SIDE_PX.to_string()),
            ];
            let name = format!(
                "{PART}/{way}/spike={}/wanted={}/hysteresis={}",
                work.spike_m, work.wanted, work.hysteresis
            );
            PlannedCase {
                id: CaseId::new(STUDY, name, conditions),
                samples,
                may_be_wrong: false,
            }
        });
        CaseGroup {
            name: format!("{STUDY}/{PART}"),
            cases: cases.collect(),
            warm_up: None,
            work: Self { work },
            open: |group, context| {
                let part = ZonePart::new(&group.work, context);
                Ok(Box::new(JudgedOnce::new(part)))
            },
        }
    }
}

fn eye() -> Eye {
    let [longitude_deg, latitude_deg] = Field::eye_deg();
    let row = ViewRow {
        longitude_deg,
        latitude_deg,
        height_m: EYE_M,
        pitch_deg: PITCH_DEG,
        ..ViewRow::default()
    };
    row.eye(SIDE_PX)
}

struct ZonePart<'a> {
    group: &'a Zones,
    counters: Counters<'a>,
    /// By way and height of the spikes: what they hide.
    hides: BTreeMap<(&'static str, u64), f64>,
    /// The last frame of each case.
    last: BTreeMap<usize, CountedFrame>,
}

impl<'a> ZonePart<'a> {
    fn new(group: &'a Zones, context: Context<'a>) -> Self {
        Self {
            group,
            counters: Counters::new(context.devices),
            hides: BTreeMap::new(),
            last: BTreeMap::new(),
        }
    }

    /// Of what a zone shows a level below the finest over what it shows at the finest, the largest.
    fn hidden(&mut self, work: Work) -> Result<f64, Failure> {
        let key = (work.way.names()[0], work.spike_m.to_bits());
        if let Some(known) = self.hides.get(&key) {
            return Ok(*known);
        }
        let (eye, field) = (eye(), work.field());
        let mut worst = 1.0_f64;
        let mut counts = |levels: &Levels| {
            let drawn = field.drawn(&eye, levels);
            self.counters.by_node(work.way, &eye, &drawn)
        };
        let fine = counts(&[FINEST; ZONES * ZONES])?;
        for zone in 0..ZONES * ZONES {
            let mut levels = [FINEST; ZONES * ZONES];
            levels[zone] = FINEST - 1;
            let coarse = counts(&levels)?;
            let [fine, coarse] = [&fine, &coarse].map(|counts| counts[&node(zone)]);
            if coarse >= MIN_PX {
                worst = worst.max(coarse as f64 / fine.max(1) as f64);
            }
        }
        self.hides.insert(key, worst);
        Ok(worst)
    }

    fn run(&mut self, case: usize) -> Result<Course, Failure> {
        let work = self.group.work[case];
        let (eye, field) = (eye(), work.field());
        let rule = ZoneRule::new(
            COARSE_TRIANGLES.into(),
            FINEST,
            work.wanted,
            work.hysteresis,
        );
        let mut levels: Levels = [0; ZONES * ZONES];
        let counters = &mut self.counters;
        let course = run(counters, work.way, &eye, field, &rule, &mut levels)?;
        let last = course.ends.last().cloned();
        self.last.extend(last.map(|last| (case, last)));
        Ok(course)
    }
}

/// Zones that follow their counted pixels while the eye stands still.
///
/// - `levels`: those of the first frame, then those after the last
fn run(
    counters: &mut Counters<'_>,
    way: PixelCount,
    eye: &Eye,
    field: Field,
    rule: &ZoneRule,
    levels: &mut Levels,
) -> Result<Course, Failure> {
    // Of each zone, the frame in which its level was first drawn.
    let mut since = [0; ZONES * ZONES];
    let mut counted = Vec::new();
    let mut course = Course::default();
    for frame in 0..FRAMES {
        let drawn = field.drawn(eye, levels);
        counted.push(counters.by_node(way, eye, &drawn)?);
        let triangles = levels.iter().map(|level| rule.triangles(*level));
        course.sizes.push(triangles.sum());
        if frame == 0 || frame + 1 == FRAMES {
            course.ends.push(CountedFrame {
                eye: *eye,
                drawn,
                counts: counted[frame].clone(),
            });
        }
        let Some(old) = (frame + 1).checked_sub(DELAY) else {
            continue;
        };
        for (node, pixels) in &counted[old] {
            let zone = number(*node);
            // A zone acts on counts of its own level alone.
            if since[zone] > old {
                continue;
            }
            let next = rule.next(levels[zone], *pixels as f64);
            if next != levels[zone] {
                levels[zone] = next;
                since[zone] = frame + 1;
                course.last_change = Some(frame);
            }
        }
    }
    Ok(course)
}

impl Shows for ZonePart<'_> {
    type Shown = Course;

    fn show(&mut self, case: usize) -> Result<(String, Course), Failure> {
        let course = self.run(case)?;
        Ok((course.hash(), course))
    }

    fn judge(&mut self, case: usize, course: Course) -> Result<Verdict, Failure> {
        let hides = self.hidden(self.group.work[case])?;
        let (mut figures, reason) = course.exactness();
        figures.push(("globe_zone_hides", hides));
        figures.extend(course.rest(DELAY));
        let last = course.sizes.last();
        figures.extend(last.map(|count| ("globe_triangles", *count)));
        let note = ("triangles-by-frame", course.note());
        Ok(judged(reason, figures, vec![note]))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let CountedFrame { eye, drawn, .. } = verified(&mut self.last, case)?;
        let way = self.group.work[case].way;
        Ok(self.counters.time(way, eye, drawn)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_fixtures::on_device::on_device;

    #[test]
    fn spikes_let_zones_cycle_and_a_wide_hysteresis_stops_them() {
        on_device(terrafill_gpu::shared_gpu, |context| {
            let zones = Zones::planned(Depth::Quick, 1);
            let mut part = ZonePart::new(&zones.work, context);
            let mut of = |spike_m: f64, hysteresis: f64| {
                let mut work = zones.work.work.iter();
                let is_it = |work: &Work| work.spike_m == spike_m && work.hysteresis == hysteresis;
                let case = work.position(is_it).expect("planned");
                let hides = part.hidden(zones.work.work[case]).unwrap_or(f64::NAN);
                let course = part.run(case).expect("counted");
                let against_rays = course.against_rays();
                eprintln!(
                    "spikes of {spike_m} m, hysteresis {hysteresis}: hide all but 1/{hides:.2}, rest after {:?}, {:?}",
                    course.settled(DELAY),
                    against_rays
                );
                assert_eq!(against_rays.1, 0);
                (hides, course.settled(DELAY))
            };
            let (plain, rest) = of(0.0, 4.0);
            assert!(
                plain < 1.5 && rest.is_some_and(|frames| frames > 1),
                "{plain}"
            );
            let (hides, rest) = of(1200.0, 64.0);
            assert!(
                4.0 * hides < 64.0 && hides > 3.0 && rest.is_some(),
                "{hides}"
            );
            // Negative control: with less than four times what the spikes hide they never rest.
            assert_eq!(of(1200.0, 8.0).1, None);
        });
    }
}
