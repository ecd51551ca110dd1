// SPDX-License-Identifier: MIT OR Apache-2.0
//! Both programs at work: each has a run folder, which the measurements of all its processes come to.
//!
//! The first process of a side verifies every picture against the reference. Each further one draws the
//! pictures of its cases once more, makes sure by their hashes that they are the verified ones, and times
//! them. So correctness costs a program one process, and no time is ever taken of a wrong picture.
//!
//! A timing process has a folder of its own, see [`Desk`]: what it reads and where its files lie is the same for
//! both sides and whatever was measured before. When all appended to the folder of their side, the base's had
//! twice as many rows, as base and null are two processes. Each process read them at its start, and the new
//! program's were 2.3 % faster in the first group of cases, of the same work.
//!
//! Timing processes go in lock-step where both programs can, see `lockstep`, and else one after another.

use crate::cores::Cores;
use crate::error::says_machine_failed;
use crate::hold::{Hold, PROCESS, VERIFY};
use crate::lockstep::{Ended, Stepped, step};
use crate::{GateError, GatedTime, Program, Side, Sides, Span, Times, TimingOrder, Trio, Watched};
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::io::{self, BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use terrafill_results::{Case, Clock, Outcome, Run, Samples, VerifiedRun};

/// The times that a study's cases are compared by; none for a study that times nothing.
pub type GatedTimes<'a> = &'a dyn Fn(&str, Clock) -> Vec<GatedTime>;

/// What both programs measure, and how often.
#[derive(Debug, Clone, Default)]
pub struct Workload {
    /// Arguments of `bench`: scenes, studies, techniques, size …
    pub arguments: Vec<OsString>,
    /// Timed samples of a case in each process that runs by itself; 1 where no time is compared.
    pub samples: u32,
    /// Frames that a sample is the mean of.
    pub frames: u32,
    /// Frames whose cost is added to each sample of a side: base, new. For the self-test.
    pub extra: [u32; 2],
}

/// The folder of one timing process, gone with it: a copy of its program, and the run as it was verified.
///
/// Processes of one file share the pages of its text, and which pages of memory these are decides by percents
/// how fast they run. Were base and its null one file and new another, the two of one file would win. Names are of
/// one length, since the length of a process's arguments moves its stack.
struct Desk(PathBuf);

impl Desk {
    /// - `start`: of its name
    fn of(start: &str, process: u32, out: &Path) -> Self {
        Self(out.join(format!("{start}{process:05}")))
    }

    fn program(&self) -> PathBuf {
        self.0.join("terrafill")
    }

    fn cases(&self) -> PathBuf {
        self.0.join("cases.txt")
    }

    fn run(&self) -> PathBuf {
        self.0.join("run")
    }

    fn lay_out(
        &self,
        program: &Path,
        verified: &VerifiedRun,
        cases: &BTreeSet<String>,
    ) -> Result<(), GateError> {
        verified.write_part(&self.run())?;
        self.take_program(program)?;
        let list = self.cases();
        let text: Vec<&str> = cases.iter().map(String::as_str).collect();
        std::fs::write(&list, text.join("\n")).map_err(GateError::io(&list))
    }

    fn take_program(&self, program: &Path) -> Result<(), GateError> {
        std::fs::create_dir_all(&self.0).map_err(GateError::io(&self.0))?;
        let copy = self.program();
        std::fs::copy(program, &copy).map_err(GateError::io(&copy))?;
        Ok(())
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        // One that stays takes room and changes no verdict.
        drop(std::fs::remove_dir_all(&self.0));
    }
}

/// Two programs and their run folders.
pub struct Job<'a> {
    programs: [Program; 2],
    workload: Workload,
    out: PathBuf,
    say: &'a mut dyn FnMut(&str),
    started: Instant,
    way: TimingOrder,
    _hold: Hold,
    /// Where timing processes run; empty: anywhere.
    cores: Cores,
    /// Runs of base and new as they were verified.
    verified: [Option<VerifiedRun>; 2],
    /// What verifying processes of base and new measured, in order.
    setups: [Vec<Run>; 2],
    /// Runs with all that was measured so far; `None` since a process has added to them.
    measured: Option<[Run; 2]>,
}

