// SPDX-License-Identifier: MIT OR Apache-2.0
//! Balls over terrain, stepped on devices and drawn from where the step left them.

use crate::STUDY;
use crate::arithmetic::Real as _;
use crate::drawing::{DrawCalls, DrawsBalls};
use crate::flight::{Flight, Law, RESTITUTION};
use crate::metrics::{BALLS, DRAWN, GROUND, INTEGRATOR, INTERFACE, PART, SIZE_PX, WAY};
use crate::on_devices::{TIMED, constants, take};
use crate::stepping::Stepping;
use crate::steps::{BallConstants, Steps};
use crate::terrain::{State, Terrain, ball_view, judge};
use crate::walk::{FLIGHT_STEPS_PER_SECOND, Walk, flight_steps, walk};
use std::collections::BTreeMap;
use std::ops::Range;
use terrafill_contract::{CpuStopwatch, DeviceError, ids_of, numbers_hash};
use terrafill_results::Verdict;
use terrafill_scene::ImageSize;
use terrafill_shapes::rays::Judged;
use terrafill_study::{
    CaseGroup, Context, Failure, Figures, JudgedOnce, Request, Shows, judged, planned_case,
    verified,
};

/// Balls that are drawn one by one at most: the published figure ends at 5,000.
const MOST_EACH: u32 = 10_000;
/// Balls that are drawn at most: of more their step alone is of interest.
const MOST_DRAWN: u32 = 100_000;

/// Pixels a side of a quick run that names no size: the published one is not known.
const QUICK_SIDE_PX: u32 = 256;
/// Balls of other laws, and of ground that they change: the most that every run draws.
pub(crate) const COMPARED_BALLS: u32 = 4_000;

/// Size of the request's pictures: square, of its smaller side.
pub(crate) fn size_of(request: &Request) -> ImageSize {
    let [width, height] = request.size_or([QUICK_SIDE_PX; 2]);
    let side = width.min(height);
    ImageSize::new(side, side)
}

/// So many balls over terrain, by a way and a law, drawn or not.
#[derive(Debug, Clone, Copy)]
struct DrawnCase {
    way: Stepping,
    law: Law,
    drawn: DrawCalls,
    balls: u32,
}

impl DrawnCase {
    fn constants(&self) -> BallConstants {
        constants_over_terrain(self.balls, self.law)
    }
}

pub(crate) const STEP_S: f64 = 1.0 / FLIGHT_STEPS_PER_SECOND as f64;

/// So many balls over terrain that are reflected by a law.
pub(crate) fn constants_over_terrain(balls: u32, law: Law) -> BallConstants {
    BallConstants {
        step_s: f32::of(STEP_S),
        law: law.number(),
        restitution: f32::of(RESTITUTION),
        ..constants(balls)
    }
}

/// How balls step over terrain by a law.
pub(crate) fn flight_over(terrain: &Terrain, law: Law) -> Flight<'_> {
    Flight {
        terrain,
        law,
        restitution: RESTITUTION,
        step_s: STEP_S,
    }
}

/// Balls over terrain, drawn or not.
pub(crate) struct DrawnBalls {
    cases: Vec<DrawnCase>,
    size: ImageSize,
}

/// - `counts`: numbers of balls
/// - `samples`: of a process
pub(crate) fn group(counts: &[u32], size: ImageSize, samples: u32) -> CaseGroup<DrawnBalls> {
    let mut cases = Vec::new();
    for way in Stepping::ALL {
        let of = |law, drawn, balls| DrawnCase {
            way,
            law,
            drawn,
            balls,
        };
        for &balls in counts {
            let drawn = DrawCalls::ALL.into_iter();
            let drawn = drawn.filter(|drawn| {
                balls
                    <= match drawn {
                        DrawCalls::Nothing => u32::MAX,
                        DrawCalls::All => MOST_DRAWN,
                        DrawCalls::Each => MOST_EACH,
                    }
            });
            cases.extend(drawn.map(|drawn| of(Law::Published, drawn, balls)));
        }
        // Other laws of what is published.
        let laws = [Law::Guarded, Law::Event];
        cases.extend(laws.map(|law| of(law, DrawCalls::Nothing, COMPARED_BALLS)));
    }
    let case = |case: &DrawnCase| {
        let DrawnCase {
            way,
            law,
            drawn,
            balls,
        } = case;
        let (interface, name) = way.names();
        let conditions = vec![
            (PART, "drawn".to_owned()),
            (INTERFACE, interface.to_owned()),
            (WAY, name.to_owned()),
            (GROUND, "terrain".to_owned()),
            (INTEGRATOR, law.name().to_owned()),
            (DRAWN, drawn.name().to_owned()),
            (BALLS, balls.to_string()),
        ];
        planned_case(
            STUDY,
            samples,
            conditions,
            Some((SIZE_PX, size.width.to_string())),
        )
    };
    CaseGroup {
        name: format!("{STUDY}/drawn"),
        cases: cases.iter().map(case).collect(),
        warm_up: None,
        work: DrawnBalls { cases, size },
        open: |group, context| {
            Ok(Box::new(JudgedOnce::new(DrawnSession {
                group,
                context,
                terrain: Terrain::new(),
                walked: BTreeMap::new(),
                first: BTreeMap::new(),
                opened: BTreeMap::new(),
            })))
        },
    }
}

