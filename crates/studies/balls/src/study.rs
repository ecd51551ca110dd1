// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: drops by integrator, stiffness, arithmetic, state and step; then what needs devices.

use crate::chapter::CHAPTER;
use crate::drop::{Arithmetic, Drop, GROUND_M, MOSTLY};
use crate::integrator::Integrator;
use crate::metrics::*;
use crate::{STUDY, craters, drawn, on_devices};
use std::collections::BTreeMap;
use terrafill_contract::CpuStopwatch;
use terrafill_results::{ConditionKey, PlannedCase, Status, Verdict};
use terrafill_study::{
    CaseGroup, Depth, Failure, Figures, Planned, Request, Session, Study, StudyError, judged,
    planned_case,
};

/// Steps a second; a quick run leaves out the last.
const STEPS: [u32; 6] = [30, 120, 480, 1_920, 7_680, 30_720];
/// Stiffness k/m, 1/s².
const SPRINGS: [f64; 3] = [1e3, 1e5, 1e7];
/// Timed runs of each case in a process, unless the request says otherwise.
const SAMPLES: u32 = 2;

/// The same of drops, which take the most time: a sample is the mean over many balls and steps.
const DROP_SAMPLES: u32 = 1;

/// Balls on flat ground, by every integrator.
#[derive(Debug, Clone, Copy)]
pub struct BallsStudy;

impl Study for BallsStudy {
    terrafill_study::study_facts!(
        name: STUDY,
        metrics: METRICS,
        conditions: crate::metrics::CONDITIONS,
        least_depth: Full,
        chapter: CHAPTER,
    );

    fn needs_device(&self) -> bool {
        // Without one, its part of devices is skipped, with the reason.
        false
    }

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let is_quick = request.depth == Depth::Quick;
        let samples = request.samples.unwrap_or(SAMPLES);
        let (counts, size) = (on_devices::counts(is_quick), drawn::size_of(request));
        Ok(Planned {
            groups: vec![
                Box::new(group(
                    request.depth,
                    request.samples.unwrap_or(DROP_SAMPLES),
                )),
                Box::new(on_devices::group(counts, samples)),
                Box::new(drawn::group(counts, size, samples)),
                Box::new(craters::group(&craters::COUNTS, size, samples)),
            ],
            ..Planned::default()
        })
    }
}

/// Conditions of a case, in the order of its name.
fn conditions(drop: &Drop) -> [(ConditionKey, String); 6] {
    let stiffness = drop.stiffness.map(|stiffness| format!("{stiffness:e}"));
    let state = if drop.datum_m > 0.0 { "height" } else { "gap" };
    [
        (PART, "drop".to_owned()),
        (INTEGRATOR, drop.integrator.name().to_owned()),
        (STIFFNESS, stiffness.unwrap_or_else(|| "hard".to_owned())),
        (ARITHMETIC, drop.arithmetic.name().to_owned()),
        (STATE, state.to_owned()),
        (STEPS_PER_SECOND, drop.steps_per_second.to_string()),
    ]
}

fn drops(depth: Depth) -> Vec<Drop> {
    let is_quick = depth == Depth::Quick;
    let balls = match depth {
        Depth::Quick => 16,
        Depth::Main => 64,
        Depth::Full => 128,
    };
    let mut drops = Vec::new();
    for stiffness in SPRINGS.map(Some).into_iter().chain([None]) {
        let integrators: &[Integrator] = match stiffness {
            Some(_) => &Integrator::SPRING,
            None => &Integrator::HARD,
        };
        for &integrator in integrators {
            for arithmetic in Arithmetic::ALL {
                for datum_m in [0.0, GROUND_M] {
                    for &steps_per_second in &STEPS[..if is_quick { 5 } else { 6 }] {
                        drops.push(Drop {
                            integrator,
                            stiffness,
                            arithmetic,
                            datum_m,
                            steps_per_second,
                            restitution: 1.0,
                            balls,
                            seconds: 5,
                        });
                    }
                }
            }
        }
    }
    drops
}

/// Drops, which need no device.
fn group(depth: Depth, samples: u32) -> CaseGroup<Vec<Drop>> {
    let drops = drops(depth);
    let case = |drop: &Drop| PlannedCase {
        may_be_wrong: drop.may_blow_up(),
        ..planned_case(STUDY, samples, conditions(drop), None)
    };
    CaseGroup {
        name: format!("{STUDY}/drop"),
        cases: drops.iter().map(case).collect(),
        // The check of a case runs it once.
        warm_up: Some(0),
        work: drops,
        open: |group, _| Ok(Box::new(BallsSession(&group.work))),
    }
}

struct BallsSession<'a>(&'a [Drop]);

impl Session for BallsSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let landed = self.0[case].land();
        let reason = if landed.blown_share > MOSTLY {
            format!("{:.0} % of the balls blew up", 100.0 * landed.blown_share)
        } else {
            String::new()
        };
        let figures = [
            (BALL_RMS_M.name, landed.rms_m),
            (BALL_BLOWN_SHARE.name, Some(landed.blown_share)),
            (BALL_ENERGY_CHANGE.name, landed.energy_change),
            ("ball_deepest_m", Some(landed.deepest_m)),
        ];
        // A figure that is not finite is absent.
        let known = figures.into_iter();
        let known =
            known.filter_map(|(name, value)| Some((name, value.filter(|v| v.is_finite())?)));
        Ok(judged(reason, known.collect(), Vec::new()))
    }

    fn recheck(
        &mut self,
        _case: usize,
        status: Status,
        _notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, Failure> {
        // The figures are exact: another process has the same.
        Ok(Verdict {
            status,
            ..Verdict::default()
        })
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let drop = self.0[case].timed();
        let watch = CpuStopwatch::start();
        std::hint::black_box(drop.work());
        let ball_seconds = f64::from(drop.balls) * f64::from(drop.seconds);
        Ok(vec![("ball_cpu_us", watch.cpu_ms() * 1e3 / ball_seconds)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_whose_balls_blew_up_is_wrong_and_only_where_that_is_foreseen() {
        let balls = group(Depth::Quick, 1);
        let mut session = BallsSession(&balls.work);
        let mut wrong = 0;
        for (index, case) in balls.cases.iter().enumerate() {
            let verdict = session.verify(index).expect("it has figures");
            if verdict.status == Status::Ok {
                assert_eq!(verdict.reason, "");
            } else {
                assert!(case.may_be_wrong, "{}: {}", case.id.name, verdict.reason);
                wrong += 1;
            }
        }
        // Negative control: some do, and most do not.
        assert!(wrong > 20 && wrong < balls.cases.len() / 3, "{wrong}");
    }
}
