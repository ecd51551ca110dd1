// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: interfaces × image sizes, in one group.

use crate::globe::{Draw, INTERFACES, Reader, byte_count, check, fingerprint, globe};
use crate::keys::{API, SIZE_PX};
use crate::metrics::METRICS;
use crate::{STUDY, chapter::CHAPTER};
use std::collections::BTreeMap;
use terrafill_fill::CpuStopwatch;
use terrafill_results::Verdict;
use terrafill_scene::ImageSize;
use terrafill_study::{
    CaseGroup, CaseSession, Context, Depth, Failure, Figures, Measures, Planned, Request, Study,
    StudyError, judged, planned_case,
};

/// Pixels a side, from 32 kB to 134 MB of colour and depth. A quick run measures the first four.
const SIZES: [u32; 6] = [64, 256, 512, 1024, 2048, 4096];
const QUICK_SIZES: usize = 4;

/// Timed reads of each case in a process, unless the request says otherwise. Odd, so that the median
/// is one of them.
const SAMPLES: u32 = 7;

/// What reading an image back costs.
#[derive(Debug, Clone, Copy)]
pub struct ReadbackStudy;

impl Study for ReadbackStudy {
    terrafill_study::study_facts!(
        name: STUDY,
        question: "How long does reading an image back take, and at which rate?",
        metrics: METRICS,
        conditions: crate::keys::CONDITIONS,
        least_depth: Full,
        chapter: CHAPTER,
    );

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let is_quick = request.depth == Depth::Quick;
        let sizes = &SIZES[..if is_quick { QUICK_SIZES } else { SIZES.len() }];
        let samples = request.samples.unwrap_or(SAMPLES);
        Ok(Planned {
            groups: vec![Box::new(readings(sizes, samples))],
            skipped: Vec::new(),
        })
    }
}

/// Every interface and size.
fn readings(sizes: &[u32], samples: u32) -> CaseGroup<Vec<(Draw, u32)>> {
    let (mut work, mut cases) = (Vec::new(), Vec::new());
    for (api, draw) in INTERFACES {
        for &side in sizes {
            let conditions = [(API, api.name.to_owned()), (SIZE_PX, side.to_string())];
            cases.push(planned_case(STUDY, samples, conditions, None));
            work.push((draw, side));
        }
    }
    CaseGroup {
        name: STUDY.to_owned(),
        cases,
        warm_up: None,
        work,
        open: |group, context| {
            Ok(Box::new(CaseSession(Readings {
                work: &group.work,
                context,
                drawn: BTreeMap::new(),
            })))
        },
    }
}

struct Readings<'a> {
    work: &'a [(Draw, u32)],
    context: Context<'a>,
    /// Targets that hold the globe by case, and the fingerprint of the picture that was verified.
    drawn: BTreeMap<usize, (Reader, u64)>,
}