struct Opened {
    steps: Box<dyn Steps>,
    points: Box<dyn DrawsBalls>,
    ranges: Vec<Range<u32>>,
}

struct DrawnSession<'a> {
    group: &'a CaseGroup<DrawnBalls>,
    context: Context<'a>,
    terrain: Terrain,
    /// By way, law and number of balls: how they went, and where they ended.
    walked: BTreeMap<(Stepping, Law, u32), (Walk, Vec<State>)>,
    /// Of the first picture of a way and number of balls, by which others are held.
    first: BTreeMap<(Stepping, u32), Vec<u32>>,
    /// By case.
    opened: BTreeMap<usize, Opened>,
}

/// What a case counted, and how its picture was judged.
#[derive(Debug, Default)]
struct BallOutcome {
    walk: Walk,
    /// Balls that ended elsewhere than when they were followed.
    strayed: usize,
    /// Bytes that were uploaded while stepping and drawing, and that had to be: the CPU writes what it steps itself.
    uploaded: u64,
    expected: u64,
    judged: Judged,
    differing: usize,
    draws: usize,
}

/// What a case left behind.
struct ShownBalls {
    last: Vec<State>,
    /// Numbers of the picture's pixels; none where nothing is drawn.
    numbers: Vec<u32>,
    uploaded: u64,
}

impl DrawnSession<'_> {
    fn judged(&mut self, case: usize, shown: &ShownBalls) -> Result<BallOutcome, DeviceError> {
        let DrawnBalls { ref cases, size } = self.group.work;
        let of_case = cases[case];
        let DrawnCase {
            way,
            law,
            drawn,
            balls: count,
        } = of_case;
        let balls = self.terrain.balls(count);
        let key = (way, law, count);
        if !self.walked.contains_key(&key) {
            let devices = self.context.devices;
            let mut steps = way.open(devices, &of_case.constants(), &balls, Some(&self.terrain))?;
            let walk = walk(steps.as_mut(), &flight_over(&self.terrain, law), &balls)?;
            self.walked.insert(key, (walk, steps.read()?));
        }
        let (walk, there) = &self.walked[&key];
        let last = &shown.last;
        let strayed = last.iter().zip(there).filter(|(a, b)| a != b).count();
        let submissions = flight_steps(balls.len()).div_ceil(TIMED);
        let mut found = BallOutcome {
            walk: *walk,
            strayed: strayed + last.len().abs_diff(there.len()),
            uploaded: shown.uploaded,
            expected: way.uploads(count, submissions),
            draws: drawn.ranges(count).len(),
            ..BallOutcome::default()
        };
        if found.draws > 0 {
            let ImageSize { width, height } = size;
            found.judged = judge(&ball_view(), [width, height], last, &shown.numbers);
            let first = self.first.entry((way, count));
            let first = first.or_insert_with(|| shown.numbers.clone());
            let pixels = shown.numbers.iter().zip(&*first);
            found.differing = pixels.filter(|(a, b)| a != b).count();
        }
        Ok(found)
    }
}

impl BallOutcome {
    fn reason(&self) -> String {
        let Self {
            walk,
            strayed,
            uploaded,
            expected,
            judged,
            differing,
            ..
        } = self;
        let reason = walk.reason();
        if !reason.is_empty() {
            reason
        } else if *strayed > 0 {
            format!("{strayed} balls end elsewhere when steps are taken in frames of {TIMED}")
        } else if uploaded != expected {
            format!(
                "{uploaded} bytes were uploaded while stepping and drawing, expected {expected}"
            )
        } else if judged.mismatched > 0 {
            format!(
                "{} pixels show what the reference does not allow",
                judged.mismatched
            )
        } else if *differing > 0 {
            format!("{differing} pixels differ from those of one draw for all")
        } else if self.draws > 0 && judged.shown == 0 {
            "it shows nothing".to_owned()
        } else {
            String::new()
        }
    }
}

