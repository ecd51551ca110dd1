// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: drops by integrator, stiffness, arithmetic, state and step; contacts; reflections; rests.

use crate::chapter::CHAPTER;
use crate::contact::{STEPS, energy_ratio};
use crate::drop::{Arithmetic, Drop, GROUND_M, MOSTLY, Rest};
use crate::integrator::Integrator;
use crate::keys::{self, *};
use crate::{STUDY, drawn, metrics::METRICS, on_devices};
use std::collections::BTreeMap;
use terrafill_fill::CpuStopwatch;
use terrafill_results::{ConditionKey, PlannedCase, Status, Verdict};
use terrafill_study::{
    CaseGroup, CaseSession, Depth, Failure, Figures, Group, Measures, Planned, Request, Study,
    StudyError, judged, planned_case,
};

/// Conditions of a case, in the order of its name.
type Conditions = Vec<(ConditionKey, String)>;

/// Steps a second; a quick run leaves out the last.
const STEPS_PER_SECOND: [u32; 6] = [30, 120, 480, 1_920, 7_680, 30_720];
/// Stiffness k/m by its name in tables, 1/s².
const STIFFNESS: [(&str, f64); 3] = [("1e3", 1e3), ("1e5", 1e5), ("1e7", 1e7)];
/// Timed runs of each case in a process, unless the request says otherwise.
const SAMPLES: u32 = 2;

/// Balls on flat ground, by every integrator.
#[derive(Debug, Clone, Copy)]
pub struct BallsStudy;

impl Study for BallsStudy {
    terrafill_study::study_facts!(
        name: STUDY,
        question: "Which integrator takes a bouncing ball to which error, and what does a step cost on devices?",
        metrics: METRICS,
        conditions: crate::keys::CONDITIONS,
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
        let mut groups: Vec<Box<dyn Group>> = Vec::new();
        for (part, experiments) in [
            ("drop", drops(is_quick)),
            ("contact", contacts()),
            ("reflect", reflections()),
            ("rest", rests()),
        ] {
            groups.push(Box::new(group(part, experiments, samples)));
        }
        groups.push(Box::new(on_devices::group(is_quick, samples)));
        let pictures = (drawn::size_of(request), samples);
        groups.push(Box::new(drawn::group(is_quick, pictures)));
        Ok(Planned {
            groups,
            skipped: Vec::new(),
        })
    }
}

/// What a case does.
#[derive(Debug, Clone, Copy)]
enum Experiment {
    Drop(Drop),
    Contact(Integrator, f64),
    Reflect(Drop),
    Rest(Rest),
}

fn state(datum_m: f64) -> String {
    if datum_m > 0.0 { "height" } else { "gap" }.to_owned()
}

fn drops(is_quick: bool) -> Vec<(Conditions, Experiment)> {
    let spring = STIFFNESS.map(|(name, value)| (name, Some(value)));
    let laws = spring.into_iter().chain([("hard", None)]);
    let mut drops = Vec::new();
    for (name, stiffness) in laws {
        let integrators: &[Integrator] = match stiffness {
            Some(_) => &Integrator::SPRING,
            None => &Integrator::HARD,
        };
        for &integrator in integrators {
            for arithmetic in Arithmetic::ALL {
                for datum_m in [0.0, GROUND_M] {
                    for &steps in &STEPS_PER_SECOND[..if is_quick { 5 } else { 6 }] {
                        let drop = Drop {
                            integrator,
                            stiffness,
                            arithmetic,
                            datum_m,
                            steps_per_second: steps,
                            restitution: 1.0,
                            balls: if is_quick { 16 } else { 128 },
                            seconds: 5,
                        };
                        let conditions = vec![
                            (INTEGRATOR, integrator.name().to_owned()),
                            (keys::STIFFNESS, name.to_owned()),
                            (ARITHMETIC, arithmetic.name().to_owned()),
                            (STATE, state(datum_m)),
                            (keys::STEPS_PER_SECOND, steps.to_string()),
                        ];
                        drops.push((conditions, Experiment::Drop(drop)));
                    }
                }
            }
        }
    }
    drops
}

fn contacts() -> Vec<(Conditions, Experiment)> {
    let of = |integrator: Integrator| {
        STEPS.map(|length| {
            let conditions = vec![
                (INTEGRATOR, integrator.name().to_owned()),
                (OMEGA_DT, length.to_string()),
            ];
            (conditions, Experiment::Contact(integrator, length))
        })
    };
    Integrator::SPRING.into_iter().flat_map(of).collect()
}

fn reflections() -> Vec<(Conditions, Experiment)> {
    let mut reflections = Vec::new();
    for integrator in Integrator::HARD {
        for restitution in [1.0, 0.8, 0.5] {
            for steps in [30, 60, 240] {
                let drop = Drop {
                    integrator,
                    stiffness: None,
                    arithmetic: Arithmetic::F64,
                    datum_m: 0.0,
                    steps_per_second: steps,
                    restitution,
                    balls: 2_000,
                    seconds: 10,
                };
                let conditions = vec![
                    (INTEGRATOR, integrator.name().to_owned()),
                    (RESTITUTION, restitution.to_string()),
                    (keys::STEPS_PER_SECOND, steps.to_string()),
                ];
                reflections.push((conditions, Experiment::Reflect(drop)));
            }
        }
    }
    reflections
}

