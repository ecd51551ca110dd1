// SPDX-License-Identifier: MIT OR Apache-2.0
//! `gate` and `bless`.

use crate::arguments::{BlessArguments, GateArguments, SelfTestKind};
use crate::data::data_dirs;
use crate::draft;
use crate::outcome::{Failure, Outcome, print};
use crate::registry::{STUDIES, chapters};
use crate::stop::clear_when_stopped;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::io::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};
use terrafill_gate::threshold::{SETUP_FLOOR_PERCENT, WALL_FLOOR_PERCENT};
use terrafill_gate::{
    Blessing, Finding, GateError, GateOptions, GateReport, GateShard, GatedTime, Injection, Job,
    Program, Proof, Rules, SelfTest, Side, Workload, add_blessings, annotations, carry_scenes,
    load_baseline, markdown, matches, prune_blessings, read_blessings, read_json, read_limits,
    refuse_equal_programs, save_baseline, self_test, shipped_limits, text, write_files,
};
use terrafill_results::{Clock, Run};
use terrafill_scene::{
    ImageSize, choices, shipped_scene_names, shipped_scene_text, split_data_dirs,
};

/// Timed samples of a case in each process, of one frame each: the median of 30 frames is not moved by
/// those that were held up.
const SAMPLES: u32 = 30;

/// Shortest time between two lines of progress. Programs speak every 25 s at least, so that no silence
/// is longer than that where this is shorter.
const MIN_SILENCE: Duration = Duration::from_secs(15);

impl From<GateError> for Failure {
    fn from(error: GateError) -> Self {
        Self {
            outcome: Outcome::from_code(error.exit_code()),
            message: error.to_string(),
        }
    }
}

/// The metric that a study is ranked by.
pub(crate) fn primary(study: &str, clock: Clock) -> Option<&'static str> {
    let chapters = chapters();
    let chapter = chapters.iter().find(|chapter| chapter.study() == study)?;
    chapter.primary_metric(clock)
}

/// The times of a study that are compared, by what they cover.
fn gated(study: &str, clock: Clock) -> Vec<GatedTime> {
    let study = STUDIES.iter().find(|known| known.name() == study);
    study.map_or_else(Vec::new, |study| {
        GatedTime::of(study.metrics(), study.chapter().primary_metric(clock))
    })
}

/// Says what is being done, now and then.
struct Talk(Option<Instant>);

impl Talk {
    fn say(&mut self, what: &str) {
        if self.0.is_none_or(|last| last.elapsed() >= MIN_SILENCE) {
            eprintln!("gate: {what}");
            self.0 = Some(Instant::now());
        }
    }
}

pub(crate) fn run(arguments: &GateArguments) -> Result<Outcome, Failure> {
    let (width, height) = arguments.size;
    // Regions of a file become one scene file, which both sides read; where the base runs does not matter.
    let scenes = draft::written(
        &arguments.scenes,
        &arguments.own,
        ImageSize { width, height },
        &std::path::absolute(&arguments.cache).map_err(Failure::bad_input)?,
        true,
    )?;
    let arguments = &GateArguments {
        scenes,
        ..arguments.clone()
    };
    let mut limits = shipped_limits()?;
    if let Some(path) = &arguments.limits {
        limits.extend(read_limits(path)?);
    }
    let blessings = read_blessings(&arguments.blessed)?;
    let rules = Rules {
        limits: &limits,
        blessings: &blessings,
    };
    if arguments.shard.is_some() && (arguments.base.is_none() || arguments.self_test.is_some()) {
        let message = "--shard needs --base: both programs run over each part";
        return Err(Failure::bad_input(message));
    }
    if let Some(kind) = arguments.self_test {
        return prove(arguments, kind);
    }
    // An answer of an earlier gate must not be taken for this one's.
    drop(std::fs::remove_file(arguments.out.join("gate.json")));
    let report = match (&arguments.base, &arguments.base_run, &arguments.baseline) {
        (Some(base), None, None) => Some(two_programs(arguments, base, &rules)?),
        (None, Some(base), None) => {
            let base = load(base)?;
            Some(against(arguments, &base, &rules)?)
        }
        (None, None, Some(name)) => {
            let new = new_run(arguments)?;
            let base = load_baseline(&new, &arguments.baselines, name)?;
            let names = [format!("baseline {name}"), new.path.display().to_string()];
            Some(GateReport::of_runs(names, &base, &new, &rules)?)
        }
        (None, None, None) => None,
        _ => {
            let message = "give one of --base, --base-run and --baseline";
            return Err(Failure::bad_input(message));
        }
    };
    let outcome = match &report {
        Some(report) => finish(report, &arguments.out)?,
        None if arguments.save_baseline.is_some() => Outcome::Done,
        None => {
            let message = "nothing to compare with: give --base, --base-run or --baseline";
            return Err(Failure::bad_input(message));
        }
    };
    if let Some(name) = &arguments.save_baseline {
        let new = match &report {
            Some(_) => load(&last_run(arguments))?,
            None => new_run(arguments)?,
        };
        let place = save_baseline(&new, &arguments.baselines, name)?;
        print(format!("saved: {}\n", place.display()))?;
    }
    Ok(outcome)
}

