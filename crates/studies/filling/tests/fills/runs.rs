// SPDX-License-Identifier: MIT OR Apache-2.0
//! Runs of a study in a folder, as small as they can be.

use std::path::Path;
use std::rc::Rc;
use terrafill_contract::Devices;
use terrafill_results::{Metric, Run, RunEnvironment, RunFolder, SCHEMA};
use terrafill_study::{Plan, Request, RunOptions, Silent, Study, plan, run};

pub(crate) const OPTIONS: RunOptions = RunOptions {
    processes: 1,
    process: 0,
    warm_up: 0,
    seed: 1,
    shard: None,
};

/// Whether runs can be made here; says why not.
pub(crate) fn has_device() -> bool {
    terrafill_gpu::open_for_test(&Default::default()).is_some()
}

pub(crate) fn environment() -> RunEnvironment {
    RunEnvironment {
        schema: SCHEMA,
        ..RunEnvironment::default()
    }
}

/// A run in a folder that is there.
pub(crate) fn measure(plan: &Plan, folder: &RunFolder) -> Run {
    let devices = Rc::new(Devices::default());
    run(plan, folder, &devices, &OPTIONS, &mut Silent).expect("measured");
    Run::load(folder.path()).expect("a run")
}

/// A run in a new folder.
pub(crate) fn measured(
    study: &dyn Study,
    metrics: &[Metric],
    out: &Path,
    request: &Request,
) -> Run {
    let plan = plan(&[study], request, &OPTIONS).expect("planned");
    let folder = RunFolder::create(out, environment(), plan.run_plan().clone(), metrics);
    measure(&plan, &folder.expect("a new folder"))
}
