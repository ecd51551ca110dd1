// SPDX-License-Identifier: MIT OR Apache-2.0
//! `bench`, `report` and `merge`.

use crate::arguments::{
    BenchArguments, BudgetArguments, GrowthSampleArguments, MergeArguments, ReportArguments,
    Sharing,
};
use crate::clocks::device_clocks;
use crate::data::data_dirs;
use crate::draft;
use crate::environment::environment;
use crate::gate::finish;
use crate::outcome::{Failure, Outcome, complain, print};
use crate::progress::{Said, Timed};
use crate::read::Read;
use crate::registry::{RIVALS, STUDIES, chapters, metrics, metrics_of};
use crate::report::print_report;
use crate::stop::{say_when_stopped, what_is_kept};
use crate::techniques::terms;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::Path;
use std::process::{Command, Stdio};
use std::rc::Rc;
use std::sync::mpsc::Receiver;
use terrafill_contract::Devices;
use terrafill_filling::answer_text;
use terrafill_gpu::shared_gpu;
use terrafill_results::{Budget, Moment, Run, RunFolder, Skipped, append_clocks, read_durations};
use terrafill_scene::{ImageSize, choices};
use terrafill_study::{
    Depth, FramesPerSample, Request, RunOptions, RunOutcome, Settling, Share, Study, StudyError,
    Turn, Turns, plan_shared,
};

/// Processes of a run: fewer than five give no interval.
const PROCESSES: u32 = 5;

/// Processes of a run at most where something is still undecided after [`PROCESSES`]: these narrow an
/// interval to 40 % of what six give. Only what is undecided is measured in them, which takes seconds each.
const MAX_PROCESSES: u32 = 36;

/// Maximum number of looks at a case before a group is timed on hardware. Each group waits, since a GPU rests
/// while the CPU verifies.
const LOOKS: u32 = 40;
/// The same on a software device, which has no clock of its own: once in a process.
const SOFTWARE_LOOKS: u32 = 8;

/// Blocks dropped at the start of each process on hardware: caches and clock rates settle.
const WARM_UP: u32 = 2;
/// The same on a software device: there, that each case has just been drawn to be verified is enough.
/// `--samples 5` shows it. Of 340 fills on lavapipe in five processes, the first block took 1.001 of the fifth's
/// CPU time in the median. Of its samples 5 % lay above 1.24 times it, of the second block's above 1.20.
const SOFTWARE_WARM_UP: u32 = 0;

