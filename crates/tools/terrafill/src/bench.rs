// SPDX-License-Identifier: MIT OR Apache-2.0
//! `bench` and `report`.

use crate::arguments::{BenchArguments, GROWTH_SAMPLE, GrowthSampleArguments, ReportArguments};
use crate::registry::SURFACES;
use crate::{Failure, Outcome, print};
use std::path::Path;
use terrafill_filling::{BenchError, BenchOptions, GrowthProgram};
use terrafill_report::write_report;
use terrafill_results::legacy::RunFolder;
use terrafill_scene::{ImageSize, data_dir_from_env};

pub(crate) fn run(arguments: BenchArguments) -> Result<Outcome, Failure> {
    let options = BenchOptions {
        surfaces: SURFACES,
        scenes: arguments.scenes,
        backends: arguments.backend,
        quick: arguments.quick,
        out: arguments.out,
        resume: arguments.resume,
        data_dir: arguments.data.or_else(data_dir_from_env),
        frames: arguments.frames,
        size: ImageSize {
            width: arguments.size.0,
            height: arguments.size.1,
        },
        shard: arguments.shard,
        adapter: arguments.adapter,
        ladder: (!arguments.ladder.is_empty()).then_some(arguments.ladder),
        matrix: (!arguments.matrix.is_empty()).then_some(arguments.matrix),
        precision: match (arguments.precision, arguments.no_precision) {
            (true, _) => Some(true),
            (_, true) => Some(false),
            _ => None,
        },
    };
    let this = GrowthProgram {
        path: std::env::current_exe().map_err(Failure::bad_input)?,
        verb: GROWTH_SAMPLE,
    };
    let outcome = terrafill_filling::run_with_growth_program(&options, &this);
    let outcome = outcome.map_err(|error| match error {
        BenchError::NoDevice(_) | BenchError::Device { .. } => Failure::no_device(error),
        _ => Failure::bad_input(error),
    })?;
    for (scene, why) in &outcome.skipped_scenes {
        eprintln!("skipped: {scene}: {why}");
    }
    if outcome == Default::default() {
        eprintln!("nothing was measured");
        return Ok(Outcome::NothingMeasured);
    }
    print(&format!(
        "{} right, {} wrong, {} failed, {} skipped; in sweeps {} wrong on purpose\n",
        outcome.ok, outcome.wrong, outcome.failed, outcome.skipped, outcome.wrong_in_sweep
    ));
    print_report(&options.out)?;
    Ok(match outcome {
        _ if outcome.wrong + outcome.failed > 0 => Outcome::Regression,
        _ if outcome.ok == 0 => Outcome::NothingMeasured,
        _ => Outcome::Done,
    })
}

pub(crate) fn growth_sample(arguments: &GrowthSampleArguments) -> Result<Outcome, Failure> {
    let sample = terrafill_filling::growth_sample(&arguments.file);
    print(&sample.map_err(Failure::bad_input)?);
    Ok(Outcome::Done)
}

pub(crate) fn report(arguments: &ReportArguments) -> Result<Outcome, Failure> {
    print_report(&arguments.run)?;
    Ok(Outcome::Done)
}

fn print_report(run: &Path) -> Result<(), Failure> {
    let summary = write_report(run).map_err(Failure::bad_input)?;
    if summary.missing > 0 {
        let folder = RunFolder::open(run).map_err(Failure::bad_input)?;
        eprintln!("{} planned cases are missing:", summary.missing);
        for case in folder.missing().map_err(Failure::bad_input)? {
            eprintln!("  {case}");
        }
    }
    print(&format!("report: {}\n", summary.path.display()));
    Ok(())
}