impl Shows for DrawnSession<'_> {
    type Shown = ShownBalls;

    fn show(&mut self, case: usize) -> Result<(String, ShownBalls), Failure> {
        let DrawnBalls { ref cases, size } = self.group.work;
        let case_of = cases[case];
        let balls = self.terrain.balls(case_of.balls);
        let (devices, constants) = (self.context.devices, case_of.constants());
        let mut steps = case_of
            .way
            .open(devices, &constants, &balls, Some(&self.terrain))?;
        let mut points = steps.points(size)?;
        let mut uploaded = take(steps.as_mut(), flight_steps(balls.len()))?;
        let last = steps.read()?;
        let ranges = case_of.drawn.ranges(case_of.balls);
        let mut numbers = Vec::new();
        if !ranges.is_empty() {
            let before = steps.uploaded();
            points.draw(steps.current(), &ranges)?;
            uploaded += steps.uploaded() - before;
            numbers = ids_of(&points.read()?);
        }
        let opened = Opened {
            steps,
            points,
            ranges,
        };
        self.opened.insert(case, opened);
        let balls = numbers_hash(bytemuck::cast_slice(&last));
        let hash = format!("{balls}-{}-{uploaded}", numbers_hash(&numbers));
        let shown = ShownBalls {
            last,
            numbers,
            uploaded,
        };
        Ok((hash, shown))
    }

    fn judge(&mut self, case: usize, shown: ShownBalls) -> Result<Verdict, Failure> {
        let found = self.judged(case, &shown)?;
        let reason = found.reason();
        let mut figures = vec![
            ("ball_terrain_step_m", found.walk.step_m),
            ("ball_terrain_step_speed", found.walk.step_speed),
            ("ball_terrain_followed", found.walk.followed as f64),
            ("ball_terrain_in_band", found.walk.in_band as f64),
            ("ball_impacts", found.walk.impacts as f64),
            ("ball_impact_max_s", found.walk.impact_max_s),
            ("ball_impact_rms_s", found.walk.impact_rms_s),
            ("ball_impact_missed", found.walk.missed_share),
            ("ball_sunk_share", found.walk.sunk_share),
            ("ball_upload_bytes", found.uploaded as f64),
            ("ball_draws", found.draws as f64),
        ];
        let of_impacts = [
            ("ball_impact_place_m", found.walk.impact_place_m),
            ("ball_impact_energy", found.walk.impact_energy),
        ];
        figures.extend(
            of_impacts
                .into_iter()
                .filter_map(|(name, of)| Some((name, of?))),
        );
        if found.draws > 0 {
            figures.push(("ball_mismatched_px", found.judged.mismatched as f64));
            figures.push(("ball_differing_px", found.differing as f64));
        }
        Ok(judged(reason, figures, Vec::new()))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let opened = verified(&mut self.opened, case)?;
        let watch = CpuStopwatch::start();
        opened.steps.step(1)?;
        let stepped_ms = watch.cpu_ms();
        let gpu_ms = opened.steps.gpu_ms()?;
        let mut figures: Figures = Vec::new();
        figures.extend(gpu_ms.map(|ms| ("ball_step_gpu_us", 1e3 * ms)));
        if !opened.ranges.is_empty() {
            let state = opened.steps.current();
            let gpu_ms = opened.points.draw(state, &opened.ranges)?;
            figures.push(("ball_draw_cpu_us", 1e3 * (watch.cpu_ms() - stepped_ms)));
            figures.extend(gpu_ms.map(|ms| ("ball_draw_gpu_us", 1e3 * ms)));
        }
        figures.push(("ball_frame_cpu_us", 1e3 * watch.cpu_ms()));
        figures.push(("ball_frame_wall_us", 1e3 * watch.wall_ms()));
        Ok(figures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::rc::Rc;
    use terrafill_contract::Devices;
    use terrafill_results::Status;
    use terrafill_study::Group as _;

    const SIZE: ImageSize = ImageSize::new(QUICK_SIDE_PX, QUICK_SIDE_PX);

    #[test]
    fn balls_over_terrain_follow_f64_and_those_over_other_ground_do_not() {
        let devices = Rc::new(Devices::default());
        let group = group(&[500], SIZE, 1);
        let context = Context {
            devices: &devices,
            folder: std::path::Path::new(""),
        };
        let mut session = group.open(context).expect("opens");
        for (at, planned) in group.cases.iter().enumerate() {
            let verdict = session
                .verify(at)
                .or_else(Failure::verdict)
                .expect("a verdict");
            let name = &planned.id.name;
            eprintln!(
                "{name}: {:?} {} {:?}",
                verdict.status, verdict.reason, verdict.figures
            );
            if verdict.status == Status::Skipped {
                continue;
            }
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
            let times = session.time(at).expect("a time");
            assert!(times.iter().all(|(_, time)| *time >= 0.0), "{times:?}");
        }
        // Negative controls: blocks in each other's layers, another law, and a picture of balls that moved on.
        let terrain = Terrain::new();
        let mut exchanged = terrain.clone();
        exchanged.blocks.swap(5, 6);
        let first = terrain.balls(500);
        for way in Stepping::ALL {
            let case = DrawnCase {
                way,
                law: Law::Event,
                drawn: DrawCalls::All,
                balls: 500,
            };
            let open = |over| way.open(&devices, &case.constants(), &first, Some(over));
            let (Ok(mut steps), Ok(mut other)) = (open(&terrain), open(&exchanged)) else {
                continue;
            };
            let right =
                walk(steps.as_mut(), &flight_over(&terrain, case.law), &first).expect("steps");
            assert_eq!(right.reason(), "", "{way:?}");
            let wrong =
                walk(other.as_mut(), &flight_over(&terrain, case.law), &first).expect("steps");
            assert!(wrong.reason().contains("from f64"), "{way:?}: {wrong:?}");
            let law = Flight {
                law: Law::Guarded,
                ..flight_over(&terrain, case.law)
            };
            let wrong = walk(open(&terrain).expect("opens").as_mut(), &law, &first);
            let wrong = wrong.expect("steps");
            assert!(wrong.reason().contains("from f64"), "{way:?}: {wrong:?}");
            let last = steps.read().expect("reads");
            let mut points = steps.points(SIZE).expect("points");
            let drawn = points.draw(steps.current(), &DrawCalls::All.ranges(500));
            drawn.expect("draws");
            let numbers = ids_of(&points.read().expect("a picture"));
            let size = [SIZE.width, SIZE.height];
            let judged = |balls: &[State]| judge(&ball_view(), size, balls, &numbers);
            assert_eq!(judged(&last).mismatched, 0, "{way:?}");
            assert!(judged(&first).mismatched > 0, "{way:?}");
        }
    }

    #[test]
    fn many_balls_are_looked_at_now_and_then_and_meet_the_ground() {
        let devices = Rc::new(Devices::default());
        let group = group(&[MOST_DRAWN + 1], SIZE, 1);
        let context = Context {
            devices: &devices,
            folder: std::path::Path::new(""),
        };
        let mut session = group.open(context).expect("opens");
        let verdict = session
            .verify(0)
            .or_else(Failure::verdict)
            .expect("a verdict");
        assert_eq!(verdict.status, Status::Ok, "{}", verdict.reason);
        // So many are not drawn.
        let drawn = |case: &DrawnCase| case.drawn != DrawCalls::Nothing;
        assert!(!group.work.cases.iter().any(drawn));
    }

    #[test]
    fn whatever_is_wrong_is_said() {
        let walk = Walk {
            impacts: 1,
            ..Walk::default()
        };
        let right = BallOutcome {
            walk,
            judged: Judged {
                shown: 9,
                ..Judged::default()
            },
            draws: 1,
            ..BallOutcome::default()
        };
        assert_eq!(right.reason(), "");
        let said = |change: fn(&mut BallOutcome)| {
            let mut wrong = BallOutcome {
                walk: Walk {
                    impacts: 1,
                    ..Walk::default()
                },
                ..BallOutcome::default()
            };
            change(&mut wrong);
            wrong.reason()
        };
        assert!(said(|ball| ball.walk.step_m = 1.0).contains("from f64"));
        assert!(said(|ball| ball.strayed = 2).contains("2 balls end elsewhere"));
        assert!(said(|ball| ball.uploaded = 4).contains("4 bytes"));
        let differing = said(|ball| (ball.differing, ball.draws) = (1, 2));
        assert!(differing.contains("1 pixels differ"));
    }
}