impl<'a> Job<'a> {
    /// - `out`: folder of both run folders: new, empty, or of a gate that was killed, whose work is taken away
    /// - `say`: hears what comes next
    ///
    /// # Errors
    /// [`GateError::BadInput`] where the folder holds something; [`GateError::Io`].
    pub fn new(
        programs: [Program; 2],
        workload: Workload,
        out: &Path,
        say: &'a mut dyn FnMut(&str),
    ) -> Result<Self, GateError> {
        let hold = Hold::take(out, say)?;
        let way = match programs.iter().find(|program| !program.knows("--stepped")) {
            Some(program) => TimingOrder::Turns {
                why: format!("{} was built before lock-step", program.label()),
            },
            None => TimingOrder::LockStep,
        };
        Ok(Self {
            _hold: hold,
            cores: Cores::default(),
            verified: [None, None],
            setups: [Vec::new(), Vec::new()],
            measured: None,
            way,
            programs,
            workload,
            out: out.to_owned(),
            say,
            started: Instant::now(),
        })
    }

    /// Folder of a side's run.
    #[must_use]
    pub fn folder(&self, side: Side) -> PathBuf {
        self.out.join(side.name())
    }

    /// The gate's folder.
    pub(crate) fn out(&self) -> &Path {
        &self.out
    }

    /// A side's run as it is now.
    ///
    /// # Errors
    /// [`GateError::Run`].
    pub fn load(&self, side: Side) -> Result<Run, GateError> {
        Ok(Run::load(&self.folder(side))?)
    }

    fn program(&self, side: Side) -> &Program {
        &self.programs[side.index()]
    }

    /// - `out`: folder of the process's run
    fn with_options(&self, mut command: Command, side: Side, out: &Path) -> Command {
        command.arg("bench").args(&self.workload.arguments);
        command.args(["--processes", "1", "--samples"]);
        // In lock-step the gate counts the samples.
        let samples = match self.way {
            TimingOrder::LockStep => 1,
            TimingOrder::Turns { .. } => self.workload.samples,
        };
        command.arg(samples.to_string());
        if self.workload.frames > 1 {
            let extra = self.workload.extra[side.index()];
            command.arg("--frames-per-sample");
            command.arg(self.workload.frames.to_string());
            command.arg("--extra-frames").arg(format!("{extra:03}"));
        }
        command.arg("--out").arg(out);
        command
    }

    /// Verifies every picture of a side, and counts its work.
    ///
    /// # Errors
    /// [`GateError::BadInput`] for arguments that the program refuses, [`GateError::NoDevice`],
    /// [`GateError::NothingMeasured`]. A wrong picture is no error: the run says so.
    pub fn verify(&mut self, side: Side) -> Result<Run, GateError> {
        let what = format!("{}: every picture against the reference", side.name());
        (self.say)(&what);
        let folder = self.folder(side);
        let run = self.verify_in(side, &self.program(side).path.clone(), &folder)?;
        self.verified[side.index()] = Some(VerifiedRun::read(&folder)?);
        // A GPU's clock does not count what the CPU does.
        if self.workload.samples > 1 && run.clock() == Clock::ProcessCpu {
            self.cores = Cores::of_this_process();
        }
        self.setups[side.index()] = vec![run.clone()];
        Ok(run)
    }

    fn verify_in(&mut self, side: Side, program: &Path, folder: &Path) -> Result<Run, GateError> {
        let command = self.with_options(Command::new(program), side, folder);
        let ended = self.run_to_end(side, command)?;
        match ended.status.code() {
            // A wrong picture or a missing case: the tables have it.
            Some(0 | 1 | 3) => Ok(Run::load(folder)?),
            _ => Err(self.refused(side, &ended)),
        }
    }

    /// Runs a program and passes on what it says, so that a long step is no silence.
    fn run_to_end(&mut self, side: Side, mut command: Command) -> Result<Ended, GateError> {
        let child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn();
        let mut child = child.map_err(|error| self.failed(side, error.to_string()))?;
        // Held until the process has ended: it ends itself when the pipe is closed, as by a kill.
        let pipe = child.stdin.take();
        let lines = child.stderr.take().map(|said| BufReader::new(said).lines());
        let mut said = Vec::new();
        for line in lines.into_iter().flatten().map_while(Result::ok) {
            (self.say)(&line);
            said.push(line);
        }
        let status = child.wait();
        drop(pipe);
        let status = status.map_err(|error| self.failed(side, error.to_string()))?;
        Ok(Ended { status, said })
    }

    fn failed(&self, side: Side, message: String) -> GateError {
        GateError::Program {
            what: format!("{} program {}", side.name(), self.program(side).label()),
            message,
        }
    }