pub(crate) fn run(arguments: &BenchArguments) -> Result<Outcome, Failure> {
    if arguments.suite.is_some() && !arguments.in_suite {
        return crate::suite::run(arguments);
    }
    let (width, height) = arguments.size();
    let is_first = arguments.process == 0 && !arguments.resume;
    let scenes = draft::written(
        &arguments.scenes,
        &arguments.own,
        ImageSize { width, height },
        &arguments.out,
        is_first,
    )?;
    let arguments = &BenchArguments {
        scenes,
        ..arguments.clone()
    };
    let depth = match (arguments.quick, arguments.full) {
        (true, _) => Depth::Quick,
        (_, true) => Depth::Full,
        _ => Depth::Main,
    };
    let studies = studies(arguments, depth)?;
    let casts = |study: &&dyn Study| study.name() == terrafill_shadows::STUDY;
    if arguments.casters.is_some() && !studies.iter().any(casts) {
        let found: Vec<&str> = studies.iter().map(|study| study.name()).collect();
        return Err(Failure::bad_input(format!(
            "--casters: found --study {}, allowed: {}",
            found.join(", "),
            terrafill_shadows::STUDY
        )));
    }
    let request = request(arguments, depth)?;
    let processes = arguments.processes.unwrap_or(match depth {
        _ if arguments.in_suite => 1,
        Depth::Quick => 1,
        Depth::Main | Depth::Full => PROCESSES,
    });
    let devices = Rc::new(Devices::new(arguments.adapter.clone()));
    let is_software = shared_gpu(&devices).map_or(true, |gpu| gpu.facts.is_software());
    let options = RunOptions {
        processes,
        process: arguments.process,
        warm_up: if is_software {
            SOFTWARE_WARM_UP
        } else {
            WARM_UP
        },
        seed: arguments.seed,
        shard: arguments.shard,
    };
    let frames = FramesPerSample {
        frames: arguments.frames_per_sample,
        extra: arguments.extra_frames,
    };
    let (share, sharing) = share(arguments)?;
    let mut read = (options.process == 0).then(|| Read::of(&request));
    for line in read.iter().filter_map(|read| read.long_input.as_ref()) {
        complain(line);
    }
    let plan = plan_shared(&studies, &request, &options, &share).map_err(failure)?;
    if let Some(read) = &mut read {
        read.add_planned(plan.inputs());
    }
    let mut plan = plan.with_frames(frames);
    if let Some(file) = &arguments.time_only {
        let keys = std::fs::read_to_string(file).map_err(|error| {
            Failure::bad_input(format!("--time-only: {}: {error}", file.display()))
        })?;
        let keys = keys.lines().map(str::to_owned).collect();
        plan = plan.timing_only(keys).map_err(failure)?;
    }
    if options.process == 0 {
        // Whoever did not ask for a rival reads in the report what it takes.
        let is_rival = |skipped: &&Skipped| {
            let mut rivals = RIVALS.iter();
            rivals.any(|rival| skipped.what == format!("technique {}", rival.name()))
        };
        let skipped = plan.run_plan().skipped.iter();
        for skipped in skipped.filter(|skipped| !is_rival(skipped)) {
            complain(format!("skipped: {}: {}", skipped.what, skipped.reason));
        }
        for warning in read.iter().flat_map(|read| &read.warnings) {
            complain(format!("warning: {warning}"));
        }
    }
    if plan.run_plan().cases.is_empty() {
        complain("nothing was measured");
        return Ok(Outcome::NothingMeasured);
    }
    if arguments.stepped && options.process == 0 {
        let message = "--stepped: found process 0, which verifies, allowed: a later --process";
        return Err(Failure::bad_input(message));
    }
    let lines = (options.process > 0 || arguments.in_suite).then(lines_of_first_process);
    let mut described = describe(&studies, &request, &options);
    described.extend(sharing);
    let folder = open_folder(arguments, &studies, &request, described, &plan, &devices)?;
    let plan = plan.with_settling(settling(is_software));
    if options.process == 0 {
        keep(&arguments.budget, &arguments.out)?;
        if let Some(read) = &read {
            read.write(&arguments.out)?;
            if read.long_input.is_some() {
                let run_plan = plan.run_plan();
                complain(format!("{} cases are planned", run_plan.cases.len()));
            }
        }
        say_when_stopped(&arguments.out)?;
        if let Some(line) = first_line(depth, processes, arguments) {
            print(format!("{line}\n"))?;
        }
    }
    note_clocks(arguments, &devices, Moment::Start)?;
    let said = Said::new(options.process, processes, arguments.process_of);
    let mut progress = Timed::new(said, &folder, options.process);
    let ran = match lines {
        Some(lines) if arguments.stepped => {
            let turns = &mut Stepped(lines);
            terrafill_study::run_by_turns(&plan, &folder, &devices, &options, &mut progress, turns)
        }
        _ => terrafill_study::run(&plan, &folder, &devices, &options, &mut progress),
    };
    let timed = progress.end();
    ran.map_err(|error| keeps_what_was_measured(failure(error), arguments))?;
    timed.map_err(Failure::bad_input)?;
    note_clocks(arguments, &devices, Moment::End)?;
    if options.process > 0 || arguments.in_suite {
        return Ok(Outcome::Done);
    }
    drop(devices);
    let further = || -> Result<(), Failure> {
        for process in 1..processes {
            run_process(process, &[])?;
        }
        if depth != Depth::Quick && arguments.processes.is_none() {
            decide(arguments, processes)?;
        }
        Ok(())
    };
    further().map_err(|failure| keeps_what_was_measured(failure, arguments))?;
    let outcome = RunOutcome::of(&arguments.out).map_err(Failure::bad_input)?;
    let driver_fault = match outcome.driver_fault {
        0 => String::new(),
        some => format!("; {some} differ by a known driver fault"),
    };
    let counts = format!(
        "{} right, {} wrong, {} failed, {} skipped; {} wrong where the error is the question{driver_fault}\n",
        outcome.ok, outcome.wrong, outcome.failed, outcome.skipped, outcome.wrong_on_purpose
    );
    let run = Run::load(&arguments.out).map_err(Failure::bad_input)?;
    print_report(
        terrafill_report::write(&arguments.out, &chapters(), terms()),
        &format!("{counts}{}", answer_text(&run)),
        arguments.open,
    )
}