fn load(path: &Path) -> Result<Run, Failure> {
    Run::load(path).map_err(Failure::bad_input)
}

/// Where the new side's run is once a gate has ended.
fn last_run(arguments: &GateArguments) -> std::path::PathBuf {
    let own = || arguments.out.join(Side::New.name());
    arguments.new_run.clone().unwrap_or_else(own)
}

fn against(
    arguments: &GateArguments,
    base: &Run,
    rules: &Rules<'_>,
) -> Result<GateReport, Failure> {
    let Some(new) = &arguments.new_run else {
        let message = "--base-run needs --new-run: times of two jobs are not compared";
        return Err(Failure::bad_input(message));
    };
    let new = load(new)?;
    let names = [&base.path, &new.path].map(|path| path.display().to_string());
    Ok(GateReport::of_runs(names, base, &new, rules)?)
}

/// The new side's run folder: as given, or measured now.
fn new_run(arguments: &GateArguments) -> Result<Run, Failure> {
    if let Some(path) = &arguments.new_run {
        return load(path);
    }
    let new = new_program(arguments)?;
    let mut talk = Talk(None);
    let mut say = |what: &str| talk.say(what);
    let workload = workload(arguments, &arguments.scenes, false)?;
    let programs = [new.clone(), new];
    let mut job = Job::new(programs, workload, &arguments.out, &mut say)?;
    Ok(job.verify(Side::New)?)
}

fn new_program(arguments: &GateArguments) -> Result<Program, Failure> {
    let new = if let Some(new) = &arguments.new {
        new.clone()
    } else {
        let this = std::env::current_exe().map_err(Failure::bad_input)?;
        this.display().to_string()
    };
    Ok(Program::find(&new, &arguments.cache)?)
}