impl Measures for Readings<'_> {
    /// Draws the globe and reads it twice.
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let (draw, side) = self.work[case];
        let input = globe(ImageSize {
            width: side,
            height: side,
        })?;
        let reader = draw(self.context.devices, &input)?;
        let [first, second] = [reader()?, reader()?];
        let reason = check([&first, &second], &input).err().unwrap_or_default();
        self.drawn.insert(case, (reader, fingerprint(&first)));
        let figures = vec![("readback_bytes", byte_count(&first) as f64)];
        Ok(judged(reason, figures, Vec::new()))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let drawn = self.drawn.get(&case);
        let (reader, verified) = drawn.ok_or("it was not verified".to_owned())?;
        let watch = CpuStopwatch::start();
        let read = reader();
        let (cpu_ms, wall_ms) = (watch.cpu_ms(), watch.wall_ms());
        let picture = read?;
        if fingerprint(&picture) != *verified {
            return Err("it read different bytes than when it was verified"
                .to_owned()
                .into());
        }
        Ok(vec![
            ("readback_cpu_ms", cpu_ms),
            ("readback_wall_ms", wall_ms),
            (
                "readback_rate",
                byte_count(&picture) as f64 * 1e-3 / wall_ms,
            ),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use std::rc::Rc;
    use terrafill_fill::{Devices, device_for_test};
    use terrafill_results::{
        Block, Chapter as _, Outcome, Run, RunEnvironment, RunFolder, SCHEMA, Status,
    };
    use terrafill_study::{Group as _, RunOptions, Silent, plan, run};

    #[test]
    fn a_quick_plan_stops_at_1024_pixels() {
        let sides = |depth| {
            let request = Request {
                depth,
                ..Request::default()
            };
            let planned = ReadbackStudy.plan(&request).expect("planned");
            let cases = planned.groups[0].cases().iter();
            let sides = cases.map(|case| case.id.condition(SIZE_PX).to_owned());
            sides.collect::<Vec<_>>()
        };
        let quick = ["64", "256", "512", "1024"];
        assert_eq!(sides(Depth::Quick), [quick, quick].concat());
        assert_eq!(sides(Depth::Full).len(), 12);
        assert_eq!(sides(Depth::Full).last().map(String::as_str), Some("4096"));
    }

    fn measure(folder: &Path, devices: Devices) -> Run {
        let request = Request {
            depth: Depth::Quick,
            samples: Some(1),
            ..Request::default()
        };
        let options = RunOptions {
            processes: 1,
            process: 0,
            warm_up: 0,
            seed: 1,
            shard: None,
        };
        let plan = plan(&[&ReadbackStudy], &request, &options).expect("planned");
        let environment = RunEnvironment {
            schema: SCHEMA,
            ..RunEnvironment::default()
        };
        let run_plan = plan.run_plan().clone();
        let run_folder = RunFolder::create(folder, environment, run_plan, &METRICS);
        let run_folder = run_folder.expect("a folder");
        run(&plan, &run_folder, &Rc::new(devices), &options, &mut Silent).expect("measured");
        Run::load(folder).expect("a run")
    }

    #[test]
    fn a_run_has_every_time_and_a_chapter() {
        for (_, draw) in INTERFACES {
            let size = ImageSize {
                width: 1,
                height: 1,
            };
            let input = globe(size).expect("a surface");
            let drawn = draw(&Devices::default(), &input);
            if device_for_test(drawn).is_none() {
                return;
            }
        }
        let folder = tempfile::tempdir().expect("a folder");
        let run = measure(&folder.path().join("run"), Devices::default());
        // Eight cases, and two of them again.
        assert_eq!(run.cases.len(), 10);
        for case in &run.cases {
            let name = case.id();
            assert_eq!(case.outcome, Outcome::Ok, "{name}: {}", case.reason);
            let [cpu_ms, wall_ms, rate] = ["readback_cpu_ms", "readback_wall_ms", "readback_rate"]
                .map(|metric| case.value(metric).expect("measured"));
            assert!(cpu_ms >= 0.0 && wall_ms > 0.0, "{name}");
            let side: f64 = case.condition(SIZE_PX).parse().expect("a number");
            let bytes = 8.0 * side * side;
            assert!((rate * wall_ms * 1e3 / bytes - 1.0).abs() < 1e-9, "{name}");
            if !case.is_twin() {
                assert_eq!(case.value("readback_bytes"), Some(bytes), "{name}");
            }
        }
        let blocks = CHAPTER.blocks(&run).expect("a chapter");
        assert!(blocks.iter().any(|block| matches!(block, Block::Plot(_))));
    }

    #[test]
    fn a_missing_device_and_a_size_beyond_its_limit_are_skipped_with_the_reason() {
        let folder = tempfile::tempdir().expect("a folder");
        let none = Devices::new(Some("no such adapter".to_owned()));
        let run = measure(&folder.path().join("run"), none);
        for case in run.cases.iter().filter(|case| !case.is_twin()) {
            assert_eq!(case.outcome, Outcome::Skipped, "{}", case.reason);
            assert!(!case.reason.is_empty());
        }
        let devices = Rc::new(Devices::default());
        let group = readings(&[1 << 20], 1);
        let context = Context {
            devices: &devices,
            folder: folder.path(),
        };
        let mut session = group.open(context).expect("opens");
        for case in 0..group.cases.len() {
            let verdict = session.verify(case).expect("a verdict");
            assert_eq!(verdict.status, Status::Skipped);
            assert!(session.sample(case).is_err());
        }
    }
}
