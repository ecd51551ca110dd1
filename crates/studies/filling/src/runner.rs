// SPDX-License-Identifier: MIT OR Apache-2.0
//! The run: `scenes → meshes → FrameInput → reference and backends → figures → samples → CSV`.

use crate::group::GroupRun;
use crate::scenes::{SkippedScenes, plan_groups};
use crate::{BenchCase, BenchError, BenchOptions, SceneGroup, environment};
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use std::rc::Rc;
use terrafill_fill::Devices;
use terrafill_gpu::shared_gpu;
use terrafill_results::legacy::{
    CaseKey, LadderRung, RunEnvironment, RunError, RunFolder, RunPlan, Status, Summary,
};

/// What a run came to.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct BenchOutcome {
    /// Cases whose picture is right, baselines not counted.
    pub ok: usize,
    /// Cases whose picture is wrong, sweeps not counted.
    pub wrong: usize,
    /// Points of a sweep whose picture is wrong: their error is what the sweep shows.
    pub wrong_in_sweep: usize,
    /// Cases that broke off.
    pub failed: usize,
    /// Cases that the device cannot run.
    pub skipped: usize,
    /// Scenes left out, with the reason.
    pub skipped_scenes: Vec<(String, String)>,
}

/// Runs what `options` ask for.
///
/// # Errors
/// [`BenchError`] for wrong input, no device, or a folder that cannot be written. What was measured
/// before stays.
pub fn run(options: &BenchOptions) -> Result<BenchOutcome, BenchError> {
    let names: Vec<&str> = options.techniques.iter().map(|t| t.name()).collect();
    for backend in &options.backends {
        if !names.contains(&backend.as_str()) {
            return Err(BenchError::UnknownBackend {
                found: backend.clone(),
                allowed: names.join(", "),
            });
        }
    }
    let (groups, skipped_scenes) = plan_groups(options)?;
    let devices = Rc::new(Devices::new(options.adapter.clone()));
    let gpu = shared_gpu(&devices).map_err(BenchError::NoDevice)?;
    let plan = RunPlan {
        cases: groups
            .iter()
            .flat_map(|group| group.cases.iter().map(|case| case.key.clone()))
            .collect(),
        drawn_only: groups
            .iter()
            .flat_map(|group| group.cases.iter().filter(|case| case.frames == 0))
            .map(|case| case.key.clone())
            .collect(),
        skipped_scenes: skipped_scenes.clone(),
        frames: options.frame_count(),
        warm_up: options.warm_up_count(),
    };
    let environment = environment(&gpu.facts, options);
    let folder = if options.resume {
        refuse_other_setup(&RunFolder::open(&options.out)?, &environment)?;
        RunFolder::resume(&options.out, &plan)?
    } else {
        RunFolder::create(&options.out, &environment, &plan)?
    };
    let ladder: Vec<LadderRung> = groups.iter().flat_map(|g| g.ladder.clone()).collect();
    folder.write_ladder(&ladder)?;
    let missing = folder.missing()?;
    let progress = progress_bar(&plan, &missing);
    for group in &groups {
        let is_done = group.cases.iter().all(|case| !missing.contains(&case.key));
        if !is_done {
            GroupRun::new(&devices, options, &folder, group, &progress)?.run(&missing)?;
        }
    }
    progress.finish_and_clear();
    Ok(outcome(&groups, &folder.summaries()?, skipped_scenes))
}

/// Rows of a run are compared with one another, so the rest of it is measured in the same way. The
/// plan does not hold all of that: size, device, driver, shaders and code are in the environment.
fn refuse_other_setup(folder: &RunFolder, now: &RunEnvironment) -> Result<(), RunError> {
    let then = folder.environment()?;
    // Whether the tree is clean changes with every edit, also of a text that nothing runs.
    let commit = |of: &RunEnvironment| of.commit.trim_end_matches("+dirty").to_owned();
    let aspects: [(&str, String, String); 6] = [
        ("options", then.options.join(" "), now.options.join(" ")),
        ("device", then.gpu.clone(), now.gpu.clone()),
        ("driver", then.driver_info.clone(), now.driver_info.clone()),
        (
            "shader hash",
            then.shader_hash.clone(),
            now.shader_hash.clone(),
        ),
        ("profile", then.profile.clone(), now.profile.clone()),
        ("commit", commit(&then), commit(now)),
    ];
    match aspects.into_iter().find(|(_, then, now)| then != now) {
        None => Ok(()),
        Some((what, then, now)) => Err(RunError::Occupied {
            path: folder.path().to_owned(),
            message: format!("cannot resume with {what} {now:?}, it was begun with {then:?}"),
        }),
    }
}

fn progress_bar(plan: &RunPlan, missing: &[CaseKey]) -> ProgressBar {
    let bar = ProgressBar::new(plan.cases.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} cases · {eta} · {msg}")
    {
        bar.set_style(style);
    }
    bar.set_position((plan.cases.len() - missing.len()) as u64);
    bar
}

fn outcome(
    groups: &[SceneGroup],
    summaries: &[Summary],
    skipped_scenes: SkippedScenes,
) -> BenchOutcome {
    let cases: BTreeMap<&CaseKey, &BenchCase> = groups
        .iter()
        .flat_map(|group| group.cases.iter().map(|case| (&case.key, case)))
        .collect();
    let mut outcome = BenchOutcome {
        skipped_scenes,
        ..BenchOutcome::default()
    };
    for summary in summaries {
        let Some(case) = cases.get(&summary.key()) else {
            continue;
        };
        match summary.status {
            _ if case.roles.baseline => {}
            Status::Ok => outcome.ok += 1,
            Status::Wrong if case.roles.sweep => outcome.wrong_in_sweep += 1,
            Status::Wrong => outcome.wrong += 1,
            Status::Failed => outcome.failed += 1,
            Status::Skipped => outcome.skipped += 1,
        }
    }
    outcome
}
