// SPDX-License-Identifier: MIT OR Apache-2.0
//! Zones of a height field whose levels follow their counted pixels (Gebbie and Bailey, “Using occlusion_query for
//! Heightfield Terrains”), drawn and counted on devices. A row of spikes hides the zones behind it at the finest level
//! alone, so that they have fewer pixels the finer they are.

mod field;
mod section;

pub(crate) use section::blocks;

use crate::STUDY;
use crate::counts::device::{Counters, Way};
use crate::counts::scene::{ByRays, Drawn};
use crate::keys;
use crate::keys::{API, COUNTED_BY, HYSTERESIS, SIZE_PX, SPIKE_M};
use crate::list::{Eye, ViewRow};
use field::{COARSE_TRIANGLES, FINEST, Field, Levels, ZONES, node, number};
use std::collections::BTreeMap;
use terrafill_control::{Node, ZoneRule};
use terrafill_fill::CpuStopwatch;
use terrafill_results::{CaseId, PlannedCase, Verdict};
use terrafill_scene::ImageSize;
use terrafill_study::{
    CaseSession, Context, Failure, Figures, Group, Measures, Session, StudyError, judged,
};

/// Name of this part in cases.
pub(crate) const PART: &str = "zones";

const SIDE_PX: u32 = 400;
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
    way: Way,
    spike_m: f64,
    hysteresis: f64,
    wanted: f64,
}

/// All of it.
pub(crate) struct Zones {
    work: Vec<Work>,
    cases: Vec<PlannedCase>,
}

impl Zones {
    pub(crate) fn new(is_quick: bool, samples: u32) -> Self {
        let ways = &Way::ALL[..if is_quick { 1 } else { 2 }];
        let all = &WANTED[..if is_quick { 1 } else { WANTED.len() }];
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
                (keys::PART, PART.to_owned()),
                (API, api.to_owned()),
                (COUNTED_BY, way.to_owned()),
                (SPIKE_M, work.spike_m.to_string()),
                (keys::WANTED, work.wanted.to_string()),
                (HYSTERESIS, work.hysteresis.to_string()),
                (keys::DELAY, DELAY.to_string()),
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
        Self {
            cases: cases.collect(),
            work,
        }
    }
}

fn eye() -> Eye {
    let [longitude_deg, latitude_deg] = Field::eye_deg();
    let row = ViewRow {
        name: String::new(),
        longitude_deg,
        latitude_deg,
        height_m: EYE_M,
        pitch_deg: PITCH_DEG,
        quick: false,
        all_cells: false,
    };
    row.eye(SIDE_PX)
}

impl Group for Zones {
    fn name(&self) -> String {
        format!("{STUDY}/{PART}")
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.cases
    }

    fn open<'a>(&'a self, context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        Ok(Box::new(CaseSession(ZonePart::new(self, context))))
    }
}

/// What a loop did.
#[derive(Debug, Clone, PartialEq, Default)]
struct Course {
    /// Triangles of all zones, frame by frame.
    triangles: Vec<f64>,
    /// Frames in which a zone changed its level.
    changes: Vec<usize>,
    /// Largest difference from rays, nodes off by more than their edges, and nodes compared.
    against_rays: (u64, usize, usize),
}

impl Course {
    /// Frames after which nothing changes; `None` where changes go on to the end.
    fn settled(&self) -> Option<usize> {
        let last = self.changes.last().map_or(0, |frame| frame + 1);
        (last + 2 * DELAY + 2 <= self.triangles.len()).then_some(last)
    }
}

struct ZonePart<'a> {
    group: &'a Zones,
    counters: Counters<'a>,
    /// By way and height of the spikes: what they hide.
    hides: BTreeMap<(&'static str, u64), f64>,
    /// The last frame of each case.
    last: BTreeMap<usize, Drawn>,
}

impl<'a> ZonePart<'a> {
    fn new(group: &'a Zones, context: Context<'a>) -> Self {
        let size = ImageSize {
            width: SIDE_PX,
            height: SIDE_PX,
        };
        Self {
            group,
            counters: Counters::new(context.devices, size),
            hides: BTreeMap::new(),
            last: BTreeMap::new(),
        }
    }

    fn counts(
        &mut self,
        way: Way,
        eye: &Eye,
        drawn: &Drawn,
    ) -> Result<BTreeMap<Node, u64>, Failure> {
        let counts = self.counters.get(way)?.count(eye, drawn)?;
        Ok(drawn.nodes.iter().copied().zip(counts).collect())
    }