    fn refused(&self, side: Side, ended: &Ended) -> GateError {
        let is_unknown = |line: &String| line.contains("--time-only");
        if ended.said.iter().any(is_unknown) {
            let message =
                "built before the gate: it cannot be timed by it; --no-time compares the rest";
            return self.failed(side, message.to_owned());
        }
        // The last lines say why; a progress line or two stand before them.
        let last = &ended.said[ended.said.len().saturating_sub(4)..];
        // What is indented goes on with the line above it.
        let last = last.join("; ").replace(";     ", " ");
        let message = format!("{}: {last}", ended.status);
        // Who kills without a word is the system, when it is short of memory.
        if ended.said.iter().any(|line| says_machine_failed(line)) || was_killed(ended.status) {
            return self.failed(side, message).of_machine();
        }
        match ended.status.code() {
            Some(4) => GateError::NothingMeasured(format!("{}: {message}", side.name())),
            Some(5) => GateError::NoDevice(format!("{}: {message}", side.name())),
            _ => self.failed(side, message),
        }
    }
}

impl Job<'_> {
    /// A process of a side that times these cases alone.
    ///
    /// - `block`: number of its block, all of whose processes run on one core
    ///
    /// Its folder has to live until it has ended.
    fn timing(
        &self,
        side: Side,
        process: u32,
        block: u32,
        cases: &BTreeSet<String>,
    ) -> Result<(Desk, Command), GateError> {
        let desk = Desk::of(PROCESS, process, &self.out);
        desk.lay_out(&self.program(side).path, self.verified(side)?, cases)?;
        let command = self.cores.command(&desk.program(), block);
        let mut command = self.with_options(command, side, &desk.run());
        command.arg(format!("--process={process:05}"));
        command.arg("--time-only").arg(desk.cases());
        Ok((desk, command))
    }

    fn verified(&self, side: Side) -> Result<&VerifiedRun, GateError> {
        let verified = self.verified[side.index()].as_ref();
        verified.ok_or_else(|| self.failed(side, "timed before it was verified".to_owned()))
    }

    /// Why a process in lock-step failed: as it says itself, or as its pipe did.
    fn broke_off(&self, side: Side, process: Stepped, error: &io::Error) -> GateError {
        match process.end() {
            Ok(ended) if !ended.said.is_empty() => self.refused(side, &ended),
            _ => self.failed(side, format!("in lock-step: {error}")),
        }
    }
}

impl Sides for Job<'_> {
    fn way(&self) -> &TimingOrder {
        &self.way
    }

    fn is_on_one_core(&self) -> bool {
        !self.cores.is_empty()
    }

    fn run_together(&mut self, trio: Trio, cases: &BTreeSet<String>) -> Result<(), GateError> {
        let sides = trio.processes();
        let mut desks = Vec::with_capacity(sides.len());
        let mut start = |(side, process): (Side, u32)| -> Result<Stepped, GateError> {
            let (desk, mut command) = self.timing(side, process, trio.block(), cases)?;
            desks.push((side, desk));
            command.arg("--stepped");
            Stepped::start(command).map_err(|error| self.failed(side, error.to_string()))
        };
        let mut started = [None, None, None];
        for place in trio.start_order() {
            started[place] = Some(start(sides[place])?);
        }
        let [Some(base), Some(null), Some(new)] = started else {
            return Err(self.failed(Side::Base, "a process was not started".to_owned()));
        };
        let mut processes = [base, null, new];
        let seed = u64::from(trio.base);
        let stepped = step(&mut processes, self.workload.frames.max(1), seed);
        let failed = stepped.err();
        for (index, (process, (side, _))) in processes.into_iter().zip(sides).enumerate() {
            match &failed {
                Some((of, error)) if *of == index => {
                    return Err(self.broke_off(side, process, error));
                }
                Some(_) => {}
                None => {
                    let ended = process.end();
                    let ended = ended.map_err(|error| self.failed(side, error.to_string()))?;
                    if !ended.status.success() {
                        return Err(self.refused(side, &ended));
                    }
                }
            }
        }
        self.measured = None;
        for (side, desk) in desks {
            self.verified(side)?.add_part(&desk.run())?;
        }
        Ok(())
    }

    fn run(&mut self, side: Side, process: u32, cases: &BTreeSet<String>) -> Result<(), GateError> {
        let (desk, command) = self.timing(side, process, (process - 1) / 4, cases)?;
        let ended = self.run_to_end(side, command)?;
        self.measured = None;
        if ended.status.success() {
            Ok(self.verified(side)?.add_part(&desk.run())?)
        } else {
            Err(self.refused(side, &ended))
        }
    }

    fn times(&mut self, side: Side, metric: &str) -> Result<Times, GateError> {
        let runs = match self.measured.take() {
            Some(runs) => runs,
            None => [self.load(Side::Base)?, self.load(Side::New)?],
        };
        let times = of_metric(&runs[side.index()], metric);
        self.measured = Some(runs);
        Ok(times)
    }

    fn verify_again(&mut self, number: u32) -> Result<(), GateError> {
        let mut order = [Side::Base, Side::New];
        if number.is_multiple_of(2) {
            order.reverse();
        }
        for side in order {
            let desk = Desk::of(VERIFY, number, &self.out);
            desk.take_program(&self.program(side).path)?;
            let run = self.verify_in(side, &desk.program(), &desk.run())?;
            self.setups[side.index()].push(run);
        }
        Ok(())
    }

    fn setups(&self, side: Side, metric: &str) -> Times {
        let mut all = Times::new();
        for (number, run) in (0..).zip(&self.setups[side.index()]) {
            // Figures of the probe have number 0; timed samples count from 1.
            for (case, samples) in of_metric(run, metric) {
                let of_probe = samples.get(&0).and_then(|of| of.get(&0));
                let of_probe = of_probe.map(|value| (0, *value)).into_iter().collect();
                all.entry(case).or_default().insert(number, of_probe);
            }
        }
        all
    }

    fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    fn say(&mut self, what: &str) {
        (self.say)(what);
    }
}