/// Studies by name, or those that belong to a run of this depth.
fn studies(arguments: &BenchArguments, depth: Depth) -> Result<Vec<&'static dyn Study>, Failure> {
    let mut chosen: Vec<&'static dyn Study> = Vec::new();
    // A suite is a study of the same name.
    for name in arguments.study.iter().chain(&arguments.suite) {
        let found = STUDIES.iter().find(|study| study.name() == name);
        let study = found.ok_or_else(|| {
            let allowed = choices(name, STUDIES.iter().map(|study| study.name()));
            Failure::bad_input(format!("--study: found {name:?}, allowed: {allowed}"))
        })?;
        if !chosen.iter().any(|other| other.name() == study.name()) {
            chosen.push(*study);
        }
    }
    if chosen.is_empty() {
        // Who names scenes wants them measured, and not what has nothing to do with any.
        let least = if arguments.scenes.is_empty() {
            depth
        } else {
            depth.min(Depth::Main)
        };
        let belongs = STUDIES.iter().filter(|study| study.least_depth() <= least);
        chosen.extend(belongs);
    }
    Ok(chosen)
}

/// How groups are shared among shards, and the option that every shard of a run has in common: `merge`
/// refuses shards that were shared in another way, or by another run.
fn share(arguments: &BenchArguments) -> Result<(Share, Option<String>), Failure> {
    match &arguments.shard_by {
        Sharing::Turns => Ok((Share::Turns, None)),
        Sharing::Hash => Ok((Share::Hash, Some("shard-by=hash".to_owned()))),
        Sharing::Duration(run) => {
            let rows = read_durations(run).map_err(Failure::bad_input)?;
            if rows.is_empty() {
                let run = run.display();
                return Err(Failure::bad_input(format!(
                    "--shard-by: found no durations.csv in {run}, needs a run of this version"
                )));
            }
            let mut seconds: BTreeMap<String, f64> = BTreeMap::new();
            for row in rows {
                *seconds.entry(row.first_case).or_default() += row.seconds;
            }
            let text = format!("{seconds:?}");
            let mark = format!("shard-by=duration:{:016x}", fingerprint(&text));
            Ok((Share::Durations(seconds), Some(mark)))
        }
    }
}

