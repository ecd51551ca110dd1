// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: interfaces × image sizes, in one group.

use crate::api::{INTERFACES, Interface, Readable};
use crate::globe::{byte_count, check, fingerprint, globe};
use crate::keys::{API, SIZE_PX};
use crate::metrics::METRICS;
use crate::{STUDY, chapter::ReadbackChapter};
use std::collections::BTreeMap;
use terrafill_fill::{CpuStopwatch, DeviceError, FillInput, Picture};
use terrafill_results::{CaseId, Chapter, ConditionKey, Metric, PlannedCase, Status, Verdict};
use terrafill_scene::ImageSize;
use terrafill_study::{Context, Depth, Group, Planned, Request, Session, Study, StudyError};

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
    fn name(&self) -> &'static str {
        STUDY
    }

    fn question(&self) -> &'static str {
        "How long does reading an image back take, and at which rate?"
    }

    fn metrics(&self) -> &'static [Metric] {
        &METRICS
    }

    fn conditions(&self) -> Vec<ConditionKey> {
        crate::keys::CONDITIONS.to_vec()
    }

    fn least_depth(&self) -> Depth {
        Depth::Full
    }

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let is_quick = request.depth == Depth::Quick;
        let sizes = &SIZES[..if is_quick { QUICK_SIZES } else { SIZES.len() }];
        let samples = request.samples.unwrap_or(SAMPLES);
        Ok(Planned {
            groups: vec![Box::new(Readings::new(sizes, samples))],
            skipped: Vec::new(),
        })
    }

    fn chapter(&self) -> &dyn Chapter {
        &ReadbackChapter
    }
}

/// Every interface and size.
struct Readings {
    readings: Vec<(Interface, ImageSize)>,
    cases: Vec<PlannedCase>,
}

impl Readings {
    fn new(sizes: &[u32], samples: u32) -> Self {
        let square = |&side: &u32| ImageSize {
            width: side,
            height: side,
        };
        let of = |interface| sizes.iter().map(move |side| (interface, square(side)));
        let readings: Vec<(Interface, ImageSize)> = INTERFACES.into_iter().flat_map(of).collect();
        let case = |(interface, size): &(Interface, ImageSize)| {
            let (api, side) = (interface.api.name, size.width);
            PlannedCase {
                id: CaseId::new(
                    STUDY,
                    format!("{api}/{side}"),
                    [(API, api.to_owned()), (SIZE_PX, side.to_string())],
                ),
                samples,
                may_be_wrong: false,
            }
        };
        Self {
            cases: readings.iter().map(case).collect(),
            readings,
        }
    }
}

impl Group for Readings {
    fn name(&self) -> String {
        STUDY.to_owned()
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.cases
    }

    fn open<'a>(&'a self, context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        Ok(Box::new(ReadingsSession {
            readings: &self.readings,
            context,
            drawn: BTreeMap::new(),
        }))
    }
}

/// Targets that hold the globe.
struct Drawn {
    targets: Box<dyn Readable>,
    /// Of the picture that was verified.
    fingerprint: u64,
}

struct ReadingsSession<'a> {
    readings: &'a [(Interface, ImageSize)],
    context: Context<'a>,
    /// By case.
    drawn: BTreeMap<usize, Drawn>,
}

impl ReadingsSession<'_> {
    /// Draws the globe and reads it twice.
    fn draw(&self, case: usize, input: &FillInput) -> Result<DrawnAndRead, DeviceError> {
        let (interface, size) = self.readings[case];
        let mut targets = (interface.open)(self.context.devices, size)?;
        targets.draw(input)?;
        let pictures = [targets.read()?, targets.read()?];
        Ok((targets, pictures))
    }
}

type DrawnAndRead = (Box<dyn Readable>, [Picture; 2]);

impl Session for ReadingsSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        let (interface, size) = self.readings[case];
        let input = globe(size).map_err(|error| StudyError::Broken {
            place: format!("{STUDY}/{}/{}", interface.api.name, size.width),
            message: error.to_string(),
        })?;
        let (targets, [first, second]) = match self.draw(case, &input) {
            Ok(drawn) => drawn,
            Err(error) => return Ok(verdict_of(&error)),
        };
        let figures = vec![("readback_bytes", byte_count(&first) as f64)];
        let (status, reason) = match check([&first, &second], &input) {
            Ok(()) => (Status::Ok, String::new()),
            Err(reason) => (Status::Wrong, reason),
        };
        let fingerprint = fingerprint(&first);
        let drawn = Drawn {
            targets,
            fingerprint,
        };
        self.drawn.insert(case, drawn);
        Ok(Verdict {
            status,
            reason,
            figures,
            notes: Vec::new(),
        })
    }

    fn sample(&mut self, case: usize) -> Result<Vec<(&'static str, f64)>, String> {
        let drawn = self.drawn.get(&case).ok_or("it was not verified")?;
        let watch = CpuStopwatch::start();
        let read = drawn.targets.read();
        let (cpu_ms, wall_ms) = (watch.cpu_ms(), watch.wall_ms());
        let picture = read.map_err(|error| error.to_string())?;
        if fingerprint(&picture) != drawn.fingerprint {
            return Err("it read different bytes than when it was verified".to_owned());
        }
        let megabytes = byte_count(&picture) as f64 * 1e-6;
        Ok(vec![
            ("readback_cpu_ms", cpu_ms),
            ("readback_wall_ms", wall_ms),
            ("readback_rate", megabytes / (wall_ms * 1e-3)),
        ])
    }
}

/// A device or a size that is missing is no defect.
fn verdict_of(error: &DeviceError) -> Verdict {
    match error {
        DeviceError::Unsupported { .. } => Verdict::skipped(error.to_string()),
        _ => Verdict::failed(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use std::rc::Rc;
    use terrafill_fill::{Devices, device_for_test};
    use terrafill_results::{Block, Outcome, Run, RunEnvironment, RunFolder, SCHEMA};
    use terrafill_study::{RunOptions, Silent, plan, run};

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
        for interface in INTERFACES {
            let size = ImageSize {
                width: 1,
                height: 1,
            };
            let opened = (interface.open)(&Devices::default(), size);
            if device_for_test(opened).is_none() {
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
        let blocks = ReadbackChapter.blocks(&run).expect("a chapter");
        let Some(Block::Text(sentence)) = blocks.first() else {
            panic!("a sentence: {blocks:?}");
        };
        assert!(sentence.contains("wgpu") && sentence.contains("vulkan"));
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
        let group = Readings::new(&[1 << 20], 1);
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
        // Twin: a device that breaks is a defect.
        let lost = verdict_of(&DeviceError::DeviceLost("gone".to_owned()));
        assert_eq!(lost.status, Status::Failed);
    }
}
