// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: interfaces × image sizes, in one group. Each reads a globe, whose depth follows from a formula.

use crate::metrics::{API, BYTES, CPU, METRICS, RATE, SIZE_PX, WALL};
use crate::{STUDY, chapter::CHAPTER};
use std::hash::{DefaultHasher, Hasher as _};
use terrafill_conformance::{globe_mismatch, rolled_globe};
use terrafill_contract::{CpuStopwatch, Picture, SurfaceInterface, SurfaceTargets};
use terrafill_results::{ConditionKey, Verdict};
use terrafill_scene::ImageSize;
use terrafill_study::{
    Context, Depth, Failure, Figures, Planned, Request, Study, StudyError, Trial, judged, trials,
};

/// Interfaces in the order in which they are reported.
const INTERFACES: [SurfaceInterface; 2] = [terrafill_gpu::SURFACES, terrafill_vulkan::SURFACES];

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
        metrics: METRICS,
        conditions: crate::metrics::CONDITIONS,
        least_depth: Full,
        chapter: CHAPTER,
    );

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let is_quick = request.depth == Depth::Quick;
        let sizes = &SIZES[..if is_quick { QUICK_SIZES } else { SIZES.len() }];
        let reads = INTERFACES.iter().flat_map(|&interface| {
            let of_side = move |&side: &u32| ReadBack { interface, side };
            sizes.iter().map(of_side)
        });
        let samples = request.samples.unwrap_or(SAMPLES);
        let group = trials(STUDY, STUDY.to_owned(), samples, reads.collect());
        Ok(Planned {
            groups: vec![Box::new(group)],
            ..Planned::default()
        })
    }
}

/// An image of so many pixels a side, through an interface.
struct ReadBack {
    interface: SurfaceInterface,
    side: u32,
}

impl Trial for ReadBack {
    /// Targets that hold the globe, and the fingerprint of the picture that was verified.
    type Opened = (Box<dyn SurfaceTargets>, u64);

    fn conditions(&self) -> Vec<(ConditionKey, String)> {
        let api = self.interface.api.name.to_owned();
        vec![(API, api), (SIZE_PX, self.side.to_string())]
    }

    /// Draws the globe and reads it twice.
    fn verify(&self, context: Context<'_>) -> Result<(Self::Opened, Verdict), Failure> {
        let [width, height] = [self.side; 2];
        let input = rolled_globe(ImageSize { width, height }).map_err(Failure::broken)?;
        let mut targets = (self.interface.open)(context.devices, input.size)?;
        targets.prepare((&input).into())?;
        targets.draw_surface()?;
        let (first, second) = (targets.read()?, targets.read()?);
        let verified = fingerprint(&first);
        let is_same = fingerprint(&second) == verified;
        let others = || "read twice, the same targets gave different bytes".to_owned();
        let wrong = globe_mismatch(&first, &input).or_else(|| (!is_same).then(others));
        let figures = vec![(BYTES.name, byte_count(&first))];
        let verdict = judged(wrong.unwrap_or_default(), figures, Vec::new());
        Ok(((targets, verified), verdict))
    }

    fn time(&self, (targets, verified): &mut Self::Opened) -> Result<Figures, Failure> {
        let watch = CpuStopwatch::start();
        let read = targets.read();
        let (cpu_ms, wall_ms) = (watch.cpu_ms(), watch.wall_ms());
        let picture = read?;
        if fingerprint(&picture) != *verified {
            let why = "it read different bytes than when it was verified";
            return Err(Failure::broken(why));
        }
        let rate = byte_count(&picture) * 1e-3 / wall_ms;
        Ok(vec![
            (CPU.name, cpu_ms),
            (WALL.name, wall_ms),
            (RATE.name, rate),
        ])
    }
}

/// Of all bytes of a picture.
fn fingerprint(picture: &Picture) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(&picture.rgba);
    hasher.write(bytemuck::cast_slice(&picture.depth));
    hasher.finish()
}

/// Bytes of colour and depth.
fn byte_count(picture: &Picture) -> f64 {
    (picture.rgba.len() + size_of_val(picture.depth.as_slice())) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use std::rc::Rc;
    use terrafill_contract::{Devices, device_for_test};
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
        let size = ImageSize::new(1, 1);
        for interface in INTERFACES {
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
            if !case.is_repeat() {
                assert_eq!(case.value("readback_bytes"), Some(bytes), "{name}");
            }
        }
        let blocks = CHAPTER.blocks(&run).expect("a chapter");
        assert!(blocks.iter().any(|block| matches!(block, Block::Plot(_))));
    }

    #[test]
    fn a_device_gives_the_globe_back_and_one_byte_is_another_picture() {
        // Odd, so that rows are padded.
        let size = ImageSize::new(101, 67);
        let input = rolled_globe(size).expect("a surface");
        for interface in INTERFACES {
            let opened = (interface.open)(&Devices::default(), size);
            let Some(mut targets) = device_for_test(opened) else {
                continue;
            };
            targets.prepare((&input).into()).expect("uploads");
            targets.draw_surface().expect("draws");
            let right = targets.read().expect("read");
            assert_eq!(globe_mismatch(&right, &input), None);
            assert_eq!(byte_count(&right), 101.0 * 67.0 * 8.0);
            // Negative controls: rows from below, and a byte of a colour.
            let mut other = right.clone();
            other.depth.reverse();
            assert!(globe_mismatch(&other, &input).is_some());
            let mut other = right.clone();
            other.rgba[0] += 1;
            assert_ne!(fingerprint(&other), fingerprint(&right));
            assert_eq!(fingerprint(&right.clone()), fingerprint(&right));
        }
    }

    #[test]
    fn a_missing_device_and_a_size_beyond_its_limit_are_skipped_with_the_reason() {
        let folder = tempfile::tempdir().expect("a folder");
        let none = Devices::new(Some("no such adapter".to_owned()));
        let run = measure(&folder.path().join("run"), none);
        for case in run.cases.iter().filter(|case| !case.is_repeat()) {
            assert_eq!(case.outcome, Outcome::Skipped, "{}", case.reason);
            assert!(!case.reason.is_empty());
        }
        let devices = Rc::new(Devices::default());
        let too_large = INTERFACES.map(|interface| ReadBack {
            interface,
            side: 1 << 20,
        });
        let group = trials(STUDY, STUDY.to_owned(), 1, too_large.into());
        let context = Context {
            devices: &devices,
            folder: folder.path(),
        };
        let mut session = group.open(context).expect("opens");
        for case in 0..group.cases.len() {
            let verdict = session
                .verify(case)
                .or_else(Failure::verdict)
                .expect("a verdict");
            assert_eq!(verdict.status, Status::Skipped);
            assert!(session.time(case).is_err());
        }
    }
}