/// Whether a signal ended a process that it could not answer.
fn was_killed(status: ExitStatus) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::process::ExitStatusExt as _;
        status.signal() == Some(9)
    }
    #[cfg(not(unix))]
    {
        let _ = status;
        false
    }
}

/// Values of a metric by case; a case that failed since it was verified has no time that counts.
fn of_metric(run: &Run, metric: &str) -> Times {
    let counts = |case: &&Case| matches!(case.outcome, Outcome::Ok | Outcome::Wrong);
    let timed = run
        .cases
        .iter()
        .filter(|case| !case.is_repeat())
        .filter(counts);
    let of_processes = |samples: &Samples| {
        let processes = samples.iter();
        processes
            .map(|(process, of)| (*process, of.iter().map(|(at, ms)| (*at, *ms)).collect()))
            .collect()
    };
    timed
        .filter_map(|case| Some((case.id().key(), of_processes(case.samples(metric)?))))
        .collect()
}

/// Times that are compared: those of each frame, then those that a process takes once. They are of cases that are
/// right on both sides, planned with samples, and of a study that times them.
///
/// A frame that has no time all the same is among them, so that it is missed; so is another time that one run has.
/// Of what neither run measures there is nothing to compare.
#[must_use]
pub fn watched(base: &Run, new: &Run, gated: GatedTimes<'_>) -> [Vec<Watched>; 2] {
    let clock = new.clock();
    let is_right = |case: &&Case| !case.is_repeat() && case.outcome == Outcome::Ok;
    let by_key = |run: &'_ Run| -> BTreeMap<String, usize> {
        let cases = run
            .cases
            .iter()
            .enumerate()
            .filter(|(_, case)| is_right(case));
        cases
            .map(|(index, case)| (case.id().key(), index))
            .collect()
    };
    let of_new = by_key(new);
    let mut found: [BTreeMap<(Span, &str), BTreeSet<String>>; 2] = Default::default();
    for (key, index) in by_key(base) {
        let Some(other) = of_new.get(&key) else {
            continue;
        };
        let cases = [&base.cases[index], &new.cases[*other]];
        if cases.iter().all(|case| case.planned.samples == 0) {
            continue;
        }
        for GatedTime { metric, span } in gated(&cases[0].id().study, clock) {
            let samples = || cases.iter().filter_map(|case| case.samples(metric));
            let is_setup = samples().any(|of| of.values().any(|of| of.get(&0).is_some()));
            if span == Span::Frame || samples().next().is_some() {
                let of = found[usize::from(is_setup)]
                    .entry((span, metric))
                    .or_default();
                of.insert(key.clone());
            }
        }
    }
    found.map(|found| {
        let found = found.into_iter();
        found
            .map(|((span, metric), cases)| Watched {
                metric: metric.to_owned(),
                span,
                cases,
            })
            .collect()
    })
}

/// Conditions of every case, by key.
pub(crate) fn conditions(run: &Run) -> BTreeMap<String, BTreeMap<String, String>> {
    let cases = run.cases.iter();
    cases
        .map(|case| (case.id().key(), case.id().conditions.clone()))
        .collect()
}