    /// Of what a zone shows a level below the finest over what it shows at the finest, the largest.
    fn hidden(&mut self, work: Work) -> Result<f64, Failure> {
        let key = (work.way.names()[0], work.spike_m.to_bits());
        if let Some(known) = self.hides.get(&key) {
            return Ok(*known);
        }
        let (eye, field) = (
            eye(),
            Field {
                spike_m: work.spike_m,
            },
        );
        let mut worst = 1.0_f64;
        let fine = self.counts(work.way, &eye, &field.drawn(&eye, &[FINEST; ZONES * ZONES]))?;
        for zone in 0..ZONES * ZONES {
            let mut levels = [FINEST; ZONES * ZONES];
            levels[zone] = FINEST - 1;
            let coarse = self.counts(work.way, &eye, &field.drawn(&eye, &levels))?;
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
        let (eye, field) = (
            eye(),
            Field {
                spike_m: work.spike_m,
            },
        );
        let rule = ZoneRule::new(
            COARSE_TRIANGLES.into(),
            FINEST,
            work.wanted,
            work.hysteresis,
        );
        let mut levels: Levels = [0; ZONES * ZONES];
        // Of each zone, the frame in which its level was first drawn.
        let mut since = [0; ZONES * ZONES];
        let mut counted: Vec<BTreeMap<Node, u64>> = Vec::new();
        let mut course = Course::default();
        for frame in 0..FRAMES {
            let drawn = field.drawn(&eye, &levels);
            let counts = self.counts(work.way, &eye, &drawn)?;
            counted.push(counts);
            let triangles = levels.iter().map(|level| rule.triangles(*level));
            course.triangles.push(triangles.sum());
            if frame == 0 || frame + 1 == FRAMES {
                let (largest, wrong) = ByRays::new(&eye, &drawn).against(&counted[frame]);
                let (so_far, so_wrong, compared) = course.against_rays;
                let nodes = compared + drawn.nodes.len();
                course.against_rays = (so_far.max(largest), so_wrong + wrong, nodes);
                self.last.insert(case, drawn);
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
                    course.changes.push(frame);
                }
            }
        }
        Ok(course)
    }
}

impl Measures for ZonePart<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let work = self.group.work[case];
        let hides = self.hidden(work)?;
        let course = self.run(case)?;
        let (largest, wrong, compared) = course.against_rays;
        let settled = course.settled();
        let mut figures = vec![
            ("globe_zone_hides", hides),
            ("globe_count_off_px", largest as f64),
            ("globe_count_wrong_nodes", wrong as f64),
            ("globe_count_nodes", compared as f64),
            ("globe_count_cycles", f64::from(u8::from(settled.is_none()))),
        ];
        figures.extend(settled.map(|frames| ("globe_count_settle_frames", frames as f64)));
        figures.extend(
            course
                .triangles
                .last()
                .map(|count| ("globe_triangles", *count)),
        );
        let reason = match wrong {
            0 => String::new(),
            wrong => format!(
                "{wrong} of {compared} zones are off by more pixels than they have at their edges, allowed 0"
            ),
        };
        let triangles: Vec<String> = course.triangles.iter().map(f64::to_string).collect();
        Ok(judged(
            reason,
            figures,
            vec![("triangles-by-frame", triangles.join(" "))],
        ))
    }

    /// The last frame with its counts read at once, and without counts.
    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let drawn = self.last.get(&case);
        let drawn = drawn.ok_or("it was not verified".to_owned())?;
        let counter = self.counters.get(self.group.work[case].way)?;
        let eye = eye();
        let watch = CpuStopwatch::start();
        counter.count(&eye, drawn)?;
        let counted_ms = watch.cpu_ms();
        let watch = CpuStopwatch::start();
        counter.draw(&eye, drawn)?;
        Ok(vec![
            ("globe_counted_cpu_ms", counted_ms),
            ("globe_uncounted_cpu_ms", watch.cpu_ms()),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::rc::Rc;
    use terrafill_fill::{Devices, device_for_test};

    #[test]
    fn spikes_let_zones_cycle_and_a_wide_hysteresis_stops_them() {
        let devices = Rc::new(Devices::default());
        if device_for_test(terrafill_gpu::shared_gpu(&devices)).is_none() {
            return;
        }
        let zones = Zones::new(true, 1);
        let folder = tempfile::tempdir().expect("a folder");
        let context = Context {
            devices: &devices,
            folder: folder.path(),
        };
        let mut part = ZonePart::new(&zones, context);
        let mut of = |spike_m: f64, hysteresis: f64| {
            let mut work = zones.work.iter();
            let is_it = |work: &Work| work.spike_m == spike_m && work.hysteresis == hysteresis;
            let case = work.position(is_it).expect("planned");
            let hides = part.hidden(zones.work[case]).unwrap_or(f64::NAN);
            let course = part.run(case).ok().expect("counted");
            eprintln!(
                "spikes of {spike_m} m, hysteresis {hysteresis}: hide all but 1/{hides:.2}, rest after {:?}, {:?}",
                course.settled(),
                course.against_rays
            );
            assert_eq!(course.against_rays.1, 0);
            (hides, course.settled())
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
        // Twin: with less than four times what the spikes hide they never rest.
        assert_eq!(of(1200.0, 8.0).1, None);
    }
}