fn two_programs(
    arguments: &GateArguments,
    base: &str,
    rules: &Rules<'_>,
) -> Result<GateReport, Failure> {
    if arguments.new_run.is_some() {
        let message = "--base needs --new, not --new-run: times are compared within one job alone";
        return Err(Failure::bad_input(message));
    }
    let part = part(arguments)?;
    clear_when_stopped(&arguments.out)?;
    let base = Program::find(base, &arguments.cache).map_err(GateError::of_machine)?;
    let new = new_program(arguments)?;
    refuse_equal_programs(&base, &new)?;
    let names = [base.label(), new.label()];
    let asked = part.as_ref().map_or(&arguments.scenes, |part| &part.scenes);
    let named = match asked.as_slice() {
        [] => shipped_scene_names()
            .into_iter()
            .map(str::to_owned)
            .collect(),
        some => some.to_vec(),
    };
    // Another program's scenes are not known here.
    let is_this_program = arguments.new.is_none();
    let own = |scene: &str| {
        let text = shipped_scene_text(scene).filter(|_| is_this_program);
        text.map(str::to_owned)
    };
    let carried = carry_scenes([&base, &new], &named, &own, &arguments.cache)?;
    // Where all are meant, and none differs, the programs name theirs.
    let scenes = if carried.carried.is_empty() {
        asked
    } else {
        &carried.scenes
    };
    for name in &carried.carried {
        eprintln!("gate: {name} was edited: both programs run it as the new version has it");
    }
    let mut talk = Talk(None);
    let mut say = |what: &str| talk.say(what);
    let mut job = Job::new(
        [base, new],
        workload(arguments, scenes, !arguments.no_time)?,
        &arguments.out,
        &mut say,
    )?;
    let options = GateOptions {
        times: !arguments.no_time,
        advisory: arguments.advisory_time,
        floors_percent: {
            let usual = [WALL_FLOOR_PERCENT, SETUP_FLOOR_PERCENT, SETUP_FLOOR_PERCENT];
            let [wall, preparation, planning] = arguments.other_floors.unwrap_or(usual);
            [arguments.floor_percent, wall, preparation, planning]
        },
        budget: Duration::from_secs(arguments.time_budget_s),
        is_part: part.is_some(),
    };
    let gated = terrafill_gate::gate(&mut job, names, &options, rules, &gated);
    let mut report = gated.map_err(|error| carried.explain(error))?;
    if part.is_some() {
        let whole = report.compared.iter().find(|case| !is_of(case, scenes));
        if let Some(case) = whole {
            let message = format!("--shard shares scenes out, and {case} is of none of them");
            return Err(Failure::bad_input(message));
        }
    }
    report.part = part;
    Ok(report)
}

/// The scenes of this part of the gate.
fn part(arguments: &GateArguments) -> Result<Option<GateShard>, Failure> {
    let Some(shard) = arguments.shard else {
        return Ok(None);
    };
    let earlier = match &arguments.balance_by {
        Some(folder) => Some(read_json(&folder.join("gate.json"))?),
        None => None,
    };
    let part = GateShard::new(shard, &arguments.scenes, earlier.as_ref())?;
    Ok(Some(part))
}

/// Whether a case is of one of these scenes, which are names or files.
fn is_of(case: &str, scenes: &[String]) -> bool {
    let scene = case.split('/').nth(1).unwrap_or_default();
    let mut names = scenes.iter().map(|scene| Path::new(scene).file_stem());
    names.any(|name| name.is_some_and(|name| name == scene))
}

/// What both sides measure.
fn workload(
    arguments: &GateArguments,
    scenes: &[String],
    is_timed: bool,
) -> Result<Workload, Failure> {
    let mut of_bench: Vec<OsString> = scenes.iter().map(OsString::from).collect();
    let mut option = |name: &str, value: &dyn AsRef<std::ffi::OsStr>| {
        of_bench.push(name.into());
        of_bench.push(value.as_ref().to_owned());
    };
    for study in &arguments.study {
        option("--study", study);
    }
    for technique in &arguments.technique {
        option("--technique", technique);
    }
    let (width, height) = arguments.size;
    option("--size", &format!("{width}x{height}"));
    let data = data_dirs(&arguments.data)?;
    for folder in data.iter().flat_map(|data| split_data_dirs(data)) {
        option("--data", &folder);
    }
    if let Some(adapter) = &arguments.adapter {
        option("--adapter", adapter);
    }
    if !arguments.main {
        of_bench.push("--quick".into());
    }
    Ok(Workload {
        arguments: of_bench,
        samples: if is_timed { SAMPLES } else { 1 },
        frames: 1,
        extra: [0, 0],
    })
}

/// Prints the report, writes its files, and tells GitHub where it runs there.
pub(crate) fn finish(report: &GateReport, out: &Path) -> Result<Outcome, Failure> {
    write_files(report, out)?;
    print(text(report))?;
    print(format!("report: {}\n", out.join("gate.md").display()))?;
    if let Some(path) = std::env::var_os("GITHUB_STEP_SUMMARY") {
        let summary = std::fs::OpenOptions::new()
            .append(true)
            .create(true)
            .open(&path)
            .and_then(|mut file| file.write_all(markdown(report).as_bytes()));
        summary.map_err(|error| Failure::bad_input(format!("GITHUB_STEP_SUMMARY: {error}")))?;
    }
    if std::env::var_os("GITHUB_ACTIONS").is_some() {
        for line in annotations(report) {
            print(format!("{line}\n"))?;
        }
    }
    Ok(Outcome::from_code(report.exit_code))
}