/// Tells texts apart (FNV-1a; Fowler, Noll and Vo, 1991).
fn fingerprint(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// How long processes wait for a steady clock.
fn settling(is_software: bool) -> Settling {
    Settling {
        max_looks: if is_software { SOFTWARE_LOOKS } else { LOOKS },
        each_group: !is_software,
    }
}

/// How many processes a run takes, and what they can say; nothing where whoever measures said how many.
fn first_line(depth: Depth, processes: u32, arguments: &BenchArguments) -> Option<String> {
    if arguments.processes.is_some() || arguments.in_suite {
        return None;
    }
    Some(match depth {
        Depth::Quick => "a quick run takes one process and decides nothing".to_owned(),
        Depth::Main | Depth::Full => format!(
            "{processes} processes, each one replicate; what is undecided then takes more, {MAX_PROCESSES} at most"
        ),
    })
}

fn request(arguments: &BenchArguments, depth: Depth) -> Result<Request, Failure> {
    let mut request = Request {
        scenes: arguments.scenes.clone(),
        techniques: arguments.technique.clone(),
        depth,
        samples: arguments.samples,
        size: arguments.size().into(),
        names_size: arguments.size.is_some(),
        data_dir: data_dirs(&arguments.data)?,
        ..Request::default()
    };
    let casters = arguments.casters.iter().cloned().collect();
    for (key, values) in [
        ("ablation", &arguments.ablation),
        ("matrix", &arguments.matrix),
        ("casters", &casters),
    ] {
        if !values.is_empty() {
            request.settings.insert(key.to_owned(), values.clone());
        }
    }
    Ok(request)
}

/// The run's options as `key=value`: a run is resumed with the same ones only.
fn describe(studies: &[&dyn Study], request: &Request, options: &RunOptions) -> Vec<String> {
    let names: Vec<&str> = studies.iter().map(|study| study.name()).collect();
    let mut lines = vec![
        format!("studies={}", names.join("+")),
        format!("depth={:?}", request.depth).to_lowercase(),
        format!("processes={}", options.processes),
        format!("seed={}", options.seed),
        format!("size={}x{}", request.size[0], request.size[1]),
    ];
    if let Some(samples) = request.samples {
        lines.push(format!("samples={samples}"));
    }
    for (key, values) in [
        ("scenes", &request.scenes),
        ("techniques", &request.techniques),
    ]
    .into_iter()
    .chain(
        request
            .settings
            .iter()
            .map(|(key, values)| (key.as_str(), values)),
    ) {
        if !values.is_empty() {
            lines.push(format!("{key}={}", values.join("+")));
        }
    }
    if let Some(shard) = options.shard {
        lines.push(format!("shard={}/{}", shard.index, shard.count));
    }
    lines
}

fn open_folder(
    arguments: &BenchArguments,
    studies: &[&dyn Study],
    request: &Request,
    mut described: Vec<String>,
    plan: &terrafill_study::Plan,
    devices: &Devices,
) -> Result<RunFolder, Failure> {
    // Without the device that a study needs, no folder is begun.
    let gpu = match shared_gpu(devices) {
        Ok(gpu) => Some(gpu),
        Err(error) if studies.iter().any(|study| study.needs_device()) => {
            return Err(Failure::no_device(error));
        }
        Err(_) => None,
    };
    let facts = gpu.as_ref().map(|gpu| &gpu.facts);
    if (arguments.frames_per_sample, arguments.extra_frames) != (1, 0) {
        let (frames, extra) = (arguments.frames_per_sample, arguments.extra_frames);
        described.push(format!("frames={frames}+{extra}"));
    }
    let environment = environment(facts, request.size, described);
    let (path, run_plan) = (&arguments.out, plan.run_plan());
    if arguments.process > 0 || arguments.resume {
        return RunFolder::resume(path, &environment, run_plan).map_err(Failure::bad_input);
    }
    RunFolder::create(path, environment, run_plan.clone(), &metrics_of(run_plan))
        .map_err(Failure::bad_input)
}

/// Writes down at which clocks the device runs now.
fn note_clocks(
    arguments: &BenchArguments,
    devices: &Devices,
    moment: Moment,
) -> Result<(), Failure> {
    let gpu = shared_gpu(devices).ok();
    let facts = gpu.as_ref().map(|gpu| &gpu.facts);
    let rows = device_clocks(facts, arguments.process, moment);
    append_clocks(&arguments.out, &rows).map_err(Failure::bad_input)
}

/// Measures what chapters cannot decide yet in further processes, until they can or there are
/// [`MAX_PROCESSES`].
fn decide(arguments: &BenchArguments, processes: u32) -> Result<(), Failure> {
    for process in processes..MAX_PROCESSES {
        let run = Run::load(&arguments.out).map_err(Failure::bad_input)?;
        let undecided: Vec<String> = chapters()
            .iter()
            .flat_map(|chapter| chapter.undecided(&run))
            .collect();
        if undecided.is_empty() {
            break;
        }
        complain(format!(
            "process {} of {MAX_PROCESSES} at most: {} cases once more, of which something is undecided",
            process + 1,
            undecided.len()
        ));
        let file = arguments.out.join("undecided.txt");
        std::fs::write(&file, undecided.join("\n")).map_err(Failure::bad_input)?;
        let bound = format!("--process-of={MAX_PROCESSES}");
        let more = ["--time-only".as_ref(), file.as_os_str(), bound.as_ref()];
        run_process(process, &more)?;
        std::fs::remove_file(&file).map_err(Failure::bad_input)?;
    }
    Ok(())
}

/// Measures once more in a process of its own: everything, or what further arguments say.
fn run_process(process: u32, more: &[&OsStr]) -> Result<(), Failure> {
    let this = std::env::current_exe().map_err(Failure::bad_input)?;
    let mut child = Command::new(this)
        .args(std::env::args_os().skip(1))
        .arg(format!("--process={process}"))
        .args(more)
        .stdin(Stdio::piped())
        .spawn()
        .map_err(Failure::bad_input)?;
    // Held until the child has ended, see `lines_of_first_process`; waiting would close it.
    let pipe = child.stdin.take();
    let status = child.wait().map_err(Failure::bad_input)?;
    drop(pipe);
    if status.success() {
        return Ok(());
    }
    let message = format!("process {process} of the run: {status}");
    Err(match status.code() {
        Some(5) => Failure::no_device(message),
        _ => Failure::bad_input(message),
    })
}

/// What the process that started this one says. Ends this process when that one is killed: it would
/// write on beside the run that is resumed there.
fn lines_of_first_process() -> Receiver<String> {
    let (say, lines) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        // The pipe ends when its other end is closed.
        for line in std::io::stdin().lines().map_while(Result::ok) {
            drop(say.send(line));
        }
        // Not by `std::process::exit`: a driver's own clean-up at exit fails while another thread draws.
        signal_hook::low_level::exit(Outcome::Inconclusive as i32);
    });
    lines
}