fn rests() -> Vec<(Conditions, Experiment)> {
    let mut rests = Vec::new();
    for (name, stiffness) in STIFFNESS {
        for arithmetic in Arithmetic::ALL {
            for datum_m in [0.0, 10.0, 100.0, GROUND_M, 8_000.0] {
                let rest = Rest {
                    stiffness,
                    arithmetic,
                    datum_m,
                };
                let conditions = vec![
                    (keys::STIFFNESS, name.to_owned()),
                    (ARITHMETIC, arithmetic.name().to_owned()),
                    (DATUM_M, datum_m.to_string()),
                ];
                rests.push((conditions, Experiment::Rest(rest)));
            }
        }
    }
    rests
}

/// Cases of one part, which need no device.
fn group(
    part: &'static str,
    of: Vec<(Conditions, Experiment)>,
    samples: u32,
) -> CaseGroup<Vec<Experiment>> {
    let case = |(conditions, experiment): &(Conditions, Experiment)| {
        let part = [(PART, part.to_owned())].into_iter();
        let conditions = part.chain(conditions.iter().cloned());
        // Shares and energies are exact; only drops are timed.
        let (samples, may_be_wrong) = match experiment {
            Experiment::Drop(drop) => (samples, drop.may_blow_up()),
            _ => (0, false),
        };
        PlannedCase {
            may_be_wrong,
            ..planned_case(STUDY, samples, conditions, None)
        }
    };
    CaseGroup {
        name: format!("{STUDY}/{part}"),
        cases: of.iter().map(case).collect(),
        // The check of a case runs it once.
        warm_up: Some(0),
        work: of.into_iter().map(|(_, experiment)| experiment).collect(),
        open: |group, _| Ok(Box::new(CaseSession(BallsSession(&group.work)))),
    }
}

struct BallsSession<'a>(&'a [Experiment]);

impl Measures for BallsSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let figures = figures(&self.0[case]);
        let mut shares = figures.iter();
        let blown = shares.find(|(name, _)| *name == BALL_BLOWN_SHARE.name);
        let reason = match blown {
            Some((_, share)) if *share > MOSTLY => {
                format!("{:.0} % of the balls blew up", 100.0 * share)
            }
            _ => String::new(),
        };
        Ok(judged(reason, figures, Vec::new()))
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
        let Experiment::Drop(drop) = &self.0[case] else {
            return Err(Failure::Broken("only drops are timed".to_owned()));
        };
        let watch = CpuStopwatch::start();
        std::hint::black_box(drop.work());
        let ball_seconds = f64::from(drop.balls) * f64::from(drop.seconds);
        Ok(vec![("ball_cpu_us", watch.cpu_ms() * 1e3 / ball_seconds)])
    }
}

/// What a case shows; a figure that is not finite is absent.
fn figures(experiment: &Experiment) -> Figures {
    let figures = match experiment {
        Experiment::Drop(drop) => {
            let landed = drop.land();
            vec![
                ("ball_rms_m", landed.rms_m),
                ("ball_blown_share", Some(landed.blown_share)),
                ("ball_energy_change", landed.energy_change),
                ("ball_deepest_m", Some(landed.deepest_m)),
            ]
        }
        Experiment::Contact(integrator, length) => {
            let ratio = energy_ratio(*integrator, *length);
            vec![
                ("ball_contact_energy_mean", ratio.map(|ratio| ratio.mean)),
                ("ball_contact_energy_max", ratio.map(|ratio| ratio.largest)),
                (
                    "ball_contact_energy_rms",
                    ratio.map(|ratio| ratio.rms_change),
                ),
                (
                    "ball_contact_stayed_share",
                    ratio.map(|ratio| ratio.stayed_share),
                ),
            ]
        }
        Experiment::Reflect(drop) => {
            let landed = drop.land();
            vec![
                ("ball_sunk_share", Some(landed.sunk_share)),
                ("ball_energy_change", landed.energy_change),
            ]
        }
        Experiment::Rest(rest) => {
            let rested = rest.settle();
            vec![
                ("ball_rest_gap_m", Some(rested.gap_error_m)),
                ("ball_rest_speed", Some(rested.speed)),
            ]
        }
    };
    let known = figures.into_iter();
    let known = known.filter_map(|(name, value)| Some((name, value.filter(|v| v.is_finite())?)));
    known.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_whose_balls_blew_up_is_wrong_and_only_where_that_is_foreseen() {
        let balls = group("drop", drops(true), 1);
        let mut session = BallsSession(&balls.work);
        let mut wrong = 0;
        for (index, case) in balls.cases.iter().enumerate() {
            let verdict = session.verify(index).expect("it has figures");
            match verdict.status {
                Status::Ok => assert_eq!(verdict.reason, ""),
                _ => {
                    assert!(case.may_be_wrong, "{}: {}", case.id.name, verdict.reason);
                    wrong += 1;
                }
            }
        }
        // Twin: some do, and most do not.
        assert!(wrong > 20 && wrong < balls.cases.len() / 3, "{wrong}");
    }
}