/// Measures how often the time gate is right on this machine.
fn prove(arguments: &GateArguments, kind: SelfTestKind) -> Result<Outcome, Failure> {
    let injection = match kind {
        SelfTestKind::Aa => None,
        SelfTestKind::Inject => {
            let percent = arguments.percent;
            let injection = Injection::percent(percent);
            Some(injection.ok_or_else(|| {
                Failure::bad_input(format!("--percent: found {percent}, allowed: 1 … 100"))
            })?)
        }
    };
    let new = new_program(arguments)?;
    let base = match &arguments.base {
        Some(base) => Program::find(base, &arguments.cache)?,
        None => new.clone(),
    };
    let test = SelfTest {
        injection,
        runs: arguments.runs,
        budget: Duration::from_secs(arguments.time_budget_s),
        floor_percent: arguments.floor_percent,
    };
    let mut talk = Talk(None);
    let proof = self_test(
        &test,
        &[base, new],
        &workload(arguments, &arguments.scenes, true)?,
        &arguments.out,
        &gated,
        &mut |what| talk.say(what),
        &mut |proof: &Proof| eprintln!("gate: {}", proof.sentences(injection).join("; ")),
    )?;
    print(proof.sentences(injection).join("\n") + "\n")?;
    Ok(if proof.is_wrong(injection) {
        Outcome::Regression
    } else {
        Outcome::Done
    })
}

pub(crate) fn bless(arguments: &BlessArguments) -> Result<Outcome, Failure> {
    let report = read_json(&arguments.gate.join("gate.json"))?;
    if arguments.all || !arguments.cases.is_empty() {
        accept(arguments, &report)?;
    }
    if arguments.prune {
        let pruned = prune_blessings(&arguments.blessed, &report)?;
        for Blessing { case, metric, .. } in &pruned {
            print(format!("taken out: {case}, {metric}\n"))?;
        }
        print(format!("{} blessings taken out\n", pruned.len()))?;
    }
    Ok(Outcome::Done)
}

fn accept(arguments: &BlessArguments, report: &GateReport) -> Result<(), Failure> {
    let reason = arguments.reason.as_deref().unwrap_or_default();
    if reason.trim().is_empty() {
        return Err(Failure::bad_input("--reason: found none, needs a sentence"));
    }
    let found: Vec<&Finding> = report.findings.iter().filter(|f| f.counts()).collect();
    let is_named = |pattern: &str, finding: &Finding| {
        let metrics = &arguments.metric;
        matches(pattern, &finding.case) && (metrics.is_empty() || metrics.contains(&finding.metric))
    };
    let everything = ["*".to_owned()];
    let patterns = if arguments.all {
        &everything[..]
    } else {
        &arguments.cases
    };
    for pattern in patterns {
        if !found.iter().any(|finding| is_named(pattern, finding)) {
            let cases: BTreeSet<&str> = found.iter().map(|finding| finding.case.as_str()).collect();
            let cases = choices(pattern, cases);
            let of_metric = match arguments.metric.as_slice() {
                [] => String::new(),
                some => format!(" in {}", some.join(", ")),
            };
            return Err(Failure::bad_input(format!(
                "{}: found no difference of {pattern:?}{of_metric} to bless, there are: {cases}",
                arguments.gate.display()
            )));
        }
    }
    let mut blessings = Vec::new();
    let mut said = String::new();
    for finding in found {
        if !patterns.iter().any(|pattern| is_named(pattern, finding)) {
            continue;
        }
        let (case, sentence) = (&finding.case, finding.sentence());
        match Blessing::of(finding, report.base_commit(), reason) {
            Some(blessing) => {
                blessings.push(blessing);
                said += &format!("blessed: {case}, {sentence}\n");
            }
            None => said += &format!("no change to bless, measure it again: {case}, {sentence}\n"),
        }
    }
    add_blessings(&arguments.blessed, &blessings)?;
    print(said)
}