/// Turns that come as lines on standard input; `terrafill_gate` has the other end.
struct Stepped(Receiver<String>);

impl Turns for Stepped {
    fn ready(&mut self, cases: &[String]) -> Result<(), String> {
        say(&format!("ready\t{}", cases.join("\t")))
    }

    fn next(&mut self) -> Result<Turn, String> {
        let line = self.0.recv().map_err(|error| error.to_string())?;
        let words: Vec<&str> = line.split(' ').collect();
        let turn = match words[..] {
            ["block"] => Some(Turn::Block),
            ["next"] => Some(Turn::NextGroup),
            [word @ ("sample" | "warm"), place, of] => {
                let counts = word == "sample";
                let numbers = place.parse().ok().zip(of.parse().ok());
                numbers.map(|(place, of)| Turn::Sample { place, of, counts })
            }
            _ => None,
        };
        turn.ok_or_else(|| {
            format!("found {line:?}, allowed: sample PLACE OF, warm PLACE OF, block, next")
        })
    }

    fn over(&mut self, is_well: bool) -> Result<(), String> {
        say(if is_well { "over" } else { "broken" })
    }
}

fn say(line: &str) -> Result<(), String> {
    print(format!("{line}\n")).map_err(|failure| failure.message)
}

fn failure(error: StudyError) -> Failure {
    match error {
        StudyError::NoDevice(_) | StudyError::Broken { .. } => Failure::no_device(error),
        _ => Failure::bad_input(error),
    }
}

/// What a run that broke off leaves, for whoever started it: further processes leave the word to the first.
fn keeps_what_was_measured(failure: Failure, arguments: &BenchArguments) -> Failure {
    let Failure { outcome, message } = failure;
    let message = match arguments.process {
        0 => format!("{message}\n{}", what_is_kept(&arguments.out)),
        _ => message,
    };
    Failure { outcome, message }
}

pub(crate) fn growth_sample(arguments: &GrowthSampleArguments) -> Result<Outcome, Failure> {
    let sample = terrafill_growth::growth_sample(&arguments.file);
    print(sample.map_err(Failure::bad_input)?)?;
    Ok(Outcome::Done)
}

pub(crate) fn report(arguments: &ReportArguments) -> Result<Outcome, Failure> {
    let write = if arguments.single_file {
        terrafill_report::write_single_file
    } else {
        terrafill_report::write
    };
    keep(&arguments.budget, &arguments.run)?;
    let written = write(&arguments.run, &chapters(), terms());
    print_report(written, "", arguments.open)
}

/// Puts limits that are given into the folder of a run: reports answer by them.
fn keep(given: &BudgetArguments, folder: &Path) -> Result<(), Failure> {
    // Not beside what is no run.
    RunFolder::open(folder).map_err(Failure::bad_input)?;
    let was = Budget::read(folder).map_err(Failure::bad_input)?;
    let budget = given.over(was);
    budget.map_or(Ok(()), |budget| {
        budget.write(folder).map_err(Failure::bad_input)
    })
}

pub(crate) fn merge(arguments: &MergeArguments) -> Result<Outcome, Failure> {
    if arguments.runs.iter().any(|folder| is_gate(folder)) {
        let report = terrafill_gate::merge_gates(&arguments.runs)?;
        return finish(&report, &arguments.out);
    }
    terrafill_results::merge(&arguments.runs, &arguments.out, metrics())
        .map_err(Failure::bad_input)?;
    let report = terrafill_report::write(&arguments.out, &chapters(), terms());
    print_report(report, "", false)
}

/// Whether a folder is one of `gate`, ended or not.
fn is_gate(folder: &Path) -> bool {
    ["gate.json", "base", "new"]
        .iter()
        .any(|name| folder.join(name).exists())
}
